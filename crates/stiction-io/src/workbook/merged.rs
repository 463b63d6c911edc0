//! Merged cells, such as a tag above the columns of its signals.

use super::grid::{Cell, Grid};
use calamine::Dimensions;
use std::collections::HashSet;

/// Rows from the top of a sheet in which headers are looked for.
const TOP: usize = 40;

/// The grid with the values of merged cells where they belong.
///
/// A value over several rows is the value of each. A text over several columns belongs to the names below it, as in
/// `FIC101 PV`, if its row has no other such text, or if some names are equal and need it. A title over all columns
/// belongs to none.
pub(super) fn resolved(mut grid: Grid, merged: &[Dimensions]) -> Grid {
    let height = grid.rows.len();
    let mut groups: Vec<(usize, usize, usize)> = vec![];
    for range in merged {
        let (top, left) = (range.start.0 as usize, range.start.1 as usize);
        let (bottom, right) = (range.end.0 as usize, range.end.1 as usize);
        let value = grid.get(top, left).clone();
        if value == Cell::Empty || bottom < top || right < left {
            continue;
        }
        if right == left {
            for row in top + 1..=bottom.min(height.saturating_sub(1)) {
                if *grid.get(row, left) == Cell::Empty {
                    grid.place(row, left, value.clone());
                }
            }
        } else if bottom == top && top < TOP && matches!(value, Cell::Text(_)) {
            groups.push((top, left, right));
        }
    }
    groups.sort_unstable();
    for row in groups.chunk_by(|a, b| a.0 == b.0) {
        name_below(&mut grid, row);
    }
    grid
}

/// Texts above several names in a sheet that does not list its merged cells: each reaches to the next one.
pub(super) fn apparent(grid: &Grid) -> Vec<Dimensions> {
    let mut found = vec![];
    for row in 0..grid.rows.len().min(TOP).saturating_sub(1) {
        let is_text = |column: &usize| matches!(grid.get(row, *column), Cell::Text(_));
        let is_name = |column: usize| matches!(grid.get(row + 1, column), Cell::Text(_));
        let width = grid.rows[row + 1].len();
        let texts: Vec<usize> = (0..grid.rows[row].len()).filter(is_text).collect();
        let is_header = texts.len() > 1 || texts.first().is_some_and(|first| *first > 0);
        for (k, left) in texts.iter().enumerate() {
            let right = texts.get(k + 1).copied().unwrap_or(width).max(left + 1) - 1;
            if is_header && right > *left && (*left..=right).all(is_name) {
                let at = |column: usize| (row as u32, column as u32);
                found.push(Dimensions::new(at(*left), at(right)));
            }
        }
    }
    found
}

/// Puts the texts of a row before the names below them.
fn name_below(grid: &mut Grid, groups: &[(usize, usize, usize)]) {
    let Some(&(row, ..)) = groups.first() else { return };
    let below: Vec<(usize, std::sync::Arc<str>)> = (0..grid.rows.get(row + 1).map_or(0, Vec::len))
        .filter_map(|column| match grid.get(row + 1, column) {
            Cell::Text(name) => Some((column, name.clone())),
            _ => None,
        })
        .collect();
    let covered = |column: usize| groups.iter().find(|(_, l, r)| (*l..=*r).contains(&column));
    let is_alone = groups.len() == 1;
    let cells = grid.rows[row].iter().filter(|cell| **cell != Cell::Empty).count();
    let is_title =
        is_alone && cells == 1 && below.iter().all(|(column, _)| covered(*column).is_some());
    let mut seen = HashSet::new();
    let are_equal = below.iter().any(|(_, name)| !seen.insert(name.clone()));
    if below.len() < 2 || is_title || !(is_alone || are_equal) {
        return;
    }
    for (column, name) in below {
        if let Some((_, left, _)) = covered(column)
            && let Cell::Text(group) = grid.get(row, *left)
        {
            let name = format!("{group} {name}");
            grid.place(row + 1, column, Cell::Text(name.into()));
        }
    }
    for column in 0..grid.rows[row].len() {
        // The name of a single column stands in either row.
        let cell = std::mem::take(&mut grid.rows[row][column]);
        if covered(column).is_none() && *grid.get(row + 1, column) == Cell::Empty {
            grid.place(row + 1, column, cell);
        }
    }
}
