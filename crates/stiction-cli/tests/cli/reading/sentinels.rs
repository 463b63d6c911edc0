//! Loops of the population with numbers that are no measurements, and with true events that look like them.

use super::count;
use super::in_process::{Judged, Random, Sampled, for_each, judged};

const SEED: u64 = 4801;
const SENTINELS: [f64; 6] = [-9999.0, 9999.0, -999.25, 1e31, -32768.0, 327.67];

/// Six sentinels at 1 to 20 places of PV or OP: the verdict is that of the clean loop. `STICTION_LOOPS=500` is the whole.
#[test]
fn sentinels_do_not_change_a_verdict() {
    let loops = count("STICTION_LOOPS", 5);
    let of_loop = |index: usize| {
        let clean = Sampled::member(SEED, index);
        let right = judged(clean.wide().as_bytes(), "loop.csv").expect("a plain table is read");
        let of_sentinel = |sentinel: &f64| {
            let mut random = Random::of(SEED, 100 * index + sentinel.abs() as usize % 97);
            let (places, mut spoilt) = (1 + random.below(20), clean.clone());
            let in_op = random.below(3) == 0;
            for _ in 0..places {
                let at = random.below(clean.len());
                if in_op { spoilt.op[at] = *sentinel } else { spoilt.pv[at] = *sentinel }
            }
            let what = format!(
                "loop {index}: {places} x {sentinel} in {}",
                if in_op { "OP" } else { "PV" }
            );
            (what, right.clone(), judged(spoilt.wide().as_bytes(), "loop.csv"))
        };
        SENTINELS.iter().map(of_sentinel).collect::<Vec<_>>()
    };
    let all: Vec<_> = for_each(loops, of_loop).into_iter().flatten().collect();
    let (mut equal, mut unnamed, mut wrong, mut opposite) = (0, vec![], vec![], vec![]);
    for (what, right, found) in &all {
        match found {
            Ok(found) => {
                equal += usize::from(found.grade == right.grade);
                let line = format!(
                    "{what}: {}, clean {}; {:?}",
                    found.grade,
                    right.grade,
                    found.new_words(right)
                );
                if found.is_opposite(right) {
                    opposite.push(line);
                } else if found.grade != right.grade {
                    wrong.push(line);
                } else if !found
                    .new_words(right)
                    .iter()
                    .any(|word| word.contains("mask") || word.contains("no measurement"))
                {
                    unnamed.push(line);
                }
            }
            Err(message) => wrong.push(format!("{what}: refused: {message}")),
        }
    }
    let share = equal as f64 / all.len() as f64;
    println!(
        "sentinels: {} files, {:.2} % equal, {} opposite, {} not named",
        all.len(),
        100.0 * share,
        opposite.len(),
        unnamed.len()
    );
    let first = |lines: &[String]| lines.iter().take(12).cloned().collect::<Vec<_>>().join("\n");
    assert!(
        opposite.is_empty() && share >= 0.98 && unnamed.is_empty(),
        "{:.2} % of {} equal, expected 98 %\n== opposite: {}\n{}\n== another grade: {}\n{}\n== not named: {}\n{}\n",
        100.0 * share,
        all.len(),
        opposite.len(),
        first(&opposite),
        wrong.len(),
        first(&wrong),
        unnamed.len(),
        first(&unnamed)
    );
}

/// True steps, spikes that decay, and saturation are no sentinels. `STICTION_LOOPS=200` is the whole.
#[test]
fn true_events_stay() {
    let loops = count("STICTION_LOOPS", 5).min(200);
    let of_loop = |index: usize| {
        let clean = Sampled::member(SEED + 1, index);
        let n = clean.len();
        let mut random = Random::of(SEED + 1, index);
        let span = |x: &[f64]| {
            x.iter().fold(f64::MIN, |a, b| a.max(*b)) - x.iter().fold(f64::MAX, |a, b| a.min(*b))
        };
        let at_share = |x: &[f64], share: f64| {
            let mut sorted = x.to_vec();
            sorted.sort_by(f64::total_cmp);
            sorted[(share * (n - 1) as f64) as usize]
        };
        let height = span(&clean.pv);
        let mut events: Vec<(&str, Sampled)> = vec![];
        let mut with = |name, change: &mut dyn FnMut(&mut Sampled)| {
            let mut changed = clean.clone();
            change(&mut changed);
            events.push((name, changed));
        };
        let from = n / 4 + random.below(n / 2);
        with("step", &mut |to| {
            for k in from..n {
                to.pv[k] += 8.0 * height;
                to.sp[k] += 8.0 * height;
            }
        });
        with("step back", &mut |to| {
            for k in from..(from + n / 10).min(n) {
                to.pv[k] -= 8.0 * height;
                to.sp[k] -= 8.0 * height;
            }
        });
        with("spikes that decay", &mut |to| {
            for _ in 0..3 {
                let from = random.below(n - 12);
                for j in 0..12 {
                    to.pv[from + j] += 6.0 * height * (-(j as f64) / 3.0).exp();
                }
            }
        });
        let (pv_top, op_top) = (at_share(&clean.pv, 0.9), at_share(&clean.op, 0.85));
        with("saturated PV", &mut |to| to.pv.iter_mut().for_each(|v| *v = v.min(pv_top)));
        with("saturated OP", &mut |to| to.op.iter_mut().for_each(|v| *v = v.min(op_top)));
        with("closed OP", &mut |to| {
            for k in from..(from + n / 20).min(n) {
                to.op[k] = 0.0;
            }
        });
        let of_event = |(name, changed): (&str, Sampled)| {
            let text = changed.wide();
            let lost = |found: &Judged| {
                let words: Vec<&String> = found
                    .said
                    .iter()
                    .filter(|word| word.contains("mask") || word.contains("no measurement"))
                    .collect();
                (found.lost > 0 || !words.is_empty()).then(|| {
                    format!("loop {index}, {name}: {} samples lost of {n}; {words:?}", found.lost)
                })
            };
            match judged(text.as_bytes(), "loop.csv") {
                Ok(found) => lost(&found),
                Err(message) => Some(format!("loop {index}, {name}: refused: {message}")),
            }
        };
        events.into_iter().filter_map(of_event).collect::<Vec<_>>()
    };
    let lost: Vec<String> = for_each(loops, of_loop).into_iter().flatten().collect();
    println!("true events: {} of {} files lose samples", lost.len(), 6 * loops);
    assert!(
        lost.is_empty(),
        "{} of {} files lose samples\n{}\n",
        lost.len(),
        6 * loops,
        lost.iter().take(20).cloned().collect::<Vec<_>>().join("\n")
    );
}
