//! Writes a report with all views of a simulated sticky flow loop: `report_views PATH [SAMPLES]`.

use stiction::closed_loop::{ClosedLoop, Controller, Process, Signal};
use stiction::detect::Decision;
use stiction::diagnose::VerdictClass;
use stiction::recording::{Mode, Modes, Stretch};
use stiction::valve::{Assembly, Model};
use stiction::{Bands, series};
use stiction_report::report::layout::{Badge, Block, Card, Fact, Report, Section, Table, number};
use stiction_report::report::views::{self, Context, Ellipse};

/// A flow loop whose valve has the given S and J, cut into stretches at `cuts` (from, to).
fn stretches(
    (s, j): (f64, f64),
    samples: usize,
    cuts: &[(f64, f64)],
) -> Result<Vec<Stretch>, stiction::Error> {
    let mut flow = ClosedLoop::new(
        Controller::pi(0.55, 3.5)?,
        Assembly::new(Model::TwoPhase.build(Bands::from_s_j(s, j)?)?),
        Process::first_order(1.5, 5.93, 1.07)?,
    );
    flow.sample_time = 1.0;
    flow.samples = samples;
    flow.op_rest = 45.0;
    flow.pv_rest = 60.0;
    flow.set_point = Signal::Steps(vec![
        (0.0, 60.0),
        (0.04 * samples as f64, 63.0),
        (0.6 * samples as f64, 65.0),
    ]);
    flow.measurement = vec![Signal::Noise { sd: 0.15, tau_s: 0.0, seed: 7 }];
    let run = flow.run()?;
    let stretch = |&(from, to): &(f64, f64)| {
        let range = (from * samples as f64) as usize..(to * samples as f64) as usize;
        Stretch {
            from: range.start as f64,
            sample_time: 1.0,
            op: run.op[range.clone()].to_vec(),
            pv: Some(run.pv[range.clone()].to_vec()),
            sp: Some(run.sp[range.clone()].to_vec()),
            vp: Some(run.vp[range].to_vec()),
            bridged: 0,
        }
    };
    Ok(cuts.iter().map(stretch).collect())
}

/// The ellipse of equal spread: of the right look, though no detector's.
fn ellipse(stretch: &Stretch) -> Option<Ellipse> {
    let pv = stretch.pv.as_ref()?;
    let (op, n) = (&stretch.op, stretch.len() as f64);
    let (mx, my) = (series::mean(op), series::mean(pv));
    let cov: f64 = op.iter().zip(pv).map(|(x, y)| (x - mx) * (y - my)).sum::<f64>() / n;
    let (xx, yy) = (series::variance(op), series::variance(pv));
    let angle = 0.5 * (2.0 * cov).atan2(xx - yy);
    let (middle, radius) = ((xx + yy) / 2.0, ((xx - yy) / 2.0).hypot(cov));
    let semi_axes = ((2.0 * (middle + radius)).sqrt(), (2.0 * (middle - radius)).sqrt());
    Some(Ellipse { op: mx, pv: my, semi_axes, angle })
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let path = arguments.next().ok_or("usage: report_views PATH [SAMPLES]")?;
    let samples = arguments.next().map_or(Ok(1_800), |n| n.parse())?;
    let end = samples as f64;

    let sticky = stretches((6.0, 2.5), samples, &[(0.0, 0.22), (0.3, 1.0)])?;
    let modes = Modes {
        time: vec![0.0, 0.22 * end, 0.3 * end],
        modes: vec![Mode::Automatic, Mode::Manual, Mode::Cascade],
    };
    let context = Context {
        start: Some(1_710_000_000.0),
        pv_unit: Some("m³/h"),
        modes: Some(&modes),
        period_s: None,
    };
    let mut first = Section::new(
        "FIC-101",
        Badge::from(VerdictClass::Sticks),
        "the valve sticks: 4 of 5 methods that decide say so",
    )
    .reason("4 of 5 methods that decide say it sticks; 1 is undecided, 2 abstain")
    .fact(Fact::new("S", number(6.0), "%"))
    .fact(Fact::new("J", number(2.5), "%"))
    .heading("What was recorded");
    for figure in views::all(&sticky, 1, ellipse(&sticky[1]).as_ref(), &context) {
        first = first.with(figure);
    }
    let table =
        Table::new("Numbers of the method").words("number").numbers("value", "").words("unit");
    let table = table.row(["delta tau", "0.12", ""]).row(["threshold", "0.05", ""]);
    let mut card = Card::new("Histogram of the example", "Something clear, with its numbers.")
        .badge(Decision::Sticks)
        .caveat("the loop's type is not known; it is taken to be self-regulating")
        .table(table.clone());
    card.figure = views::histograms(&sticky[1], &context);
    let first = first
        .heading("Evidence")
        .with(card)
        .with(Card::new("Another method", "Made for integrating loops.").badge(Decision::Abstains))
        .with(Block::Details { summary: "Parameters".into(), blocks: vec![table.into()] });

    let healthy = stretches((0.2, 0.1), samples, &[(0.0, 1.0)])?;
    let mut second = Section::new(
        "FIC-102",
        Badge::from(VerdictClass::DoesNotStick),
        "all methods that decide say it does not stick",
    )
    .heading("What was recorded");
    for figure in views::all(&healthy, 0, None, &Context::default()) {
        second = second.with(figure);
    }
    let report = Report::new("Two flow loops", concat!("stiction ", env!("CARGO_PKG_VERSION")))
        .introduction("Simulated flow loops, one with a sticking valve and one without.")
        .source("example", "simulated; no file was read")
        .with(first)
        .with(second);
    std::fs::write(path, report.html()?)?;
    Ok(())
}
