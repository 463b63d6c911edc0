//! How series look: colour, dash pattern, marker.

use super::{Panel, Style};

/// Indices of the colours: those of Okabe and Ito that stand out on white.
///
/// Higher indices start over.
pub mod colour {
    /// Blue.
    pub const BLUE: usize = 0;
    /// Vermilion.
    pub const VERMILION: usize = 1;
    /// Bluish green.
    pub const GREEN: usize = 2;
    /// Reddish purple.
    pub const PURPLE: usize = 3;
    /// Orange.
    pub const ORANGE: usize = 4;
    /// Sky blue.
    pub const SKY: usize = 5;
    /// Black.
    pub const BLACK: usize = 6;
}

/// Red, green, blue.
pub(super) type Rgb = (u8, u8, u8);

/// In the order of the indices in [`colour`].
const COLOURS: [Rgb; 7] = [
    (0x00, 0x72, 0xb2),
    (0xd5, 0x5e, 0x00),
    (0x00, 0x9e, 0x73),
    (0xcc, 0x79, 0xa7),
    (0xe6, 0x9f, 0x00),
    (0x56, 0xb4, 0xe9),
    (0x00, 0x00, 0x00),
];

pub(super) const INK: Rgb = (0x22, 0x22, 0x22);
pub(super) const GRID: Rgb = (0xe4, 0xe4, 0xe4);
pub(super) const REFERENCE: Rgb = (0x66, 0x66, 0x66);
pub(super) const BAND: Rgb = (0x99, 0x99, 0x99);
pub(super) const EMPTY: Rgb = (0xdd, 0xdd, 0xdd);
pub(super) const UNKNOWN: Rgb = COLOURS[colour::VERMILION];
pub(super) const PAPER: Rgb = (0xff, 0xff, 0xff);

/// Lengths of strokes and gaps, px. Ends are round, so a stroke of length 0 is a dot.
pub(super) type Dash = &'static [f64];

pub(super) const SOLID: Dash = &[];
pub(super) const DASHED: Dash = &[6.0, 5.0];
pub(super) const DOTTED: Dash = &[0.0, 4.0];

/// Handed out to lines in this order.
const DASHES: [Dash; 6] =
    [SOLID, DASHED, &[9.0, 4.5, 0.0, 4.5], DOTTED, &[15.0, 5.0], &[9.0, 4.0, 0.0, 4.0, 0.0, 4.0]];

/// The shape of a point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Marker {
    Circle,
    Square,
    Triangle,
    Diamond,
}

/// Handed out to clouds of points in this order.
const MARKERS: [Marker; 4] = [Marker::Circle, Marker::Square, Marker::Triangle, Marker::Diamond];

/// How one series is drawn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Look {
    pub colour: Rgb,
    pub dash: Dash,
    /// Set for points, which have no stroke, and for the key of bars.
    pub marker: Option<Marker>,
}

/// The looks of a panel's series: no two lines share a dash pattern before all are used up.
pub(super) fn looks(panel: &Panel) -> Vec<Look> {
    let taken = |dash: Dash| {
        panel.series.iter().any(|s| match s.style {
            Style::Dashed => dash == DASHED,
            Style::Dotted => dash == DOTTED,
            _ => false,
        })
    };
    let mut dashes = DASHES.into_iter().filter(|d| !taken(d)).chain(DASHES.into_iter().cycle());
    let mut markers = MARKERS.into_iter().cycle();
    let look = |(index, series): (usize, &super::Series)| {
        let (dash, marker) = match series.style {
            Style::Line | Style::Steps => (dashes.next().unwrap_or(SOLID), None),
            Style::Dashed => (DASHED, None),
            Style::Dotted => (DOTTED, None),
            Style::Points => (SOLID, markers.next()),
            Style::Bars => (SOLID, Some(Marker::Square)),
        };
        Look { colour: COLOURS[series.colour.unwrap_or(index) % COLOURS.len()], dash, marker }
    };
    panel.series.iter().enumerate().map(look).collect()
}
