//! Sums of trees of thresholds.

use crate::error::{Error, Result};
use std::hint::select_unpredictable as select;

/// A node of a tree.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Node {
    /// Values of a feature up to the threshold go left, larger ones right.
    Split {
        /// Index of the feature.
        feature: u16,
        /// The largest value that goes left; infinite if the split separates missing values from all others.
        threshold: f32,
        /// Whether a missing value goes right.
        missing_right: bool,
    },
    /// The value that the tree adds.
    Leaf(f32),
}

/// A sum of trees: `f(x) = base + sum_t leaf_t(x)`.
///
/// Features are compared as `f32`, as they were in training. A feature that is NaN or infinite counts as missing
/// and takes the branch that each node has for missing values. The sum is in the order of the trees, so the same
/// values give the same bits.
#[derive(Debug, Clone, PartialEq)]
pub struct Ensemble {
    base: f64,
    /// The nodes of all trees, each tree in preorder: the left child of a node is the next one.
    steps: Vec<Step>,
    /// The root of each tree.
    roots: Vec<u32>,
}

/// A node in eight bytes, because a verdict visits tens of thousands of them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Step {
    /// Index of the feature, or [`LEAF`]; the highest bit means that missing values go right.
    feature: u16,
    /// Distance from the node to its right child.
    right: u16,
    /// The threshold, or the value of a leaf.
    value: f32,
}

/// The feature of a leaf, in memory and in a file.
const LEAF: u16 = 0x7fff;

/// The largest number of splits from the root of a tree to a leaf.
const DEEPEST: usize = u8::MAX as usize;

/// The bit of a feature that sends missing values right.
const MISSING_RIGHT: u16 = 0x8000;

/// The largest number of features.
pub const MOST_FEATURES: usize = LEAF as usize;

/// Features as trees compare them: `f32`, and NaN for missing or infinite values.
pub fn row(values: &[f64]) -> Vec<f32> {
    values.iter().map(|&v| v as f32).map(|v| if v.is_finite() { v } else { f32::NAN }).collect()
}

impl Ensemble {
    /// The sum of a base and trees. The nodes of each tree are given in preorder: a split, its whole left branch, its
    /// whole right branch.
    ///
    /// # Errors
    /// If a tree is not complete, continues after its end, branches right beyond 65,535 nodes or has more than 255
    /// splits in a row, a feature is [`MOST_FEATURES`] or above, a threshold is NaN, or the base or a leaf is not
    /// finite.
    pub fn new(base: f64, trees: &[Vec<Node>]) -> Result<Self> {
        let steps = trees.iter().flatten().map(|node| Step::of(*node)).collect::<Result<_>>()?;
        let all = Self::of_steps(base, steps)?;
        let starts = trees.iter().scan(0, |end, tree| {
            *end += tree.len();
            Some((*end - tree.len()) as u32)
        });
        match all.roots.iter().copied().eq(starts) {
            true => Ok(all),
            false => Err(damaged("a tree ends too early or too late")),
        }
    }

    /// The sum of a base and of consecutive trees, each in preorder.
    pub(super) fn of_steps(base: f64, mut steps: Vec<Step>) -> Result<Self> {
        if !base.is_finite() || steps.len() > u32::MAX as usize {
            return Err(damaged("a sum of trees has no base or too many nodes"));
        }
        // After its first entry, the splits whose right branch has not begun, `depth` of them.
        let (mut open, mut depth) = ([0_u32; DEEPEST + 1], 0_u8);
        let (mut roots, mut root, mut whole) = (vec![], 0, true);
        for place in 0..steps.len() {
            if whole {
                root = place;
                roots.push(root as u32);
            }
            let Step { feature, value, .. } = steps[place];
            let leaf = feature == LEAF;
            if value.is_nan() | (leaf & value.is_infinite()) {
                return Err(damaged("a threshold or a leaf of a tree is not a number"));
            }
            whole = leaf & (depth == 0);
            if whole {
                continue;
            }
            // Behind a leaf begins the right branch of the last open split. What a split gets here is overwritten.
            // Without a branch, for the processor could not predict it.
            let split = select(leaf, open[usize::from(depth)] as usize, place);
            let right = u16::try_from(place + 1 - root);
            steps[split].right = right.map_err(|_| damaged("a tree has too many nodes"))?;
            if !leaf & (usize::from(depth) == DEEPEST) {
                return Err(damaged("a tree is too deep"));
            }
            open[usize::from(depth.wrapping_add(1))] = place as u32;
            depth = select(leaf, depth.wrapping_sub(1), depth.wrapping_add(1));
        }
        match whole {
            true => Ok(Self { base, steps, roots }),
            false => Err(damaged("a tree has no end")),
        }
    }

    /// The mean of sums of trees; 0 for none.
    pub fn mean(ensembles: &[Self]) -> Self {
        let share = 1.0 / ensembles.len().max(1) as f64;
        let mut mean = Self { base: 0.0, steps: vec![], roots: vec![] };
        for each in ensembles {
            mean.base += share * each.base;
            let before = mean.steps.len() as u32;
            mean.roots.extend(each.roots.iter().map(|root| root + before));
            mean.steps.extend(each.steps.iter().map(|step| match step.feature {
                LEAF => Step { value: (share * f64::from(step.value)) as f32, ..*step },
                _ => *step,
            }));
        }
        mean
    }

    /// The trees as in a file. Leaves are 16-bit integers times the smallest sufficient power of two. Rounding again
    /// changes nothing.
    pub fn rounded(mut self) -> Self {
        let unit = 2f64.powi(self.exponent());
        for leaf in self.steps.iter_mut().filter(|step| step.feature == LEAF) {
            leaf.value = ((f64::from(leaf.value) / unit).round() * unit) as f32;
        }
        self
    }

    /// The exponent of that power of two.
    pub(super) fn exponent(&self) -> i32 {
        let leaves = self.steps.iter().filter(|step| step.feature == LEAF);
        let largest = leaves.map(|step| f64::from(step.value.abs())).fold(0.0, f64::max);
        let exponent = (largest / f64::from(i16::MAX)).log2().ceil();
        // Below, `f32` has no whole steps. Without a leaf, or with zeros only, any exponent works.
        if exponent.is_finite() { (exponent as i32).max(-120) } else { 0 }
    }

    /// The sum at a [`row`] of features. A feature beyond its end is missing.
    pub fn margin(&self, row: &[f32]) -> f64 {
        let mut sum = self.base;
        for &root in &self.roots {
            let mut at = root as usize;
            sum += loop {
                let step = self.steps[at];
                if step.feature == LEAF {
                    break f64::from(step.value);
                }
                let value = row.get(usize::from(step.feature & LEAF)).copied().unwrap_or(f32::NAN);
                let missing_right = step.feature & MISSING_RIGHT != 0;
                let goes_right = value > step.value || (value.is_nan() && missing_right);
                at = if goes_right { root as usize + usize::from(step.right) } else { at + 1 };
            };
        }
        sum
    }

    /// The constant before the first tree.
    pub fn base(&self) -> f64 {
        self.base
    }

    /// Number of trees.
    pub fn trees(&self) -> usize {
        self.roots.len()
    }

    /// The nodes of each tree, in preorder.
    pub fn nodes(&self) -> impl Iterator<Item = Vec<Node>> + '_ {
        let ends = self.roots.iter().skip(1).map(|root| *root as usize);
        let ends = ends.chain([self.steps.len()]);
        self.roots.iter().zip(ends).map(|(from, to)| {
            self.steps[*from as usize..to].iter().map(|step| Node::from(*step)).collect()
        })
    }

    /// One more than the largest feature it splits by.
    pub fn features(&self) -> usize {
        let splits = self.steps.iter().filter(|step| step.feature != LEAF);
        splits.map(|step| usize::from(step.feature & LEAF) + 1).max().unwrap_or(0)
    }
}

impl Step {
    pub fn split(feature: u16, threshold: f32, missing_right: bool) -> Self {
        let feature = feature | if missing_right { MISSING_RIGHT } else { 0 };
        Self { feature, right: 0, value: threshold }
    }

    pub fn leaf(value: f32) -> Self {
        Self { feature: LEAF, right: 0, value }
    }

    fn of(node: Node) -> Result<Self> {
        match node {
            Node::Split { feature: LEAF.., .. } => Err(damaged("a tree splits without a feature")),
            Node::Split { feature, threshold, missing_right } => {
                Ok(Self::split(feature, threshold, missing_right))
            }
            Node::Leaf(value) => Ok(Self::leaf(value)),
        }
    }
}

impl From<Step> for Node {
    fn from(step: Step) -> Self {
        match step.feature {
            LEAF => Self::Leaf(step.value),
            feature => Self::Split {
                feature: feature & LEAF,
                threshold: step.value,
                missing_right: feature & MISSING_RIGHT != 0,
            },
        }
    }
}

fn damaged(reason: &str) -> Error {
    Error::Bundle(reason.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn split(feature: u16, threshold: f32, missing_right: bool) -> Node {
        Node::Split { feature, threshold, missing_right }
    }

    /// `x0 <= 1 ? (x1 <= 0 ? 1 : 2) : 4`, missing x0 going right, missing x1 left.
    fn two_levels() -> Vec<Node> {
        let leaf = Node::Leaf;
        vec![split(0, 1.0, true), split(1, 0.0, false), leaf(1.0), leaf(2.0), leaf(4.0)]
    }

    #[test]
    fn values_take_their_ways() {
        let trees = Ensemble::new(0.5, &[two_levels(), vec![Node::Leaf(10.0)]]).unwrap();
        let at = |values: &[f64]| trees.margin(&row(values)) - 10.5;
        assert_eq!(at(&[1.0, 0.0]), 1.0);
        assert_eq!(at(&[1.0, 0.1]), 2.0);
        assert_eq!(at(&[1.1, 0.0]), 4.0);
        assert_eq!(at(&[f64::NAN, 0.0]), 4.0);
        assert_eq!(at(&[f64::INFINITY, 0.0]), 4.0);
        assert_eq!(at(&[1.0, f64::NAN]), 1.0);
        assert_eq!(at(&[1.0]), 1.0);
        assert_eq!((trees.trees(), trees.features(), trees.base()), (2, 2, 0.5));
    }

    #[test]
    fn nodes_come_back() {
        let trees = vec![two_levels(), vec![Node::Leaf(3.0)], two_levels()];
        let ensemble = Ensemble::new(1.0, &trees).unwrap();
        assert_eq!(ensemble.nodes().collect::<Vec<_>>(), trees);
    }

    #[test]
    fn a_mean_is_the_mean_of_margins() {
        let a = Ensemble::new(1.0, &[two_levels()]).unwrap();
        let b = Ensemble::new(3.0, &[vec![Node::Leaf(2.0)], two_levels()]).unwrap();
        let mean = Ensemble::mean(&[a.clone(), b.clone()]);
        for x in [0.0_f32, 2.0, f32::NAN] {
            for y in [-1.0_f32, 1.0] {
                let expected = 0.5 * (a.margin(&[x, y]) + b.margin(&[x, y]));
                assert_eq!(mean.margin(&[x, y]), expected);
            }
        }
        assert_eq!(Ensemble::mean(&[]).margin(&[]), 0.0);
    }

    #[test]
    fn rounding_changes_little_and_only_once() {
        for scale in [1e-30_f32, 1e-3, 0.37, 1.0, 5e9, 3e38] {
            let leaves = [-1.0, 0.123_456, 0.0, 0.999_99].map(|x| vec![Node::Leaf(scale * x)]);
            let plain = Ensemble::new(0.0, &leaves).unwrap();
            let once = plain.clone().rounded();
            for (a, b) in once.steps.iter().zip(&plain.steps) {
                assert!((a.value - b.value).abs() <= scale / 32_000.0, "{} {}", a.value, b.value);
            }
            assert_eq!(once.clone().rounded(), once);
        }
        assert_eq!(Ensemble::mean(&[]).rounded(), Ensemble::mean(&[]));
    }

    #[test]
    fn what_is_no_tree_is_refused() {
        let leaf = Node::Leaf(0.0);
        for tree in [
            vec![],
            vec![leaf, leaf],
            vec![split(0, 0.0, true), leaf],
            vec![split(LEAF, 0.0, true), leaf, leaf],
            vec![split(0, f32::NAN, true), leaf, leaf],
            vec![Node::Leaf(f32::NAN)],
        ] {
            assert!(Ensemble::new(0.0, std::slice::from_ref(&tree)).is_err(), "{tree:?}");
        }
        assert!(Ensemble::new(f64::NAN, &[]).is_err());
    }
}
