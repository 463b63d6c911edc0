//! Pictures of limit cycles, of one over time, and maps over two parameters.

use super::run::{pv_panel, valve_panel};
use crate::error::Result;
use crate::limit_cycle::exact::Trajectory;
use crate::limit_cycle::map::{Axis, Map, Parameter};
use crate::limit_cycle::{ContinuousLoop, Cycle, Swing};
use stiction_figure::figure::{Figure, Heat, Panel, Scale, Series, Tile, colour};

/// Two periods of an exact cycle, with set point and PV above OP and VP.
pub fn over_time(title: &str, cycle: &Cycle, orbit: &Trajectory, set_point: f64) -> Figure {
    let twice = |values: &[f64], later: f64| -> Vec<f64> {
        values.iter().copied().chain(values.iter().map(|value| value + later)).collect()
    };
    let t = twice(&orbit.time_s, cycle.period_s);
    let [op, vp, pv] = [&orbit.op, &orbit.vp, &orbit.pv].map(|values| twice(values, 0.0));
    let sp = vec![set_point; t.len()];
    let caption = format!(
        "The exact limit cycle over two periods of {:.4} s, beginning with a slip. Half peak to peak: OP {:.4} %, VP \
         {:.4} %, PV {:.4} in PV units.",
        cycle.period_s, cycle.half_pp.op, cycle.half_pp.vp, cycle.half_pp.pv
    );
    Figure::new(title)
        .caption(caption)
        .with(pv_panel(&t, &sp, &pv, "PV, SP (PV units)"))
        .with(valve_panel(&t, &op, &vp))
}

/// The quantity that a map shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantity {
    /// The period.
    Period,
    /// Half peak-to-peak value of the OP.
    Op,
    /// Half peak-to-peak value of the VP.
    Vp,
    /// Half peak-to-peak value of the PV.
    Pv,
}

impl Quantity {
    /// Name and unit.
    pub fn label(self) -> &'static str {
        match self {
            Self::Period => "period (s)",
            Self::Op => "half peak-to-peak OP (% of span)",
            Self::Vp => "half peak-to-peak VP (% of span)",
            Self::Pv => "half peak-to-peak PV (PV units)",
        }
    }

    /// Value for a cycle with this period, s, and these half peak-to-peak values.
    fn of(self, (period_s, half_pp): (f64, Swing)) -> f64 {
        match self {
            Self::Period => period_s,
            Self::Op => half_pp.op,
            Self::Vp => half_pp.vp,
            Self::Pv => half_pp.pv,
        }
    }
}

/// A map in colours, with the boundary beyond which the loop does not cycle. Unknown places are marked.
///
/// The colours are logarithmic if the largest value is more than 20 times the smallest. The present loop is marked.
/// Over S and J the line J = S is drawn, where a valve sticks without a dead band.
///
/// # Errors
/// If the values of an axis are too close to each other.
pub fn map(title: &str, map: &Map, present: &ContinuousLoop, quantity: Quantity) -> Result<Figure> {
    let (mut x, mut y) = (order(&map.x), order(&map.y));
    x.dedup_by_key(|k| map.x.values[*k]);
    y.dedup_by_key(|k| map.y.values[*k]);
    let tile = |column: usize, row: usize| match map.at(column, row) {
        Some(crate::limit_cycle::map::Point::NoCycle { .. }) => Tile::Empty,
        Some(point) => point.cycle().map_or(Tile::Unknown, |cycle| Tile::Value(quantity.of(cycle))),
        None => Tile::Unknown,
    };
    let tiles: Vec<Tile> =
        y.iter().flat_map(|row| x.iter().map(move |column| tile(*column, *row))).collect();
    let (mut low, mut high) = (f64::INFINITY, 0f64);
    for tile in &tiles {
        if let Tile::Value(value) = tile {
            (low, high) = (low.min(*value), high.max(*value));
        }
    }
    let heat = Heat {
        label: quantity.label().to_owned(),
        x: x.iter().map(|k| map.x.values[*k]).collect(),
        y: y.iter().map(|k| map.y.values[*k]).collect(),
        tiles,
        scale: if low > 0.0 && high > 20.0 * low { Scale::Log } else { Scale::Linear },
        empty: "no cycle".to_owned(),
        unknown: "unknown".to_owned(),
    };
    let mut panel = Panel::new(map.x.parameter.label(), map.y.parameter.label()).heat(heat);
    let boundary = map.boundary();
    if !boundary.is_empty() {
        let (x, y): (Vec<f64>, Vec<f64>) = boundary.iter().flatten().copied().unzip();
        let breaks: Vec<usize> = (2..x.len()).step_by(2).collect();
        panel = panel.with(Series::line("", x, y).colour(colour::BLACK).breaks(breaks));
    }
    let (over, up) = (map.x.parameter, map.y.parameter);
    let ends = |axis: &Axis| {
        axis.values
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(*v), high.max(*v)))
    };
    let ((left, right), (bottom, top)) = (ends(&map.x), ends(&map.y));
    let (from, to) = (left.max(bottom), right.min(top));
    let mut told = String::new();
    if matches!((over, up), (Parameter::S, Parameter::J) | (Parameter::J, Parameter::S))
        && from < to
    {
        panel = panel.with(Series::dashed("J = S", [from, to], [from, to]).colour(colour::BLACK));
        told += " Dashed: J = S.";
    }
    if let (Some(x), Some(y)) = (over.of(present), up.of(present))
        && (left..=right).contains(&x)
        && (bottom..=top).contains(&y)
    {
        panel = panel.with(Series::points("present loop", [x], [y]).colour(colour::VERMILION));
        told += " The point marks the present loop.";
    }
    // Its unit is at the colour bar.
    let what = quantity.label().split(" (").next().unwrap_or_default();
    let title = match title {
        "" => format!("{what} of the limit cycle"),
        title => format!("{title}: {what} of the limit cycle"),
    };
    let caption = format!(
        "{} of the final limit cycle of the loop over {} and {}, by the {} method.{told}",
        quantity.label(),
        map.x.parameter.name(),
        map.y.parameter.name(),
        map.method.name()
    );
    Ok(Figure::new(title).caption(caption).panel_height(420.0).with(panel))
}

/// The places of the values of an axis, ascending.
fn order(axis: &Axis) -> Vec<usize> {
    let mut order: Vec<usize> = (0..axis.values.len()).collect();
    order.sort_by(|a, b| axis.values[*a].total_cmp(&axis.values[*b]));
    order
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Bands;
    use crate::closed_loop::{Controller, Process};
    use crate::limit_cycle::map::{Parameter, Point};
    use crate::limit_cycle::{Method, exact};
    use crate::valve::Model;

    fn paper() -> ContinuousLoop {
        let controller = Controller::pi(1.1, 2.5).unwrap();
        let process = Process::first_order(1.5, 5.93, 1.07).unwrap();
        let bands = Bands::from_s_j(5.0, 3.0).unwrap();
        ContinuousLoop::new(controller, process, Model::TwoPhase, bands)
    }

    fn of(j: (f64, f64)) -> Map {
        let x = Axis::even(Parameter::S, 1.0, 9.0, 5).unwrap();
        let y = Axis::even(Parameter::J, j.0, j.1, 4).unwrap();
        Map::of(&paper(), x, y, Method::Exact).unwrap()
    }

    #[test]
    fn a_cycle_is_drawn_over_two_periods() {
        let (cycle, orbit) = exact::trajectory(&paper(), 100).unwrap().unwrap();
        let figure = over_time("Cycle", &cycle, &orbit, 0.0);
        let times = &figure.panels[0].series[0].x;
        assert!(times.is_sorted());
        assert!((times[times.len() - 1] / cycle.period_s - 2.0).abs() < 1e-9);
        let svg = figure.svg().unwrap();
        assert!(svg.contains("18.0437 s") && svg.contains("OP, VP (% of span)"));
    }

    #[test]
    fn a_map_tells_its_axes_its_colours_and_where_there_is_no_cycle() {
        let svg = map("Map", &of((0.0, 6.0)), &paper(), Quantity::Period).unwrap().svg().unwrap();
        for wanted in [
            "S (%)",
            "J (%)",
            "Map: period of the limit cycle",
            "period (s)",
            "no cycle",
            "J = S",
            "present loop",
        ] {
            assert!(svg.contains(wanted), "{wanted}");
        }
        assert!(!svg.contains("unknown"));
    }

    #[test]
    fn axes_may_descend_and_points_may_be_unknown() {
        let mut descending = of((6.0, 0.0));
        let figure = |map: &Map| super::map("", map, &paper(), Quantity::Pv).unwrap();
        assert_eq!(figure(&of((0.0, 6.0))).panels[0].heat, figure(&descending).panels[0].heat);
        descending.points[0] = Point::Unknown { reason: "test".to_owned() };
        assert!(figure(&descending).svg().unwrap().contains("unknown"));
    }

    #[test]
    fn maps_without_any_cycle_are_drawn_too() {
        for quantity in [Quantity::Period, Quantity::Op, Quantity::Vp, Quantity::Pv] {
            let mut none = of((0.0, 6.0));
            none.points.fill(Point::NoCycle { reason: "test".to_owned() });
            let svg = map("", &none, &paper(), quantity).unwrap().svg().unwrap();
            assert!(svg.contains("no cycle"));
        }
    }
}
