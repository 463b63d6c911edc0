//! The look of series: colour, dash pattern and marker.

use super::{Panel, Style};

/// Indices of the colours, from Okabe and Ito's set, as far as they stand out on white.
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

    /// Set point.
    pub const SP: usize = BLACK;
    /// Process value.
    pub const PV: usize = GREEN;
    /// Controller output.
    pub const OP: usize = BLUE;
    /// Valve position.
    pub const VP: usize = VERMILION;
}

/// The colours of the signals for a page, as CSS variables `--sp`, `--pv`, `--op` and `--vp`. On white these are the
/// colours of the figures, and on black lighter colours of the same hue.
pub fn signals_css() -> String {
    let shades = |dark: bool| {
        let one = |(name, index, light): (&str, usize, Rgb)| {
            let (r, g, b) = if dark { light } else { COLOURS[index] };
            format!("  --{name}: #{r:02x}{g:02x}{b:02x};\n")
        };
        let signals = [
            ("sp", colour::SP, (0xe8, 0xe8, 0xea)),
            ("pv", colour::PV, (0x3c, 0xc7, 0x9b)),
            ("op", colour::OP, COLOURS[colour::SKY]),
            ("vp", colour::VP, (0xff, 0x9a, 0x4d)),
        ];
        format!(":root {{\n{}}}\n", signals.map(one).concat())
    };
    format!(
        "/* The colours of the signals, as in all figures: made of stiction-figure's palette. */\n{}\
         @media (prefers-color-scheme: dark) {{\n{}}}\n",
        shades(false),
        shades(true)
    )
}

/// Red, green, blue.
pub(super) type Rgb = (u8, u8, u8);

/// The colours, in the order of the indices in [`colour`].
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

/// Viridis, from dark to bright, which colour-blind readers can order too, by Nathaniel Smith, Stéfan van der Walt
/// and Eric Firing, CC0. There are more shades than an eye distinguishes, but few enough that most neighbouring tiles
/// of a map share one.
#[rustfmt::skip]
const SHADES: [u32; 129] = [
    0x440154, 0x440357, 0x45065a, 0x46095c, 0x460c5f, 0x470f62, 0x471265, 0x471567, 0x48186a,
    0x481a6c, 0x481d6e, 0x481f71, 0x482273, 0x472475, 0x472777, 0x472979, 0x472c7a, 0x462e7c,
    0x46317e, 0x45337f, 0x453681, 0x443882, 0x433a83, 0x423d84, 0x423f85, 0x414186, 0x404487,
    0x3f4688, 0x3e4888, 0x3d4b89, 0x3c4d89, 0x3b4f8a, 0x3a518b, 0x39538b, 0x38558c, 0x37588b,
    0x365a8c, 0x355c8d, 0x345e8d, 0x33608d, 0x32628d, 0x31648d, 0x31668e, 0x30688d, 0x2f6a8d,
    0x2e6c8e, 0x2d6e8e, 0x2c708e, 0x2c718e, 0x2b738e, 0x2a758e, 0x29778e, 0x29798d, 0x287b8e,
    0x277d8e, 0x267f8d, 0x26818e, 0x25828e, 0x24848e, 0x23868d, 0x23888d, 0x228a8d, 0x218c8d,
    0x218e8c, 0x20908c, 0x20918c, 0x1f938b, 0x1f958b, 0x1f978a, 0x1e998a, 0x1e9b89, 0x1e9d88,
    0x1f9f88, 0x1fa087, 0x1fa286, 0x20a485, 0x21a684, 0x22a883, 0x24aa82, 0x25ac81, 0x27ad80,
    0x29af7f, 0x2cb17d, 0x2eb37c, 0x31b57a, 0x34b679, 0x37b877, 0x3aba75, 0x3dbb73, 0x40bd71,
    0x44bf6f, 0x48c06d, 0x4cc26b, 0x50c469, 0x54c567, 0x58c764, 0x5cc862, 0x60ca5f, 0x65cb5d,
    0x69cc5a, 0x6ece57, 0x73cf55, 0x77d052, 0x7cd24f, 0x81d34c, 0x86d448, 0x8bd545, 0x90d642,
    0x95d73f, 0x9bd83b, 0xa0d938, 0xa5da35, 0xaadb31, 0xb0dc2e, 0xb5dd2a, 0xbade27, 0xc0df24,
    0xc5df21, 0xcae01e, 0xd0e11b, 0xd5e219, 0xdae218, 0xdfe318, 0xe4e418, 0xe9e41a, 0xeee51c,
    0xf3e51e, 0xf8e621, 0xfde725,
];

/// The steps of [`shade`] from 0 to 1.
pub(super) const STEPS: usize = SHADES.len() - 1;

/// The colour of a value, from 0 (dark) to 1 (bright).
pub(super) fn shade(fraction: f64) -> Rgb {
    let [_, r, g, b] =
        SHADES[((fraction * STEPS as f64).round() as usize).min(STEPS)].to_be_bytes();
    (r, g, b)
}

/// Lengths of strokes and gaps, px. Ends are round, so a stroke of length 0 is a dot.
pub(super) type Dash = &'static [f64];

pub(super) const SOLID: Dash = &[];
pub(super) const DASHED: Dash = &[6.0, 5.0];
pub(super) const DOTTED: Dash = &[0.0, 4.0];

/// The dash patterns of lines, in this order.
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

/// The markers of clouds of points, in this order.
const MARKERS: [Marker; 4] = [Marker::Circle, Marker::Square, Marker::Triangle, Marker::Diamond];

/// The look of one series.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Look {
    pub colour: Rgb,
    pub dash: Dash,
    /// Set for points, which have no stroke, and for the key of bars.
    pub marker: Option<Marker>,
}

/// The looks of a panel's series. No two lines share a dash pattern before all are used.
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
