//! Evidence of a window about its valve, as numbers that do not depend on units, offsets, directions or the time
//! scale.
//!
//! [`Prepared`] resamples a window to one resolution per period and removes its units. Then each line of evidence
//! measures its features. Each line is one file. A feature that cannot be measured is NaN, never a code.
//!
//! Most features are indices of published detectors, which are in [`crate::methods`]; here they are numbers without
//! thresholds. Our own are named after the quantity they measure.

pub mod circumstances;
pub mod op_shape;
pub mod patterns;
mod prepared;
pub mod pv_shape;
mod regression;
pub mod response;
mod turns;
mod waves;
mod windows;

pub use prepared::{Dense, Prepared, Trace, high_passed};
pub use windows::{windows, windows_of_all};

pub mod information;
pub mod model;
pub mod raw;

use crate::finding::Abstention;
use crate::identify::hammerstein::{self, HammersteinOptions, ModelEvidence};
use crate::identify::information::Information;
use crate::recording::Segment;
use stiction_model::named;

/// A number of the evidence.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Feature {
    /// Name, such as `arx_gain`.
    pub name: &'static str,
    /// Meaning, a short sentence.
    pub meaning: &'static str,
    /// Line of evidence.
    pub line: Line,
    /// 1 if larger values can only be evidence for stiction, -1 if only against, 0 if either.
    pub monotone: i8,
}

named! {
    /// The independent lines of evidence.
    #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
    pub enum Line {
        /// How much better a sticking valve explains the PV than one that follows.
        Model = "valve models",
        /// Samples in which OP and PV move differently.
        Patterns = "patterns",
        /// The shape of the OP's wave; needs no PV.
        OpShape = "wave shapes",
        /// The shape of the PV's or error's wave.
        PvShape = "shape of the PV",
        /// Whether the PV responds to the OP at all.
        Response = "response",
        /// Circumstances of the loop: set point, limits, resolution, record length.
        Circumstances = "circumstances",
        /// The raw signals, as a neural net uses them.
        Signals = "raw signals",
    }
}

impl Line {
    /// The lines that are also weighed alone, with their parts: the model fits; motion of one signal while the other
    /// rests, and response of the PV; waveforms.
    pub const WEIGHED: [(Self, &'static [Self]); 3] = [
        (Self::Model, &[Self::Model]),
        (Self::Patterns, &[Self::Patterns, Self::Response]),
        (Self::OpShape, &[Self::OpShape, Self::PvShape]),
    ];
}

/// The smallest relevant gain: half a percent of the remaining prediction error.
pub const LEAST_GAIN: f64 = 0.005;

/// A table of features, whether they need the OP only, and their function.
struct Part {
    features: &'static [Feature],
    op_only: bool,
    measure: fn(&Prepared<'_>, &mut Vec<f64>),
}

/// The parts that are measured one by one, in the order of [`Evidence::values`]. [`model`] and [`information`] follow,
/// whose fits are kept, and [`raw`], which uses these fits.
const PARTS: [Part; 6] = [
    Part { features: &patterns::FEATURES, op_only: false, measure: patterns::measure },
    Part { features: &op_shape::FEATURES, op_only: true, measure: op_shape::measure },
    Part { features: &pv_shape::FEATURES, op_only: false, measure: pv_shape::measure },
    Part { features: &response::FEATURES, op_only: false, measure: response::measure },
    Part { features: &circumstances::OF_OP, op_only: true, measure: circumstances::measure_op },
    Part {
        features: &circumstances::OF_LOOP,
        op_only: false,
        measure: circumstances::measure_loop,
    },
];

/// All features, in the order of [`Evidence::values`].
pub fn features() -> impl Iterator<Item = &'static Feature> {
    PARTS
        .iter()
        .flat_map(|part| part.features)
        .chain(model::FEATURES)
        .chain(model::DENSE)
        .chain(&information::FEATURES)
        .chain(&raw::FEATURES)
}

/// The indices, in [`features`], of those that need the OP only. Recordings without a PV have only these. With a PV,
/// the dominant period comes from OP and error together, so the values may differ from the values of the OP alone.
pub fn op_only() -> impl Iterator<Item = usize> {
    let needs = PARTS.iter().flat_map(|part| part.features.iter().map(|_| part.op_only));
    needs.enumerate().filter(|(_, op_only)| *op_only).map(|(i, _)| i)
}

/// Dominant period of a segment, samples, as [`Prepared`] finds it; `None` without an oscillation.
pub fn recorded_period(segment: &Segment) -> Option<f64> {
    let prepared = Prepared::of(segment).ok()?;
    Some(prepared.period * prepared.factor as f64)
}

/// The evidence of a window.
#[derive(Debug, Clone, PartialEq)]
pub struct Evidence {
    /// One value for each of [`features`]; NaN where the feature cannot be measured.
    pub values: Vec<f64>,
    /// Span of the OP without its slow part, percent of span: the scale of S.
    pub op_span: f64,
    /// Dominant period, s.
    pub period_s: f64,
    /// Sticking valves before a linear process, fitted to OP and PV; `None` without a PV that moves, or with too
    /// little to fit.
    pub model: Option<ModelEvidence>,
    /// The models at the [dense](Prepared::dense) resolution, where one exists.
    pub dense: Option<ModelEvidence>,
    /// The information of the window about S; `None` if too little can be predicted.
    pub information: Option<Information>,
}

impl Evidence {
    /// The evidence in a segment, or a window of one.
    ///
    /// # Errors
    /// If there is nothing to measure, for example if the OP never moves.
    pub fn of(segment: &Segment) -> Result<Self, Abstention> {
        Ok(Self::of_prepared(&Prepared::of(segment)?))
    }

    /// The evidence in a prepared window.
    pub fn of_prepared(prepared: &Prepared<'_>) -> Self {
        let mut values = Vec::with_capacity(features().count());
        for part in &PARTS {
            (part.measure)(prepared, &mut values);
        }
        let ((model, dense), (information, signals)) = crate::parallel::join(
            || {
                let model = prepared.pv.as_ref().and_then(|pv| {
                    let (op, period) = (&prepared.op.values, prepared.period);
                    hammerstein::weigh(op, &pv.values, period, &HammersteinOptions::default()).ok()
                });
                (model, prepared.dense.as_ref().and_then(model::weigh_dense))
            },
            || {
                let information = prepared.segment.pv.as_deref().and_then(|pv| {
                    let period = prepared.period * prepared.factor as f64;
                    information::of(&prepared.segment.op, pv, period)
                });
                let signals = raw::values_of(prepared, information.as_ref());
                (information, signals)
            },
        );
        model::measure(model.as_ref(), &mut values);
        model::measure_dense(dense.as_ref().or(model.as_ref()), &mut values);
        information::measure(information.as_ref(), prepared.op_span(), &mut values);
        values.extend(signals);
        // A ratio to zero is not a number.
        values.iter_mut().filter(|v| !v.is_finite()).for_each(|v| *v = f64::NAN);
        Self {
            values,
            op_span: prepared.op_span(),
            period_s: prepared.period_s(),
            model,
            dense,
            information,
        }
    }

    /// Whether a sticking valve predicts the PV better than one that follows by a relevant share, in any of the
    /// fits.
    pub fn finds_gain(&self) -> bool {
        let fits = [&self.model, &self.dense].into_iter().flatten();
        fits.into_iter().any(|fits| fits.best().gain >= LEAST_GAIN)
    }

    /// The value of the feature of that name; `None` if there is none of that name.
    pub fn get(&self, name: &str) -> Option<f64> {
        features().zip(&self.values).find(|(feature, _)| feature.name == name).map(|(_, v)| *v)
    }

    /// The values that need the OP only.
    pub fn op_only(&self) -> Vec<f64> {
        op_only().map(|i| self.values[i]).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Bands;
    use crate::closed_loop::{ClosedLoop, Controller, Process, Signal};
    use crate::valve::{Assembly, Model};
    use std::collections::HashSet;
    use std::f64::consts::{PI, TAU};

    const N: usize = 1000;

    fn segment(op: Vec<f64>, pv: Option<Vec<f64>>, sp: Option<Vec<f64>>) -> Segment {
        Segment { from: 0.0, sample_time: 1.0, op, pv, sp, vp: None, bridged: 0 }
    }

    /// A loop with noise, its load drifting; its valve sticks by `s` percent, half of it slip jump.
    fn simulated(s: f64, seed: u64) -> Segment {
        let valve = Model::TwoPhase.build(Bands::from_s_j(s, 0.5 * s).unwrap()).unwrap();
        let mut system = ClosedLoop::new(
            Controller::pi(0.4, 12.0).unwrap(),
            Assembly::new(valve),
            Process::first_order(1.2, 8.0, 3.0).unwrap(),
        );
        system.sample_time = 1.0;
        system.samples = N + 300;
        (system.op_rest, system.pv_rest) = (45.0, 30.0);
        system.set_point = 30.0.into();
        system.load =
            vec![Signal::step(0.0, 4.0, 1.0), Signal::RandomWalk { sd_per_sqrt_s: 0.05, seed }];
        system.measurement = vec![Signal::Noise { sd: 0.1, tau_s: 0.0, seed: seed + 1 }];
        let run = system.run().unwrap();
        let tail = |x: &[f64]| x[300..].to_vec();
        segment(tail(&run.op), Some(tail(&run.pv)), Some(tail(&run.sp)))
    }

    fn map(x: &[f64], f: impl Fn(f64) -> f64) -> Vec<f64> {
        x.iter().map(|v| f(*v)).collect()
    }

    fn wave(period: f64, phase: f64) -> Vec<f64> {
        (0..N).map(|k| (TAU * k as f64 / period + phase).sin()).collect()
    }

    #[test]
    fn names_are_unique_and_values_as_many() {
        let names: HashSet<&str> = features().map(|f| f.name).collect();
        assert_eq!(names.len(), features().count());
        assert_eq!(Evidence::of(&simulated(4.0, 1)).unwrap().values.len(), names.len());
        let op_shapes = features().filter(|f| f.line == Line::OpShape).count();
        assert_eq!(op_only().count(), op_shapes + circumstances::OF_OP.len());
        for (place, feature) in features().enumerate() {
            assert!(feature.line != Line::OpShape || op_only().any(|i| i == place));
            assert!(!feature.meaning.ends_with('.') && feature.monotone.abs() <= 1);
        }
    }

    #[test]
    fn units_offsets_directions_and_time_do_not_matter() {
        for (s, seed) in [(4.0, 1), (0.0, 2), (8.0, 3)] {
            let original = simulated(s, seed);
            let found = Evidence::of(&original).unwrap();
            let moved = |x: &Option<Vec<f64>>| x.as_ref().map(|x| map(x, |v| 7.0 - 3.0 * v));
            let others = [
                Segment { pv: moved(&original.pv), sp: moved(&original.sp), ..original.clone() },
                Segment { op: map(&original.op, |v| 100.0 - v), ..original.clone() },
                Segment { op: map(&original.op, |v| 0.5 * v + 10.0), ..original.clone() },
                Segment { sample_time: 60.0, from: 5.0, ..original.clone() },
            ];
            for (which, other) in others.iter().enumerate() {
                let other = Evidence::of(other).unwrap();
                for ((feature, a), b) in features().zip(&found.values).zip(&other.values) {
                    // Valves that all but follow solve all but singular equations; nets compute in single precision.
                    let fine = match feature.name.split('_').next() {
                        Some("info") => 1e-5,
                        Some("net") => 1e-3,
                        _ => 1e-9,
                    };
                    let same = a.is_nan() && b.is_nan() || (a - b).abs() <= fine * a.abs().max(1.0);
                    assert!(same, "{} of {s} under {which}: {a} and {b}", feature.name);
                }
            }
            let minutes = Evidence::of(&others[3]).unwrap();
            assert!((minutes.period_s / found.period_s - 60.0).abs() < 1e-9);
            let halved = Evidence::of(&others[2]).unwrap();
            assert!((halved.op_span / found.op_span - 0.5).abs() < 1e-9);
        }
    }

    #[test]
    fn shapes_have_closed_forms() {
        let sine = wave(50.0, 0.3);
        let triangle = map(&sine, |v| v.clamp(-1.0, 1.0).asin() * 2.0 / PI);
        let square = map(&sine, f64::signum);
        let of = |op: &[f64]| Evidence::of(&segment(op.to_vec(), None, None)).unwrap();
        let close = |evidence: &Evidence, name: &str, expected: f64, tolerance: f64| {
            let found = evidence.get(name).unwrap();
            assert!((found - expected).abs() <= tolerance, "{name}: {found}, not {expected}");
        };
        let (of_sine, of_triangle, of_square) = (of(&sine), of(&triangle), of(&square));
        close(&of_sine, "op_kurtosis", -1.5, 0.02);
        close(&of_triangle, "op_kurtosis", -1.2, 0.04);
        close(&of_square, "op_kurtosis", -2.0, 0.04);
        close(&of_sine, "op_chord", 2.0 * (5.0 / 6.0 - 8.0 / (PI * PI)), 0.005);
        close(&of_triangle, "op_chord", 0.0, 0.002);
        close(&of_triangle, "op_triangle", 1.0, 0.03);
        close(&of_sine, "op_triangle", 0.0, 0.02);
        close(&of_square, "op_square", 1.0, 0.02);
        close(&of_sine, "op_square", -1.0, 0.02);
        close(&of_triangle, "op_peaked", 1.0, 0.01);
        close(&of_square, "op_peaked", -1.0, 0.01);
        close(&of_triangle, "op_harmonic_3", (1f64 / 81.0).ln(), 0.1);
        close(&of_square, "op_harmonic_3", (1f64 / 9.0).ln(), 0.1);
        close(&of_triangle, "op_turns", 2.0, 0.2);
        for evidence in [&of_sine, &of_triangle, &of_square] {
            assert!((evidence.period_s - 50.0).abs() < 0.5, "{}", evidence.period_s);
            close(evidence, "op_irreversible_quarter", 0.0, 0.05);
            close(evidence, "op_leg_time_spread", 0.0, 0.03);
            close(evidence, "cycles", 20f64.ln(), 0.01);
            assert!(evidence.get("rho1").unwrap().is_nan());
        }
        // 1 percent of amplitude is a span of 2.
        assert!((of_triangle.op_span - 2.0).abs() < 0.1);
    }

    #[test]
    fn a_linear_pair_is_coherent_and_its_controller_fits() {
        // dOP = -(a de + b e) of a PV a fifth of a period later.
        let pv = wave(40.0, 0.0);
        let mut op = vec![50.0; N];
        for k in 1..N {
            let (before, now) = (30.0 - pv[k - 1], 30.0 - pv[k]);
            op[k] = op[k - 1] + 0.7 * (now - before) + 0.05 * 0.5 * (now + before - 60.0);
        }
        let evidence = Evidence::of(&segment(op, Some(pv), Some(vec![0.0; N]))).unwrap();
        assert!(evidence.get("controller_misfit").unwrap() < -15.0);
        assert!(evidence.get("coherence").unwrap() > 0.999);
        // Amplitudes of 0.7 w sin and 0.05 sin.
        let (p, i) = (0.7 * TAU / 40.0, 0.05);
        let action = evidence.get("controller_action").unwrap();
        assert!((action - p.atan2(i) * 2.0 / PI).abs() < 0.02, "{action}");
    }

    #[test]
    fn a_sticking_valve_differs_from_one_that_follows() {
        let (sticks, follows) = (simulated(6.0, 5), simulated(0.0, 5));
        let (sticks, follows) = (Evidence::of(&sticks).unwrap(), Evidence::of(&follows).unwrap());
        for name in ["rho1", "op_triangle", "slips", "op_before_jump", "innovation_focus"] {
            let (a, b) = (sticks.get(name).unwrap(), follows.get(name).unwrap());
            assert!(a > b, "{name}: {a} and {b}");
        }
        // The OP travels the same way before every slip.
        assert!(sticks.get("slip_travel_spread").unwrap() < 0.1);
        assert!(sticks.get("slip_with_op").unwrap() > 0.9);
    }

    #[test]
    fn whatever_the_data_values_are_finite_or_nan() {
        let base = simulated(4.0, 9);
        let (op, pv, sp) = (base.op.clone(), base.pv.clone().unwrap(), base.sp.clone());
        let spike = |at: usize, n: usize| (0..n).map(|k| f64::from(k == at)).collect::<Vec<_>>();
        let cases = [
            segment(op.clone(), None, None),
            segment(op.clone(), Some(vec![5.0; N]), None),
            segment(op.clone(), Some(vec![5.0; N]), sp.clone()),
            segment(op.clone(), Some(pv.clone()), None),
            segment(op[..20].to_vec(), Some(pv[..20].to_vec()), Some(vec![30.0; 20])),
            segment(op[..16].to_vec(), Some(pv[..16].to_vec()), None),
            segment(spike(500, N), Some(spike(510, N)), None),
            segment(op.clone(), Some(spike(3, N)), None),
            segment(map(&op, f64::round), Some(map(&pv, f64::round)), sp.clone()),
            segment(wave(50.0, 0.0), Some(wave(50.0, 1.0)), None),
            segment(wave(2.0, 0.5), Some(wave(2.0, 1.0)), None),
            segment((0..N).map(|k| k as f64).collect(), Some(pv.clone()), None),
            segment(map(&op, |v| 1e300 * v), Some(map(&pv, |v| 1e-300 * v)), None),
            segment(wave(N as f64, 0.0), Some(wave(10.0, 0.0)), Some(wave(200.0, 0.0))),
        ];
        for (which, case) in cases.iter().enumerate() {
            let evidence = match Evidence::of(case) {
                Ok(evidence) => evidence,
                Err(why) => panic!("{which}: {}", why.0),
            };
            assert_eq!(evidence.values.len(), features().count());
            assert!(evidence.values.iter().all(|v| v.is_finite() || v.is_nan()), "{which}");
            assert!(evidence.op_span > 0.0 && evidence.period_s > 0.0, "{which}");
        }
        let still = Evidence::of(&cases[1]).unwrap();
        assert_eq!(still.get("pv_constant"), Some(1.0));
        assert_eq!(still.get("rest_share"), Some(1.0));
        assert!(still.get("rho1").unwrap().is_nan());
        // One that moves by what rounding makes does not move.
        let rounded = map(&wave(9.0, 0.0), |v| 5.0 + 1e-15 * v);
        assert_eq!(
            Evidence::of(&segment(op.clone(), Some(rounded), None)).unwrap().get("pv_constant"),
            Some(1.0)
        );
        let refused = [
            segment(vec![50.0; N], Some(pv.clone()), None),
            segment(op[..15].to_vec(), None, None),
            segment(map(&op, |v| if v == op[7] { f64::NAN } else { v }), None, None),
            segment(op.clone(), Some(pv[1..].to_vec()), None),
            segment(vec![], None, None),
        ];
        for case in &refused {
            assert!(Evidence::of(case).is_err());
        }
    }

    #[test]
    fn of_the_op_alone_is_what_a_recording_without_pv_gives() {
        let both = simulated(5.0, 4);
        let alone = Evidence::of(&Segment { pv: None, sp: None, ..both.clone() }).unwrap();
        let places: Vec<usize> = op_only().collect();
        for (i, value) in alone.values.iter().enumerate() {
            assert!(places.contains(&i) || value.is_nan(), "{i}");
        }
        assert!(alone.op_only().iter().all(|v| v.is_finite()));
    }
}
