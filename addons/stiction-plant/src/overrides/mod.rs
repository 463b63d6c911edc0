//! Overrides, the conclusions of people about a valve, which may differ from the computed verdict.
//!
//! The program stores them in `stiction-overrides.toml` beside their recordings:
//!
//! ```toml
//! [[override]]
//! loop = "FIC101"
//! verdict = "does not stick"
//! reason = "new packing, stroked by maintenance"
//! by = "J. Miller"
//! entered = 2026-03-02
//! tool = "stiction 0.1.0"
//! file = "FIC101.csv"
//! sha256 = "9f86d081884c7d659a2feaa0c55ad015a3bf4f1b2b0b822cd15d6c15b0f00a08"
//!
//! [[override]]
//! loop = "FIC102"
//! verdict = "does not stick"
//! reason = "stroked on the bench"
//! all_recordings = true
//! from = 2026-03-01
//! until = 2026-06-30
//! ```
//!
//! An override holds for the loop of exactly that tag, and
//!
//! * either for one recording, the file of that name in this folder whose bytes have that SHA-256. A rewritten file
//!   is a different recording;
//! * or, with `all_recordings`, for every file of this folder. Such an override must end, with `until`.
//!
//! With `from` or `until` it holds only for data recorded on those days, both included, in UTC. The judged segment must
//! lie completely between them, so a recording without dates is not covered. An override of one recording takes
//! precedence over one of all. Two overrides of one loop and scope with overlapping days contradict each other, and
//! neither applies.
//!
//! An entry that cannot be understood does not affect the others. It is reported with its line, see [`Damaged`], and
//! stays unchanged in the file. The file is changed under a lock, so that simultaneous entries are not lost.

mod change;
mod entry;
mod text;

pub use change::{enter, remove, with, without};
pub use entry::{Override, Scope};
pub use jiff::civil::Date;
pub use text::Damaged;

use change::read_if_there;
use jiff::tz::TimeZone;
use std::path::{Path, PathBuf};
use stiction_diagnose::diagnose::Diagnosis;
use stiction_io::Result;
use text::pieces;

/// Name of the file that holds the overrides of a folder.
pub const FILE_NAME: &str = "stiction-overrides.toml";

/// The overrides of a folder.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Overrides {
    /// The name of the file in messages.
    pub origin: String,
    /// All valid overrides, in the order of the file.
    pub all: Vec<Override>,
    /// The entries that do not apply, because they are damaged or contradict each other.
    pub damaged: Vec<Damaged>,
}

/// The properties of a recording that overrides depend on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Recorded<'a> {
    /// Tag of the loop.
    pub loop_name: &'a str,
    /// File.
    pub file: &'a Path,
    /// SHA-256 of the file's bytes, hexadecimal.
    pub sha256: &'a str,
    /// Beginning and end of the judged data, in seconds since 1970-01-01 UTC, if known.
    pub span: Option<(f64, f64)>,
}

impl Overrides {
    /// The file of overrides in the folder of `file`, or in `file` itself if it is a folder.
    pub fn path_for(file: &Path) -> PathBuf {
        if file.is_dir() { file.join(FILE_NAME) } else { file.with_file_name(FILE_NAME) }
    }

    /// Reads the overrides at `path`; none if the file is missing.
    ///
    /// # Errors
    /// If the overrides cannot be read.
    pub fn read(path: &Path) -> Result<Self> {
        Ok(Self::parse(&read_if_there(path)?, &path.display().to_string()))
    }

    /// Reads overrides from the bytes of their file. `origin` is its name in messages.
    pub fn parse(bytes: &[u8], origin: &str) -> Self {
        let mut damaged = vec![];
        let mut all: Vec<(usize, Override)> = vec![];
        for piece in pieces(bytes) {
            match piece.found {
                Ok(found) => all.extend(found),
                Err(wrong) => damaged.push(wrong),
            }
        }
        // Only the author knows which of two contradicting entries is meant.
        let rival = |place: usize| {
            let (_, one) = &all[place];
            let mut others = all.iter().enumerate().filter(|(other, _)| *other != place);
            others.find(|(_, (_, other))| one.rivals(other) && one.overlaps(other)).map(|(_, o)| o)
        };
        let rivals: Vec<Option<usize>> =
            (0..all.len()).map(|place| rival(place).map(|(line, _)| *line)).collect();
        let mut kept = vec![];
        for ((line, one), rival) in all.into_iter().zip(rivals) {
            let Some(other) = rival else {
                kept.push(one);
                continue;
            };
            let message = format!(
                "[override]: contradicts the override in line {other} on loop {}, for {}; remove one override, \
                 or give days that do not overlap",
                one.loop_name,
                one.scope_in_words()
            );
            damaged.push(Damaged { line, loop_name: Some(one.loop_name), message });
        }
        damaged.sort_by_key(|each| each.line);
        Self { origin: origin.to_owned(), all: kept, damaged }
    }

    /// Adds the conclusion of a person to the diagnosis of a recording, from `file` with that SHA-256. Overrides that
    /// do not apply are noted with the reason.
    pub fn overrule(&self, diagnosis: &mut Diagnosis, file: &Path, sha256: &str) {
        let span = diagnosis.start.zip(diagnosis.segment()).map(|(start, segment)| {
            let from = start + segment.from;
            (from, from + segment.duration())
        });
        let (found, notes) = self.of(&Recorded { loop_name: &diagnosis.name, file, sha256, span });
        diagnosis.verdict.overruled = found.map(|found| found.shown(&self.origin));
        diagnosis.notes.extend(notes);
    }

    /// The fault of each invalid entry, in a sentence with file and line.
    pub fn complaints(&self) -> impl Iterator<Item = String> {
        self.damaged.iter().map(|each| self.complaint(each))
    }

    fn complaint(&self, of: &Damaged) -> String {
        format!(
            "{}, line {}: {}; this override does not apply until you correct or remove it, but the other overrides apply",
            self.origin, of.line, of.message
        )
    }

    /// The override that holds for a recording, and the reasons why others of its tag do not.
    pub fn of(&self, recorded: &Recorded<'_>) -> (Option<&Override>, Vec<String>) {
        let file_name = recorded.file.file_name().unwrap_or_default().to_string_lossy();
        let mut found: Option<&Override> = None;
        // An unreadable loop tag may be this one.
        let of_this =
            |each: &&Damaged| each.loop_name.as_ref().is_none_or(|name| name == recorded.loop_name);
        let mut notes: Vec<String> =
            self.damaged.iter().filter(of_this).map(|each| self.complaint(each)).collect();
        for each in self.all.iter().filter(|each| each.loop_name == recorded.loop_name) {
            let why_not = match &each.scope {
                Scope::File { name, .. } if *name != file_name => continue,
                Scope::File { sha256, .. } if !sha256.eq_ignore_ascii_case(recorded.sha256) => {
                    Some(
                        "the file has changed since the override was entered; enter it again if it still holds",
                    )
                }
                _ => each.outside(recorded.span),
            };
            match why_not {
                Some(why) => notes.push(format!(
                    "an override in {} states that the valve {}, but does not apply: {why}",
                    self.origin,
                    each.verdict.name()
                )),
                None if each.scope == Scope::All && found.is_some() => {}
                None => found = Some(each),
            }
        }
        (found, notes)
    }
}

/// The date of today, UTC.
pub fn today() -> Date {
    jiff::Timestamp::now().to_zoned(TimeZone::UTC).date()
}

#[cfg(test)]
mod tests {
    use super::text::in_toml;
    use super::*;
    use stiction_diagnose::diagnose::VerdictClass;

    const SHA: &str = "9f86d081884c7d659a2feaa0c55ad015a3bf4f1b2b0b822cd15d6c15b0f00a08";

    fn one() -> Override {
        Override {
            loop_name: "FIC101".to_owned(),
            verdict: VerdictClass::DoesNotStick,
            reason: "new \"packing\"".to_owned(),
            by: Some("J. Miller".to_owned()),
            entered: Some(Date::constant(2026, 3, 2)),
            tool: Some("stiction 0.1.0".to_owned()),
            scope: Scope::File { name: "a.csv".to_owned(), sha256: SHA.to_owned() },
            from: None,
            until: None,
        }
    }

    fn for_all(from: Option<Date>, until: Date) -> Override {
        Override { scope: Scope::All, from, until: Some(until), ..one() }
    }

    fn recorded<'a>(tag: &'a str, file: &'a str, sha256: &'a str) -> Recorded<'a> {
        Recorded { loop_name: tag, file: Path::new(file), sha256, span: None }
    }

    fn text(made: &[u8]) -> &str {
        std::str::from_utf8(made).unwrap()
    }

    fn all(bytes: &[u8]) -> Vec<Override> {
        let found = Overrides::parse(bytes, "o.toml");
        assert_eq!(found.damaged, []);
        found.all
    }

    #[test]
    fn what_is_written_is_read() {
        let made = with(b"", "o.toml", &one()).unwrap();
        assert!(
            made.starts_with(b"# Conclusions") && text(&made).contains("entered = 2026-03-02"),
            "{}",
            text(&made)
        );
        assert_eq!(all(&made), [one()]);
        let both = with(&made, "o.toml", &for_all(None, Date::constant(2026, 6, 1))).unwrap();
        assert_eq!(all(&both).len(), 2);
        let nasty = "\u{1b}\u{7f} \\ \"\"\" \n[[override]]\nloop = 'B' \u{202e}".to_owned();
        let nasty = Override { reason: nasty, ..one() };
        let made = with(b"", "o.toml", &nasty).unwrap();
        assert_eq!(all(&made), [nasty]);
        assert_eq!(made.iter().filter(|b| **b == b'\n').count(), 12, "{}", text(&made));
        // As files were before they told the tool.
        let old = text(&made).replace("tool = \"stiction 0.1.0\"\n", "");
        assert_eq!(all(old.as_bytes())[0].tool, None);
    }

    #[test]
    fn comments_stay_and_the_same_scope_is_replaced() {
        let made = [b"# of ours\n", &with(b"", "o.toml", &one()).unwrap()[..], b"# of the next\n"]
            .concat();
        let newer = Override { reason: "stroked".to_owned(), ..one() };
        let made = with(&made, "o.toml", &newer).unwrap();
        assert!(
            made.starts_with(b"# of ours\n") && made.ends_with(b"\n# of the next\n"),
            "{}",
            text(&made)
        );
        assert_eq!(all(&made), [newer]);
        let (rest, removed) = without(&made, "o.toml", |each| each.loop_name == "FIC101").unwrap();
        assert_eq!((removed, all(&rest).len()), (1, 0));
        assert!(rest.starts_with(b"# of ours") && rest.ends_with(b"# of the next\n"));
        assert_eq!(without(&made, "o.toml", |_| false).unwrap(), (made, 0));
        let inline = format!(
            "override = [{{loop = 'FIC101', verdict = 'sticks', reason = 'x', file = 'a.csv', sha256 = '{SHA}'}}]\n"
        );
        assert_eq!(all(inline.as_bytes()).len(), 1);
        assert!(with(inline.as_bytes(), "o.toml", &one()).is_err());
    }

    #[test]
    fn a_damaged_entry_never_hides_the_others() {
        let other = |name: &str| Override { loop_name: name.to_owned(), ..one() };
        let (first, last) = (in_toml(&other("A")), in_toml(&other("C")));
        let cut = &in_toml(&one())[..50];
        for (middle, loop_name, at) in [
            (cut.as_bytes(), Some("FIC101"), 3),
            (b"[[override]]\nloop = \"B\"\nverdict = \"fine\"\n", Some("B"), 3),
            (b"[[override]]\nloop = \"B\"\nreason = \"\xff\"\n", None, 3),
            (b"[[override]]\nloop = \"B\"\nreason = \"\"\"\nx\n", Some("B"), 6),
            (b"[[overide]]\nloop = \"B\"\n", Some("B"), 1),
            (b"[[override\n", None, 1),
        ] {
            let file = [first.as_bytes(), middle, b"\n", last.as_bytes()].concat();
            let check = |file: &[u8], names: &[&str]| {
                let found = Overrides::parse(file, "o.toml");
                let kept: Vec<_> = found.all.iter().map(|each| &*each.loop_name).collect();
                assert_eq!(kept, names, "{}", String::from_utf8_lossy(file));
                assert_eq!(found.damaged.len(), 1, "{:?}", found.damaged);
                found
            };
            let found = check(&file, &["A", "C"]);
            assert_eq!(found.damaged[0].line, 9 + at, "{:?}", found.damaged);
            assert_eq!(found.damaged[0].loop_name.as_deref(), loop_name);
            let named = found.complaints().next().unwrap();
            assert!(
                named.starts_with("o.toml, line ") && named.contains("the other overrides apply"),
                "{named}"
            );
            let notes = |tag| found.of(&recorded(tag, "a.csv", SHA)).1;
            assert_eq!(notes("A").len(), usize::from(loop_name.is_none()));
            assert_eq!(notes("FIC101").len(), usize::from(loop_name != Some("B")));
            // What is entered and removed beside it leaves it where it is.
            let more = with(&file, "o.toml", &other("D")).unwrap();
            check(&more, &["A", "C", "D"]);
            let (less, removed) = without(&more, "o.toml", |each| each.loop_name != "D").unwrap();
            assert_eq!(removed, 2);
            check(&less, &["D"]);
        }
    }

    #[test]
    fn entries_of_many_at_a_time_are_all_kept() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(FILE_NAME);
        std::thread::scope(|scope| {
            for k in 0..12 {
                let one = Override { loop_name: format!("L{k}"), ..one() };
                let path = &path;
                scope.spawn(move || enter(path, &one).unwrap());
            }
        });
        let found = Overrides::read(&path).unwrap();
        assert_eq!((found.all.len(), found.damaged.len()), (12, 0));
        assert_eq!(remove(&path, |each| each.loop_name == "L3").unwrap(), 1);
        assert_eq!(Overrides::read(&path).unwrap().all.len(), 11);
    }

    #[test]
    fn nothing_is_applied_to_another_loop_or_recording() {
        let overrides = Overrides { all: vec![one()], ..Overrides::default() };
        let found = |tag, file, sha| overrides.of(&recorded(tag, file, sha));
        assert_eq!(found("FIC101", "folder/a.csv", SHA), (Some(&one()), vec![]));
        assert_eq!(found("FIC101", "b.csv", SHA), (None, vec![]));
        for tag in ["fic101", "FIC1011", "FIC10"] {
            assert_eq!(found(tag, "a.csv", SHA), (None, vec![]), "{tag}");
        }
        let (none, notes) = found("FIC101", "a.csv", &"0".repeat(64));
        assert!(none.is_none() && notes[0].contains("the file has changed"), "{notes:?}");
    }

    #[test]
    fn days_bound_what_is_covered() {
        let day = Date::constant(2026, 3, 1);
        let begin = day.to_zoned(TimeZone::UTC).unwrap().timestamp().as_second() as f64;
        let overrides = Overrides { all: vec![for_all(Some(day), day)], ..Overrides::default() };
        let covers = |span| overrides.of(&Recorded { span, ..recorded("FIC101", "x.csv", SHA) });
        assert!(covers(Some((begin, begin + 86_399.0))).0.is_some());
        for span in [Some((begin - 1.0, begin + 9.0)), Some((begin, begin + 86_400.0)), None] {
            let (none, notes) = covers(span);
            assert!(none.is_none() && notes.len() == 1, "{span:?}");
        }
        // One recording goes before all of them, in either order.
        let sure = Override { verdict: VerdictClass::Sticks, ..one() };
        for all in [vec![for_all(None, day), sure.clone()], vec![sure.clone(), for_all(None, day)]]
        {
            let overrides = Overrides { all, ..Overrides::default() };
            let span = Some((begin, begin));
            let found = overrides.of(&Recorded { span, ..recorded("FIC101", "a.csv", SHA) });
            assert_eq!(found.0, Some(&sure));
        }
    }

    #[test]
    fn mistakes_name_the_line_and_the_remedy() {
        let file = format!("file = \"a.csv\"\nsha256 = \"{SHA}\"\n");
        let head = "[[override]]\nloop = \"A\"\nverdict = \"sticks\"\nreason = \"x\"\n";
        let twice = format!("{head}{file}{head}{file}");
        for (text, expected) in [
            ("[[override]]\n", "line 1: override.loop: is missing; give the tag"),
            ("[[override]]\nloop = \"\"\n", "line 2: override.loop: is empty"),
            (
                "[[override]]\nloop = \"A\"\nverdict = \"fine\"\n",
                "line 3: override.verdict: there is no verdict named \"fine\"; known are sticks, does not stick",
            ),
            ("[[override]]\nloop = \"A\"\nverdict = \"sticks\"\n", "override.reason: is missing"),
            (head, "override.file: is missing; name the file, or write all_recordings = true"),
            (&format!("{head}file = \"a.csv\"\n"), "override.sha256: is missing"),
            (
                &format!("{head}file = \"a.csv\"\nsha256 = \"12\"\n"),
                "line 6: override.sha256: must be 64",
            ),
            (
                &format!("{head}all_recordings = true\n"),
                "override.until: is missing; an override of all",
            ),
            (
                &format!("{head}all_recordings = 1\n"),
                "line 5: override.all_recordings: must be true or false",
            ),
            (&format!("{head}all_recordings = true\n{file}"), "exclude each other"),
            (
                &format!("{head}{file}until = \"soon\"\n"),
                "line 7: override.until: must be a date such as",
            ),
            (&format!("{head}{file}until = 3\n"), "line 7: override.until: must be a date such as"),
            (
                &format!("{head}{file}from = 2026-02-02\nuntil = 2026-02-01\n"),
                "line 8: override.until: is before from",
            ),
            (&format!("{head}{file}tag = \"B\"\n"), "line 7: unknown key \"override.tag\""),
            (
                &twice,
                "line 1: [override]: contradicts the override in line 7 on loop A, for this recording, a.csv",
            ),
            ("override = 3\n", "line 1"),
            ("[[override]\n", "line 1"),
        ] {
            let found = Overrides::parse(text.as_bytes(), "o.toml");
            assert_eq!(found.all, []);
            let message = found.complaints().next().unwrap();
            assert!(message.starts_with("o.toml, line "), "{message}");
            assert!(message.contains(expected), "{expected}: {message}");
        }
    }
}
