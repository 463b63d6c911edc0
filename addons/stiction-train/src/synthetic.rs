//! Artificial loops: features drawn from simple laws, for testing the training.

use crate::dataset::{Column, Dataset, Truth};
use crate::random::Stream;
use stiction_diagnose::evidence::Line;
use stiction_diagnose::fusion::Cause;

/// Rows of four columns. Column 0 is evidence for a fault, column 1 (of the OP alone) is weak evidence, column 2
/// distinguishes causes, but not sticking from normal operation. Column 3 is `ln(S / span)` with noise that column
/// 1 scales; a tenth of it is missing.
pub fn dataset(seed: u64, rows: u64) -> Dataset {
    let mut stream = Stream::new(seed, 77);
    let column = |name: &str, monotone, op_only| {
        let line = if op_only { Line::OpShape } else { Line::Model };
        Column { name: name.into(), monotone, line, op_only }
    };
    let columns = vec![
        column("evidence", 1, false),
        column("shape", 0, true),
        column("cause", 0, false),
        column("extent", 0, false),
    ];
    let mut normal = move || (0..12).map(|_| stream.unit()).sum::<f64>() - 6.0;
    let mut chance = Stream::new(seed, 78);
    let rows = (0..rows).map(|index| {
        let sticks = chance.unit() < 0.45;
        let cause = match (sticks, chance.unit()) {
            (true, u) if u < 0.1 => Cause::NoResponse,
            (true, _) => Cause::StickingValve,
            (false, u) if u < 0.5 => Cause::NormalOperation,
            (false, u) if u < 0.8 => Cause::ExternalWave,
            (false, _) => Cause::Saturation,
        };
        let s = (8.0_f64).powf(chance.unit());
        let span = s * (0.5 + chance.unit());
        let noise = 0.05 + 0.3 * chance.unit();
        let fault = f64::from(sticks);
        // Sticking looks like normal operation in it.
        let looks = if cause == Cause::StickingValve { Cause::NormalOperation } else { cause };
        let place = Cause::ALL.iter().position(|each| *each == looks).unwrap_or(0) as f64;
        let extent = (s / span).ln() + noise * normal();
        let values = vec![
            (2.5 * fault + normal()) as f32,
            (0.2 * fault + noise) as f32,
            (place + 0.5 * normal()) as f32,
            if chance.unit() < 0.1 { f32::NAN } else { extent as f32 },
        ];
        let process = if chance.unit() < 0.5 { "first order" } else { "second order" };
        let truth = Truth {
            index,
            kind: cause.name().replace(' ', "-"),
            cause,
            visible: chance.unit() < 0.95,
            slips: 10,
            nats: 100.0,
            swing: 2.0,
            s: if sticks { s } else { 0.0 },
            j: if sticks { s * chance.unit() } else { 0.0 },
            model: if !sticks {
                ""
            } else if chance.unit() < 0.7 {
                "two-phase"
            } else {
                "he"
            }
            .into(),
            process: process.into(),
            steps: 1 + index % 10,
            op_span: span,
            families: vec![format!("process: {process}"), format!("cause: {}", cause.name())],
        };
        (truth, values)
    });
    Dataset::new(columns, rows.collect::<Vec<_>>())
}
