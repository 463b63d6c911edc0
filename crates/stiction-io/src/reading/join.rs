//! Joins recordings of one loop from several files.

use crate::error::{Error, Result};
use crate::names::list;
use sha2::{Digest, Sha256};
use std::collections::{HashMap, HashSet};
use stiction_recording::recording::{Channel, MaskedSample, Modes, Quality, Recording};

/// A recording, and the name of its file in messages.
pub type Part<'a> = (&'a str, &'a Recording);

/// Joins the recordings of one loop. Recordings with dates are ordered by them. Recordings without dates follow each
/// other as given. A clock that continues is kept, and a clock that restarts is shifted to the next sample. The time
/// between two files remains a gap, and samples in both files are used once. The name is taken from the first
/// recording. Values that are not measurements are found in the joined recording, so that the result does not depend on
/// the files.
///
/// # Errors
/// If only some files have dates, the files differ in signals, units or ranges, or they overlap with different samples.
/// The error names the file. Also if there are no recordings.
pub fn join(parts: &[Part<'_>]) -> Result<Recording> {
    let dated = parts.iter().filter(|(_, recording)| recording.start.is_some()).count();
    if let (Some((with, _)), Some((without, _))) = (
        parts.iter().find(|(_, recording)| recording.start.is_some()),
        parts.iter().find(|(_, recording)| recording.start.is_none()),
    ) {
        let message = format!(
            "has no dates, but {with} has, so the files cannot be put in order; give only files with dates, or only files \
             without dates"
        );
        return Err(refused(without, message));
    }
    if let [(_, one)] = parts {
        return Ok((*one).clone());
    }
    let whole: Vec<_> =
        parts.iter().map(|(origin, recording)| (*origin, recording.unmasked())).collect();
    let mut parts: Vec<Part<'_>> = whole.iter().map(|(origin, part)| (*origin, &**part)).collect();
    let begin = |(_, r): &Part<'_>| r.start.unwrap_or(0.0) + span(&r.op).0;
    if dated > 0 {
        parts.sort_by(|a, b| begin(a).total_cmp(&begin(b)));
    }
    let Some(((first, whole), rest)) = parts.split_first() else {
        return Err(refused("no file", "is given, so there is nothing to join".to_owned()));
    };
    let mut whole = (*whole).clone();
    let mut clock = Clock::of(&whole);
    let mut taken = vec![(*first, span(&whole.op).1)];
    for (origin, part) in rest {
        alike((first, &whole), (origin, part))?;
        let shift = clock.shift(part);
        let (from, to) = span(&part.op);
        // The last of several that reach into this one, else the previous one.
        let reaches = taken.iter().rev().find(|(_, end)| *end >= from + shift);
        let before = reaches.or(taken.last()).map_or(*first, |(origin, _)| *origin);
        append(&mut whole, part, shift).map_err(|message| {
            refused(origin, format!("overlaps {before} {message}; leave one file out"))
        })?;
        taken.push((origin, to + shift));
        for note in &part.notes {
            if !whole.notes.contains(note) {
                whole.notes.push(note.clone());
            }
        }
    }
    if parts.len() > 1 {
        let files: Vec<&str> = parts.iter().map(|(origin, _)| *origin).collect();
        let follow =
            if clock.began_again { "; they have no dates and are joined without gaps" } else { "" };
        whole
            .notes
            .insert(0, format!("joined from {} files, {}{follow}", files.len(), list(&files)));
    }
    whole.mask();
    Ok(whole)
}

/// A SHA-256 of several files, computed from the SHA-256 of each in hexadecimal, one per line.
pub fn sha256<'a>(files: impl IntoIterator<Item = &'a str>) -> String {
    let lines: String = files.into_iter().map(|each| format!("{each}\n")).collect();
    format!("{:x}", Sha256::digest(lines))
}

fn refused(origin: &str, message: String) -> Error {
    Error::Table { origin: origin.to_owned(), message }
}

/// The first and last time of a channel.
fn span(channel: &Channel) -> (f64, f64) {
    let times = || channel.time.iter().copied();
    (times().fold(f64::INFINITY, f64::min), times().fold(f64::NEG_INFINITY, f64::max))
}

/// The position of the clocks of the parts on the clock of the whole.
struct Clock {
    start: Option<f64>,
    /// Beginning of the first part on its own clock.
    first: f64,
    /// End of the previous part on its own clock, and the delay of that clock behind the clock of the whole.
    last: f64,
    shift: f64,
    /// The most frequent time between samples, s.
    step: f64,
    began_again: bool,
}

impl Clock {
    fn of(first: &Recording) -> Self {
        let (begin, end) = span(&first.op);
        let mut times = first.op.time.clone();
        times.sort_by(f64::total_cmp);
        let mut steps: Vec<f64> = times.windows(2).map(|pair| pair[1] - pair[0]).collect();
        steps.retain(|step| *step > 0.0);
        steps.sort_by(f64::total_cmp);
        Self {
            start: first.start,
            first: begin,
            last: end,
            shift: 0.0,
            step: steps.get(steps.len() / 2).copied().unwrap_or(1.0),
            began_again: false,
        }
    }

    /// The delay of the clock of the next part.
    fn shift(&mut self, part: &Recording) -> f64 {
        if let (Some(start), Some(own)) = (self.start, part.start) {
            return own - start;
        }
        let (begin, end) = span(&part.op);
        if begin == self.first && begin <= self.last {
            self.shift += self.last + self.step - begin;
            self.began_again = true;
        }
        self.last = end;
        self.shift
    }
}

/// Checks that two parts can belong to one recording.
fn alike((first, a): Part<'_>, (origin, b): Part<'_>) -> Result<()> {
    for (name, a, b) in [
        ("PV", a.pv.as_ref(), b.pv.as_ref()),
        ("SP", a.sp.as_ref(), b.sp.as_ref()),
        ("VP", a.vp.as_ref(), b.vp.as_ref()),
        ("OP", Some(&a.op), Some(&b.op)),
    ] {
        if a.is_some() != b.is_some() {
            return Err(lacks(name, first, origin, a.is_some()));
        }
        let (Some(a), Some(b)) = (a, b) else { continue };
        if a.unit != b.unit {
            let unit = |channel: &Channel| channel.unit.clone().unwrap_or("no unit".to_owned());
            let message = format!(
                "has its {name} in {}, but {first} in {}; convert both to the same unit",
                unit(b),
                unit(a)
            );
            return Err(refused(origin, message));
        }
        if a.range != b.range {
            let ends = |channel: &Channel| {
                channel.range.map_or("percent".to_owned(), |r| format!("{} to {}", r.low, r.high))
            };
            return Err(refused(
                origin,
                format!(
                    "has its {name} in the range {}, but {first} in {}; give the range for both",
                    ends(b),
                    ends(a)
                ),
            ));
        }
    }
    if a.mode.is_some() != b.mode.is_some() {
        return Err(lacks("mode", first, origin, a.mode.is_some()));
    }
    Ok(())
}

fn lacks(signal: &str, first: &str, origin: &str, first_has: bool) -> Error {
    let (with, without) = if first_has { (first, origin) } else { (origin, first) };
    let message = format!(
        "has no {signal}, but {with} has, so the files are not parts of one recording; leave one file out"
    );
    refused(without, message)
}

/// Appends the samples of `part`, whose clock is `shift` s behind, to the samples of `whole`.
fn append(whole: &mut Recording, part: &Recording, shift: f64) -> std::result::Result<(), String> {
    let channel = |signal: &str, whole: &mut Channel, part: &Channel| {
        let samples = |channel: &Channel, shift: f64| {
            let values = channel.values.iter().zip(&channel.quality);
            let times = channel.time.iter().map(|t| t + shift);
            times.zip(values).map(|(t, (v, q))| (t, Value(*v, *q))).collect::<Vec<_>>()
        };
        let all = merged(samples(whole, 0.0), samples(part, shift))
            .map_err(|differ| differ.words(signal))?;
        whole.time = all.iter().map(|(t, _)| *t).collect();
        whole.values = all.iter().map(|(_, value)| value.0).collect();
        whole.quality = all.iter().map(|(_, value)| value.1).collect();
        let named = part.masked.iter().map(|m| MaskedSample { time: m.time + shift, ..*m });
        whole.masked.extend(named);
        whole.masked.sort_by(|a, b| a.time.total_cmp(&b.time).then(a.value.total_cmp(&b.value)));
        whole.masked.dedup_by(|a, b| a.time == b.time && a.value == b.value);
        Ok::<_, String>(())
    };
    channel("OP", &mut whole.op, &part.op)?;
    for (signal, whole, part) in [
        ("PV", &mut whole.pv, &part.pv),
        ("SP", &mut whole.sp, &part.sp),
        ("VP", &mut whole.vp, &part.vp),
    ] {
        if let (Some(whole), Some(part)) = (whole, part) {
            channel(signal, whole, part)?;
        }
    }
    if let (Some(whole), Some(part)) = (&mut whole.mode, &part.mode) {
        let of = |modes: &Modes, shift: f64| {
            modes.time.iter().map(|t| t + shift).zip(modes.modes.iter().copied()).collect()
        };
        let all = merged(of(whole, 0.0), of(part, shift)).map_err(|differ| differ.words("mode"))?;
        (whole.time, whole.modes) = all.into_iter().unzip();
    }
    Ok(())
}

/// A value and its quality. Two unusable values are equal.
#[derive(Clone, Copy)]
struct Value(f64, Quality);

impl PartialEq for Value {
    fn eq(&self, other: &Self) -> bool {
        self.1 == other.1 && (self.0 == other.0 || (self.0.is_nan() && other.0.is_nan()))
    }
}

/// How two recordings of the same time differ.
enum Differ {
    /// In a value.
    Values,
    /// In sampling times.
    Times,
}

impl Differ {
    fn words(self, signal: &str) -> String {
        match self {
            Self::Values => format!("with different values of the {signal}"),
            Self::Times => format!("with samples of the {signal} at other times"),
        }
    }
}

/// The samples of both, with common samples once. Where the two overlap, all samples of one must also be samples of the
/// other. One series may begin with a held value that the other series stored only at its change.
fn merged<V: PartialEq + Copy>(
    mut old: Vec<(f64, V)>,
    new: Vec<(f64, V)>,
) -> std::result::Result<Vec<(f64, V)>, Differ> {
    // Clocks of different files agree to a microsecond at best.
    let key = |time: f64| (time * 1e6).round() as i64;
    let keys = |samples: &[(f64, V)]| -> HashSet<i64> {
        samples.iter().map(|(time, _)| key(*time)).collect()
    };
    let (before, after) = (keys(&old), keys(&new));
    let (Some(end), Some(begin)) = (before.iter().max(), after.iter().min()) else {
        old.extend(new);
        return Ok(old);
    };
    if begin > end {
        old.extend(new);
        return Ok(old);
    }
    let within_old = before.iter().filter(|key| *key >= begin).count();
    let within_new = after.iter().filter(|key| *key <= end).count();
    if before.intersection(&after).count() < within_old.min(within_new) {
        return Err(Differ::Times);
    }
    let mut known: HashMap<i64, Vec<V>> = HashMap::new();
    for (time, value) in &old {
        known.entry(key(*time)).or_default().push(*value);
    }
    for (time, value) in new {
        match known.get(&key(time)) {
            Some(values) if values.contains(&value) => {}
            Some(_) => return Err(Differ::Values),
            None => old.push((time, value)),
        }
    }
    old.sort_by(|a, b| a.0.total_cmp(&b.0));
    Ok(old)
}

#[cfg(test)]
mod tests {
    use super::*;
    use stiction_recording::recording::{Mode, Range, RangeSource};

    /// A loop sampled every second from `start` or, without a date, from 0; the OP counts on from `op`.
    fn part(start: Option<f64>, op: f64, count: usize) -> Recording {
        let values: Vec<f64> = (0..count).map(|k| op + k as f64).collect();
        let mut part = Recording::regular("A", 1.0, &values, Some(&values), None).unwrap();
        part.start = start;
        part
    }

    fn joined(parts: &[Recording]) -> std::result::Result<Recording, String> {
        let names = ["a.csv", "b.csv", "c.csv"];
        let parts: Vec<Part<'_>> = names.into_iter().zip(parts).collect();
        join(&parts).map_err(|error| error.to_string())
    }

    #[test]
    fn dates_put_files_in_order_and_gaps_stay() {
        let whole = joined(&[part(Some(110.0), 7.0, 2), part(Some(100.0), 1.0, 3)]).unwrap();
        assert_eq!(whole.start, Some(100.0));
        assert_eq!(whole.op.time, [0.0, 1.0, 2.0, 10.0, 11.0]);
        assert_eq!(whole.op.values, [1.0, 2.0, 3.0, 7.0, 8.0]);
        assert_eq!(whole.pv.unwrap().time.len(), 5);
        assert_eq!(whole.notes, ["joined from 2 files, \"b.csv\", \"a.csv\""]);
    }

    #[test]
    fn without_dates_files_follow_each_other() {
        let mut later = part(None, 9.0, 2);
        for channel in [Some(&mut later.op), later.pv.as_mut()].into_iter().flatten() {
            channel.time = vec![5.0, 6.0];
        }
        let whole = joined(&[part(None, 1.0, 2), part(None, 5.0, 2), later]).unwrap();
        // The second clock begins again; the third goes on from the second's.
        assert_eq!(whole.op.time, [0.0, 1.0, 2.0, 3.0, 7.0, 8.0]);
        assert!(whole.notes[0].ends_with("joined without gaps"), "{:?}", whole.notes);
    }

    #[test]
    fn what_is_in_two_files_is_taken_once() {
        let whole = joined(&[part(Some(0.0), 1.0, 3), part(Some(2.0), 3.0, 3)]).unwrap();
        assert_eq!(whole.op.values, [1.0, 2.0, 3.0, 4.0, 5.0]);
        let twice = joined(&[part(Some(0.0), 1.0, 3), part(Some(0.0), 1.0, 3)]).unwrap();
        assert_eq!(twice.op.values, [1.0, 2.0, 3.0]);
        // A value that a file begins with, where the other stores changes only.
        let mut changes = part(Some(0.0), 1.0, 3);
        changes.mode = Some(Modes { time: vec![0.0], modes: vec![Mode::Automatic] });
        let mut next = part(Some(2.0), 3.0, 3);
        next.mode =
            Some(Modes { time: vec![0.0, 1.0], modes: vec![Mode::Automatic, Mode::Manual] });
        let modes = joined(&[changes, next]).unwrap().mode.unwrap();
        assert_eq!(modes.time, [0.0, 2.0, 3.0]);
    }

    #[test]
    fn what_cannot_be_one_recording_is_refused() {
        let (a, b) = (part(Some(0.0), 1.0, 3), part(Some(2.0), 4.0, 3));
        let (mut without, mut unit, mut range, mut mode) =
            (b.clone(), b.clone(), b.clone(), b.clone());
        without.pv = None;
        unit.op.unit = Some("mA".to_owned());
        range.op.range = Some(Range::new(4.0, 20.0, RangeSource::Given).unwrap());
        mode.mode = Some(Modes::default());
        let shifted = part(Some(1.5), 2.0, 3);
        for (other, expected) in [
            (b, "b.csv: overlaps a.csv with different values of the OP; leave one file out"),
            (shifted, "b.csv: overlaps a.csv with samples of the OP at other times"),
            (part(None, 1.0, 3), "b.csv: has no dates, but a.csv has"),
            (without, "b.csv: has no PV, but a.csv has"),
            (unit, "b.csv: has its OP in mA, but a.csv in no unit"),
            (range, "b.csv: has its OP in the range 4 to 20, but a.csv in percent"),
            (mode, "a.csv: has no mode, but b.csv has"),
        ] {
            let message = joined(&[a.clone(), other]).unwrap_err();
            assert!(message.contains(expected), "{message}");
        }
        assert!(joined(&[]).unwrap_err().contains("nothing to join"));
    }

    #[test]
    fn one_recording_is_itself() {
        let one = part(None, 1.0, 3);
        assert_eq!(joined(std::slice::from_ref(&one)), Ok(one));
    }

    #[test]
    fn hashes_depend_on_the_order() {
        assert_eq!(sha256(["a", "b"]).len(), 64);
        assert_ne!(sha256(["a", "b"]), sha256(["b", "a"]));
    }
}
