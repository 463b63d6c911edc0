//! The input and output files of a run, which must not be the same.
//!
//! Arguments that name a file are an [`In`] or an [`Out`], never a path. So `main` sees them all before a command runs,
//! and refuses an output that is an input or another output. Files that a command opens without a name from the user,
//! such as the recordings of an index or the pages of a folder, go through [`In::also`] and [`Out::inside`], which make
//! the same checks.

use crate::{output, replaced};
use anyhow::{Context, Result, bail};
use clap::builder::{MapValueParser, PathBufValueParser, TypedValueParser, ValueParserFactory};
use clap::{ArgMatches, Command};
use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::fs::Metadata;
use std::ops::Deref;
use std::path::{Path, PathBuf};
use std::sync::{LazyLock, Mutex, MutexGuard, PoisonError};
use stiction_io::Error::NoOp;
use stiction_io::reading::Format;

/// The name of standard input in messages.
pub const STANDARD_INPUT: &str = "standard input";

/// An input file of a run. `-` is standard input.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct In(PathBuf);

/// An output file or folder of a run. `-` is standard output.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Out(PathBuf);

impl In {
    /// An input that no argument names.
    pub fn also(path: impl Into<PathBuf>) -> Result<Self> {
        let path = path.into();
        run().read(&path, &format!("{}, which this run reads too", path.display()))?;
        Ok(Self(path))
    }

    /// Whether this is standard input.
    pub fn is_standard(&self) -> bool {
        self.0 == Path::new("-")
    }

    /// Name in messages.
    pub fn origin(&self) -> String {
        if self.is_standard() { STANDARD_INPUT.to_owned() } else { self.0.display().to_string() }
    }
}

/// The files that `named` names. For a folder, these are the files in it that are named like recordings, in order.
///
/// # Errors
/// If a folder cannot be listed or contains no recordings.
pub fn with_folders(named: &[In]) -> Result<Vec<In>> {
    let mut all = vec![];
    for each in named {
        if !each.is_dir() {
            all.push(each.clone());
            continue;
        }
        let there = std::fs::read_dir(&**each).with_context(|| each.origin())?;
        let mut paths: Vec<PathBuf> = there.flatten().map(|entry| entry.path()).collect();
        paths.retain(|path| path.is_file() && Format::is_named_like_one(path));
        paths.sort();
        if paths.is_empty() {
            bail!(
                "{}: no file in this folder has the name of a recording, such as a.csv",
                each.origin()
            );
        }
        for path in paths {
            all.push(In::also(path)?);
        }
    }
    Ok(all)
}

/// Whether an error only means that a file of a folder is not a recording. The user is notified. Files that are `named`
/// themselves must be recordings.
pub fn is_skipped(error: &anyhow::Error, named: &[In]) -> bool {
    let Some(NoOp { origin, has_times: false, .. }) = error.downcast_ref() else { return false };
    let is_of_folder = named.iter().all(|file| file.origin() != *origin);
    if is_of_folder {
        output::note(format!("{origin} is not a recording and is skipped"));
    }
    is_of_folder
}

impl Out {
    /// An output that no argument names, beside an input.
    pub fn also(path: impl Into<PathBuf>) -> Result<Self> {
        let path = path.into();
        run().check(&path)?;
        Ok(Self(path))
    }

    /// A file in this folder.
    pub fn inside(&self, name: impl AsRef<Path>) -> Result<Self> {
        Self::also(self.0.join(name))
    }

    /// Creates this folder if it is missing.
    pub fn make_folder(&self) -> Result<()> {
        make_folder(&self.0)
    }

    /// Whether this is standard output.
    pub fn is_standard(&self) -> bool {
        self.0 == Path::new("-")
    }
}

/// Creates a folder if it is missing.
pub fn make_folder(path: &Path) -> Result<()> {
    if let Some(file) = path.ancestors().find(|above| above.is_file()) {
        bail!("{}: is a file, but must be a folder; name another folder", file.display());
    }
    std::fs::create_dir_all(path).with_context(|| path.display().to_string())
}

/// Creates a folder if it is missing. Refuses a folder that contains files, unless --force is given.
pub fn make_empty_folder(path: &Path) -> Result<()> {
    let named = || path.display().to_string();
    make_folder(path)?;
    if !replaced::is_forced() && std::fs::read_dir(path).with_context(named)?.next().is_some() {
        bail!(
            "{} is not empty; --force writes to it and overwrites files of the same name",
            named()
        );
    }
    Ok(())
}

impl Deref for In {
    type Target = Path;

    fn deref(&self) -> &Path {
        &self.0
    }
}

impl Deref for Out {
    type Target = Path;

    fn deref(&self) -> &Path {
        &self.0
    }
}

impl ValueParserFactory for In {
    type Parser = MapValueParser<PathBufValueParser, fn(PathBuf) -> Self>;

    fn value_parser() -> Self::Parser {
        PathBufValueParser::new().map(Self)
    }
}

impl ValueParserFactory for Out {
    type Parser = MapValueParser<PathBufValueParser, fn(PathBuf) -> Self>;

    fn value_parser() -> Self::Parser {
        PathBufValueParser::new().map(Self)
    }
}

/// Registers all files that the arguments name, and refuses an output that is an input or another output.
pub fn note(command: &Command, matches: &ArgMatches) -> Result<()> {
    let Some((name, matches)) = matches.subcommand() else { return Ok(()) };
    let Some(command) = command.find_subcommand(name) else { return Ok(()) };
    // Files that a task of a command names belong to the same run.
    note(command, matches)?;
    let mut run = run();
    for argument in command.get_arguments() {
        let id = argument.get_id().as_str();
        let files = matches.try_get_many::<In>(id).ok().flatten();
        for file in files.into_iter().flatten() {
            let called = match argument.get_long() {
                Some(long) => format!("{}, the file of --{long}", file.origin()),
                None => format!("{}, which this run reads", file.origin()),
            };
            run.read(file, &called)?;
        }
    }
    for argument in command.get_arguments() {
        let id = argument.get_id().as_str();
        let Ok(Some(file)) = matches.try_get_one::<Out>(id) else { continue };
        let option = match argument.get_long() {
            Some(long) => format!("--{long}"),
            None => argument.get_id().to_string(),
        };
        run.written(file, &option)?;
    }
    Ok(())
}

/// Identifies a file by its path, or by a number that all links to the file share.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
enum Key {
    Path(PathBuf),
    #[cfg(unix)]
    Inode(u64, u64),
    StandardInput,
    StandardOutput,
}

/// The files of this run, each with its name in messages.
#[derive(Debug, Default)]
struct Run {
    read: HashMap<Key, String>,
    written: HashMap<Key, String>,
}

fn run() -> MutexGuard<'static, Run> {
    static RUN: LazyLock<Mutex<Run>> = LazyLock::new(Mutex::default);
    RUN.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Run {
    fn read(&mut self, file: &Path, called: &str) -> Result<()> {
        let keys = match file == Path::new("-") {
            true => match self.read.entry(Key::StandardInput) {
                Entry::Occupied(_) => bail!("standard input can be read only once; give - once"),
                Entry::Vacant(place) => {
                    place.insert(called.to_owned());
                    keys_of_standard_input()
                }
            },
            // A missing file cannot be lost.
            false => std::fs::metadata(file).map_or(vec![], |there| keys(file, Some(&there))),
        };
        for key in keys {
            if let Some(option) = self.written.get(&key) {
                bail!("{option} would overwrite {called}; name another file");
            }
            self.read.insert(key, called.to_owned());
        }
        Ok(())
    }

    fn written(&mut self, file: &Path, option: &str) -> Result<()> {
        for key in output_keys(file) {
            if let Some(input) = self.read.get(&key) {
                bail!("{option} {} would overwrite {input}; name another file", file.display());
            }
            match self.written.entry(key) {
                Entry::Occupied(other) if other.get() != option => {
                    bail!(
                        "{option} {} is also the output of {}, and one output would be lost; name another file",
                        file.display(),
                        other.get()
                    );
                }
                Entry::Occupied(_) => {}
                Entry::Vacant(place) => {
                    place.insert(option.to_owned());
                }
            }
        }
        Ok(())
    }

    /// Refuses a file that the run is about to write if an argument names it as an input or output.
    fn check(&self, file: &Path) -> Result<()> {
        for key in output_keys(file) {
            if let Some(input) = self.read.get(&key) {
                bail!("{} would overwrite {input}; name another folder", file.display());
            }
            if let Some(option) = self.written.get(&key) {
                bail!("{} is also the output of {option}; name another file", file.display());
            }
        }
        Ok(())
    }
}

fn output_keys(file: &Path) -> Vec<Key> {
    match file == Path::new("-") {
        true => vec![Key::StandardOutput],
        false => keys(file, std::fs::metadata(file).ok().as_ref()),
    }
}

/// The keys of a file that exists or may be created. Devices and pipes have no keys: nothing is lost there.
fn keys(file: &Path, there: Option<&Metadata>) -> Vec<Key> {
    if there.is_some_and(|there| !there.is_file() && !there.is_dir()) {
        return vec![];
    }
    let target = stiction_io::whole::end_of_links(file);
    let folder = match target.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    let full = match (target.canonicalize(), folder.canonicalize(), target.file_name()) {
        (Ok(full), ..) => full,
        (Err(_), Ok(folder), Some(name)) => folder.join(name),
        _ => target.clone(),
    };
    let mut keys = vec![Key::Path(full)];
    keys.extend(there.and_then(inode));
    keys
}

#[cfg(unix)]
fn inode(of: &Metadata) -> Option<Key> {
    use std::os::unix::fs::MetadataExt;
    of.is_file().then(|| Key::Inode(of.dev(), of.ino()))
}

#[cfg(not(unix))]
fn inode(_: &Metadata) -> Option<Key> {
    None
}

/// The keys of the file that is redirected to standard input, if any.
#[cfg(unix)]
fn keys_of_standard_input() -> Vec<Key> {
    use std::os::fd::AsFd;
    let file = std::io::stdin().as_fd().try_clone_to_owned().map(std::fs::File::from);
    file.and_then(|file| file.metadata()).ok().and_then(|there| inode(&there)).into_iter().collect()
}

#[cfg(not(unix))]
fn keys_of_standard_input() -> Vec<Key> {
    vec![]
}

#[cfg(test)]
mod tests {
    use super::{In, Out};
    use crate::Cli;
    use clap::CommandFactory;
    use clap::builder::ValueParser;
    use std::any::TypeId;
    use std::path::PathBuf;

    /// Arguments that name a file and more, so that their command reads it by `In::also`.
    const MORE: [(&str, &str); 6] = [
        ("simulate", "scenario"),
        ("compensate", "scenario"),
        ("what-if", "scenario"),
        ("limit-cycle", "scenario"),
        ("fmu", "scenario"),
        ("fmu", "library"),
    ];

    mod outputs {
        include!("../tests/cli/outputs.rs");
    }

    /// Those of a command and of its tasks.
    fn outputs_of(command: &clap::Command, found: &mut Vec<(String, String)>) {
        for argument in command.get_arguments() {
            if argument.get_value_parser().type_id() == TypeId::of::<Out>() {
                found.push((command.get_name().to_owned(), argument.get_id().to_string()));
            }
        }
        command.get_subcommands().for_each(|task| outputs_of(task, found));
    }

    /// The list is that of the test that tries to lose a recording by each of them.
    #[test]
    fn every_output_is_tried() {
        let mut found = vec![];
        outputs_of(&Cli::command(), &mut found);
        found.retain(|(command, argument)| {
            !outputs::OUTPUTS.iter().any(|of| (of.0, of.1) == (&**command, &**argument))
        });
        assert!(found.is_empty(), "not in the list: {found:?}");
    }

    /// A command with an output that is not asked for here would overwrite its input.
    #[test]
    fn every_argument_that_names_a_file_is_an_in_or_an_out() {
        let kind = |parser: &ValueParser| parser.type_id();
        let is = |parser: &ValueParser, of: TypeId| kind(parser) == of;
        let words = ["FILE", "FOLDER", "DIR", ".html", ".csv", "PATH", "OUT", "INDEX"];
        let (mut read, mut written) = (0, 0);
        for command in Cli::command().get_subcommands() {
            for argument in command.get_arguments() {
                let id = argument.get_id().as_str();
                let parser = argument.get_value_parser();
                let at = (command.get_name(), id);
                assert!(
                    !is(parser, TypeId::of::<PathBuf>()),
                    "{at:?} is a path: make it an In or Out"
                );
                read += usize::from(is(parser, TypeId::of::<In>()));
                written += usize::from(is(parser, TypeId::of::<Out>()));
                let known = is(parser, TypeId::of::<In>()) || is(parser, TypeId::of::<Out>());
                let names: Vec<_> = argument.get_value_names().unwrap_or_default().to_vec();
                let takes = argument.get_action().takes_values();
                let named = names.iter().any(|name| words.iter().any(|word| name.contains(word)));
                let like = ["input", "output", "file", "csv", "report", "plot"].contains(&id);
                if takes && (named || like) && !known {
                    assert!(MORE.contains(&at), "{at:?} names a file: make it an In or Out");
                }
            }
        }
        assert!(read >= 14 && written >= 20, "{read} inputs, {written} outputs");
    }
}
