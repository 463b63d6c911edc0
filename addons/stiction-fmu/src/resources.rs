//! The parameters inside an FMU, in its resources.

use std::path::{Path, PathBuf};

use crate::fmu::Fmu;

/// The file's name.
const FILE: &str = "stiction.json";

/// Larger than any file of parameters.
const MOST_BYTES: u64 = 1 << 20;

/// Reads the parameters in this directory.
pub(crate) fn read(directory: &Path) -> Result<Fmu, String> {
    let path = directory.join(FILE);
    let refuse =
        |why: String| format!("the parameters in {} cannot be used: {why}", path.display());
    let size = std::fs::metadata(&path).map_err(|e| refuse(e.to_string()))?.len();
    if size > MOST_BYTES {
        return Err(refuse(format!(
            "the file has {size} bytes, more than the allowed {MOST_BYTES}"
        )));
    }
    let text = std::fs::read_to_string(&path).map_err(|e| refuse(e.to_string()))?;
    Fmu::from_json(&text).map_err(refuse)
}

/// The directory of a `file:` URI, as in FMI 2.0.
pub(crate) fn directory(uri: &str) -> Result<PathBuf, String> {
    let refuse = || format!("the location of the resources, \"{uri}\", is not a file: URI");
    let scheme = uri.get(..5).ok_or_else(refuse)?;
    if !scheme.eq_ignore_ascii_case("file:") {
        return Err(refuse());
    }
    let path = &uri[5..];
    // file:/path, file:///path, file://localhost/path, file://server/share/path
    let path = match path.strip_prefix("//") {
        Some(rest) if is_drive(rest) => rest,
        Some(rest) => {
            let (host, path) = rest.split_at(rest.find('/').ok_or_else(refuse)?);
            let here = host.is_empty() || host.eq_ignore_ascii_case("localhost");
            // Windows reaches other machines by such paths.
            if here || !cfg!(windows) { path } else { &uri[5..] }
        }
        None => path,
    };
    let path = decoded(path).ok_or_else(refuse)?;
    let drive = path.strip_prefix('/').filter(|rest| is_drive(rest));
    Ok(PathBuf::from(drive.unwrap_or(&path)))
}

/// Whether a path begins with a drive of Windows.
fn is_drive(path: &str) -> bool {
    matches!(path.as_bytes(), [letter, b':', ..] if letter.is_ascii_alphabetic())
}

/// The text with its `%20` and similar codes decoded.
fn decoded(text: &str) -> Option<String> {
    let mut bytes = vec![];
    let mut rest = text.bytes();
    while let Some(byte) = rest.next() {
        bytes.push(if byte == b'%' {
            let digit = |byte: Option<u8>| (byte? as char).to_digit(16);
            (digit(rest.next())? * 16 + digit(rest.next())?) as u8
        } else {
            byte
        });
    }
    String::from_utf8(bytes).ok()
}

#[cfg(test)]
mod tests {
    use super::directory;
    use std::path::Path;

    #[test]
    fn uris_name_directories() {
        for (uri, path) in [
            ("file:///tmp/a%20b/resources", "/tmp/a b/resources"),
            ("file:/tmp/resources", "/tmp/resources"),
            ("file://localhost/tmp/resources", "/tmp/resources"),
            ("FILE:///C:/fmu/resources", "C:/fmu/resources"),
            ("file:/C:/fmu/resources", "C:/fmu/resources"),
            ("file://c:/fmu/resources", "c:/fmu/resources"),
            ("file:///C:%5Cfmu%5Cresources", "C:\\fmu\\resources"),
            ("file:///D:/%C3%BCbung/resources/", "D:/\u{fc}bung/resources/"),
            (
                "file://server/share/resources",
                if cfg!(windows) { "//server/share/resources" } else { "/share/resources" },
            ),
        ] {
            assert_eq!(directory(uri).unwrap(), Path::new(path));
        }
        for uri in ["", "http://a/b", "file://", "file:///%zz", "file:///%ff", "/tmp", "ä:ööö"]
        {
            assert!(directory(uri).is_err(), "{uri}");
        }
    }
}
