//! The documents, followed to the letter: every command of README and of the pages, in the order shown, in a folder
//! that holds what a fresh clone does. What a page shows below a command is what the command prints.

use crate::folder;
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::Mutex;

const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");

/// What the pages tell readers to type and this test does not: how such a line begins, and why.
const NOT_RUN: [(&str, &str); 15] = [
    ("cargo add ", "changes the reader's own project"),
    ("cargo build ", "builds what is under test"),
    ("cargo doc ", "CI runs it"),
    ("cargo install ", "installs what is under test"),
    ("cargo run --release -p ", "builds an example"),
    ("cargo test ", "runs this test, or measures for hours"),
    ("STICTION_LOOPS=300 cargo test ", "measures for minutes"),
    ("STICTION_TESTS=200 cargo test ", "measures for minutes"),
    ("export RUSTFLAGS=", "for a package that is not built here"),
    ("MATURIN_PEP517_ARGS=", "builds the package"),
    ("pip ", "CI builds and installs the package"),
    ("python ", "CI runs it"),
    ("rustup ", "installs a compiler"),
    ("sha256sum stiction-*.whl", "of the package that is not built here"),
    ("STICTION_FMU_TARGETS=", "needs a compiler for another platform"),
];

/// Recordings that are not part of the project: `docs/accuracy.md` measures on them.
const NOT_AT_HAND: &str = "../shared/";

/// Words of `bench` before the number of loops to simulate. Pages show counts that measure; a few loops tell whether the
/// command runs.
const COUNTS: [&str; 6] = ["simulated", "positions", "invented", "--per-kind", "networks", "tests"];

/// A line of a block of commands.
struct Line {
    number: usize,
    command: String,
    /// 0 unless a comment behind the command says "exit code N".
    code: i32,
    /// What the page shows below the block, if the command is alone in it.
    shown: Option<String>,
}

/// The fenced blocks of a page: language, number of the first line within, text; and whether nothing but blank lines
/// stands between it and the one before.
fn blocks(page: &str) -> Vec<(&str, usize, Vec<&str>, bool)> {
    let (mut found, mut open, mut adjoins) = (vec![], None, false);
    for (index, line) in page.lines().enumerate() {
        match (open.take(), line.strip_prefix("```")) {
            (None, Some(language)) => open = Some((language, index + 2, vec![], adjoins)),
            (None, None) => adjoins &= line.trim().is_empty(),
            (Some(block), Some(_)) => {
                found.push(block);
                adjoins = true;
            }
            (Some(mut block), None) => {
                block.2.push(line);
                open = Some(block);
            }
        }
    }
    assert!(open.is_none(), "a block is not closed");
    found
}

/// The commands of a page.
fn lines(page: &str) -> Vec<Line> {
    let blocks = blocks(page);
    let mut found: Vec<Line> = vec![];
    for (index, (_, first, text, _)) in blocks.iter().enumerate().filter(|(_, b)| b.0 == "sh") {
        let before = found.len();
        let mut continued = String::new();
        for (line, number) in text.iter().zip(*first..) {
            if let Some(part) = line.strip_suffix('\\') {
                continued += part;
                continue;
            }
            let whole = std::mem::take(&mut continued) + line;
            let command = whole.trim().to_owned();
            if command.is_empty() || command.starts_with('#') {
                continue;
            }
            let comment = command.rsplit_once(" #").map_or("", |(_, comment)| comment);
            let code = comment.split_once("exit code ").map_or(0, |(_, rest)| {
                let digits = rest.split(|c: char| !c.is_ascii_digit()).next();
                digits.and_then(|d| d.parse().ok()).expect("exit code N")
            });
            found.push(Line { number, command, code, shown: None });
        }
        let below =
            blocks.get(index + 1).filter(|(language, .., adjoins)| *language == "text" && *adjoins);
        if let ([alone], Some((_, _, text, _))) = (&mut found[before..], below) {
            alone.shown = Some(text.join("\n"));
        }
    }
    found
}

/// The line as a shell is to run it, or `None` if [`NOT_RUN`] has it.
fn runnable(command: &str) -> Option<String> {
    let command = command.replace("cargo run --release --bin stiction -- ", "stiction ");
    if NOT_RUN.iter().any(|(begin, _)| command.starts_with(begin)) || command.contains(NOT_AT_HAND)
    {
        return None;
    }
    assert!(command.starts_with("stiction "), "neither run nor listed as not run: {command}");
    if command.starts_with("stiction lab") {
        // It runs until it is ended; its first line says where it is.
        let lab = command.split(" #").next().unwrap_or_default();
        return Some(format!("timeout -s INT 4 {lab} --no-open | grep -m 1 '^http://127'"));
    }
    if !command.starts_with("stiction bench ") {
        return Some(command);
    }
    let mut words: Vec<_> = command.split_whitespace().collect();
    for k in 1..words.len() {
        if COUNTS.contains(&words[k - 1]) {
            words[k] = "4";
        }
    }
    Some(words.join(" "))
}

/// Whether a page shows what was printed; a line `...` stands for any lines.
fn is_shown(shown: &str, printed: &str) -> bool {
    let (shown, printed) = (format!("\n{}\n", shown.trim()), format!("\n{}\n", printed.trim()));
    let parts: Vec<_> = shown.split("...\n").collect();
    let (first, last) = (parts[0], parts[parts.len() - 1]);
    if parts.len() == 1 {
        return shown == printed;
    }
    let mut rest = Some(printed.as_str());
    for part in &parts {
        rest = rest.and_then(|rest| rest.split_once(part)).map(|(_, after)| after);
    }
    rest.is_some() && printed.starts_with(first) && (last.is_empty() || printed.ends_with(last))
}

/// README, and all pages below `docs`.
fn pages() -> Vec<PathBuf> {
    let mut found: Vec<_> =
        ["README.md", "python/README.md", "samples/README.md"].map(PathBuf::from).into();
    let mut folders = vec![PathBuf::from("docs")];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(Path::new(ROOT).join(&folder)).expect("a folder of pages") {
            let entry = entry.expect("an entry");
            let path = folder.join(entry.file_name());
            if entry.path().is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|e| e == "md") {
                found.push(path);
            }
        }
    }
    found.sort();
    found
}

/// Follows a page, and gives the number of commands run and what went otherwise than it says.
fn follow(page: &Path, path: &OsString) -> (usize, Vec<String>) {
    let text = std::fs::read_to_string(Path::new(ROOT).join(page)).expect("a page");
    let folder = folder(&format!("followed-{}", page.display().to_string().replace('/', "-")));
    for samples in ["samples", "samples/test", "examples/detectors"] {
        std::fs::create_dir_all(folder.join(samples)).expect("a folder");
        for sample in std::fs::read_dir(Path::new(ROOT).join(samples)).expect("the samples") {
            let sample = sample.expect("a sample");
            if sample.path().is_file() {
                std::fs::copy(sample.path(), folder.join(samples).join(sample.file_name()))
                    .expect("copied");
            }
        }
    }
    let (mut ran, mut wrong) = (0, vec![]);
    for line in lines(&text) {
        let Some(command) = runnable(&line.command) else { continue };
        let mut shell = Command::new("sh");
        shell.args(["-c", &command]).current_dir(&folder).env("PATH", path).stdin(Stdio::null());
        let begun = std::time::Instant::now();
        let done = shell.output().expect("a shell");
        println!(
            "{:6.1} s  {}:{}  {command}",
            begun.elapsed().as_secs_f64(),
            page.display(),
            line.number
        );
        ran += 1;
        let at = format!("{}:{}: {command}", page.display(), line.number);
        let (out, err) =
            (String::from_utf8_lossy(&done.stdout), String::from_utf8_lossy(&done.stderr));
        if done.status.code() != Some(line.code) {
            wrong.push(format!("{at}\n{}, not exit code {}\n{err}", done.status, line.code));
        }
        if let Some(shown) = line.shown.filter(|shown| !is_shown(shown, &out)) {
            wrong.push(format!("{at}\nprints\n{out}\nand not, as the page shows,\n{shown}\n"));
        }
    }
    (ran, wrong)
}

#[test]
fn every_command_of_every_page_does_what_the_page_says() {
    let bin = Path::new(env!("CARGO_BIN_EXE_stiction")).parent().expect("a folder").to_owned();
    let inherited = std::env::var_os("PATH").unwrap_or_default();
    let path = std::env::join_paths([bin].into_iter().chain(std::env::split_paths(&inherited)));
    let path = path.expect("a PATH");
    let (left, done) = (Mutex::new(pages()), Mutex::new((0, vec![])));
    let workers = std::thread::available_parallelism().map_or(1, usize::from);
    std::thread::scope(|scope| {
        for _ in 0..workers {
            scope.spawn(|| {
                loop {
                    let Some(page) = left.lock().expect("a lock").pop() else { break };
                    let (ran, wrong) = follow(&page, &path);
                    let mut done = done.lock().expect("a lock");
                    done.0 += ran;
                    done.1.extend(wrong);
                }
            });
        }
    });
    let (ran, wrong) = done.into_inner().expect("a lock");
    println!("{ran} commands");
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    assert!(ran >= 100, "only {ran} commands were found");
}

#[test]
fn commands_are_found_as_a_reader_sees_them() {
    let page = "```sh\nstiction a  # exit code 1 if it sticks\nstiction b \\\n  c\n\n# why\n```\n\n```text\nof two\n```\n\
        ```sh\nstiction d\n```\n\n```text\nyes\n```\n\n```sh\nstiction e\n```\nThen\n```text\nof itself\n```\n";
    let found = lines(page);
    let seen = found.iter().map(|l| (l.number, l.command.as_str(), l.code, l.shown.as_deref()));
    let expected = [
        (2, "stiction a  # exit code 1 if it sticks", 1, None),
        (4, "stiction b   c", 0, None),
        (13, "stiction d", 0, Some("yes")),
        (21, "stiction e", 0, None),
    ];
    assert_eq!(seen.collect::<Vec<_>>(), expected);
    assert_eq!(
        runnable("cargo run --release --bin stiction -- --help").as_deref(),
        Some("stiction --help")
    );
    assert_eq!(
        runnable("stiction lab run.csv  # opens the browser").as_deref(),
        Some("timeout -s INT 4 stiction lab run.csv  --no-open | grep -m 1 '^http://127'")
    );
    assert_eq!(runnable("pip install ."), None);
    assert_eq!(
        runnable("stiction bench simulated 1000").as_deref(),
        Some("stiction bench simulated 4")
    );
}

#[test]
fn lines_may_be_left_out() {
    let printed = "a\nb 1\nc\nd\n";
    for shown in
        ["a\nb 1\nc\nd", "a\n...\nd", "a\n...", "...\nd", "...\nb 1\n...", "a\n...\nc\n...\nd"]
    {
        assert!(is_shown(shown, printed), "{shown}");
    }
    for shown in [
        "a\nb 2\nc\nd",
        "b 1\n...",
        "...\nc",
        "...\nb\n...",
        "...\nc\n...\na\n...",
        "a\n...\nx\n...\nd",
    ] {
        assert!(!is_shown(shown, printed), "{shown}");
    }
}

#[test]
fn the_citation_names_this_version() {
    let citation =
        std::fs::read_to_string(Path::new(ROOT).join("CITATION.cff")).expect("a citation");
    assert!(
        citation.contains(concat!("\nversion: ", env!("CARGO_PKG_VERSION"), "\n")),
        "{citation}"
    );
}

#[test]
#[should_panic = "neither run nor listed as not run"]
fn a_command_that_nobody_knows_is_noticed() {
    let _ = runnable("rm -r samples");
}
