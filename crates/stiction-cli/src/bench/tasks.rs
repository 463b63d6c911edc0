//! `stiction bench suite`, `report`, `verify` and `answer`.

use super::Form;
use super::entrants::{self, Source};
use crate::files::{self, In, Out};
use crate::{output, progress};
use anyhow::{Context, Result, anyhow, bail};
use clap::{Parser, Subcommand};
use rayon::prelude::*;
use sha2::{Digest, Sha256};
use std::io::{BufRead, Write};
use stiction::methods::MethodId;
use stiction::score::bench::exchange::{self, AnswerLine};
use stiction::score::bench::results::{Label, Results, Submitted, joined, same_loops};
use stiction::score::bench::{datasheet, leaderboard};
use stiction::scoreboard::{KnownLoop, answer_of};
use stiction::suite::Known;
use stiction_io::whole::WholeFile;
use stiction_report::sheet::Sheet;

#[derive(Subcommand)]
pub enum Task {
    /// Write a suite of loops: recordings, separate truth, datasheet, and SHA-256 of the files
    ///
    /// Recordings are lines of JSON, as `stiction bench detector` sends them. The same suite has the same bytes on every machine. With
    /// --hidden, the seeds are derived from the passphrase in the variable STICTION_BENCH_PASSPHRASE, so that an
    /// organiser can withhold these loops.
    #[command(after_help = "Examples:
  stiction bench suite v1 -o suite
  stiction bench suite v1-training -o training
  STICTION_BENCH_PASSPHRASE=... stiction bench suite v1 --hidden -o hidden")]
    Suite(SuiteArgs),
    /// Compare results on one page with a leaderboard, curves, differences, and loops to examine
    ///
    /// Results are what stiction bench detector prints with --json. All results must be for the same loops.
    #[command(after_help = "Examples:
  stiction bench report mine.json theirs.json -o page.html
  stiction bench report mine.json theirs.json --markdown")]
    Report(ReportArgs),
    /// Check submitted results: loops, answers, their SHA-256, and the measures
    ///
    /// The measures are computed again from the answers. The tool, and the name, version, command and times of the
    /// detector, are not checked. For the hidden half of a suite, the variable STICTION_BENCH_PASSPHRASE must
    /// hold its passphrase. Exit code 2: a check failed, and the message lists the faults.
    #[command(after_help = "Examples:
  stiction bench verify mine.json")]
    Verify(VerifyArgs),
    /// Answer recordings from standard input, as a program for `stiction bench detector`
    ///
    /// Reads one recording as JSON from each line and writes one line of JSON with its answer. Your own program must
    /// read and answer in the same form.
    #[command(after_help = "Examples:
  stiction bench answer < suite/recordings.jsonl > answers.jsonl
  stiction bench detector 'stiction bench answer --method horch' --suite v1-trial")]
    Answer(AnswerArgs),
}

#[derive(Parser)]
pub struct SuiteArgs {
    /// v1, v1-trial or v1-training
    #[arg(value_name = "SUITE")]
    name: String,
    /// Write the hidden half
    #[arg(long)]
    hidden: bool,
    /// Folder to write to; created if missing
    #[arg(short, long, value_name = "DIR")]
    output: Out,
}

#[derive(Parser)]
pub struct ReportArgs {
    /// Results
    #[arg(required = true, value_name = "RESULTS.json")]
    results: Vec<In>,
    /// Write the page to this file
    #[arg(short, long, value_name = "FILE")]
    output: Option<Out>,
    #[command(flatten)]
    form: Form,
}

#[derive(Parser)]
pub struct VerifyArgs {
    /// Results
    #[arg(required = true, value_name = "RESULTS.json")]
    results: Vec<In>,
}

#[derive(Parser)]
pub struct AnswerArgs {
    /// Answer by this method instead of the verdict
    #[arg(long, value_name = "NAME")]
    method: Option<String>,
}

pub fn run(task: Task) -> Result<()> {
    match task {
        Task::Suite(args) => write_suite(&args),
        Task::Report(args) => report(&args),
        Task::Verify(args) => verify(&args),
        Task::Answer(args) => answer(&args),
    }
}

/// Number of loops held in memory at a time.
const BATCH: usize = 256;

/// A file of a suite, and the hash of its content.
struct Hashed {
    file: WholeFile,
    hash: Sha256,
    path: Out,
}

impl Hashed {
    fn create(path: Out) -> Result<Self> {
        let file = WholeFile::create(&path).with_context(|| path.display().to_string())?;
        Ok(Self { file, hash: Sha256::new(), path })
    }

    fn write(&mut self, text: &str) -> Result<()> {
        self.hash.update(text);
        self.file.write_all(text.as_bytes()).with_context(|| self.path.display().to_string())
    }

    /// The line of SHA256SUMS for a file of this name.
    fn keep(self, name: &str) -> Result<String> {
        self.file.keep().with_context(|| self.path.display().to_string())?;
        let hash: String = self.hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect();
        Ok(format!("{hash}  {name}\n"))
    }
}

fn write_suite(args: &SuiteArgs) -> Result<()> {
    let suite = entrants::suite(&args.name, args.hidden)?;
    let folder = &args.output;
    files::make_empty_folder(folder)?;
    folder.inside("truth")?.make_folder()?;
    let mut recordings = Hashed::create(folder.inside(datasheet::RECORDINGS)?)?;
    let progress = progress::bar("simulating", suite.len());
    let mut all = vec![];
    for from in (0..suite.len()).step_by(BATCH) {
        let batch: Vec<(String, KnownLoop)> = (from..suite.len().min(from + BATCH))
            .into_par_iter()
            .map(|k| {
                let Known { recording, asked } = suite.known(k)?;
                progress.inc(1);
                Ok((exchange::line(&recording).map_err(|e| anyhow!(e))?, asked))
            })
            .collect::<Result<_>>()?;
        for (line, asked) in batch {
            recordings.write(&line)?;
            recordings.write("\n")?;
            all.push(asked);
        }
    }
    progress.finish_and_clear();
    let mut sums = recordings.keep(datasheet::RECORDINGS)?;
    let truth_name = format!("truth/{}", datasheet::TRUTH);
    for (name, text) in [
        (truth_name.as_str(), truth(&all)?),
        ("DATASHEET.md", datasheet::markdown(&suite, &all, output::TOOL)),
    ] {
        let mut file = Hashed::create(folder.inside(name)?)?;
        file.write(&text)?;
        sums += &file.keep(name)?;
    }
    output::write(Some(&folder.inside("SHA256SUMS")?), sums.as_bytes())?;
    output::line(format!("{} loops; see {}", suite.len(), folder.display()))
}

fn truth(all: &[KnownLoop]) -> Result<String> {
    let columns = "id,kind,sticks,visible,S,J,evidence_nats,slips,groups";
    let mut sheet = Sheet::new(columns.split(','))?;
    let say = |value: Option<f64>| value.map_or(String::new(), |v| v.to_string());
    for KnownLoop { id, truth, groups } in all {
        let groups: Vec<String> =
            groups.iter().map(|(name, value)| format!("{name}: {value}")).collect();
        sheet.row([
            id.clone(),
            truth.kind.clone(),
            truth.sticks.to_string(),
            truth.visible.to_string(),
            say(truth.s),
            say(truth.j),
            say(truth.member.map(|member| member.gain)),
            truth.member.map_or(String::new(), |member| member.slips.to_string()),
            groups.join("; "),
        ])?;
    }
    Ok(sheet.text()?)
}

/// Results in files.
struct Again {
    /// Each set of results with the name of its file.
    submitted: Vec<(String, Submitted)>,
    asked: Vec<KnownLoop>,
    /// All results, measured again together.
    results: Results,
}

/// Reads results in files, and measures them again together. All results must be about the same loops.
fn read(files: &[In]) -> Result<Again> {
    let mut submitted = vec![];
    for file in files {
        let text = std::fs::read_to_string(&**file).with_context(|| file.origin())?;
        let found = Submitted::read(&text).map_err(|e| anyhow!("{} {e}", file.origin()))?;
        submitted.push((file.origin(), found));
    }
    let loops = same_loops(&submitted).map_err(|e| anyhow!(e))?;
    let (loops, asked) = match &loops.suite {
        Some(name) => {
            let source = Source::suite(name, loops.hidden)?;
            (source.loops(), source.known_loops()?)
        }
        None => (loops.clone(), loops.labels.iter().map(Label::known_loop).collect()),
    };
    let results = joined(output::TOOL, &submitted, loops, &asked).map_err(|e| anyhow!(e))?;
    Ok(Again { submitted, asked, results })
}

fn report(args: &ReportArgs) -> Result<()> {
    let Again { asked, results, .. } = read(&args.results)?;
    if let Some(file) = &args.output {
        output::write(Some(file), leaderboard::html(&results, &asked)?.as_bytes())?;
        if !args.form.json && !args.form.markdown {
            return Ok(());
        }
    }
    entrants::print(&results, &args.form)
}

fn verify(args: &VerifyArgs) -> Result<()> {
    for file in &args.results {
        let Again { submitted, results: again, .. } = read(std::slice::from_ref(file))?;
        let faults: Vec<String> =
            submitted.iter().flat_map(|(_, each)| each.faults(&again)).collect();
        if !faults.is_empty() {
            bail!("{}: {}", file.origin(), faults.join("; "));
        }
        let tool = submitted.first().map_or("", |(_, each)| &each.tool);
        for entry in &again.entries {
            output::line(format!(
                "{}: {} is verified. {}, measured by {tool}, SHA-256 of the answers {}",
                file.origin(),
                entry.detector.name,
                again.loops.title(),
                entry.sha256
            ))?;
        }
    }
    Ok(())
}

fn answer(args: &AnswerArgs) -> Result<()> {
    let method = args.method.as_deref().map(str::parse::<MethodId>).transpose()?;
    let mut out = std::io::stdout().lock();
    for (k, line) in std::io::stdin().lock().lines().enumerate() {
        let line = line.context("standard input")?;
        let recording = exchange::recording(&line)
            .map_err(|e| anyhow!("standard input, line {}: {e}", k + 1))?;
        let answer = answer_of(&recording, method)
            .with_context(|| format!("standard input, line {}, {}", k + 1, recording.name))?;
        // A detector answers at once, so each line is flushed.
        writeln!(out, "{}", AnswerLine::of(&recording.name, &answer).line())
            .and_then(|()| out.flush())?;
    }
    Ok(())
}
