//! Writes results to files and to standard output.

use crate::files::Out;
use crate::replaced;
use crate::shown::steers;
use crate::text::painted;
use anyhow::{Context, Error, Result, bail};
use std::io::{ErrorKind, IsTerminal, StdoutLock, Write};
use std::sync::atomic::{AtomicBool, Ordering};
use stiction_figure::Figure;
use stiction_io::whole;

pub use crate::shown::{name, shown};
pub use stiction_report::sheet::Sheet;

/// Name and version of the program, as documents show them.
pub const TOOL: &str = concat!("stiction ", env!("CARGO_PKG_VERSION"));

/// Writes data to a file, whole or not at all; without a file or with `-`, to standard output. A file with other data
/// is not replaced, see [`replaced`].
pub fn write(to: Option<&Out>, bytes: &[u8]) -> Result<()> {
    match to {
        Some(file) if !file.is_standard() => {
            replaced::check(file, bytes)?;
            whole::write(file, bytes).with_context(|| file.display().to_string())
        }
        _ if std::io::stdout().is_terminal() => text(&String::from_utf8_lossy(bytes)),
        _ => to_standard_output(bytes),
    }
}

/// Writes the output of `make` to the file that an option named, if given. True if that is standard output.
pub fn given<T: AsRef<[u8]>, E: Into<Error>>(
    to: &Option<Out>,
    make: impl FnOnce() -> Result<T, E>,
) -> Result<bool> {
    let Some(file) = to else { return Ok(false) };
    write(Some(file), make().map_err(Into::into)?.as_ref())?;
    Ok(file.is_standard())
}

/// Draws a figure to the file of --plot, if it is given.
pub fn plot(to: &Option<Out>, make: impl FnOnce() -> Result<Figure>) -> Result<()> {
    to.as_ref().map_or(Ok(()), |path| figure("--plot", path, &make()?))
}

/// Prints text to standard output, in colour on a terminal that supports it.
pub fn text(text: &str) -> Result<()> {
    // The only escape sequences in it are those of its colours.
    let text = painted(&shown(text));
    flushed(|out| anstream::AutoStream::auto(out).write_all(text.as_bytes()))
}

fn to_standard_output(bytes: &[u8]) -> Result<()> {
    flushed(|out| out.write_all(bytes))
}

fn flushed(write: impl FnOnce(&mut StdoutLock<'static>) -> std::io::Result<()>) -> Result<()> {
    let mut out = std::io::stdout().lock();
    write(&mut out)?;
    Ok(out.flush()?)
}

/// Draws `figure` to the file that `option` named, .svg or .png.
pub fn figure(option: &str, path: &Out, figure: &Figure) -> Result<()> {
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or("");
    let bytes = match extension.to_ascii_lowercase().as_str() {
        "svg" => figure.svg()?.into_bytes(),
        "png" => figure.png()?,
        _ => bail!("{option} {}: the file must end in .svg or .png", path.display()),
    };
    write(Some(path), &bytes)
}

/// Prints one line to standard output.
pub fn line(words: impl std::fmt::Display) -> Result<()> {
    text(&format!("{words}\n"))
}

/// Prints one line about an entry that was made. If the output fails, the message says that the entry exists.
pub fn entered(words: impl std::fmt::Display) -> Result<()> {
    line(&words).with_context(|| format!("{words}, but standard output failed"))
}

/// Prints a document as JSON, indented.
pub fn json(document: &impl serde::Serialize) -> Result<()> {
    json_text(&serde_json::to_string_pretty(document)?)
}

/// Prints JSON. Control characters can occur only in its texts, where they are escaped.
pub fn json_text(json: &str) -> Result<()> {
    let mut out = String::new();
    for c in json.chars() {
        if steers(c) && c != '\n' {
            out += &format!("\\u{:04x}", u32::from(c));
        } else {
            out.push(c);
        }
    }
    to_standard_output(format!("{out}\n").as_bytes())
}

/// Whether notes and progress are suppressed.
static QUIET: AtomicBool = AtomicBool::new(false);

/// Suppresses notes and progress from now on.
pub fn set_quiet(quiet: bool) {
    QUIET.store(quiet, Ordering::Relaxed);
}

/// Whether notes and progress are suppressed.
pub fn is_quiet() -> bool {
    QUIET.load(Ordering::Relaxed)
}

/// Prints a note to the user beside the result. A closed standard error is no failure.
pub fn note(text: impl std::fmt::Display) {
    if is_quiet() {
        return;
    }
    let _ = writeln!(std::io::stderr(), "note: {}", name(&text.to_string()));
}

/// Prints the reason of a failure.
pub fn complain(error: &anyhow::Error) {
    // Not eprintln!, which panics where standard error is closed.
    let _ = writeln!(std::io::stderr(), "stiction: {}", name(&failure(error)));
}

/// Prints errors in the arguments, in the words of their parser.
pub fn usage(text: &str) {
    let _ = write!(std::io::stderr(), "{}", shown(text));
}

/// A failure in one line: the attempt and the cause, with the options of this command. Causes that repeat the error
/// above them are left out.
fn failure(error: &anyhow::Error) -> String {
    let words = |cause: &(dyn std::error::Error + 'static)| match cause.downcast_ref() {
        Some(stiction_io::Error::Setting { settings, message }) => {
            format!("--set {}: {message}", settings.join(" --set "))
        }
        _ => cause.to_string(),
    };
    let mut line = String::new();
    for cause in error.chain() {
        let said = words(cause);
        match line.as_str() {
            "" => line = said,
            before if before.ends_with(&said) => {}
            _ => line += &format!(": {said}"),
        }
        line += remedy(cause);
    }
    line
}

/// A remedy for an error of the operating system, which gives no remedy.
fn remedy(cause: &(dyn std::error::Error + 'static)) -> &'static str {
    let Some(refused) = cause.downcast_ref::<std::io::Error>() else { return "" };
    match refused.kind() {
        // Our own errors name their remedy.
        _ if refused.raw_os_error().is_none() => "",
        ErrorKind::NotFound => "; correct the name",
        ErrorKind::NotADirectory => {
            "; the path has a file where a folder is needed, so correct the path"
        }
        ErrorKind::IsADirectory => "; name a file in this folder",
        ErrorKind::PermissionDenied => "; give this user access to it, or name another place",
        ErrorKind::ReadOnlyFilesystem => "; name a place with write permission",
        ErrorKind::StorageFull => "; free space on the disk, or name another place",
        ErrorKind::InvalidFilename => "; choose another name",
        _ => "",
    }
}

/// Whether the reader of our output has closed the pipe.
pub fn is_broken_pipe(error: &anyhow::Error) -> bool {
    error
        .chain()
        .filter_map(|cause| cause.downcast_ref::<std::io::Error>())
        .any(|cause| cause.kind() == ErrorKind::BrokenPipe)
}
