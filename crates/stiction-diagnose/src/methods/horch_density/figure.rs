//! Figure of the method: how often the PV bends by how much.

use super::HorchDensityResult;
use crate::drawing::{Scene, sheet};
use crate::methods::shared::curvature::LABEL;
use crate::spoken::number;
use stiction_figure::figure::{Figure, Legend, Panel, Series, colour};

pub(in crate::methods) fn draw(_: &Scene<'_>, found: &HorchDensityResult) -> Option<Figure> {
    let x = &found.places[..];
    let panel = Panel::new(LABEL, "density (per standard deviation)")
        .legend(Legend::Above)
        .with(Series::bars("found", x, &found.found[..]).colour(colour::SKY))
        .with(
            Series::line("one hump, as with a sticking valve", x, &found.one_hump[..])
                .colour(colour::VERMILION),
        )
        .with(
            Series::dashed("two humps, as of a sinusoid", x, &found.two_humps[..])
                .colour(colour::BLACK),
        );
    let caption = format!(
        "Density of the PV's second derivative, with the best fits of one hump and of two. The index is {}: 1 if \
         one hump fits, −1 if two do.",
        number(found.statistic)
    );
    Some(sheet(caption).with(panel))
}
