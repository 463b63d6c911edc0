//! `stiction inspect`.

use crate::{folder, refuses, run, write};

const WIDE: &str = "Time;FIC1.PV [m3/h];FIC1.OP;FIC1.MODE;Room\r\n\
                    27.10.2024 02:30:00;1,5;50;AUTO;21\r\n\
                    27.10.2024 02:45:00;Bad;51;MAN;21\r\n\
                    27.10.2024 02:00:00;1,7;52,5;AUTO;21\r\n";

#[test]
fn inspect_shows_what_is_taken_for_what() {
    let folder = folder("inspect");
    write(&folder, "wide.csv", WIDE);
    let out = run(&folder, &["inspect", "wide.csv", "--zone", "Europe/Berlin"]).quiet_success();
    let (before, rest) = out.split_once("  sha256  ").expect("the hash");
    let (hash, rest) = rest.split_at(64);
    assert!(hash.bytes().all(|b| b.is_ascii_hexdigit()), "{hash}");
    assert_eq!(before, "wide.csv\n  format  CSV, UTF-8, delimiter semicolon, decimal mark ,\n");
    let expected = "
  layout  one loop, one column per signal
loop FIC1, flow
  times   \"Time\", date and time, day first, Europe/Berlin, 2024-10-27 02:30:00+02:00 to 2024-10-27 02:00:00+01:00, \
every 900 s, no segment in automatic
          1 from 2024-10-27 02:45:00+02:00 on: the recording is cut where the controller was not in command
  column          signal  unit  values                 range                       samples
  FIC1.OP         OP      –     50 to 52.5             0 to 100, taken as percent  3
  FIC1.PV [m3/h]  PV      m3/h  1.5 to 1.7             –                           2 of 3
                  1 bad
                  1 from 2024-10-27 02:45:00+02:00 on: runs of up to 3 missing samples were bridged
  FIC1.MODE       mode    –     2 automatic, 1 manual  –                           3
columns
  Time            time          its name is a word for time
  FIC1.PV [m3/h]  PV of FIC1    it ends with PV, a word for PV
  FIC1.OP         OP of FIC1    it ends with OP, a word for OP
  FIC1.MODE       mode of FIC1  it ends with MODE, a word for mode
  Room            not used      it is not the name of a signal of a loop
note: \"Room\" holds numbers and is not used, while loop FIC1 has no SP, no VP; if one of them is a missing signal, \
assign the signal, as in --map \"sp=Room\"
note: from row 2 on, Europe/Berlin has an hour twice in autumn; by the order of the rows, 2 rows count \
as its first pass and 1 as its second
";
    assert_eq!(rest, expected);
}

#[test]
fn inspect_tells_the_same_as_json() {
    let folder = folder("inspect-json");
    write(&folder, "wide.csv", WIDE);
    write(&folder, "one.csv", "t,mv\n0,0.5\n1,0.25\n");
    let arguments =
        ["inspect", "wide.csv", "one.csv", "--json", "--pv-range", "-1,3", "--type", "level"];
    let all = run(&folder, &arguments).json();
    let wide = &all["files"][0];
    assert_eq!(wide["delimiter"], ";");
    assert_eq!(wide["columns"][2]["role"], "OP");
    assert_eq!(wide["columns"][2]["loop"], "FIC1");
    assert_eq!(wide["loops"][0]["type"], "level");
    assert_eq!(wide["loops"][0]["signals"]["pv"]["quality"]["bad"], 1);
    assert_eq!(wide["loops"][0]["signals"]["pv"]["range"]["low"], -1.0);
    assert_eq!(wide["loops"][0]["signals"]["pv"]["unit"], "m3/h");
    let one = &all["files"][1]["loops"][0];
    assert_eq!(one["name"], "one");
    assert_eq!(one["signals"]["op"]["range"]["high"], 1.0);
    assert_eq!(one["signals"]["op"]["range"]["source"], "estimated");
    assert_eq!(one["start_s"], serde_json::Value::Null);
}

#[test]
fn a_wrong_interpretation_can_be_corrected() {
    let folder = folder("inspect-options");
    write(
        &folder,
        "odd.csv",
        "zeit,y,ist,stellung\n05/06/2024 00:00,5,weg,4\n05/06/2024 00:01,6,2,5\n",
    );
    let given = ["inspect", "odd.csv", "--map", "FIC9.vp=stellung", "--map", "FIC9.pv=ist"];
    let more = ["--map", "FIC9.op=y", "--time-format", "day-first", "--bad-text", "weg"];
    let out = run(&folder, &[&given[..], &more[..]].concat()).quiet_success();
    for part in
        ["loop FIC9, flow", "1 of 2\n            1 bad", "stellung  VP", "2024-06-05 00:01:00"]
    {
        assert!(out.contains(part), "{part}: {out}");
    }
    let mapping = "time_format = \"day-first\"\nbad_text = [\"weg\"]\n[loop.FIC9]\npv = \"ist\"\nop = \"y\"\n\
                   vp = \"stellung\"\n";
    write(&folder, "map.toml", mapping);
    assert_eq!(run(&folder, &["inspect", "odd.csv", "--mapping", "map.toml"]).quiet_success(), out);
    // Beside the recording it need not be named; what is named holds in its place, and it can be left out.
    write(&folder, "odd.csv.mapping.toml", mapping);
    let beside = run(&folder, &["inspect", "odd.csv"]);
    assert_eq!((beside.code, &beside.out), (0, &out));
    assert!(beside.err.contains("odd.csv.mapping.toml (--no-config ignores it)"), "{}", beside.err);
    assert_eq!(run(&folder, &["inspect", "odd.csv", "--mapping", "map.toml"]).quiet_success(), out);
    assert_ne!(run(&folder, &["inspect", "odd.csv", "--no-config"]).code, 0);
    // A mapping that is damaged stops the file it is of, and no other.
    write(&folder, "odd.csv.mapping.toml", "zon = 1");
    write(&folder, "even.csv", "t,op,pv\n0,1,2\n1,2,3\n2,1,2\n");
    let judged = run(&folder, &["diagnose", "odd.csv", "even.csv"]);
    assert!(judged.err.contains("odd.csv.mapping.toml, line 1"), "{}", judged.err);
    assert!(judged.out.contains("even"), "{}", judged.out);
}

#[test]
fn what_cannot_be_read_is_refused() {
    let folder = folder("inspect-refusals");
    write(&folder, "text.csv", "t,op\n0,50\n1,Kaputt\n");
    write(&folder, "map.toml", "\nzon = \"UTC\"\n");
    write(&folder, "pv.csv", "t,pv\n0,50\n");
    for (arguments, expected) in [
        (&["text.csv"][..], "text.csv, row 3, column \"op\": \"Kaputt\""),
        (&["none.csv"], "none.csv: "),
        (&["pv.csv"], "name the column, as in --map op=COLUMN"),
        (&["pv.csv", "--mapping", "map.toml"], "map.toml, line 2: unknown key \"zon\""),
        (&["pv.csv", "--map", "op=out"], "has no column \"out\", which is given as OP"),
        (&["pv.csv", "--map", "opp=pv"], "\"opp\" is not a role; roles are time, date, op"),
        (&["pv.csv", "--map", "op"], "not ROLE=COLUMN"),
        (&["pv.csv", "--map", "A.op_range=9,1"], "loop.A.op_range: must be two numbers"),
        (&["pv.csv", "--map", "modes.16=car"], "modes.16: is \"car\", but must be one of"),
        (&["pv.csv", "pv.csv", "--write-map", "m.toml"], "name only one"),
        (&["pv.csv", "--zone", "Berlin"], "\"Berlin\" is not a time zone"),
        (&["pv.csv", "--time-format", "iso"], "\"iso\" is not a time format"),
        (&["pv.csv", "--op-range", "100,0"], "the lower one first, such as 0,100"),
        (&["pv.csv", "--sample-time", "0"], "must be a number above 0"),
        (&["pv.csv", "--type", "flo"], "flow, level"),
    ] {
        refuses(&folder, &[&["inspect"], arguments].concat(), expected);
    }
}

#[test]
fn a_missing_file_is_reported_once() {
    let folder = folder("inspect-missing-file");
    for command in ["diagnose", "history", "inspect"] {
        let refused = run(&folder, &[command, "none.csv"]).refusal();
        assert_eq!(refused.matches("os error 2").count(), 1, "{refused}");
        assert!(refused.starts_with("stiction: none.csv: "), "{refused}");
    }
}

/// The files of a folder, in order, that have names of recordings.
#[test]
fn a_folder_stands_for_its_recordings() {
    let folder = folder("inspect-folder");
    std::fs::create_dir(folder.join("data")).unwrap();
    for name in ["b.csv", "a.csv"] {
        std::fs::copy(
            crate::diagnose::samples().join("FIC101-sticky.csv"),
            folder.join("data").join(name),
        )
        .unwrap();
    }
    write(&folder, "data/readme.md", "# not a recording\n");
    let shown = run(&folder, &["inspect", "data", "--json"]).json();
    let files: Vec<&str> = shown["files"]
        .as_array()
        .unwrap()
        .iter()
        .map(|file| file["file"].as_str().unwrap())
        .collect();
    assert_eq!(files.len(), 2, "{files:?}");
    assert!(files[0].ends_with("a.csv") && files[1].ends_with("b.csv"), "{files:?}");
    let found = run(&folder, &["diagnose", "data", "--brief"]).quiet_success();
    assert!(found.contains("sticks"), "{found}");
    refuses(&folder, &["diagnose", "data", "--csv", "data/a.csv"], "a.csv");
}

/// What the operating system refuses has a remedy, and what a mapping names wrongly its file.
#[test]
fn refusals_name_the_file_and_what_helps() {
    let folder = folder("inspect-remedies");
    write(&folder, "a.csv", "t,op\n0,50\n1,51\n2,52\n");
    write(&folder, "map.toml", "[columns]\nOUT = \"op\"\n");
    std::fs::create_dir(folder.join("data")).unwrap();
    for (arguments, expected) in [
        (&["inspect", "a.csv", "--mapping", "map.toml"][..], "which is given as OP (in map.toml)"),
        (&["inspect", "a.csv", "--mapping", "no.toml"], "; correct the name"),
        (&["inspect", "none.csv"], "; correct the name"),
        #[cfg(unix)]
        (&["inspect", "data"], "data: no file in this folder has the name of a recording"),
        #[cfg(unix)]
        (&["inspect", "a.csv/b.csv"], "a file where a folder is needed, so correct the path"),
        (
            &["diagnose", "a.csv", "--report", "a.csv/pages"],
            "a.csv: is a file, but must be a folder",
        ),
        (&["man", "a.csv"], "a.csv: is a file, but must be a folder"),
    ] {
        refuses(&folder, arguments, expected);
    }
}

/// Whatever a mapping file can say, the command line can, too.
#[test]
fn every_key_of_a_mapping_file_can_be_given() {
    let folder = folder("inspect-settings");
    let rows = "t,A.OP,A.PV,A.MODE,B.OP,B.Quality\n0,5,1,16,50,0\n1,6,x,8,51,7\n2,7,3,16,52,0\n";
    write(&folder, "odd.csv", rows);
    let given = [
        "A.op_range=4,20",
        "A.pv_range=0,10",
        "B.type=level",
        "modes.16=auto",
        "modes.8=manual",
        "quality.0=good",
        "quality.7=bad",
        "bad_text=x",
        "time_format=seconds",
    ];
    let options = given.iter().flat_map(|each| ["--map", *each]);
    let arguments: Vec<&str> = ["inspect", "odd.csv"].into_iter().chain(options).collect();
    let out = run(&folder, &arguments).quiet_success();
    for part in [
        "5 to 7                 4 to 20, given",
        "1 to 3                 0 to 10, given",
        "2 automatic, 1 manual",
        "loop B, level",
    ] {
        assert!(out.contains(part), "{part}: {out}");
    }
    write(
        &folder,
        "map.toml",
        "bad_text = [\"x\"]\ntime_format = \"seconds\"\n[modes]\n16 = \"auto\"\n8 = \"manual\"\n[quality]\n\
         0 = \"good\"\n7 = \"bad\"\n[loop.A]\nop_range = [4, 20]\npv_range = [0, 10]\n[loop.B]\ntype = \"level\"\n",
    );
    assert_eq!(run(&folder, &["inspect", "odd.csv", "--mapping", "map.toml"]).quiet_success(), out);
    // What the command says goes before what the file says, and the last word before the first.
    let over = ["inspect", "odd.csv", "--mapping", "map.toml", "--map", "A.op_range=0,1"];
    let over = [&over[..], &["--map", "A.op_range=0,50"]].concat();
    assert!(run(&folder, &over).quiet_success().contains("0 to 50, given"));
}

#[test]
fn what_was_found_is_written_and_read_again() {
    let folder = folder("inspect-write-map");
    write(&folder, "wide.csv", WIDE);
    let wrote = run(&folder, &["inspect", "wide.csv", "--write-map", "map.toml"]);
    assert_eq!(
        (wrote.code, &*wrote.err),
        (0, "note: wrote map.toml; give this file to --mapping\n")
    );
    let mapping = crate::read(&folder, "map.toml");
    assert!(mapping.contains("op_range = [0, 100]  # taken as percent"), "{mapping}");
    let read = run(&folder, &["inspect", "wide.csv", "--mapping", "map.toml"]).quiet_success();
    assert!(read.contains("0 to 100, given") && !read.contains("note:"), "{read}");
    // A person may have corrected it.
    let refused = run(&folder, &["inspect", "wide.csv", "--write-map", "map.toml"]).refusal();
    assert!(refused.contains("map.toml exists already; --force overwrites it"), "{refused}");
    run(&folder, &["inspect", "wide.csv", "--write-map", "map.toml", "--force"]);
    assert_eq!(crate::read(&folder, "map.toml"), mapping);
    let printed = run(&folder, &["inspect", "wide.csv", "--write-map", "-"]).quiet_success();
    assert_eq!(printed, mapping);
}
