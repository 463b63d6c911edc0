//! Decodes the bytes of a text file.

use crate::error::{Error, Result};
use encoding_rs::{Encoding, UTF_8, UTF_16BE, UTF_16LE, WINDOWS_1252};
use std::borrow::Cow;

/// A text and its encoding.
#[derive(Debug)]
pub struct Decoded<'b> {
    /// The characters, without a byte order mark.
    pub text: Cow<'b, str>,
    /// Name of the encoding, such as `UTF-8`.
    pub encoding: &'static str,
    /// A note on the encoding for the user.
    pub note: Option<String>,
}

/// The text in `bytes`, in UTF-8, in UTF-16 with or without a byte order mark, or else in Windows-1252, the common
/// superset of Latin-1.
///
/// # Errors
/// If the bytes are not text, or begin like a Unicode encoding but are not valid in it.
pub fn decode<'b>(bytes: &'b [u8], origin: &str) -> Result<Decoded<'b>> {
    let wrong = |message: String| Error::Table { origin: origin.to_owned(), message };
    let marked = Encoding::for_bom(bytes);
    let utf_16 = marked.map(|(encoding, _)| encoding).or_else(|| utf_16(bytes));
    let (encoding, start) = match (marked, utf_16) {
        (Some(marked), _) => marked,
        (None, Some(encoding)) => (encoding, 0),
        (None, None) if std::str::from_utf8(bytes).is_ok() => (UTF_8, 0),
        (None, None) => (WINDOWS_1252, 0),
    };
    let Some(text) = encoding.decode_without_bom_handling_and_without_replacement(&bytes[start..])
    else {
        let name = encoding.name();
        return Err(wrong(format!(
            "begins like {name} text, but is not valid {name}; export it again as UTF-8"
        )));
    };
    if let Some(at) = text.find('\0') {
        let line = text[..at].matches('\n').count() + 1;
        return Err(wrong(format!(
            "line {line} holds a zero byte, so this is not text; give a CSV file"
        )));
    }
    let note = (encoding == WINDOWS_1252).then(|| {
        let valid = std::str::from_utf8(bytes).map_or_else(|e| e.valid_up_to(), str::len);
        let line = bytes[..valid].iter().filter(|b| **b == b'\n').count() + 1;
        format!("line {line} is not UTF-8; the file is read as Windows-1252 (Latin-1)")
    });
    Ok(Decoded { text, encoding: encoding.name(), note })
}

/// Whether `bytes` begin like a format other than text.
pub fn has_signature(bytes: &[u8]) -> bool {
    const SIGNATURES: [&[u8]; 3] = [b"PAR1", b"MATLAB 5.0", b"MATLAB 7.3"];
    SIGNATURES.iter().any(|signature| bytes.starts_with(signature))
}

/// Detects UTF-16 without a byte order mark. Its first characters belong to a header and are mostly ASCII, so every
/// second byte is zero.
fn utf_16(bytes: &[u8]) -> Option<&'static Encoding> {
    let start = &bytes[..bytes.len().min(64) & !1];
    let zeros = |offset| start.iter().skip(offset).step_by(2).filter(|b| **b == 0).count();
    let most = start.len() / 4;
    match (zeros(0), zeros(1)) {
        (0, odd) if odd > most => Some(UTF_16LE),
        (even, 0) if even > most => Some(UTF_16BE),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn encoded(text: &str, unit: impl Fn(u16) -> [u8; 2]) -> Vec<u8> {
        text.encode_utf16().flat_map(unit).collect()
    }

    #[test]
    fn every_encoding_gives_the_same_text() {
        let text = "time,pv,op\n0,21.5 °C,é\n";
        let cases = [
            (text.as_bytes().to_vec(), "UTF-8"),
            (format!("\u{feff}{text}").into_bytes(), "UTF-8"),
            (encoded(text, u16::to_le_bytes), "UTF-16LE"),
            (encoded(text, u16::to_be_bytes), "UTF-16BE"),
            (encoded(&format!("\u{feff}{text}"), u16::to_le_bytes), "UTF-16LE"),
            (encoded(&format!("\u{feff}{text}"), u16::to_be_bytes), "UTF-16BE"),
            (text.chars().map(|c| c as u8).collect(), "windows-1252"),
        ];
        for (bytes, encoding) in cases {
            let decoded = decode(&bytes, "f.csv").unwrap();
            assert_eq!((&*decoded.text, decoded.encoding), (text, encoding));
            assert_eq!(decoded.note.is_some(), encoding == "windows-1252");
        }
    }

    #[test]
    fn what_is_no_text_is_an_error() {
        for (bytes, expected) in [
            (&b"a,b\n1,\0\n"[..], "line 2 holds a zero byte"),
            (b"\xef\xbb\xbfa,\xff\n", "begins like UTF-8 text, but is not valid UTF-8"),
            (b"\xff\xfea\0,\0b", "begins like UTF-16LE text"),
        ] {
            let message = decode(bytes, "f.csv").unwrap_err().to_string();
            assert!(message.contains(expected), "{message}");
        }
    }
}
