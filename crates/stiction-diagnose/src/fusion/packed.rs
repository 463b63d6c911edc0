//! Sums of trees in few bytes.
//!
//! All trees of a model split by the same few thresholds: training sorts the values of a feature into at most 255
//! bins. So the thresholds of each feature are written once, and splits refer to them by number. One bit each marks
//! whether a node is a split and where missing values go. Leaves are integers of 16 bits times a power of two for
//! each sum. A tree of 16 leaves takes 71 bytes.

use super::bytes::{Reader, Writer, damaged};
use super::trees::{Ensemble, Node, Step};
use crate::error::Result;

/// The thresholds of every feature, ascending.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Cuts(Vec<Vec<f32>>);

/// Number of bytes for a count.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Room {
    Byte,
    Word,
}

impl Room {
    fn of(count: usize) -> Self {
        if count <= 1 << 8 { Self::Byte } else { Self::Word }
    }

    fn bytes(self) -> usize {
        match self {
            Self::Byte => 1,
            Self::Word => 4,
        }
    }

    fn write(self, out: &mut Writer, number: usize) {
        match self {
            Self::Byte => out.u8(number as u8),
            Self::Word => out.u32(number as u32),
        }
    }

    /// The number at a place of such numbers.
    #[inline]
    fn at(self, numbers: &[u8], place: usize) -> usize {
        match self {
            Self::Byte => usize::from(numbers[place]),
            Self::Word => u32::from_le_bytes(numbers.as_chunks().0[place]) as usize,
        }
    }
}

impl Cuts {
    /// The thresholds of some sums of trees.
    pub fn of<'a>(ensembles: impl IntoIterator<Item = &'a Ensemble>, features: usize) -> Self {
        let mut all = vec![vec![]; features];
        for node in ensembles.into_iter().flat_map(Ensemble::nodes).flatten() {
            if let Node::Split { feature, threshold, .. } = node {
                all[usize::from(feature)].push(threshold);
            }
        }
        for cuts in &mut all {
            cuts.sort_by(f32::total_cmp);
            cuts.dedup_by(|a, b| a.to_bits() == b.to_bits());
        }
        Self(all)
    }

    pub fn write(&self, out: &mut Writer) {
        out.list(self.0.iter(), |out, cuts| out.list(cuts.iter(), |out, cut| out.f32(*cut)));
    }

    /// Trees with at most this number of features.
    pub fn read(from: &mut Reader<'_>, features: usize) -> Result<Self> {
        let all = from.list(4, |from| from.list(4, Reader::f32))?;
        match all.len() <= features {
            true => Ok(Self(all)),
            false => Err(damaged("splits by a feature without a name")),
        }
    }

    fn rooms(&self) -> [Room; 2] {
        let most = self.0.iter().map(Vec::len).max().unwrap_or(0);
        [Room::of(self.0.len()), Room::of(most)]
    }

    /// Writes a sum of trees, its leaves [rounded](Ensemble::rounded).
    pub fn write_trees(&self, out: &mut Writer, trees: &Ensemble) {
        let exponent = trees.exponent();
        let unit = 2f64.powi(exponent);
        let nodes: Vec<Node> = trees.nodes().flatten().collect();
        let splits: Vec<(usize, f32, bool)> = nodes
            .iter()
            .filter_map(|node| match *node {
                Node::Split { feature, threshold, missing_right } => {
                    Some((usize::from(feature), threshold, missing_right))
                }
                Node::Leaf(_) => None,
            })
            .collect();
        out.f64(trees.base());
        out.u8(exponent as i8 as u8);
        out.u32(trees.trees() as u32);
        out.u32(splits.len() as u32);
        write_bits(out, nodes.iter().map(|node| matches!(node, Node::Split { .. })));
        write_bits(out, splits.iter().map(|(.., missing_right)| *missing_right));
        let [of_features, of_cuts] = self.rooms();
        splits.iter().for_each(|(feature, ..)| of_features.write(out, *feature));
        for (feature, threshold, _) in &splits {
            let place = self.0[*feature].binary_search_by(|cut| cut.total_cmp(threshold));
            of_cuts.write(out, place.unwrap_or(0));
        }
        for node in &nodes {
            if let Node::Leaf(value) = node {
                out.u16((f64::from(*value) / unit).round() as i16 as u16);
            }
        }
    }

    pub fn read_trees(&self, from: &mut Reader<'_>) -> Result<Ensemble> {
        let base = from.f64()?;
        let unit = 2f32.powi(i32::from(from.u8()? as i8));
        let (count, splits) = (from.u32()? as usize, from.u32()? as usize);
        let [of_features, of_cuts] = self.rooms();
        // Counts that exceed the bytes are refused.
        let of_split = of_features.bytes() + of_cuts.bytes() + 2;
        let needed = splits.saturating_mul(of_split).saturating_add(count.saturating_mul(2));
        if needed > from.0.len() {
            return Err(damaged("ends before all of its trees"));
        }
        let nodes = 2 * splits + count;
        let (is_split, missing_right) =
            (from.part(nodes.div_ceil(8))?, from.part(splits.div_ceil(8))?);
        let [features, places] =
            [from.part(splits * of_features.bytes())?, from.part(splits * of_cuts.bytes())?];
        let leaves = from.part(2 * (splits + count))?.as_chunks().0;
        if is_split.iter().map(|byte| byte.count_ones() as usize).sum::<usize>() != splits {
            return Err(damaged("has a wrong number of splits"));
        }
        let mut steps = vec![Step::leaf(0.0); nodes];
        let mut k = 0;
        each_place(is_split, true, |place| {
            let feature = of_features.at(features, k);
            let cuts = self.0.get(feature).ok_or_else(|| damaged("has an unknown feature"))?;
            let threshold = cuts.get(of_cuts.at(places, k));
            let threshold = threshold.ok_or_else(|| damaged("has an unknown threshold"))?;
            let split = Step::split(feature as u16, *threshold, bit(missing_right, k));
            *steps.get_mut(place).ok_or_else(|| damaged("has one split too many"))? = split;
            k += 1;
            Ok(())
        })?;
        let mut leaves = leaves.iter();
        each_place(is_split, false, |place| {
            if let Some((step, bytes)) = steps.get_mut(place).zip(leaves.next()) {
                *step = Step::leaf(f32::from(i16::from_le_bytes(*bytes)) * unit);
            }
            Ok(())
        })?;
        let trees = Ensemble::of_steps(base, steps)?;
        match trees.trees() == count {
            true => Ok(trees),
            false => Err(damaged("has a wrong number of trees")),
        }
    }
}

/// Eight to a byte, the first in the lowest bit.
fn write_bits(out: &mut Writer, bits: impl Iterator<Item = bool>) {
    let (mut byte, mut filled) = (0, 0);
    for bit in bits {
        byte |= u8::from(bit) << filled;
        filled += 1;
        if filled == 8 {
            out.u8(byte);
            (byte, filled) = (0, 0);
        }
    }
    if filled > 0 {
        out.u8(byte);
    }
}

/// Visits the places of the bits that are set, or of the bits that are not set. It handles 64 bits at a time, because
/// the processor cannot predict each bit.
fn each_place(bits: &[u8], set: bool, mut visit: impl FnMut(usize) -> Result<()>) -> Result<()> {
    for (k, bytes) in bits.chunks(8).enumerate() {
        let mut word = [0; 8];
        word[..bytes.len()].copy_from_slice(bytes);
        let word = u64::from_le_bytes(word);
        let mut left = if set { word } else { !word };
        while left != 0 {
            visit(64 * k + left.trailing_zeros() as usize)?;
            left &= left - 1;
        }
    }
    Ok(())
}

fn bit(bytes: &[u8], k: usize) -> bool {
    bytes[k / 8] >> (k % 8) & 1 == 1
}

#[cfg(test)]
mod tests {
    use super::*;

    fn split(feature: u16, threshold: f32, missing_right: bool) -> Node {
        Node::Split { feature, threshold, missing_right }
    }

    fn through(ensemble: &Ensemble, features: usize) -> (Ensemble, usize) {
        let cuts = Cuts::of([ensemble], features);
        let mut out = Writer::default();
        cuts.write(&mut out);
        let table = out.0.len();
        cuts.write_trees(&mut out, ensemble);
        let mut from = Reader(&out.0);
        let read = Cuts::read(&mut from, features).unwrap().read_trees(&mut from).unwrap();
        assert!(from.0.is_empty());
        (read, out.0.len() - table)
    }

    #[test]
    fn rounded_trees_come_back_to_the_bit() {
        let leaf = Node::Leaf;
        let tree = |k: u16| {
            let x = f32::from(k);
            vec![
                split(k % 7, x / 3.0, k.is_multiple_of(2)),
                leaf(0.1 * x),
                split(0, f32::INFINITY, true),
                leaf(-0.01 * x),
                leaf(7.0 / (1.0 + x)),
            ]
        };
        for trees in [0, 1, 40, 3000] {
            let trees: Vec<Vec<Node>> = (0..trees).map(tree).chain([vec![leaf(0.3)]]).collect();
            let rounded = Ensemble::new(-0.7, &trees).unwrap().rounded();
            assert_eq!(through(&rounded, 7).0, rounded);
        }
        // One more feature than a byte can number.
        let wide =
            Ensemble::new(0.0, &[vec![split(256, 0.5, true), leaf(1.0), leaf(0.0)]]).unwrap();
        assert_eq!(through(&wide, 257).0, wide);
    }

    #[test]
    fn a_leaf_takes_less_than_five_bytes() {
        let tree = |k: u16| {
            let mut nodes: Vec<Node> = (0..15)
                .flat_map(|j| [split(j, f32::from(k % 200), true), Node::Leaf(1.0)])
                .collect();
            nodes.push(Node::Leaf(0.0));
            nodes
        };
        let trees: Vec<Vec<Node>> = (0..1000).map(tree).collect();
        let (_, bytes) = through(&Ensemble::new(0.0, &trees).unwrap(), 15);
        assert!(bytes <= 17 + 71 * 1000, "{bytes}");
    }
}
