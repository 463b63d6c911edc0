//! Changes the file of overrides under a lock, whole or not at all.

use super::entry::Override;
use super::text::{in_toml, pieces};
use std::fs::File;
use std::path::Path;
use stiction_io::{Error, Result};
use stiction_io::{bytes, whole};

/// Name of the empty lock file in the folder of the overrides. The file is not removed, because another process may
/// have just locked it.
const LOCK_NAME: &str = ".stiction-overrides.lock";

const HEAD: &str = "# Conclusions of people about valves, kept by `stiction override`.\n\
    # The computed verdict is always shown beside them.\n\n";

/// Adds an override to the file at `path`, see [`with`], even if others change the file at the same time.
///
/// # Errors
/// If the file cannot be locked, read or written, or as for [`with`].
pub fn enter(path: &Path, one: &Override) -> Result<()> {
    change(path, |bytes, origin| Ok((with(bytes, origin, one)?, ())))
}

/// Removes the overrides that are `unwanted` from the file at `path`, and returns their number.
///
/// # Errors
/// If the file cannot be locked, read or written, or as for [`without`].
pub fn remove(path: &Path, unwanted: impl Fn(&Override) -> bool) -> Result<usize> {
    change(path, |bytes, origin| without(bytes, origin, unwanted))
}

/// Reads the file, changes it and writes it whole, under a lock.
fn change<T>(path: &Path, edit: impl FnOnce(&[u8], &str) -> Result<(Vec<u8>, T)>) -> Result<T> {
    let refused = |path: &Path, source| Error::File { path: path.display().to_string(), source };
    let lock_path = whole::end_of_links(path).with_file_name(LOCK_NAME);
    let lock = File::options().create(true).write(true).truncate(false).open(&lock_path);
    let lock = lock.map_err(|e| refused(&lock_path, e))?;
    lock.lock().map_err(|e| refused(&lock_path, e))?;
    let bytes = read_if_there(path)?;
    let (made, done) = edit(&bytes, &path.display().to_string())?;
    if made != bytes {
        whole::write(path, &made).map_err(|e| refused(path, e))?;
    }
    Ok(done)
}

/// The bytes of the file at `path`; none if the file does not exist.
pub fn read_if_there(path: &Path) -> Result<Vec<u8>> {
    match bytes::read(path) {
        Err(Error::File { source, .. }) if source.kind() == std::io::ErrorKind::NotFound => {
            Ok(vec![])
        }
        read => read,
    }
}

/// The bytes of a file of overrides with one more override. The new override replaces overrides of the same loop and
/// scope with overlapping days. All other content, such as comments and damaged entries, is unchanged.
///
/// # Errors
/// If an override to be replaced is not written as its own `[[override]]` table.
pub fn with(bytes: &[u8], origin: &str, one: &Override) -> Result<Vec<u8>> {
    let (mut made, removed) =
        edited(bytes, origin, |other| one.rivals(other) && one.overlaps(other))?;
    let new = in_toml(one);
    match removed.first() {
        Some(place) => {
            made.splice(place..place, new.into_bytes());
        }
        None if made.trim_ascii().is_empty() => made = format!("{HEAD}{new}").into_bytes(),
        None => {
            // A file that was cut may end within a line.
            let blank: &[u8] = if made.ends_with(b"\n") { b"\n" } else { b"\n\n" };
            made.extend_from_slice(blank);
            made.extend(new.into_bytes());
        }
    }
    Ok(made)
}

/// The bytes of a file of overrides without those that are `unwanted`, and their number.
///
/// # Errors
/// If an override to be removed is not written as its own `[[override]]` table.
pub fn without(
    bytes: &[u8],
    origin: &str,
    unwanted: impl Fn(&Override) -> bool,
) -> Result<(Vec<u8>, usize)> {
    let (made, removed) = edited(bytes, origin, unwanted)?;
    Ok((made, removed.len()))
}

/// The bytes without the overrides that are `unwanted`, and their places. Comments stay.
fn edited(
    bytes: &[u8],
    origin: &str,
    unwanted: impl Fn(&Override) -> bool,
) -> Result<(Vec<u8>, Vec<usize>)> {
    let (mut made, mut removed) = (vec![], vec![]);
    for piece in pieces(bytes) {
        let text = &bytes[piece.range.clone()];
        let unwanted = piece.found.iter().flatten().find(|(_, each)| unwanted(each));
        let Some((line, _)) = unwanted else {
            made.extend_from_slice(text);
            continue;
        };
        if !text.starts_with(b"[[") {
            let message = "override: write each as a table of its own, [[override]]".to_owned();
            return Err(Error::Overrides { origin: origin.to_owned(), line: *line, message });
        }
        removed.push(made.len());
        made.extend_from_slice(&text[end_of_entry(text)..]);
    }
    Ok((made, removed))
}

/// Where an entry ends and the comments above the next one begin.
fn end_of_entry(text: &[u8]) -> usize {
    let mut end = text.len();
    for line in text.split_inclusive(|b| *b == b'\n').rev() {
        let bare = line.trim_ascii();
        if !(bare.is_empty() || bare.starts_with(b"#")) {
            break;
        }
        end -= line.len();
    }
    end
}
