//! Counts the repairs.

use super::repair::{GridRepair, RepairKind};
use super::track::{Resampled, Run, State};
use super::{LEAST_KNOWN_VP, LONGEST_BRIDGE};
use crate::recording::{Channel, Recording};
use std::collections::BTreeMap;

/// Counts the repairs, over all runs.
#[derive(Default)]
pub(super) struct Log {
    counts: BTreeMap<(RepairKind, &'static str), (usize, f64)>,
}

impl Log {
    fn add(&mut self, kind: RepairKind, signal: &'static str, count: usize, first_s: f64) {
        if count > 0 {
            self.counts.entry((kind, signal)).or_insert((0, first_s)).0 += count;
        }
    }

    pub(super) fn gap(&mut self, signal: &'static str, after: f64, count: usize) {
        self.add(RepairKind::Gap, signal, count, after);
    }

    pub(super) fn signal(
        &mut self,
        signal: &'static str,
        resampled: Option<&Resampled>,
        run: &Run,
        step: f64,
    ) {
        let Some(resampled) = resampled else { return };
        for (kind, state) in [
            (RepairKind::Irregular, State::Between),
            (RepairKind::Bridged, State::Bridged),
            (RepairKind::Gap, State::Unknown),
        ] {
            let mut places = (0..run.points).filter(|&k| resampled.state[k] == state);
            if let Some(first) = places.next() {
                let first_s = run.from + first as f64 * step;
                self.add(kind, signal, 1 + places.count(), first_s);
            }
        }
    }

    pub(super) fn not_closed(&mut self, closed: &[bool], run: &Run, step: f64) {
        let mut places = (0..closed.len()).filter(|&k| !closed[k]);
        if let Some(first) = places.next() {
            let first_s = run.from + first as f64 * step;
            self.add(RepairKind::NotAutomatic, "time", 1 + places.count(), first_s);
        }
    }

    pub(super) fn repairs(self, recording: &Recording) -> Vec<GridRepair> {
        let few = |signal| {
            let channel = match signal {
                "PV" => recording.pv.as_ref(),
                "OP" => Some(&recording.op),
                _ => None,
            };
            match channel.map(Channel::usable_share) {
                Some(share) if share < 0.5 => {
                    format!("; only {:.0} % of its samples are usable", 100.0 * share)
                }
                _ => String::new(),
            }
        };
        let repair = |((kind, signal), (count, first_s)): ((RepairKind, &'static str), _)| {
            let done = match kind {
                RepairKind::Irregular if signal == "OP" => {
                    "points of the grid between samples keep the value of the last sample".to_owned()
                }
                RepairKind::Irregular => {
                    "points of the grid between samples are interpolated, or held if stored on change"
                        .to_owned()
                }
                RepairKind::Bridged => {
                    format!("runs of up to {LONGEST_BRIDGE} missing samples were bridged")
                }
                RepairKind::Gap if signal == "VP" => format!(
                    "VP is left out of segments in which less than {:.0} % of VP is known",
                    100.0 * LEAST_KNOWN_VP
                ),
                RepairKind::Gap => format!("the recording is cut at each gap{}", few(signal)),
                _ => "the recording is cut where the controller was not in command".to_owned(),
            };
            GridRepair { kind, signal, count, first_s, done }
        };
        self.counts.into_iter().map(repair).collect()
    }
}
