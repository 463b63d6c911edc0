//! Figure of the method: the prediction error of the loop beside the errors of its surrogates.

use super::SurrogatesResult;
use crate::drawing::{Scene, dashed, histogram, line_at, sheet, solid};
use crate::series::{max, mean, sample_std};
use crate::spoken::number;
use stiction_figure::figure::{Figure, Legend, Panel, Series, colour};

pub(in crate::methods) fn draw(_: &Scene<'_>, found: &SurrogatesResult) -> Option<Figure> {
    let (x, shares) = histogram(&found.surrogates);
    let limit = mean(&found.surrogates) - 3.0 * found.limit * sample_std(&found.surrogates);
    let panel =
        Panel::new("squared prediction error Γ (variances, summed)", "share of the surrogates (%)")
            .legend(Legend::Above)
            .with(Series::bars("surrogates", x, &shares[..]).colour(colour::SKY))
            .with(line_at(dashed, "limit", limit, max(&shares)).colour(colour::BLACK))
            .with(line_at(solid, "this loop", found.gamma, max(&shares)).colour(colour::VERMILION));
    let caption = format!(
        "Error of predicting the control error from its own past, compared with {} surrogates with the same \
         spectrum and the same values but random phases. To the left of the limit, the control error is more \
         predictable than that of a linear loop. N is {}; the loop is nonlinear above {}.",
        found.surrogates.len(),
        number(found.n),
        number(found.limit)
    );
    Some(sheet(caption).with(panel))
}
