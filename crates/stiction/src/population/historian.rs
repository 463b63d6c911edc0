//! What a historian does to a signal.

/// The samples that a swinging-door compression with the given deviation keeps, and straight lines
/// between them: what comes back from a historian that interpolates. The first and last samples are
/// kept; every other one lies within `deviation` of what comes back.
///
/// Source: E. H. Bristol, "Swinging door trending: adaptive trend recording?", ISA National
/// Conference 1990 (recalled, not read).
pub fn swinging_door(x: &[f64], deviation: f64) -> Vec<f64> {
    let mut back = Vec::with_capacity(x.len());
    let Some(&first) = x.first() else { return back };
    back.push(first);
    let mut anchor = 0;
    // The steepest and the flattest line from the anchor that pass within the deviation of every
    // sample since.
    let (mut steepest, mut flattest) = (f64::INFINITY, f64::NEG_INFINITY);
    for k in 1..x.len() {
        let run = (k - anchor) as f64;
        let slope = (x[k] - x[anchor]) / run;
        if slope > steepest || slope < flattest {
            extend(&mut back, x, anchor, k - 1);
            anchor = k - 1;
            (steepest, flattest) = (f64::INFINITY, f64::NEG_INFINITY);
        }
        let run = (k - anchor) as f64;
        steepest = steepest.min((x[k] + deviation - x[anchor]) / run);
        flattest = flattest.max((x[k] - deviation - x[anchor]) / run);
    }
    extend(&mut back, x, anchor, x.len() - 1);
    back
}

/// The straight line from sample `from`, which is there already, to sample `to`.
fn extend(back: &mut Vec<f64>, x: &[f64], from: usize, to: usize) {
    for k in from + 1..=to {
        let share = (k - from) as f64 / (to - from) as f64;
        back.push(if k == to { x[to] } else { x[from] + share * (x[to] - x[from]) });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_comes_back_is_within_the_deviation() {
        let x: Vec<f64> = (0..500).map(|k| (f64::from(k * k) * 0.01).sin() * 3.0).collect();
        let back = swinging_door(&x, 0.2);
        assert_eq!(back.len(), x.len());
        assert!(x.iter().zip(&back).all(|(a, b)| (a - b).abs() <= 0.2 + 1e-12));
        let kept = x.iter().zip(&back).filter(|(a, b)| a == b).count();
        assert!((50..450).contains(&kept), "{kept}");
        assert_eq!(swinging_door(&x, 0.0).len(), x.len());
        assert!(swinging_door(&[], 1.0).is_empty());
    }
}
