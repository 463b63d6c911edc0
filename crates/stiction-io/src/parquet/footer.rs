//! Checks the footer of a Parquet file before the parquet crate reads it.

use super::thrift;

/// The mark at the beginning and end of a file.
pub const MAGIC: &[u8] = b"PAR1";

const MAGIC_ENCRYPTED: &[u8] = b"PARE";

/// The length of the footer and the mark, which end a file.
pub const TAIL: usize = 8;

/// Nesting depth at which the file is refused. Nested columns are refused anyway.
const MAX_SCHEMA_DEPTH: usize = 32;

/// The length of the footer with schema and places of pages. `head` and `tail` are the ends of a file with this many
/// bytes.
pub fn footer_length(head: &[u8], tail: &[u8], bytes: usize) -> Result<usize, String> {
    if bytes == 0 {
        return Err("is empty; a Parquet file is needed".to_owned());
    }
    let encrypted = "is encrypted and cannot be read; write it without encryption";
    if head.starts_with(MAGIC_ENCRYPTED) {
        return Err(encrypted.to_owned());
    }
    if !head.starts_with(MAGIC) {
        return Err("is not a Parquet file, which begins with \"PAR1\"".to_owned());
    }
    let short = "is cut short: a Parquet file ends with \"PAR1\"; copy or write it again";
    let body = match tail.strip_suffix(MAGIC) {
        Some(body) if bytes >= MAGIC.len() + TAIL => body,
        _ => return Err(short.to_owned()),
    };
    let Some((_, length)) = body.split_last_chunk() else { return Err(short.to_owned()) };
    let length = u32::from_le_bytes(*length) as usize;
    if length > bytes - TAIL - MAGIC.len() {
        return Err(format!(
            "claims a footer of {length} bytes, which is longer than the file; write it again"
        ));
    }
    Ok(length)
}

/// Refuses a footer that would make the parquet crate allocate more than the file contains, or recurse endlessly.
pub fn check_footer(footer: &[u8]) -> Result<(), String> {
    let damaged = || "its footer is damaged; write the file again".to_owned();
    let (fields, _) = thrift::Fields::read(footer).ok_or_else(damaged)?;
    if fields.fields(8).is_some() {
        return Err("is encrypted and cannot be read; write it without encryption".to_owned());
    }
    for schema in fields.all(2) {
        let mut elements = schema.as_list().iter();
        // Number of children still expected on every level.
        let mut open = vec![1usize];
        while let Some(level) = open.last_mut() {
            if *level == 0 {
                open.pop();
                continue;
            }
            *level -= 1;
            let element = elements.next().and_then(thrift::Value::as_fields).ok_or_else(damaged)?;
            // The crate uses the last of several fields with one number.
            let children = element.all(5).map(|value| match value {
                thrift::Value::Int(count) => usize::try_from(*count).unwrap_or(usize::MAX),
                _ => usize::MAX,
            });
            let children = children.max().unwrap_or(0);
            if children > elements.len() || open.len() > MAX_SCHEMA_DEPTH {
                return Err(damaged());
            }
            open.push(children);
        }
        if elements.next().is_some() {
            return Err(damaged());
        }
    }
    let chunks = fields.all(4).flat_map(|groups| groups.as_list());
    let chunks = chunks.filter_map(|group| group.as_fields()).flat_map(|group| group.all(1));
    for chunk in chunks.flat_map(|columns| columns.as_list()) {
        let encrypted = chunk.as_fields().is_some_and(|c| c.fields(8).is_some());
        if encrypted {
            return Err(
                "has encrypted columns and cannot be read; write it without encryption".to_owned()
            );
        }
    }
    Ok(())
}
