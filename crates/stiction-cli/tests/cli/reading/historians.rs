//! The base loop as twelve historians and two spreadsheets export it, each with the vices of its kind. All but one must
//! be read unaided, and that one by following its message once.

use super::{Case, N, Right, at, case, clock, comma, folder, lines};

/// A few samples fewer.
fn nearly(right: &mut Right) {
    right.judged = (N - 70, N + 2);
}

/// Text in Windows-1252.
fn windows_1252(text: &str) -> Vec<u8> {
    text.chars().map(|c| u8::try_from(u32::from(c)).expect("a letter of Latin 1")).collect()
}

fn crlf(text: &str) -> String {
    text.replace('\n', "\r\n")
}

/// Two samples in a thousand.
fn rare(k: usize) -> bool {
    k % 500 == 123
}

fn files() -> Vec<Case> {
    let plain = |k: usize, pattern: &str| clock(pattern, k as f64);
    let commas = |k| {
        let [pv, sp, op] = at(k);
        [comma(pv, 3), comma(sp, 1), comma(op, 3)]
    };
    let pi_wide = lines("PI DataLink,,,\n,FIC101.PV,FIC101.SP,FIC101.OP\n", |k| {
        let [pv, sp, op] = at(k);
        let pv = match k {
            _ if rare(k) => "I/O Timeout".to_owned(),
            777 => "Bad".to_owned(),
            0 => "Pt Created".to_owned(),
            _ => pv.to_string(),
        };
        format!("{},{pv},{sp},{op}\n", plain(k, "%d-%b-%y %H:%M:%S"))
    });
    let pi_long = lines("Tag,Timestamp,Value,Status\n", |k| {
        let (mut text, time) = (String::new(), plain(k, "%Y-%m-%dT%H:%M:%S.0000000Z"));
        for (tag, value) in ["PV", "SP", "OP"].iter().zip(at(k)) {
            if *tag == "SP" && k % 60 != 0 {
                continue;
            }
            let (value, status) = match rare(k) && *tag == "PV" {
                true => ("No Data".to_owned(), "Bad"),
                false => (value.to_string(), "Good"),
            };
            text += &format!("FIC101.{tag},{time},{value},{status}\n");
        }
        text
    });
    let phd = lines(
        "Honeywell Uniformance PHD,Excel Companion,,,\nStart Time,\
            14/03/2025 06:00:00,,,\nSample Interval,1s,,,\n,,,,\nTime,\
            FC2103.DACA.PV,Conf,FC2103.PIDA.OP,Conf,FC2103.PIDA.SP,Conf,\
            FC2103.PIDA.MODE\n",
        |k| {
            let ([pv, sp, op], time) = (at(k), plain(k, "%d/%m/%Y %H:%M:%S"));
            let (pv, conf) = if rare(k) { (-9999.0, 0) } else { (pv, 100) };
            format!("{time},{pv:.3},{conf},{op:.3},100,{sp:.1},100,AUTO\n")
        },
    );
    let noon = jiff::civil::date(2025, 3, 14).at(11, 50, 0, 0);
    let deltav = lines(
        "\"Date/Time\",\"FIC-2104/PID1/PV.CV\",\"FIC-2104/PID1/SP.CV\",\
            \"FIC-2104/PID1/OUT.CV\",\"FIC-2104/PID1/MODE.ACTUAL\"\n",
        |k| {
            let [pv, sp, op] = at(k);
            let time = super::clock_from(noon, "%m/%d/%Y %I:%M:%S %p", k as f64);
            format!("\"{time}\",\"{pv:.4}\",\"{sp:.1}\",\"{op:.4}\",\"16\"\n")
        },
    );
    let wonderware =
        lines("DateTime,TagName,Value,vValue,Quality,QualityDetail,OPCQuality\n", |k| {
            let tags = ["PV", "SP", "OUT"].iter().zip(at(k));
            let time = plain(k, "%Y-%m-%d %H:%M:%S.000");
            let row = |(tag, value): (&&str, f64)| match rare(k) && *tag == "PV" {
                true => format!("{time},FIC2105_{tag},(null),(null),1,24,0\n"),
                false => format!("{time},FIC2105_{tag},{value:.3},{value:.3},0,192,192\n"),
            };
            tags.map(row).collect()
        });
    let seeq = lines(
        "\u{feff}Date-Time,\"Area A: FIC2106 Flow PV (m3/h)\",\
            \"Area A: FIC2106 Flow SP (m3/h)\",\
            \"Area A: FIC2106 Valve Output (%)\"\n",
        |k| {
            let [pv, sp, op] = at(k);
            let pv = if rare(k) { String::new() } else { format!("{pv:.5}") };
            format!("{},{pv},{sp:.5},{op:.5}\n", plain(k, "%Y-%m-%dT%H:%M:%S.000+01:00"))
        },
    );
    let wincc = lines("\"VarName\";\"TimeString\";\"VarValue\";\"Validity\";\"Time_ms\"\n", |k| {
        let tags = ["PV_IN", "SP", "LMN"].iter().zip(at(k));
        let days = comma(45_730_250_000.0 + k as f64 * 1e6 / 86_400.0, 6);
        let time = plain(k, "%d.%m.%Y %H:%M:%S");
        let row = |(tag, value): (&&str, f64)| {
            format!("\"FIC2112/PID.{tag}#Value\";\"{time}\";{};1;{days}\n", comma(value, 3))
        };
        tags.map(row).collect()
    }) + "\"$RT_COUNT$\";3600;\"\";\"\";\"\"\n";
    let ignition = lines("t_stamp,North/FIC101/PV,North/FIC101/SP,North/FIC101/CV\n", |k| {
        let [pv, sp, op] = at(k);
        format!("{},{pv},{sp},{op}\n", 1_741_932_000_000_i64 + 1000 * k as i64)
    });
    let ignition_long = lines("tagid,intvalue,floatvalue,dataintegrity,t_stamp\n", |k| {
        let tags = [11, 12, 13].iter().zip(at(k));
        let time = 1_741_932_000_000_i64 + 1000 * k as i64;
        let row = |(tag, value): (&i32, f64)| format!("{tag},,{value},192,{time}\n");
        tags.map(row).collect()
    });
    let german = lines(
        "Zeitpunkt;Durchfluss Istwert [m³/h];Durchfluss Sollwert [m³/h];\
            Stellgröße [%];Betriebsart\n",
        |k| {
            let ([pv, sp, op], time) = (commas(k), plain(k, "%d.%m.%Y %H:%M:%S"));
            format!("{time};{pv};{sp};{op};Automatik\n")
        },
    );
    let french = lines("Horodatage;Mesure (m³/h);Consigne (m³/h);Sortie (%);Mode\n", |k| {
        let ([pv, sp, op], time) = (commas(k), plain(k, "%d/%m/%Y %H:%M:%S"));
        format!("{time};{pv};{sp};{op};Automatique\n")
    });
    let abb = lines("Time;FIC2110:PV;FIC2110:SP;FIC2110:Out;FIC2110:Mode\n", |k| {
        let ([pv, sp, op], time) = (at(k), plain(k, "%Y-%m-%d %H:%M:%S,000"));
        let (pv, op) = (comma(pv, 2), comma(op, 2));
        // A row is torn, and the set point is written once a minute.
        match k {
            431 => format!("{time};{pv}\n"),
            _ if k % 60 == 0 => format!("{time};{pv};{};{op};Auto\n", comma(sp, 1)),
            _ => format!("{time};{pv};;{op};Auto\n"),
        }
    });
    let yokogawa = lines(
        "Exaquantum/Explorer\nDate,Time,FIC2111.PV,FIC2111.SV,FIC2111.MV,\
            FIC2111.MODE\n,,M3/H,M3/H,%,\n",
        |k| {
            let [pv, sp, op] = at(k);
            let pv = if rare(k) { "-------".to_owned() } else { format!("{pv:.2}") };
            format!("{},{pv},{sp:.1},{op:.2},AUT\n", plain(k, "%Y/%m/%d,%H:%M:%S"))
        },
    );
    let aspen = lines("NAME,IP_TREND_TIME,IP_TREND_VALUE,IP_TREND_QSTATUS\n", |k| {
        let tags = ["FIC2113.PV", "FIC2113.SP", "FIC2113.OP"].iter().zip(at(k));
        let row = |(tag, value): (&&str, f64)| {
            let (value, status) = match rare(k) && tag.ends_with("PV") {
                true => ("0.000".to_owned(), "Bad"),
                false => (format!("{value:.3}"), "Good"),
            };
            format!("{tag},{},{value},{status}\n", plain(k, "%d-%b-%y %H:%M:%S.0"))
        };
        tags.map(row).collect()
    });
    let german_bytes = windows_1252(&crlf(&german));
    let french_bytes = windows_1252(&crlf(&french));
    vec![
        case("PI DataLink", "pi-wide.csv", crlf(&pi_wide)).right(nearly),
        case("PI, long", "pi-long.csv", pi_long),
        case("Honeywell PHD", "phd.csv", crlf(&phd)).right(nearly),
        case("DeltaV", "deltav.csv", deltav).or_refused(&["16"], &[]),
        case("Wonderware", "wonderware.csv", wonderware).right(nearly),
        case("Seeq", "seeq.csv", seeq).right(nearly),
        case("WinCC", "wincc.csv", wincc),
        case("Ignition", "ignition.csv", ignition),
        // Numbers of tags name no signal, so the user must.
        Case {
            options: &["--map", "pv=11", "--map", "sp=12"],
            ..case("Ignition, long", "ignition-long.csv", ignition_long)
        }
        .or_refused(&[], &["op=13"]),
        case("Excel, German", "excel-de.csv", german_bytes),
        case("Excel, French", "excel-fr.csv", french_bytes)
            .or_refused(&[], &["--time-format=day-first"]),
        case("ABB 800xA", "abb.csv", abb).right(nearly),
        case("Yokogawa", "yokogawa.csv", yokogawa).right(nearly).or_refused(&["-------"], &[]),
        case("Aspen IP.21", "aspen.csv", aspen).right(nearly),
    ]
}

#[test]
fn twelve_historians_and_two_spreadsheets() {
    let folder = folder("reading-historians");
    let files = files();
    let (mut unaided, mut by_advice, mut wrong) = (0, vec![], vec![]);
    for case in &files {
        let strict = Case { may_refuse: false, ..case.clone() };
        match (strict.fault(&folder), case.fault(&folder)) {
            (None, _) => unaided += 1,
            (Some(_), None) => by_advice.push(case.name),
            (_, Some(fault)) => wrong.push(fault),
        }
    }
    let all = files.len();
    let found = format!("{unaided} of {all} unaided, by advice {by_advice:?}");
    println!("historians: {found}");
    assert!(wrong.is_empty(), "historians: {found}; {} wrong\n{}\n", wrong.len(), wrong.join("\n"));
    // Of the twelve systems one may need its advice. The second files of PI and Ignition do not count.
    let aided = by_advice.iter().filter(|name| !name.contains("long")).count();
    assert!(aided <= 1, "historians: {found}");
}
