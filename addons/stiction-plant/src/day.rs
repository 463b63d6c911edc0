//! Days by the clock of the plant, and recordings cut at them.

use jiff::civil::Date;
use jiff::{Span, Unit};
use stiction_diagnose::recording::{Channel, MaskedSample, Modes, Recording};
use stiction_io::timestamp::{Zone, instant};

/// A value stored on change holds into a window for at most this long, s. With this bound a window does not depend on
/// other data in the same read.
pub const HELD_FROM: f64 = 86_400.0;

const EPOCH: Date = Date::constant(1970, 1, 1);

/// The day of the plant at an instant, s since 1970-01-01 UTC: days since 1970-01-01 on its calendar.
pub fn of(instant: f64, zone: &Zone) -> i64 {
    (zone.plant_time(instant).shows(instant) / 86_400.0).floor() as i64
}

/// When a day of the plant begins, s since 1970-01-01 UTC.
pub fn begin(day: i64, zone: &Zone) -> f64 {
    let date = date(day);
    instant(&date, Some(zone)).unwrap_or(day as f64 * 86_400.0)
}

/// A day as text, such as `2026-03-01`; its number if the day is outside the calendar.
pub fn date(day: i64) -> String {
    let date = Span::new().try_days(day).and_then(|days| EPOCH.checked_add(days));
    date.map_or_else(|_| day.to_string(), |date| date.to_string())
}

/// The day of a text such as `2026-03-01`.
///
/// # Errors
/// If the text is not a date.
pub fn parse(text: &str) -> Result<i64, String> {
    let date: Date =
        text.parse().map_err(|_| format!("\"{text}\" is not a day; write it like 2026-03-01"))?;
    let since = EPOCH.until((Unit::Day, date)).map_err(|e| e.to_string())?;
    Ok(i64::from(since.get_days()))
}

/// The days on which a recording has a sample of the OP, in order; empty for a recording without dates.
pub fn days(recording: &Recording, zone: &Zone) -> Vec<i64> {
    let Some(start) = recording.start else { return vec![] };
    let mut days: Vec<i64> = vec![];
    let mut within = (f64::INFINITY, f64::NEG_INFINITY);
    for t in &recording.op.time {
        let at = start + t;
        // Clocks are asked once a day, not once a sample.
        if !(at >= within.0 && at < within.1) {
            let day = of(at, zone);
            within = (begin(day, zone), begin(day + 1, zone));
            days.push(day);
        }
    }
    days.sort_unstable();
    days.dedup();
    days
}

/// The samples of a recording from `from` up to `to`, s since 1970-01-01 UTC, as they are. `None` without a sample of
/// the OP, or without dates.
pub fn slice(recording: &Recording, from: f64, to: f64) -> Option<Recording> {
    let start = recording.start?;
    let within = |t: f64| {
        let at = ((start + t) * 1e6).round() / 1e6;
        at >= from && at < to
    };
    let channel = |channel: &Channel| {
        let chosen: Vec<usize> =
            (0..channel.time.len()).filter(|k| within(channel.time[*k])).collect();
        Channel {
            time: chosen.iter().map(|k| channel.time[*k]).collect(),
            values: chosen.iter().map(|k| channel.values[*k]).collect(),
            quality: chosen.iter().map(|k| channel.quality[*k]).collect(),
            unit: channel.unit.clone(),
            range: channel.range,
            masked: channel.masked.iter().filter(|masked| within(masked.time)).copied().collect(),
        }
    };
    let modes = |modes: &Modes| {
        let each = modes.time.iter().copied().zip(modes.modes.iter().copied());
        let (time, modes) = each.filter(|(t, _)| within(*t)).unzip();
        Modes { time, modes }
    };
    let op = channel(&recording.op);
    (!op.time.is_empty()).then(|| Recording {
        name: recording.name.clone(),
        loop_type: recording.loop_type,
        start: recording.start,
        plant_time: recording.plant_time.clone(),
        columns: recording.columns.clone(),
        op,
        pv: recording.pv.as_ref().map(channel),
        sp: recording.sp.as_ref().map(channel),
        vp: recording.vp.as_ref().map(channel),
        mode: recording.mode.as_ref().map(modes),
        notes: vec![],
    })
}

/// The samples of a recording from `from` up to `to`, s since 1970-01-01 UTC, on a clock that begins at `from`. A value
/// before that which is not [older than a day](HELD_FROM) is held to the first sample. `None` without a sample of the
/// OP, or without dates.
pub fn cut(recording: &Recording, from: f64, to: f64) -> Option<Recording> {
    let start = recording.start?;
    // Files begin their clocks anywhere; to the microsecond, the same instant is the same number.
    let clock = |t: f64| ((start + t - from) * 1e6).round() / 1e6;
    let channel = |channel: &Channel| Channel {
        time: channel.time.iter().map(|t| clock(*t)).collect(),
        masked: channel
            .masked
            .iter()
            .map(|masked| MaskedSample { time: clock(masked.time), ..*masked })
            .collect(),
        ..channel.clone()
    };
    let shifted = Recording {
        start: Some(from),
        op: channel(&recording.op),
        pv: recording.pv.as_ref().map(channel),
        sp: recording.sp.as_ref().map(channel),
        vp: recording.vp.as_ref().map(channel),
        mode: recording.mode.as_ref().map(|modes| Modes {
            time: modes.time.iter().map(|t| clock(*t)).collect(),
            modes: modes.modes.clone(),
        }),
        // Of files, not of the window.
        notes: vec![],
        ..recording.clone()
    };
    shifted.part(0.0, to - from, HELD_FROM)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn days_are_those_of_the_clock_on_the_wall() {
        let berlin: Zone = "Europe/Berlin".parse().unwrap();
        let day = parse("2026-03-29").unwrap();
        assert_eq!(date(day), "2026-03-29");
        let (from, to) = (begin(day, &berlin), begin(day + 1, &berlin));
        assert_eq!(to - from, 82_800.0, "summer time begins");
        assert_eq!(
            (of(from, &berlin), of(from - 1.0, &berlin), of(to, &berlin)),
            (day, day - 1, day + 1)
        );
        assert!(parse("29.3.2026").is_err());
    }

    #[test]
    fn days_beyond_the_calendar_are_numbers() {
        let berlin: Zone = "Europe/Berlin".parse().unwrap();
        for day in [11_574_074, -11_574_074, i64::MAX, i64::MIN] {
            assert_eq!((date(day), begin(day, &berlin)), (day.to_string(), day as f64 * 86_400.0));
        }
        assert_eq!(of(1e12, &berlin), 11_574_074);
    }

    #[test]
    fn a_cut_begins_its_clock_and_holds_no_longer_than_a_day() {
        let op: Vec<f64> = (0..100).map(f64::from).collect();
        let mut whole = Recording::regular("A", 3600.0, &op, Some(&op), None).unwrap();
        whole.start = Some(1000.0);
        let sp = |at: f64| Some(Channel::new("SP", vec![at], vec![7.0]).unwrap());
        whole.sp = sp(40.0 * 3600.0);
        let from = 1000.0 + 48.0 * 3600.0;
        let window = cut(&whole, from, from + 86_400.0).unwrap();
        assert_eq!((window.op.time.len(), window.op.time[0], window.op.values[0]), (24, 0.0, 48.0));
        assert_eq!(window.sp.unwrap().time, [0.0]);
        whole.sp = sp(0.0);
        assert_eq!(cut(&whole, from, from + 86_400.0).unwrap().sp, None);
        assert_eq!(cut(&whole, 1e9, 2e9), None);
        let zone: Zone = "UTC".parse().unwrap();
        assert_eq!(days(&whole, &zone), [0, 1, 2, 3, 4]);
    }
}
