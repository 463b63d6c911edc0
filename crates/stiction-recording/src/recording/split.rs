//! Splits a long recording into shorter ones.

use super::{Channel, Modes, Recording};

impl Recording {
    /// The recording in windows of `window` s that begin at its first sample. The last window takes the rest, so no
    /// window is shorter than half a window. A recording shorter than one and a half windows stays whole. Times keep
    /// their clock. Windows without a sample of the OP are left out.
    ///
    /// If a channel has no sample at the beginning of a window, as in a historian that stores only changes, its
    /// previous value is repeated there.
    ///
    /// # Errors
    /// If `window` is not a finite number above 0.
    pub fn split(&self, window: f64) -> crate::error::Result<Vec<Self>> {
        crate::error::positive("the window", window)?;
        let channels = [Some(&self.op), self.pv.as_ref(), self.sp.as_ref(), self.vp.as_ref()];
        let times = || channels.into_iter().flatten().flat_map(|channel| &channel.time);
        let first = times().copied().fold(f64::INFINITY, f64::min);
        let last = times().copied().fold(f64::NEG_INFINITY, f64::max);
        let duration = last - first;
        let count = (duration / window).round().max(1.0);
        if !duration.is_finite() || count < 2.0 {
            return Ok(vec![self.clone()]);
        }
        // With more windows than samples, some would be empty.
        let count = count.min(times().count() as f64) as usize;
        let part = |k: usize| {
            let from = first + k as f64 * window;
            let to = if k + 1 < count { from + window } else { f64::INFINITY };
            self.part(from, to, f64::INFINITY)
        };
        Ok((0..count).filter_map(part).collect())
    }

    /// The samples from `from` up to `to`, s on the recording's clock, from the first of any channel on. If a channel
    /// has no sample there, its last earlier value is repeated, unless the value is older than `held_s` before `from`.
    /// `None` without a value of the OP.
    pub fn part(&self, from: f64, to: f64, held_s: f64) -> Option<Self> {
        let channels = [Some(&self.op), self.pv.as_ref(), self.sp.as_ref(), self.vp.as_ref()];
        let times = channels.into_iter().flatten().flat_map(|channel| &channel.time);
        let within = |t: &f64| *t >= from && *t < to;
        let first = times.copied().filter(within).fold(f64::INFINITY, f64::min);
        if !first.is_finite() {
            return None;
        }
        let earliest = from - held_s;
        let slice = |channel: &Channel| cut(channel, first, to, earliest);
        Some(Self {
            name: self.name.clone(),
            loop_type: self.loop_type,
            start: self.start,
            plant_time: self.plant_time.clone(),
            columns: self.columns.clone(),
            op: slice(&self.op)?,
            pv: self.pv.as_ref().and_then(slice),
            sp: self.sp.as_ref().and_then(slice),
            vp: self.vp.as_ref().and_then(slice),
            mode: self.mode.as_ref().map(|modes| cut_modes(modes, first, to, earliest)),
            notes: self.notes.clone(),
        })
    }
}

/// The samples of a channel from `from` up to `to`. At `from` the last earlier sample counts, if it is not before
/// `earliest`. The result is `None` without samples.
fn cut(channel: &Channel, from: f64, to: f64, earliest: f64) -> Option<Channel> {
    let mut chosen: Vec<(usize, f64)> = channel
        .time
        .iter()
        .enumerate()
        .filter(|(_, t)| **t >= from && **t < to)
        .map(|(k, t)| (k, *t))
        .collect();
    if !chosen.iter().any(|(_, t)| *t == from) {
        let held = channel.time.iter().enumerate().filter(|(_, t)| **t < from && **t >= earliest);
        if let Some((k, _)) = held.max_by(|(_, a), (_, b)| a.total_cmp(b)) {
            chosen.insert(0, (k, from));
        }
    }
    (!chosen.is_empty()).then(|| Channel {
        time: chosen.iter().map(|(_, t)| *t).collect(),
        values: chosen.iter().map(|(k, _)| channel.values[*k]).collect(),
        quality: chosen.iter().map(|(k, _)| channel.quality[*k]).collect(),
        unit: channel.unit.clone(),
        range: channel.range,
        masked: channel.masked.iter().filter(|m| m.time >= from && m.time < to).copied().collect(),
    })
}

fn cut_modes(modes: &Modes, from: f64, to: f64, earliest: f64) -> Modes {
    let mut part = Modes::default();
    let each = || modes.time.iter().copied().zip(modes.modes.iter().copied());
    if let Some((_, held)) = each().rfind(|(t, _)| *t <= from && *t >= earliest) {
        part.time.push(from);
        part.modes.push(held);
    }
    for (t, mode) in each().filter(|(t, _)| *t > from && *t < to) {
        part.time.push(t);
        part.modes.push(mode);
    }
    part
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::Mode;

    fn regular(samples: usize) -> Recording {
        let op: Vec<f64> = (0..samples).map(|k| k as f64).collect();
        Recording::regular("loop", 2.0, &op, Some(&op), None).unwrap()
    }

    #[test]
    fn every_sample_is_in_one_window() {
        let whole = regular(100);
        for window in [10.0, 33.0, 61.0, 120.0, 1e9] {
            let parts = whole.split(window).unwrap();
            let op: Vec<f64> = parts.iter().flat_map(|part| part.op.values.clone()).collect();
            assert_eq!(op, whole.op.values, "{window}");
            for part in &parts {
                let duration = part.op.time.last().unwrap() - part.op.time[0];
                assert!(parts.len() == 1 || duration >= window / 2.0 - 2.0, "{window}: {duration}");
                assert!(parts.len() == 1 || duration <= 1.5 * window, "{window}: {duration}");
                assert_eq!(part.op.time, part.pv.as_ref().unwrap().time);
            }
        }
        assert_eq!(whole.split(1e9).unwrap(), std::slice::from_ref(&whole));
        for wrong in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(whole.split(wrong).is_err());
        }
    }

    #[test]
    fn what_is_held_reaches_into_the_next_window() {
        let mut whole = regular(100);
        whole.op = Channel::new("OP", vec![0.0, 30.0], vec![40.0, 45.0]).unwrap();
        whole.mode =
            Some(Modes { time: vec![0.0, 90.0], modes: vec![Mode::Automatic, Mode::Manual] });
        let parts = whole.split(50.0).unwrap();
        assert_eq!(parts.len(), 4);
        assert_eq!((parts[1].op.time[0], parts[1].op.values[0]), (50.0, 45.0));
        let modes = |k: usize| parts[k].mode.clone().unwrap();
        assert_eq!(modes(1).time, [50.0, 90.0]);
        assert_eq!((modes(2).time, modes(2).modes), (vec![100.0], vec![Mode::Manual]));
    }
}
