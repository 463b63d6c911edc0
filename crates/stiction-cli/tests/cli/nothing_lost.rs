//! No run destroys what it reads or what was there: inputs, other outputs, full disks, kills.

use crate::diagnose::{samples, with_samples};
use crate::outputs::OUTPUTS as ARGUMENTS;
use crate::{command, folder, read, refuses, run, write};
use std::collections::BTreeMap;
use std::path::Path;
use std::process::Command;
use std::time::Duration;

const FILE: &str = "FIC101-sticky.csv";

/// The files of a folder and the folders in it, with what they hold; less those that a killed run left behind.
fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut found = BTreeMap::new();
    for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
        let name = entry.file_name().into_string().expect("UTF-8");
        if entry.path().is_dir() {
            found.extend(files(&entry.path()).into_iter().map(|(k, v)| (format!("{name}/{k}"), v)));
        } else if !is_left_over(&name) {
            found.insert(name, std::fs::read(entry.path()).expect("a file"));
        }
    }
    found
}

/// Whether a name is that of a file that was not ended.
fn is_left_over(name: &str) -> bool {
    name.starts_with(".stiction-") && name.ends_with(".part")
}

#[test]
fn an_output_that_is_an_input_is_refused_by_every_command() {
    let folder = with_samples("output-is-input");
    std::fs::hard_link(folder.join(FILE), folder.join("hard.csv")).expect("a link");
    std::fs::create_dir(folder.join("sub")).expect("a folder");
    write(&folder, "in.csv", "t,u\n0,1\n1,2\n2,3\n");
    write(&folder, "map.toml", "zone = \"UTC\"\n");
    write(&folder, "index.csv", format!("loop,label,file\nA,stiction,{FILE}\n"));
    write(&folder, "lib.so", "x");
    let scenario = run(&folder, &["simulate", "paper/closed-loop", "--print"]).quiet_success();
    write(&folder, "loop.toml", &scenario);
    let input = "[input]\nsignal = \"file\"\nfile = \"in.csv\"\ncolumn = \"u\"\n";
    write(
        &folder,
        "open.toml",
        format!("sample_time = 1\nduration = 3\n{input}[valve]\nmodel = \"ideal\"\n"),
    );
    let absolute = folder.join(FILE).display().to_string();
    let mut same = vec![FILE, "./sub/../FIC101-sticky.csv", "hard.csv", &absolute];
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink(FILE, folder.join("soft.csv")).expect("a link");
        same.push("soft.csv");
    }
    let before = files(&folder);
    let mut cases: Vec<Vec<&str>> = vec![];
    for output in same {
        cases.push(vec!["diagnose", FILE, "--csv", output]);
        cases.push(vec!["diagnose", FILE, "--json", "--report", output]);
        cases.push(vec!["history", FILE, "--csv", output]);
        cases.push(vec!["history", FILE, "--report", output]);
        cases.push(vec!["shift", FILE, "--csv", output]);
        cases.push(vec!["fit", FILE, "-o", output]);
        cases.push(vec!["fit", FILE, "--plot", output]);
        cases.push(vec!["bench", "labels", "index.csv", "--csv", output]);
        cases.push(vec!["bench", "labels", "index.csv", "--report", output]);
        cases.push(vec!["diagnose", output, "--csv", FILE]);
    }
    for command in ["simulate", "compensate", "what-if", "limit-cycle"] {
        let option = if command == "simulate" { "-o" } else { "--csv" };
        cases.push(vec![command, "loop.toml", option, "loop.toml"]);
        cases.push(vec![command, "loop.toml", "--plot", "loop.toml"]);
    }
    cases.extend([
        vec!["limit-cycle", "loop.toml", "--nyquist", "loop.toml"],
        vec!["simulate", "open.toml", "-o", "in.csv"],
        vec!["fmu", "loop.toml", "-o", "loop.toml"],
        vec!["fmu", "-o", "lib.so", "--library", "x86_64-windows=lib.so"],
        vec!["valve", "--S", "5", "--J", "2", "in.csv", "-o", "in.csv"],
        vec!["stem", "--input", "in.csv", "-o", "in.csv"],
        vec!["stem", "--input", "in.csv", "--events", "in.csv"],
        vec!["diagnose", FILE, "--mapping", "map.toml", "--csv", "map.toml"],
        vec!["bench", "labels", "index.csv", "--csv", "index.csv"],
    ]);
    for arguments in cases {
        let refused = run(&folder, &arguments).refusal();
        assert!(
            refused.contains("would overwrite") && refused.contains("name another file"),
            "{arguments:?}: {refused}"
        );
        assert_eq!(files(&folder), before, "{arguments:?}");
    }
    // The overrides that it reads too, and a page of a folder.
    let overrule = ["override", FILE, "--verdict", "sticks", "--reason", "x"];
    run(&folder, &overrule).quiet_success();
    let before = files(&folder);
    for command in ["diagnose", "history"] {
        let arguments = [command, FILE, "--csv", "stiction-overrides.toml"];
        refuses(&folder, &arguments, "would overwrite stiction-overrides.toml");
    }
    std::fs::copy(folder.join(FILE), folder.join("sub/index.html")).expect("a copy");
    let refused = run(&folder, &["diagnose", "sub/index.html", "--report", "sub"]).refusal();
    assert!(refused.contains("sub/index.html would overwrite"), "{refused}");
    assert_eq!(read(&folder, "sub/index.html"), read(&folder, FILE));
    #[cfg(unix)]
    {
        std::fs::remove_file(folder.join("stiction-overrides.toml")).expect("a file");
        let beside = folder.join("stiction-overrides.toml");
        std::os::unix::fs::symlink(FILE, beside).expect("a link");
        run(&folder, &overrule).refusal();
    }
    assert_eq!(files(&folder)[FILE], before[FILE]);
}

/// The first file in a folder, or the file itself.
fn first_file(path: &Path) -> std::path::PathBuf {
    if !path.is_dir() {
        return path.to_owned();
    }
    let mut there: Vec<_> =
        std::fs::read_dir(path).expect("a folder").flatten().map(|e| e.path()).collect();
    there.sort();
    first_file(&there[0])
}

/// Pages and pictures of others need --force. What a command wrote, it writes again, with other parameters, too.
#[test]
fn a_page_or_picture_of_others_needs_force_and_own_output_is_written_again() {
    let folder = with_samples("page-as-output");
    let page = "<!doctype html><title>Notes on stiction</title><p>mine</p>\n";
    let drawing = "<svg xmlns=\"http://www.w3.org/2000/svg\"><path d=\"M0 0\"/></svg>";
    for (line, file, foreign) in [
        ("diagnose FIC101-sticky.csv --report r.html", "r.html", page),
        ("test plan FIC101-sticky.csv --sheet t.html", "t.html", page),
        ("test plan FIC101-sticky.csv --sheet u.html", "u.html", "my notes\n"),
        ("simulate paper/closed-loop --plot run.svg", "run.svg", drawing),
        ("simulate paper/closed-loop --plot run.png", "run.png", "\u{89}PNG\r\n\u{1a}\n\0"),
    ] {
        write(&folder, file, foreign);
        let arguments: Vec<&str> = line.split(' ').collect();
        refuses(&folder, &arguments, "this program did not write it");
        assert_eq!(read(&folder, file), foreign);
        let forced = run(&folder, &[&arguments, &["--force"][..]].concat());
        assert_eq!(forced.code, 0, "{line}: {}", forced.err);
        let again = run(&folder, &arguments);
        assert_eq!(again.code, 0, "{line}: {}", again.err);
    }
    write(&folder, "in.csv", "t,u\n0,1\n1,2\n2,3\n");
    for (s, j) in [("1", "1"), ("2", "0.5"), ("0", "0")] {
        run(&folder, &["valve", "--S", s, "--J", j, "in.csv", "-o", "v.csv"]).quiet_success();
    }
    write(&folder, "other.csv", "t,u\n0,1\n1,2.5\n2,3\n");
    let refused = run(&folder, &["valve", "--S", "1", "--J", "1", "other.csv", "-o", "v.csv"]);
    assert!(refused.refusal().contains("with other data than this run writes"));
}

/// A pattern in the wrong place names a recording as an output, which the run does not read.
#[test]
fn a_recording_is_replaced_by_no_output() {
    let folder = with_samples("recording-as-output");
    std::fs::copy(samples().join("test/FIC106-tested.csv"), folder.join("FIC106-tested.csv"))
        .expect("a copy");
    write(&folder, "in.csv", "t,u\n0,1\n1,2\n2,3\n");
    write(&folder, "index.csv", "loop,label,file\nFIC101,stiction,FIC101-sticky.csv\n");
    let results = ["bench", "detector", "--suite", "v1-trial", "--only", "verdict", "--json"];
    write(&folder, "results.json", run(&folder, &results).quiet_success());
    let recording = read(&folder, "FIC102-disturbed.csv");
    for (_, _, output, line) in ARGUMENTS {
        let arguments: Vec<&str> = line.split(' ').collect();
        let ran = |more: &[&str]| run(&folder, &[&arguments, more].concat());
        let first = ran(&[]);
        assert_eq!(first.code, 0, "{line}: {}", first.err);
        let path = first_file(&folder.join(output));
        let made = std::fs::read(&path).expect("it is written");
        // Some folders are written once; the documents take long.
        let is_folder = folder.join(output).is_dir();
        // A mapping file is written to be corrected by hand.
        let is_edited = line.contains("--write-map");
        if !is_folder && !is_edited {
            let again = ran(&[]);
            assert_eq!(again.code, 0, "{line}, again: {}", again.err);
        }
        write(&folder, path.to_str().expect("UTF-8"), &recording);
        let refused = ran(&[]);
        assert_eq!(refused.code, 2, "{line}: {}", refused.err);
        assert!(refused.err.contains("--force"), "{line}: {}", refused.err);
        assert_eq!(std::fs::read_to_string(&path).expect("it is there"), recording, "{line}");
        if !is_folder {
            assert_eq!(ran(&["--force"]).code, 0, "{line}");
            let forced = std::fs::read(&path).expect("it is written");
            assert_eq!(forced.get(..4), made.get(..4), "{line}");
        }
    }
    // As it happens by hand.
    let csv: Vec<String> =
        files(&folder).into_keys().filter(|name| name.starts_with("FIC10")).collect();
    let all: Vec<&str> = csv.iter().map(String::as_str).collect();
    let refused = run(&folder, &[&["diagnose", "--csv"][..], &all].concat());
    assert_eq!(refused.code, 2);
    assert!(refused.err.contains("FIC101-sticky.csv exists already"), "{}", refused.err);
    assert_eq!(read(&folder, FILE), read(&samples(), FILE));
}

#[test]
fn two_outputs_under_one_name_are_refused() {
    let folder = with_samples("two-outputs");
    for arguments in [
        &["diagnose", FILE, "--report", "y.html", "--csv", "./y.html"][..],
        &["diagnose", FILE, "--report", "-", "--csv", "-"],
        &["history", FILE, "--report", "y", "--csv", "y"],
        &["simulate", "paper/closed-loop", "-o", "y.svg", "--plot", "y.svg"],
        &["stem", "-o", "y", "--events", "y"],
        &["limit-cycle", "paper/closed-loop", "--plot", "y.png", "--nyquist", "y.png"],
    ] {
        refuses(&folder, arguments, "one output would be lost");
    }
    assert!(!folder.join("y").exists() && !folder.join("y.html").exists());
    // What is no file loses nothing.
    #[cfg(unix)]
    run(&folder, &["diagnose", FILE, "--report", "/dev/null", "--csv", "/dev/null"]);
}

/// Outputs of all kinds: what is written, and the arguments for it.
const OUTPUTS: [(&str, &[&str]); 9] = [
    ("r.html", &["diagnose", FILE, "--report", "r.html"]),
    ("h.html", &["history", FILE, "--report", "h.html"]),
    ("run.csv", &["simulate", "paper/closed-loop", "-o", "run.csv"]),
    ("run.svg", &["simulate", "paper/closed-loop", "--plot", "run.svg"]),
    ("run.png", &["simulate", "paper/closed-loop", "--plot", "run.png"]),
    ("valve.fmu", &["fmu", "paper/closed-loop", "-o", "valve.fmu"]),
    ("stem.csv", &["stem", "-o", "stem.csv"]),
    ("shift.csv", &["shift", FILE, "--csv", "shift.csv"]),
    ("board.html", &["bench", "simulated", "2", "--only", "verdict", "--report", "board.html"]),
];

/// What an output may replace.
fn old_content(file: &str) -> &'static str {
    let is_drawn = [".html", ".svg", ".png"].iter().any(|end| file.ends_with(end));
    if is_drawn { "<meta name=\"generator\" content=\"stiction\">\n" } else { "old\n" }
}

/// A limit on the size of files stands for a full disk: `trap` decides whether the write fails or the process dies.
#[cfg(unix)]
#[test]
fn a_write_that_fails_leaves_the_old_file_whole() {
    let folder = with_samples("write-fails");
    let overrule = |reason: &str| {
        let arguments =
            ["override", FILE, "--verdict", "does-not-stick", "--by", "J", "--reason", reason];
        arguments.map(str::to_owned).to_vec()
    };
    let quick = overrule("first");
    let arguments: Vec<&str> = quick.iter().map(String::as_str).collect();
    run(&folder, &arguments).quiet_success();
    let long = overrule(&"long ".repeat(600));
    let mut cases: Vec<(&str, Vec<String>)> = OUTPUTS
        .iter()
        .map(|(file, arguments)| (*file, arguments.iter().map(|a| (*a).to_owned()).collect()))
        .collect();
    cases.push(("stiction-overrides.toml", long));
    for (file, arguments) in &cases {
        if !folder.join(file).exists() {
            write(&folder, file, old_content(file));
        }
        let old = read(&folder, file);
        for (trap, dies) in [("trap '' XFSZ;", false), ("", true)] {
            let script = format!("{trap} ulimit -f 2; exec \"$@\"");
            let done = Command::new("sh")
                .args(["-c", &script, "sh", env!("CARGO_BIN_EXE_stiction")])
                .args(arguments)
                .current_dir(&folder)
                .output()
                .expect("sh starts");
            let said = String::from_utf8_lossy(&done.stderr);
            assert_eq!(done.status.code(), if dies { None } else { Some(2) }, "{file}: {said}");
            assert_eq!(read(&folder, file), old, "{file}: {said}");
            if !dies {
                assert!(said.contains(file), "{said}");
            }
        }
    }
    assert!(run(&folder, &["diagnose", FILE]).quiet_success().contains("Overruled by J"));
    // Who dies cannot clean up, but what is left is told apart from data; who fails does.
    let left = std::fs::read_dir(&folder).expect("a folder").flatten();
    let left = left.filter(|e| is_left_over(&e.file_name().to_string_lossy())).count();
    // A later run removes what is old enough.
    assert!((1..=cases.len()).contains(&left), "{left} files of those who died");
}

/// The same on a disk that is really full.
#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_leaves_the_old_file_whole() {
    let folder = with_samples("full-disk");
    let mount = "mkdir -p small && mount -t tmpfs -o size=64k none small";
    let script = |work: &str| {
        let mut unshare = Command::new("unshare");
        unshare.args(["-m", "sh", "-c", &format!("{mount} && {work}")]).current_dir(&folder);
        unshare.env("STICTION", env!("CARGO_BIN_EXE_stiction")).output()
    };
    if !script("true").is_ok_and(|done| done.status.success()) {
        eprintln!("skipped: mounting is not permitted here");
        return;
    }
    let mut tried = 0;
    for (file, arguments) in OUTPUTS {
        if file == "shift.csv" {
            continue; // It fits.
        }
        let arguments = arguments.join(" ").replace(file, &format!("small/{file}"));
        let old = old_content(file);
        let work = format!(
            "printf '{old}' > small/{file} && dd if=/dev/zero of=small/fill bs=1k count=52 2>/dev/null; \
             \"$STICTION\" {arguments} >/dev/null; echo $?; cat small/{file}; ls -A small"
        );
        let done = script(&work).expect("unshare starts");
        let said = String::from_utf8_lossy(&done.stdout).into_owned();
        assert_eq!(said, format!("2\n{old}{}", sorted(&[file, "fill"])), "{file}");
        tried += 1;
    }
    assert_eq!(tried, 8);
    // Overrides: the entry is not kept, and the others are.
    let enter = |reason: &str| {
        format!("\"$STICTION\" override small/a.csv --verdict sticks --by J --reason {reason}")
    };
    let reason = "x".repeat(9000);
    let work = format!(
        "head -400 {FILE} > small/a.csv; {} && dd if=/dev/zero of=small/fill bs=1k count=64 2>/dev/null; {}; echo $?; \
         rm small/fill; \"$STICTION\" override small --list",
        enter("seen"),
        enter(&reason)
    );
    let done = script(&work);
    let said = String::from_utf8_lossy(&done.expect("unshare starts").stdout).into_owned();
    assert!(said.contains("\n2\na: sticks (seen); by J"), "{said}");
}

#[cfg(target_os = "linux")]
fn sorted(names: &[&str]) -> String {
    let mut names = names.to_vec();
    names.sort_unstable();
    names.iter().map(|name| format!("{name}\n")).collect()
}

/// Kills at moments spread over the run: what has its name is whole.
#[cfg(unix)]
#[test]
fn a_kill_leaves_no_partial_file() {
    let place = with_samples("kill");
    let population = ["population", "--n", "150", "--seed", "5", "-o"];
    let samples = ["FIC101-sticky.csv", "FIC102-disturbed.csv", "FIC105-cascade.csv"];
    let report: Vec<&str> = [&["diagnose"][..], &samples, &["--report"]].concat();
    let (mut kills, mut partial, mut seen, mut left) = (0, 0, 0, 0);
    for (name, arguments) in [("population", &population[..]), ("report", &report)] {
        let whole = format!("{name}-whole");
        let began = std::time::Instant::now();
        let done = run(&place, &[arguments, &[&whole]].concat());
        assert_eq!(done.code, 0, "{}", done.err);
        let takes = began.elapsed();
        let expected = files(&place.join(&whole));
        assert!(expected.len() > 3);
        for k in 1..=20 {
            let cut = format!("{name}-{k}");
            let mut child = command(&place)
                .args([arguments, &[&cut]].concat())
                .stdout(std::process::Stdio::null())
                .stderr(std::process::Stdio::null())
                .spawn()
                .expect("the command starts");
            std::thread::sleep(takes.mul_f64(0.05 * f64::from(k)).max(Duration::from_millis(1)));
            child.kill().expect("SIGKILL");
            child.wait().expect("it ends");
            kills += 1;
            for (file, bytes) in files(&place.join(&cut)) {
                seen += 1;
                partial += usize::from(expected[&file] != bytes);
            }
            let entries = std::fs::read_dir(place.join(&cut)).into_iter().flatten().flatten();
            left += entries.filter(|e| is_left_over(&e.file_name().to_string_lossy())).count();
        }
    }
    println!("{kills} kills, {seen} files, {partial} partial, {left} left over");
    assert!(seen > 100, "the kills came before anything was written");
    assert_eq!(partial, 0);
}

#[test]
fn overrides_of_twelve_writers_are_all_kept() {
    let folder = folder("override-parallel");
    for k in 0..12 {
        write(
            &folder,
            &format!("L{k}.csv"),
            read(&samples(), FILE).replace("60.06", &format!("60.{k}")),
        );
    }
    let children: Vec<_> = (0..12)
        .map(|k| {
            let (file, reason) = (format!("L{k}.csv"), format!("r{k}"));
            let arguments = ["override", &file, "--verdict", "sticks", "--reason", &reason];
            let mut command = command(&folder);
            command.args(arguments).stdout(std::process::Stdio::null()).spawn().expect("it starts")
        })
        .collect();
    for mut child in children {
        assert!(child.wait().expect("it ends").success());
    }
    let kept = read(&folder, "stiction-overrides.toml");
    assert_eq!(kept.matches("[[override]]").count(), 12, "{kept}");
    let list = run(&folder, &["override", ".", "--list"]).quiet_success();
    assert_eq!(list.lines().filter(|line| line.contains("; entered 20")).count(), 12, "{list}");
    assert!(list.contains(concat!(" with stiction ", env!("CARGO_PKG_VERSION"))), "{list}");
}

#[test]
fn a_damaged_override_is_named_and_the_others_hold() {
    let folder = with_samples("override-damaged");
    let enter = |reason: &str| {
        let arguments =
            ["override", FILE, "--verdict", "does-not-stick", "--by", "J", "--reason", reason];
        run(&folder, &arguments)
    };
    enter("stroked").quiet_success();
    let cut = "\n[[override]]\nloop = \"FIC102-disturbed\"\nverdict = \"sticks\"\nreason = \"see";
    write(&folder, "stiction-overrides.toml", read(&folder, "stiction-overrides.toml") + cut);
    let done = run(&folder, &["diagnose", FILE, "FIC102-disturbed.csv", "--json"]);
    assert_eq!(done.code, 0);
    let named = "stiction-overrides.toml, line 17: invalid basic string";
    assert!(
        done.err.contains(named) && done.err.contains("the other overrides apply"),
        "{}",
        done.err
    );
    let found: serde_json::Value = serde_json::from_str(&done.out).expect("JSON");
    assert_eq!(found["loops"][0]["verdict"]["override"]["reason"], "stroked");
    let notes = |k: usize| found["loops"][k]["notes"].to_string();
    assert!(notes(1).contains(named) && !notes(0).contains(named), "{}", notes(1));
    // What is entered beside it leaves it, and no longer tells without a word.
    let again = enter("stroked again");
    assert!(again.code == 0 && again.err.contains(named), "{}", again.err);
    let kept = read(&folder, "stiction-overrides.toml");
    assert!(kept.contains("stroked again") && kept.contains(cut.trim_start()), "{kept}");
}
