//! What cannot be understood: exit code 2, nothing on standard output, and a message that names the
//! place and what would be right.

use crate::{folder, run, write};
use std::path::Path;

/// Runs the command, which must refuse with a message that contains all of `expected`.
fn refuses(folder: &Path, arguments: &[&str], expected: &[&str]) {
    let done = run(folder, arguments);
    let err = &done.err;
    assert_eq!((done.code, done.out.as_str()), (2, ""), "{arguments:?}: {err}");
    assert!(err.starts_with("stiction: ") || err.starts_with("error: "), "{arguments:?}: {err}");
    for part in expected {
        assert!(err.contains(part), "{arguments:?} must say \"{part}\", but says: {err}");
    }
}

/// Runs the command with each line of arguments after `task`.
fn all_refuse(folder: &Path, task: &str, cases: &[(&str, &[&str])]) {
    for (line, expected) in cases {
        let arguments: Vec<&str> = task.split_whitespace().chain(line.split_whitespace()).collect();
        refuses(folder, &arguments, expected);
    }
}

#[test]
fn malformed_tables() {
    let folder = folder("malformed-tables");
    // Bytes of the file, and what the message says besides the file's name.
    let cases: &[(&[u8], &[&str])] = &[
        (b"", &["is empty; a header row and at least two rows are needed"]),
        (b"\n\r\n\n", &["is empty"]),
        (b"   \n", &["is empty"]),
        (b"\xef\xbb\xbf", &["is empty"]),
        (b"t,u\n", &["has no row below its header; add at least two rows"]),
        (b"t,u\n0,1\n", &["has one row below its header; add at least one row"]),
        (b"t,u\n0,NaN\n1,2\n", &["row 2, column \"u\": \"NaN\" is not a finite number"]),
        (b"t,u\n0,1\n1,inf\n", &["row 3, column \"u\": \"inf\" is not a finite number"]),
        (b"t,u\n0,1\n1,-Infinity\n", &["row 3, column \"u\"", "not a finite number"]),
        (b"t,u\n0,1\n1,1e999\n", &["row 3, column \"u\": \"1e999\""]),
        (b"t,u\n0,1\n1,high\n", &["row 3, column \"u\": \"high\"", "write numbers like 1.5"]),
        (b"t,u\n0,1\n1,0x10\n", &["row 3, column \"u\": \"0x10\""]),
        (b"t;u\n0;1,5\n1;2,5\n", &["row 2, column \"u\": \"1,5\"", "write numbers like 1.5"]),
        (b"t,u\n0,1\n1,\n", &["row 3, column \"u\": is empty; a number is needed"]),
        (b"t,u\n0,1\n1, \n", &["row 3, column \"u\": is empty"]),
        (b"t,v\n0,1\n1,2\n", &["has no column \"u\"; its columns are \"t\", \"v\""]),
        (b"t,U\n0,1\n1,2\n", &["has no column \"u\"; its columns are \"t\", \"U\""]),
        (b"t,u,u\n0,1,1\n1,2,2\n", &["has two columns named \"u\"; rename one"]),
        (b"t,u,,\n0,1,,\n1,2,,\n", &["has two columns named \"\"; rename one"]),
        (b"t,u\n0,1\n1\n", &["row 3 has 1 cells, but the header has 2 columns"]),
        (b"t,u\n0,1\n1,2,3\n", &["row 3 has 3 cells, but the header has 2 columns"]),
        (b"t,u\r\n0,1\r\n\r\n1,2,3\r\n", &["row 4 has 3 cells"]),
        (b"t,u\n0,1\n1,\xff\n", &["line 3 is not UTF-8 text; save the file as CSV in UTF-8"]),
        (b"\xff\xfet\0,\0u\0\n\0", &["line 1 is not UTF-8 text"]),
        (b"t,u\n0,1\n2,1\n1,1\n", &["row 4, column \"t\": the time 1 does not come after 2; sort"]),
        (b"t,u\n0,1\n1,1\n1,1\n", &["row 4, column \"t\": the time 1 does not come after 1"]),
        (b"Time,u\n1,1\n0,1\n", &["row 3, column \"Time\": the time 0 does not come after 1"]),
        (b"t,u\n0,1\nnan,1\n", &["row 3, column \"t\": \"nan\" is not a finite number"]),
        (b"time_s,u\n0,1\nlater,1\n", &["row 3, column \"time_s\": \"later\""]),
        (b"0,1\n1,2\n2,3\n", &["row 1 must name the columns, but reads \"0,1\"; add a header"]),
        (b"t,u,vp\n0,1,1\n1,2,1\n", &["has a column \"vp\" already; rename it"]),
        (b"t,u\r\n0,1\r\n\r\n1,x\r\n", &["row 4, column \"u\": \"x\""]),
        (b"t,u,note\n0,1,\"two\nlines\"\n1,x,\n", &["row 4, column \"u\": \"x\""]),
        (b"t,u\n0,\"1\n1,2\n", &["one row below its header"]),
        (b"\0\0\0\0\n\0\n\0\n", &["has no column \"u\""]),
        (b"{\"u\": [1, 2]}\n{}\n{}\n", &["row 2 has 1 cells, but the header has 2 columns"]),
    ];
    for (bytes, expected) in cases {
        write(&folder, "in.csv", bytes);
        let expected = [&["in.csv"], *expected].concat();
        refuses(&folder, &["valve", "--S", "5", "--J", "2", "in.csv"], &expected);
        refuses(&folder, &["valve", "--S", "5", "--J", "2", "in.csv", "-o", "out.csv"], &expected);
        assert!(!folder.join("out.csv").exists(), "nothing is written after a refusal");
    }
}

#[test]
fn malformed_valve_commands() {
    let folder = folder("malformed-valve");
    write(&folder, "in.csv", "u\n0\n10\n");
    let cases: &[(&str, &[&str])] = &[
        ("--S 5 --J 2 none.csv", &["none.csv: ", "No such file"]),
        ("--S 5 --J 2 .", &[".: "]),
        ("--S 5 --J 2", &["<INPUT>"]),
        ("--J 2 in.csv", &["model two-phase needs --S, in percent of span"]),
        ("--S 5 in.csv", &["model two-phase needs --J"]),
        ("--S -5 --J 2 in.csv", &["S is -5, but must be a finite number of at"]),
        ("--S 5 --J nan in.csv", &["J is NaN"]),
        ("--S inf --J 2 in.csv", &["S is inf"]),
        ("--S five --J 2 in.csv", &["invalid value 'five' for '--S"]),
        ("--S 5 --J 2 --start nan in.csv", &["--start is NaN"]),
        ("--S 5 --J 2 --column op in.csv", &["has no column \"op\""]),
        (
            "--model sticky --S 5 --J 2 in.csv",
            &["there is no valve model named \"sticky\"; known are two-phase, choudhury"],
        ),
        ("--model he-wang --S 2 --J 3 in.csv", &["J is 3, but must be at most S = 2"]),
        ("--model he --S 2 --J 1 --K 1.5 in.csv", &["--K is the overshoot of model he-wang only"]),
        ("--S 5 --J 2 in.csv -o no/folder/out.csv", &["no/folder/out.csv"]),
        ("--s 5 in.csv", &["unexpected argument '--s'"]),
    ];
    all_refuse(&folder, "valve", cases);
}

/// A loop of which `line` is added to the table `table`, and the line it then stands on.
fn with(table: &str, line: &str) -> (String, usize) {
    let mut lines: Vec<&str> = LOOP.lines().collect();
    let at = lines.iter().position(|of| *of == table).expect("the table") + 1;
    lines.insert(at, line);
    (lines.join("\n"), at + 1)
}

const LOOP: &str = "\
# A well-formed loop, to be spoilt.
sample_time = 0.1
duration = 10

[set_point]
value = 5

[controller]
kc = 1.1
ti = 2.5

[valve]
S = 5
J = 2

[process]
gain = 1.5
tau = 5.93
delay = 1.07

[[load]]
value = 1

[master]
every = 2

[master.controller]
kc = 1

[master.process]
gain = 1
tau = 5
";

#[test]
fn unknown_keys_are_pointed_at() {
    let folder = folder("unknown-keys");
    write(&folder, "good.toml", LOOP);
    run(&folder, &["simulate", "good.toml"]).quiet_success();
    // Table, line added to it, and the key as the message names it.
    let cases = [
        ("# A well-formed loop, to be spoilt.", "sampletime = 1", "sampletime"),
        ("# A well-formed loop, to be spoilt.", "tuning = { kc = 1 }", "tuning"),
        ("# A well-formed loop, to be spoilt.", "start = 1", "start"),
        ("[set_point]", "vlaue = 1", "set_point.vlaue"),
        ("[set_point]", "period = 1", "set_point.period"),
        ("[controller]", "Kc = 1.1", "controller.Kc"),
        ("[valve]", "s = 5", "valve.s"),
        ("[valve]", "\"\" = 5", "valve."),
        ("[valve]", "limits.low = 5", "valve.limits"),
        ("[process]", "theta = 1", "process.theta"),
        ("[process]", "tau2 = 1", "process.tau2"),
        ("[[load]]", "sd = 1", "load.sd"),
        ("[[load]]", "\"größe\" = 1", "load.größe"),
        ("[master]", "evry = 1", "master.evry"),
        ("[master.controller]", "kx = 1", "master.controller.kx"),
        ("[master.process]", "lag = 1", "master.process.lag"),
    ];
    for (table, line, key) in cases {
        let (text, at) = with(table, line);
        write(&folder, "bad.toml", text);
        let place = format!("bad.toml, line {at}: ");
        let message = match line {
            "limits.low = 5" => "valve.limits: must be a list of numbers".to_owned(),
            _ => format!("unknown key \"{key}\"; known here are "),
        };
        refuses(&folder, &["simulate", "bad.toml"], &[&(place + &message)]);
    }
    // A misspelt required key or table is not just missing.
    for (right, wrong) in [
        ("sample_time", "sample_tim"),
        ("kc", "Kc"),
        ("[controller]", "[contoller]"),
        ("[valve]", "[vlave]"),
        ("[[load]]", "[[laod]]"),
        ("gain", "gian"),
    ] {
        let line = LOOP.lines().position(|l| l.split(' ').next() == Some(right)).expect("it") + 1;
        write(&folder, "bad.toml", LOOP.replacen(right, wrong, 1));
        let key = wrong.trim_matches(['[', ']']);
        refuses(&folder, &["simulate", "bad.toml"], &[&format!("line {line}: unknown key"), key]);
    }
}

#[test]
fn malformed_scenarios() {
    let folder = folder("malformed-scenarios");
    // What in the good scenario is replaced by what, the line of the error, and its message.
    let cases = [
        // Not TOML.
        ("duration = 10", "duration 10", 3, "expected `=`"),
        ("duration = 10", "duration = ", 3, "string values must be quoted"),
        ("duration = 10", "duration = 10\nduration = 10", 4, "duplicate key"),
        ("[valve]", "[valve", 12, "unclosed table"),
        ("[process]", "[valve]", 16, "duplicate key"),
        // Wrong types.
        ("duration = 10", "duration = \"10\"", 3, "duration: must be a finite number"),
        ("duration = 10", "duration = 2020-01-01", 3, "duration: must be a finite number"),
        ("S = 5", "S = [5]", 13, "valve.S: must be a finite number"),
        ("S = 5", "S = true", 13, "valve.S: must be a finite number"),
        ("S = 5", "model = 5\nS = 5", 13, "valve.model: must be a text in quotes"),
        ("S = 5", "limits = 100\nS = 5", 13, "valve.limits: must be a list of numbers"),
        ("S = 5", "limits = [0, \"x\"]\nS = 5", 13, "valve.limits: must be a list of numbers"),
        ("S = 5", "limits = [0, 50, 100]\nS = 5", 13, "valve.limits: must be two numbers"),
        ("[set_point]\nvalue = 5", "set_point = 5", 5, "must be a table, [set_point]"),
        ("every = 2", "every = 1.5", 25, "every: is 1.5, but must be a whole number"),
        ("every = 2", "every = -1", 25, "every: is -1, but must be a whole number"),
        ("every = 2", "every = 0", 25, "every: is 0 samples, but must be at least 1"),
        ("every = 2", "every = 1e300", 25, "must be a whole number"),
        // Not finite.
        ("S = 5", "S = nan", 13, "valve.S: must be a finite number"),
        ("S = 5", "S = -inf", 13, "valve.S: must be a finite number"),
        ("S = 5", "S = 1e999", 13, "valve.S: must be a finite number"),
        ("S = 5", "S = 99999999999999999999", 13, "valve.S: must be a finite number"),
        // Missing.
        ("sample_time = 0.1\n", "", 1, "sample_time: is missing; give a number"),
        ("kc = 1.1\n", "", 8, "controller.kc: is missing; give the gain"),
        ("ti = 2.5", "td = 2.5", 8, "controller.ti: is missing, but td is given"),
        ("S = 5\n", "", 12, "valve.S: is missing; give percent of span"),
        ("gain = 1.5\n", "", 16, "process.gain: is missing; give a number"),
        ("value = 5", "signal = \"sine\"", 5, "set_point.amplitude: is missing"),
        ("value = 5", "signal = \"steps\"", 5, "set_point.steps: is missing; list [time, value]"),
        ("[process]\ngain = 1.5\ntau = 5.93\ndelay = 1.07\n", "", 1, "process: is missing; add"),
        ("[valve]\nS = 5\nJ = 2\n", "", 1, "valve: is missing; add a table [valve]"),
        // Out of range.
        ("sample_time = 0.1", "sample_time = 0", 2, "sample_time: is 0 s; it must be above 0"),
        ("sample_time = 0.1", "sample_time = -1", 2, "sample_time: is -1 s; it must be above 0"),
        ("sample_time = 0.1", "sample_time = nan", 2, "sample_time: must be a finite number"),
        ("duration = 10", "duration = 1e12", 3, "duration: gives 10000000000000 samples"),
        ("duration = 10", "duration = 1e308", 3, "samples, but must give between 2 and 100000000"),
        ("duration = 10", "duration = -1", 3, "duration: gives -10 samples"),
        ("duration = 10", "duration = 0.1", 3, "duration: gives 1 samples"),
        ("S = 5", "S = -5", 13, "S is -5, but must be a finite number of at least 0"),
        ("S = 5", "model = \"he-wang\"\nS = 1", 15, "J is 2, but must be at most S = 1"),
        ("S = 5", "model = \"he-wang\"\nK = 3\nS = 5", 14, "K is 3, but must be between 1"),
        ("S = 5", "K = 1.5\nS = 5", 13, "K: is the overshoot of model \"he-wang\" only"),
        ("S = 5\nJ = 2", "fs = 1\nfd = 2", 14, "fd is 2, but must be between -1 and fs = 1"),
        ("S = 5", "fs = 1\nS = 5", 12, "[valve]: give either S and J, or fs and fd"),
        ("S = 5", "limits = [100, 0]\nS = 5", 12, "the lower limit of the valve is 100"),
        ("S = 5", "lag = -1\nS = 5", 13, "valve.lag: stem lag is -1"),
        ("S = 5", "rest_tolerance = -1\nS = 5", 13, "rest_tolerance: rest tolerance is -1"),
        ("kc = 1.1", "limits = [5, 5]\nkc = 1", 8, "the lower limit of the controller output is 5"),
        ("kc = 1.1", "anti_windup = \"none\"\nkc = 1", 8, "limits: is missing"),
        ("kc = 1.1", "kp = 1\nkc = 1", 8, "give either kc, ti, td (ISA form) or kp, ki, kd"),
        ("ti = 2.5", "ti = 0", 10, "Ti is 0, but must be a finite number above 0"),
        ("tau = 5.93", "tau = -1", 16, "process time constant is -1"),
        ("delay = 1.07", "delay = -1", 16, "process dead time is -1"),
        ("delay = 1.07", "delay = 1e300", 1, "more than 10 million samples"),
        ("value = 5", "signal = \"steps\"\nsteps = []", 5, "at least one (time, value) pair"),
        ("value = 5", "signal = \"steps\"\nsteps = [[2, 0], [1, 0]]", 5, "must ascend, but 1 s"),
        ("value = 5", "signal = \"steps\"\nsteps = [[2, 0, 1]]", 7, "list of [time, value] pairs"),
        ("value = 5", "signal = \"steps\"\nsteps = 5", 7, "must be a list of [time, value] pairs"),
        ("value = 5", "signal = \"sine\"\namplitude = 1\nperiod = 0", 8, "period is 0"),
        ("value = 5", "signal = \"noise\"\nsd = -1", 5, "standard deviation is -1"),
        ("[master]", "[resolution]\nop = -1\n[master]", 25, "resolution.op: is -1, but must be"),
        // Unknown names.
        ("S = 5", "model = \"sticky\"\nS = 5", 13, "no valve model named \"sticky\"; known are"),
        ("gain = 1.5", "type = \"third-order\"\ngain = 1", 17, "must be one of \"first-order\""),
        (
            "value = 5",
            "signal = \"sin\"",
            6,
            "is \"sin\", but must be one of \"constant\", \"sine\"",
        ),
        ("value = 5", "signal = \"file\"\nfile = \"no.csv\"\ncolumn = \"u\"", 7, "no.csv: "),
        (
            "gain = 1.5\ntau = 5.93",
            "type = \"transfer-function\"\nnum = [1, 2, 3]\nden = [1, 2]",
            16,
            "between 1 and 2, as many as the denominator",
        ),
        (
            "gain = 1.5\ntau = 5.93",
            "type = \"transfer-function\"\nnum = [1]\nden = [0, 2]",
            16,
            "leading coefficient other than 0",
        ),
    ];
    for (original, spoilt, line, message) in cases {
        assert!(LOOP.contains(original), "{original}");
        write(&folder, "bad.toml", LOOP.replacen(original, spoilt, 1));
        let place = format!("stiction: bad.toml, line {line}: ");
        refuses(&folder, &["simulate", "bad.toml"], &[&place, message]);
        refuses(&folder, &["simulate", "bad.toml", "--print"], &[&place, message]);
    }

    let texts: &[(&[u8], &[&str])] = &[
        (b"", &["line 1: sample_time: is missing"]),
        (
            b"sample_time = 1\nduration = 9\n",
            &["simulates nothing; add [controller] and [process]"],
        ),
        (b"title = 'a'\n# \xe4\n", &["line 2: is not UTF-8 text; save the file in UTF-8"]),
        (b"\0", &["line 1"]),
        (b"a = [[[[", &["line 1"]),
    ];
    for (text, expected) in texts {
        write(&folder, "bad.toml", text);
        refuses(&folder, &["simulate", "bad.toml"], expected);
    }
    for deep in ["a = ".to_owned() + &"[".repeat(100_000), "[".to_owned() + &"a.".repeat(100_000)] {
        write(&folder, "bad.toml", deep);
        refuses(&folder, &["simulate", "bad.toml"], &["bad.toml, line 1: "]);
    }
}

#[test]
fn malformed_simulate_commands() {
    let folder = folder("malformed-simulate");
    write(&folder, "loop.toml", LOOP);
    let cases: &[(&str, &[&str])] = &[
        ("", &["<SCENARIO>"]),
        ("paper/no-such", &["no scenario file or built-in", "built-in scenarios are paper"]),
        (".", &[".: "]),
        ("loop.toml --set valve.S", &["--set valve.S: is not of the form key=value"]),
        ("loop.toml --set =4", &["--set =4: the key is incomplete"]),
        ("loop.toml --set valve.=4", &["--set valve.=4: the key is incomplete"]),
        ("loop.toml --set valve.Q=4", &["--set valve.Q=4: unknown key \"valve.Q\""]),
        ("loop.toml --set wat=4", &["--set wat=4: unknown key \"wat\"; known here are"]),
        ("loop.toml --set valve.S=-4", &["--set valve.S=-4: ", "S is -4"]),
        ("loop.toml --set valve.S=four", &["valve.S: must be a finite number"]),
        ("loop.toml --set valve.S=", &["valve.S: must be a finite number"]),
        ("loop.toml --set valve.S.x=1", &["\"S\" is a value, not a table"]),
        ("loop.toml --set valve=1", &["valve: must be a table, [valve]"]),
        ("loop.toml --set load.7.value=1", &["\"load\" has 1 tables; count them from"]),
        ("loop.toml --set load.value=1", &["\"load\" has 1 tables; count them from"]),
        ("loop.toml --set noise.0.sd=1", &["noise: must be a table, [noise]"]),
        ("loop.toml --plot run.gif", &["--plot run.gif: the file must end in .svg"]),
        ("loop.toml -o no/run.csv", &["no/run.csv: "]),
        ("loop.toml --plot no/run.svg", &["no/run.svg: "]),
        ("loop.toml --frobnicate", &["unexpected argument '--frobnicate'"]),
        (
            "loop.toml --set controller.kc=1e99 --set controller.ti=1e-99",
            &["overflows at t = ", "the system is unstable"],
        ),
    ];
    all_refuse(&folder, "simulate", cases);
    write(&folder, "short.csv", "t,u\n0,1\n1,2\n");
    let input = "sample_time = 1\nduration = 9\n[valve]\nS = 5\nJ = 2\n[input]\nsignal = \"file\"\n\
                 file = \"short.csv\"\n";
    for (column, expected) in [
        ("column = \"u\"", "line 6: [input]: signal has 2 samples, but 9 are needed"),
        ("column = \"v\"", "line 8: input.file: short.csv: has no column \"v\""),
        ("", "line 6: input.column: is missing; name a column"),
    ] {
        write(&folder, "file.toml", format!("{input}{column}\n"));
        refuses(&folder, &["simulate", "file.toml"], &[expected]);
    }
}

#[test]
fn malformed_stem_and_figure_commands() {
    let folder = folder("malformed-stem");
    write(&folder, "op.csv", "t,u\n0,1\n2,1\n1,1\n");
    write(&folder, "untimed.csv", "k,u\n0,1\n1,1\n");
    write(&folder, "file", "");
    let cases: &[(&str, &[&str])] = &[
        (
            "stem --parameters none",
            &["there is no stem parameter set named \"none\"; known are cts"],
        ),
        ("stem --friction glue", &["glue", "known are classical"]),
        ("stem --parameters mass_kg", &["no stem parameter set named"]),
        ("stem --set mass_kg=heavy", &["--set mass_kg=heavy: write NAME=VALUE"]),
        (
            "stem --set colour=1",
            &["there is no stem parameter named \"colour\"; known are mass_kg"],
        ),
        ("stem --set mass_kg=-1", &["-1, but must be"]),
        ("stem --set mass_kg=nan", &["NaN, but must be"]),
        ("stem --period 0", &["makes 1 samples"]),
        ("stem --period -1", &["samples, but between 2 and"]),
        ("stem --period nan", &["NaN samples"]),
        ("stem --sample-time 0", &["inf samples, but between 2 and"]),
        ("stem --sample-time 1e-9", &["but between 2 and 100 million are allowed"]),
        ("stem --amplitude inf", &["amplitude is inf"]),
        ("stem --input op.csv", &["row 4, column \"t\": the time 1 does not come after 2"]),
        ("stem --input untimed.csv", &["has no column \"t\"; its columns are"]),
        ("stem --input none.csv", &["none.csv: "]),
        ("stem --column u", &["--input"]),
        ("stem --signal triangle", &["possible values: ramp, sine"]),
        ("figures --output file", &["file: "]),
        ("figures now", &["unexpected argument 'now'"]),
        ("detect", &["unrecognized subcommand 'detect'"]),
    ];
    all_refuse(&folder, "", cases);
}
