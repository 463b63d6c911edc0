//! Files written whole or not at all.
//!
//! The content goes to a temporary file in the same folder, is flushed to the disk, and takes the name of the file in
//! one step. After a full disk or an interruption, the previous file remains. A killed process leaves the temporary
//! file `.stiction-XXXXXX.part`, which patterns such as `*.csv` do not match. The writer holds a lock on it, so the
//! next run that writes to the folder recognises a leftover file and removes it.

use std::collections::HashSet;
use std::fs::{self, File, Permissions, TryLockError};
use std::io::{self, BufWriter, Error, ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::sync::{LazyLock, Mutex, PoisonError};
use tempfile::TempPath;

/// Beginning of a temporary file's name.
const PREFIX: &str = ".stiction-";
/// End of a temporary file's name.
const SUFFIX: &str = ".part";

/// A file that is being written. The file gets its name with [`keep`](Self::keep). Without that, nothing changes.
#[derive(Debug)]
pub struct WholeFile {
    out: BufWriter<File>,
    place: Option<Place>,
}

/// The final place of a complete file. A device or pipe has none, and is written directly.
#[derive(Debug)]
struct Place {
    beside: TempPath,
    target: PathBuf,
    /// The permissions of the previous file.
    permissions: Option<Permissions>,
}

/// Writes `bytes` to the file at `path`, whole or not at all.
///
/// # Errors
/// As for [`WholeFile::create`] and [`WholeFile::keep`].
pub fn write(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let mut file = WholeFile::create(path)?;
    file.write_all(bytes)?;
    file.keep()
}

impl WholeFile {
    /// Begins to write the file at `path`. A link remains, and its target is written.
    ///
    /// # Errors
    /// If the target is a folder or read-only, or its folder is missing or does not permit a new file.
    pub fn create(path: &Path) -> io::Result<Self> {
        let there = fs::metadata(path).ok();
        if let Some(there) = &there
            && there.is_dir()
        {
            return Err(Error::new(ErrorKind::IsADirectory, "is a folder; name a file"));
        }
        // A file that is open under this name, such as /dev/stdout, has other writers, too.
        let is_open = path.starts_with("/dev") || path.starts_with("/proc");
        if is_open || there.as_ref().is_some_and(|there| !there.is_file()) {
            return Ok(Self { out: BufWriter::new(File::create(path)?), place: None });
        }
        let permissions = there.map(|there| there.permissions());
        if permissions.as_ref().is_some_and(Permissions::readonly) {
            let message = "is read-only; allow writing to it, or name another file";
            return Err(Error::new(ErrorKind::PermissionDenied, message));
        }
        let target = end_of_links(path);
        let folder = match target.parent() {
            Some(folder) if !folder.as_os_str().is_empty() => folder,
            _ => Path::new("."),
        };
        fs::metadata(folder)?;
        remove_left_over_once(folder);
        let (out, beside) = loop {
            let (out, beside) = temporary(folder)?;
            // Another run may have taken it for a leftover before it was locked. Where files cannot be locked, nothing is
            // removed.
            let locked = out.try_lock();
            if !matches!(locked, Err(TryLockError::WouldBlock)) && beside.exists() {
                break (out, beside);
            }
        };
        Ok(Self { out: BufWriter::new(out), place: Some(Place { beside, target, permissions }) })
    }

    /// Finishes the file and gives it its name.
    ///
    /// # Errors
    /// If the rest cannot be written, or the name cannot be given. Then nothing has changed.
    pub fn keep(self) -> io::Result<()> {
        let file = self.out.into_inner().map_err(io::IntoInnerError::into_error)?;
        let Some(Place { beside, target, permissions }) = self.place else { return Ok(()) };
        if let Some(permissions) = permissions {
            file.set_permissions(permissions)?;
        }
        file.sync_all()?;
        drop(file);
        beside.persist(target).map_err(|refused| refused.error)
    }
}

impl Write for WholeFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.out.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.out.flush()
    }
}

/// A new temporary file in `folder`.
fn temporary(folder: &Path) -> io::Result<(File, TempPath)> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(PREFIX).suffix(SUFFIX);
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        // As for any new file, without the permissions that the user's mask removes.
        builder.permissions(Permissions::from_mode(0o666));
    }
    let made = builder.tempfile_in(folder).map_err(|error| match error.kind() {
        ErrorKind::PermissionDenied => Error::new(
            error.kind(),
            format!(
                "its folder, {}, does not permit new files; change the permission, or name another folder",
                folder.display()
            ),
        ),
        // Without the temporary name, which has no meaning for the user.
        kind => Error::from(kind),
    })?;
    Ok(made.into_parts())
}

/// Removes temporary files of killed writers in `folder` that nobody has locked. Files that cannot be removed stay.
pub fn remove_left_over(folder: &Path) {
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let name = entry.file_name();
        let name = name.to_string_lossy();
        if name.starts_with(PREFIX) && name.ends_with(SUFFIX) {
            remove_if_left_over(&entry.path());
        }
    }
}

/// Once per folder and process, so that a folder of many files is not listed for each of them.
fn remove_left_over_once(folder: &Path) {
    static SEEN: LazyLock<Mutex<HashSet<PathBuf>>> = LazyLock::new(Mutex::default);
    let first = SEEN.lock().unwrap_or_else(PoisonError::into_inner).insert(folder.to_owned());
    if first {
        remove_left_over(folder);
    }
}

/// Removes a temporary file that no writer holds. The lock is held until it is gone.
fn remove_if_left_over(path: &Path) {
    if fs::symlink_metadata(path).is_ok_and(|there| there.is_file())
        && let Ok(file) = File::open(path)
        && file.try_lock().is_ok()
    {
        let _ = fs::remove_file(path);
    }
}

/// The target of `path` after all links, which may not exist yet.
pub fn end_of_links(path: &Path) -> PathBuf {
    /// The number of links that Linux follows.
    const LINKS: usize = 40;
    let mut at = path.to_owned();
    for _ in 0..LINKS {
        let Ok(next) = fs::read_link(&at) else { break };
        at = at.parent().map_or_else(|| next.clone(), |folder| folder.join(&next));
    }
    at
}

#[cfg(test)]
mod tests {
    use super::*;
    #[test]
    fn what_killed_writers_left_is_removed_and_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        for name in [".stiction-left.part", ".stiction-x.txt", "stiction-x.part"] {
            File::create(at(name)).unwrap();
        }
        // Another writer, for which a lock of this process by another handle stands.
        let held = File::create(at(".stiction-held.part")).unwrap();
        held.try_lock().unwrap();
        write(&at("a.txt"), b"x").unwrap();
        let mut left: Vec<_> = fs::read_dir(folder.path())
            .unwrap()
            .map(|e| e.unwrap().file_name().into_string().unwrap())
            .collect();
        left.sort();
        assert_eq!(left, [".stiction-held.part", ".stiction-x.txt", "a.txt", "stiction-x.part"]);
        drop(held);
        remove_left_over(folder.path());
        assert!(!at(".stiction-held.part").exists());
        // A file that is being written is held.
        let begun = WholeFile::create(&at("b.txt")).unwrap();
        remove_left_over(folder.path());
        begun.keep().unwrap();
        assert!(at("b.txt").exists());
    }

    #[test]
    fn files_are_replaced_whole_and_links_stay() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("a.txt");
        for text in ["first", "second"] {
            write(&file, text.as_bytes()).unwrap();
            assert_eq!(fs::read_to_string(&file).unwrap(), text);
        }
        // What is not kept has not happened.
        let mut begun = WholeFile::create(&file).unwrap();
        begun.write_all(b"third").unwrap();
        drop(begun);
        assert_eq!(fs::read_to_string(&file).unwrap(), "second");
        #[cfg(unix)]
        {
            use std::os::unix::fs::{PermissionsExt, symlink};
            fs::set_permissions(&file, Permissions::from_mode(0o640)).unwrap();
            let (link, dangling) = (folder.path().join("link"), folder.path().join("dangling"));
            symlink("a.txt", &link).unwrap();
            symlink("new.txt", &dangling).unwrap();
            write(&link, b"fourth").unwrap();
            write(&dangling, b"new").unwrap();
            assert!(link.is_symlink() && dangling.is_symlink());
            assert_eq!(fs::read_to_string(&file).unwrap(), "fourth");
            assert_eq!(fs::metadata(&file).unwrap().permissions().mode() & 0o777, 0o640);
            assert_eq!(fs::read_to_string(folder.path().join("new.txt")).unwrap(), "new");
            write(Path::new("/dev/null"), b"x").unwrap();
            fs::set_permissions(&file, Permissions::from_mode(0o440)).unwrap();
            let refused = write(&file, b"fifth").unwrap_err().to_string();
            assert!(refused.starts_with("is read-only"), "{refused}");
            assert_eq!(fs::read_to_string(&file).unwrap(), "fourth");
        }
        assert!(write(&folder.path().join("b/c"), b"x").unwrap_err().kind() == ErrorKind::NotFound);
        assert!(write(folder.path(), b"x").unwrap_err().kind() == ErrorKind::IsADirectory);
        let left = fs::read_dir(folder.path()).unwrap().flatten();
        assert!(!left.into_iter().any(|e| e.file_name().to_string_lossy().ends_with(SUFFIX)));
    }
}
