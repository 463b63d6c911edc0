//! How tables are laid out: clocks, headers, names, and rows that are no samples.

use crate::said;
use std::fmt::Write;
use stiction_io::reading::{self, Reading};
use stiction_io::{ReadOptions, layout::Layout};
use stiction_recording::recording::{Mode, Quality, Recording};

fn with(text: &str, map: &[&str]) -> Result<Reading, String> {
    let map = map.iter().map(|each| each.parse().expect("a mapping")).collect();
    let options = ReadOptions { map, ..ReadOptions::default() };
    reading::parse(text.as_bytes(), "f.csv", &options).map_err(|error| error.to_string())
}

fn read(text: &str) -> Reading {
    with(text, &[]).unwrap_or_else(|error| panic!("{error}\n{text}"))
}

fn refused(text: &str, map: &[&str]) -> String {
    with(text, map).expect_err(text)
}

/// The samples of all signals, such as `FIC1 PV 0:1 1:2 OP 0:50`.
fn shown(recording: &Recording) -> String {
    let mut shown = recording.name.clone();
    for (name, channel) in
        [("PV", recording.pv.as_ref()), ("SP", recording.sp.as_ref()), ("OP", Some(&recording.op))]
    {
        let Some(channel) = channel else { continue };
        let _ = write!(shown, " {name}");
        for ((time, value), quality) in
            channel.time.iter().zip(&channel.values).zip(&channel.quality)
        {
            let _ = match quality {
                Quality::Good => write!(shown, " {time}:{value}"),
                Quality::Uncertain => write!(shown, " {time}:{value}?"),
                Quality::Bad => write!(shown, " {time}:b"),
                Quality::Missing => write!(shown, " {time}:m"),
            };
        }
    }
    shown
}

fn all(text: &str) -> String {
    read(text).recordings.iter().map(shown).collect::<Vec<_>>().join(" | ")
}

#[test]
fn every_signal_may_have_a_clock() {
    let expected = "FIC1 PV 0:1 1:2 2:3 SP 0:5 OP 0.5:50 1.5:51";
    for text in [
        "Time;FIC1.PV;Time2;FIC1.SP;Time3;FIC1.OP\n0;1;0;5;0.5;50\n1;2;;;1.5;51\n2;3;;;;\n",
        "Time;FIC1.PV;Time;FIC1.SP;Time;FIC1.OP\n0;1;0;5;0.5;50\n1;2;;;1.5;51\n2;3\n",
        "FIC1.PV;Time;FIC1.SP;Time.1;FIC1.OP;Time.2\n1;0;5;0;50;0.5\n2;1;;;51;1.5\n3;2;;;;\n",
        "FIC1.PV.Time;FIC1.PV.Value;FIC1.SP.Time;FIC1.SP.Value;FIC1.OP.Time;FIC1.OP.Value\n0;1;0;5;0.5;50\n1;2;;;1.5;51\n2;3;;;;\n",
        "FIC1.PV;FIC1.PV_t;FIC1.SP;FIC1.SP_t;FIC1.OP;FIC1.OP_t\n1;0;5;0;50;0.5\n2;1;;;51;1.5\n3;2;;;;\n",
        "FIC1.PV ValueX;FIC1.PV ValueY;FIC1.SP ValueX;FIC1.SP ValueY;FIC1.OP ValueX;FIC1.OP ValueY\n0;1;0;5;0.5;50\n1;2;;;1.5;51\n2;3;;;;\n",
        "FIC1.PV;;FIC1.OP;;FIC1.SP;\nTime;Value;Time;Value;Time;Value\n0;1;0.5;50;0;5\n1;2;1.5;51;;\n2;3;;;;\n",
        "Tag;FIC1.PV;;FIC1.OP;;FIC1.SP\n;Time;Value;Time;Value;Time;Value\n;0;1;0.5;50;0;5\n;1;2;1.5;51;;\n;2;3;;;;\n",
    ] {
        let text = text.replacen("Tag;FIC1.PV;;FIC1.OP;;FIC1.SP", ";FIC1.PV;;FIC1.OP;;FIC1.SP;", 1);
        let reading = read(&text);
        assert_eq!(reading.recordings.iter().map(shown).collect::<String>(), expected, "{text}");
        assert_eq!(reading.layout, Layout::SideBySide);
        assert!(
            said(&reading).contains("columns of times; each signal is read with the times"),
            "{}",
            said(&reading)
        );
        assert!(!said(&reading).contains("mode=Time"), "{}", said(&reading));
    }
    // A delimiter at the end of the rows, as a workbook is read, makes no column.
    let closed = "FIC1.PV;;FIC1.OP;;\nTime;Value;Time;Value;\n0;1;0.5;50;\n1;2;1.5;51;\n";
    let reading = read(closed);
    assert_eq!(shown(&reading.recordings[0]), "FIC1 PV 0:1 1:2 OP 0.5:50 1.5:51");
    assert!(!said(&reading).contains("has no column of times"), "{}", said(&reading));
    let dates = "Time;FIC1.PV;Time2;FIC1.OP [%]\n2025-03-14 06:00:00;1;2025-03-14 06:00:01;50\n2025-03-14 06:00:01;2;2025-03-14 06:00:04;51\n";
    assert_eq!(all(dates), "FIC1 PV 0:1 1:2 OP 1:50 4:51");
    // Qualities stand beside the values, and a mapping uses the names of the file.
    let quality = "Time,a,Status,Time,b,Status\n0,1,Good,0,50,Good\n1,2,Bad,1,51,Good\n";
    let reading = with(quality, &["pv=a", "op=b"]).unwrap();
    assert_eq!(shown(&reading.recordings[0]), "f PV 0:1 1:b OP 0:50 1:51");
}

#[test]
fn a_tag_above_its_times_names_the_values_beside_them() {
    let rows = "2025-03-14 06:00:00,60,2025-03-14 06:00:00,44\n2025-03-14 06:00:01,61,2025-03-14 06:00:02,45\n";
    let text = format!("FIC1.PV,,FIC1.OP,\n{rows}");
    let reading = read(&text);
    assert_eq!(shown(&reading.recordings[0]), "FIC1 PV 0:60 1:61 OP 0:44 2:45");
    assert!(
        said(&reading)
            .contains("each tag in row 1 names the times below it and the values beside them")
    );
    // Neither a title, nor tags above values alone.
    for header in ["Export,,,", "FIC1.PV,FIC1.OP,,"] {
        assert!(
            refused(&format!("{header}\n{rows}"), &[]).contains("row 2 must name the columns"),
            "{header}"
        );
    }
}

#[test]
fn one_clock_for_all_remains_one() {
    for text in [
        // T1 and T2 are temperatures, and constant columns are no clocks.
        "Time,FIC1.PV,Time2,FIC1.OP\n0,1,7,50\n1,2,7,51\n",
        "time,T1,FIC1.PV,T2,FIC1.OP\n0,20,1,30,50\n1,21,2,31,51\n",
        "time,op_t,FIC1.PV,FIC1.OP\n0,20,1,50\n1,21,2,51\n",
    ] {
        assert_eq!(all(text), "FIC1 PV 0:1 1:2 OP 0:50 1:51", "{text}");
    }
    let chosen = with("Time,FIC1.PV,Time2,FIC1.OP\n0,1,5,50\n1,2,6,51\n", &["time=Time"]).unwrap();
    assert_eq!(shown(&chosen.recordings[0]), "FIC1 PV 0:1 1:2 OP 0:50 1:51");
}

/// A table in which each row is a sample of some signals only.
#[test]
fn empty_cells_may_be_rows_of_other_signals() {
    let mut joined = "t,FIC1.PV,FIC1.SP,FIC1.OP,FIC1.MODE\n".to_owned();
    let mut rates = joined.clone();
    let mut lost = joined.clone();
    for k in 0..60 {
        let sp = if k % 20 == 0 { "5" } else { "" };
        let mode = if k == 0 { "AUTO" } else { "" };
        let op = if k % 3 == 0 { "50" } else { "" };
        let _ = write!(joined, "{k},{},{sp},,{mode}\n{k}.2,,,{},\n", k % 7, 50 + k % 5);
        let _ = writeln!(rates, "{k},{},{sp},{op},{mode}", k % 7);
        let pv = if k % 9 == 4 { String::new() } else { (k % 7).to_string() };
        let _ = writeln!(lost, "{k},{pv},5,50,AUTO");
    }
    let reading = read(&joined);
    let one = &reading.recordings[0];
    let pv = one.pv.as_ref().unwrap();
    assert_eq!(
        (pv.time.len(), one.op.time.len(), one.sp.as_ref().unwrap().time.len()),
        (60, 60, 3)
    );
    assert_eq!((pv.time[1], one.op.time[1], pv.usable_share()), (1.0, 1.2, 1.0));
    assert_eq!(one.mode.as_ref().unwrap().modes, [Mode::Automatic]);
    let note = "empty cells of \"FIC1.OP\", \"FIC1.PV\", \"FIC1.SP\" do not count as missing";
    assert!(said(&reading).contains(note), "{}", said(&reading));
    // Two rates in one table.
    let reading = read(&rates);
    let one = &reading.recordings[0];
    assert_eq!((one.op.time.len(), one.op.time[1]), (20, 3.0));
    // Samples that are missing in a regular table stay so.
    let reading = read(&lost);
    let pv = reading.recordings[0].pv.as_ref().unwrap();
    assert_eq!(pv.quality.iter().filter(|quality| **quality == Quality::Missing).count(), 7);
    assert!(!said(&reading).contains("not count as missing"), "{}", said(&reading));
}

#[test]
fn names_that_repeat_belong_to_the_column_on_their_left() {
    let text = "Time,FC1.DACA.PV,Conf,FC1.PIDA.OP,Conf,FC1.PIDA.SP,Conf,FC1.PIDA.MODE\n\
                0,1,100,50,100,5,100,AUTO\n1,2,0,51,100,5,100,AUTO\n";
    assert_eq!(all(text), "FC1.PIDA PV 0:1 1:b SP 0:5 1:5 OP 0:50 1:51");
    let ignored = with(text, &["ignore=Conf"]).unwrap();
    assert_eq!(shown(&ignored.recordings[0]), "FC1.PIDA PV 0:1 1:2 SP 0:5 1:5 OP 0:50 1:51");
    let one = with(text, &["ignore=Conf (column 3)"]).unwrap();
    assert_eq!(shown(&one.recordings[0]), "FC1.PIDA PV 0:1 1:2 SP 0:5 1:5 OP 0:50 1:51");
    let words = "t;PV;Quality;OP;Quality\n0;1;Good;50;Good\n1;2;Good;51;Bad\n";
    assert_eq!(all(words), "f PV 0:1 1:2 OP 0:50 1:b");
    // What is left is renamed, and a message says how to choose.
    let twice = "t,op,pv,op\n0,50,1,60\n1,51,2,61\n";
    let message = refused(twice, &[]);
    assert!(message.contains("map op=op (column 2)"), "{message}");
    let chosen = with(twice, &["op=op (column 2)", "ignore=op (column 4)"]).unwrap();
    assert_eq!(shown(&chosen.recordings[0]), "f PV 0:1 1:2 OP 0:50 1:51");
    let chosen = with(twice, &["op=op (column 2)"]).unwrap();
    assert_eq!(shown(&chosen.recordings[0]), "f PV 0:1 1:2 OP 0:50 1:51");
}

#[test]
fn qualities_in_front_of_their_signals_are_noted() {
    let text = |header: &str| format!("{header}\n0,Bad,1,Good,50\n1,Good,2,Good,51\n");
    let reading = read(&text("Time,Status,FIC1.PV,Status,FIC1.OP"));
    assert_eq!(shown(&reading.recordings[0]), "FIC1 PV 0:b 1:2 OP 0:50 1:51");
    let note = "\"Status (column 2)\" to \"Status (column 4)\" are interpreted as the qualities of the signals \
                on their right";
    assert!(said(&reading).contains(note), "{}", said(&reading));
    // One that has no signal on either side is named.
    let text = "Time,Status,FIC1.PV,Status,FIC1.OP,FIC1.SP\n0,Bad,1,Good,50,5\n1,Good,2,Bad,51,5\n";
    let reading = read(&text.replace("FIC1.PV,Status", "Note,Status"));
    let note = "\"Status (column 2)\" is not used, because \"Time\" on its left is not a signal";
    assert!(said(&reading).contains(note), "{}", said(&reading));
    assert!(said(&reading).contains("map pv_quality=Status (column 2)"), "{}", said(&reading));
}

#[test]
fn a_header_may_have_several_rows() {
    let rows = "2025-03-14 06:00:00,1,5,50\n2025-03-14 06:00:01,2,5,51\n";
    let expected = "FIC1 PV 0:1 1:2 SP 0:5 1:5 OP 0:50 1:51";
    for header in [
        "Time,FIC1.PV,FIC1.SP,FIC1.OP\n ,m3/h,m3/h,%\n ,Feed flow,Feed flow set,Feed valve\n",
        "Time,FIC1.PV,FIC1.SP,FIC1.OP\n ,Feed flow,Feed flow set,Feed valve\n ,m3/h,m3/h,%\n",
        "Tag,FIC1.PV,FIC1.SP,FIC1.OP\nDescription,Feed flow,Feed flow,Feed valve\nUnits,m3/h,m3/h,%\nRange,0 - 120,0 - 120,0 - 100\n",
        "Tag,FIC1.PV,FIC1.SP,FIC1.OP\nUnit,m3/h,m3/h,%\nLow,0,0,0\nHigh,120,120,100\n",
        "Honeywell Uniformance PHD,Excel Companion,,\nStart Time,14/03/2025 06:00:00,,\nSample Interval,1s,,\n,,,\nTime,FIC1.PV,FIC1.SP,FIC1.OP\n",
        "Report,Unit 7,March,all\nTime,FIC1.PV,FIC1.SP,FIC1.OP\n,,,\n",
        "Export of 14.03.2025\n\nTime,FIC1.PV,FIC1.SP,FIC1.OP\n\n\n",
        ",FIC1,,\nTime,PV,SP,OP\n",
        ",FIC1,FIC1,FIC1\nTime,PV,SP,OP\n",
        "Report of March,,,\n\n,FIC1.PV,FIC1.SP,FIC1.OP\n",
        "Timestamp,Feed flow,Feed flow,Feed valve\n,FIC1.PV,FIC1.SP,FIC1.OP\n",
    ] {
        let reading = read(&format!("{header}{rows}"));
        let own = reading.recordings.iter().map(shown).collect::<String>();
        assert_eq!(own, expected, "{header}");
    }
    let reading =
        read(&format!("Time,FIC1.PV,FIC1.SP,FIC1.OP\n ,Feed,Feed,Valve\n ,m3/h,m3/h,%\n{rows}"));
    assert!(
        said(&reading).contains("row 2 only describes the columns and is not read"),
        "{}",
        said(&reading)
    );
    assert_eq!(reading.recordings[0].pv.as_ref().unwrap().unit.as_deref(), Some("m3/h"));
    // Groups above names that repeat.
    let groups = ",FIC1,,LIC2,\nTime,PV,OP,PV,OP\n0,1,50,7,20\n1,2,51,8,21\n";
    assert_eq!(all(groups), "FIC1 PV 0:1 1:2 OP 0:50 1:51 | LIC2 PV 0:7 1:8 OP 0:20 1:21");
    // Words in the first samples are no header.
    assert_eq!(all("op,pv,t\nBad,Bad,0\n51,2,1\n"), "f PV 0:b 1:2 OP 0:b 1:51");
}

/// Rows of samples, from 0 on.
fn rows(count: usize) -> String {
    (0..count).map(|k| format!("{k},{},50\n", k % 7)).collect()
}

#[test]
fn lines_at_the_end_are_no_samples() {
    for end in [
        "End of data\n",
        "Total rows: 30\n",
        "(30 rows affected)\n",
        "--- end ---\n",
        "\n\nEnd of report,,\n",
        "$RT_COUNT$,30,\n",
        "Average,3.1,50\nMaximum,6,50\n",
    ] {
        let reading = read(&format!("t,pv,op\n{}{end}", rows(30)));
        assert_eq!(reading.recordings[0].op.values.len(), 30, "{end}");
        assert!(said(&reading).contains("at the end"), "{end}: {}", said(&reading));
    }
    let long = "\"VarName\";\"TimeString\";\"VarValue\";\"Validity\";\"Time_ms\"\n\
                \"FIC2112/PID.PV_IN#Value\";\"14.03.2025 06:00:00\";60,060;1;45730250000,000000\n\
                \"FIC2112/PID.LMN#Value\";\"14.03.2025 06:00:00\";44,970;1;45730250000,000000\n\
                \"$RT_COUNT$\";7200;\"\";\"\";\"\"\n";
    let reading = with(long, &["ignore=Validity"]).unwrap();
    assert_eq!(shown(&reading.recordings[0]), "FIC2112/PID PV 0:60.06 OP 0:44.97");
    // The last sample of a long table may have no value.
    let long = "tag,time,value\nA.OP,0,50\nA.PV,0,1\nA.OP,1,51\nA.PV,1,\n";
    assert_eq!(all(long), "A PV 0:1 1:m OP 0:50 1:51");
}

#[test]
fn a_torn_row_is_left_out_and_counted() {
    let whole = rows(200);
    let torn =
        whole.replacen("\n70,0,50\n", "\n70,0\n", 1).replacen("\n90,6,50\n", "\n90,6,50,7,8\n", 1);
    let reading = read(&format!("t,pv,op\n{torn}"));
    assert_eq!(reading.recordings[0].op.values.len(), 198);
    assert!(
        said(&reading).contains("2 rows do not have 3 cells and are not read: rows 72, 92"),
        "{}",
        said(&reading)
    );
    let last = read(&format!("t,pv,op\n{whole}200,"));
    assert_eq!(last.recordings[0].op.values.len(), 200);
    assert!(said(&last).contains("row 202, \"200\", has 2 cells instead of 3"), "{}", said(&last));
    // In many rows it is the delimiter that is wrong.
    let commas = whole.replace(",6,50\n", ",6,5,50\n");
    let message = refused(&format!("t,pv,op\n{commas}"), &[]);
    assert!(message.contains("row 8 has 4 cells, but the header has 3 columns"), "{message}");
    // Files that were put together repeat the header.
    let twice = read(&format!("t,pv,op\n{whole}t,pv,op\n200,1,50\n"));
    assert_eq!(twice.recordings[0].op.values.len(), 201);
    assert!(said(&twice).contains("one row repeats the header"), "{}", said(&twice));
}

#[test]
fn a_file_without_header_is_read_by_content_or_place() {
    let long = "10LCA2110.PV;14.03.2025 06:00:00;60,060\n10LCA2110.OP;14.03.2025 06:00:00;50\n\
                10LCA2110.PV;14.03.2025 06:00:01;60,5\n10LCA2110.OP;14.03.2025 06:00:01;51\n";
    assert_eq!(all(long), "10LCA2110 PV 0:60.06 1:60.5 OP 0:50 1:51");
    let wide = "2025-03-14 06:00:00;1,5;50\n2025-03-14 06:00:01;2,5;51\n";
    let message = refused(wide, &[]);
    assert!(
        message.contains("row 1 must name the columns, but reads \"2025-03-14 06:00:00;1,5;50\""),
        "{message}"
    );
    assert!(message.contains("map time=column 1 and map op=column 3"), "{message}");
    let told = with(wide, &["time=column 1", "pv=column 2", "op=column 3"]).unwrap();
    assert_eq!(shown(&told.recordings[0]), "f PV 0:1.5 1:2.5 OP 0:50 1:51");
}

#[test]
fn tags_are_matched_across_words() {
    for (header, name) in [
        (
            "t,\"Area A: FIC2106 Flow PV (m3/h)\",\"Area A: FIC2106 Flow SP (m3/h)\",\"Area A: FIC2106 Valve Output (%)\"",
            "Area A: FIC2106",
        ),
        ("t,FIC7_Flow_PV,FIC7_Flow_SP,FIC7_Valve_OP", "FIC7"),
        ("t,U1/FIC-7 PV,U1/FIC-7 Setpoint,U1/FIC-7 Valve OUT", "U1/FIC-7"),
        ("t,Mesure,Consigne,Sortie régulateur", "f"),
        ("t,Medida (m3/h),Consigna (m3/h),Salida (%)", "f"),
        ("t,Misura,Setpoint,Uscita", "f"),
        ("t,Durchfluss Istwert [m³/h],Durchfluss Sollwert [m³/h],Stellgröße [%]", "Durchfluss"),
        ("t,FIC2105_PV,FIC2105_SP,FIC2105_OUT", "FIC2105"),
    ] {
        let expected = format!("{name} PV 0:1 1:2 SP 0:5 1:5 OP 0:50 1:51");
        assert_eq!(all(&format!("{header}\n0,1,5,50\n1,2,5,51\n")), expected, "{header}");
    }
    // Two PVs of one tag, and another block, are not joined; what is not used is said at the loop.
    let two = "t,FIC7 Flow PV,FIC7 Pressure PV,FIC7 Valve OP\n0,1,5,50\n1,2,6,51\n";
    let reading = read(two);
    assert_eq!(shown(&reading.recordings[0]), "FIC7 Valve OP 0:50 1:51");
    let note = "the loop has no PV, while \"FIC7 Flow PV\", \"FIC7 Pressure PV\" are not used";
    assert!(reading.recordings[0].notes.iter().any(|own| own.contains(note)), "{}", said(&reading));
    let told = with(two, &["FIC7 Valve.pv=FIC7 Flow PV"]).unwrap();
    assert_eq!(shown(&told.recordings[0]), "FIC7 Valve PV 0:1 1:2 OP 0:50 1:51");
    assert_eq!(all("t,FIC7/AI1.PV,FIC7/PID1.OP\n0,1,50\n1,2,51\n"), "FIC7/PID1 OP 0:50 1:51");
}

#[test]
fn tables_of_historians_are_known() {
    let wonderware = "DateTime,TagName,Value,vValue,Quality,QualityDetail,OPCQuality\n\
                      2025-03-14 06:00:00.000,FIC1_PV,1,1,0,192,192\n2025-03-14 06:00:00.000,FIC1_OUT,50,50,0,192,192\n\
                      2025-03-14 06:00:01.000,FIC1_PV,2,2,1,24,24\n";
    assert_eq!(all(wonderware), "FIC1 PV 0:1 1:b OP 0:50");
    let aspen = "NAME,IP_TREND_TIME,IP_TREND_VALUE\nFIC1.PV,2025-03-14 06:00:00,1\nFIC1.OP,2025-03-14 06:00:00,50\n";
    assert_eq!(all(aspen), "FIC1 PV 0:1 OP 0:50");
}
