//! Every model against an independent implementation, over six inputs.

use crate::common;

use common::{Table, max_difference, model_named, positions};

/// Columns of the table: model and its (S, J).
const MODELS: [&str; 7] = ["kano", "choudhury", "twophase", "xch", "he", "stenman", "backlash"];
const BANDS: [(u32, u32); 6] = [(5, 0), (5, 2), (5, 5), (5, 7), (2, 1), (10, 3)];

#[test]
fn models_reproduce_the_reference() {
    let table = Table::fixture("open_loop_models.csv.gz");
    let mut inputs: Vec<&str> = (0..table.len()).map(|row| table.text(row, "input")).collect();
    inputs.dedup();
    assert_eq!(inputs.len(), 6);
    for model in MODELS {
        let mut worst: f64 = 0.0;
        for (s, j) in BANDS {
            for input in &inputs {
                let rows = table.rows(|row| table.text(row, "input") == *input);
                let op = table.column(&rows, "u");
                let expected = table.column(&rows, &format!("{model}_S{s}_J{j}"));
                let found = positions(model_named(model), s.into(), j.into(), &op);
                let difference = max_difference(&found, &expected);
                assert!(difference <= 1e-12, "{model} S={s} J={j} {input}: {difference:e}");
                worst = worst.max(difference);
            }
        }
        println!("{model}: largest difference {worst:e}");
    }
}
