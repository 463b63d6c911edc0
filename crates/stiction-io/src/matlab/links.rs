//! Links from an HDF5 file to other files, which a reader should neither follow nor silently skip.
//!
//! The HDF5 library lists the targets of links, and so omits links to other files. They are found by the form of
//! their messages, after "HDF5 File Format Specification", section IV.A.2.g. A message has version 1, flags, type 64,
//! the name with its length, and the length of the rest. The rest is a zero, the file and the path in it, each ended
//! by a zero. Groups of the old form have no such links.

/// The type of an external link.
const EXTERNAL: u8 = 64;

/// Flags for the number of bytes in the length of the name, and for optional fields.
const SIZE_OF_LENGTH: u8 = 0b11;
const HAS_ORDER: u8 = 0b100;
const HAS_TYPE: u8 = 0b1000;
const HAS_CHARSET: u8 = 0b1_0000;
const ALL_FLAGS: u8 = 0b1_1111;

/// The names of the links in `bytes` that lead to other files.
pub fn external(bytes: &[u8]) -> Vec<String> {
    let begins = |at: &usize| matches!(bytes[*at..], [1, flags, EXTERNAL, ..] if flags & HAS_TYPE != 0 && flags <= ALL_FLAGS);
    (0..bytes.len()).filter(begins).filter_map(|at| link(&bytes[at + 1..])).collect()
}

/// The name of the link whose flags are at the beginning of `message`, if it is one.
fn link(message: &[u8]) -> Option<String> {
    let (flags, rest) = message.split_first()?;
    let order = if flags & HAS_ORDER == 0 { 0 } else { 8 };
    let charset = usize::from(flags & HAS_CHARSET != 0);
    let rest = rest.get(1 + order + charset..)?;
    let (length, rest) = rest.split_at_checked(1 << (flags & SIZE_OF_LENGTH))?;
    let length = length.iter().rev().fold(0u64, |sum, byte| sum << 8 | u64::from(*byte));
    let (name, rest) = rest.split_at_checked(usize::try_from(length).ok()?)?;
    let (length, rest) = rest.split_first_chunk()?;
    let target = rest.get(..u16::from_le_bytes(*length).into())?;
    let [0, file_and_path @ .., 0] = target else { return None };
    let mut parts = file_and_path.split(|byte| *byte == 0);
    let is_text = |part: &[u8]| {
        !part.is_empty() && str::from_utf8(part).is_ok_and(|text| !text.contains(char::is_control))
    };
    let [file, path] = [parts.next()?, parts.next()?];
    (parts.next().is_none() && [name, file, path].into_iter().all(is_text))
        .then(|| String::from_utf8_lossy(name).into_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn message(flags: u8, between: &[u8], name: &str, target: &[u8]) -> Vec<u8> {
        let mut bytes = vec![9, 1, flags, EXTERNAL];
        bytes.extend(between);
        bytes.push(name.len() as u8);
        bytes.extend(name.as_bytes());
        bytes.extend((target.len() as u16).to_le_bytes());
        bytes.extend(target);
        bytes
    }

    #[test]
    fn external_links_are_found_and_nothing_else() {
        let target = b"\0other.h5\0/pv\0";
        assert_eq!(external(&message(0x08, &[], "pv", target)), ["pv"]);
        assert_eq!(external(&message(0x1c, &[7, 0, 0, 0, 0, 0, 0, 0, 1], "op", target)), ["op"]);
        // No flag of a type, no path, a name with a control character, and cut short.
        assert!(external(&message(0x10, &[1], "pv", target)).is_empty());
        assert!(external(&message(0x08, &[], "pv", b"\0other.h5\0")).is_empty());
        assert!(external(&message(0x08, &[], "p\n", target)).is_empty());
        let whole = message(0x08, &[], "pv", target);
        assert!((0..whole.len()).all(|end| external(&whole[..end]).is_empty()));
    }
}
