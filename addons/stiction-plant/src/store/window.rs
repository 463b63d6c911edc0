//! The row of a window, that is, of one loop on one day.

use crate::store::table::columns;
use stiction_diagnose::diagnose::change::Seen;
use stiction_diagnose::diagnose::{
    Diagnosis, Estimate, Grade, Observation, VerdictClass, Weighing,
};
use stiction_diagnose::fusion::{self, Pool, Valves};
use stiction_diagnose::recording::fitness::{Class, MeasureId};
use stiction_diagnose::valve_test::TestReading;

columns! {
    /// One window of one loop. Units are as in the columns.
    pub struct WindowRow;
    /// Tag of the loop.
    "loop" [""] name: String;
    /// Area of the plant, from plant.toml.
    "area" [""] area: Option<String>;
    /// Unit of the plant, from plant.toml.
    "unit" [""] unit: Option<String>;
    /// Type of the loop.
    "type" [""] loop_type: String;
    /// Start of the window, since 1970-01-01 UTC: midnight by the clock of the plant.
    "window_start" ["s"] window_start: i64;
    /// Duration of the window: one or more plant days.
    "window_s" ["s"] window_s: i64;
    /// Version of the program that judged the window.
    "engine_version" [""] engine_version: String;
    /// Version of the trained model of the verdict.
    "model_version" [""] model_version: String;
    /// SHA-256 of the settings in plant.toml that affect the verdict.
    "settings_hash" [""] settings_hash: String;
    /// SHA-256 of the window's files (on Spark: rows), by which a scan recognises a finished window.
    "input_fingerprint" [""] input_fingerprint: String;
    /// SHA-256 of the judged samples, independent of where they are stored; empty without samples.
    "samples_fingerprint" [""] samples_fingerprint: Option<String>;
    /// Reason why the window could not be judged; empty for a judged window.
    "error" [""] error: Option<String>;
    /// Number of samples of the judged stretch.
    "samples" [""] samples: Option<i64>;
    /// Share of usable samples of the OP or of the PV, whichever is lower.
    "good_share" ["%"] good_share: Option<f64>;
    /// Share of the time in automatic: the service factor.
    "auto_share" ["%"] auto_share: Option<f64>;
    /// Time from the start of the window to the start of the judged stretch.
    "stretch_start_s" ["s"] stretch_start_s: Option<f64>;
    /// Duration of the judged stretch.
    "stretch_s" ["s"] stretch_s: Option<f64>;
    /// Sample time of the judged stretch.
    "sample_time_s" ["s"] sample_time_s: Option<f64>;
    /// Fitness of the data: fit, caveats or unfit.
    "fitness" [""] fitness: Option<String>;
    /// Reasons why the data are unfit, in sentences.
    "unfit_reasons" [""] unfit_reasons: Option<String>;
    /// Whether the PV moves during the judged stretch.
    "pv_moves" [""] pv_moves: Option<bool>;
    /// Whether the loop oscillates.
    "oscillates" [""] oscillates: Option<bool>;
    /// Period of the oscillation.
    "period_s" ["s"] period_s: Option<f64>;
    /// Regularity of the oscillation.
    "regularity" [""] regularity: Option<f64>;
    /// Amplitude of the oscillation of the control error. If only the OP oscillates, amplitude of the OP in %.
    "amplitude" ["PV"] amplitude: Option<f64>;
    /// OP travel, up and down, per hour.
    "travel_per_hour" ["%/h"] travel_per_hour: Option<f64>;
    /// OP reversals above the noise, per hour.
    "reversals_per_hour" ["1/h"] reversals_per_hour: Option<f64>;
    /// Share of the time with the OP at a limit.
    "at_limit_share" ["%"] at_limit_share: Option<f64>;
    /// Conclusion of the verdict, such as sticks.
    "verdict" [""] verdict: Option<String>;
    /// Grade of the verdict, such as probably sticks.
    "grade" [""] grade: Option<String>;
    /// Probability that the valve sticks.
    "probability" [""] probability: Option<f64>;
    /// Basis of the verdict, such as evidence in OP and PV.
    "basis" [""] basis: Option<String>;
    /// Number of windows of evidence in this window, with overlaps counted once.
    "evidence_windows" [""] evidence_windows: Option<f64>;
    /// Combined evidence of the window: sums that are added over days.
    "pool" [""] pool: Option<String>;
    /// Stick band plus dead band, of span.
    "S" ["%"] s: Option<f64>;
    /// Lower end of the interval of S, of span.
    "S_low" ["%"] s_low: Option<f64>;
    /// Upper end of the interval of S, of span.
    "S_high" ["%"] s_high: Option<f64>;
    /// Slip jump, of span.
    "J" ["%"] j: Option<f64>;
    /// Lower end of the interval of J, of span.
    "J_low" ["%"] j_low: Option<f64>;
    /// Upper end of the interval of J, of span.
    "J_high" ["%"] j_high: Option<f64>;
    /// Detection limit, of span: a larger S would have been detected.
    "S_below" ["%"] s_below: Option<f64>;
    /// The likeliest cause other than stiction.
    "alternative" [""] alternative: Option<String>;
    /// Probability of the cause in `alternative`.
    "alternative_likelihood" [""] alternative_likelihood: Option<f64>;
    /// Mistake in the columns, because of which the window has no verdict.
    "mistaken" [""] mistaken: Option<String>;
    /// Behaviour of a PV that does not respond.
    "no_response" [""] no_response: Option<String>;
    /// Result of a valve test in the window; empty without a readable test.
    "test" [""] test: Option<String>;
    /// S by the test, of span.
    "test_S" ["%"] test_s: Option<f64>;
    /// Lower end of the interval of S by the test, of span.
    "test_S_low" ["%"] test_s_low: Option<f64>;
    /// Upper end of the interval of S by the test, of span.
    "test_S_high" ["%"] test_s_high: Option<f64>;
    /// Upper limit of S by a test without a value of S, of span.
    "test_S_below" ["%"] test_s_below: Option<f64>;
    /// Start of the test, since 1970-01-01 UTC.
    "test_from" ["s"] test_from: Option<i64>;
    /// End of the test, since 1970-01-01 UTC.
    "test_to" ["s"] test_to: Option<i64>;
}

/// The program's version in rows.
pub const ENGINE_VERSION: &str = env!("CARGO_PKG_VERSION");

/// The training of the verdict, in a word.
pub fn model_version() -> String {
    let (Ok(bundle), Ok(valves)) = (fusion::shipped(), Valves::shipped()) else {
        return "none".to_owned();
    };
    let from = &bundle.provenance;
    format!(
        "population-{}-seed-{}-loops-{}-{}",
        from.population, from.seed, from.trained, valves.name
    )
}

impl WindowRow {
    /// Whether it was judged.
    pub fn is_judged(&self) -> bool {
        self.error.is_none() && self.stretch_s.is_some()
    }

    /// The grade, if the window has one.
    pub fn grade(&self) -> Option<Grade> {
        Grade::ALL.into_iter().find(|grade| self.grade.as_deref() == Some(grade.name()))
    }

    /// The middle of the stretch that was judged, or of the window if none was, s since 1970-01-01 UTC.
    pub fn middle(&self) -> f64 {
        let from = self.stretch_start_s.unwrap_or(0.0);
        self.window_start as f64 + from + self.stretch_s.unwrap_or(self.window_s as f64) / 2.0
    }

    /// Observation of the valve in the middle of the judged stretch, like [`Diagnosis::observation`]; `None` if none
    /// was judged.
    pub fn observation(&self) -> Option<Observation> {
        let estimate = |value: Option<f64>, low: Option<f64>, high: Option<f64>| {
            Some(Estimate { value: value?, low: low?, high: high? })
        };
        self.stretch_s?;
        Some(Observation {
            time: self.middle(),
            class: VerdictClass::by_name(self.verdict.as_deref()?).ok()?,
            grade: self.grade(),
            probability: self.probability,
            s: estimate(self.s, self.s_low, self.s_high),
            j: estimate(self.j, self.j_low, self.j_high),
            weight: 1.0,
            windows: self.evidence_windows.unwrap_or(1.0),
            pool: self.pool.as_ref().and_then(|pool| pool.parse().ok()),
        })
    }

    /// It with how the loop moves, for changes of the valve; `None` if it was not judged.
    pub fn seen(&self) -> Option<Seen> {
        let moves = [self.amplitude, self.period_s, self.travel_per_hour, self.reversals_per_hour];
        let moves = moves.map(|move_| move_.filter(|value| *value > 0.0).map(f64::ln));
        Some(Seen { valve: self.observation()?, days: self.window_s as f64 / 86_400.0, moves })
    }

    /// The row with the results of a diagnosis. Identity, settings and fingerprint are taken from `self`. The times of
    /// the diagnosis count from the start of the window.
    #[must_use]
    pub fn judged(self, diagnosis: &Diagnosis) -> Self {
        let verdict = &diagnosis.verdict;
        let judged = diagnosis.judged.as_ref();
        let kpi = |name: &str| diagnosis.kpis.get(name).and_then(|kpi| kpi.value);
        let found = diagnosis.oscillation().map(|(_, found)| found);
        let (s, j) = (diagnosis.stiction.s, diagnosis.stiction.j);
        let alternative = verdict.alternatives.first();
        let reasons = diagnosis.fitness.reasons.join(" ");
        let finite = |value: Option<f64>| value.filter(|value| value.is_finite());
        Self {
            loop_type: diagnosis.loop_type.name().to_owned(),
            samples: judged.map(|judged| judged.samples as i64),
            good_share: finite(kpi("good values")),
            auto_share: finite(Some(100.0 * diagnosis.grid.closed_share)),
            stretch_start_s: judged.map(|judged| judged.from_s),
            stretch_s: judged.map(|judged| judged.duration_s),
            sample_time_s: judged.map(|judged| judged.sample_time_s),
            fitness: Some(diagnosis.fitness.class.name().to_owned()),
            unfit_reasons: (!reasons.is_empty()).then_some(reasons),
            pv_moves: diagnosis
                .fitness
                .measures
                .iter()
                .find(|measure| measure.id == MeasureId::PvMoves)
                .map(|measure| measure.class != Class::Unfit),
            oscillates: found.map(|found| found.found),
            period_s: finite(found.and_then(|found| found.period_s)),
            regularity: finite(found.and_then(|found| found.regularity)),
            amplitude: finite(found.and_then(|found| found.amplitude)),
            travel_per_hour: finite(kpi("OP travel")),
            reversals_per_hour: finite(kpi("OP reversals")),
            at_limit_share: finite(kpi("OP at a limit")),
            verdict: Some(verdict.class.name().to_owned()),
            grade: Some(verdict.grade.name().to_owned()),
            probability: finite(verdict.probability),
            basis: Some(verdict.basis.name().to_owned()),
            evidence_windows: finite(diagnosis.evidence.as_ref().map(Weighing::number)),
            pool: diagnosis.pool().map(Pool::to_string),
            s: s.map(|s| s.value),
            s_low: s.map(|s| s.low),
            s_high: s.map(|s| s.high),
            j: j.map(|j| j.value),
            j_low: j.map(|j| j.low),
            j_high: j.map(|j| j.high),
            s_below: verdict.s_below.as_ref().map(|limit| limit.value),
            alternative: alternative.map(|other| other.cause.name().to_owned()),
            alternative_likelihood: alternative.map(|other| other.likelihood),
            mistaken: diagnosis.mistaken().map(|mistake| mistake.name().to_owned()),
            no_response: diagnosis.silence().map(|silence| silence.name().to_owned()),
            ..self
        }
    }

    /// The row with the results of a valve test, whose times count from the start of the window.
    #[must_use]
    pub fn tested(self, test: &TestReading) -> Self {
        let at = |s: f64| Some(self.window_start + s as i64);
        Self {
            test: Some(test.class.name().to_owned()),
            test_s: test.s.map(|s| s.value),
            test_s_low: test.s.map(|s| s.low),
            test_s_high: test.s.map(|s| s.high),
            test_s_below: test.s_below,
            test_from: at(test.from_s),
            test_to: at(test.to_s),
            ..self
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::store::table::Row;
    use stiction_diagnose::diagnose::{DiagnoseOptions, diagnose};

    #[test]
    fn rows_go_to_a_table_and_back() {
        let simulated = stiction_population::LoopKind::Sticky.simulate(3).unwrap();
        let found = diagnose(&simulated.recording, &DiagnoseOptions::default()).unwrap();
        let judged = WindowRow { name: "FIC101".to_owned(), ..WindowRow::default() }.judged(&found);
        assert!(
            judged.samples > Some(0)
                && judged.verdict.is_some()
                && judged.travel_per_hour.is_some()
        );
        let refused = WindowRow { error: Some("it is".to_owned()), ..WindowRow::default() };
        let rows = vec![judged, refused];
        let mut table = WindowRow::table(&rows);
        assert_eq!(WindowRow::rows(&table).unwrap(), rows);
        table.columns.truncate(2);
        assert!(WindowRow::rows(&table).unwrap_err().contains("has no column \"type\""));
    }

    #[test]
    fn columns_are_described_and_are_those_of_the_json() {
        let columns = WindowRow::columns();
        assert!(columns.iter().all(|column| !column.meaning.is_empty()));
        let json = serde_json::to_value(WindowRow::default()).unwrap();
        let keys: Vec<&String> = json.as_object().unwrap().keys().collect();
        assert_eq!(keys, columns.iter().map(|column| column.name).collect::<Vec<_>>());
    }
}
