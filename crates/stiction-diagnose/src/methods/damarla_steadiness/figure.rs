//! Figure of the method: windows by a test of steadiness.

use super::{DamarlaTestResult, SteadinessTest};
use crate::drawing::Scene;
use crate::methods::shared::drawn_windows::marked;
use stiction_figure::figure::Figure;

pub(in crate::methods) fn draw(scene: &Scene<'_>, found: &DamarlaTestResult) -> Option<Figure> {
    let what = match found.test {
        SteadinessTest::FTest => "variance",
        SteadinessTest::TTest | SteadinessTest::Hotelling => "mean",
        SteadinessTest::ReverseArrangements => "level",
    };
    let lead = format!(
        "In the shaded windows of {} samples, the PV's {what} is steady and the OP's is not",
        found.window
    );
    marked(scene, &lead, &found.marked, found.window)
}
