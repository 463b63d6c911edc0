//! Raw signals in a small net, for signs that shapes and fits do not measure.

mod input;
mod net;

pub use input::{CHANNELS, Input, LENGTH, SCALARS};
pub use net::{Net, OUTPUTS, shipped};

use super::{Feature, Line, Prepared};
use crate::cause::Cause;
use crate::identify::information::Information;

/// A feature of this line.
const fn feature(name: &'static str, monotone: i8, meaning: &'static str) -> Feature {
    Feature { name, meaning, line: Line::Signals, monotone }
}

/// The features of this line, in the order of [`values`].
pub const FEATURES: [Feature; 8] = [
    feature("net_fault", 1, "log-odds of a fault by the raw signals"),
    feature("net_s", 0, "S by the raw signals if the valve sticks, share of the OP's span, ln"),
    feature("net_j", 0, "J over S by the raw signals if the valve sticks"),
    feature("net_sticks", 0, "ln of the probability that the valve sticks, by the raw signals"),
    feature(
        "net_no_response",
        0,
        "ln of the probability that the valve does not respond, by the raw signals",
    ),
    feature(
        "net_dead_zone",
        0,
        "ln of the probability of a dead zone elsewhere, by the raw signals",
    ),
    feature(
        "net_wave",
        0,
        "ln of the probability of an external wave with corners, by the raw signals",
    ),
    feature("net_normal", 0, "ln of the probability of normal operation, by the raw signals"),
];

/// The causes whose probabilities are features.
const CAUSES: [Cause; 5] = [
    Cause::StickingValve,
    Cause::NoResponse,
    Cause::DeadZoneElsewhere,
    Cause::ExternalWave,
    Cause::NormalOperation,
];

/// The input of the net for a window, if there is enough data.
pub fn net_input(prepared: &Prepared<'_>, information: Option<&Information>) -> Option<Input> {
    information.and_then(|told| Input::of(prepared, &told.added_stem))
}

/// One value for each of [`FEATURES`]; NaN without a net, or with too few data.
pub(super) fn values_of(
    prepared: &Prepared<'_>,
    information: Option<&Information>,
) -> [f64; FEATURES.len()] {
    let said = shipped().and_then(|net| Some(net.outputs(&net_input(prepared, information)?)));
    said.map_or([f64::NAN; FEATURES.len()], |said| values(&said))
}

/// The features from the output of a net.
pub fn values(said: &[f32; OUTPUTS]) -> [f64; FEATURES.len()] {
    let said = said.map(f64::from);
    let margins = &said[3..];
    let most = margins.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let all = most + margins.iter().map(|margin| (margin - most).exp()).sum::<f64>().ln();
    let mut out = [said[0], said[1], said[2], 0.0, 0.0, 0.0, 0.0, 0.0];
    for (cause, margin) in Cause::ALL.iter().zip(margins) {
        if let Some(place) = CAUSES.iter().position(|known| known == cause) {
            out[3 + place] = (margin - all).max(-20.0);
        }
    }
    out
}
