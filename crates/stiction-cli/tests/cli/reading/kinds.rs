//! Further files of each kind, made from the base loop. Whatever its dress, the loop sticks with S = 4 %.

use super::in_process::judged;
use super::{Case, FIXTURES, N, Right, at, clock, clock_from, comma, examine, grouped, lines};
use stiction::diagnose::Grade;

const ISO: &str = "%Y-%m-%d %H:%M:%S";
const GERMAN: &str = "%d.%m.%Y %H:%M:%S";

/// A case of one file of CSV.
fn case(name: &'static str, bytes: impl Into<Vec<u8>>) -> Case {
    super::case(name, "a.csv", bytes)
}

/// The lines above, then one or more lines of every sample with its PV, SP and OP.
fn samples(above: &str, mut line: impl FnMut(usize, [f64; 3]) -> String) -> String {
    lines(above, |k| line(k, at(k)))
}

/// A table of dates, PV, SP and OP below its header.
fn below(head: &str) -> String {
    samples(head, |k, [pv, sp, op]| format!("{},{pv},{sp},{op}\n", clock(ISO, k as f64)))
}

/// A plain table whose numbers `change` replaces: sample and PV, SP, OP.
fn plain(change: impl Fn(usize, [f64; 3]) -> [f64; 3]) -> String {
    lines("Time,FIC1.PV,FIC1.SP,FIC1.OP\n", |k| {
        let [pv, sp, op] = change(k, at(k));
        format!("{},{pv},{sp},{op}\n", clock(ISO, k as f64))
    })
}

/// Fewer judged samples, because a part of the recording cannot be used.
fn part(right: &mut Right) {
    right.judged = (500, N);
    right.probability = (0.8, 1.0);
    right.s = Some((3.0, 4.8));
    right.grades = &["sticks", "probably sticks"];
}

/// All but a few samples at the ends, or at a gap.
fn nearly(right: &mut Right) {
    right.judged = (N - 70, N + 2);
}

const MASKED: &[&str] = &["mask", "no measurement", "sentinel", "placeholder"];

#[test]
fn sentinels() {
    let flat = |k: usize, [pv, sp, op]: [f64; 3]| match k {
        1100.. => [0.0, sp, 0.0],
        _ => [pv, sp, op],
    };
    let cases = vec![
        case(
            "one -9999 in the PV",
            plain(|k, [pv, sp, op]| [if k == 600 { -9999.0 } else { pv }, sp, op]),
        )
        .said(MASKED),
        case(
            "five 32767 in the OP",
            plain(|k, [pv, sp, op]| [pv, sp, if k % 240 == 7 { 32767.0 } else { op }]),
        )
        .said(MASKED),
        case(
            "1e31 in the SP and -999.25 in the PV",
            plain(|k, [pv, sp, op]| {
                [if k % 300 == 9 { -999.25 } else { pv }, if k % 500 == 3 { 1e31 } else { sp }, op]
            }),
        )
        .said(MASKED),
        case(
            "twenty 327.67 in a row in the PV",
            plain(|k, [pv, sp, op]| [if (700..720).contains(&k) { 327.67 } else { pv }, sp, op]),
        )
        .said(MASKED)
        .right(part),
        case("zeros after a shutdown", plain(flat)).right(part).said(&[
            "mask",
            "no measurement",
            "flat",
            "shut",
            "frozen",
            "does not change",
            "rests at",
        ]),
        case(
            "one -9999 in each of PV and OP",
            plain(|k, [pv, sp, op]| {
                [if k == 300 { -9999.0 } else { pv }, sp, if k == 900 { -9999.0 } else { op }]
            }),
        )
        .said(MASKED),
    ];
    examine("sentinels", cases);
}

#[test]
fn clocks_that_restart() {
    const AGAIN: &[&str] = &[
        "restart",
        "again",
        "went back",
        "goes back",
        "fell back",
        "falls back",
        "runs",
        "jumps back",
        "overflow",
    ];
    let runs = |length: usize| {
        samples("t,pv,sp,op\n", |k, [pv, sp, op]| format!("{},{pv},{sp},{op}\n", k % length))
    };
    let overflow = samples("time (ms),pv,sp,op\n", |k, [pv, sp, op]| {
        format!("{},{pv},{sp},{op}\n", (k * 1000) % 65_536)
    });
    let autumn = jiff::civil::date(2024, 10, 27).at(2, 50, 0, 0);
    let summer_time = samples("Time,FIC1.PV,FIC1.SP,FIC1.OP\n", |k, [pv, sp, op]| {
        let seconds = if k < 600 { k as f64 } else { k as f64 - 3600.0 };
        format!("{},{pv},{sp},{op}\n", clock_from(autumn, ISO, seconds))
    });
    let run = |right: &mut Right| {
        part(right);
        right.judged = (600, N);
    };
    let cases = vec![
        case("two runs from zero", runs(600)).right(run).said(AGAIN),
        case("a first run that is longer", runs(800)).right(run).said(AGAIN),
        case("a counter of 16 bits", overflow)
            .right(|right| right.judged = (N - 20, N))
            .said(AGAIN),
        case("the end of summer time", summer_time).right(run).said(AGAIN),
    ];
    examine("restarts", cases);
}

/// The three tags beside each other, each with its own clock: SP once a minute, OP `late` seconds after the PV. Its column
/// begins `from` samples later.
fn beside(
    head: &str,
    between: &str,
    stamp: &dyn Fn(f64) -> String,
    late: f64,
    from: usize,
) -> String {
    let cells = |k: usize, every: usize, signal: usize, late: f64| match k * every {
        k if k < N => format!("{}{between}{}", stamp(k as f64 + late), at(k)[signal]),
        _ => between.to_owned(),
    };
    lines(head, |k| {
        let (pv, sp) = (cells(k, 1, 0, 0.0), cells(k, 60, 1, 0.0));
        format!("{pv}{between}{sp}{between}{}\n", cells(k + from, 1, 2, late))
    })
}

#[test]
fn a_clock_for_each_channel() {
    let seconds = |s: f64| s.to_string();
    let dated = |s: f64| clock(ISO, s);
    let cases = vec![
        case(
            "clocks named after their tags",
            beside(
                "FIC1.PV.Time;FIC1.PV.Value;FIC1.SP.Time;FIC1.SP.Value;FIC1.OP.Time;\
            FIC1.OP.Value\n",
                ";",
                &seconds,
                0.2,
                0,
            ),
        )
        .right(nearly),
        case(
            "clocks of one name",
            beside("Time,FIC1.PV,Time,FIC1.SP,Time,FIC1.OP\n", ",", &dated, 0.0, 0),
        )
        .right(nearly),
        case(
            "numbered clocks",
            beside("Time,FIC1.PV,Time 2,FIC1.SP,Time 3,FIC1.OP\n", ",", &dated, 0.0, 7),
        )
        .right(|right| right.judged = (N - 9, N)),
    ];
    examine("clocks", cases);
}

/// A row for each time of any tag; `none` in the other cells.
fn joined(head: &str, none: &str, stamp: &dyn Fn(f64) -> String, jitter: f64) -> String {
    samples(head, |k, [pv, sp, op]| {
        let shaken = |k: usize| jitter * (((k * 7919) % 41) as f64 / 20.0 - 1.0);
        let s = k as f64;
        let mut text = format!("{},{pv},{none},{none}\n", stamp(s + 0.05 + shaken(k)));
        text += &format!("{},{none},{none},{op}\n", stamp(s + 0.35 + shaken(k + 13)));
        if k % 60 == 0 {
            text += &format!("{},{none},{sp},{none}\n", stamp(s + 0.7));
        }
        text
    })
}

#[test]
fn empty_cells_that_mean_the_time_of_another_tag() {
    let dated = |s: f64| clock("%Y-%m-%d %H:%M:%S%.3f", s);
    let seconds = |s: f64| format!("{s:.3}");
    let steady = samples("Time,FIC1.PV,FIC1.SP,FIC1.OP\n", |k, [pv, sp, op]| {
        let s = k as f64;
        let sp = if k % 60 == 0 { sp.to_string() } else { String::new() };
        format!("{},{pv},{sp},{op}\n", clock(ISO, s))
    });
    let cases = vec![
        case("empty cells", joined("Time,FIC1.PV,FIC1.SP,FIC1.OP\n", "", &dated, 0.0))
            .right(nearly),
        case("#N/A", joined("Time,FIC1.PV,FIC1.SP,FIC1.OP\n", "#N/A", &dated, 0.0)).right(nearly),
        case("NaN, with jitter", joined("t,FIC1.PV,FIC1.SP,FIC1.OP\n", "NaN", &seconds, 0.04))
            .right(nearly),
        case("a set point once a minute", steady),
    ];
    examine("joined", cases);
}

#[test]
fn stored_on_change() {
    let tenth = |x: f64, step: f64| (x / step).round() * step;
    let wide = |step: f64| {
        let mut last = [f64::NAN; 3];
        lines("Time,FIC1.PV,FIC1.SP,FIC1.OP\n", |k| {
            let now = at(k).map(|x| tenth(x, step));
            let cells: Vec<String> = now
                .iter()
                .zip(&last)
                .map(|(now, last)| if now == last { String::new() } else { format!("{now:.2}") })
                .collect();
            last = now;
            format!("{},{}\n", clock(ISO, k as f64), cells.join(","))
        })
    };
    let long = |step: f64| {
        let mut last = [f64::NAN; 3];
        lines("TagName,Time,Value\n", |k| {
            let now = at(k).map(|x| tenth(x, step));
            let mut text = String::new();
            for (tag, (now, last)) in ["PV", "SP", "OP"].iter().zip(now.iter().zip(&last)) {
                if now != last {
                    text += &format!("FIC1.{tag},{},{now:.2}\n", clock(ISO, k as f64));
                }
            }
            last = now;
            text
        })
    };
    let by_exception = {
        let mut last = [f64::NAN; 3];
        lines("TagName,Time,Value\n", |k| {
            let mut text = String::new();
            for (index, tag) in ["PV", "SP", "OP"].iter().enumerate() {
                let now = at(k)[index];
                if !((now - last[index]).abs() <= 0.1) {
                    text += &format!("FIC1.{tag},{},{now:.2}\n", clock(ISO, k as f64));
                    last[index] = now;
                }
            }
            text
        })
    };
    let cases = vec![
        case("wide, steps of 0.1", wide(0.1)).right(nearly),
        case("long, steps of 0.05", long(0.05)).right(nearly),
        case("long, steps of 0.2", long(0.2)).right(|right| {
            nearly(right);
            right.s = Some((3.0, 5.0));
        }),
        case("long, changes of 0.1", by_exception).right(|right| {
            part(right);
            right.judged = (N - 70, N);
        }),
    ];
    examine("on-change", cases);
}

#[test]
fn thousands_and_decimals() {
    let of = |group: &'static str,
              mark: &'static str,
              digits: usize,
              between: &'static str,
              quote: &'static str| {
        let number =
            move |x: f64| format!("{quote}{}{quote}", grouped(20.0 * x, digits, group, mark));
        let op = move |x: f64| format!("{quote}{}{quote}", format!("{x:.2}").replace('.', mark));
        samples(
            &format!("Zeit{between}FIC1.PV{between}FIC1.SP{between}FIC1.OP\n"),
            |k, [pv, sp, out]| {
                format!(
                    "{}{between}{}{between}{}{between}{}\n",
                    clock(ISO, k as f64),
                    number(pv),
                    number(sp),
                    op(out)
                )
            },
        )
    };
    // The PV crosses 1000, in whole numbers.
    let across = |group: &'static str, between: &'static str, digits: usize| {
        samples(
            &format!("Time{between}FIC1.PV{between}FIC1.SP{between}FIC1.OP\n"),
            |k, [pv, sp, op]| {
                let quoted = |x: f64| format!("\"{}\"", grouped(1000.0 * x / 60.0, 0, group, "."));
                let (time, pv, sp) = (clock(ISO, k as f64), quoted(pv), quoted(sp));
                format!("{time}{between}{pv}{between}{sp}{between}{op:.digits$}\n")
            },
        )
    };
    let of_1200 = |right: &mut Right| right.pv = (1150.0, 1260.0);
    // The OP has few levels without decimals, so only the PV decides.
    let of_1000 = |right: &mut Right| {
        right.pv = (970.0, 1042.0);
        right.grades = &["sticks", "probably sticks", "unclear"];
        right.probability = (0.0, 1.0);
        right.s = None;
    };
    let cases = vec![
        case("English", of(",", ".", 1, ",", "\"")).right(of_1200),
        case("German", of(".", ",", 1, ";", "")).right(of_1200),
        case("a narrow space", of("\u{202f}", ",", 1, ";", "")).right(of_1200),
        case("an apostrophe", of("'", ".", 1, ";", "")).right(of_1200),
        case("across 1000, beside decimals", across(",", ",", 2)).right(of_1000),
        case("across 1000, a comma", across(",", ",", 0))
            .right(of_1000)
            .or_refused(&["1,001"], &[]),
        case("across 1000, an apostrophe", across("'", ";", 0)).right(of_1000),
    ];
    examine("marks", cases);
}

#[test]
fn units_and_ranges_of_the_op() {
    let named = |name: &str, low: f64, high: f64, digits: usize| {
        samples(&format!("Time,FIC1.PV,FIC1.SP,{name}\n"), |k, [pv, sp, op]| {
            format!(
                "{},{pv},{sp},{:.digits$}\n",
                clock(ISO, k as f64),
                low + (high - low) * op / 100.0
            )
        })
    };
    let guess = |right: &mut Right| {
        right.holds = Some(4.0);
        right.s = Some((0.0, 100.0));
    };
    let cases = vec![
        case("psi in brackets", named("FIC1.OP [psi]", 3.0, 15.0, 4))
            .or_refused(&["psi"], &["--op-range=3,15"]),
        case("bar", named("FIC1.OP (bar)", 0.2, 1.0, 5))
            .or_refused(&["bar"], &["--op-range=0.2,1"]),
        case("kPa", named("FIC1.OP (kPa)", 20.0, 100.0, 3))
            .or_refused(&["kPa"], &["--op-range=20,100"]),
        case("mA", named("FIC1.OP (mA)", 4.0, 20.0, 4)),
        case("V of 1 to 5", named("FIC1.OP (V)", 1.0, 5.0, 4))
            .right(guess)
            .or_refused(&["V"], &["--op-range=1,5"]),
        case("permille without a unit", named("FIC1.OP", 0.0, 1000.0, 1)).right(guess),
        case("counts of 12 bits", named("FIC1.OP", 0.0, 4095.0, 0)).right(guess),
        case("fractions", named("FIC1.OP", 0.0, 1.0, 4)),
    ];
    examine("ranges", cases);
}

/// A long table with a quality for each value.
fn with_quality(quality: impl Fn(usize, &str) -> &'static str) -> String {
    lines("Tag,Time,Value,Quality\n", |k| {
        let tags = ["PV", "SP", "OP"].iter().zip(at(k));
        tags.map(|(tag, value)| {
            format!("FIC1.{tag},{},{value},{}\n", clock(ISO, k as f64), quality(k, tag))
        })
        .collect()
    })
}

#[test]
fn words_of_quality() {
    let rare = |k: usize, tag: &str| tag == "PV" && k % 400 == 37;
    let cases = vec![
        case(
            "names of status codes",
            with_quality(|k, tag| if rare(k, tag) { "BadNoCommunication" } else { "Good" }),
        )
        .right(nearly),
        case(
            "words with codes",
            with_quality(
                |k, tag| if rare(k, tag) { "Bad (0x80000000)" } else { "Good (0x00000000)" },
            ),
        )
        .right(nearly),
        case(
            "StatusCode()",
            with_quality(|k, tag| {
                if rare(k, tag) { "StatusCode(BadOutOfService)" } else { "StatusCode(Good)" }
            }),
        )
        .right(nearly),
        case(
            "codes with GoodClamped",
            with_quality(|k, tag| if rare(k, tag) { "0x00300000" } else { "0x00000000" }),
        ),
        case(
            "192 and one unknown code",
            with_quality(|k, tag| if k == 500 && tag == "PV" { "1234567" } else { "192" }),
        )
        .right(nearly)
        .or_refused(&["1234567", "row 150"], &[]),
    ];
    examine("quality", cases);
}

#[test]
fn annotated_tables() {
    let of = |head: &dyn Fn(usize, &str) -> String,
              row: &dyn Fn(usize, &str, f64, usize) -> String,
              end: &str| {
        let mut text = String::new();
        for (table, tag) in ["op", "pv", "sp"].iter().enumerate() {
            text += &head(table, tag);
            for k in 0..N {
                let [pv, sp, op] = at(k);
                text += &row(table, tag, [op, pv, sp][table], k);
            }
            text += end;
        }
        text.replace('\n', end)
    };
    let z = |k: usize| clock("%Y-%m-%dT%H:%M:%SZ", k as f64);
    let whole = "#datatype,string,long,dateTime:RFC3339,double,string,string\n#group,\
            false,false,false,false,true,true\n#default,_result,,,,,\n,result,\
            table,_time,_value,_field,_measurement\n";
    let merely_named = ",result,table,_time,_value,_field,loop\n";
    let pivoted = lines(
        "#datatype,string,long,dateTime:RFC3339,string,double,double,double\n\
            #group,false,false,false,true,false,false,false\n#default,_result,,,,,\
            ,\n,result,table,_time,_measurement,op,pv,sp\n",
        |k| {
            let [pv, sp, op] = at(k);
            format!(",,0,{},FIC101,{op},{pv},{sp}\n", z(k))
        },
    );
    let rows = |table: usize, tag: &str, value: f64, k: usize| {
        format!(",,{table},{},{value},{tag},FIC101\n", z(k))
    };
    let cases = vec![
        case("three tables, CR LF", of(&|_, _| whole.to_owned(), &rows, "\r\n")),
        case("headers without annotations", of(&|_, _| merely_named.to_owned(), &rows, "\n")),
        case("pivoted", pivoted),
    ];
    examine("annotated", cases);
}

#[test]
fn times_of_day() {
    let night = jiff::civil::date(2025, 3, 14).at(23, 50, 0, 0);
    let of = |head: &str, pattern: &'static str, step: f64| {
        samples(head, |k, [pv, sp, op]| {
            format!("{},{pv},{sp},{op}\n", clock_from(night, pattern, step * k as f64))
        })
    };
    let minutes = |right: &mut Right| right.step = 60.0;
    let two = samples("Date,Time,FIC1.PV,FIC1.SP,FIC1.OP\n", |k, [pv, sp, op]| {
        format!("{},{pv},{sp},{op}\n", clock_from(night, "%d.%m.%Y,%H:%M:%S", k as f64))
    });
    let cases = vec![
        case("twelve hours", of("Time,FIC1.PV,FIC1.SP,FIC1.OP\n", "%I:%M:%S %p", 1.0))
            .or_refused(&[], &[]),
        case("minutes", of("Time,FIC1.PV,FIC1.SP,FIC1.OP\n", "%H:%M", 60.0))
            .right(minutes)
            .or_refused(&[], &[]),
        case("minutes of the hour", of("Time,FIC1.PV,FIC1.SP,FIC1.OP\n", "%M:%S.0", 1.0))
            .or_refused(&[], &[]),
        case("date and time of day", two),
    ];
    examine("time-of-day", cases);
}

#[test]
fn notations_and_names_of_times() {
    let of = |name: &str, pattern: &str| {
        samples(&format!("{name};FIC1.PV;FIC1.SP;FIC1.OP\n"), |k, [pv, sp, op]| {
            format!("{};{pv};{sp};{op}\n", clock(pattern, k as f64))
        })
    };
    let notations = [
        ("basic ISO 8601", "%Y%m%dT%H%M%SZ"),
        ("day of the year", "%Y-%jT%H:%M:%S"),
        ("week", "%G-W%V-%uT%H:%M:%S"),
        ("comma and short offset", "%Y-%m-%dT%H:%M:%S,000+01"),
    ];
    let named = notations.map(|(name, pattern)| case(name, of("Time", pattern)));
    examine("times", named.into());
    const NAMES: &str = "SourceTimestamp|Server Timestamp|_time|IP_TREND_TIME|Zeitpunkt|\
        Datum/Uhrzeit|Horodatage|Fecha|Fecha y hora|Data/Ora|t_stamp|TimeString|Zeitstempel|\
        Date heure|Tijd|Tidpunkt|日時";
    let wrong =
        NAMES.split('|').filter_map(|name| match judged(of(name, GERMAN).as_bytes(), "a.csv") {
            Ok(found) if found.samples == N && found.grade == Grade::Sticks => None,
            Ok(found) => Some(format!("{name}: {found:?}")),
            Err(message) => Some(format!("{name}: refused: {message}")),
        });
    let wrong: Vec<String> = wrong.collect();
    assert!(wrong.is_empty(), "{} names of times\n{}", wrong.len(), wrong.join("\n"));
}

#[test]
fn several_rows_above_the_numbers() {
    let cases = vec![
        case(
            "names, units, descriptions",
            below(
                "Time,FIC1.PV,FIC1.SP,FIC1.OP\n,m3/h,m3/h,%\n,Feed to K1,Feed to K1,\
            Feed to K1\n",
            ),
        ),
        case(
            "descriptions, names",
            below("Timestamp,Feed flow,Feed flow,Feed flow\n,FIC1.PV,FIC1.SP,FIC1.OP\n"),
        ),
        case("loop above signal", below(",FIC1,FIC1,FIC1\nTime,PV,SP,OP\n")),
        case(
            "names, descriptions, units, low, high",
            below("Time,FIC1.PV,FIC1.SP,FIC1.OP\nDescription,Feed,Feed,Feed\nUnits,m3/h,m3/h,%\n"),
        ),
    ];
    examine("headers", cases);
}

#[test]
fn a_file_for_each_tag() {
    let one = |head: &str, index: usize, every: usize| {
        lines(head, |k| match k % every {
            0 => format!("{};{}\n", clock(ISO, k as f64), at(k)[index]),
            _ => String::new(),
        })
    };
    let three = |name, heads: [&str; 3], files: [&'static str; 3]| {
        super::case(name, files[0], one(heads[0], 0, 1))
            .file(files[1], one(heads[1], 1, 60))
            .file(files[2], one(heads[2], 2, 1))
            .or_refused(&[], &[])
            .right(nearly)
    };
    let cases = vec![
        three(
            "the names of the files",
            ["Time;Value\n"; 3],
            ["FIC7_PV.csv", "FIC7_SP.csv", "FIC7_OP.csv"],
        ),
        three(
            "the headers",
            ["Timestamp;FIC7.PV\n", "Timestamp;FIC7.SP\n", "Timestamp;FIC7.OP\n"],
            ["a.csv", "b.csv", "c.csv"],
        ),
        three("roles alone", ["Zeit;Wert\n"; 3], ["pv.csv", "sp.csv", "op.csv"]),
    ];
    examine("files", cases);
}

#[test]
fn repeated_names() {
    let bad = |k: usize| if k % 400 == 37 { "Bad" } else { "Good" };
    let quality =
        samples("Time,FIC1.PV,Quality,FIC1.OP,Quality,FIC1.SP,Quality\n", |k, [pv, sp, op]| {
            let pv = if bad(k) == "Bad" { 0.0 } else { pv };
            format!("{},{pv},{},{op},Good,{sp},Good\n", clock(ISO, k as f64), bad(k))
        });
    let percent = samples("Time;FIC1.PV;Conf;FIC1.OP;Conf\n", |k, [pv, _, op]| {
        let (pv, conf) = if bad(k) == "Bad" { (-9999.0, 0) } else { (pv, 100) };
        format!("{};{pv};{conf};{op};100\n", clock(ISO, k as f64))
    });
    let same = samples("Time,FIC1.PV,FIC1.PV,FIC1.SP,FIC1.OP\n", |k, [pv, sp, op]| {
        format!("{},{pv},{pv},{sp},{op}\n", clock(ISO, k as f64))
    });
    let cases = vec![
        case("a quality after each tag", quality),
        case("a confidence after each tag", percent),
        case("a column twice", same).or_refused(&["FIC1.PV"], &[]),
    ];
    examine("names", cases);
}

#[test]
fn torn_rows_and_trailers() {
    let whole = || plain(|_, values| values);
    let without_end = |text: &str, cells: usize| {
        let mut rows: Vec<String> = text.lines().map(str::to_owned).collect();
        let short: Vec<&str> = rows[600].split(',').take(cells).collect();
        rows[600] = short.join(",");
        rows.join("\n") + "\n"
    };
    let cut = whole();
    let glued = whole().replacen(&format!("\n{}", clock(ISO, 700.0)), &clock(ISO, 700.0), 1);
    let noted: &[&str] = &["row 601", "601", "short", "torn", "skipped", "fewer"];
    let near = |right: &mut Right| right.judged = (N - 2, N);
    let cases = vec![
        case("a short row", without_end(&whole(), 2)).said(noted).right(near),
        case("a row without its last value", without_end(&whole(), 3)).said(noted).right(near),
        case("the last row cut", &cut.as_bytes()[..cut.len() - 9]).right(near),
        case("two rows in one", glued)
            .said(&["row 701", "701", "skipped", "torn", "more"])
            .right(near)
            .or_refused(&["701"], &[]),
        case("End of data", whole() + "End of data\n").right(near),
        case("a count", whole() + "$RT_COUNT$,1200,,\n").right(near),
        case("averages below", whole() + "\nAverage,60.1,60,45.2\nMaximum,62.3,60,48.1\n")
            .right(near)
            .or_refused(&["Average"], &[]),
    ];
    examine("torn", cases);
}

#[test]
fn side_by_side() {
    let dated = |s: f64| clock(ISO, s);
    let german = |s: f64| clock(GERMAN, s);
    let cases = vec![
        case(
            "tags above Time and Value",
            beside(
                "FIC1.PV,,FIC1.SP,,FIC1.OP,\nTime,Value,Time,Value,Time,Value\n",
                ",",
                &dated,
                0.0,
                0,
            ),
        )
        .right(nearly),
        case(
            "tags above, German",
            beside(
                "FIC1.PV;;FIC1.SP;;FIC1.OP;\nZeit;Wert;Zeit;Wert;Zeit;Wert\n",
                ";",
                &german,
                0.0,
                0,
            ),
        )
        .right(nearly),
        case(
            "times named after tags",
            beside(
                "FIC1.PV Time,FIC1.PV,FIC1.SP Time,FIC1.SP,FIC1.OP Time,FIC1.OP\n",
                ",",
                &dated,
                0.0,
                0,
            ),
        )
        .right(nearly),
    ];
    examine("side-by-side", cases);
}

#[test]
fn no_header() {
    let long = lines("", |k| {
        let tags = ["PV", "SP", "OP"].iter().zip(at(k));
        tags.map(|(tag, value)| {
            format!("FIC1.{tag};{};{}\n", clock(GERMAN, k as f64), comma(value, 2))
        })
        .collect()
    });
    let wide = samples("", |k, [pv, sp, op]| format!("{k}\t{pv}\t{sp}\t{op}\n"));
    // Only the user knows the names, so no option is needed.
    let cases = vec![
        case("long", long).or_refused(&["FIC1.PV;14.03.2025 06:00:00;60,06"], &[]).unadvised(),
        super::case("wide, tabs", "a.txt", wide).or_refused(&["60.06"], &[]).unadvised(),
        case("wide, dates", below(""))
            .or_refused(&["2025-03-14 06:00:00,60.06,60,44.97"], &[])
            .unadvised(),
    ];
    examine("no-header", cases);
}

#[test]
fn names_in_words() {
    let cases = vec![
        case(
            "an area before it",
            below(
                "Date-Time,Area A: FIC2106 Flow PV (m3/h),\
            Area A: FIC2106 Flow SP (m3/h),Area A: FIC2106 Valve Output (%)\n",
            ),
        ),
        case(
            "a reactor",
            below(
                "Date-Time,Unit 2: TIC 300 Reactor Temperature PV (degC),\
            Unit 2: TIC 300 Reactor Temperature SP (degC),\
            Unit 2: TIC 300 Valve Output (%)\n",
            ),
        ),
        case(
            "a level",
            below(
                "Date-Time,LIC07 Drum Level PV,LIC07 Drum Level Setpoint,\
            LIC07 Controller Output (%)\n",
            ),
        ),
    ];
    examine("words", cases);
}

/// A file that a library wrote, of the first 600 samples.
fn kept(name: &'static str) -> Case {
    let bytes = std::fs::read(format!("{FIXTURES}/{name}")).expect("a fixture");
    super::case(name, name, bytes).right(|right| right.judged = (600, 600))
}

#[test]
fn structures_of_simulink() {
    let cases = vec![
        kept("simulink-labels.mat"),
        kept("simulink-matrix.mat").or_refused(&["PV and SP"], &["op=OP"]).unadvised(),
        kept("simulink-without-time.mat").or_refused(&[], &[]),
    ];
    examine("simulink", cases);
}

#[test]
fn workbooks() {
    let cases = vec![
        kept("plain.xlsx"),
        kept("titles.xlsx"),
        kept("two-sheets.xlsx"),
        kept("merged.xlsx"),
        kept("plain.xls"),
        kept("plain.ods"),
    ];
    examine("workbooks", cases);
}

#[test]
fn the_base_is_what_the_cases_expect() {
    examine("base", vec![case("plain", plain(|_, values| values))]);
}
