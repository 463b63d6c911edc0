//! A report on diagnosed loops.

use super::layout::{Badge, Report, Section};
use super::views::{self, Context};
use crate::Error;
use crate::document::Source;
use stiction::diagnose::Diagnosis;

/// The report on some loops, each with the file it comes from: one self-contained HTML page.
///
/// # Errors
/// If a figure cannot be drawn, as when a signal is far beyond what a picture can show.
pub fn html(tool: &str, loops: &[(&Diagnosis, &Source)]) -> Result<String, Error> {
    let mut report = Report::new("Diagnosis of control loops", tool);
    for (diagnosis, source) in loops {
        report = report.source(&source.file, &source.sha256).with(section(diagnosis));
    }
    report.html()
}

fn section(diagnosis: &Diagnosis) -> Section {
    let verdict = &diagnosis.verdict;
    let headline = verdict.reasons.first().map_or("", String::as_str);
    let mut section = Section::new(&diagnosis.name, Badge::from(verdict.class), headline);
    for reason in diagnosis.fitness.reasons() {
        section = section.reason(reason);
    }
    let context = Context {
        start: diagnosis.start,
        pv_unit: diagnosis.pv_unit.as_deref(),
        modes: diagnosis.mode.as_ref(),
        period_s: diagnosis.oscillation().and_then(|(_, oscillation)| oscillation.period_s),
    };
    if let Some(judged) = diagnosis.judged {
        for figure in views::all(&diagnosis.grid.stretches, judged, None, &context) {
            section = section.with(figure);
        }
    }
    section
}
