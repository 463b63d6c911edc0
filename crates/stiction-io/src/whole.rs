//! Files written whole or not at all.
//!
//! What is written goes to a temporary file in the same folder, is flushed to the disk, and takes the name of the file
//! in one step. A full disk, or an end in between, leaves what was there before. Who is killed leaves the temporary file:
//! it is called `.stiction-XXXXXX.part`, which no pattern such as `*.csv` takes for data, and may be removed.

use std::fs::{self, File, Permissions};
use std::io::{self, BufWriter, Error, ErrorKind, Write};
use std::path::{Path, PathBuf};
use tempfile::TempPath;

/// What the name of a temporary file begins with.
const PREFIX: &str = ".stiction-";
/// What it ends with.
const SUFFIX: &str = ".part";

/// A file that is being written. It takes its name with [`keep`](Self::keep); without that, nothing has happened.
#[derive(Debug)]
pub struct WholeFile {
    out: BufWriter<File>,
    place: Option<Place>,
}

/// Where a file goes when it is whole; a device or pipe has no such place, and is written as it is.
#[derive(Debug)]
struct Place {
    beside: TempPath,
    target: PathBuf,
    /// Those of the file that was there.
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
    /// Begins to write the file at `path`. A link stays one: what it leads to is written.
    ///
    /// # Errors
    /// If it is a folder or read-only, or its folder is missing or takes no new file.
    pub fn create(path: &Path) -> io::Result<Self> {
        let there = fs::metadata(path).ok();
        if let Some(there) = &there
            && there.is_dir()
        {
            return Err(Error::new(ErrorKind::IsADirectory, "is a folder; name a file"));
        }
        // What stands there under the name of an open file, such as /dev/stdout, is written by others, too.
        let is_open = path.starts_with("/dev") || path.starts_with("/proc");
        if is_open || there.as_ref().is_some_and(|there| !there.is_file()) {
            return Ok(Self { out: BufWriter::new(File::create(path)?), place: None });
        }
        let permissions = there.map(|there| there.permissions());
        if permissions.as_ref().is_some_and(Permissions::readonly) {
            let message = "is read-only; permit writing it, or name another file";
            return Err(Error::new(ErrorKind::PermissionDenied, message));
        }
        let target = end_of_links(path);
        let folder = match target.parent() {
            Some(folder) if !folder.as_os_str().is_empty() => folder,
            _ => Path::new("."),
        };
        fs::metadata(folder)?;
        let mut builder = tempfile::Builder::new();
        builder.prefix(PREFIX).suffix(SUFFIX);
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt;
            // As for any new file: less what the user's mask takes away.
            builder.permissions(Permissions::from_mode(0o666));
        }
        let (out, beside) = builder
            .tempfile_in(folder)
            .map_err(|error| match error.kind() {
                ErrorKind::PermissionDenied => Error::new(
                    error.kind(),
                    format!(
                        "its folder, {}, takes no new file; permit that, or name another",
                        folder.display()
                    ),
                ),
                // Without the temporary name, which tells nobody anything.
                kind => Error::from(kind),
            })?
            .into_parts();
        Ok(Self { out: BufWriter::new(out), place: Some(Place { beside, target, permissions }) })
    }

    /// Ends the file and gives it its name.
    ///
    /// # Errors
    /// If what is left cannot be written, or the name cannot be given; then nothing has happened.
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

/// The file that `path` names, by whatever links; it may be one that is still to be made.
pub fn end_of_links(path: &Path) -> PathBuf {
    /// As many links as Linux follows.
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
