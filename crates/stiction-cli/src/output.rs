//! Writing results to files and to standard output.

use anyhow::{Context, Result, bail};
use std::io::{ErrorKind, Write};
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use stiction_figure::Figure;

/// The program with its version, as documents name it.
pub const TOOL: &str = concat!("stiction ", env!("CARGO_PKG_VERSION"));

/// Writes `bytes` to the file at `path`, or to standard output for none or `-`.
pub fn write(path: Option<&Path>, bytes: &[u8]) -> Result<()> {
    match path {
        Some(path) if path != Path::new("-") => {
            whole(path, bytes).with_context(|| path.display().to_string())
        }
        _ => {
            // What is no text goes out as it is; of text, colours go to terminals that want them.
            let mut out = std::io::stdout().lock();
            match std::str::from_utf8(bytes).is_ok_and(|text| text.contains('\u{1b}')) {
                true => anstream::AutoStream::auto(&mut out).write_all(bytes)?,
                false => out.write_all(bytes)?,
            }
            Ok(out.flush()?)
        }
    }
}

/// Writes a file whole or not at all: a full disk or an end in between leaves what was there before. A device or a pipe,
/// a file that is reached by a link, one that must not be written and one in a folder that takes no other are written
/// as they are.
fn whole(path: &Path, bytes: &[u8]) -> std::io::Result<()> {
    let there = std::fs::symlink_metadata(path);
    let plain =
        there.as_ref().map_or(true, |there| there.is_file() && !there.permissions().readonly());
    let Some(name) = path.file_name().filter(|_| plain) else {
        return std::fs::write(path, bytes);
    };
    let mut beside = std::ffi::OsString::from(".");
    beside.push(name);
    beside.push(format!(".{}.part", std::process::id()));
    let beside = path.with_file_name(beside);
    match std::fs::write(&beside, bytes) {
        Err(error) if error.kind() == ErrorKind::PermissionDenied && there.is_ok() => {
            return std::fs::write(path, bytes);
        }
        written => written,
    }
    .and_then(|()| {
        there.map_or(Ok(()), |there| std::fs::set_permissions(&beside, there.permissions()))
    })
    .and_then(|()| std::fs::rename(&beside, path))
    .inspect_err(|_| {
        let _ = std::fs::remove_file(&beside);
    })
}

/// Draws `figure` to the file that `option` named, .svg or .png.
pub fn figure(option: &str, path: &Path, figure: &Figure) -> Result<()> {
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or("");
    let bytes = match extension.to_ascii_lowercase().as_str() {
        "svg" => figure.svg()?.into_bytes(),
        "png" => figure.png()?,
        _ => bail!("{option} {}: the file must end in .svg or .png", path.display()),
    };
    write(Some(path), &bytes)
}

/// Prints one line to standard output.
pub fn line(text: impl std::fmt::Display) -> Result<()> {
    write(None, format!("{text}\n").as_bytes())
}

/// Prints a document as JSON, indented.
pub fn json(document: &impl serde::Serialize) -> Result<()> {
    line(serde_json::to_string_pretty(document)?)
}

/// The times of samples, rounded to a millionth of a sample, so that 0.3 is not 0.30000000000000004.
pub fn times(sample_time: f64, samples: usize) -> Vec<f64> {
    let digits = (6.0 - sample_time.log10()).ceil().max(0.0);
    // Beyond these digits a number's own rounding is finer.
    let unit = (digits <= 15.0).then(|| 10f64.powf(digits));
    let time = |k| {
        let t = k as f64 * sample_time;
        unit.map_or(t, |unit| (t * unit).round() / unit)
    };
    (0..samples).map(time).collect()
}

/// Whether notes and progress are left out.
static QUIET: AtomicBool = AtomicBool::new(false);

/// Leaves notes and progress out from now on.
pub fn set_quiet(quiet: bool) {
    QUIET.store(quiet, Ordering::Relaxed);
}

/// Whether notes and progress are left out.
pub fn is_quiet() -> bool {
    QUIET.load(Ordering::Relaxed)
}

/// Tells the user something beside the result. Where no one can read it, that is no failure.
pub fn note(text: impl std::fmt::Display) {
    if is_quiet() {
        return;
    }
    let _ = writeln!(std::io::stderr(), "note: {text}");
}

/// A failure in a line: what was tried, and why it did not work, with the options of this command. Some causes
/// say what the error above them says too; they are not repeated.
pub fn failure(error: &anyhow::Error) -> String {
    let words = |cause: &(dyn std::error::Error + 'static)| match cause.downcast_ref() {
        Some(stiction_io::Error::Setting { settings, message }) => {
            format!("--set {}: {message}", settings.join(" --set "))
        }
        _ => cause.to_string(),
    };
    let mut line = String::new();
    for cause in error.chain().map(words) {
        match line.as_str() {
            "" => line = cause,
            said if said.ends_with(&cause) => {}
            _ => line += &format!(": {cause}"),
        }
    }
    line
}

/// Whether the reader of our output has gone.
pub fn is_broken_pipe(error: &anyhow::Error) -> bool {
    error
        .chain()
        .filter_map(|cause| cause.downcast_ref::<std::io::Error>())
        .any(|cause| cause.kind() == ErrorKind::BrokenPipe)
}

#[cfg(test)]
mod tests {
    use super::whole;

    #[test]
    fn files_are_replaced_whole_and_links_stay() {
        let folder = std::env::temp_dir().join(format!("stiction-output-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let file = folder.join("a.txt");
        for text in ["first", "second"] {
            whole(&file, text.as_bytes()).unwrap();
            assert_eq!(std::fs::read_to_string(&file).unwrap(), text);
        }
        #[cfg(unix)]
        {
            let link = folder.join("link.txt");
            std::os::unix::fs::symlink(&file, &link).unwrap();
            whole(&link, b"third").unwrap();
            assert!(std::fs::symlink_metadata(&link).unwrap().is_symlink());
            assert_eq!(std::fs::read_to_string(&file).unwrap(), "third");
        }
        let hidden = |name: &str| name.ends_with(".part");
        let left = std::fs::read_dir(&folder).unwrap();
        assert!(!left.flatten().any(|entry| entry.file_name().to_str().is_some_and(hidden)));
        // What cannot be put in its place leaves nothing behind.
        std::fs::create_dir(folder.join("b")).unwrap();
        assert!(
            whole(&folder.join("b"), b"x").is_err() && whole(&folder.join("c/d"), b"x").is_err()
        );
        std::fs::remove_dir_all(&folder).unwrap();
    }
}
