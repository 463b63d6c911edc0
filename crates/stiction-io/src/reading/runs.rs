//! Runs of a clock that begins again in a file: separated, with a note.

use super::builder::Builder;
use crate::columns::layout::LoopPlan;
use crate::columns::role::Signal;
use crate::error::{Error, Result};
use crate::remedy::Remedy;
use crate::timestamp::MOST_COLLAPSED;
use stiction_recording::recording::{Recording, Restart};

/// Number of restarts that the note lists.
const MOST_LISTED: usize = 8;

impl Builder<'_> {
    /// Moves times behind each restart of the clock, and notes the restarts.
    ///
    /// # Errors
    /// If too many rows of one run repeat the time of an earlier row with different values.
    pub(super) fn separate_runs(&self, plan: &LoopPlan, recording: &mut Recording) -> Result<()> {
        let channels = [Some(&recording.op), recording.pv.as_ref()].into_iter().flatten();
        if channels.clone().all(|each| each.time.is_sorted()) {
            return Ok(());
        }
        let samples = channels.map(|each| each.time.len()).max().unwrap_or(0);
        let rows = [Signal::Op, Signal::Pv, Signal::Sp, Signal::Vp, Signal::Mode]
            .map(|signal| plan.signal(signal).map_or(vec![], |place| self.source(place).rows));
        let runs = recording.separate_runs(&rows.each_ref().map(|rows| &**rows));
        if runs.repeated.count as f64 > MOST_COLLAPSED * samples as f64 {
            let message = format!(
                "has the time of another row but other values, like {} of {samples} rows, so samples would be lost; \
                 write times that differ{}",
                runs.repeated.count,
                if self.is_long() {
                    String::new()
                } else {
                    let remedy = self.options.wording.of(Remedy::SampleTime(1.0));
                    format!(", or give the time between rows, as in {remedy}")
                }
            );
            let column = self.plan.time.map_or("", |time| &self.sheet.columns[time].name);
            return Err(Error::Cell {
                origin: self.sheet.origin.clone(),
                row: self.sheet.row(runs.repeated.first),
                column: column.to_owned(),
                message,
            });
        }
        recording.notes.extend(self.note(&runs.restarts));
        Ok(())
    }

    /// The note on restarts.
    fn note(&self, restarts: &[Restart]) -> Option<String> {
        let show = |seconds: f64| self.times.clock.show(self.times.start, seconds);
        let place = |each: &Restart| {
            let row = self.sheet.row(each.row);
            format!("row {row} ({} after {})", show(each.after), show(each.before))
        };
        let listed: Vec<String> = restarts.iter().take(MOST_LISTED).map(place).collect();
        let more = restarts.len().saturating_sub(MOST_LISTED);
        let places = match (&listed[..], more) {
            ([], _) => return None,
            (listed, 0) => listed.join(", "),
            (listed, more) => format!("{} and {more} more", listed.join(", ")),
        };
        let apart = restarts.iter().filter(|each| !each.joined).count();
        let done = match (restarts.len(), apart) {
            (_, 0) => {
                "The signals continue or stay in their range there, so the runs are one sample time apart"
                    .to_owned()
            }
            (all, apart) if all == apart => {
                "The signals do not continue there, so a gap is left between the runs".to_owned()
            }
            (all, apart) => format!(
                "The runs are one sample time apart at {} rows, where the signals continue; a gap is left at the other rows",
                all - apart
            ),
        };
        // Hours 1 to 12, with 1 after 12.
        let hour = |t: f64| ((self.times.start.unwrap_or(0.0) + t) / 3600.0).rem_euclid(24.0);
        let is_half = restarts
            .iter()
            .all(|each| hour(each.before) >= 12.0 && (1.0..2.0).contains(&hour(each.after)))
            && self.times.seconds.iter().all(|t| (1.0..13.0).contains(&hour(*t)));
        let half = match is_half {
            true => {
                ". All hours are 1 to 12, so the times probably lack AM and PM; export AM and PM, too, or 24 hours"
            }
            false => "",
        };
        Some(format!(
            "the clock jumps back in {places}; all rows stay in the order of the file. {done}{half}"
        ))
    }
}
