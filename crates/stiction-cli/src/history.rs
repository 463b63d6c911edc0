//! `stiction history`: several recordings, or a long one, of the same valves.

use crate::diagnose::{ended, joined};
use crate::files::{In, Out};
use crate::loops::{Diagnosed, diagnose_all, find_all};
use crate::output::{self, Sheet};
use crate::reading_args::Reading;
use crate::text::{self, coloured, field, number};
use anyhow::{Result, anyhow, bail};
use clap::Parser;
use stiction::diagnose::{DiagnoseOptions, Observation, combine, repair};
use stiction::oscillation;
use stiction::recording::{Grid, GridOptions, PlantTime, Recording};
use stiction::spoken;
use stiction_io::timestamp::{Zone, instant};
use stiction_report::document::{Point, Source, Valve, ValveHistory};
use stiction_report::report::{self, history};

/// The shortest default window in s, a day, so that every window includes all shifts.
const DAY: f64 = 86_400.0;
/// Minimum number of periods in a default window. With fewer periods, the data have a caveat.
const CYCLES: f64 = 10.0;

/// Show the history of valves: each window, all windows combined, drift, and the effect of a repair.
///
/// Recordings of one tag belong together, in any number of files. Files without tags need --join. Each recording is cut
/// into windows of a day, or of ten periods of its oscillation if that is longer. A recording shorter than one and a
/// half windows stays whole. Every window is diagnosed on its own, then the results are combined. With --repair only
/// the windows after the repair are combined.
#[derive(Parser)]
#[command(after_help = "Examples:
  stiction history FIC101-january.csv FIC101-february.csv --join --report history.html
  stiction history export.parquet --loop FIC101 --window 8h --repair 2026-03-01T08:00
  stiction history plant/*.csv --csv windows.csv")]
pub struct Args {
    /// CSV, Parquet, Excel or MATLAB files; - is standard input
    #[arg(required = true, value_name = "FILE")]
    files: Vec<In>,
    /// Show only the valve of this loop; may be given several times
    #[arg(long = "loop", value_name = "TAG")]
    loops: Vec<String>,
    /// Treat all files as recordings of one valve, one after the other; gaps between them remain gaps
    #[arg(long)]
    join: bool,
    /// Length of a window, such as 8h, 90min, 2d or 3600 (s)
    #[arg(long, value_name = "DURATION", value_parser = a_duration)]
    window: Option<f64>,
    /// Compare the windows before and after this time, such as 2026-03-01T08:00 in the zone of --zone or UTC; for
    /// recordings without dates, a time in s
    #[arg(long, value_name = "TIME")]
    repair: Option<String>,
    /// Write a self-contained HTML report to this file
    #[arg(long, value_name = "OUT.html")]
    report: Option<Out>,
    /// Print the results as JSON
    #[arg(long)]
    json: bool,
    /// Write a table with one row per window to this CSV file; - is standard output
    #[arg(long, value_name = "FILE", conflicts_with = "json")]
    csv: Option<Out>,
    // Must be last, because its heading applies to all that follows.
    #[command(flatten)]
    reading: Reading,
}

pub(crate) fn a_duration(text: &str) -> Result<f64, String> {
    let text = text.trim();
    let digits = text.find(|c: char| c.is_ascii_alphabetic()).unwrap_or(text.len());
    let (value, unit) = text.split_at(digits);
    let size = match unit {
        "" | "s" => 1.0,
        "min" => 60.0,
        "h" => 3600.0,
        "d" => DAY,
        _ => f64::NAN,
    };
    match value.trim().parse::<f64>().map(|value| value * size) {
        Ok(seconds) if seconds > 0.0 && seconds.is_finite() => Ok(seconds),
        _ => Err("must be above 0 and in s, min, h or d, such as 8h".to_owned()),
    }
}

pub fn run(args: Args) -> Result<()> {
    let (found, mut failures) = find_all(&args.files, &args.loops, &args.reading)?;
    let recordings = if args.join {
        joined::all(found)?
    } else {
        joined::offer(&found);
        joined::separate(found)
    };
    let mut windows = vec![];
    for (source, recording) in recordings {
        let window = args.window.unwrap_or_else(|| default_window(&recording));
        for part in recording.split(window)? {
            windows.push((source.clone(), part));
        }
    }
    let total = windows.len();
    let (mut diagnosed, refused) = diagnose_all(&windows, &DiagnoseOptions::default());
    diagnosed.retain(|each| each.diagnosis.segment().is_some());
    if diagnosed.is_empty() {
        failures.extend(refused);
        if failures.is_empty() && total > 0 {
            bail!("no window has a segment in automatic to analyse");
        }
    } else if diagnosed.len() < total {
        output::note(format!(
            "{} of {total} windows have no segment in automatic to analyse, and are left out",
            total - diagnosed.len()
        ));
    }
    let mut tags: Vec<&str> = vec![];
    for each in &diagnosed {
        if !tags.contains(&each.diagnosis.name.as_str()) {
            tags.push(&each.diagnosis.name);
        }
    }
    let mut valves = vec![];
    for tag in tags {
        let own: Vec<&Diagnosed> = diagnosed.iter().filter(|d| d.diagnosis.name == tag).collect();
        valves.push(valve(tag, &own, &args)?);
    }
    if !valves.is_empty() {
        show(&ValveHistory::new(output::TOOL, valves), &args)?;
    }
    ended(failures)
}

fn show(history: &ValveHistory, args: &Args) -> Result<()> {
    output::given(&args.report, || report::history_html(history))?;
    output::given(&args.csv, || table(history))?;
    if args.json {
        return output::json_text(&history.json());
    }
    if args.csv.is_none() {
        let texts: Vec<String> = history.valves.iter().map(in_words).collect();
        output::text(&texts.join("\n"))?;
    }
    Ok(())
}

/// A day, or ten periods of the whole recording's oscillation if that is longer.
fn default_window(recording: &Recording) -> f64 {
    let period = Grid::of(recording, &GridOptions::default()).ok().and_then(|grid| {
        let segment = grid.longest()?;
        let found = oscillation::analyse(&segment.op, segment.sample_time);
        found.period_s.filter(|_| found.found)
    });
    period.map_or(DAY, |period| DAY.max(CYCLES * period))
}

/// The history of one valve, from the diagnoses of its windows.
fn valve(tag: &str, own: &[&Diagnosed], args: &Args) -> Result<Valve> {
    let mut sources: Vec<Source> = vec![];
    for each in own {
        if !sources.contains(&each.source) {
            sources.push(each.source.clone());
        }
    }
    let dated = own.iter().all(|each| each.diagnosis.start.is_some());
    if !dated && sources.len() > 1 {
        bail!(
            "loop {tag} is in {} files, and some of the files have no dates; give files with dates, or --join if the \
             files are named in order of time",
            sources.len()
        );
    }
    let mut seen: Vec<(Point, Observation)> = own
        .iter()
        .filter_map(|Diagnosed { source, diagnosis, .. }| {
            let origin = diagnosis.start.filter(|_| dated).unwrap_or(0.0);
            let segment = diagnosis.segment()?;
            let (from, duration) = (segment.from, segment.duration());
            let point = Point::new(diagnosis, &source.file, origin + from, duration);
            Some((point, diagnosis.observation(origin)?))
        })
        .collect();
    seen.sort_by(|(_, a), (_, b)| a.time.total_cmp(&b.time));
    let (points, observations): (Vec<Point>, Vec<Observation>) = seen.into_iter().unzip();
    let time = match &args.repair {
        Some(text) => Some(repair_time(text, dated, args.reading.zone()?.as_ref())?),
        None => None,
    };
    let repaired = time.map(|time| repair(&observations, time)).transpose()?;
    // Only the present valve counts. Windows before a repair are left out.
    let now = observations.iter().filter(|o| time.is_none_or(|time| o.time >= time));
    let combined = combine(&now.cloned().collect::<Vec<_>>())?;
    let plant_time =
        own.first().map_or_else(PlantTime::default, |each| each.diagnosis.plant_time.clone());
    Ok(Valve {
        name: tag.to_owned(),
        sources,
        dated,
        plant_time,
        windows: points,
        combined,
        repair: repaired,
    })
}

fn repair_time(text: &str, dated: bool, zone: Option<&Zone>) -> Result<f64> {
    if dated {
        return instant(text, zone).map_err(|e| anyhow!("--repair: {e}"));
    }
    text.parse::<f64>().ok().filter(|t| t.is_finite()).ok_or_else(|| {
        anyhow!("--repair {text}: the recording has no dates; give the time in s on the clock of the recording")
    })
}

fn in_words(valve: &Valve) -> String {
    let files = match &valve.sources[..] {
        [one] => output::name(&one.file).into_owned(),
        several => format!("{} files", several.len()),
    };
    let windows = spoken::counted(valve.windows.len(), "window");
    let grade = valve.combined.grade;
    let grade = coloured(grade, &grade.name().to_uppercase());
    let mut out = format!("{}  {files}, {windows}\n\n", output::name(&valve.name));
    out += &text::plain(&history::windows(valve));
    out.push('\n');
    out += &field("together", &format!("{grade}: {}", history::headline(valve)));
    for fact in history::course(valve) {
        out += &field(&fact.name, &fact.value);
    }
    out
}

fn table(history: &ValveHistory) -> Result<String> {
    let columns = "loop,file,from,from_s,duration_s,verdict,grade,basis,probability,S,S_low,\
        S_high,J,J_low,J_high,fitness";
    let mut sheet = Sheet::new(columns.split(','))?;
    let say = |value: Option<f64>| value.map_or(String::new(), spoken::cell);
    for valve in &history.valves {
        for w in &valve.windows {
            let (s, j) = (w.s, w.j);
            sheet.row([
                valve.name.clone(),
                w.file.clone(),
                valve.date(w.from_s).unwrap_or_else(|| number(w.from_s)),
                w.from_s.to_string(),
                w.duration_s.to_string(),
                w.class.name().to_owned(),
                w.grade.name().to_owned(),
                w.basis.name().to_owned(),
                say(w.probability),
                say(s.map(|s| s.value)),
                say(s.map(|s| s.low)),
                say(s.map(|s| s.high)),
                say(j.map(|j| j.value)),
                say(j.map(|j| j.low)),
                say(j.map(|j| j.high)),
                w.fitness.name().to_owned(),
            ])?;
        }
    }
    Ok(sheet.text()?)
}

#[cfg(test)]
mod tests {
    use super::a_duration;

    #[test]
    fn durations() {
        for (text, seconds) in [
            ("3600", 3600.0),
            ("90s", 90.0),
            ("90min", 5400.0),
            ("8h", 28_800.0),
            ("1.5 d", 129_600.0),
        ] {
            assert_eq!(a_duration(text), Ok(seconds));
        }
        for wrong in ["", "h", "0", "-1h", "3 weeks", "nan", "inf", "1e999"] {
            assert!(a_duration(wrong).is_err(), "{wrong}");
        }
    }
}
