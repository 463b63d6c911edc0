//! Which columns or tags of a sheet are which signals of which loops.

mod bundles;

pub use bundles::{Bundle, Shape, bundles, shape};

use crate::content::Content;
use crate::error::{Error, Result};
use crate::leftover;
use crate::options::{Mapped, ReadOptions};
use crate::remedy::{Remedy, Wording};
use crate::role::{self, Role, SEPARATORS, Signal};
use crate::sheet::{Cells, LeftOut, Sheet};
use std::collections::{BTreeMap, HashMap, HashSet};
use std::sync::Arc;
use stiction_diagnose::recording::Mode;

/// How many reasons why something is no column have a note of their own; the list of columns has them all.
const MOST_REASONS: usize = 20;

/// How a sheet holds its loops.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Layout {
    /// One loop, a column a signal.
    OneLoop,
    /// Several loops side by side, a column a signal.
    Wide,
    /// A row a sample, with the name of its tag.
    Long,
}

impl Layout {
    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::OneLoop => "one loop, a column a signal",
            Self::Wide => "wide: a column a signal of a loop",
            Self::Long => "long: a row a sample, with its tag",
        }
    }
}

/// What a column or tag was recognised as, and why.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Recognised {
    /// The part of the file, as in [`Sheet::part`].
    pub part: String,
    /// Name of the column, or of the tag of a long sheet.
    pub column: String,
    /// What it is.
    pub role: Role,
    /// The loop it belongs to, where its name tells one.
    pub loop_name: Option<String>,
    /// Why, in words.
    pub why: String,
}

/// A loop that a mapping names, and that is not read because a column or tag is not there.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct MissingLoop {
    /// Its name.
    pub name: String,
    /// Why it is not read, with what would help.
    pub reason: String,
    /// Whether other signals of it are there; if not, it may be in another file.
    pub is_partly_here: bool,
}

/// A loop: which names hold its signals and qualities, as indices of the names.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct LoopPlan {
    /// Its name; none if nothing tells one.
    pub name: Option<String>,
    /// What the user should know of it alone.
    pub notes: Vec<String>,
    /// Why it is not read, where the file has a signal of it that could not be made a column.
    pub unread: Option<String>,
    signals: [Option<usize>; 5],
    qualities: [Option<usize>; 5],
    quality: Option<usize>,
}

impl LoopPlan {
    /// The name that holds `signal`.
    pub fn signal(&self, signal: Signal) -> Option<usize> {
        self.signals[signal as usize]
    }

    /// The name that holds the quality of `signal`.
    pub fn quality(&self, signal: Signal) -> Option<usize> {
        self.qualities[signal as usize].or(self.quality)
    }

    fn place(&mut self, role: Role) -> Option<&mut Option<usize>> {
        match role {
            Role::Signal(signal) => Some(&mut self.signals[signal as usize]),
            Role::Quality(Some(signal)) => Some(&mut self.qualities[signal as usize]),
            Role::Quality(None) => Some(&mut self.quality),
            _ => None,
        }
    }

    /// Every name it uses.
    fn names(&self) -> impl Iterator<Item = usize> + '_ {
        self.signals.iter().chain(&self.qualities).chain([&self.quality]).flatten().copied()
    }

    fn has_op(&self) -> bool {
        self.signal(Signal::Op).is_some()
    }
}

/// A tag of a long sheet and the rows that are its.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Tag {
    /// Its name.
    pub name: String,
    /// Its rows, in their order.
    pub rows: Vec<usize>,
}

/// Where the samples of a sheet are.
#[derive(Debug, Clone, PartialEq)]
pub enum Place {
    /// In columns, which are the names of the loops.
    Columns,
    /// In rows, each of a tag; the tags are the names of the loops.
    Rows {
        /// The tags in order of their first row.
        tags: Vec<Tag>,
        /// The column of values.
        value: usize,
        /// The column of qualities.
        quality: Option<usize>,
    },
}

/// What a sheet holds.
#[derive(Debug, Clone, PartialEq)]
pub struct Plan {
    /// How its loops lie in it.
    pub layout: Layout,
    /// Where the samples are.
    pub place: Place,
    /// The column of times; none if rows are evenly spaced.
    pub time: Option<usize>,
    /// The column of days, where `time` is a time of day.
    pub date: Option<usize>,
    /// The loops that have an OP, in order of their first name.
    pub loops: Vec<LoopPlan>,
    /// Every column and tag.
    pub recognised: Vec<Recognised>,
    /// The loops of the mapping that lack a column or tag.
    pub missing: Vec<MissingLoop>,
    /// What the user should know.
    pub notes: Vec<String>,
}

/// Recognises what `sheet` holds.
///
/// # Errors
/// If a column that was named for no loop in particular is not there, or two columns are the same signal of
/// the same loop.
pub fn recognise(sheet: &Sheet, options: &ReadOptions) -> Result<Plan> {
    let given = Given::of(options);
    let about_rows = AboutRows::find(sheet, &given)?;
    let mut plan = match (about_rows.of(Role::Tag), about_rows.of(Role::Value)) {
        (Some(tag), Some(value)) => long(sheet, &given, &about_rows, tag, value)?,
        _ => wide(sheet, &given, &about_rows)?,
    };
    plan.time = about_rows.of(Role::Time);
    plan.date = about_rows.of(Role::Date);
    if plan.time.is_none() {
        plan.time = plan.date.take();
    }
    name_left_out(sheet, &given, &mut plan);
    for recognised in &mut plan.recognised {
        recognised.part.clone_from(&sheet.part);
    }
    Ok(plan)
}

/// Names what could not be made a column. A loop is not judged on half of its signals: where one of them is left out,
/// and nothing stands for it, the loop is not read. A mode is no such signal, and neither is what is empty or single.
fn name_left_out(sheet: &Sheet, given: &Given<'_>, plan: &mut Plan) {
    let lower = |name: &Option<String>| name.as_ref().map(|name| name.to_lowercase());
    let mut places: HashMap<Option<String>, usize> =
        plan.loops.iter().enumerate().map(|(place, each)| (lower(&each.name), place)).collect();
    let mut by_reason: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
    for LeftOut { name, why, holds_samples } in &sheet.left_out {
        let found = candidate(name, given);
        let role = found.as_ref().map_or(Role::Ignored, |found| found.role);
        let is_given = found.as_ref().is_some_and(|found| found.given);
        let loop_name = found.and_then(|found| found.loop_name);
        plan.recognised.push(Recognised {
            part: String::new(),
            column: name.clone(),
            role: Role::Ignored,
            loop_name: loop_name.clone(),
            why: format!("it {why}"),
        });
        if is_given && role == Role::Ignored {
            continue;
        }
        if let Role::Signal(signal) = role
            && signal != Signal::Mode
            && (*holds_samples || is_given)
        {
            let only = plan.loops.first().filter(|_| plan.loops.len() == 1);
            // What tells no loop belongs to the only one.
            let is_only = only.is_some_and(|only| only.name.is_none() || loop_name.is_none());
            let place = match places.get(&lower(&loop_name)) {
                Some(place) => *place,
                None if is_only => 0,
                None => {
                    plan.loops.push(LoopPlan { name: loop_name.clone(), ..LoopPlan::default() });
                    places.insert(lower(&loop_name), plan.loops.len() - 1);
                    plan.loops.len() - 1
                }
            };
            if plan.loops[place].signal(signal).is_none() {
                plan.loops[place].unread.get_or_insert(format!(
                    "has \"{name}\", by its name the {}, but it {why}; mend it, or leave it out with {}",
                    signal.name(),
                    given.options.wording.of(Remedy::map("ignore", name))
                ));
                continue;
            }
        }
        by_reason.entry(why).or_default().push(name);
    }
    let more: Vec<&str> = by_reason.values().skip(MOST_REASONS).flatten().copied().collect();
    for (why, names) in by_reason.iter().take(MOST_REASONS) {
        plan.notes.push(match &names[..] {
            [name] => format!("\"{name}\" {why} and is not used"),
            names => format!("{} are not used: each {why}", list(names)),
        });
    }
    if !more.is_empty() {
        plan.notes.push(format!("{} are not used, for other reasons", list(&more)));
    }
}

fn wide(sheet: &Sheet, given: &Given<'_>, about_rows: &AboutRows) -> Result<Plan> {
    let names: Vec<&str> = sheet.columns.iter().map(|column| &*column.name).collect();
    let missing = missing(sheet, &names, given.options, "column")?;
    let content = Content { sheet, place: &Place::Columns };
    let rows: Vec<usize> = about_rows
        .roles
        .iter()
        .filter(|(_, role)| matches!(role, Role::Time | Role::Date))
        .map(|(column, _)| *column)
        .collect();
    let mut assigned = assign(&content, &names, &rows, missing, given)?;
    for (column, role) in &about_rows.roles {
        // A column that only its name makes one about rows may be a signal or quality all the same.
        if matches!(role, Role::Time | Role::Date) {
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
    about_rows: &AboutRows,
    tag: usize,
    value: usize,
) -> Result<Plan> {
    for role in [Role::Tag, Role::Value, Role::Quality(None)] {
        about_rows.check_single(sheet, role, given.options.wording)?;
    }
    let tags = tags(sheet, tag, given.options.wording)?;
    let quality = about_rows.of(Role::Quality(None));
    let place = Place::Rows { tags: tags.clone(), value, quality };
    let names: Vec<&str> = tags.iter().map(|tag| &*tag.name).collect();
    let missing = missing(sheet, &names, given.options, "tag")?;
    let assigned = assign(&Content { sheet, place: &place }, &names, &[], missing, given)?;
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

/// The columns that say something of whole rows: times, tags, values, a common quality.
struct AboutRows {
    roles: Vec<(usize, Role)>,
    given: HashSet<usize>,
}

impl AboutRows {
    fn find(sheet: &Sheet, told: &Given<'_>) -> Result<Self> {
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
        // What is given stands in place of what is recognised.
        let replaced: Vec<Role> =
            [Role::Time, Role::Date, Role::Tag, Role::Value, Role::Quality(None)]
                .into_iter()
                .filter(|role| roles.iter().any(|(i, each)| each == role && given.contains(i)))
                .collect();
        roles.retain(|(i, role)| given.contains(i) || !replaced.contains(role));
        let found = Self { roles, given };
        // Words for the others count only in a long table.
        found.check_single(sheet, Role::Time, told.options.wording)?;
        found.check_single(sheet, Role::Date, told.options.wording)?;
        Ok(found)
    }

    /// That only one column has `role`.
    fn check_single(&self, sheet: &Sheet, role: Role, wording: Wording) -> Result<()> {
        let mut columns = self.roles.iter().filter(|(_, each)| *each == role);
        let (Some((a, _)), Some((b, _))) = (columns.next(), columns.next()) else { return Ok(()) };
        let (a, b) = (&sheet.columns[*a].name, &sheet.columns[*b].name);
        Err(conflict(sheet, &role.to_string(), None, a, b, role.option_name(), wording))
    }

    fn of(&self, role: Role) -> Option<usize> {
        self.roles.iter().find(|(_, each)| *each == role).map(|(column, _)| *column)
    }

    fn recognised(&self, name: &str, column: usize) -> Recognised {
        let role = self.roles.iter().find(|(each, _)| *each == column).map(|(_, role)| *role);
        let role = role.filter(|role| self.of(*role) == Some(column));
        let why = match role {
            Some(_) if self.given.contains(&column) => "it is given".to_owned(),
            Some(role) => format!("its name is a word for {role}"),
            None => "its name is not known".to_owned(),
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
fn tags(sheet: &Sheet, column: usize, wording: Wording) -> Result<Vec<Tag>> {
    let column = &sheet.columns[column];
    let Cells::Text(cells) = &column.cells else {
        return Err(Error::Column {
            origin: sheet.origin.clone(),
            column: column.name.clone(),
            message: format!(
                "holds numbers, but is to name tags; say which column does, as in {}",
                wording.of(Remedy::map_some("tag"))
            ),
        });
    };
    let mut places: HashMap<&str, usize> = HashMap::new();
    let mut tags: Vec<Tag> = vec![];
    let mut last: Option<(&Arc<str>, usize)> = None;
    for (row, cell) in cells.iter().enumerate() {
        // Rows of a tag mostly follow each other, and share its name.
        if let Some((_, place)) = last.filter(|(known, _)| Arc::ptr_eq(known, cell)) {
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
            tags.push(Tag { name: cell.to_string(), rows: vec![] });
            tags.len() - 1
        });
        tags[place].rows.push(row);
        last = Some((cell, place));
    }
    Ok(tags)
}

/// What the user says of columns and tags, by their names.
struct Given<'o> {
    options: &'o ReadOptions,
    exactly: HashMap<&'o str, usize>,
    in_lower_case: HashMap<String, usize>,
}

impl<'o> Given<'o> {
    fn of(options: &'o ReadOptions) -> Self {
        // Of several the last counts.
        let columns = || options.map.iter().enumerate().map(|(place, each)| (&*each.column, place));
        let in_lower_case = columns().map(|(column, place)| (column.to_lowercase(), place));
        Self { options, exactly: columns().collect(), in_lower_case: in_lower_case.collect() }
    }

    /// What is said of the column or tag called `name`, with its unit or without.
    fn mapped(&self, name: &str) -> Option<&'o Mapped> {
        let loosely = |name: &str| self.in_lower_case.get(&name.to_lowercase());
        let place = self
            .exactly
            .get(name)
            .or_else(|| loosely(name).max(loosely(role::without_unit(name).0)))?;
        Some(&self.options.map[*place])
    }
}

/// The loops for which the user names what is not there; what is named for no loop must be.
fn missing(
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
        .flat_map(|name| [name.to_lowercase(), role::without_unit(name).0.to_lowercase()])
        .collect();
    let (mut missing, mut seen): (Vec<MissingLoop>, _) = (vec![], HashSet::new());
    for mapped in options.map.iter().filter(|each| !known.contains(&each.column.to_lowercase())) {
        let reason = format!(
            "has no {what} \"{}\", which is given as {}; its {what}s are {}",
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

/// Names in quotes, not endlessly many.
pub fn list(names: &[&str]) -> String {
    const MOST: usize = 20;
    let shown: Vec<_> = names.iter().take(MOST).map(|name| format!("\"{name}\"")).collect();
    let more = names.len().saturating_sub(MOST);
    let more = if more > 0 { format!(" and {more} more") } else { String::new() };
    format!("{}{more}", shown.join(", "))
}

fn conflict(
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
            "\"{a}\" and \"{b}\" can both be the {role}{of_loop}; say which, as in {}",
            wording.of(Remedy::map(format!("{prefix}{option}"), a))
        ),
    }
}

struct Assigned {
    loops: Vec<LoopPlan>,
    recognised: Vec<Recognised>,
    missing: Vec<MissingLoop>,
    notes: Vec<String>,
}

/// A name taken apart or given.
struct Candidate {
    loop_name: Option<String>,
    role: Role,
    given: bool,
    is_mv: bool,
    why: String,
}

impl Candidate {
    fn recognised(loop_name: Option<String>, role: Role, why: impl Into<String>) -> Self {
        Self { loop_name, role, given: false, is_mv: false, why: why.into() }
    }
}

fn candidate(name: &str, given: &Given<'_>) -> Option<Candidate> {
    let options = given.options;
    let split = |why: &dyn Fn(&role::Split) -> String| {
        let by_pattern = options.pattern.as_ref().and_then(|p| p.split(name, &options.signals));
        let by_pattern = by_pattern.map(|split| {
            let pattern = options.pattern.as_ref().map_or("", |pattern| pattern.text());
            let why = format!("it is built as {pattern}");
            (split, why)
        });
        by_pattern.or_else(|| {
            let split = role::split(name, &options.signals)?;
            let why = why(&split);
            Some((split, why))
        })
    };
    let why = |split: &role::Split| match split.role {
        Role::Quality(_) => "its name ends with a word for a quality".to_owned(),
        role if split.loop_name.is_some() => {
            format!("it ends with {}, a word for {role}", split.word)
        }
        role => format!("its name is a word for {role}"),
    };
    if let Some(mapped) = given.mapped(name) {
        let named = || split(&why).and_then(|(split, _)| split.loop_name);
        return Some(Candidate {
            loop_name: mapped.loop_name.clone().or_else(named),
            role: mapped.role,
            given: true,
            is_mv: false,
            why: "it is given".to_owned(),
        });
    }
    if let Some((split, why)) = split(&why) {
        let is_mv = split.role == Role::Signal(Signal::Op) && role::is_mv(&split.word);
        return Some(Candidate {
            is_mv,
            ..Candidate::recognised(split.loop_name, split.role, why)
        });
    }
    match role::of_rows(name) {
        Some(role @ Role::Quality(None)) => Some(Candidate::recognised(
            None,
            role,
            "its name is a word for the quality of all signals",
        )),
        _ => None,
    }
}

/// Tells which signal of which loop each of the `names` is, but for the columns that are about `rows`.
fn assign(
    content: &Content<'_>,
    names: &[&str],
    rows: &[usize],
    missing: Vec<MissingLoop>,
    given: &Given<'_>,
) -> Result<Assigned> {
    let (sheet, options) = (content.sheet, given.options);
    let mut candidates: Vec<Option<Candidate>> =
        names.iter().map(|name| candidate(name, given)).collect();
    let mut notes = vec![];
    let settled = settle_mv(&mut candidates, names, options.wording);
    take_switches(&mut candidates, names, content);
    take_quantity(&mut candidates, names, content, options.wording, &mut notes);
    let is_unused = |i: &usize| {
        candidates[*i].is_none()
            && !rows.contains(i)
            && content.is_numeric(*i)
            && !content.is_about_rows(*i)
    };
    let unused: Vec<usize> = (0..names.len()).filter(is_unused).collect();

    let mut loops: Vec<LoopPlan> = vec![];
    let mut places: HashMap<Option<String>, usize> = HashMap::new();
    // Those that are given go first: what is recognised for their place is then not used.
    let mut order: Vec<usize> = (0..names.len()).collect();
    for i in &order {
        let Some(candidate) = &candidates[*i] else { continue };
        let mut plan = LoopPlan { name: candidate.loop_name.clone(), ..LoopPlan::default() };
        if plan.place(candidate.role).is_some() {
            places
                .entry(candidate.loop_name.as_ref().map(|name| name.to_lowercase()))
                .or_insert_with(|| {
                    loops.push(plan);
                    loops.len() - 1
                });
        }
    }
    for (i, note) in settled {
        let of = candidates[i].as_ref().and_then(|candidate| candidate.loop_name.as_ref());
        if let Some(place) = places.get(&of.map(|name| name.to_lowercase())) {
            loops[*place].notes.push(note);
        }
    }
    order.sort_by_key(|i| candidates[*i].as_ref().is_some_and(|c| !c.given));
    for i in order {
        let Some(candidate) = &mut candidates[i] else { continue };
        let key = candidate.loop_name.as_ref().map(|name| name.to_lowercase());
        let Some(plan) = places.get(&key).map(|place| &mut loops[*place]) else { continue };
        let name = plan.name.clone();
        let Some(place) = plan.place(candidate.role) else { continue };
        match *place {
            None => *place = Some(i),
            Some(other) if given.mapped(names[other]).is_some() && !candidate.given => {
                candidate.why = format!("the {} is given as \"{}\"", candidate.role, names[other]);
                candidate.role = Role::Ignored;
            }
            Some(other) => {
                let (a, b) = (names[other.min(i)], names[other.max(i)]);
                let role = candidate.role;
                return Err(conflict(
                    sheet,
                    &role.to_string(),
                    name.as_deref(),
                    a,
                    b,
                    role.option_name(),
                    options.wording,
                ));
            }
        }
    }
    let recognised = names.iter().zip(candidates).map(|(name, candidate)| match candidate {
        Some(candidate) => Recognised {
            part: String::new(),
            column: (*name).to_owned(),
            role: candidate.role,
            loop_name: candidate.loop_name,
            why: candidate.why,
        },
        None => Recognised {
            part: String::new(),
            column: (*name).to_owned(),
            role: Role::Ignored,
            loop_name: None,
            why: "no signal of a loop is called so".to_owned(),
        },
    });
    let mut assigned = Assigned { loops, recognised: recognised.collect(), missing, notes };
    join_the_nameless(&mut assigned);
    join_acquisition(&mut assigned, names);
    leave_out_missing(&mut assigned);
    let lone = keep_those_with_op(&mut assigned);

    let candidates: Vec<usize> = lone.into_iter().chain(unused.iter().copied()).collect();
    let named: Vec<&str> = candidates.iter().map(|i| names[*i]).collect();
    let offered = leftover::offer_pairs(&mut assigned.loops, &named, options.wording);
    let offered: HashSet<usize> = offered.into_iter().map(|place| candidates[place]).collect();
    let is_offered = |i: &usize| offered.contains(i);
    let unused: Vec<&str> = unused.iter().filter(|i| !is_offered(i)).map(|i| names[*i]).collect();
    assigned.notes.extend(leftover::note(&assigned.loops, &unused, options.wording));
    Ok(assigned)
}

/// Columns of 0 and 1 that tell whether a loop is in automatic, or in manual, where nothing else tells its
/// mode. MAN goes before AUTO, which is not taken beside CAS: a loop in cascade may be in neither.
fn take_switches(candidates: &mut [Option<Candidate>], names: &[&str], content: &Content<'_>) {
    let mut found: Vec<(usize, role::Split, Mode)> = (0..names.len())
        .filter(|i| candidates[*i].is_none())
        .filter_map(|i| role::split_switch(names[i]).map(|(split, mode)| (i, split, mode)))
        .filter(|(i, ..)| content.is_switch(*i))
        .collect();
    found.sort_by_key(|(_, _, mode)| *mode != Mode::Manual);
    let key = |split: &role::Split| split.loop_name.as_ref().map(|name| name.to_lowercase());
    let cascades: Vec<Option<String>> = found
        .iter()
        .filter(|(_, _, mode)| *mode == Mode::Cascade)
        .map(|(_, split, _)| key(split))
        .collect();
    let modes = candidates.iter().flatten().filter(|c| c.role == Role::Signal(Signal::Mode));
    let mut told: HashSet<Option<String>> =
        modes.map(|c| c.loop_name.as_ref().map(|name| name.to_lowercase())).collect();
    for (i, split, mode) in found {
        let key = key(&split);
        if mode == Mode::Cascade || (mode == Mode::Automatic && cascades.contains(&key)) {
            continue;
        }
        // A mode of no loop in particular may be that of any.
        let told = told.contains(&None) || !told.insert(key);
        let (role, why) = match (told, mode) {
            (true, _) => (Role::Ignored, "the mode is told elsewhere"),
            (false, Mode::Manual) => (split.role, "it tells by 0 and 1 whether it is in manual"),
            (false, _) => (split.role, "it tells by 0 and 1 whether it is in automatic"),
        };
        candidates[i] = Some(Candidate::recognised(split.loop_name, role, why));
    }
}

/// A flow, level, pressure or temperature is the PV where no other column that is left speaks of one, there is
/// only one loop, and nothing else is the PV.
fn take_quantity(
    candidates: &mut [Option<Candidate>],
    names: &[&str],
    content: &Content<'_>,
    wording: Wording,
    notes: &mut Vec<String>,
) {
    let of = |signal: Signal| {
        candidates.iter().flatten().filter(move |c| c.role == Role::Signal(signal))
    };
    let is_quantity = |i: &usize| {
        candidates[*i].is_none() && role::has_quantity(names[*i]) && content.is_numeric(*i)
    };
    let quantities: Vec<usize> = (0..names.len()).filter(is_quantity).collect();
    let ops: Vec<&Candidate> = of(Signal::Op).collect();
    let ([quantity], [op], None) = (&quantities[..], &ops[..], of(Signal::Pv).next()) else {
        return;
    };
    let (name, loop_name) = (names[*quantity], op.loop_name.clone());
    if !role::is_quantity(name) {
        return;
    }
    notes.push(format!(
        "\"{name}\" is taken as the PV, because nothing else can be it; if it is not, give {}",
        wording.of(Remedy::map("ignore", name))
    ));
    let why = "it is the only quantity that is measured";
    candidates[*quantity] = Some(Candidate::recognised(loop_name, Role::Signal(Signal::Pv), why));
}

/// MV is the manipulated variable, which is the OP; beside another OP it is the measured valve. Gives a note for each.
fn settle_mv(
    candidates: &mut [Option<Candidate>],
    names: &[&str],
    wording: Wording,
) -> Vec<(usize, String)> {
    let key = |candidate: &Candidate| candidate.loop_name.as_ref().map(|name| name.to_lowercase());
    let loops_with = |signal: Signal| -> HashSet<Option<String>> {
        let is_it = |c: &&Candidate| !c.is_mv && c.role == Role::Signal(signal);
        candidates.iter().flatten().filter(is_it).map(key).collect()
    };
    let (with_op, with_vp) = (loops_with(Signal::Op), loops_with(Signal::Vp));
    // A signal of no loop in particular may be that of any.
    let has = |loops: &HashSet<Option<String>>, of: &Candidate| {
        loops.contains(&None) || loops.contains(&key(of))
    };
    let mut notes = vec![];
    for i in 0..candidates.len() {
        let Some(candidate) = candidates[i].as_ref().filter(|candidate| candidate.is_mv) else {
            continue;
        };
        let (has_op, has_vp) = (has(&with_op, candidate), has(&with_vp, candidate));
        let name = names[i];
        let (role, note) = if has_op && !has_vp {
            let note = format!(
                "\"{name}\" stands beside an OP and is taken as the measured valve position (VP); if \
                 it is not, give {}",
                wording.of(Remedy::map("ignore", name))
            );
            (Role::Signal(Signal::Vp), note)
        } else {
            let note = format!(
                "\"{name}\" is taken as the manipulated variable, the OP; if it is the measured valve \
                 position, give {}",
                wording.of(Remedy::map("vp", name))
            );
            (Role::Signal(Signal::Op), note)
        };
        if let Some(candidate) = &mut candidates[i] {
            candidate.role = role;
            candidate.why = if role == Role::Signal(Signal::Vp) {
                "MV beside an OP is the measured valve".to_owned()
            } else {
                "MV is the manipulated variable".to_owned()
            };
        }
        notes.push((i, note));
    }
    notes
}

/// Signals that tell no loop belong to the only loop that there is.
fn join_the_nameless(assigned: &mut Assigned) {
    let Some(nameless) = assigned.loops.iter().position(|each| each.name.is_none()) else { return };
    if assigned.loops.len() != 2 {
        return;
    }
    let (a, b) = (&assigned.loops[nameless], &assigned.loops[1 - nameless]);
    let clash = a.signals.iter().zip(&b.signals).any(|(a, b)| a.is_some() && b.is_some())
        || a.qualities.iter().zip(&b.qualities).any(|(a, b)| a.is_some() && b.is_some())
        || (a.quality.is_some() && b.quality.is_some());
    if clash {
        return;
    }
    let nameless = assigned.loops.remove(nameless);
    let one = &mut assigned.loops[0];
    for name in nameless.names() {
        assigned.recognised[name].loop_name.clone_from(&one.name);
        assigned.recognised[name].why += "; there is only one loop";
    }
    for k in 0..5 {
        one.signals[k] = one.signals[k].or(nameless.signals[k]);
        one.qualities[k] = one.qualities[k].or(nameless.qualities[k]);
    }
    one.quality = one.quality.or(nameless.quality);
    one.notes.extend(nameless.notes);
}

/// The PV of a data acquisition block, `FC101.DACA`, is that of the control block of the same point,
/// `FC101.PIDA`, if that has none.
fn join_acquisition(assigned: &mut Assigned, names: &[&str]) {
    let point = |each: &LoopPlan| {
        let (point, block) = each.name.as_ref()?.rsplit_once(SEPARATORS)?;
        Some((point.to_lowercase(), block.to_lowercase()))
    };
    let mut of_point: HashMap<String, Vec<usize>> = HashMap::new();
    for (place, each) in assigned.loops.iter().enumerate().filter(|(_, each)| each.has_op()) {
        let whole = each.name.as_ref().map(|name| name.to_lowercase());
        for key in point(each).map(|(point, _)| point).into_iter().chain(whole) {
            of_point.entry(key).or_default().push(place);
        }
    }
    for k in 0..assigned.loops.len() {
        let Some((of, _)) = point(&assigned.loops[k]).filter(|(_, block)| block == "daca") else {
            continue;
        };
        let pv = Signal::Pv as usize;
        let (Some(column), false) = (assigned.loops[k].signals[pv], assigned.loops[k].has_op())
        else {
            continue;
        };
        let lacks_pv = |place: &&usize| assigned.loops[**place].signals[pv].is_none();
        let mut controllers = of_point.get(&of).into_iter().flatten().filter(lacks_pv);
        let (Some(controller), None) = (controllers.next(), controllers.next()) else { continue };
        let quality = assigned.loops[k].quality(Signal::Pv);
        let controller = &mut assigned.loops[*controller];
        controller.signals[pv] = Some(column);
        controller.qualities[pv] = controller.qualities[pv].or(quality);
        let name = controller.name.clone();
        controller.notes.push(format!(
            "\"{}\" is taken as the PV, because it is of the same point",
            names[column]
        ));
        for moved in [Some(column), quality].into_iter().flatten() {
            assigned.recognised[moved].loop_name.clone_from(&name);
            assigned.recognised[moved].why += "; the controller of that point has none";
        }
        let acquisition = &mut assigned.loops[k];
        (acquisition.signals[pv], acquisition.qualities[pv]) = (None, None);
        acquisition.quality = acquisition.quality.filter(|own| Some(*own) != quality);
    }
    assigned.loops.retain(|each| each.names().next().is_some());
}

/// Loops of the mapping that lack a column or tag are not read by half.
fn leave_out_missing(assigned: &mut Assigned) {
    let loops = assigned.recognised.iter().filter_map(|each| each.loop_name.as_ref());
    let here: HashSet<String> = loops.map(|name| name.to_lowercase()).collect();
    for missing in &mut assigned.missing {
        missing.is_partly_here = here.contains(&missing.name.to_lowercase());
    }
    let partly = assigned.missing.iter().filter(|each| each.is_partly_here);
    let partly: HashSet<String> = partly.map(|each| each.name.to_lowercase()).collect();
    let is_it = |name: &Option<String>| {
        name.as_ref().is_some_and(|name| partly.contains(&name.to_lowercase()))
    };
    assigned.loops.retain(|each| !is_it(&each.name));
    for each in assigned.recognised.iter_mut().filter(|each| is_it(&each.loop_name)) {
        each.role = Role::Ignored;
        "another column or tag of its loop is not there".clone_into(&mut each.why);
    }
    for missing in assigned.missing.iter().filter(|each| each.is_partly_here) {
        assigned
            .notes
            .push(format!("loop {} is not read: the file {}", missing.name, missing.reason));
    }
}

/// Without an OP there is no loop to look at; gives the PVs that are left without one.
fn keep_those_with_op(assigned: &mut Assigned) -> Vec<usize> {
    let lone = assigned.loops.iter().filter(|each| !each.has_op());
    let lone = lone.filter_map(|each| each.signal(Signal::Pv)).collect();
    let without: Vec<&LoopPlan> = assigned.loops.iter().filter(|each| !each.has_op()).collect();
    if without.len() < assigned.loops.len() {
        let named: Vec<&str> = without.iter().filter_map(|each| each.name.as_deref()).collect();
        assigned.notes.extend(match &named[..] {
            [] => None,
            [name] => Some(format!("loop {name} has no OP and is not read")),
            _ => Some(format!("the loops {} have no OP and are not read", list(&named))),
        });
        if named.len() < without.len() {
            let note = "the columns that tell no loop have no OP among them and are not read";
            assigned.notes.push(note.to_owned());
        }
        assigned.loops.retain(LoopPlan::has_op);
    } else {
        assigned.loops.clear();
    }
    lone
}
