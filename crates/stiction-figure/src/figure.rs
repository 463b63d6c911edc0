//! Figures as plain data, and their pictures as SVG text or PNG bytes.
//!
//! A [`Figure`] is a grid of [`Panel`]s; a panel is a pair of axes with [`Series`] and [`Annotation`]s in data
//! coordinates. The submodules know pixels: they choose ranges and ticks (`axis`), reduce long series (`reduce`), place
//! things (`layout`, `legend`, `annotate`) and draw (`paint`, on a `canvas`), as text (`svg`) or as `pixels`
//! (`coverage`, `font`). This module does not.
//!
//! Panels of one column that are directly above each other and share their x label have the same x range. Only the
//! lowest one has tick labels.
//!
//! Series differ in dash pattern or marker as well as in colour. The colours are the palette of Okabe and Ito, which
//! remains distinct for colour-blind readers.
//!
//! An axis divides its range linearly, logarithmically or as dates and times, see [`Scale`].
//!
//! On a page with the script of the report a figure is [`Live`]. Its values can be read at the pointer, and panels of
//! one [`Panel::group`] zoom together.
//!
//! # Long series
//!
//! A series is reduced before it is drawn, so that 60,000 samples do not make a file of
//! megabytes:
//!
//! * if its x never decreases (a time trend), each half-pixel column keeps its first, lowest,
//!   highest and last sample, so no extreme is lost;
//! * else (a map), samples within 0.3 px of the last one kept are dropped, as are strokes that the series has already
//!   painted.

mod annotate;
mod axis;
mod canvas;
mod clock;
mod coverage;
mod curve;
mod font;
mod geometry;
mod heat;
mod layout;
mod legend;
mod live;
mod paint;
mod palette;
mod pixels;
mod reduce;
mod svg;
mod text;

use crate::error::Error;
use layout::Sheet;
use paint::paint;
use pixels::Pixels;
use svg::{Place, Svg, caption_id};

pub use clock::instant;
pub use heat::{Heat, Tile};
pub use live::Live;
pub use palette::{colour, signals_css};
pub use svg::FONTS;

/// The largest magnitude that can be drawn. Beyond it, differences overflow.
const LARGEST: f64 = 1e300;

/// One picture: a grid of panels under a title.
#[derive(Debug, Clone, PartialEq)]
pub struct Figure {
    /// Heading inside the picture; empty for none.
    pub title: String,
    /// The caption. It belongs beside the picture, as in a paper, so the picture does not contain it. The SVG has it as
    /// its description.
    pub caption: String,
    /// The panels, row by row.
    pub panels: Vec<Panel>,
    /// Number of panels side by side.
    pub columns: usize,
    /// Width in px; less is used if all panels have equal aspect and need less.
    pub width: f64,
    /// Height of the area between the axes of a panel, px; by default it depends on the number of rows.
    pub panel_height: Option<f64>,
}

/// A pair of axes with its content.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Panel {
    /// Heading above the axes; empty for none.
    pub title: String,
    /// Quantity and unit along x, such as `time (s)`.
    pub x_label: String,
    /// Quantity and unit along y.
    pub y_label: String,
    /// A map below the curves.
    pub heat: Option<Heat>,
    /// The curves, drawn in this order.
    pub series: Vec<Series>,
    /// Marks in data coordinates.
    pub annotations: Vec<Annotation>,
    /// Ends of the x axis; by default all samples fit.
    pub x_range: Option<(f64, f64)>,
    /// Ends of the y axis; by default all samples fit.
    pub y_range: Option<(f64, f64)>,
    /// Whether a unit is equally long on both axes. The frame shrinks to the shape of the ranges. A range shorter than
    /// a quarter of the other range is widened, even if it is fixed.
    pub equal_aspect: bool,
    /// Position of the legend.
    pub legend: Legend,
    /// Scale of the x axis.
    pub x_scale: Scale,
    /// Scale of the y axis.
    pub y_scale: Scale,
    /// Height between the axes, px; by default the height of the figure.
    pub height: Option<f64>,
    /// A strip above the axes with states over time.
    pub strip: Option<Strip>,
    /// Panels of one group share crosshair and zoom on a live page. By default a panel is separate and cannot be
    /// zoomed.
    pub group: Option<String>,
}

/// The scale of an axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub enum Scale {
    /// Equal differences are equally long.
    #[default]
    Linear,
    /// Equal ratios are equally long. All values must be above zero.
    Log,
    /// Linear, and the values are seconds since 1970-01-01 UTC, written as dates and times.
    Clock,
    /// Linear, with these names for the whole numbers from 0 on.
    Names(&'static [&'static str]),
}

/// A thin strip above a pair of axes, with words for states over ranges of x.
#[derive(Debug, Clone, PartialEq)]
pub struct Strip {
    /// Name of the states, such as `mode`.
    pub name: String,
    /// The ranges.
    pub spans: Vec<Span>,
}

/// One range of a [`Strip`].
#[derive(Debug, Clone, PartialEq)]
pub struct Span {
    /// Where it begins.
    pub from: f64,
    /// Where it ends.
    pub to: f64,
    /// The state. It is left out if there is no room.
    pub word: String,
    /// How dark it is, from 0 to 1.
    pub shade: f64,
}

/// One curve or cloud of points.
#[derive(Debug, Clone, PartialEq)]
pub struct Series {
    /// Name in the legend; a series without one is not listed.
    pub label: String,
    /// Abscissae.
    pub x: Vec<f64>,
    /// Ordinates, as many as there are abscissae.
    pub y: Vec<f64>,
    /// Style of the connection between samples.
    pub style: Style,
    /// Index into the palette, see [`colour`]; by default the place of the series in its panel.
    pub colour: Option<usize>,
    /// Indices of samples that are not joined to the previous sample, ascending.
    pub breaks: Vec<usize>,
    /// A third quantity, which a live page shows for the sample under the pointer.
    pub along: Option<Along>,
}

/// A quantity along a series that is on neither axis, such as time on a map.
#[derive(Debug, Clone, PartialEq)]
pub struct Along {
    /// Quantity and unit, such as `time (s)`.
    pub label: String,
    /// Scale of its values.
    pub scale: Scale,
    /// A value for each sample.
    pub values: Vec<f64>,
}

/// The style of a series.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Style {
    /// Straight strokes. The first such series of a panel is solid. The next ones have dash patterns that no other
    /// series of the panel uses.
    Line,
    /// Straight strokes, dashed.
    Dashed,
    /// Straight strokes, dotted.
    Dotted,
    /// Each sample is held until the next, as by a digital controller. Dash patterns as for
    /// [`Style::Line`].
    Steps,
    /// A marker for each sample. Each series of markers has a different shape.
    Points,
    /// A bar from zero for each sample, as in a histogram, as wide as the distance of samples.
    Bars,
}

/// The position of a panel's legend. In a chosen corner it may cover data.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub enum Legend {
    /// In a corner without data and annotations, else above the axes. Shown only if two series have labels.
    #[default]
    Auto,
    /// In the upper left corner.
    TopLeft,
    /// In the upper right corner.
    TopRight,
    /// In the lower left corner.
    BottomLeft,
    /// In the lower right corner.
    BottomRight,
    /// Above the axes, outside.
    Above,
    /// Not shown.
    Hidden,
}

/// A mark in data coordinates. Texts may have several lines, separated by `\n`.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Annotation {
    /// A text centred on a point.
    Text {
        /// The text.
        text: String,
        /// Centre.
        at: (f64, f64),
    },
    /// A text with an arrow.
    Arrow {
        /// The text; empty for a bare arrow.
        text: String,
        /// Centre of the text, where the arrow starts.
        from: (f64, f64),
        /// What the arrow points at.
        to: (f64, f64),
    },
    /// A reference line across the panel.
    HorizontalLine {
        /// Height.
        y: f64,
        /// Name; empty for none.
        label: String,
    },
    /// A reference line from bottom to top.
    VerticalLine {
        /// Place.
        x: f64,
        /// Name; empty for none.
        label: String,
    },
    /// A shaded range of x.
    XBand {
        /// One end.
        from: f64,
        /// The other end.
        to: f64,
        /// Name; empty for none.
        label: String,
    },
    /// A double-headed arrow that measures the distance between two points, as in an
    /// engineering drawing.
    Dimension {
        /// One end.
        from: (f64, f64),
        /// The other end.
        to: (f64, f64),
        /// Name of the distance.
        label: String,
        /// Distance of the arrow from the points, px, upwards (to the right if the arrow is vertical) if positive.
        /// Thin extension lines lead from the points to the arrow, and the label is on its far side.
        offset: f64,
    },
}

impl Figure {
    /// A figure without panels, 800 px wide, one panel in a row.
    pub fn new(title: impl Into<String>) -> Self {
        Self {
            title: title.into(),
            caption: String::new(),
            panels: Vec::new(),
            columns: 1,
            width: 800.0,
            panel_height: None,
        }
    }

    crate::setters! {
        /// Sets the caption.
        fn caption(caption: impl Into<String>) => caption = caption.into();
        /// Adds a panel.
        fn with(panel: Panel) => panels.push(panel);
        /// Sets the number of panels side by side.
        fn columns(columns: usize) => columns = columns;
        /// Sets the width, px.
        fn width(width: f64) => width = width;
        /// Sets the height between the axes of every panel, px.
        fn panel_height(height: f64) => panel_height = Some(height);
    }

    /// The picture as an SVG document, fit for a file and for pasting into HTML.
    ///
    /// Text stays text, in the reader's sans-serif font. Equal figures give equal bytes.
    ///
    /// # Errors
    /// If the figure is malformed; see [`Error`].
    pub fn svg(&self) -> Result<String, Error> {
        self.check()?;
        Ok(self.document(&Sheet::new(self), Place::File))
    }

    /// The picture as an SVG with what a script needs to read values from it and to zoom.
    ///
    /// `id` is its name, which must be unique on the page. Without the script the SVG shows what [`Figure::svg`]
    /// shows.
    ///
    /// # Errors
    /// If the figure is malformed; see [`Error`].
    pub fn live(&self, id: &str) -> Result<Live, Error> {
        self.check()?;
        let sheet = Sheet::new(self);
        Ok(Live { svg: self.document(&sheet, Place::Live(id)), data: live::data(self, &sheet) })
    }

    /// The id that the caption of a picture must have on a page, for its name `id`. It describes the picture to readers
    /// who cannot see it.
    pub fn caption_id(id: &str) -> String {
        caption_id(id)
    }

    /// The picture as an SVG on a page with other pictures, without data for a script.
    ///
    /// `id` is its name, which must be unique on the page.
    ///
    /// # Errors
    /// If the figure is malformed; see [`Error`].
    pub fn still(&self, id: &str) -> Result<String, Error> {
        self.check()?;
        Ok(self.document(&Sheet::new(self), Place::Still(id)))
    }

    /// The picture as a PNG file with two pixels per px and a bundled font.
    ///
    /// Equal figures give equal bytes.
    ///
    /// # Errors
    /// If the figure is malformed; see [`Error`].
    pub fn png(&self) -> Result<Vec<u8>, Error> {
        self.check()?;
        paint(self, &Sheet::new(self), Pixels::new).into_png()
    }

    /// The picture as SVG.
    fn document(&self, sheet: &Sheet, place: Place<'_>) -> String {
        let surface = |width, height| Svg::new(width, height, place);
        paint(self, sheet, surface).into_document(&self.title, &self.caption)
    }

    /// Checks that the figure can be drawn. All later functions rely on this.
    ///
    /// # Errors
    /// If the figure is malformed; see [`Error`].
    pub fn check(&self) -> Result<(), Error> {
        if self.panels.is_empty() {
            return Err(Error::NoPanels { figure: self.title.clone() });
        }
        let size = |name, value: f64, from: f64, to: f64, allowed| {
            if (from..=to).contains(&value) {
                Ok(())
            } else {
                Err(Error::Size { name, value, allowed })
            }
        };
        size("columns", self.columns as f64, 1.0, 12.0, "1 to 12")?;
        size("width", self.width, 200.0, 4000.0, "200 to 4000 px")?;
        if let Some(height) = self.panel_height {
            size("panel_height", height, 40.0, 2000.0, "40 to 2000 px")?;
        }
        for height in self.panels.iter().filter_map(|panel| panel.height) {
            size("height of a panel", height, 40.0, 2000.0, "40 to 2000 px")?;
        }
        self.panels.iter().enumerate().try_for_each(|(index, panel)| panel.check(index))
    }
}

impl Panel {
    /// An empty panel; labels carry the unit, such as `time (s)`.
    pub fn new(x_label: impl Into<String>, y_label: impl Into<String>) -> Self {
        Self { x_label: x_label.into(), y_label: y_label.into(), ..Self::default() }
    }

    crate::setters! {
        /// Sets the heading.
        fn title(title: impl Into<String>) => title = title.into();
        /// Puts a map below the curves. The axes end at its edges.
        fn heat(heat: Heat) => heat = Some(heat);
        /// Adds a series.
        fn with(series: Series) => series.push(series);
        /// Adds an annotation.
        fn note(annotation: Annotation) => annotations.push(annotation);
        /// Fixes the ends of the x axis.
        fn x_range(from: f64, to: f64) => x_range = Some((from, to));
        /// Fixes the ends of the y axis.
        fn y_range(from: f64, to: f64) => y_range = Some((from, to));
        /// Makes a unit equally long on both axes.
        fn equal_aspect() => equal_aspect = true;
        /// Sets the position of the legend.
        fn legend(legend: Legend) => legend = legend;
        /// Sets the scale of the x axis.
        fn x_scale(scale: Scale) => x_scale = scale;
        /// Sets the scale of the y axis.
        fn y_scale(scale: Scale) => y_scale = scale;
        /// Sets the height between the axes, px.
        fn height(height: f64) => height = Some(height);
        /// Puts a strip above the axes.
        fn strip(strip: Strip) => strip = Some(strip);
        /// Links crosshair and zoom with all panels of the group.
        fn group(group: impl Into<String>) => group = Some(group.into());
    }

    fn check(&self, panel: usize) -> Result<(), Error> {
        if self.series.is_empty() && self.heat.is_none() {
            return Err(Error::NoSeries { panel });
        }
        if let Some(heat) = &self.heat {
            heat.check().map_err(|problem| Error::Heat { panel, problem })?;
        }
        for series in &self.series {
            series.check(panel, self.x_scale, self.y_scale)?;
        }
        for (index, annotation) in self.annotations.iter().enumerate() {
            if let Some(value) = annotation.coordinates().into_iter().find(|v| !drawable(*v)) {
                return Err(Error::Annotation { panel, index, value });
            }
        }
        let spans = self.strip.iter().flat_map(|strip| &strip.spans);
        for (index, span) in spans.enumerate() {
            if let Some(value) = [span.from, span.to].into_iter().find(|v| !drawable(*v)) {
                return Err(Error::Annotation { panel, index, value });
            }
        }
        for (axis, range, scale) in
            [('x', self.x_range, self.x_scale), ('y', self.y_range, self.y_scale)]
        {
            if let Some((from, to)) = range {
                let sound = drawable(from)
                    && drawable(to)
                    && from < to
                    && !axis::is_constant(from, to)
                    && (scale != Scale::Log || from > 0.0);
                if !sound {
                    return Err(Error::Range { panel, axis, from, to });
                }
            }
        }
        Ok(())
    }
}

/// A constructor for each style.
macro_rules! styles {
    ($($(#[$about:meta])* $name:ident $style:ident;)+) => {$(
        $(#[$about])*
        pub fn $name(
            label: impl Into<String>,
            x: impl Into<Vec<f64>>,
            y: impl Into<Vec<f64>>,
        ) -> Self {
            Self::new(Style::$style, label, x, y)
        }
    )+};
}

impl Series {
    /// A series in the given style.
    pub fn new(
        style: Style,
        label: impl Into<String>,
        x: impl Into<Vec<f64>>,
        y: impl Into<Vec<f64>>,
    ) -> Self {
        Self {
            label: label.into(),
            x: x.into(),
            y: y.into(),
            style,
            colour: None,
            breaks: Vec::new(),
            along: None,
        }
    }

    styles! {
        /// Samples joined by straight strokes.
        line Line;
        /// Samples joined by dashed strokes.
        dashed Dashed;
        /// Samples joined by dotted strokes.
        dotted Dotted;
        /// Samples held until the next.
        steps Steps;
        /// Samples as markers.
        points Points;
        /// Samples as bars from zero.
        bars Bars;
    }

    crate::setters! {
        /// Sets the palette index, see [`colour`].
        fn colour(index: usize) => colour = Some(index);
        /// Interrupts the line before the samples of these indices, which ascend.
        fn breaks(indices: impl Into<Vec<usize>>) => breaks = indices.into();
        /// Adds a third quantity, shown for the sample under the pointer.
        fn along(along: Along) => along = Some(along);
    }

    fn check(&self, panel: usize, x_scale: Scale, y_scale: Scale) -> Result<(), Error> {
        let series = || self.label.clone();
        if self.x.len() != self.y.len() {
            let (x, y) = (self.x.len(), self.y.len());
            return Err(Error::Length { panel, series: series(), x, y });
        }
        if self.x.is_empty() {
            return Err(Error::NoSamples { panel, series: series() });
        }
        if let Some(along) = &self.along
            && along.values.len() != self.x.len()
        {
            let (x, y) = (self.x.len(), along.values.len());
            return Err(Error::Length { panel, series: series(), x, y });
        }
        let third = self.along.iter().map(|along| ('t', &along.values, along.scale));
        let axes = [('x', &self.x, x_scale), ('y', &self.y, y_scale)];
        for (axis, values, scale) in axes.into_iter().chain(third) {
            let placed = |v: f64| drawable(v) && (scale != Scale::Log || v > 0.0);
            if let Some(index) = values.iter().position(|v| !placed(*v)) {
                let value = values[index];
                return Err(Error::Sample { panel, series: series(), axis, index, value });
            }
        }
        Ok(())
    }

    /// Whether x never decreases, as in a time trend.
    fn is_trend(&self) -> bool {
        self.x.is_sorted()
    }
}

impl Annotation {
    /// A text centred on a point.
    pub fn text(text: impl Into<String>, at: (f64, f64)) -> Self {
        Self::Text { text: text.into(), at }
    }

    /// A text centred on `from`, with an arrow to `to`.
    pub fn arrow(text: impl Into<String>, from: (f64, f64), to: (f64, f64)) -> Self {
        Self::Arrow { text: text.into(), from, to }
    }

    /// A named reference line across the panel.
    pub fn horizontal_line(y: f64, label: impl Into<String>) -> Self {
        Self::HorizontalLine { y, label: label.into() }
    }

    /// A named reference line from bottom to top.
    pub fn vertical_line(x: f64, label: impl Into<String>) -> Self {
        Self::VerticalLine { x, label: label.into() }
    }

    /// A named, shaded range of x.
    pub fn x_band(from: f64, to: f64, label: impl Into<String>) -> Self {
        Self::XBand { from, to, label: label.into() }
    }

    /// A double-headed dimension arrow at `offset` px from the points that it measures; see
    /// [`Annotation::Dimension`].
    pub fn dimension(
        from: (f64, f64),
        to: (f64, f64),
        label: impl Into<String>,
        offset: f64,
    ) -> Self {
        Self::Dimension { from, to, label: label.into(), offset }
    }

    /// Every number that must be drawable.
    fn coordinates(&self) -> Vec<f64> {
        match *self {
            Self::Text { at, .. } => vec![at.0, at.1],
            Self::Arrow { from, to, .. } => vec![from.0, from.1, to.0, to.1],
            Self::HorizontalLine { y, .. } => vec![y],
            Self::VerticalLine { x, .. } => vec![x],
            Self::XBand { from, to, .. } => vec![from, to],
            Self::Dimension { from, to, offset, .. } => {
                vec![from.0, from.1, to.0, to.1, offset]
            }
        }
    }
}

/// Whether a number can be drawn.
fn drawable(value: f64) -> bool {
    value.abs() <= LARGEST
}
