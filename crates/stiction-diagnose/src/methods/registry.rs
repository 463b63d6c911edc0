//! All detectors, by name.

use super::MethodId;
use super::detector::Detector;
use super::subject::Subject;
#[cfg(feature = "figure")]
use crate::drawing::{Context, Scene};
use crate::error::{Error, Result};
use crate::finding::{Finding, LookedAt, Method};
use std::fmt;
use std::str::FromStr;
#[cfg(feature = "figure")]
use stiction_figure::figure::Figure;

/// Declares the methods of the registry, a line each: its name here, its folder, whose `figure.rs` draws its
/// evidence, and the detector with its default parameters.
macro_rules! methods {
    ($($id:ident of $folder:ident: $detector:expr,)*) => {
        /// The methods of the registry, in the order of reports.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub enum MethodId {
            $(#[doc = concat!("That of [`", stringify!($folder), "`]: `", stringify!($detector), "`.")] $id,)*
        }

        impl MethodId {
            /// All of them, in the order of reports.
            pub const ALL: &'static [Self] = &[$(Self::$id),*];

            /// The method with its default parameters.
            pub fn detector(self) -> Box<dyn Detector> {
                match self {
                    $(Self::$id => {
                        use $folder::*;
                        Box::new($detector)
                    })*
                }
            }

            /// The figure of the method's evidence; `None` if the data are too few.
            #[cfg(feature = "figure")]
            fn draw(
                self,
                scene: &$crate::drawing::Scene<'_>,
                looked_at: &$crate::finding::LookedAt,
            ) -> Option<stiction_figure::Figure> {
                match self {
                    $(Self::$id => $folder::figure::draw(scene, looked_at.get()?),)*
                }
            }
        }
    };
}
pub(super) use methods;

impl MethodId {
    /// The entry of a method; `None` if it is not in the registry.
    pub fn of(method: &Method) -> Option<Self> {
        Self::ALL.iter().copied().find(|id| id.method() == method)
    }

    /// Description.
    pub fn method(self) -> &'static Method {
        self.detector().method()
    }

    /// Name in commands and files, such as `horch`.
    pub fn name(self) -> &'static str {
        self.method().name
    }
}

impl fmt::Display for MethodId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// By its name, in any case. The error for an unknown name lists the known ones.
impl FromStr for MethodId {
    type Err = Error;

    fn from_str(name: &str) -> Result<Self> {
        let of_name = |id: &&Self| id.name().eq_ignore_ascii_case(name.trim());
        Self::ALL.iter().find(of_name).copied().ok_or_else(|| {
            let known: Vec<&str> = Self::ALL.iter().map(|id| id.name()).collect();
            Error::UnknownName {
                family: "detector",
                name: name.to_owned(),
                known: known.join(", "),
            }
        })
    }
}

/// All detectors with their default parameters, in the order of reports.
pub fn all() -> Vec<Box<dyn Detector>> {
    MethodId::ALL.iter().map(|id| id.detector()).collect()
}

/// The detector called `name`, in any case.
///
/// # Errors
/// If no detector has this name. The message lists the known names.
pub fn by_name(name: &str) -> Result<Box<dyn Detector>> {
    name.parse().map(MethodId::detector)
}

/// The result behind a finding for `subject`. If it was not kept, the method of the registry runs again. The result is
/// `None` if the method cannot run, or if the finding is from a method with different parameters.
pub fn looked_at(finding: &Finding, subject: &Subject<'_>) -> Option<LookedAt> {
    if finding.looked_at.is_some() {
        return finding.looked_at.clone();
    }
    let detector = MethodId::of(finding.method)?.detector();
    let same = detector.parameters() == finding.parameters;
    same.then(|| detector.judge(subject).looked_at).flatten()
}

/// The figure of a finding's evidence in `subject`; `None` if the method abstains, has too little to draw, or
/// values too large to draw.
#[cfg(feature = "figure")]
pub fn figure(finding: &Finding, subject: &Subject<'_>, context: &Context<'_>) -> Option<Figure> {
    let (segment, period, group) = (subject.segment, subject.period, finding.method.name);
    let scene = Scene { segment, period, context, group };
    let looked_at = looked_at(finding, subject)?;
    let figure = MethodId::of(finding.method)?.draw(&scene, &looked_at);
    figure.filter(|figure| figure.check().is_ok())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::finding::{Decides, Decision};
    use crate::recording::{LoopType, Segment};

    #[test]
    fn every_method_is_described_and_found_by_its_name() {
        let detectors = all();
        for (i, detector) in detectors.iter().enumerate() {
            let method = detector.method();
            assert!(detectors[..i].iter().all(|other| other.method().name != method.name));
            assert_eq!(MethodId::of(method), Some(MethodId::ALL[i]));
            for text in [method.title, method.source, method.statistic, method.rule] {
                assert!(!text.trim().is_empty() && !text.contains("  "), "{}: {text}", method.name);
            }
            let numbers = method.rule.chars().any(|c| c.is_ascii_digit());
            assert!(
                numbers || method.rule.contains("threshold"),
                "{}: {}",
                method.name,
                method.rule
            );
            let parameters = detector.parameters();
            assert!(!parameters.is_empty(), "{}", method.name);
            assert!(parameters.iter().all(|p| !p.name.is_empty() && p.value.is_finite()));
            assert_eq!(by_name(&method.name.to_uppercase()).unwrap().method(), method);
        }
        let Err(error) = by_name("nonesuch") else { panic!() };
        assert!(error.to_string().contains(detectors[0].method().name));
    }

    /// Segments no one should record.
    fn zoo() -> Vec<Segment> {
        let mut zoo = vec![];
        let wave = |k: usize| (0.3 * k as f64).sin();
        let mut add = |op: Vec<f64>, pv: Option<Vec<f64>>, sp: Option<Vec<f64>>| {
            let vp = pv.clone();
            zoo.push(Segment { from: 0.0, sample_time: 1.0, op, pv, sp, vp, bridged: 0 });
        };
        for n in [0, 1, 2, 3, 4, 5, 17, 64, 300, 1000] {
            let series = |f: &dyn Fn(usize) -> f64| -> Vec<f64> { (0..n).map(f).collect() };
            let waves = series(&wave);
            let other = series(&|k| (0.3 * k as f64 + 1.0).sin());
            add(waves.clone(), None, None);
            add(waves.clone(), Some(waves.clone()), None);
            add(waves.clone(), Some(other.clone()), Some(series(&|_| 1.0)));
            add(series(&|_| 50.0), Some(series(&|_| 0.1)), None);
            add(waves.clone(), Some(series(&|_| 0.1)), None);
            add(series(&|_| 0.1), Some(waves.clone()), None);
            add(series(&|k| k as f64), Some(series(&|k| -(k as f64))), None);
            add(series(&|k| (k % 2) as f64), Some(series(&|k| (k % 3) as f64)), None);
            add(series(&|k| f64::from(k == 7)), Some(series(&|k| f64::from(k == 9))), None);
            for scale in [1e300, f64::MAX, 1e-300, f64::MIN_POSITIVE, 1e160] {
                let scaled = |x: &[f64]| -> Vec<f64> { x.iter().map(|v| v * scale).collect() };
                add(scaled(&waves), Some(scaled(&other)), None);
                add(waves.clone(), Some(scaled(&other)), Some(scaled(&waves)));
                add(scaled(&waves), Some(other.clone()), None);
            }
        }
        zoo
    }

    #[test]
    fn nothing_makes_a_detector_panic_or_answer_in_another_kind() {
        let periods = [None, Some(0.0), Some(4.0), Some(21.0), Some(1e9), Some(f64::NAN)];
        let types = [LoopType::Unknown, LoopType::Level];
        for segment in zoo() {
            for (period, loop_type) in
                periods.into_iter().flat_map(|period| types.map(|loop_type| (period, loop_type)))
            {
                let subject = Subject::new(&segment, loop_type, period);
                for detector in all() {
                    let finding = detector.judge(&subject);
                    assert_eq!(finding.method, detector.method());
                    assert!(!finding.reason.is_empty());
                    let kind = match detector.method().decides {
                        Decides::Stiction => {
                            !matches!(finding.decision, Decision::Nonlinear | Decision::Linear)
                        }
                        Decides::Nonlinearity => {
                            !matches!(finding.decision, Decision::Sticks | Decision::DoesNotStick)
                        }
                    };
                    assert!(kind, "{}", detector.method().name);
                    let abstains = finding.decision == Decision::Abstains;
                    assert_eq!(abstains, finding.statistic.is_none(), "{}", detector.method().name);
                    // A method without a known threshold tells its statistic and decides nothing.
                    let open = abstains || finding.decision == Decision::Undecided;
                    assert!(open || finding.threshold.is_some(), "{}", detector.method().name);
                }
            }
        }
    }
}
