//! Recordings and answers as lines of JSON: what a detector reads and writes.

use crate::scoreboard::Answer;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use stiction_diagnose::diagnose::Estimate;
use stiction_diagnose::finding::Decision;
use stiction_diagnose::recording::{Channel, LoopType, Recording};

/// A recording, as a detector reads it. Signals are evenly sampled and equally long, with null for missing samples.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
struct Sent {
    /// Name.
    id: String,
    /// Type of the loop, such as `flow`, or `unknown`.
    #[serde(rename = "type")]
    loop_type: String,
    /// Time between samples, s.
    sample_time_s: f64,
    /// Controller output, percent.
    op: Vec<Option<f64>>,
    /// Process value, in its units.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pv: Option<Vec<Option<f64>>>,
    /// Set point, in the units of the PV.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    sp: Option<Vec<Option<f64>>>,
    /// Valve position, percent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    vp: Option<Vec<Option<f64>>>,
}

/// An answer, as a detector writes it and as results store it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct AnswerLine {
    /// The recording.
    pub id: String,
    /// Larger values indicate sticking.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub score: Option<f64>,
    /// The probability that the valve sticks.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub probability: Option<f64>,
    /// `sticks`, `does not stick` or `abstain`; without it, the detector abstains.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub decision: Option<String>,
    /// Stick band plus dead band, percent of span.
    #[serde(rename = "S", default, skip_serializing_if = "Option::is_none")]
    pub s: Option<Guess>,
    /// Slip jump, percent of span.
    #[serde(rename = "J", default, skip_serializing_if = "Option::is_none")]
    pub j: Option<Guess>,
    /// The reason if there is no answer. A detector may write it too.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub no_answer: Option<String>,
    /// Time for the answer, s. It is measured, not asked; absent if several detectors were asked together.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub time_s: Option<f64>,
}

/// A number, or a number with its 90 % interval.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum Guess {
    /// A number.
    Value(f64),
    /// With its interval.
    Interval {
        /// The best value.
        value: f64,
        /// Lower end.
        low: f64,
        /// Upper end.
        high: f64,
    },
}

/// A recording as a line, without a line end.
///
/// # Errors
/// If the signals are not evenly sampled on one clock, with the first sample at 0.
pub fn line(recording: &Recording) -> Result<String, String> {
    let time = &recording.op.time;
    let step = time.get(1).copied().unwrap_or(1.0);
    let even = |channel: &Channel| {
        channel.time.len() == time.len()
            && channel.time.iter().enumerate().all(|(k, t)| *t == k as f64 * step)
    };
    let signal = |channel: &Channel| match even(channel) {
        true => Ok(channel.values.iter().map(|v| v.is_finite().then_some(*v)).collect()),
        false => {
            Err(format!("{}: its signals are not evenly sampled on one clock", recording.name))
        }
    };
    let optional = |channel: &Option<Channel>| channel.as_ref().map(signal).transpose();
    let sent = Sent {
        id: recording.name.clone(),
        loop_type: recording.loop_type.name().to_owned(),
        sample_time_s: step,
        op: signal(&recording.op)?,
        pv: optional(&recording.pv)?,
        sp: optional(&recording.sp)?,
        vp: optional(&recording.vp)?,
    };
    Ok(serde_json::to_string(&sent).unwrap_or_default())
}

/// The recording of a line.
///
/// # Errors
/// If the line is not a recording. The error is a sentence.
pub fn recording(line: &str) -> Result<Recording, String> {
    let sent: Sent = serde_json::from_str(line)
        .map_err(|e| format!("not a recording as JSON with id, type, sample_time_s and op: {e}"))?;
    let values = |x: Vec<Option<f64>>| -> Vec<f64> {
        x.into_iter().map(|value| value.unwrap_or(f64::NAN)).collect()
    };
    let (op, pv, sp) = (values(sent.op), sent.pv.map(values), sent.sp.map(values));
    let of = |e: stiction_model::error::Error| format!("{}: {e}", sent.id);
    let mut made =
        Recording::regular(&sent.id, sent.sample_time_s, &op, pv.as_deref(), sp.as_deref())
            .map_err(of)?;
    made.loop_type = LoopType::by_name(&sent.loop_type).map_err(of)?;
    if let Some(vp) = sent.vp.map(values) {
        if vp.len() != op.len() {
            return Err(format!(
                "{}: vp has {} samples, but op has {}",
                sent.id,
                vp.len(),
                op.len()
            ));
        }
        made.vp = Some(Channel::new("VP", made.op.time.clone(), vp).map_err(of)?);
    }
    Ok(made)
}

impl AnswerLine {
    /// An answer for results, with its time.
    pub fn of(id: &str, answer: &Answer) -> Self {
        let guess = |e: Estimate| match e.low.is_nan() || e.high.is_nan() {
            true => Guess::Value(e.value),
            false => Guess::Interval { value: e.value, low: e.low, high: e.high },
        };
        let decision = match answer.decision {
            Decision::Sticks | Decision::Nonlinear => "sticks",
            Decision::DoesNotStick | Decision::Linear => "does not stick",
            Decision::Undecided | Decision::Abstains => "abstain",
        };
        Self {
            id: id.to_owned(),
            score: answer.score,
            probability: answer.probability,
            decision: answer.failure.is_none().then(|| decision.to_owned()),
            s: answer.s.map(guess),
            j: answer.j.map(guess),
            no_answer: answer.failure.clone(),
            time_s: Some(answer.time_s).filter(|time_s| time_s.is_finite()),
        }
    }

    /// As a line, without a line end and time.
    pub fn line(&self) -> String {
        serde_json::to_string(&Self { time_s: None, ..self.clone() }).unwrap_or_default()
    }

    /// The answer. One that is out of range is no answer, with the reason.
    pub fn answer(&self) -> Answer {
        let time_s = self.time_s.unwrap_or(f64::NAN);
        self.checked(time_s).unwrap_or_else(|reason| Answer::none(reason, time_s))
    }

    fn checked(&self, time_s: f64) -> Result<Answer, String> {
        if let Some(reason) = &self.no_answer {
            return Err(reason.clone());
        }
        if self.score.is_none() && self.probability.is_none() && self.decision.is_none() {
            return Err("the answer has no score, no probability and no decision".to_owned());
        }
        // JSON has no NaN, but Python has.
        if self.score.is_some_and(|score| !score.is_finite()) {
            return Err("the score is not finite".to_owned());
        }
        if let Some(p) = self.probability.filter(|p| !(0.0..=1.0).contains(p)) {
            return Err(format!("the probability is {p}, but must be between 0 and 1"));
        }
        let decision = match self.decision.as_deref() {
            Some("sticks") => Decision::Sticks,
            Some("does not stick") => Decision::DoesNotStick,
            Some("abstain" | "abstains") | None => Decision::Abstains,
            Some(other) => {
                return Err(format!(
                    "the decision is {other:?}, but must be \"sticks\", \"does not stick\" or \"abstain\""
                ));
            }
        };
        let estimate = |name: &str, guess: Option<Guess>| -> Result<Option<Estimate>, String> {
            let found = match guess {
                None => return Ok(None),
                Some(Guess::Value(value)) => Estimate { value, low: f64::NAN, high: f64::NAN },
                Some(Guess::Interval { value, low, high }) => Estimate { value, low, high },
            };
            let ordered = match guess {
                Some(Guess::Interval { value, low, high }) => low <= value && value <= high,
                _ => true,
            };
            if !(found.value.is_finite() && found.value >= 0.0 && ordered) {
                return Err(format!("{name} must be at least 0 and lie in its interval"));
            }
            Ok(Some(found))
        };
        Ok(Answer {
            score: self.score,
            probability: self.probability,
            decision,
            s: estimate("S", self.s)?,
            j: estimate("J", self.j)?,
            time_s,
            failure: None,
        })
    }
}

/// A line of a detector.
#[derive(Debug, Clone, PartialEq)]
pub enum ParsedLine {
    /// The answer about the recording, or a broken one as no answer.
    Answer(Answer),
    /// Something else, such as a progress message.
    Other,
}

/// Interprets a line of a detector that was asked about the recording `id`. A line is an answer if it begins with a brace,
/// unless it is about another recording.
pub fn parsed_line(line: &str, id: &str) -> ParsedLine {
    let line = line.trim();
    if !line.starts_with('{') {
        return ParsedLine::Other;
    }
    let parsed: Result<serde_json::Value, _> = serde_json::from_str(line);
    let broken = |reason: String| ParsedLine::Answer(Answer::none(reason, 0.0));
    let value = match parsed {
        Ok(value) => value,
        Err(_) if ["NaN", "Infinity"].iter().any(|word| line.contains(word)) => {
            return broken(
                "the answer contains NaN or Infinity, which JSON does not have".to_owned(),
            );
        }
        Err(e) => return broken(format!("the answer is not JSON: {e}")),
    };
    match value.get("id").and_then(|found| found.as_str()) {
        Some(found) if found != id => return ParsedLine::Other,
        Some(_) => {}
        None => return broken("the answer has no id".to_owned()),
    }
    match serde_json::from_value::<AnswerLine>(value) {
        Ok(said) => ParsedLine::Answer(said.answer()),
        Err(e) => broken(format!(
            "the answer has a value of the wrong type (S and J are numbers, or objects with value, low and high): {e}"
        )),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::suite::Suite;

    #[test]
    fn a_recording_survives_the_line_bit_for_bit() {
        let suite = Suite::by_name("v1-trial", None).unwrap();
        for k in 0..suite.len() {
            let made = suite.known(k).unwrap().recording;
            let text = line(&made).unwrap();
            assert!(!text.contains('\n'));
            let back = recording(&text).unwrap();
            assert_eq!(back, made);
            assert_eq!(line(&back).unwrap(), text);
        }
    }

    #[test]
    fn missing_samples_are_null_and_other_clocks_are_refused() {
        let mut made = Recording::regular("x", 2.0, &[1.0, f64::NAN], None, None).unwrap();
        let text = line(&made).unwrap();
        assert_eq!(text, r#"{"id":"x","type":"unknown","sample_time_s":2.0,"op":[1.0,null]}"#);
        assert!(recording(&text).unwrap().op.values[1].is_nan());
        made.op.time[1] = 3.0;
        made.pv = Some(Channel::new("PV", vec![0.0, 1.0], vec![1.0, 2.0]).unwrap());
        assert!(line(&made).unwrap_err().contains("one clock"));
        for (text, wanted) in [
            ("{}", "missing field"),
            (r#"{"id":"x","type":"flux","sample_time_s":1,"op":[1]}"#, "flux"),
            (r#"{"id":"x","type":"flow","sample_time_s":0,"op":[1]}"#, "sample time"),
            (r#"{"id":"x","type":"flow","sample_time_s":1,"op":[1],"vp":[]}"#, "vp has 0 samples"),
        ] {
            let refused = recording(text).unwrap_err();
            assert!(refused.contains(wanted), "{text}: {refused}");
        }
    }

    #[test]
    fn an_answer_is_an_answer_or_has_a_reason() {
        let of = |text: &str| match parsed_line(text, "a") {
            ParsedLine::Answer(answer) => answer,
            ParsedLine::Other => Answer::none("other", 0.0),
        };
        let good = of(
            r#" {"id":"a","score":1.5,"decision":"sticks","S":{"value":2,"low":1,"high":3},"J":0.5,"x":1}"#,
        );
        assert_eq!(
            (good.score, good.decision, good.failure.as_deref()),
            (Some(1.5), Decision::Sticks, None)
        );
        assert_eq!(good.s, Some(Estimate { value: 2.0, low: 1.0, high: 3.0 }));
        assert!(good.j.is_some_and(|j| j.value == 0.5 && j.low.is_nan()));
        assert_eq!(of(r#"{"id":"a","probability":0.2}"#).decision, Decision::Abstains);
        for (text, wanted) in [
            ("reading model ...", "other"),
            ("", "other"),
            ("[1]", "other"),
            (r#"{"id":"b","score":1}"#, "other"),
            (r#"{"score":1}"#, "has no id"),
            (r#"{"id":"a"}"#, "no score, no probability and no decision"),
            (r#"{"id":"a","score":NaN}"#, "NaN"),
            (r#"{"id":"a","score":"#, "not JSON"),
            (r#"{"id":"a","score":"high"}"#, "wrong type"),
            (r#"{"id":"a","probability":1.01}"#, "between 0 and 1"),
            (r#"{"id":"a","decision":"maybe"}"#, "must be \"sticks\""),
            (r#"{"id":"a","score":1,"S":-1}"#, "S must be at least 0"),
            (r#"{"id":"a","score":1,"J":{"value":5,"low":6,"high":7}}"#, "J must be"),
            (r#"{"id":"a","no_answer":"too short"}"#, "too short"),
        ] {
            let reason = of(text).failure.unwrap();
            assert!(reason.contains(wanted), "{text}: {reason}");
        }
    }

    #[test]
    fn what_is_kept_is_what_was_reported() {
        let lines = [
            r#"{"id":"a","score":1.5,"decision":"sticks","S":{"value":2.0,"low":1.0,"high":3.0},"J":0.5}"#,
            r#"{"id":"a","probability":0.25,"decision":"abstain"}"#,
            r#"{"id":"a","no_answer":"it ended"}"#,
        ];
        for text in lines {
            let ParsedLine::Answer(answer) = parsed_line(text, "a") else { panic!("{text}") };
            assert_eq!(AnswerLine::of("a", &answer).line(), text);
        }
    }
}
