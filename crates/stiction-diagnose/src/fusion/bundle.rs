//! The result of training, and its file.

use super::bytes::{Reader, Writer, damaged};
use super::calibration::Calibration;
use super::confidence::{Confidence, Side};
use super::decision::Decision;
use super::limit::Limit;
use super::mismatch::Mismatch;
use super::packed::Cuts;
use super::quantiles::Quantiles;
use super::reference::{QUANTILES, Reference, Spread};
use super::trees::{Ensemble, MOST_FEATURES};
use crate::cause::Cause;
use crate::error::{Error, Result};
use crate::evidence::Line;
use std::sync::OnceLock;

/// The first bytes of a file.
const MAGIC: [u8; 8] = *b"STICTION";

/// The version of its format.
const VERSION: u32 = 4;

/// All frozen parts for the probabilities and intervals of the verdict.
#[derive(Debug, Clone, PartialEq)]
pub struct Bundle {
    /// Origin.
    pub provenance: Provenance,
    /// The names of the features it was trained on, in their order.
    pub features: Vec<String>,
    /// The thresholds to accuse or clear a valve.
    pub decision: Decision,
    /// For recordings of OP and PV.
    pub full: TrainedModel,
    /// For recordings of the OP alone. Its trees split by features of the OP only.
    pub op_only: Deferred,
}

/// Origin of a bundle: enough to train it again.
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
    /// Members after those, for calibration and intervals.
    pub calibrated: u64,
}

/// The sums of trees for one kind of recording.
#[derive(Debug, Clone, PartialEq)]
pub struct TrainedModel {
    /// The margin of a fault: the valve sticks visibly, or does not respond.
    pub fault: Ensemble,
    /// From that margin to a probability.
    pub calibration: Calibration,
    /// From that probability to the reported one.
    pub confidence: Confidence,
    /// The classifier of a fault by each line of evidence alone, for the lines in [`Line::WEIGHED`] that the recording
    /// has.
    pub lines: Vec<(Line, Ensemble, Calibration)>,
    /// The logit of no response, given a fault.
    pub no_response: Ensemble,
    /// The margins of the other causes, given no fault. Their shares are the softmax of these margins.
    pub causes: Vec<(Cause, Ensemble)>,
    /// Quantiles of `ln(S / OP span)`, given that the valve sticks.
    pub s: Quantiles,
    /// Quantiles of J/S, given that the valve sticks.
    pub j_over_s: Quantiles,
    /// An upper limit on S; `None` with the OP alone.
    pub limit: Option<Limit>,
    /// The features of the training loops.
    pub reference: Option<Reference>,
    /// Whether OP and PV belong to one loop; `None` with the OP alone.
    pub mismatch: Option<Mismatch>,
}

impl Bundle {
    /// Refuses features other than those the bundle was trained on. Features after them, which are newer than the
    /// bundle, are ignored until the next training.
    ///
    /// # Errors
    /// If a feature is missing or at a different index. The error names the feature.
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
                None => {
                    return Err(Error::Bundle(format!("feature {known} is missing ({trained})")));
                }
            }
        }
        Ok(())
    }

    /// Its file. It contains [rounded](Ensemble::rounded) leaves of trees. If they were rounded before, reading
    /// returns exactly the same bundle, otherwise nearly.
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut out = Writer(MAGIC.to_vec());
        out.u32(VERSION);
        let Provenance { command, population, seed, trained, calibrated } = &self.provenance;
        out.text(command);
        out.u32(*population);
        [seed, trained, calibrated].into_iter().for_each(|number| out.u64(*number));
        out.list(self.features.iter(), |out, name| out.text(name));
        out.f64(self.decision.accuse);
        out.f64(self.decision.clear);
        self.full.write(&mut out, self.features.len());
        out.0.extend(&self.op_only.bytes);
        out.0
    }

    /// Reads a file, except for the model of the OP alone.
    ///
    /// # Errors
    /// If the file is not a bundle, is of a different version, ends early, or has invalid
    /// trees, calibrations or intervals.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self> {
        let rest = bytes.strip_prefix(&MAGIC).ok_or_else(|| damaged("is not a model"))?;
        let mut from = Reader(rest);
        let version = from.u32()?;
        if version != VERSION {
            return Err(damaged(&format!(
                "has version {version}, but version {VERSION} is needed"
            )));
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
        let decision = Decision { accuse: from.f64()?, clear: from.f64()? }.checked()?;
        let full = TrainedModel::read(&mut from, features.len())?;
        let op_only = Deferred::of(from.0.to_vec(), features.len());
        Ok(Self { provenance, features, decision, full, op_only })
    }
}

/// A model that is read from its bytes when it is first used: it takes as long to read as a window to judge.
#[derive(Debug, Clone)]
pub struct Deferred {
    bytes: Vec<u8>,
    features: usize,
    read: OnceLock<Result<TrainedModel>>,
}

impl Deferred {
    /// A model with this number of features.
    pub fn new(model: &TrainedModel, features: usize) -> Self {
        let mut out = Writer::default();
        model.write(&mut out, features);
        Self::of(out.0, features)
    }

    fn of(bytes: Vec<u8>, features: usize) -> Self {
        Self { bytes, features, read: OnceLock::new() }
    }

    /// The model.
    ///
    /// # Errors
    /// As [`Bundle::from_bytes`], and if its bytes continue after its end.
    pub fn get(&self) -> Result<&TrainedModel> {
        let read = || {
            let mut from = Reader(&self.bytes);
            let model = TrainedModel::read(&mut from, self.features)?;
            if from.0.is_empty() { Ok(model) } else { Err(damaged("continues after its end")) }
        };
        self.read.get_or_init(read).as_ref().map_err(Clone::clone)
    }
}

impl PartialEq for Deferred {
    fn eq(&self, other: &Self) -> bool {
        self.bytes == other.bytes
    }
}

impl TrainedModel {
    /// Sums of trees, each with a readable name.
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
        all.extend(self.limit.iter().map(|limit| ("detection limit".to_owned(), &limit.trees)));
        all.extend(self.mismatch.iter().map(|known| ("mistaken columns".to_owned(), &known.trees)));
        all
    }

    fn write(&self, out: &mut Writer, features: usize) {
        let cuts = Cuts::of(self.ensembles().into_iter().map(|(_, trees)| trees), features);
        cuts.write(out);
        cuts.write_trees(out, &self.fault);
        write_calibration(out, &self.calibration);
        for Side { reached, most } in [self.confidence.clearing, self.confidence.accusing] {
            out.f64(reached);
            out.f64(most);
        }
        out.list(self.lines.iter(), |out, (line, trees, calibration)| {
            out.text(line.name());
            cuts.write_trees(out, trees);
            write_calibration(out, calibration);
        });
        cuts.write_trees(out, &self.no_response);
        out.list(self.causes.iter(), |out, (cause, trees)| {
            out.text(cause.name());
            cuts.write_trees(out, trees);
        });
        for Quantiles { low, middle, high, shifts, stretch } in [&self.s, &self.j_over_s] {
            [low, middle, high].into_iter().for_each(|trees| cuts.write_trees(out, trees));
            write_shifts(out, shifts);
            out.f64(*stretch);
        }
        out.list(self.limit.iter(), |out, Limit { trees, shifts }| {
            cuts.write_trees(out, trees);
            write_shifts(out, shifts);
        });
        out.list(self.reference.iter(), write_reference);
        out.list(self.mismatch.iter(), |out, Mismatch { trees, threshold }| {
            cuts.write_trees(out, trees);
            out.f64(*threshold);
        });
    }

    fn read(from: &mut Reader<'_>, features: usize) -> Result<Self> {
        let cuts = Cuts::read(from, features)?;
        let trees = |from: &mut Reader<'_>| cuts.read_trees(from);
        let side = |from: &mut Reader<'_>| -> Result<Side> {
            Ok(Side { reached: from.f64()?, most: from.f64()? })
        };
        let quantiles = |from: &mut Reader<'_>| {
            let [low, middle, high] = [trees(from)?, trees(from)?, trees(from)?];
            let (shifts, stretch) = (read_shifts(from)?, from.f64()?);
            Quantiles { low, middle, high, shifts, stretch }.checked()
        };
        let limit = |from: &mut Reader<'_>| {
            let (trees, shifts) = (trees(from)?, read_shifts(from)?);
            Limit { trees, shifts }.checked()
        };
        let mismatch = |from: &mut Reader<'_>| {
            let (trees, threshold) = (trees(from)?, from.f64()?);
            match threshold.is_finite() {
                true => Ok(Mismatch { trees, threshold }),
                false => Err(damaged("has an infinite threshold of mistaken columns")),
            }
        };
        Ok(Self {
            fault: trees(from)?,
            calibration: read_calibration(from)?,
            confidence: Confidence { clearing: side(from)?, accusing: side(from)? }.checked()?,
            lines: from.list(16, |from| {
                let line = read_line(from)?;
                Ok((line, trees(from)?, read_calibration(from)?))
            })?,
            no_response: trees(from)?,
            causes: from.list(16, |from| Ok((read_cause(from)?, trees(from)?)))?,
            s: quantiles(from)?,
            j_over_s: quantiles(from)?,
            limit: at_most_one(from.list(16, limit)?)?,
            reference: at_most_one(from.list(16, |from| read_reference(from, features))?)?,
            mismatch: at_most_one(from.list(16, mismatch)?)?,
        })
    }
}

pub(super) fn read_line(from: &mut Reader<'_>) -> Result<Line> {
    let name = from.text()?;
    let known = Line::WEIGHED.into_iter().find(|(line, _)| line.name() == name);
    known.map(|(line, _)| line).ok_or_else(|| damaged("names an unknown line of evidence"))
}

pub(super) fn read_cause(from: &mut Reader<'_>) -> Result<Cause> {
    let name = from.text()?;
    let known = Cause::ALL.into_iter().find(|cause| cause.name() == name);
    let cause = known.ok_or_else(|| damaged("names an unknown cause"))?;
    if cause.is_fault() {
        return Err(damaged("has a fault among the other causes"));
    }
    Ok(cause)
}

fn at_most_one<T>(mut all: Vec<T>) -> Result<Option<T>> {
    let last = all.pop();
    if all.is_empty() { Ok(last) } else { Err(damaged("has a part twice")) }
}

fn write_shifts(out: &mut Writer, shifts: &[(f64, f64)]) {
    out.list(shifts.iter(), |out, (width, shift)| {
        out.f64(*width);
        out.f64(*shift);
    });
}

pub(super) fn read_shifts(from: &mut Reader<'_>) -> Result<Vec<(f64, f64)>> {
    from.list(16, |from| Ok((from.f64()?, from.f64()?)))
}

fn write_reference(out: &mut Writer, reference: &Reference) {
    out.list(reference.spreads.iter(), |out, Spread { feature, missing, quantiles }| {
        out.u16(*feature);
        out.f32(*missing);
        quantiles.iter().for_each(|quantile| out.f32(*quantile));
    });
    out.list(reference.whitening.iter(), |out, weight| out.f32(*weight));
    out.f64(reference.threshold);
}

fn read_reference(from: &mut Reader<'_>, features: usize) -> Result<Reference> {
    let spreads = from.list(4 * QUANTILES, |from| {
        let (feature, missing) = (from.u16()?, from.f32()?);
        if usize::from(feature) >= features {
            return Err(damaged("describes loops by a feature without a name"));
        }
        let quantiles = (0..QUANTILES).map(|_| from.f32()).collect::<Result<_>>()?;
        Ok(Spread { feature, missing, quantiles })
    })?;
    let whitening = from.list(4, Reader::f32)?;
    Reference { spreads, whitening, threshold: from.f64()? }.checked()
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

pub(super) fn read_calibration(from: &mut Reader<'_>) -> Result<Calibration> {
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
    use crate::fusion::Node;
    use crate::fusion::reference::level;
    use proptest::prelude::*;

    fn stump(feature: u16, left: f32, right: f32) -> Ensemble {
        let split =
            Node::Split { feature, threshold: 0.0, missing_right: feature.is_multiple_of(2) };
        Ensemble::new(0.25, &[vec![split, Node::Leaf(left), Node::Leaf(right)]]).unwrap()
    }

    /// Two features that do not go together, whose log-odds of place are their values.
    fn reference() -> Reference {
        let quantiles: Vec<f32> = (0..QUANTILES).map(|k| level(k) as f32).collect();
        let spread = |feature| Spread { feature, missing: 0.125, quantiles: quantiles.clone() };
        Reference {
            spreads: vec![spread(0), spread(1)],
            whitening: vec![1.0, 0.0, 1.0],
            threshold: 2.0,
        }
    }

    fn model(shift: f32) -> TrainedModel {
        let quantiles = |middle: f32| Quantiles {
            low: stump(0, middle - 0.5 - shift, middle - 0.5),
            middle: stump(0, middle - shift, middle),
            high: stump(0, middle + 0.5 - shift, middle + 0.5),
            shifts: vec![(1.0, 0.0), (f64::INFINITY, 0.125)],
            stretch: 1.0,
        };
        let others = Cause::ALL.into_iter().filter(|cause| !cause.is_fault());
        TrainedModel {
            fault: stump(0, -2.0, 2.0),
            calibration: Calibration::Isotonic(vec![(-2.0, 0.1), (2.0, 0.9)]),
            confidence: Confidence { clearing: Side::reaching(5.0), ..Confidence::IDENTITY },
            lines: vec![(Line::Model, stump(1, -0.5, 0.5), Calibration::IDENTITY)],
            no_response: stump(1, -1.0, 3.0),
            causes: others.enumerate().map(|(k, c)| (c, stump(1, k as f32, 0.0))).collect(),
            s: quantiles(-0.5),
            j_over_s: quantiles(0.5),
            limit: Some(Limit { trees: stump(0, 2.0, -1.0), shifts: vec![(1.0, 0.5)] }),
            reference: Some(reference()),
            mismatch: Some(Mismatch { trees: stump(1, -3.0, 3.0), threshold: 1.0 }),
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
            decision: Decision { accuse: 0.9, clear: 0.1 },
            full: model(0.0),
            op_only: Deferred::new(
                &TrainedModel {
                    calibration: Calibration::IDENTITY,
                    limit: None,
                    mismatch: None,
                    ..model(0.25)
                },
                2,
            ),
        }
    }

    /// Both models of a file.
    fn whole(bytes: &[u8]) -> Result<Bundle> {
        let bundle = Bundle::from_bytes(bytes)?;
        bundle.op_only.get()?;
        Ok(bundle)
    }

    #[test]
    fn a_file_gives_back_what_was_written() {
        let bytes = bundle().to_bytes();
        assert_eq!(whole(&bytes).unwrap(), bundle());
    }

    #[test]
    fn every_shortened_or_lengthened_file_is_refused() {
        let bytes = bundle().to_bytes();
        for end in 0..bytes.len() {
            assert!(whole(&bytes[..end]).is_err(), "{end} bytes are enough");
        }
        let longer = [&bytes[..], &[0]].concat();
        assert!(whole(&longer).is_err());
    }

    #[test]
    fn other_features_are_named() {
        let said = |names: &[&str]| bundle().check(names.iter().copied()).unwrap_err().to_string();
        assert!(bundle().check(["first", "second"]).is_ok());
        assert!(said(&["first", "other"]).contains("feature 1 is other, but was second"));
        assert!(said(&["first"]).contains("feature second is missing"));
        // What is newer than the model is not looked at.
        assert!(bundle().check(["first", "second", "third"]).is_ok());
    }

    proptest! {
        #[test]
        fn garbage_is_no_model(garbage in proptest::collection::vec(any::<u8>(), 0..400)) {
            prop_assert!(whole(&garbage).is_err());
            let mut headed = MAGIC.to_vec();
            headed.extend(VERSION.to_le_bytes());
            headed.extend(garbage);
            prop_assert!(whole(&headed).is_err());
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
            if let Ok(read) = whole(&bytes)
                && let Ok(weighed) = read.weigh(&values, 10.0, false)
            {
                prop_assert!((0.0..=1.0).contains(&weighed.probability));
                prop_assert!(weighed.distance >= 0.0 && weighed.mismatch >= 0.0);
            }
        }
    }
}
