//! Turns with the OP at an end of its range, where the valve is at its end too.

use super::weigh::Manual;
use crate::spoken::counted;

/// Distance from an end that counts as at the end, percent.
const NEAR: f64 = 0.05;

/// The remark on turns at 0 or 100 %; `None` without such turns.
pub(super) fn cut(spells: &[(Vec<f64>, Manual)]) -> Option<String> {
    let turns = || spells.iter().flat_map(|(_, manual)| &manual.turns);
    let cut = turns().filter(|(_, op)| *op <= NEAR || *op >= 100.0 - NEAR).count();
    (cut > 0).then(|| {
        format!(
            "the OP was at 0 or 100 % in {} of {}, so the valve could not follow; repeat the test with the OP away from \
             its limits",
            cut,
            counted(turns().count(), "turn")
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn turns_at_an_end_are_counted() {
        let of = |op: &[f64]| {
            let turns = op.iter().enumerate().map(|(k, op)| (10 * k, *op)).collect();
            vec![(vec![], Manual { pv: vec![0.0; 100], before: op[0], turns })]
        };
        assert_eq!(cut(&of(&[40.0, 42.0, 39.0])), None);
        let said = cut(&of(&[2.0, 0.0, 3.0, 0.0, 4.0])).unwrap();
        assert!(said.starts_with("the OP was at 0 or 100 % in 2 of 5 turns"), "{said}");
        assert!(cut(&of(&[99.0, 100.0])).is_some());
    }
}
