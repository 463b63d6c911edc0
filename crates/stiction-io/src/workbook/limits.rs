//! Recognises the kind of a workbook, and refuses those that would take too much memory before they are decoded.

use super::{Kind, unread};
use crate::budget::Budget;
use calamine::Data;
use std::io::{Cursor, Read, copy, sink};
use zip::ZipArchive;

pub(super) const PASSWORD: &str =
    "is encrypted with a password; save it without a password, or save the sheet as CSV";

/// Beginning of the files of Microsoft's compound format.
const COMPOUND: &[u8] = b"\xd0\xcf\x11\xe0";

/// The kind of the workbook in `bytes`.
///
/// # Errors
/// If the bytes are not a workbook, the workbook is encrypted, or reading it would exceed the budget.
pub(super) fn check(bytes: &[u8], budget: &mut Budget) -> Result<Kind, String> {
    if bytes.starts_with(COMPOUND) {
        let name: Vec<u8> = "EncryptedPackage".bytes().flat_map(|byte| [byte, 0]).collect();
        if bytes.windows(name.len()).any(|window| window == name) {
            return Err(PASSWORD.to_owned());
        }
        let (rows, columns) = extent(bytes);
        budget.spend(rows.saturating_mul(columns).saturating_mul(size_of::<Data>()))?;
        return Ok(Kind::Xls);
    }
    let mut archive = ZipArchive::new(Cursor::new(bytes)).map_err(unread)?;
    let names: Vec<String> =
        archive.file_names().filter_map(|name| Some(name.ok()?.to_lowercase())).collect();
    let ends = |end: &str| names.iter().any(|name| name.ends_with(end));
    let kind = match () {
        () if ends("workbook.bin") => Kind::Xlsb,
        () if ends("workbook.xml") => Kind::Xlsx,
        () if ends("content.xml") => Kind::Ods,
        () => {
            return Err("is a ZIP archive without a workbook; unpack it, and give the files in it"
                .to_owned());
        }
    };
    for index in 0..archive.len() {
        let entry = archive.by_index(index).map_err(unread)?;
        let name = entry.name().map_err(unread)?.to_lowercase();
        let left = budget.left() as u64 + 1;
        if kind == Kind::Ods && name == "content.xml" {
            let mut content = vec![];
            entry.take(left).read_to_end(&mut content).map_err(unread)?;
            budget.spend(content.len())?;
            budget.spend(repeated(&content).saturating_mul(size_of::<Data>()))?;
        } else if [".xml", ".bin", ".rels"].iter().any(|end| name.ends_with(end)) {
            let length = copy(&mut entry.take(left), &mut sink()).map_err(unread)?;
            budget.spend(usize::try_from(length).unwrap_or(usize::MAX))?;
        }
    }
    Ok(kind)
}

/// Rows and columns that the cells of an old Excel file reach, because its sheets are allocated at once from the
/// farthest cells.
///
/// The records of a sheet are stored one after another. Each record has a type and a length. A cell's record continues
/// with row and column.
fn extent(bytes: &[u8]) -> (usize, usize) {
    const FIRST: usize = 0x0809;
    const LAST: usize = 0x000a;
    let word =
        |at: usize| bytes.get(at..at + 2).map_or(0, |b| usize::from(b[0]) | usize::from(b[1]) << 8);
    let long = |at: usize| word(at) | word(at + 2) << 16;
    let (mut rows, mut columns, mut at) = (0, 0, 0);
    while at + 4 < bytes.len() {
        if word(at) != FIRST || !matches!(word(at + 2), 8 | 16) {
            at += 1;
            continue;
        }
        while at + 4 < bytes.len() && word(at) != LAST {
            let (kind, length) = (word(at), word(at + 2));
            let (row, column) = match (kind, length) {
                // Number, small number, shared text, truth value or error, formula, text.
                (0x0203 | 0x027e | 0x00fd | 0x0205 | 0x0006 | 0x0204 | 0x00d6, 8..) => {
                    (word(at + 4) + 1, word(at + 6) + 1)
                }
                // Small numbers of several columns.
                (0x00bd, 6..) => (word(at + 4) + 1, word(at + 2 + length) + 1),
                // The extent that the sheet states.
                (0x0200, 14) => (long(at + 8), word(at + 14)),
                _ => (0, 0),
            };
            rows = rows.max(row);
            columns = columns.max(column);
            at += 4 + length;
        }
    }
    (rows, columns)
}

/// The number of cells that the content of an OpenDocument file becomes, where it states repeated rows and columns in
/// short.
fn repeated(content: &[u8]) -> usize {
    let content = String::from_utf8_lossy(content);
    let repeats = |text: &str, attribute: &str| {
        let number = text.split_once(attribute).and_then(|(_, rest)| rest.split('"').nth(1));
        number.and_then(|number| number.parse::<usize>().ok()).unwrap_or(1)
    };
    let mut all = 0usize;
    for table in content.split("<table:table ").skip(1) {
        let (mut empty, mut used, mut width) = (0usize, 0usize, 0usize);
        for row in table.split("<table:table-row").skip(1) {
            let (head, cells) = row.split_once('>').unwrap_or((row, ""));
            let count = repeats(head, "number-rows-repeated=").min(1 << 20);
            let mut last = 0usize;
            let mut at = 0usize;
            for cell in cells.split("table-cell").skip(1).filter(|cell| !cell.starts_with('>')) {
                let head = cell.split('>').next().unwrap_or("");
                at = at.saturating_add(repeats(head, "number-columns-repeated=").min(1 << 14));
                if cell.contains("office:") || cell.contains("text:p") || cell.contains("formula=")
                {
                    last = at;
                }
            }
            match last {
                0 => empty = empty.saturating_add(count),
                last => {
                    used = used.saturating_add(empty).saturating_add(count);
                    empty = 0;
                    width = width.max(last);
                }
            }
        }
        all = all.saturating_add(used.saturating_mul(width));
    }
    all
}
