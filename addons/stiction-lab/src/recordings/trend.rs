//! The signals of a loop as bytes, so that a million samples come in one go.
//!
//! Little endian. The number of samples and the existing signals (bit 0 SP, 1 PV, 2 OP, 3 VP) have 4 bytes each. The
//! times and these signals follow in this order, with 8 bytes a number. Times ascend. Where signals were stored at
//! different times, each signal holds its last value. A bad or missing sample is NaN.

use std::sync::Arc;
use stiction_diagnose::recording::{Channel, Recording};

/// The signals of a recording.
pub(super) fn bytes(recording: &Recording) -> Vec<u8> {
    let channels =
        [recording.sp.as_ref(), recording.pv.as_ref(), Some(&recording.op), recording.vp.as_ref()];
    let there: Vec<&Channel> = channels.iter().flatten().copied().collect();
    let times = times(&there);
    let signals = channels.iter().enumerate().filter(|(_, channel)| channel.is_some());
    let mask = signals.fold(0u32, |mask, (bit, _)| mask | 1 << bit);
    let mut out = Vec::with_capacity(8 + 8 * times.len() * (1 + there.len()));
    out.extend((times.len() as u32).to_le_bytes());
    out.extend(mask.to_le_bytes());
    times.iter().for_each(|t| out.extend(t.to_le_bytes()));
    for channel in there {
        if is_ascending(&channel.time) && channel.time[..] == times[..] {
            channel.values.iter().for_each(|value| out.extend(value.to_le_bytes()));
        } else {
            held(channel, &times).for_each(|value| out.extend(value.to_le_bytes()));
        }
    }
    out
}

fn is_ascending(times: &[f64]) -> bool {
    times.windows(2).all(|pair| pair[0] < pair[1])
}

/// The times at which any of the channels has a sample.
fn times(channels: &[&Channel]) -> Arc<[f64]> {
    if let [first, others @ ..] = channels
        && is_ascending(&first.time)
        && others.iter().all(|other| other.time == first.time)
    {
        return first.time[..].into();
    }
    let mut all: Vec<f64> = channels.iter().flat_map(|channel| &channel.time).copied().collect();
    all.sort_by(f64::total_cmp);
    all.dedup();
    all.into()
}

/// Value of a channel at each of some times; none before the first sample.
fn held<'a>(channel: &'a Channel, times: &'a [f64]) -> impl Iterator<Item = f64> + 'a {
    let mut order: Vec<usize> = (0..channel.time.len()).collect();
    order.sort_by(|a, b| channel.time[*a].total_cmp(&channel.time[*b]));
    let mut next = 0;
    let mut value = f64::NAN;
    times.iter().map(move |t| {
        while let Some(place) = order.get(next).filter(|place| channel.time[**place] <= *t) {
            value = channel.values[*place];
            next += 1;
        }
        value
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn signals_with_times_of_their_own_hold_their_values() {
        let mut recording =
            Recording::regular("loop", 1.0, &[1.0, 2.0, 3.0], Some(&[4.0, f64::NAN, 6.0]), None)
                .unwrap();
        let numbers = |bytes: &[u8]| -> Vec<f64> {
            bytes[8..]
                .chunks(8)
                .map(|eight| f64::from_le_bytes(eight.try_into().unwrap()))
                .collect()
        };
        let all = bytes(&recording);
        assert_eq!(all[..8], [3, 0, 0, 0, 0b110, 0, 0, 0]);
        assert_eq!(numbers(&all)[..4], [0.0, 1.0, 2.0, 4.0]);
        assert!(numbers(&all)[4].is_nan());
        recording.pv = Some(Channel::new("PV", vec![1.5, 0.5], vec![9.0, 8.0]).unwrap());
        let all = numbers(&bytes(&recording));
        assert_eq!(all[..5], [0.0, 0.5, 1.0, 1.5, 2.0]);
        assert!(all[5].is_nan());
        assert_eq!(all[6..], [8.0, 8.0, 9.0, 9.0, 1.0, 1.0, 2.0, 2.0, 3.0]);
    }
}
