//! The model of valves: from the combined evidence of a valve's windows to one probability and S.

use super::bundle::read_shifts;
use super::bytes::{Reader, damaged};
use super::confidence::{Confidence, Side};
use super::decision::Decision;
use super::pool::{Pool, SUMMARY};
use super::quantiles::Quantiles;
use super::sigmoid;
use super::trees::{Ensemble, MOST_FEATURES, Node};
use crate::error::{Error, Result};
use crate::estimate::Estimate;
use crate::evidence::features;
use std::sync::OnceLock;

/// The first bytes of its file.
const MAGIC: [u8; 8] = *b"VALVES 1";

/// Gives the probability that a valve is at fault, and its S, from a [`Pool`] of its windows, for one window or
/// thousands.
///
/// The model of a window errs in the next window of the same valve as in the last. So repeated windows are worth less
/// than independent windows. How much they are worth depends on what agrees: the log-odds, S, the features. Boosted
/// trees (G. Ke et al., "LightGBM", NeurIPS 30, 2017; the library was used, the paper not read) were trained on the
/// pools of simulated valves of 1 to 60 windows, `addons/stiction-train/valves/train.py`. More suspicion in a window
/// never lowers the probability.
///
/// It needs OP and PV. `docs/accuracy.md` compares its verdict with the verdict from single windows, on kinds of loops
/// that were not in its training.
#[derive(Debug, Clone, PartialEq)]
pub struct Valves {
    /// The name of its training.
    pub name: String,
    /// The places of its features among all.
    pub features: Vec<usize>,
    /// The thresholds to accuse or clear a valve.
    pub decision: Decision,
    /// The log-odds of a fault, by the row of a pool.
    fault: Ensemble,
    /// From their probability to the reported one.
    confidence: Confidence,
    /// Quantiles of `ln S`, given that the valve sticks, above its weighted mean over the windows.
    s: Quantiles,
}

impl Valves {
    /// The model in the library, read once.
    ///
    /// # Errors
    /// If the model was trained on features that no longer exist.
    pub fn shipped() -> Result<&'static Self> {
        static SHIPPED: OnceLock<Result<Valves>> = OnceLock::new();
        let read = || Self::from_bytes(include_bytes!("../../model/valves.bin"));
        SHIPPED.get_or_init(read).as_ref().map_err(Clone::clone)
    }

    /// Reads its file, as `train.py` writes it: name, names of features, thresholds, confidence, and trees in
    /// preorder. A leaf has the feature 0x7fff; the highest bit of a feature sends missing values right.
    ///
    /// # Errors
    /// If the file is not a model, ends early, continues after its end, or has invalid trees or unknown features.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self> {
        let mut from =
            Reader(bytes.strip_prefix(&MAGIC).ok_or_else(|| damaged("is no model of valves"))?);
        let name = from.text()?;
        let known: Vec<&str> = features().map(|feature| feature.name).collect();
        let place = |name: String| {
            let place = known.iter().position(|known| *known == name);
            place.ok_or_else(|| {
                Error::Bundle(format!(
                    "the model of valves needs the feature {name}: train it again"
                ))
            })
        };
        let features: Vec<usize> =
            from.list(4, Reader::text)?.into_iter().map(place).collect::<Result<_>>()?;
        let columns = SUMMARY.len() + features.len();
        let trees = |from: &mut Reader<'_>| -> Result<Ensemble> {
            let base = from.f64()?;
            let trees = from.list(4, |from| from.list(6, node))?;
            named(Ensemble::new(base, &trees)?, columns)
        };
        let side = |from: &mut Reader<'_>| -> Result<Side> {
            Ok(Side { reached: from.f64()?, most: from.f64()? })
        };
        let decision = Decision { accuse: from.f64()?, clear: from.f64()? }.checked()?;
        let confidence =
            Confidence { clearing: side(&mut from)?, accusing: side(&mut from)? }.checked()?;
        let fault = trees(&mut from)?;
        let [low, middle, high] = [trees(&mut from)?, trees(&mut from)?, trees(&mut from)?];
        let (shifts, stretch) = (read_shifts(&mut from)?, from.f64()?);
        let s = Quantiles { low, middle, high, shifts, stretch }.checked()?;
        match from.0.is_empty() {
            true => Ok(Self { name, features, decision, fault, confidence, s }),
            false => Err(damaged("continues after its end")),
        }
    }

    /// What the windows of a pool say together.
    pub fn weigh(&self, pool: &Pool) -> Together {
        let row = pool.row();
        Together {
            probability: self.confidence.reported(sigmoid(self.fault.margin(&row))),
            s: self.s.estimate(&row).map(|above| (pool.mean_ln_s() + above).exp()),
        }
    }
}

/// What the windows of a valve say together.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Together {
    /// The probability of a fault of the valve: that it sticks, or does not respond.
    pub probability: f64,
    /// S if the valve sticks, percent of span, and its 90 % interval.
    pub s: Estimate,
}

fn node(from: &mut Reader<'_>) -> Result<Node> {
    let (feature, value) = (from.u16()?, from.f32()?);
    Ok(match usize::from(feature) {
        MOST_FEATURES => Node::Leaf(value),
        _ => Node::Split {
            feature: feature & 0x7fff,
            threshold: value,
            missing_right: feature & 0x8000 != 0,
        },
    })
}

/// Trees that split by features that have names.
fn named(trees: Ensemble, features: usize) -> Result<Ensemble> {
    match trees.features() <= features {
        true => Ok(trees),
        false => Err(damaged("splits by a feature without a name")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BYTES: &[u8] = include_bytes!("../../model/valves.bin");

    #[test]
    fn the_shipped_model_is_of_todays_features() {
        let valves = Valves::shipped().unwrap();
        assert!(valves.features.windows(2).all(|two| two[0] < two[1]));
        assert!(valves.decision.checked().is_ok() && BYTES.len() < 600_000);
    }

    #[test]
    fn a_damaged_file_is_an_error() {
        assert!(Valves::from_bytes(b"").is_err());
        for end in (0..BYTES.len()).step_by(997) {
            assert!(Valves::from_bytes(&BYTES[..end]).is_err(), "{end}");
        }
        assert!(Valves::from_bytes(&[BYTES, b"x"].concat()).is_err());
        let other = String::from_utf8_lossy(&BYTES[..400]).find("net_").map_or(60, |at| at);
        let mut renamed = BYTES.to_vec();
        renamed[other] ^= 1;
        assert!(Valves::from_bytes(&renamed).is_err());
    }
}
