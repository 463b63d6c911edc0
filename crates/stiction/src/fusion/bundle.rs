//! All that training leaves behind, and its file.

use super::bytes::{Reader, Writer, damaged};
use super::calibration::Calibration;
use super::cause::Cause;
use super::quantiles::Quantiles;
use super::trees::{Ensemble, LEAF, MISSING_RIGHT, MOST_FEATURES, Node};
use crate::error::{Error, Result};
use crate::evidence::Line;

/// The first bytes of a file.
const MAGIC: [u8; 8] = *b"STICTION";

/// The version of its form.
const VERSION: u32 = 1;

/// Everything that is frozen: what the verdict's probabilities and intervals are computed with.
#[derive(Debug, Clone, PartialEq)]
pub struct Bundle {
    /// Where it comes from.
    pub provenance: Provenance,
    /// The names of the features it was trained on, in their order.
    pub features: Vec<String>,
    /// For recordings of OP and PV.
    pub full: Model,
    /// For recordings of the OP alone. Its trees split by features of the OP only.
    pub op_only: Model,
}

/// Where a bundle comes from: enough to train it again.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Provenance {
    /// The command that trained it.
    pub command: String,
    /// Version of the population it was trained on.
    pub population: u32,
    /// Seed of that population.
    pub seed: u64,
    /// Members it was trained on, from index 0.
    pub trained: u64,
    /// Members after those, which calibration and intervals rest on.
    pub calibrated: u64,
}

/// The sums of trees of one kind of recording.
#[derive(Debug, Clone, PartialEq)]
pub struct Model {
    /// The margin of a fault: the valve sticks visibly, or does not respond.
    pub fault: Ensemble,
    /// From that margin to a probability.
    pub calibration: Calibration,
    /// What each line of evidence makes of a fault by itself, of those in [`Line::WEIGHED`] that the
    /// recording has.
    pub lines: Vec<(Line, Ensemble, Calibration)>,
    /// The logit of no response, given a fault.
    pub no_response: Ensemble,
    /// The margins of the other causes, given no fault: their shares are the softmax of these.
    pub causes: Vec<(Cause, Ensemble)>,
    /// Quantiles of `ln(S / OP span)`, given that the valve sticks.
    pub s: Quantiles,
    /// Quantiles of J/S, given that the valve sticks.
    pub j_over_s: Quantiles,
}

impl Bundle {
    /// Refuses features other than those the bundle was trained on.
    ///
    /// # Errors
    /// If one is missing, extra or elsewhere; the error names it.
    pub fn check<'a>(&self, names: impl IntoIterator<Item = &'a str>) -> Result<()> {
        let mut names = names.into_iter();
        let trained = "the model of the verdict was trained on other features: train it again";
        for (k, known) in self.features.iter().enumerate() {
            match names.next() {
                Some(name) if name == known => {}
                Some(name) => {
                    let what = format!("feature {k} is {name}, but was {known} ({trained})");
                    return Err(Error::Bundle(what));
                }
                None => return Err(Error::Bundle(format!("feature {known} is gone ({trained})"))),
            }
        }
        match names.next() {
            Some(name) => Err(Error::Bundle(format!("feature {name} is new ({trained})"))),
            None => Ok(()),
        }
    }

    /// Its file.
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut out = Writer(MAGIC.to_vec());
        out.u32(VERSION);
        let Provenance { command, population, seed, trained, calibrated } = &self.provenance;
        out.text(command);
        out.u32(*population);
        [seed, trained, calibrated].into_iter().for_each(|number| out.u64(*number));
        out.list(self.features.iter(), |out, name| out.text(name));
        self.full.write(&mut out);
        self.op_only.write(&mut out);
        out.0
    }

    /// Reads a file.
    ///
    /// # Errors
    /// If it is not one, is of another version, ends early, goes on after its end, or holds trees,
    /// calibrations or intervals that are not sound.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self> {
        let rest = bytes.strip_prefix(&MAGIC).ok_or_else(|| damaged("is not a model"))?;
        let mut from = Reader(rest);
        let version = from.u32()?;
        if version != VERSION {
            return Err(damaged(&format!("has version {version}, but {VERSION} is known")));
        }
        let provenance = Provenance {
            command: from.text()?,
            population: from.u32()?,
            seed: from.u64()?,
            trained: from.u64()?,
            calibrated: from.u64()?,
        };
        let features = from.list(4, Reader::text)?;
        if features.len() > MOST_FEATURES {
            return Err(damaged("has too many features"));
        }
        let full = Model::read(&mut from, features.len())?;
        let op_only = Model::read(&mut from, features.len())?;
        if !from.0.is_empty() {
            return Err(damaged("goes on after its end"));
        }
        Ok(Self { provenance, features, full, op_only })
    }
}

impl Model {
    /// Its sums of trees, each with a name for people.
    pub fn ensembles(&self) -> Vec<(String, &Ensemble)> {
        let mut all =
            vec![("fault".to_owned(), &self.fault), ("no response".to_owned(), &self.no_response)];
        all.extend(self.lines.iter().map(|(line, trees, _)| (line.name().to_owned(), trees)));
        all.extend(self.causes.iter().map(|(cause, trees)| (cause.name().to_owned(), trees)));
        for (what, quantiles) in [("S", &self.s), ("J/S", &self.j_over_s)] {
            let Quantiles { low, middle, high, .. } = quantiles;
            for (which, trees) in [("low", low), ("median", middle), ("high", high)] {
                all.push((format!("{what}, {which}"), trees));
            }
        }
        all
    }

    fn write(&self, out: &mut Writer) {
        write_trees(out, &self.fault);
        write_calibration(out, &self.calibration);
        out.list(self.lines.iter(), |out, (line, trees, calibration)| {
            out.text(line.name());
            write_trees(out, trees);
            write_calibration(out, calibration);
        });
        write_trees(out, &self.no_response);
        out.list(self.causes.iter(), |out, (cause, trees)| {
            out.text(cause.name());
            write_trees(out, trees);
        });
        for Quantiles { low, middle, high, shifts } in [&self.s, &self.j_over_s] {
            [low, middle, high].into_iter().for_each(|trees| write_trees(out, trees));
            out.list(shifts.iter(), |out, (width, shift)| {
                out.f64(*width);
                out.f64(*shift);
            });
        }
    }

    fn read(from: &mut Reader<'_>, features: usize) -> Result<Self> {
        let trees = |from: &mut Reader<'_>| {
            let trees = read_trees(from)?;
            if trees.features() > features {
                return Err(damaged("splits by a feature that has no name"));
            }
            Ok(trees)
        };
        let quantiles = |from: &mut Reader<'_>| {
            let [low, middle, high] = [trees(from)?, trees(from)?, trees(from)?];
            let shifts = from.list(16, |from| Ok((from.f64()?, from.f64()?)))?;
            Quantiles { low, middle, high, shifts }.checked()
        };
        Ok(Self {
            fault: trees(from)?,
            calibration: read_calibration(from)?,
            lines: from.list(16, |from| {
                let name = from.text()?;
                let known = Line::WEIGHED.into_iter().find(|(line, _)| line.name() == name);
                let (line, _) =
                    known.ok_or_else(|| damaged("names an unknown line of evidence"))?;
                Ok((line, trees(from)?, read_calibration(from)?))
            })?,
            no_response: trees(from)?,
            causes: from.list(16, |from| {
                let name = from.text()?;
                let known = Cause::ALL.into_iter().find(|cause| cause.name() == name);
                let cause = known.ok_or_else(|| damaged("names an unknown cause"))?;
                if cause.is_fault() {
                    return Err(damaged("has a fault among the other causes"));
                }
                Ok((cause, trees(from)?))
            })?,
            s: quantiles(from)?,
            j_over_s: quantiles(from)?,
        })
    }
}

/// The base, and the nodes of every tree in preorder; so no file can hold a node that leads nowhere.
fn write_trees(out: &mut Writer, trees: &Ensemble) {
    out.f64(trees.base());
    let trees: Vec<Vec<Node>> = trees.nodes().collect();
    out.list(trees.iter(), |out, tree| {
        out.list(tree.iter(), |out, node| match *node {
            Node::Split { feature, threshold, missing_right } => {
                out.u16(feature | if missing_right { MISSING_RIGHT } else { 0 });
                out.f32(threshold);
            }
            Node::Leaf(value) => {
                out.u16(LEAF);
                out.f32(value);
            }
        });
    });
}

fn read_trees(from: &mut Reader<'_>) -> Result<Ensemble> {
    let base = from.f64()?;
    let trees = from.list(10, |from| {
        from.list(6, |from| {
            let (feature, value) = (from.u16()?, from.f32()?);
            Ok(match feature {
                LEAF => Node::Leaf(value),
                feature => Node::Split {
                    feature: feature & !MISSING_RIGHT,
                    threshold: value,
                    missing_right: feature & MISSING_RIGHT != 0,
                },
            })
        })
    })?;
    Ensemble::new(base, &trees)
}

fn write_calibration(out: &mut Writer, calibration: &Calibration) {
    match calibration {
        Calibration::Beta { a, b, c } => {
            out.u8(0);
            [a, b, c].into_iter().for_each(|number| out.f64(*number));
        }
        Calibration::Isotonic(points) => {
            out.u8(1);
            out.list(points.iter(), |out, (margin, probability)| {
                out.f64(*margin);
                out.f64(*probability);
            });
        }
    }
}

fn read_calibration(from: &mut Reader<'_>) -> Result<Calibration> {
    match from.u8()? {
        0 => Calibration::Beta { a: from.f64()?, b: from.f64()?, c: from.f64()? },
        1 => Calibration::Isotonic(from.list(16, |from| Ok((from.f64()?, from.f64()?)))?),
        _ => return Err(damaged("has an unknown calibration")),
    }
    .checked()
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use proptest::prelude::*;

    fn stump(feature: u16, left: f32, right: f32) -> Ensemble {
        let split =
            Node::Split { feature, threshold: 0.0, missing_right: feature.is_multiple_of(2) };
        Ensemble::new(0.25, &[vec![split, Node::Leaf(left), Node::Leaf(right)]]).unwrap()
    }

    fn model(shift: f32) -> Model {
        let quantiles = |middle: f32| Quantiles {
            low: stump(0, middle - 0.5 - shift, middle - 0.5),
            middle: stump(0, middle - shift, middle),
            high: stump(0, middle + 0.5 - shift, middle + 0.5),
            shifts: vec![(1.0, 0.0), (f64::INFINITY, 0.125)],
        };
        let others = Cause::ALL.into_iter().filter(|cause| !cause.is_fault());
        Model {
            fault: stump(0, -2.0, 2.0),
            calibration: Calibration::Isotonic(vec![(-2.0, 0.1), (2.0, 0.9)]),
            lines: vec![(Line::Model, stump(1, -0.5, 0.5), Calibration::IDENTITY)],
            no_response: stump(1, -1.0, 3.0),
            causes: others.enumerate().map(|(k, c)| (c, stump(1, k as f32, 0.0))).collect(),
            s: quantiles(-0.5),
            j_over_s: quantiles(0.5),
        }
    }

    /// A small one, of two features.
    pub fn bundle() -> Bundle {
        Bundle {
            provenance: Provenance {
                command: "made by hand".into(),
                seed: 7,
                ..Default::default()
            },
            features: vec!["first".into(), "second".into()],
            full: model(0.0),
            op_only: Model { calibration: Calibration::IDENTITY, ..model(0.25) },
        }
    }

    #[test]
    fn a_file_gives_back_what_was_written() {
        let bytes = bundle().to_bytes();
        assert_eq!(Bundle::from_bytes(&bytes).unwrap(), bundle());
    }

    #[test]
    fn every_shortened_or_lengthened_file_is_refused() {
        let bytes = bundle().to_bytes();
        for end in 0..bytes.len() {
            assert!(Bundle::from_bytes(&bytes[..end]).is_err(), "{end} bytes are enough");
        }
        let longer = [&bytes[..], &[0]].concat();
        assert!(Bundle::from_bytes(&longer).is_err());
    }

    #[test]
    fn other_features_are_named() {
        let said = |names: &[&str]| bundle().check(names.iter().copied()).unwrap_err().to_string();
        assert!(bundle().check(["first", "second"]).is_ok());
        assert!(said(&["first", "other"]).contains("feature 1 is other, but was second"));
        assert!(said(&["first"]).contains("second is gone"));
        assert!(said(&["first", "second", "third"]).contains("third is new"));
    }

    proptest! {
        #[test]
        fn garbage_is_no_model(garbage in proptest::collection::vec(any::<u8>(), 0..400)) {
            prop_assert!(Bundle::from_bytes(&garbage).is_err());
            let mut headed = MAGIC.to_vec();
            headed.extend(VERSION.to_le_bytes());
            headed.extend(garbage);
            prop_assert!(Bundle::from_bytes(&headed).is_err());
        }

        /// A damaged file is refused, or is a model that can be asked.
        #[test]
        fn damage_never_panics(
            damage in proptest::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..8),
            values in proptest::array::uniform2(-3.0..3.0f64),
        ) {
            let mut bytes = bundle().to_bytes();
            for (at, value) in damage {
                let at = at.index(bytes.len());
                bytes[at] = value;
            }
            if let Ok(read) = Bundle::from_bytes(&bytes)
                && let Ok(weighed) = read.weigh(&values, 10.0, false)
            {
                prop_assert!((0.0..=1.0).contains(&weighed.probability));
            }
        }
    }
}
