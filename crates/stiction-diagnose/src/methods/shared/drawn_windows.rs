//! OP and PV in the part with the most marked windows.

use crate::drawing::{Scene, sheet};
use std::ops::Range;
use stiction_figure::figure::{Annotation, Figure, colour};

/// Largest number of windows in a figure.
const SHOWN: usize = 100;

/// OP and PV in the part with the most marked windows.
pub fn marked(scene: &Scene<'_>, lead: &str, marked: &[bool], window: usize) -> Option<Figure> {
    let periods = scene.end().len();
    let shown = (periods / window.max(1)).clamp(20, SHOWN).min(marked.len());
    let windows = busiest(marked, shown);
    let range = windows.start * window..(windows.end * window).min(scene.op().len());
    if range.is_empty() || scene.pv().len() < range.end {
        return None;
    }
    let mut panels = [
        scene
            .trend("OP (% of span)")
            .with(scene.samples("OP", scene.op(), range.clone(), true).colour(colour::OP)),
        scene
            .trend(scene.context.pv_label("PV"))
            .with(scene.samples("PV", scene.pv(), range.clone(), false).colour(colour::PV)),
    ];
    for run in runs(marked, &windows) {
        let ends = [run.start * window, (run.end * window - 1).min(range.end - 1)];
        let ends = scene.times(ends.map(|k| k as f64));
        panels = panels.map(|panel| panel.note(Annotation::x_band(ends[0], ends[1], "")));
    }
    let count = marked.iter().filter(|m| **m).count();
    let caption = format!(
        "{lead}. {count} of {} windows are shaded. The figure shows the {shown} consecutive windows that contain the most shaded windows.",
        marked.len()
    );
    let [op, pv] = panels;
    Some(sheet(caption).with(op).with(pv))
}

/// The first group of this many neighbours with the most marks.
fn busiest(marked: &[bool], length: usize) -> Range<usize> {
    let length = length.min(marked.len());
    let mut now = marked[..length].iter().filter(|m| **m).count();
    let (mut best, mut first) = (now, 0);
    for end in length..marked.len() {
        now = now + usize::from(marked[end]) - usize::from(marked[end - length]);
        if now > best {
            (best, first) = (now, end + 1 - length);
        }
    }
    first..first + length
}

/// Runs of marked neighbours in a range.
fn runs(marked: &[bool], range: &Range<usize>) -> Vec<Range<usize>> {
    let mut runs: Vec<Range<usize>> = vec![];
    for i in range.clone().filter(|i| marked[*i]) {
        match runs.last_mut() {
            Some(last) if last.end == i => last.end = i + 1,
            _ => runs.push(i..i + 1),
        }
    }
    runs
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn most_marks_in_a_row() {
        let marked = [false, true, false, true, true, false, true, false];
        assert_eq!(busiest(&marked, 4), 1..5);
        assert_eq!(busiest(&marked, 2), 3..5);
        assert_eq!(busiest(&marked, 99), 0..8);
        assert_eq!(busiest(&[], 3), 0..0);
        assert_eq!(runs(&marked, &(1..7)), [1..2, 3..5, 6..7]);
    }
}
