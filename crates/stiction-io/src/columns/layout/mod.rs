//! Assigns columns or tags of a sheet to signals of loops.

mod about_rows;
mod assign;
mod assigned;
mod bundles;
mod candidate;
pub(crate) mod content;
mod given;
mod instrument;
mod left_out;
mod leftover;
mod neighbours;
mod plan;
pub(crate) mod side_by_side;
mod time_column;

pub use bundles::{Bundle, Shape, bundles, shape, without_op};
pub use plan::{Layout, LoopPlan, MissingLoop, Place, Plan, Recognised, Tag};

use crate::columns::options::ReadOptions;
use crate::columns::role::Role;
use crate::error::Result;
use crate::names::list;
use crate::sheet::Sheet;
use about_rows::{AboutRows, tags};
use assign::assign;
use content::Content;
use given::{Given, missing};
use left_out::name_left_out;

/// Recognises the loops of `sheet`.
///
/// # Errors
/// If a column that was given for no particular loop is missing, or two columns are the same signal of the same loop.
pub fn recognise(sheet: &Sheet, options: &ReadOptions) -> Result<Plan> {
    let given = Given::of(options);
    let mut about_rows = AboutRows::find(sheet, &given)?;
    let mut plan = match (about_rows.of(Role::Tag), about_rows.of(Role::Value)) {
        (Some(tag), Some(value)) => long(sheet, &given, &mut about_rows, tag, value)?,
        _ => wide(sheet, &given, &about_rows)?,
    };
    plan.time = about_rows.of(Role::Time);
    plan.date = about_rows.of(Role::Date);
    if plan.time.is_none() {
        plan.time = plan.date.take();
    }
    plan.notes.splice(0..0, about_rows.notes.iter().cloned());
    name_left_out(sheet, &given, &mut plan);
    for recognised in &mut plan.recognised {
        recognised.part.clone_from(&sheet.part);
    }
    Ok(plan)
}

fn wide(sheet: &Sheet, given: &Given<'_>, about_rows: &AboutRows) -> Result<Plan> {
    let names: Vec<&str> = sheet.columns.iter().map(|column| &*column.name).collect();
    let missing = missing(sheet, &names, given.options, "column")?;
    let content = Content { sheet, place: &Place::Columns };
    let rows: Vec<usize> = about_rows
        .roles
        .iter()
        .filter(|(_, role)| matches!(role, Role::Time | Role::Date | Role::Ignored))
        .map(|(column, _)| *column)
        .collect();
    let mut assigned = assign(&content, &names, &rows, missing, given)?;
    for (column, role) in &about_rows.roles {
        // A column that only looks as if it described rows, by its name, may still be a signal or quality.
        if matches!(role, Role::Time | Role::Date | Role::Ignored) {
            assigned.recognised[*column] = about_rows.recognised(names[*column], *column);
        }
    }
    let several = assigned.loops.iter().filter(|each| each.name.is_some()).count() > 1;
    Ok(Plan {
        layout: if several { Layout::Wide } else { Layout::OneLoop },
        place: Place::Columns,
        time: None,
        date: None,
        loops: assigned.loops,
        recognised: assigned.recognised,
        missing: assigned.missing,
        notes: assigned.notes,
    })
}

fn long(
    sheet: &Sheet,
    given: &Given<'_>,
    about_rows: &mut AboutRows,
    tag: usize,
    value: usize,
) -> Result<Plan> {
    about_rows.choose_quality(sheet);
    for role in [Role::Tag, Role::Value, Role::Quality(None)] {
        about_rows.check_single(sheet, role, given.options.wording)?;
    }
    let tags = tags(sheet, tag, given.options.wording)?;
    let quality = about_rows.of(Role::Quality(None));
    let place = Place::Rows { tags: tags.clone(), value, quality };
    let names: Vec<&str> = tags.iter().map(|tag| &*tag.name).collect();
    let missing = missing(sheet, &names, given.options, "tag")?;
    let mut assigned = assign(&Content { sheet, place: &place }, &names, &[], missing, given)?;
    let tagged: Vec<&str> = assigned
        .recognised
        .iter_mut()
        .filter(|each| matches!(each.role, Role::Quality(_)))
        .map(|each| {
            each.role = Role::Ignored;
            "it is a quality, but not in a column".clone_into(&mut each.why);
            &*each.column
        })
        .collect();
    if !tagged.is_empty() {
        assigned.notes.push(format!(
            "{} not used, because a table with one row per sample has its qualities in a column; write such a column, or \
             one column per signal",
            if let [one] = &tagged[..] { format!("\"{one}\" is") } else { list(&tagged) + " are" }
        ));
    }
    let content = Content { sheet, place: &Place::Columns };
    let is_left = |i: &usize| {
        let name = &*sheet.columns[*i].name;
        about_rows.recognised(name, *i).role == Role::Ignored
            && given.mapped(name).is_none()
            && content.is_qualities(*i, name)
    };
    let left: Vec<&str> =
        (0..sheet.columns.len()).filter(is_left).map(|i| &*sheet.columns[i].name).collect();
    if !left.is_empty() {
        let wording = given.options.wording;
        assigned.notes.push(leftover::note_qualities(&left, "quality".to_owned(), wording));
    }
    let mut recognised: Vec<Recognised> = sheet
        .columns
        .iter()
        .enumerate()
        .map(|(i, column)| about_rows.recognised(&column.name, i))
        .collect();
    recognised.extend(assigned.recognised);
    Ok(Plan {
        layout: Layout::Long,
        place,
        time: None,
        date: None,
        loops: assigned.loops,
        recognised,
        missing: assigned.missing,
        notes: assigned.notes,
    })
}
