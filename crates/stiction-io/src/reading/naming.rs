//! Names of loops, and other information that a file gives beside its columns.

use crate::columns::layout::LoopPlan;
use crate::sheet::Sheet;
use std::path::Path;

/// Names of loops that no column names.
pub struct Names<'a> {
    pub origin: &'a str,
    /// Length of the common beginning of the parts' names.
    pub parts: usize,
    pub several: bool,
}

impl Names<'_> {
    /// The name of a loop, and whether the file gives it.
    pub fn of(&self, plan: &LoopPlan, sheet: &Sheet) -> (String, bool) {
        let part = sheet.part.get(self.parts..).unwrap_or("");
        let name = match (&plan.name, part) {
            (Some(name), part) if part.is_empty() || !self.several => name.clone(),
            (Some(name), part) => format!("{part}.{name}"),
            (None, part) if !part.is_empty() && self.several => part.to_owned(),
            (None, _) => match attribute(sheet, &["tag", "loop", "name"]) {
                Some(told) => told.to_owned(),
                None => {
                    let stem = Path::new(self.origin).file_stem();
                    let stem = stem.map(|stem| stem.to_string_lossy().into_owned());
                    return (stem.unwrap_or(self.origin.to_owned()), false);
                }
            },
        };
        (name, true)
    }
}

/// Length of the common beginning of the parts of all sheets, up to a dot.
pub fn common_start(sheets: &[Sheet]) -> usize {
    let Some((first, others)) = sheets.split_first() else { return 0 };
    let ends = first.part.match_indices('.').map(|(at, _)| at + 1);
    ends.rev()
        .find(|end| others.iter().all(|sheet| sheet.part.starts_with(&first.part[..*end])))
        .unwrap_or(0)
}

/// The information of a file beside its columns under one of the `keys`.
pub fn attribute<'s>(sheet: &'s Sheet, keys: &[&str]) -> Option<&'s str> {
    let same = |key: &str| keys.contains(&&*key.to_lowercase().replace([' ', '-'], "_"));
    sheet.attributes.iter().find(|(key, _)| same(key)).map(|(_, value)| &**value)
}
