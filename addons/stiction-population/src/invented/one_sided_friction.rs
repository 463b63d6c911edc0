//! A valve that jumps when it opens and slides when it closes.

use super::parts::{Friction, Parts};
use super::sketch::Sketch;

/// The stem opens once the OP exceeds the static friction, and jumps to the position given by sliding friction. To
/// close, it must overcome only sliding friction. S is the OP travel from closing to opening, and J the jump; from
/// opening to closing it is S - J, without a jump.
pub(super) struct OneSidedFriction {
    /// Static friction against opening, sliding friction while opening, and friction while closing.
    holds: f64,
    opens: f64,
    closes: f64,
    /// Whether it is opening.
    opening: bool,
}

impl OneSidedFriction {
    pub fn of(sketch: &Sketch) -> Self {
        let draw = &mut sketch.of_kind();
        let closes = (sketch.s - sketch.j) * draw.uniform(0.0, 0.5);
        let holds = sketch.s - closes;
        Self { holds, opens: holds - sketch.j, closes, opening: false }
    }
}

impl Parts for OneSidedFriction {
    fn stem(&mut self, valve: &mut Friction, op: f64) -> f64 {
        if !valve.sticks() {
            return valve.step(op);
        }
        let push = op - valve.stem;
        let against = if self.opening { self.opens } else { self.holds };
        self.opening = push > against;
        if self.opening {
            valve.stem = op - self.opens;
        } else if -push > self.closes {
            valve.stem = op + self.closes;
        }
        valve.stem
    }
}

#[cfg(test)]
mod tests {
    use super::super::sketch::tests::{Invention, sketches};
    use super::*;

    #[test]
    fn it_jumps_by_j_after_s_where_it_opens_and_slides_after_s_less_j_where_it_closes() {
        for (_, sketch) in sketches(Invention::OneSidedFriction) {
            let (mut parts, mut valve) =
                (OneSidedFriction::of(&sketch), Friction::of(&sketch, true).unwrap());
            let step = 1e-3 * sketch.s;
            // Down, up and down again by three S each, in small steps.
            let mut op = sketch.rest;
            let mut way = |up: bool| {
                let (mut waited, mut first) = (None, 0.0);
                for k in 1..3000 {
                    op += if up { step } else { -step };
                    let before = valve.stem;
                    let moved = parts.stem(&mut valve, op) - before;
                    if moved != 0.0 && waited.is_none() {
                        (waited, first) = (Some(f64::from(k) * step), moved);
                    }
                }
                (waited.unwrap(), first)
            };
            way(false);
            let (s, j) = way(true);
            assert!(
                (s - sketch.s).abs() < 2.0 * step && (j - sketch.j).abs() < 2.0 * step,
                "{s} {j}"
            );
            let (s, j) = way(false);
            assert!(
                (s - (sketch.s - sketch.j)).abs() < 2.0 * step && j.abs() < 2.0 * step,
                "{s} {j}"
            );
        }
    }
}
