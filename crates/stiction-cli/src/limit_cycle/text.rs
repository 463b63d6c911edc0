//! Cycles in words.

use super::Report;
use crate::text::{self, paragraph};
use stiction::closed_loop::Process;
use stiction::limit_cycle::map::{Map, Point, Sensitivity};
use stiction::limit_cycle::tuning::{Assessment, Retuning, Tuning};
use stiction::limit_cycle::{ContinuousLoop, Cycle, Found, Method, State, Swing};

/// The process and the rest of a loop, in words.
fn description(l: &ContinuousLoop) -> String {
    let Tuning { kc, ti, td } = Tuning::of(&l.controller);
    let ti = ti.map_or(String::new(), |ti| format!(", Ti {} s", text::number(ti)));
    let td = if td == 0.0 { String::new() } else { format!(", Td {} s", text::number(td)) };
    format!(
        "process {}; controller Kc {}{ti}{td}; valve {}, S {} %, J {} %",
        process(&l.process),
        text::number(kc),
        l.model.describe().name,
        text::number(l.bands.s()),
        text::number(l.bands.j()),
    )
}

impl Report {
    /// All results as text.
    pub fn text(&self, l: &ContinuousLoop, all: bool) -> String {
        let mut out = format!("{}\n{}\n\n", self.title, description(l));
        out += &if all { every(&self.found) } else { side_by_side(&self.found) };
        for end in &self.found {
            let notes = end.notes.join("; ");
            let name = end.method.name();
            out += &match end.state {
                State::Cycle if notes.is_empty() => String::new(),
                State::Cycle => paragraph(&format!("Other motions ({name}): {notes}.")),
                State::NoCycle => paragraph(&format!("No cycle ({name}): {notes}.")),
                State::Unknown => paragraph(&format!("Unknown ({name}): {notes}.")),
            };
        }
        out += &missed(&self.found);
        if let Some(found) = &self.sensitivities {
            out += &sensitivity_text(found);
        }
        if let Some(retuning) = &self.retuning {
            out += &retuning_text(retuning, l);
        }
        if let Some(map) = &self.map {
            out += &map_text(map);
        }
        out
    }
}

/// A transfer function in the Laplace variable s.
fn process(process: &Process) -> String {
    let (num, den) = process.coefficients();
    let polynomial = |coefficients: &[f64]| {
        let degree = coefficients.len() - 1;
        let mut sum = String::new();
        for (k, c) in coefficients.iter().enumerate().filter(|(_, c)| **c != 0.0) {
            let power = match degree - k {
                0 => String::new(),
                1 => " s".to_owned(),
                n => format!(" s^{n}"),
            };
            let size = text::number(c.abs());
            let term = if size == "1" && !power.is_empty() {
                power.trim_start().to_owned()
            } else {
                size + &power
            };
            sum += match (sum.is_empty(), *c < 0.0) {
                (true, true) => "-",
                (true, false) => "",
                (false, true) => " - ",
                (false, false) => " + ",
            };
            sum += &term;
        }
        let several = coefficients.iter().filter(|c| **c != 0.0).count() > 1;
        if several { format!("({sum})") } else { sum }
    };
    let delay = match process.dead_time() {
        0.0 => String::new(),
        theta => format!(" exp(-{} s)", text::number(theta)),
    };
    format!("{}{delay} / {}", polynomial(&num), polynomial(&den))
}

/// Six digits.
fn digits(value: f64) -> String {
    if value == 0.0 || !(1e-4..1e7).contains(&value.abs()) {
        return text::number(value);
    }
    let decimals = (5.0 - value.abs().log10().floor()).clamp(0.0, 9.0) as usize;
    format!("{value:.decimals$}")
}

fn yes_no(value: bool) -> String {
    if value { "yes" } else { "no" }.to_owned()
}

/// The size of the largest multiplier, apart from the multiplier 1 of a family of cycles.
fn left_after_a_period(cycle: &Cycle) -> String {
    let mut multipliers = cycle.multipliers.iter().map(|m| m.norm());
    let is_family = |m: &f64| cycle.stable && (m - 1.0).abs() < 1e-7;
    multipliers.find(|m| !is_family(m)).map_or("-".to_owned(), |m| format!("{m:.4}"))
}

/// Quantity, unit, value.
type Line = (&'static str, &'static str, fn(&Cycle) -> f64);

const LINES: [Line; 4] = [
    ("period", " s", |c| c.period_s),
    ("half peak-to-peak OP", " %", |c| c.half_pp.op),
    ("half peak-to-peak VP", " %", |c| c.half_pp.vp),
    ("half peak-to-peak PV", "", |c| c.half_pp.pv),
];

/// The cycle by each method, and the error of the describing function.
fn side_by_side(ends: &[Found]) -> String {
    let found: Vec<(&Found, &Cycle)> =
        ends.iter().filter_map(|end| Some((end, end.cycles.first()?))).collect();
    if found.is_empty() {
        return String::new();
    }
    let both = found.len() == 2;
    let mut rows: Vec<Vec<String>> = vec![vec![String::new()]];
    rows[0].extend(found.iter().map(|(end, _)| end.method.name().to_owned()));
    if both {
        rows[0].push("error".to_owned());
    }
    for (name, unit, of) in LINES {
        let mut row = vec![name.to_owned()];
        row.extend(found.iter().map(|(_, cycle)| digits(of(cycle)) + unit));
        if let [(_, exact), (_, approximate)] = found[..] {
            row.push(format!("{:+.1} %", 100.0 * (of(approximate) / of(exact) - 1.0)));
        }
        rows.push(row);
    }
    let mut more = |name: &str, of: &dyn Fn(&Cycle) -> String| {
        let mut row = vec![name.to_owned()];
        row.extend(found.iter().map(|(_, cycle)| of(cycle)));
        row.resize(rows[0].len(), String::new());
        rows.push(row);
    };
    more("stable", &|cycle| yes_no(cycle.stable));
    more("slips per period", &|cycle| cycle.slips.to_string());
    more("deviation remaining after a period", &left_after_a_period);
    let mut right = vec![true; rows[0].len()];
    right[0] = false;
    text::columns(&rows, &right)
}

/// One row per cycle.
fn every(ends: &[Found]) -> String {
    let head = [
        "method",
        "period (s)",
        "OP (%)",
        "VP (%)",
        "PV",
        "stable",
        "slips",
        "left",
        "VP centre (%)",
    ];
    let mut rows = vec![head.map(str::to_owned)];
    for end in ends {
        for cycle in &end.cycles {
            rows.push([
                end.method.name().to_owned(),
                digits(cycle.period_s),
                digits(cycle.half_pp.op),
                digits(cycle.half_pp.vp),
                digits(cycle.half_pp.pv),
                yes_no(cycle.stable),
                cycle.slips.to_string(),
                left_after_a_period(cycle),
                digits(cycle.middle.vp),
            ]);
        }
    }
    if rows.len() == 1 {
        return String::new();
    }
    text::columns(&rows, &[false, true, true, true, true, true, true, true, true])
        + "Half peak-to-peak values. The column \"left\" is the share of a deviation that remains after a period.\n"
}

/// A warning if the describing function misses an existing cycle.
fn missed(ends: &[Found]) -> String {
    let of = |method| ends.iter().find(|end| end.method == method);
    match (of(Method::Exact), of(Method::DescribingFunction)) {
        (Some(exact), Some(approximate))
            if exact.state == State::Cycle && approximate.state == State::NoCycle =>
        {
            paragraph(
                "The describing function misses this cycle, which is far from a sine. A simulation shows it.",
            )
        }
        _ => String::new(),
    }
}

fn sensitivity_text(found: &[Sensitivity]) -> String {
    if found.is_empty() {
        return "\nNo cycle, so there are no sensitivities.\n".to_owned();
    }
    let head = ["percent per percent of", "value", "period", "OP", "VP", "PV"];
    let mut rows = vec![head.map(str::to_owned)];
    // Not -0.000.
    let slope = |value: f64| format!("{:+.3}", (value * 1e3).round() / 1e3 + 0.0);
    for each in found {
        let Swing { op, vp, pv } = each.half_pp;
        rows.push([
            each.parameter.name().to_owned(),
            format!("{} {}", text::number(each.value), each.parameter.unit()),
            slope(each.period),
            slope(op),
            slope(vp),
            slope(pv),
        ]);
    }
    format!("\n{}", text::columns(&rows, &[false, false, true, true, true, true]))
}

fn retuning_text(found: &Retuning, l: &ContinuousLoop) -> String {
    let number = |value: Option<f64>, unit: &str| {
        value.map_or("none".to_owned(), |value| text::number(value) + unit)
    };
    let mut rows = vec![["", "present", "retuned"].map(str::to_owned)];
    let mut row = |name: &str, of: &dyn Fn(&Assessment) -> String| {
        rows.push([name.to_owned(), of(&found.present), of(&found.best)]);
    };
    row("Kc", &|a| text::number(a.tuning.kc));
    row("Ti", &|a| number(a.tuning.ti, " s"));
    row("Ms", &|a| {
        if a.peak_sensitivity.is_finite() {
            text::number(a.peak_sensitivity)
        } else {
            "unstable".to_owned()
        }
    });
    row("period", &|a| number(a.cycle.as_ref().map(|c| c.period_s), " s"));
    row("half peak-to-peak OP", &|a| number(a.cycle.as_ref().map(|c| c.half_pp.op), " %"));
    row("half peak-to-peak PV", &|a| number(a.cycle.as_ref().map(|c| c.half_pp.pv), ""));
    row("IAE of a load step of 1 %", &|a| number(a.load_iae, " PV units x s"));
    let mut out = format!(
        "\nPI tuning with the smallest swing of the PV, Ms at most {}:\n{}",
        text::number(found.ms_bound),
        text::columns(&rows, &[false, true, true])
    );
    let mut said = match (&found.best.cycle, found.pv_ratio) {
        (None, Some(_)) => "With this tuning, the loop does not cycle".to_owned(),
        (_, Some(ratio)) => {
            format!(
                "With this tuning, the PV swing is {} times the present swing",
                text::number(ratio)
            )
        }
        (_, None) => "The loop does not cycle at present".to_owned(),
    };
    if let Some(ratio) = found.iae_ratio {
        said +=
            &format!("; the IAE of a load step is {} times the present IAE", text::number(ratio));
    }
    said += &format!(". {} tunings were within the bound of Ms", found.robust_tunings);
    if found.unjudged_tunings > 0 {
        said += &format!("; for {} the cycle could not be determined", found.unjudged_tunings);
    }
    said.push('.');
    if found.at_edge {
        said += " The best tuning lies at the limit of the search, a fifth to five times the present Kc and Ti. \
            A better tuning may lie outside these limits.";
    }
    if l.controller.gains().2 != 0.0 {
        said += " The derivative action was dropped.";
    }
    out += &paragraph(&said);
    out
}

fn map_text(map: &Map) -> String {
    let count = |wanted: State| map.points.iter().filter(|point| point.state() == wanted).count();
    let mut out = paragraph(&format!(
        "Map over {} and {} ({}): {} points with a cycle, {} without, {} unknown.",
        map.x.parameter.name(),
        map.y.parameter.name(),
        map.method.name(),
        count(State::Cycle),
        count(State::NoCycle),
        count(State::Unknown)
    ));
    let cycles: Vec<(f64, Swing)> = map.points.iter().filter_map(Point::cycle).collect();
    if cycles.is_empty() {
        return format!("\n{out}");
    }
    let row = |name: &str, unit: &str, of: &dyn Fn(&(f64, Swing)) -> f64| {
        let low = cycles.iter().map(of).fold(f64::INFINITY, f64::min);
        let high = cycles.iter().map(of).fold(f64::NEG_INFINITY, f64::max);
        [name.to_owned(), format!("{} to {}{unit}", digits(low), digits(high))]
    };
    let rows = [
        row("period", " s", &|c| c.0),
        row("half peak-to-peak OP", " %", &|c| c.1.op),
        row("half peak-to-peak VP", " %", &|c| c.1.vp),
        row("half peak-to-peak PV", "", &|c| c.1.pv),
    ];
    out += &text::columns(&rows, &[false, false]);
    format!("\n{out}")
}
