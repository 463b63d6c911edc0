//! Columns and tags whose roles the user gives.

use super::plan::MissingLoop;
use crate::columns::options::{Mapped, ReadOptions};
use crate::columns::role;
use crate::error::{Error, Result};
use crate::names::list;
use crate::remedy::{Remedy, Wording};
use crate::sheet::Sheet;
use std::collections::{HashMap, HashSet};

/// The user's information on columns and tags, by their names.
pub struct Given<'o> {
    pub options: &'o ReadOptions,
    exactly: HashMap<&'o str, usize>,
    in_lower_case: HashMap<String, usize>,
}

impl<'o> Given<'o> {
    pub fn of(options: &'o ReadOptions) -> Self {
        // The last of several counts.
        let columns = || options.map.iter().enumerate().map(|(place, each)| (&*each.column, place));
        let in_lower_case = columns().map(|(column, place)| (column.to_lowercase(), place));
        Self { options, exactly: columns().collect(), in_lower_case: in_lower_case.collect() }
    }

    /// The given role of the column or tag called `name`, with or without its unit.
    pub fn mapped(&self, name: &str) -> Option<&'o Mapped> {
        let loosely = |name: &str| self.in_lower_case.get(&name.to_lowercase());
        let place = self.exactly.get(name).or_else(|| loosely(name)).or_else(|| {
            loosely(role::without_place(name)).max(loosely(role::without_unit(name).0))
        })?;
        Some(&self.options.map[*place])
    }
}

/// The loops whose given columns are missing. A missing column that is given for no loop is an error.
pub fn missing(
    sheet: &Sheet,
    names: &[&str],
    options: &ReadOptions,
    what: &str,
) -> Result<Vec<MissingLoop>> {
    if options.map.is_empty() {
        return Ok(vec![]);
    }
    let columns = sheet.columns.iter().map(|column| &*column.name);
    let left_out = sheet.left_out.iter().map(|each| &*each.name);
    let known: HashSet<String> = names
        .iter()
        .copied()
        .chain(columns)
        .chain(left_out)
        .flat_map(|name| [name, role::without_place(name), role::without_unit(name).0])
        .map(str::to_lowercase)
        .collect();
    let (mut missing, mut seen): (Vec<MissingLoop>, _) = (vec![], HashSet::new());
    for mapped in options.map.iter().filter(|each| !known.contains(&each.column.to_lowercase())) {
        let holds = options.mapping.as_ref().map_or(String::new(), |file| format!(" (in {file})"));
        let reason = format!(
            "has no {what} \"{}\", which is given as {}{holds}; its {what}s are {}",
            mapped.column,
            mapped.role,
            list(names)
        );
        let Some(name) = &mapped.loop_name else {
            return Err(Error::Table { origin: sheet.origin.clone(), message: reason });
        };
        if seen.insert(name.to_lowercase()) {
            missing.push(MissingLoop { name: name.clone(), reason, is_partly_here: false });
        }
    }
    Ok(missing)
}

/// A conflict of two names for one signal or quality, with the remedy.
pub fn conflict(
    sheet: &Sheet,
    role: &str,
    loop_name: Option<&str>,
    a: &str,
    b: &str,
    option: &str,
    wording: Wording,
) -> Error {
    let of_loop = loop_name.map_or(String::new(), |name| format!(" of loop {name}"));
    let prefix = loop_name.map_or(String::new(), |name| format!("{name}."));
    Error::Table {
        origin: sheet.origin.clone(),
        message: format!(
            "\"{a}\" and \"{b}\" can both be the {role}{of_loop}; choose one, as in {}",
            wording.of(Remedy::map(format!("{prefix}{option}"), a))
        ),
    }
}

/// The question which signals a CV and an MV without a PV are: PV and OP, or OP and VP.
pub fn cv_beside_mv(sheet: &Sheet, cv: &str, mv: &str, wording: Wording) -> Error {
    let [pv, op] = [("pv", cv), ("op", mv)].map(|(role, name)| wording.of(Remedy::map(role, name)));
    let [cv_op, vp] =
        [("op", cv), ("vp", mv)].map(|(role, name)| wording.of(Remedy::map(role, name)));
    Error::Table {
        origin: sheet.origin.clone(),
        message: format!(
            "without a PV, \"{cv}\" and \"{mv}\" can be PV and OP, or OP and measured valve position; give {pv} and \
             {op} for the first, or {cv_op} and {vp} for the second"
        ),
    }
}
