//! Data for a script that reads values from a picture and zooms: frames, axes and samples, as JSON.
//!
//! Numbers are written compactly. A list of values is `{"from", "step", "d"}`, where value `i` is
//! `from + step * (d[0] + ... + d[i])` with whole `d`. The step is 1/1,000 to 1/10,000 of the range of the list. Equally
//! spaced values have their distance as step, and `n`, their number, instead of `d`. Without a step all values are
//! `from`. On logarithmic axes the list contains the decimal logarithms, as its scale shows.

use std::fmt::Write;

use super::axis::{self, Axis};
use super::geometry::Point;
use super::layout::{Cell, Sheet};
use super::palette::Look;
use super::{Figure, Panel, Scale, Series, Style, reduce};

/// Maximum number of samples of a series that are all readable.
const MOST: usize = 1_000;
/// This number for an equally spaced series, whose x values take no room.
const MOST_SPACED: usize = 3_000;
/// Finest detail of a longer trend, px.
const COLUMN: f64 = 1.0;

/// A picture with the data for a script.
#[derive(Debug, Clone, PartialEq)]
pub struct Live {
    /// The picture.
    pub svg: String,
    /// Frames, axes and samples as JSON for a `script` element. Long series are reduced, but their extremes are kept.
    pub data: String,
}

/// The data of a checked figure.
pub(super) fn data(figure: &Figure, sheet: &Sheet) -> String {
    let panels =
        figure.panels.iter().zip(&sheet.cells).map(|(panel, cell)| panel_data(panel, cell));
    format!("{{\"panels\":[{}]}}", panels.collect::<Vec<_>>().join(","))
}

fn panel_data(panel: &Panel, cell: &Cell) -> String {
    let frame = &cell.view.frame;
    let series: Vec<String> = panel
        .series
        .iter()
        .zip(&cell.looks)
        .map(|(s, look)| series_data(s, look, panel, cell))
        .collect();
    let spans: Vec<String> = panel
        .strip
        .iter()
        .flat_map(|strip| &strip.spans)
        .map(|span| format!("[{:e},{:e},{}]", span.from, span.to, text(&span.word)))
        .collect();
    format!(
        "{{\"frame\":[{:.1},{:.1},{:.1},{:.1}],\"x\":{},\"y\":{},\"group\":{},\"lettered\":{},\
         \"strip\":{},\"base\":{:.1},\"spans\":[{}],\"series\":[{}]}}",
        frame.x,
        frame.y,
        frame.w,
        frame.h,
        axis_data(&cell.view.x, &panel.x_label),
        axis_data(&cell.view.y, &panel.y_label),
        panel.group.as_deref().map_or("null".to_owned(), text),
        cell.lettered,
        panel.strip.as_ref().map_or("null".to_owned(), |strip| text(&strip.name)),
        cell.strip_base(),
        spans.join(","),
        series.join(",")
    )
}

fn axis_data(axis: &Axis, label: &str) -> String {
    format!("{{\"lo\":{:e},\"hi\":{:e},{}}}", axis.lo, axis.hi, quantity_data(label, axis.scale))
}

/// The name of a quantity, and the scale of its values.
fn quantity_data(label: &str, scale: Scale) -> String {
    let (kind, names) = match scale {
        Scale::Linear => ("linear", None),
        Scale::Log => ("log", None),
        Scale::Clock => ("clock", None),
        Scale::Names(names) => ("linear", Some(names)),
    };
    let (name, unit) = quantity(label);
    let names = names.map_or(String::new(), |names| {
        let names: Vec<String> = names.iter().map(|name| text(name)).collect();
        format!(",\"names\":[{}]", names.join(","))
    });
    format!("\"scale\":\"{kind}\",\"name\":{},\"unit\":{}{names}", text(name), text(unit))
}

fn series_data(series: &Series, look: &Look, panel: &Panel, cell: &Cell) -> String {
    let name = if series.label.trim().is_empty() {
        quantity(&panel.y_label).0
    } else {
        series.label.as_str()
    };
    let kind = match series.style {
        Style::Points => "points",
        _ if series.is_trend() => "trend",
        _ => "map",
    };
    let kept = kept(series, cell);
    let (r, g, b) = look.colour;
    let along = series.along.as_ref().map_or(String::new(), |along| {
        let values = packed(&along.values, &kept, along.scale);
        format!(",\"along\":{{{},\"values\":{values}}}", quantity_data(&along.label, along.scale))
    });
    format!(
        "{{\"name\":{},\"kind\":\"{kind}\",\"colour\":\"#{r:02x}{g:02x}{b:02x}\",\"x\":{},\"y\":{}{along}}}",
        text(name),
        packed(&series.x, &kept, panel.x_scale),
        packed(&series.y, &kept, panel.y_scale)
    )
}

/// Indices of the samples that can be read.
fn kept(series: &Series, cell: &Cell) -> Vec<usize> {
    let count = series.x.len();
    let most = if distance(&series.x).is_some() { MOST_SPACED } else { MOST };
    if count <= most {
        return (0..count).collect();
    }
    if series.is_trend() {
        let points = series.x.iter().zip(&series.y).map(|(&x, &y)| cell.view.place((x, y)));
        return reduce::seen(&points.collect::<Vec<Point>>(), &cell.view.frame, COLUMN);
    }
    (0..count).step_by(count.div_ceil(MOST)).collect()
}

/// Name and unit of a label such as `time (s)`.
fn quantity(label: &str) -> (&str, &str) {
    match label.rsplit_once('(') {
        Some((name, unit)) if unit.ends_with(')') => (name.trim(), &unit[..unit.len() - 1]),
        _ => (label.trim(), ""),
    }
}

/// The values at some indices, in the format described at the top of this file.
fn packed(values: &[f64], indices: &[usize], scale: Scale) -> String {
    let logarithms: Vec<f64>;
    let values = if scale == Scale::Log {
        logarithms = values.iter().map(|v| axis::logarithm(*v)).collect();
        &logarithms
    } else {
        values
    };
    let (from, step, whole): (f64, f64, Vec<i64>) = match distance(values) {
        Some(step) => (values[0], step, indices.iter().map(|&i| i as i64).collect()),
        None => {
            let (lo, hi) = axis::extent(values.iter().copied());
            let span = if axis::is_constant(lo, hi) { lo.abs().max(hi.abs()) } else { hi - lo };
            let power = if span > 0.0 { span.log10().floor() as i32 - 3 } else { 0 };
            let step = 10f64.powi(power.clamp(-300, 300));
            (0.0, step, indices.iter().map(|&i| (values[i] / step).round() as i64).collect())
        }
    };
    if let [first, others @ ..] = &whole[..]
        && *first != 0
        && others.iter().all(|value| value == first)
    {
        return format!("{{\"from\":{:e},\"step\":null,\"n\":{}}}", values[0], whole.len());
    }
    if whole.iter().enumerate().all(|(i, value)| *value == i as i64) {
        return format!("{{\"from\":{from:e},\"step\":{step:e},\"n\":{}}}", whole.len());
    }
    // Values recorded with fewer digits are written with fewer.
    let (whole, step) = match distance(values) {
        None => coarser(whole, step),
        Some(_) => (whole, step),
    };
    let mut list = String::new();
    let mut last = 0;
    for (i, &value) in whole.iter().enumerate() {
        let comma = if i > 0 { "," } else { "" };
        // Writing to a string cannot fail.
        let _ = write!(list, "{comma}{}", value.saturating_sub(last));
        last = value;
    }
    format!("{{\"from\":{from:e},\"step\":{step:e},\"d\":[{list}]}}")
}

/// These values in steps of the largest power of ten that divides them.
fn coarser(mut whole: Vec<i64>, mut step: f64) -> (Vec<i64>, f64) {
    while whole.iter().any(|v| *v != 0) && whole.iter().all(|v| v % 10 == 0) {
        whole.iter_mut().for_each(|v| *v /= 10);
        step *= 10.0;
    }
    (whole, step)
}

/// The distance of neighbours if they are equally spaced and not equal.
fn distance(values: &[f64]) -> Option<f64> {
    let [first, .., last] = values else { return None };
    let step = (last - first) / (values.len() - 1) as f64;
    let place = |i: usize| first + i as f64 * step;
    let regular = values.iter().enumerate().all(|(i, v)| (v - place(i)).abs() <= 1e-6 * step.abs());
    (step != 0.0 && step.is_finite() && regular).then_some(step)
}

/// A JSON string that cannot end a `script` element.
fn text(content: &str) -> String {
    let mut quoted = String::from("\"");
    for c in content.chars() {
        match c {
            '"' | '\\' => quoted.extend(['\\', c]),
            '<' | '>' | '&' | '\u{2028}' | '\u{2029}' => {
                let _ = write!(quoted, "\\u{:04x}", c as u32);
            }
            c if c.is_control() => quoted.push(' '),
            c => quoted.push(c),
        }
    }
    quoted.push('"');
    quoted
}

#[cfg(test)]
mod tests {
    use super::*;

    fn all(values: &[f64]) -> String {
        packed(values, &(0..values.len()).collect::<Vec<_>>(), Scale::Linear)
    }

    #[test]
    fn lists_are_short() {
        assert_eq!(all(&[0.5, 1.0, 1.5]), r#"{"from":5e-1,"step":5e-1,"n":3}"#);
        assert_eq!(
            all(&[50.0, 53.217, 50.5]),
            r#"{"from":0e0,"step":1e-3,"d":[50000,3217,-2717]}"#
        );
        assert_eq!(all(&[50.0, 53.2, 50.5]), r#"{"from":0e0,"step":1e-1,"d":[500,32,-27]}"#);
        assert_eq!(all(&[60.0, 60.0]), r#"{"from":6e1,"step":null,"n":2}"#);
        assert_eq!(all(&[0.0, 0.0]), r#"{"from":0e0,"step":1e0,"d":[0,0]}"#);
    }

    #[test]
    fn labels_have_units() {
        assert_eq!(quantity("PV (m³/h)"), ("PV", "m³/h"));
        assert_eq!(quantity("OP, VP (% of span)"), ("OP, VP", "% of span"));
        assert_eq!(quantity("share"), ("share", ""));
    }

    #[test]
    fn texts_cannot_leave_the_script() {
        assert_eq!(text("a</script>\"\\\u{0}"), r#""a\u003c/script\u003e\"\\ ""#);
    }
}
