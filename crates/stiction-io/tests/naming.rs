//! How control systems and people name signals. The tables are of the vendors' naming as it is commonly known;
//! none is taken from a file of a plant.

use crate::said;
use std::fmt::Write;
use stiction_io::ReadOptions;
use stiction_io::layout;
use stiction_io::reading::{self, Reading};
use stiction_recording::recording::{LoopType, Mode, Recording};

const PAGE: &str = include_str!("../../../docs/recordings.md");

/// The columns of an export of one controller, and the loop that it is read as.
struct Dialect {
    /// The vendor, as `docs/recordings.md` names it.
    name: &'static str,
    /// Columns of PV, SP, OP and, where there is one, mode.
    columns: &'static [&'static str],
    /// Tag of the loop.
    tag: &'static str,
}

const DIALECTS: [Dialect; 13] = [
    Dialect {
        name: "Honeywell Experion, TDC",
        columns: &["FC101.DACA.PV", "FC101.PIDA.SP", "FC101.PIDA.OP", "FC101.PIDA.MODE"],
        tag: "FC101.PIDA",
    },
    Dialect {
        name: "Yokogawa CENTUM",
        columns: &["FIC101.PV", "FIC101.SV", "FIC101.MV", "FIC101.MODE"],
        tag: "FIC101",
    },
    Dialect {
        name: "Emerson DeltaV",
        columns: &[
            "FIC-101/PID1/PV.CV",
            "FIC-101/PID1/SP.CV",
            "FIC-101/PID1/OUT.CV",
            "FIC-101/PID1/MODE.ACTUAL",
        ],
        tag: "FIC-101/PID1",
    },
    Dialect {
        name: "ABB 800xA",
        columns: &["FIC101:PV", "FIC101:SP", "FIC101:Out", "FIC101:Mode"],
        tag: "FIC101",
    },
    Dialect {
        name: "Siemens PCS 7, WinCC",
        columns: &["FIC101/PID.PV_IN", "FIC101/PID.SP_INT", "FIC101/PID.LMN"],
        tag: "FIC101/PID",
    },
    Dialect {
        name: "Rockwell Logix",
        columns: &["[PLC1]FIC101.PV", "[PLC1]FIC101.SP", "[PLC1]FIC101.CVEU"],
        tag: "[PLC1]FIC101",
    },
    Dialect {
        name: "Foxboro I/A",
        columns: &["CP01:FIC101.MEAS", "CP01:FIC101.SPT", "CP01:FIC101.OUT", "CP01:FIC101.MA"],
        tag: "CP01:FIC101",
    },
    Dialect {
        name: "AVEVA (Wonderware)",
        columns: &["FIC101.PV", "FIC101.SP", "FIC101.CO", "FIC101.AUTO"],
        tag: "FIC101",
    },
    Dialect {
        name: "OSIsoft PI tags",
        columns: &["FIC101.PV", "FIC101.SP", "FIC101.OP", "FIC101.MODE"],
        tag: "FIC101",
    },
    Dialect {
        name: "PI AF paths",
        columns: &[
            r"\\SERVER\DB\U1\FIC101|PV",
            r"\\SERVER\DB\U1\FIC101|SP",
            r"\\SERVER\DB\U1\FIC101|OP",
            r"\\SERVER\DB\U1\FIC101|Mode",
        ],
        tag: r"\\SERVER\DB\U1\FIC101",
    },
    Dialect {
        name: "OPC UA",
        columns: &["U1/FIC101.PV#Value", "U1/FIC101.SP#Value", "U1/FIC101.OP#Value"],
        tag: "U1/FIC101",
    },
    Dialect {
        name: "signal first",
        columns: &["PV_FIC101", "SP_FIC101", "OP_FIC101", "MODE_FIC101"],
        tag: "FIC101",
    },
    Dialect {
        name: "GE iFIX",
        columns: &["FIX.FIC101_PV.F_CV", "FIX.FIC101_SP.F_CV", "FIX.FIC101_OP.F_CV"],
        tag: "FIX.FIC101",
    },
];

fn parse(text: &str, mapping: &str) -> Result<Reading, String> {
    let options = ReadOptions::parse(mapping, "map.toml").expect("a mapping");
    reading::parse(text.as_bytes(), "f.csv", &options).map_err(|error| error.to_string())
}

/// What a recording has, such as `FIC101: PV 1, SP 2, OP 50, manual`.
fn shown(recording: &Recording) -> String {
    let mut shown = format!("{}:", recording.name);
    for (name, channel) in [
        ("PV", recording.pv.as_ref()),
        ("SP", recording.sp.as_ref()),
        ("OP", Some(&recording.op)),
        ("VP", recording.vp.as_ref()),
    ] {
        if let Some(channel) = channel {
            let _ = write!(shown, " {name} {}", channel.values[0]);
        }
    }
    if let Some(modes) = &recording.mode {
        let _ = write!(shown, " {:?}", modes.modes[0]);
    }
    shown
}

#[test]
fn every_dialect_is_read_whole() {
    let values = ["1.5", "2", "50", "1"];
    for Dialect { name, columns, tag } in DIALECTS {
        let cells = values[..columns.len()].join(",");
        let wide = format!("Timestamp,{}\n2026-03-01 00:00:00,{cells}\n", columns.join(","));
        let row = |(tag, value): (&&str, &&str)| format!("{tag},2026-03-01 00:00:00,{value}\n");
        let rows: String = columns.iter().zip(&values).map(row).collect();
        let long = format!("TagName,Timestamp,Value\n{rows}");
        let mode = if columns.len() > 3 { " Automatic" } else { "" };
        for text in [wide, long] {
            let reading = parse(&text, "").unwrap_or_else(|error| panic!("{name}: {error}"));
            let [recording] = &reading.recordings[..] else {
                panic!("{name}: {:?}", reading.recordings)
            };
            assert_eq!(shown(recording), format!("{tag}: PV 1.5 SP 2 OP 50{mode}"), "{name}");
            assert_eq!(recording.loop_type, LoopType::Flow, "{name}");
            assert!(reading.untagged.is_empty(), "{name}");
        }
    }
}

/// A scan of a plant reads some loops of a file at a time.
#[test]
fn several_loops_of_every_dialect_are_read_alike_alone_and_together() {
    for Dialect { name, columns, tag } in DIALECTS {
        let of = |number| columns.iter().map(move |column: &&str| column.replace("101", number));
        let names: Vec<String> = ["101", "102", "103"].into_iter().flat_map(of).collect();
        let value = |k: usize| ["1.5", "2", "50", "1"][k % columns.len()];
        let table = |chosen: &[usize]| {
            let header: Vec<&str> = chosen.iter().map(|k| &*names[*k]).collect();
            let cells: Vec<&str> = chosen.iter().map(|k| value(*k)).collect();
            format!("Timestamp,{}\n2026-03-01 00:00:00,{}\n", header.join(","), cells.join(","))
        };
        let all: Vec<usize> = (0..names.len()).collect();
        let whole = parse(&table(&all), "").unwrap_or_else(|error| panic!("{name}: {error}"));
        let mode = if columns.len() > 3 { " Automatic" } else { "" };
        let expected: Vec<String> = ["101", "102", "103"]
            .iter()
            .map(|number| format!("{}: PV 1.5 SP 2 OP 50{mode}", tag.replace("101", number)))
            .collect();
        assert_eq!(whole.recordings.iter().map(shown).collect::<Vec<_>>(), expected, "{name}");

        let named: Vec<&str> = names.iter().map(String::as_str).collect();
        let bundles = layout::bundles(&named, &[], &ReadOptions::default()).expect(name);
        let mut alone = vec![];
        for bundle in bundles {
            let reading = parse(&table(&bundle.names), "").expect(name);
            let told: Vec<&str> = bundle.loops.iter().map(|(own, _)| &**own).collect();
            let read: Vec<&str> = reading.recordings.iter().map(|own| &*own.name).collect();
            assert_eq!(told, read, "{name}");
            alone.extend(reading.recordings.iter().map(shown));
        }
        assert_eq!(alone, expected, "{name}");
    }
}

#[test]
fn the_page_lists_every_dialect() {
    for Dialect { name, columns, tag } in DIALECTS {
        let row = PAGE.lines().find(|line| line.starts_with(&format!("| {name} |")));
        let row = row.unwrap_or_else(|| panic!("no row for {name}")).replace("\\|", "|");
        for column in columns.iter().chain([&tag]) {
            assert!(row.contains(&format!("`{column}`")), "{name} lacks {column}");
        }
    }
}

#[test]
fn what_people_call_signals() {
    for (header, expected) in [
        ("Date,Flow (m3/h),Setpoint,Valve output (%)", "f: PV 1 SP 2 OP 3"),
        ("Time,Level,Set,Out", "f: PV 1 SP 2 OP 3"),
        ("t,Pressure [bar],Set point,Output", "f: PV 1 SP 2 OP 3"),
        ("t,Temperature,SP,FIC101.OP", "FIC101: PV 1 SP 2 OP 3"),
        ("t,Flow (m3/h),Flow setpoint (m3/h),Valve output (%)", "Flow: PV 1 SP 2 OP 3"),
        ("Zeit,Istwert (m3/h),Sollwert (m3/h),Stellwert (%)", "f: PV 1 SP 2 OP 3"),
        ("Zeit,FIC4711.X,FIC4711.W,FIC4711.Y", "FIC4711: PV 1 SP 2 OP 3"),
        ("Zeit,Regelgröße,Führungsgröße,Stellgröße", "f: PV 1 SP 2 OP 3"),
        ("Zeit,Regelgroesse,Fuehrungsgroesse,Stellgroesse", "f: PV 1 SP 2 OP 3"),
    ] {
        let reading = parse(&format!("{header}\n45000,1,2,3\n45001,1,2,3\n"), "");
        let reading = reading.unwrap_or_else(|error| panic!("{header}: {error}"));
        assert_eq!(shown(&reading.recordings[0]), expected, "{header}");
    }
    let reading = parse("t,Flow,Out\n0,1,50\n1,2,51\n", "").unwrap();
    assert!(said(&reading).contains("\"Flow\" is interpreted as the PV"), "{}", said(&reading));
    assert!(said(&reading).contains("map ignore=Flow"), "{}", said(&reading));
}

#[test]
fn what_could_be_two_things_is_not_taken() {
    // Two quantities: neither is the PV, and both are named.
    let reading = parse("t,Flow,Level,Out\n0,1,5,50\n1,3,6,51\n", "").unwrap();
    assert_eq!(shown(&reading.recordings[0]), "f: OP 50");
    let note = "\"Flow\", \"Level\" hold numbers and are not used, while the loop has no PV, no SP, \
                no VP, no mode; if one of them is a missing signal, assign the signal, as in map pv=Flow";
    assert!(said(&reading).contains(note), "{}", said(&reading));
    let reading = parse("t,Flow,Flow 2,Out\n0,1,5,50\n1,3,6,51\n", "").unwrap();
    assert_eq!(shown(&reading.recordings[0]), "f: OP 50");
    let refused = parse("t,Sollwert,Setpoint,Out\n0,1,5,50\n", "").unwrap_err();
    let expected =
        "\"Sollwert\" and \"Setpoint\" can both be the SP; choose one, as in map sp=Sollwert";
    assert!(refused.contains(expected), "{refused}");
    // With a PV a flow is something else; with two loops nobody can say whose it is.
    for header in ["t,Flow,PV,OP", "t,Flow,FIC1.OP,LIC2.OP"] {
        let reading = parse(&format!("{header}\n0,7,1,50\n1,8,2,51\n"), "").unwrap();
        assert!(said(&reading).contains("\"Flow\" holds numbers and is not used"), "{header}");
    }
}

#[test]
fn what_is_left_over_is_named() {
    let of = |header: &str| said(&parse(&format!("{header}\n0,1,a,50\n1,5,b,51\n"), "").unwrap());
    assert!(of("t,Room,Shift,op").contains("\"Room\" holds numbers"), "{}", of("t,Room,Shift,op"));
    // Texts are no signals, nor is a count of rows; and what the user leaves out is known to him.
    assert_eq!(of("t,pv,Shift,op"), "");
    let text = "n,t,pv,op,Room\n0,0,1,50,20\n1,1,2,51,21\n";
    let note = said(&parse(text, "").unwrap());
    assert!(note.contains("\"Room\" holds numbers") && !note.contains("\"n\""), "{note}");
    let position = said(&parse("t,pv,sp,op,OUTPOS\n0,1,2,50,49\n", "").unwrap());
    assert!(position.contains("no VP, no mode; if one") && position.contains("map vp=OUTPOS"));
    // With nothing missing there is nothing to be said, but it is not passed over.
    let whole = "t,pv,sp,op,vp,mode,Room\n0,1,2,50,49,AUTO,20\n";
    assert_eq!(said(&parse(whole, "").unwrap()), "\"Room\" holds numbers and is not used");
    let long = "tag,time,value\nFIC1.OP,0,50\nFIC1.PV,0,1\nTI7,0,20\nFIC1.OP,1,50\n";
    let note = said(&parse(long, "").unwrap());
    assert!(note.contains("\"TI7\" holds numbers"), "{note}");
    assert!(note.contains("loop FIC1 has no SP, no VP, no mode"), "{note}");
}

/// A limit is no position, and a switch is a mode or nothing.
#[test]
fn only_columns_that_fit_are_offered() {
    for (header, rows, offer) in [
        ("OPHILM,OUTPOS", ["100,49", "100,51"], Some("map vp=OUTPOS")),
        ("OPHILM", ["100", "100"], None),
        ("OPLOLM", ["0", "0"], None),
        ("Total", ["7000", "7100"], None),
        ("Running", ["1", "0"], Some("map mode=Running")),
    ] {
        let [a, b] = rows;
        let note = said(
            &parse(&format!("t,pv,sp,op,{header}\n0,1,2,50,{a}\n1,2,2,52,{b}\n"), "").unwrap(),
        );
        match offer {
            Some(offer) => assert!(note.contains(offer), "{header}: {note}"),
            None => assert_eq!(note, format!("\"{header}\" holds numbers and is not used")),
        }
    }
}

/// PCS 7 has the SP of the operator beside the SP in effect.
#[test]
fn the_sp_in_effect_goes_before_that_of_the_operator() {
    for (header, expected) in [
        ("F1/PID.PV_IN,F1/PID.SP_INT,F1/PID.LMN,F1/PID.SP", "F1/PID: PV 1 SP 4 OP 3"),
        ("F1/PID.PV_IN,F1/PID.SP_INT,F1/PID.LMN,F2/PID.SP", "F1/PID: PV 1 SP 2 OP 3"),
    ] {
        let reading = parse(&format!("t,{header}\n0,1,2,3,4\n"), "").unwrap();
        assert_eq!(shown(&reading.recordings[0]), expected, "{header}");
    }
    let given = "[columns]\n\"SP_INT\" = \"sp\"\n";
    let reading = parse("t,PV,SP_INT,OP,SP\n0,1,2,3,4\n", given).unwrap();
    assert_eq!(shown(&reading.recordings[0]), "f: PV 1 SP 2 OP 3");
}

#[test]
fn the_transmitter_of_a_loop_is_offered() {
    let text = "t,10FT101.DACA.PV,10FT102.DACA.PV,10FC101.PIDA.OP,10FC101.PIDA.SP\n0,1,2,50,3\n";
    let reading = parse(text, "").unwrap();
    assert_eq!(shown(&reading.recordings[0]), "10FC101.PIDA: SP 3 OP 50");
    let note = "by its tag, \"10FT101.DACA.PV\" can be the PV of 10FC101.PIDA, which has no PV; if this is \
                right, give map 10FC101.PIDA.pv=10FT101.DACA.PV";
    assert!(said(&reading).contains(note), "{}", said(&reading));
    assert!(!said(&reading).contains("10FT102.DACA.PV\" can"), "{}", said(&reading));
    // What is offered can be taken as it is written there.
    let mapping = "[loop.\"10FC101.PIDA\"]\npv = \"10FT101.DACA.PV\"\n";
    let reading = parse(text, mapping).unwrap();
    assert_eq!(shown(&reading.recordings[0]), "10FC101.PIDA: PV 1 SP 3 OP 50");
    let bare = parse("t,U1/LIT-7,U1/LIC-7.OP,Room\n0,1,50,20\n1,5,51,20\n", "").unwrap();
    assert!(said(&bare).contains("map U1/LIC-7.pv=U1/LIT-7"), "{}", said(&bare));
    assert!(said(&bare).contains("\"Room\" holds numbers"), "{}", said(&bare));
}

#[test]
fn switches_tell_the_mode() {
    let modes = |text: &str| {
        let reading = parse(text, "").unwrap_or_else(|error| panic!("{text}: {error}"));
        let modes = reading.recordings[0].mode.as_ref().map(|modes| modes.modes.clone());
        (modes, said(&reading))
    };
    let (found, note) = modes("t,FIC1.OP,FIC1.AUTO\n0,50,1\n1,51,0\n");
    assert_eq!(found, Some(vec![Mode::Automatic, Mode::Manual]));
    assert!(
        note.contains("\"FIC1.AUTO\" is interpreted as the mode, with 1 automatic and 0 manual"),
        "{note}"
    );
    let (found, note) = modes("t,FIC1.OP,FIC1.AUTO,FIC1.MAN\n0,50,0,1\n1,51,0,0\n2,51,,\n");
    assert_eq!(found, Some(vec![Mode::Manual, Mode::Automatic, Mode::Other]));
    assert!(note.contains("map ignore=FIC1.MAN"), "{note}");
    let (found, _) = modes("t,op,hand\n0,50,FALSE\n1,51,TRUE\n");
    assert_eq!(found, Some(vec![Mode::Automatic, Mode::Manual]));
    // The newest row first: a mode holds until the next in time.
    let (found, _) = modes("t,op,mode\n2,51,MAN\n1,51,MAN\n0,50,AUTO\n");
    assert_eq!(found, Some(vec![Mode::Automatic, Mode::Manual, Mode::Manual]));
    // What is not in automatic may be in cascade.
    let (found, note) = modes("t,FIC1.OP,FIC1.AUTO,FIC1.CAS\n0,50,0,1\n1,51,0,1\n");
    assert_eq!(found, None);
    assert!(note.contains("\"FIC1.AUTO\", \"FIC1.CAS\" hold numbers"), "{note}");
    // A column of modes goes before, and one of other numbers is no switch.
    let (found, _) = modes("t,FIC1.OP,FIC1.AUTO,FIC1.MODE\n0,50,1,CAS\n");
    assert_eq!(found, Some(vec![Mode::Cascade]));
    let (found, note) = modes("t,FIC1.OP,FIC1.MAN\n0,50,37.5\n");
    assert_eq!(found, None);
    assert!(note.contains("\"FIC1.MAN\" holds numbers and is not used"), "{note}");
}

/// A position or an output with the tag of the valve is offered, and what is offered works as it is written.
#[test]
fn the_signals_of_a_valve_are_offered() {
    for (header, offers, expected) in [
        (
            "20FIC101.PV,20FIC101.SP,20FIC101.OP,20ZT101.PV",
            &["20FIC101.vp=20ZT101.PV"][..],
            "20FIC101: PV 1 SP 2 OP 3 VP 4",
        ),
        ("FIC1.PV,FIC1.SP,FIC1.OP,ZI-1", &["FIC1.vp=ZI-1"], "FIC1: PV 1 SP 2 OP 3 VP 4"),
        (
            "FIC101.PV,FIC101.SP,FV101.OUT,FV101.POS",
            &["FIC101.op=FV101.OUT", "FIC101.vp=FV101.POS"],
            "FIC101: PV 1 SP 2 OP 3 VP 4",
        ),
        (
            "FC-1/PID1/PV.CV,FC-1/PID1/SP.CV,FC-1/PID1/OUT.CV,FC-1/AO1/READBACK.CV",
            &["FC-1/PID1.vp=FC-1/AO1/READBACK.CV"],
            "FC-1/PID1: PV 1 SP 2 OP 3 VP 4",
        ),
    ] {
        let text = format!("t,{header}\n0,1,2,3,4\n1,1,2,3,4\n");
        let notes = said(&parse(&text, "").unwrap());
        assert!(!notes.contains("the loop has no PV"), "{header}: {notes}");
        let mut mapping = String::from("[columns]\n");
        for offer in offers {
            assert!(notes.contains(&format!("map {offer}")), "{header}: {notes}");
            let (role, column) = offer.split_once('=').unwrap();
            let _ = writeln!(mapping, "\"{column}\" = \"{role}\"");
        }
        assert_eq!(shown(&parse(&text, &mapping).unwrap().recordings[0]), expected, "{header}");
    }
    for header in ["FIC1.PV,FIC1.SP,FIC1.OP,ZT2.PV", "FIC1.PV,FIC1.SP,FIC1.OP,LV1.POS"] {
        let notes = said(&parse(&format!("t,{header}\n0,1,2,3,4\n"), "").unwrap());
        assert!(!notes.contains("by its tag, "), "{header}: {notes}");
    }
    let reading = parse("t,FC-1/AO1/OUT.CV,FC-1/AO1/READBACK.CV\n0,3,4\n", "").unwrap();
    assert_eq!(reading.recordings.iter().map(shown).collect::<Vec<_>>(), ["FC-1/AO1: OP 3 VP 4"]);
}

/// CV is the controlled variable of textbooks, or the output of a controller.
#[test]
fn cv_beside_mv_is_a_question() {
    for (header, columns) in [
        ("CV,SP,MV", ["CV", "MV"]),
        ("MV,CV", ["CV", "MV"]),
        ("FIC1.CV,FIC1.SP,FIC1.MV,LIC2.PV,LIC2.OP", ["FIC1.CV", "FIC1.MV"]),
    ] {
        let [cv, mv] = columns;
        let cells = ["1", "2", "50", "4", "60"][..header.split(',').count()].join(",");
        let text = format!("t,{header}\n0,{cells}\n");
        let refused = parse(&text, "").unwrap_err();
        for option in
            [format!("pv={cv}"), format!("op={mv}"), format!("op={cv}"), format!("vp={mv}")]
        {
            assert!(refused.contains(&format!("map {option}")), "{refused}");
        }
        for (own, other) in [("pv", "op"), ("op", "vp")] {
            let mapping = format!("[columns]\n\"{cv}\" = \"{own}\"\n\"{mv}\" = \"{other}\"\n");
            let reading = parse(&text, &mapping).unwrap();
            let columns = &reading.recordings[0].columns;
            let (first, second) = match own {
                "pv" => (&columns.pv, &columns.op),
                _ => (&columns.op, &columns.vp),
            };
            assert_eq!((first.as_deref(), second.as_deref()), (Some(cv), Some(mv)), "{header}");
        }
    }
    // With a PV, CV is the output.
    let reading = parse("t,FIC1.PV,FIC1.CV,FIC1.MV\n0,1,50,49\n", "").unwrap();
    assert_eq!(shown(&reading.recordings[0]), "FIC1: PV 1 OP 50 VP 49");
    let reading = parse("t,Flow,CV,MV\n0,1,50,49\n", "").unwrap();
    assert_eq!(shown(&reading.recordings[0]), "f: PV 1 OP 50 VP 49");
}

/// The parameters of DeltaV, and gas, are no outputs. What is not read is named.
#[test]
fn parameters_and_gases_are_no_outputs() {
    let loops = |header: &str| {
        let cells: Vec<String> = (1..=header.split(',').count()).map(|k| k.to_string()).collect();
        let reading = parse(&format!("t,{header}\n0,{0}\n1,{0}\n", cells.join(",")), "").unwrap();
        let loops: Vec<String> = reading.recordings.iter().map(shown).collect();
        (loops.join(" | "), said(&reading))
    };
    for (header, expected) in [
        ("F1/PID1/PV.CV,F1/PID1/OUT.CV,FI2/AI1/OUT.CV,F1/PID1/GAIN.CV", "F1/PID1: PV 1 OP 2"),
        ("FIC1.PV,FIC1.OP,Stack CO,CO", "FIC1: PV 1 OP 2"),
        ("PV,OP,CO", "f: PV 1 OP 2"),
    ] {
        let (found, note) = loops(header);
        assert_eq!(found, expected, "{header}");
        let last = header.split(',').next_back().unwrap();
        assert!(note.contains(&format!("\"{last}\" hold")), "{header}: {note}");
    }
    for (header, expected) in [
        ("FIC1.PV,FIC1.CO,LIC2.PV,LIC2.OP", "FIC1: PV 1 OP 2 | LIC2: PV 3 OP 4"),
        ("PV,SP,CO", "f: PV 1 SP 2 OP 3"),
        ("VALVE.PV,VALVE.CV,TIC3.OP", "VALVE: PV 1 OP 2 | TIC3: OP 3"),
    ] {
        let (found, note) = loops(header);
        assert_eq!(found, expected, "{header}");
        assert!(!note.contains("carbon") && !note.contains("holds numbers"), "{header}: {note}");
    }
    let (found, note) = loops("Stack CO");
    assert_eq!(found, "Stack: OP 1");
    assert!(note.contains("if it is carbon monoxide, give map ignore=Stack CO"), "{note}");
}

#[test]
fn words_of_modes_are_read_or_offered() {
    let both = Some(vec![Mode::Automatic, Mode::Manual]);
    let modes = |header: &str, cells: [&str; 2], mapping: &str| {
        let [a, b] = cells;
        let reading = parse(&format!("t,{header}\n0,50,{a}\n1,51,{b}\n"), mapping).unwrap();
        let modes = reading.recordings[0].mode.as_ref().map(|modes| modes.modes.clone());
        (modes, said(&reading))
    };
    for name in ["FIC1.A/M", "FIC1_A/M", "FIC1.AM", "A/M", "FIC1.AUTO"] {
        assert_eq!(modes(&format!("FIC1.OP,{name}"), ["A", "M"], "").0, both, "{name}");
    }
    assert_eq!(modes("FIC1.OP,FIC1.A_M", ["1", "0"], "").0, both);
    for name in ["FIC1.Ctrl State", "FIC1.MODE.TARGET", "State"] {
        let header = format!("FIC1.OP,{name}");
        let (found, note) = modes(&header, ["AUTO", "MAN"], "");
        let expected =
            format!("\"{name}\" holds mode names and is not used, while the loop has no mode");
        assert_eq!(found, None, "{name}");
        assert!(note.contains(&expected) && note.contains(&format!("map mode={name}")), "{note}");
        let mapping = format!("[columns]\n\"{name}\" = \"mode\"\n");
        assert_eq!(modes(&header, ["AUTO", "MAN"], &mapping).0, both, "{name}");
    }
    // Among several loops each has its own. Units, and a loop with a mode, need no note.
    let text = "t,A1.OP,A11.OP,A11.State\n0,50,60,MAN\n";
    assert!(said(&parse(text, "").unwrap()).contains("map A11.mode=A11.State"));
    for header in ["FIC1.OP,Unit", "FIC1.OP,FIC1.MODE,FIC1.State"] {
        let cells = if header.contains("MODE") { "CAS,AUTO" } else { "A" };
        let reading = parse(&format!("t,{header}\n0,50,{cells}\n"), "").unwrap();
        assert!(!said(&reading).contains("mode names"), "{header}");
    }
}

/// With one OP in a file, a signal that only one other name has is its signal, with a note.
#[test]
fn the_rest_belongs_to_the_only_op() {
    let of = |header: &str| {
        let cells = |name: &str| if name.to_lowercase().contains("mode") { "AUTO" } else { "7" };
        let cells = header.split(',').map(cells).collect::<Vec<_>>().join(",");
        let reading = parse(&format!("t,{header}\n0,{cells}\n1,{cells}\n"), "").unwrap();
        let loops: Vec<String> = reading.recordings.iter().map(shown).collect();
        (loops.join(" | "), said(&reading))
    };
    for (header, expected, used) in [
        ("FIC1.PV,FIC1.OP,Loop Mode", "FIC1: PV 7 OP 7 Automatic", &["Loop Mode"][..]),
        ("FIC1.PV,FIC1.OP,PID Mode", "FIC1: PV 7 OP 7 Automatic", &["PID Mode"]),
        ("FIC1.OP,FIC1.Block.MODE", "FIC1: OP 7 Automatic", &["FIC1.Block.MODE"]),
        ("FIC1.OP,FIC1.PIDA.MODE", "FIC1: OP 7 Automatic", &["FIC1.PIDA.MODE"]),
        ("FIC1.OP,FIC1.PV,FIC1.Remote.SP", "FIC1: PV 7 SP 7 OP 7", &["FIC1.Remote.SP"]),
        ("Flow PV,Flow SP,Valve CO", "Valve: PV 7 SP 7 OP 7", &["Flow PV", "Flow SP"]),
        (
            "Flow Setpoint,Flow,Valve Demand,Valve Feedback",
            "f: PV 7 SP 7 OP 7 VP 7",
            &["Flow Setpoint", "Valve Feedback"],
        ),
        ("FIC1.OP,LIC2.PV,LIC2.SP,Loop Mode", "FIC1: OP 7 Automatic", &["Loop Mode"]),
    ] {
        let (found, note) = of(header);
        assert_eq!(found, expected, "{header}");
        for name in used {
            assert!(note.contains(&format!("\"{name}\" is interpreted as the ")), "{note}");
            assert!(note.contains(&format!("map ignore={name}")), "{header}: {note}");
        }
        assert!(!note.contains("Mode\" is not used"), "{header}: {note}");
    }
    // A different tag, a second candidate, and a file with several OPs are left to the user.
    for (header, expected, offer) in [
        ("FIC1.OP,LIC2.PV,LIC2.MODE", "FIC1: OP 7", ""),
        ("FIC1.OP,FIC1.PV,Room.PV,Room.SP", "FIC1: PV 7 OP 7", "map FIC1.sp=Room.SP"),
        ("FIC1.OP,Loop Mode,Pump Mode", "FIC1: OP 7", "map FIC1.mode=Loop Mode"),
        (
            "FIC1.OP,FIC2.OP,FIC1.Block.MODE",
            "FIC1: OP 7 | FIC2: OP 7",
            "map FIC1.mode=FIC1.Block.MODE",
        ),
        ("FIC1.OP,FIC2.OP,Loop Mode", "FIC1: OP 7 | FIC2: OP 7", ""),
    ] {
        let (found, note) = of(header);
        assert_eq!(found, expected, "{header}");
        assert!(note.contains(offer) && note.contains("no OP"), "{header}: {note}");
        assert!(!note.contains("is interpreted"), "{header}: {note}");
    }
    let given = "[columns]\n\"Loop Mode\" = \"LIC2.mode\"\n";
    let text = "t,FIC1.OP,LIC2.PV,Loop Mode\n0,50,1,AUTO\n";
    assert_eq!(shown(&parse(text, given).unwrap().recordings[0]), "FIC1: OP 50");
    // 0 and 1 of Auto/Manual are read as those of A/M, with a note.
    let reading = parse("t,FIC1.OP,FIC1.Auto/Manual\n0,50,1\n1,51,0\n", "").unwrap();
    assert_eq!(shown(&reading.recordings[0]), "FIC1: OP 50 Automatic");
    assert!(said(&reading).contains("with 1 automatic and 0 manual"), "{}", said(&reading));
}

/// Modes under the name of a status that no loop has are offered.
#[test]
fn a_status_with_modes_is_offered() {
    let text = "t,FIC1.PV,FIC1.OP,FIC1.Controller Status\n0,1,50,AUTO\n1,2,51,MAN\n";
    let note = said(&parse(text, "").unwrap());
    assert!(note.contains("map mode=FIC1.Controller Status"), "{note}");
}

#[test]
fn a_mapping_that_a_file_lacks_concerns_its_loop() {
    let mapping = "[loop.A]\npv = \"x1\"\nop = \"y1\"\n[loop.B]\npv = \"x2\"\nop = \"y2\"\n\
                   [loop.C]\npv = \"x3\"\nop = \"y3\"\n";
    let reading = parse("t,x1,y1,y2\n0,1,50,60\n", mapping).unwrap();
    assert_eq!(reading.recordings.iter().map(shown).collect::<Vec<_>>(), ["A: PV 1 OP 50"]);
    let missing: Vec<_> = reading
        .missing
        .iter()
        .map(|each| (&*each.name, each.is_partly_here, each.reason.contains("has no column \"")))
        .collect();
    assert_eq!(missing, [("B", true, true), ("C", false, true)]);
    let note = said(&reading);
    assert!(note.contains("loop B is not read: the file has no column \"x2\""), "{note}");
    assert!(note.contains("lacks these loops of the mapping: \"C\""), "{note}");
    // A file that has nothing else is refused with the reason.
    let refused = parse("t,y2\n0,60\n", mapping).unwrap_err();
    assert!(refused.starts_with("f.csv: has no column \"x2\", which is given as PV"), "{refused}");
}
