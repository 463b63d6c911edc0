//! `stiction` without a subcommand: recordings dropped on the program are diagnosed, and a person at a terminal is asked.

use std::ffi::OsString;
use std::io::{BufRead, IsTerminal, Write};
use std::path::Path;
use std::process::Command;

/// The simulated recording that the choice offers.
const SAMPLE: &str = "samples/sticky-flow";

/// The command to run, and whether a window waits for a key before it closes.
pub struct Launch {
    pub command: Vec<OsString>,
    pub waits: bool,
}

/// The command that the arguments of the program mean. `names` are the names of its subcommands.
pub fn launch(arguments: Vec<OsString>, names: &[&str]) -> Launch {
    let own = arguments.first().cloned().unwrap_or_else(|| "stiction".into());
    if let Some(command) = dropped(&own, arguments.get(1..).unwrap_or_default(), names) {
        // Windows opens a window for it, and closes it with the program.
        return Launch { command, waits: cfg!(windows) };
    }
    let is_person = std::io::stdin().is_terminal() && std::io::stdout().is_terminal();
    if arguments.len() == 1
        && is_person
        && let Some(command) = chosen(&own)
    {
        return Launch { command, waits: cfg!(windows) };
    }
    Launch { command: arguments, waits: false }
}

/// The diagnosis of dropped files, with a report next to the first.
fn dropped(own: &OsString, files: &[OsString], names: &[&str]) -> Option<Vec<OsString>> {
    let first = Path::new(files.first()?);
    // A word without a folder, such as `fit`, stays the name of a subcommand, even if a file is called so.
    let is_name = first.to_str().is_some_and(|word| names.contains(&word));
    if is_name || !files.iter().all(|file| Path::new(file).is_file()) {
        return None;
    }
    let mut name = first.file_stem()?.to_owned();
    name.push("-stiction.html");
    Some(diagnosis(own, files, &first.with_file_name(name)))
}

fn diagnosis(own: &OsString, files: &[OsString], report: &Path) -> Vec<OsString> {
    let words = ["--report".into(), report.into(), "--open".into(), "--".into()];
    [own.clone(), "diagnose".into()].into_iter().chain(words).chain(files.iter().cloned()).collect()
}

/// The command line that the user chooses, or `None` at the end of the input.
fn chosen(own: &OsString) -> Option<Vec<OsString>> {
    let mut out = anstream::stdout();
    let text = format!(
        "stiction {}: does this control valve stick?\n\n  1  open the lab in the browser\n  2  diagnose a sample recording, and \
         open its report\n  3  print the help\n\nA recording of your own: stiction diagnose FILE.csv --report report.html --open\n",
        crate::VERSION
    );
    write!(out, "{text}").ok()?;
    let mut line = String::new();
    loop {
        write!(out, "\n1, 2 or 3 [1]: ").and_then(|()| out.flush()).ok()?;
        line.clear();
        if std::io::stdin().lock().read_line(&mut line).ok()? == 0 {
            return None;
        }
        let with = |words: &[&str]| -> Vec<OsString> {
            std::iter::once(own.clone()).chain(words.iter().map(OsString::from)).collect()
        };
        match line.trim() {
            "" | "1" => return Some(with(&["lab"])),
            "2" => return sample(own),
            "3" => return Some(with(&["--help"])),
            _ => {}
        }
    }
}

/// The diagnosis of the sample, which is simulated into the user's cache.
fn sample(own: &OsString) -> Option<Vec<OsString>> {
    let folder = dirs::cache_dir().unwrap_or_else(std::env::temp_dir).join("stiction/sample");
    std::fs::create_dir_all(&folder).ok()?;
    let recording = folder.join("sticky-flow.csv");
    let words = ["--quiet", "--no-config", "simulate", SAMPLE, "--columns", "t,sp,pv,op", "-o"];
    let simulated =
        Command::new(std::env::current_exe().ok()?).args(words).arg(&recording).status().ok()?;
    let report = folder.join("sticky-flow.html");
    simulated.success().then(|| diagnosis(own, &[recording.into()], &report))
}

/// Waits for the Enter key.
pub fn wait() {
    crate::output::note("press Enter to close this window");
    let _ = std::io::stdin().lock().read_line(&mut String::new());
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(words: &[&str]) -> Vec<OsString> {
        let words = std::iter::once("stiction").chain(words.iter().copied());
        launch(words.map(OsString::from).collect(), &["fit", "diagnose"]).command
    }

    #[test]
    fn files_are_diagnosed_and_all_else_is_left_alone() {
        let path = |name: &str| format!("{}/{name}", env!("CARGO_MANIFEST_DIR"));
        let [one, two, none] = [path("Cargo.toml"), path("build.rs"), path("none.csv")];
        let report = path("Cargo-stiction.html");
        let words = ["stiction", "diagnose", "--report", &report, "--open", "--", &one, &two];
        assert_eq!(of(&[&one, &two]), words.map(OsString::from));
        let left: [&[&str]; 5] = [&[], &["fit"], &["--help"], &["diagnose", &one], &[&none]];
        for words in left {
            let same = std::iter::once(&"stiction").chain(words).map(OsString::from);
            assert_eq!(of(words), same.collect::<Vec<_>>());
        }
    }
}
