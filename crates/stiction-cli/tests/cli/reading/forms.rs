//! The same samples in every form give the same verdict. `STICTION_LOOPS=200` is the whole.

use super::count;
use super::in_process::{Sampled, for_each, judged, shown};
use std::fmt::Write as _;

const SEED: u64 = 4803;

/// A long table in the order of time; `late` is how much later OP is sampled, s. `changes` leaves out equal samples.
fn long(of: &Sampled, late: f64, changes: bool) -> String {
    let mut text = "Tag,Time (s),Value\n".to_owned();
    let mut last = [f64::NAN; 3];
    for k in 0..of.len() {
        let t = k as f64 * of.step;
        for (index, (tag, t, value)) in
            [("PV", t, of.pv[k]), ("SP", t, of.sp[k]), ("OP", t + late, of.op[k])]
                .into_iter()
                .enumerate()
        {
            if !changes || value != last[index] || k + 1 == of.len() {
                let _ = writeln!(text, "F1.{tag},{},{}", shown(t), shown(value));
            }
            last[index] = value;
        }
    }
    text
}

/// A wide table; equal samples are left empty.
fn wide_changes(of: &Sampled) -> String {
    let mut text = "Time (s),F1.PV,F1.SP,F1.OP\n".to_owned();
    let mut last = [f64::NAN; 3];
    for k in 0..of.len() {
        text += &shown(k as f64 * of.step);
        for (index, value) in [of.pv[k], of.sp[k], of.op[k]].into_iter().enumerate() {
            let is_new = value != last[index] || k + 1 == of.len();
            let _ = write!(text, ",{}", if is_new { shown(value) } else { String::new() });
            last[index] = value;
        }
        text.push('\n');
    }
    text
}

/// A row for each time of a tag, with the other cells empty.
fn joined(of: &Sampled, late: f64, none: &str) -> String {
    let mut text = "Time (s),F1.PV,F1.SP,F1.OP\n".to_owned();
    for k in 0..of.len() {
        let t = k as f64 * of.step;
        let _ = writeln!(text, "{},{},{},{none}", shown(t), shown(of.pv[k]), shown(of.sp[k]));
        let _ = writeln!(text, "{},{none},{none},{}", shown(t + late), shown(of.op[k]));
    }
    text
}

/// Time and value of each tag side by side.
fn beside(of: &Sampled, late: f64) -> String {
    let mut text = "Time (s),F1.PV,Time 2 (s),F1.SP,Time 3 (s),F1.OP\n".to_owned();
    for k in 0..of.len() {
        let t = k as f64 * of.step;
        let (now, later) = (shown(t), shown(t + late));
        let _ = writeln!(
            text,
            "{now},{},{now},{},{later},{}",
            shown(of.pv[k]),
            shown(of.sp[k]),
            shown(of.op[k])
        );
    }
    text
}

#[test]
fn every_form_of_the_same_samples_gives_one_verdict() {
    let loops = count("STICTION_LOOPS", 5).min(200);
    let of_loop = |index: usize| {
        let fine = Sampled::member(SEED, index);
        let coarse = fine.coarse();
        let late = fine.step / 4.0;
        // Each form beside a plain table of the same samples.
        let forms = [
            ("long", fine.wide(), long(&fine, 0.0, false)),
            ("joined", long(&fine, late, false), joined(&fine, late, "")),
            ("joined with NaN", long(&fine, late, false), joined(&fine, late, "NaN")),
            ("side by side", long(&fine, late, false), beside(&fine, late)),
            ("side by side, one clock", fine.wide(), beside(&fine, 0.0)),
            ("long on change", coarse.wide(), long(&coarse, 0.0, true)),
            ("wide on change", coarse.wide(), wide_changes(&coarse)),
        ];
        forms.map(|(name, plain, form)| {
            let right =
                judged(plain.as_bytes(), "loop.csv").map_err(|e| format!("the plain table: {e}"));
            (
                name,
                match (right, judged(form.as_bytes(), "loop.csv")) {
                    (Ok(right), Ok(found)) => {
                        // A probability at a threshold may fall to either side of it.
                        let near = right
                            .probability
                            .zip(found.probability)
                            .is_some_and(|(a, b)| (a - b).abs() < 0.02);
                        (right.grade != found.grade && !near).then(|| {
                            format!(
                                "loop {index}, {name}: {} of {} samples, expected {} of {}; {:?}",
                                found.grade,
                                found.samples,
                                right.grade,
                                right.samples,
                                found.new_words(&right)
                            )
                        })
                    }
                    (Err(message), _) => Some(format!("loop {index}, {name}: {message}")),
                    (_, Err(message)) => Some(format!("loop {index}, {name}: refused: {message}")),
                },
            )
        })
    };
    let all: Vec<_> = for_each(loops, of_loop).into_iter().flatten().collect();
    let mut table = String::new();
    let mut wrong = vec![];
    for form in [
        "long",
        "joined",
        "joined with NaN",
        "side by side",
        "side by side, one clock",
        "long on change",
        "wide on change",
    ] {
        let of_form: Vec<_> = all.iter().filter(|(name, _)| *name == form).collect();
        let bad: Vec<_> = of_form.iter().filter_map(|(_, fault)| fault.as_ref()).collect();
        let _ =
            writeln!(table, "{form:24} {} of {} equal", of_form.len() - bad.len(), of_form.len());
        // Where only changes of a coarse signal are stored, a long rest and a gap look alike.
        let most = if form.ends_with("on change") { of_form.len() / 5 } else { 0 };
        if bad.len() > most {
            wrong.extend(bad.into_iter().take(4).cloned());
        }
    }
    println!("{table}");
    assert!(wrong.is_empty(), "\n{table}\n{}\n", wrong.join("\n"));
}
