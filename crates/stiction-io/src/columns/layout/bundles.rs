//! Groups the names of a file, so that reading a part gives the same result as reading the whole.

use super::about_rows::AboutRows;
use super::candidate::candidate;
use super::given::Given;
use super::instrument::Instrument;
use super::side_by_side::has_clocks;
use crate::columns::options::ReadOptions;
use crate::columns::role::{self, Role, SEPARATORS, Signal};
use crate::sheet::{Cells, Column, Sheet};
use std::collections::{BTreeMap, HashMap, HashSet};

/// The columns of a table that describe whole rows.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Shape {
    /// The column of times.
    pub time: usize,
    /// The columns of tags and of values in a table with one row per sample; none in a table with one column per
    /// signal.
    pub long: Option<(usize, usize)>,
    /// All columns that describe whole rows.
    pub about_rows: Vec<usize>,
}

/// Names that are read together.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Bundle {
    /// The loops among them that have an OP, and the name of that OP.
    pub loops: Vec<(String, usize)>,
    /// All members, as indices.
    pub names: Vec<usize>,
    /// Whether a PV is among the members.
    pub has_pv: bool,
}

/// The shape of a table, from the names of its columns. `None` if the names do not show the shape, or if no times
/// exist.
pub fn shape(columns: &[&str], options: &ReadOptions) -> Option<Shape> {
    if has_clocks(columns, options) {
        return None;
    }
    let column = |name: &&str| Column {
        name: (*name).to_owned(),
        unit: None,
        cells: Cells::Numbers(vec![]),
    };
    let sheet = Sheet { columns: columns.iter().map(column).collect(), ..Sheet::default() };
    let found = AboutRows::find(&sheet, &Given::of(options)).ok()?;
    // The cells decide between several columns of times.
    if options.sample_time.is_some() || found.of(Role::Date).is_some() || found.is_open() {
        return None;
    }
    Some(Shape {
        time: found.of(Role::Time)?,
        long: found.of(Role::Tag).zip(found.of(Role::Value)),
        about_rows: found.roles.iter().map(|(column, _)| *column).collect(),
    })
}

/// The smallest sets of `names`, except columns about `rows`, that give the same result alone and together. `None` if
/// all must be read together, because the file has at most one loop or a name that may belong to any loop.
pub fn bundles(names: &[&str], rows: &[usize], options: &ReadOptions) -> Option<Vec<Bundle>> {
    let given = Given::of(options);
    let is_of_any = |each: &crate::columns::options::Mapped| {
        each.loop_name.is_none() && matches!(each.role, Role::Signal(_) | Role::Quality(_))
    };
    if options.map.iter().any(is_of_any) {
        return None;
    }
    let mut found: Vec<(usize, String, Option<Role>)> = vec![];
    for (i, name) in names.iter().enumerate().filter(|(i, _)| !rows.contains(i)) {
        let candidate = candidate(name, &given);
        match candidate {
            // Another OP of the file decides what it is.
            Some(of) if of.is_co => return None,
            Some(of) => match (of.loop_name, of.role) {
                (Some(loop_name), role) => found.push((i, loop_name, Some(role))),
                (None, Role::Signal(_) | Role::Quality(_)) => return None,
                (None, _) => {}
            },
            None => {
                let switch = role::split_switch(name).and_then(|(split, _)| split.loop_name);
                found.extend(switch.map(|loop_name| (i, loop_name, None)));
            }
        }
    }
    // Loops with different words behind one tag may be one loop.
    let mut of_tag: HashMap<String, String> = HashMap::new();
    for (_, name, _) in &found {
        let Some(tag) = Instrument::before_words(name) else { continue };
        let known = of_tag.entry(tag.to_lowercase()).or_insert_with(|| name.to_lowercase());
        if *known != name.to_lowercase() {
            return None;
        }
    }
    // The PV of an acquisition block may belong to another block of its point.
    let point = |name: &str| {
        name.rsplit_once(SEPARATORS)
            .map(|(point, block)| (point.to_lowercase(), block.to_lowercase()))
    };
    let acquired: HashSet<String> = found
        .iter()
        .filter_map(|(_, name, _)| point(name))
        .filter(|(_, block)| block == "daca")
        .map(|(point, _)| point)
        .collect();
    let key = |name: &str| match point(name) {
        Some((point, _)) if acquired.contains(&point) => point,
        _ => name.to_lowercase(),
    };
    let mut places: BTreeMap<String, usize> = BTreeMap::new();
    let mut bundles: Vec<Bundle> = vec![];
    // The first name of a loop determines how it is written.
    let mut called: BTreeMap<String, String> = BTreeMap::new();
    for (i, name, role) in found {
        let place = *places.entry(key(&name)).or_insert_with(|| {
            bundles.push(Bundle::default());
            bundles.len() - 1
        });
        bundles[place].names.push(i);
        bundles[place].has_pv |= role == Some(Role::Signal(Signal::Pv));
        if !matches!(role, Some(Role::Signal(_) | Role::Quality(_))) {
            continue;
        }
        called.entry(name.to_lowercase()).or_insert_with(|| name.clone());
        let known = bundles[place]
            .loops
            .iter()
            .any(|(known, _)| known.to_lowercase() == name.to_lowercase());
        if role == Some(Role::Signal(Signal::Op)) && !known {
            bundles[place].loops.push((name, i));
        }
    }
    for (name, _) in bundles.iter_mut().flat_map(|bundle| &mut bundle.loops) {
        if let Some(called) = called.get(&name.to_lowercase()) {
            name.clone_from(called);
        }
    }
    bundles.retain(|bundle| !bundle.loops.is_empty());
    (bundles.len() > 1).then_some(bundles)
}

/// The signals of loops among `names` that are in none of the bundles, because their loop has no OP.
pub fn without_op(names: &[&str], bundles: &[Bundle], options: &ReadOptions) -> Vec<usize> {
    let given = Given::of(options);
    let used: HashSet<usize> = bundles.iter().flat_map(|bundle| &bundle.names).copied().collect();
    let is_signal = |name: &str| {
        candidate(name, &given)
            .is_some_and(|of| matches!(of.role, Role::Signal(_)) && of.loop_name.is_some())
    };
    (0..names.len()).filter(|k| !used.contains(k) && is_signal(names[*k])).collect()
}
