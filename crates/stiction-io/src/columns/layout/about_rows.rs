//! Columns that describe whole rows, and the tags of a long sheet.

use super::given::{Given, conflict};
use super::plan::{Recognised, Tag};
use super::time_column;
use crate::columns::role::{self, Role};
use crate::error::{Error, Result};
use crate::remedy::{Remedy, Wording};
use crate::sheet::{Cells, Sheet};
use std::collections::{HashMap, HashSet};

/// The columns that describe whole rows: times, tags, values, a common quality.
pub struct AboutRows {
    pub roles: Vec<(usize, Role)>,
    given: HashSet<usize>,
    /// Notes for the user on the choice of the time.
    pub notes: Vec<String>,
}

impl AboutRows {
    pub fn find(sheet: &Sheet, told: &Given<'_>) -> Result<Self> {
        let (mut roles, mut given): (Vec<(usize, Role)>, HashSet<usize>) = Default::default();
        for (i, column) in sheet.columns.iter().enumerate() {
            if let Some(mapped) = told.mapped(&column.name) {
                let about = !matches!(
                    mapped.role,
                    Role::Signal(_) | Role::Quality(Some(_)) | Role::Ignored
                );
                if about && mapped.loop_name.is_none() {
                    roles.push((i, mapped.role));
                    given.insert(i);
                }
            } else if let Some(role) = role::of_rows(&column.name) {
                roles.push((i, role));
            }
        }
        // Q beside tags and values is their quality; in other tables it may be a flow.
        let has = |role: Role| roles.iter().any(|(_, each)| *each == role);
        let q = sheet.columns.iter().position(|column| column.name.eq_ignore_ascii_case("q"));
        if let Some(q) = q.filter(|q| told.mapped(&sheet.columns[*q].name).is_none())
            && has(Role::Tag)
            && has(Role::Value)
        {
            roles.push((q, Role::Quality(None)));
        }
        // Given roles replace recognised ones.
        let replaced: Vec<Role> =
            [Role::Time, Role::Date, Role::Tag, Role::Value, Role::Quality(None)]
                .into_iter()
                .filter(|role| roles.iter().any(|(i, each)| each == role && given.contains(i)))
                .collect();
        roles.retain(|(i, role)| given.contains(i) || !replaced.contains(role));
        let mut found = Self { roles, given, notes: vec![] };
        time_column::choose(sheet, &mut found, told);
        // Words for the other roles count only in a long table.
        if !sheet.is_empty() && told.options.sample_time.is_none() {
            found.check_single(sheet, Role::Time, told.options.wording)?;
            found.check_single(sheet, Role::Date, told.options.wording)?;
        }
        Ok(found)
    }

    /// Keeps one of several columns of qualities, if one holds the plain codes of OPC, or says which values are good.
    /// Wonderware writes `OPCQuality` beside its own codes in `Quality` and `QualityDetail`, and PI Web API writes `Good`
    /// beside `Questionable`.
    pub fn choose_quality(&mut self, sheet: &Sheet) {
        let is_quality = |role: &Role| *role == Role::Quality(None);
        let columns = self.roles.iter().filter(|(_, role)| is_quality(role));
        let chosen = columns
            .filter_map(|(column, _)| {
                let name = role::plain(&sheet.columns[*column].name);
                ["opcquality", "good", "isgood"]
                    .iter()
                    .position(|known| *known == name)
                    .zip(Some(*column))
            })
            .min();
        if let Some((_, chosen)) = chosen {
            self.roles.retain(|(column, role)| !is_quality(role) || *column == chosen);
        }
    }

    /// Whether the user gives the column of `role`.
    pub fn is_given(&self, role: Role) -> bool {
        self.roles.iter().any(|(column, each)| *each == role && self.given.contains(column))
    }

    /// Whether the names alone leave several columns as possible times.
    pub fn is_open(&self) -> bool {
        self.roles.iter().filter(|(_, role)| *role == Role::Time).count() > 1
    }

    /// Checks that only one column has `role`.
    pub fn check_single(&self, sheet: &Sheet, role: Role, wording: Wording) -> Result<()> {
        let mut columns = self.roles.iter().filter(|(_, each)| *each == role);
        let (Some((a, _)), Some((b, _))) = (columns.next(), columns.next()) else { return Ok(()) };
        let (a, b) = (&sheet.columns[*a].name, &sheet.columns[*b].name);
        Err(conflict(sheet, &role.to_string(), None, a, b, role.option_name(), wording))
    }

    pub fn of(&self, role: Role) -> Option<usize> {
        self.roles.iter().find(|(_, each)| *each == role).map(|(column, _)| *column)
    }

    pub fn recognised(&self, name: &str, column: usize) -> Recognised {
        let role = self.roles.iter().find(|(each, _)| *each == column).map(|(_, role)| *role);
        let role = role.filter(|role| *role == Role::Ignored || self.of(*role) == Some(column));
        let why = match role {
            Some(_) if self.given.contains(&column) => "an option or mapping names it".to_owned(),
            Some(Role::Ignored) => "another column is the time".to_owned(),
            Some(role @ (Role::Time | Role::Date)) if role::of_rows(name) != Some(role) => {
                "its cells are times".to_owned()
            }
            Some(role) => format!("its name is a word for {role}"),
            None => "its name is unknown".to_owned(),
        };
        Recognised {
            part: String::new(),
            column: name.to_owned(),
            role: role.unwrap_or(Role::Ignored),
            loop_name: None,
            why,
        }
    }
}

/// The tags of a long sheet.
pub fn tags(sheet: &Sheet, column: usize, wording: Wording) -> Result<Vec<Tag>> {
    let column = &sheet.columns[column];
    let Cells::Text(cells) = &column.cells else {
        return Err(Error::Column {
            origin: sheet.origin.clone(),
            column: column.name.clone(),
            message: format!(
                "holds numbers, but should hold tags; name the column of tags, as in {}",
                wording.of(Remedy::map_some("tag"))
            ),
        });
    };
    let cells = cells.view();
    let mut places: HashMap<&str, usize> = HashMap::new();
    let mut tags: Vec<Tag> = vec![];
    let mut last: Option<(&str, usize)> = None;
    for (row, cell) in cells.iter().enumerate() {
        // Rows of a tag mostly follow each other.
        if let Some((_, place)) = last.filter(|(known, _)| *known == cell) {
            tags[place].rows.push(row);
            continue;
        }
        if cell.is_empty() {
            return Err(Error::Cell {
                origin: sheet.origin.clone(),
                row: sheet.row(row),
                column: column.name.clone(),
                message: "is empty; every row needs a tag".to_owned(),
            });
        }
        let place = *places.entry(cell).or_insert_with(|| {
            tags.push(Tag { name: cell.to_owned(), rows: vec![] });
            tags.len() - 1
        });
        tags[place].rows.push(row);
        last = Some((cell, place));
    }
    Ok(tags)
}
