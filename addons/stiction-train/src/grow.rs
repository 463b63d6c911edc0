//! One regression tree on gradients, grown leaf by leaf.

use crate::bins::{Bins, MISSING};
use rayon::prelude::*;
use std::ops::Range;
use stiction_diagnose::fusion::Node;

/// Bins of a histogram: the bins of known values, and one bin of missing values.
const BINS: usize = 256;

/// Additions that justify a parallel task.
const WORTH_A_TASK: usize = 20_000;

/// Sums of gradients and of second derivatives.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
struct Sum {
    g: f64,
    h: f64,
}

impl std::ops::Add for Sum {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self { g: self.g + other.g, h: self.h + other.h }
    }
}

impl std::ops::Sub for Sum {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        Self { g: self.g - other.g, h: self.h - other.h }
    }
}

/// Limits of a tree.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    /// The most leaves.
    pub leaves: usize,
    /// The smallest sum of second derivatives in a leaf.
    pub least_weight: f64,
    /// Addition to that sum: it pulls leaves to 0.
    pub l2: f64,
}

/// A split of a column, and its gain.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Split {
    column: usize,
    bin: u8,
    missing_right: bool,
    gain: f64,
    /// Sums of the left side.
    left: Sum,
    /// 1 if the right leaf must not be below the left one, -1 if not above.
    monotone: i8,
}

/// A leaf that may be split.
struct Leaf {
    /// Index in the tree.
    node: usize,
    /// Range of the rows that reach the leaf.
    rows: Range<usize>,
    sum: Sum,
    /// Bounds of its value.
    bounds: (f64, f64),
    /// For each column in use, the sums of each bin.
    histogram: Vec<Sum>,
    best: Option<Split>,
}

/// A node while the tree grows.
#[derive(Debug, Clone, Copy)]
enum Growing {
    Split { column: usize, bin: u8, missing_right: bool, left: usize, right: usize },
    Leaf { value: f32 },
}

/// A tree, in bins; its rows sorted by leaf.
pub struct Tree {
    nodes: Vec<Growing>,
    /// The rows on which the tree was grown, sorted by leaf.
    rows: Vec<u32>,
    /// Index, rows and bounds of the value of each leaf.
    leaves: Vec<(usize, Range<usize>, (f64, f64))>,
}

impl Tree {
    /// Grows a tree on gradients `(g, h)` of every row, the first and second derivative of the loss. Only the given
    /// rows, which ascend, and columns are used. The leaf with the largest gain is split next, where
    /// `gain = score(left) + score(right) - score(leaf)` and `score = -(2 g w + (h + l2) w^2)` at the value
    /// `w = -g / (h + l2)`, bounded.
    ///
    /// For a monotone column, the leaves on both sides of a split must keep that order. Their middle is a bound for
    /// everything below ("basic" in LightGBM). Missing values are outside that order. Adds the gain of each split to
    /// `gains`.
    ///
    /// Source: G. Ke et al., "LightGBM: a highly efficient gradient boosting decision tree", NeurIPS 30
    /// (2017) (recalled, not read). Sums are taken in the order of the rows, so the tree does not
    /// depend on the number of threads.
    pub fn grow(
        bins: &Bins,
        gradients: &[(f32, f32)],
        rows: Vec<u32>,
        columns: &[usize],
        monotone: &[i8],
        limits: &Limits,
        gains: &mut [f64],
    ) -> Self {
        let mut grower = Grower { bins, gradients, rows, columns, monotone, limits };
        let mut nodes = vec![Growing::Leaf { value: 0.0 }];
        let mut leaves = vec![grower.root()];
        while leaves.len() < limits.leaves {
            let mut chosen: Option<(usize, Split)> = None;
            for (k, leaf) in leaves.iter().enumerate() {
                if let Some(split) = leaf.best
                    && chosen.is_none_or(|(_, best)| split.gain > best.gain)
                {
                    chosen = Some((k, split));
                }
            }
            let Some((k, split)) = chosen else { break };
            gains[split.column] += split.gain;
            let (left, right) = (nodes.len(), nodes.len() + 1);
            let Split { column, bin, missing_right, .. } = split;
            nodes[leaves[k].node] = Growing::Split { column, bin, missing_right, left, right };
            nodes.extend([Growing::Leaf { value: 0.0 }; 2]);
            let leaf = leaves.swap_remove(k);
            // The children of the last split are not split again.
            let last = leaves.len() + 2 == limits.leaves;
            leaves.extend(grower.part(leaf, split, (left, right), last));
        }
        for leaf in &leaves {
            nodes[leaf.node] = Growing::Leaf { value: grower.value(leaf.sum, leaf.bounds) as f32 };
        }
        let places = leaves.into_iter().map(|leaf| (leaf.node, leaf.rows, leaf.bounds)).collect();
        Self { nodes, rows: grower.rows, leaves: places }
    }

    /// Replaces the value of every leaf by `value` of its rows and present value.
    pub fn revalue(&mut self, value: impl Fn(&[u32], f32) -> f32 + Sync) {
        let values: Vec<f32> = self
            .leaves
            .par_iter()
            .map(|(node, rows, _)| match self.nodes[*node] {
                Growing::Leaf { value: now } => value(&self.rows[rows.clone()], now),
                Growing::Split { .. } => 0.0,
            })
            .collect();
        for ((node, ..), value) in self.leaves.iter().zip(values) {
            self.nodes[*node] = Growing::Leaf { value };
        }
    }

    /// Output at a row.
    pub fn value(&self, bins: &Bins, row: u32) -> f32 {
        let mut at = 0;
        loop {
            match self.nodes[at] {
                Growing::Leaf { value } => return value,
                Growing::Split { column, bin, missing_right, left, right } => {
                    let code = bins.codes(column)[row as usize];
                    let goes_right = if code == MISSING { missing_right } else { code > bin };
                    at = if goes_right { right } else { left };
                }
            }
        }
    }

    /// Nodes in preorder, thresholds in the features' units.
    pub fn nodes(&self, bins: &Bins) -> Vec<Node> {
        let mut out = Vec::with_capacity(self.nodes.len());
        let mut to_come = vec![0];
        while let Some(at) = to_come.pop() {
            out.push(match self.nodes[at] {
                Growing::Leaf { value } => Node::Leaf(value),
                Growing::Split { column, bin, missing_right, left, right } => {
                    to_come.extend([right, left]);
                    let threshold = bins.end(column, bin);
                    Node::Split { feature: column as u16, threshold, missing_right }
                }
            });
        }
        out
    }
}

struct Grower<'a> {
    bins: &'a Bins,
    gradients: &'a [(f32, f32)],
    rows: Vec<u32>,
    columns: &'a [usize],
    monotone: &'a [i8],
    limits: &'a Limits,
}

impl Grower<'_> {
    fn root(&self) -> Leaf {
        let rows = 0..self.rows.len();
        let mut histogram = self.empty();
        self.fill(rows.clone(), &mut histogram);
        // Every histogram contains every row: the first one's sum is that of all.
        let sum = histogram.iter().take(BINS).fold(Sum::default(), |sum, bin| sum + *bin);
        let mut leaf = Leaf {
            node: 0,
            rows,
            sum,
            bounds: (f64::NEG_INFINITY, f64::INFINITY),
            histogram,
            best: None,
        };
        leaf.best = self.best(&leaf);
        leaf
    }

    fn empty(&self) -> Vec<Sum> {
        vec![Sum::default(); self.columns.len() * BINS]
    }

    /// Columns per task, with this many additions each.
    fn columns_a_task(&self, additions: usize) -> usize {
        (WORTH_A_TASK / additions.max(1)).max(1)
    }

    /// Adds the rows' gradients to their bins.
    fn fill(&self, rows: Range<usize>, histogram: &mut [Sum]) {
        let rows = &self.rows[rows];
        // In the order of the rows, so that each column reads them sequentially.
        let gradients: Vec<(f32, f32)> =
            rows.iter().map(|row| self.gradients[*row as usize]).collect();
        histogram
            .par_chunks_mut(BINS)
            .zip(self.columns)
            .with_min_len(self.columns_a_task(rows.len()))
            .for_each(|(histogram, column)| {
                let codes = self.bins.codes(*column);
                for (row, (g, h)) in rows.iter().zip(&gradients) {
                    let bin = &mut histogram[usize::from(codes[*row as usize])];
                    bin.g += f64::from(*g);
                    bin.h += f64::from(*h);
                }
            });
    }

    /// The two leaves of a split.
    fn part(&mut self, leaf: Leaf, split: Split, places: (usize, usize), last: bool) -> [Leaf; 2] {
        let codes = self.bins.codes(split.column);
        let goes_right = |row: &u32| match codes[*row as usize] {
            MISSING => split.missing_right,
            code => code > split.bin,
        };
        let rows = &mut self.rows[leaf.rows.clone()];
        let right: Vec<u32> = rows.iter().copied().filter(goes_right).collect();
        let mut kept = 0;
        for k in 0..rows.len() {
            let row = rows[k];
            if !goes_right(&row) {
                rows[kept] = row;
                kept += 1;
            }
        }
        rows[kept..].copy_from_slice(&right);
        let middle = leaf.rows.start + kept;

        let sums = (split.left, leaf.sum - split.left);
        let (left_bounds, right_bounds) = match split.monotone {
            0 => (leaf.bounds, leaf.bounds),
            monotone => {
                let (low, high) = leaf.bounds;
                let values = (self.value(sums.0, leaf.bounds), self.value(sums.1, leaf.bounds));
                let parting = 0.5 * (values.0 + values.1);
                if monotone > 0 {
                    ((low, parting), (parting, high))
                } else {
                    ((parting, high), (low, parting))
                }
            }
        };
        let child = |node, rows, sum, bounds| Leaf {
            node,
            rows,
            sum,
            bounds,
            histogram: vec![],
            best: None,
        };
        let mut children = [
            child(places.0, leaf.rows.start..middle, sums.0, left_bounds),
            child(places.1, middle..leaf.rows.end, sums.1, right_bounds),
        ];
        let splittable = |leaf: &Leaf| leaf.sum.h >= 2.0 * self.limits.least_weight;
        if last || !children.iter().any(splittable) {
            return children;
        }
        // The smaller child is counted; the larger one is its parent less the smaller.
        let small = usize::from(children[0].rows.len() > children[1].rows.len());
        let mut counted = self.empty();
        self.fill(children[small].rows.clone(), &mut counted);
        let mut rest = leaf.histogram;
        rest.iter_mut().zip(&counted).for_each(|(rest, counted)| *rest = *rest - *counted);
        children[small].histogram = counted;
        children[1 - small].histogram = rest;
        for leaf in &mut children {
            leaf.best = if splittable(leaf) { self.best(leaf) } else { None };
        }
        children
    }

    /// The value of a leaf.
    fn value(&self, sum: Sum, (low, high): (f64, f64)) -> f64 {
        (-sum.g / (sum.h + self.limits.l2)).max(low).min(high)
    }

    /// Twice the reduction of the loss by a leaf of that value.
    fn score(&self, sum: Sum, value: f64) -> f64 {
        -value * (2.0 * sum.g + (sum.h + self.limits.l2) * value)
    }

    /// The best split of a leaf over all columns, the first of equals.
    fn best(&self, leaf: &Leaf) -> Option<Split> {
        let best: Vec<Option<Split>> = leaf
            .histogram
            .par_chunks(BINS)
            .zip(self.columns)
            .with_min_len(self.columns_a_task(4 * BINS))
            .map(|(histogram, column)| self.best_of_column(leaf, histogram, *column))
            .collect();
        let mut chosen: Option<Split> = None;
        for split in best.into_iter().flatten() {
            if chosen.is_none_or(|best| split.gain > best.gain) {
                chosen = Some(split);
            }
        }
        chosen
    }

    fn best_of_column(&self, leaf: &Leaf, histogram: &[Sum], column: usize) -> Option<Split> {
        let least = self.limits.least_weight;
        let missing = histogram[usize::from(MISSING)];
        let bins = self.bins.bins(column);
        let unsplit = self.score(leaf.sum, self.value(leaf.sum, leaf.bounds));
        // Rounding leaves a trace of removed rows, which is not a gain.
        let mut best_gain = 1e-9 * (1.0 + unsplit.abs());
        let mut best = None;
        let any_missing = missing.h > 1e-6 * least.max(1e-6);
        let ways: &[bool] = if any_missing { &[true, false] } else { &[true] };
        for &missing_right in ways {
            let mut left = if missing_right { Sum::default() } else { missing };
            // The end of the last bin separates missing values from all others.
            let ends = if any_missing && missing_right { bins } else { bins - 1 };
            for bin in 0..ends {
                left = left + histogram[bin];
                let right = leaf.sum - left;
                if left.h < least {
                    continue;
                }
                if right.h < least {
                    break;
                }
                let monotone = if bin + 1 == bins { 0 } else { self.monotone[column] };
                let (l, r) = (self.value(left, leaf.bounds), self.value(right, leaf.bounds));
                if (monotone > 0 && l > r) || (monotone < 0 && l < r) {
                    continue;
                }
                let gain = self.score(left, l) + self.score(right, r) - unsplit;
                if gain > best_gain {
                    best_gain = gain;
                    // Without missing values in training, later ones go with the majority.
                    let missing_right = if any_missing { missing_right } else { right.h > left.h };
                    best =
                        Some(Split { column, bin: bin as u8, missing_right, gain, left, monotone });
                }
            }
        }
        best
    }
}
