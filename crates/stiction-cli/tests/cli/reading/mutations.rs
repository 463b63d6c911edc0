//! Clean files, each spoilt once or twice: no panic, and no verdict is turned to its opposite without a note that names
//! the reason. `STICTION_FILES=2000` is the whole.

use super::in_process::{Judged, Random, Sampled, for_each, judged, shown};
use super::{clock, count, folder, run};
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::panic::catch_unwind;

const SEED: u64 = 4804;

/// The form of a clean file.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Form {
    Seconds,
    Dated,
    German,
    Long,
}

/// A row: its time and its other cells.
#[derive(Clone)]
struct Row {
    t: f64,
    cells: Vec<String>,
    /// Number of its cells that are written.
    kept: usize,
    end: Option<&'static str>,
}

/// A file as a table of text.
struct Text {
    form: Form,
    above: Vec<String>,
    header: Vec<String>,
    rows: Vec<Row>,
    below: String,
    spare: String,
    /// What is between two times that are written, s.
    resolution: f64,
    pattern: &'static str,
    end: &'static str,
    last: fn(String) -> Vec<u8>,
}

/// A signal of the loop: PV, SP and OP in this order.
const SIGNALS: [&str; 3] = ["PV", "SP", "OP"];

fn tag(signal: usize) -> String {
    format!("FIC1.{}", SIGNALS[signal])
}

impl Text {
    fn of(form: Form, of: &Sampled) -> Self {
        let names: &[&str] = match form {
            Form::Seconds => &["t", "pv", "sp", "op"],
            Form::Dated => &["Time", "FIC1.PV", "FIC1.SP", "FIC1.OP"],
            Form::German => &["Zeit", "FIC1.PV", "FIC1.SP", "FIC1.OP"],
            Form::Long => &["Time", "Tag", "Value"],
        };
        let mut rows = vec![];
        for k in 0..of.len() {
            let values = [of.pv[k], of.sp[k], of.op[k]].map(shown);
            let mut row = |cells: Vec<String>| {
                let kept = cells.len() + 1;
                rows.push(Row { t: k as f64 * of.step, cells, kept, end: None });
            };
            match form {
                Form::Long => {
                    for (signal, value) in values.into_iter().enumerate() {
                        row(vec![tag(signal), value]);
                    }
                }
                _ => row(values.to_vec()),
            }
        }
        Self {
            form,
            above: vec![],
            header: names.iter().map(|&name| name.to_owned()).collect(),
            rows,
            below: String::new(),
            spare: String::new(),
            resolution: 1e-3,
            pattern: if form == Form::German {
                "%d.%m.%Y %H:%M:%S%.3f"
            } else {
                "%Y-%m-%d %H:%M:%S%.3f"
            },
            end: "\n",
            last: String::into_bytes,
        }
    }

    fn between(&self) -> &'static str {
        if self.form == Form::German { ";" } else { "," }
    }

    fn bytes(&self) -> Vec<u8> {
        let between = self.between();
        let mut text: String =
            self.above.iter().map(|line| format!("{line}{}", self.end)).collect();
        if !self.header.is_empty() {
            text += &self.header.join(between);
            text += self.end;
        }
        for row in &self.rows {
            let t = (row.t / self.resolution).round() * self.resolution;
            let time = match self.form {
                Form::Seconds => shown(t),
                _ => clock(self.pattern, t),
            };
            let written = |cell: &String| match self.form {
                Form::German if cell.parse::<f64>().is_ok() => cell.replace('.', ","),
                _ => cell.clone(),
            };
            let cells: Vec<String> =
                std::iter::once(time).chain(row.cells.iter().map(written)).collect();
            text += &cells[..row.kept.min(cells.len())].join(between);
            text += row.end.unwrap_or(self.end);
        }
        (self.last)(text + &self.below)
    }

    /// The cell of a signal in one of its samples, chosen at random.
    fn cell(&mut self, signal: usize, random: &mut Random) -> &mut String {
        let samples = self.samples();
        let k = random.below(samples);
        self.cell_of(signal, k)
    }

    fn samples(&self) -> usize {
        if self.form == Form::Long { self.rows.len() / 3 } else { self.rows.len() }
    }

    /// The cell of a signal in sample `k`; any other if an earlier mutation took it away.
    fn cell_of(&mut self, signal: usize, k: usize) -> &mut String {
        let (row, cell) = match self.form {
            Form::Long => (3 * k + signal, 1),
            _ => (k, signal),
        };
        let found = self.rows.get_mut(row).and_then(|row| row.cells.get_mut(cell));
        found.unwrap_or(&mut self.spare)
    }

    /// The name of a column, if the header is still there.
    fn name(&mut self, column: usize) -> &mut String {
        self.header.get_mut(column).unwrap_or(&mut self.spare)
    }

    /// Changes all values of a signal that are numbers.
    fn all(&mut self, signal: usize, change: impl Fn(f64) -> f64) {
        for k in 0..self.samples() {
            let cell = self.cell_of(signal, k);
            if let Ok(value) = cell.parse() {
                *cell = shown(change(value));
            }
        }
    }

    fn put(&mut self, signal: usize, word: &str, most: usize, random: &mut Random) {
        for _ in 0..1 + random.below(most) {
            *self.cell(signal, random) = word.to_owned();
        }
    }

    /// The header or tag of a signal becomes another.
    fn rename(&mut self, signal: usize, name: &str) {
        if self.form != Form::Long {
            *self.name(1 + signal) = name.to_owned();
            return;
        }
        let tag = tag(signal);
        let tags = self.rows.iter_mut().map(|row| &mut row.cells[0]);
        tags.filter(|of| **of == tag).for_each(|of| *of = name.to_owned());
    }

    /// Each of two signals gets the header or tag of the other.
    fn exchange(&mut self, one: usize, other: usize) {
        if self.form != Form::Long {
            self.rename(one, &SIGNALS[other].to_lowercase());
            self.rename(other, &SIGNALS[one].to_lowercase());
            return;
        }
        for of in self.rows.iter_mut().map(|row| &mut row.cells[0]) {
            if *of == tag(one) {
                *of = tag(other);
            } else if *of == tag(other) {
                *of = tag(one);
            }
        }
    }

    /// Puts rows below the header, others if the form is long.
    fn rows_below(&mut self, wide: &[&[&str]], long: &[&[&str]]) {
        let rows = if self.form == Form::Long { long } else { wide };
        let between = self.between();
        self.above.push(self.header.join(between));
        self.above.extend(rows.iter().map(|row| row.join(between)));
        self.header = vec![];
    }

    fn any_row(&mut self, random: &mut Random) -> &mut Row {
        let at = random.below(self.rows.len());
        &mut self.rows[at]
    }

    /// A place in the middle half.
    fn middle(&self, random: &mut Random) -> usize {
        let n = self.samples();
        let k = n / 4 + random.below(n / 2);
        if self.form == Form::Long { 3 * k } else { k }
    }

    /// The rows from a place in the middle half on.
    fn rest(&mut self, random: &mut Random) -> impl Iterator<Item = &mut Row> {
        let at = self.middle(random);
        self.rows[at..].iter_mut()
    }
}

/// A way to spoil a file, and words of which a note must have one if the verdict changes to its opposite.
type Mutation = (&'static str, fn(&mut Text, &mut Random), &'static [&'static str]);

const VALUES: &[&str] =
    &["mask", "no measurement", "bad", "missing", "bridged", "usable", "9999", "32768"];
const CLOCKS: &[&str] = &[
    "time",
    "clock",
    "again",
    "restart",
    "order",
    "missing",
    "segment",
    "duplicate",
    "bridged",
    "row",
];
const ROWS: &[&str] = &["row", "line", "torn", "short", "skipped", "missing", "bridged", "cut"];
const NAMES: &[&str] = &["column", "tag", "not used", "unused", "header", "no pv", "row"];
const UNITS: &[&str] = &["range", "percent", "unit", "fraction", "column"];

const SENTINELS: [&str; 6] = ["-9999", "9999", "-999.25", "1e31", "-32768", "327.67"];

const MUTATIONS: &[Mutation] = &[
    ("sentinel in PV", |text, r| text.put(0, r.of_these(&SENTINELS), 20, r), VALUES),
    ("sentinel in OP", |text, r| text.put(2, r.of_these(&SENTINELS), 20, r), VALUES),
    ("sentinel in SP", |text, r| text.put(1, r.of_these(&SENTINELS[..4]), 5, r), VALUES),
    ("zero in PV", |text, r| text.put(0, "0", 10, r), VALUES),
    (
        "spike in PV",
        |text, r| {
            let cell = text.cell(0, r);
            *cell = shown(3.0 * cell.parse::<f64>().unwrap_or(1.0) + 50.0);
        },
        VALUES,
    ),
    ("Bad in PV", |text, r| text.put(0, "Bad", 20, r), VALUES),
    ("I/O Timeout in OP", |text, r| text.put(2, "I/O Timeout", 10, r), VALUES),
    ("unknown word in PV", |text, r| text.put(0, "kaputt", 3, r), VALUES),
    ("empty PV", |text, r| text.put(0, "", 40, r), VALUES),
    ("empty OP", |text, r| text.put(2, "", 40, r), VALUES),
    (
        "frozen PV",
        |text, r| {
            let from = r.below(text.samples() - 40);
            let held = text.cell_of(0, from).clone();
            (from..from + 40).for_each(|k| *text.cell_of(0, k) = held.clone());
        },
        &["frozen", "does not change", "updates"],
    ),
    (
        "zeros at the end",
        |text, _| {
            let n = text.samples();
            for k in n - n / 10..n {
                *text.cell_of(0, k) = "0".to_owned();
                *text.cell_of(2, k) = "0".to_owned();
            }
        },
        &["mask", "no measurement", "frozen", "does not change", "rests at", "flat", "shut"],
    ),
    (
        "another decimal mark in a cell",
        |text, r| {
            let cell = text.cell(0, r);
            *cell = format!(
                "\"{}\"",
                if cell.contains('.') { cell.replace('.', ",") } else { cell.clone() + ",5" }
            );
        },
        &["decimal", "mark", "comma", "mask"],
    ),
    (
        "thousands marked",
        |text, _| {
            let (group, mark) = if text.form == Form::German { (".", ",") } else { (",", ".") };
            for k in 0..text.samples() {
                for signal in [0, 1] {
                    let cell = text.cell_of(signal, k);
                    if let Ok(value) = cell.parse::<f64>() {
                        *cell = format!(
                            "\"{}\"",
                            super::grouped(1000.0 + 10.0 * value.abs(), 8, group, mark)
                        );
                    }
                }
            }
        },
        &["decimal", "thousand", "mark"],
    ),
    (
        "an extra delimiter in some rows",
        |text, r| {
            for _ in 0..5 {
                let row = text.any_row(r);
                row.cells.push(String::new());
                row.kept += 1;
            }
        },
        ROWS,
    ),
    (
        "another delimiter in a row",
        |text, r| {
            let row = text.any_row(r);
            row.cells = vec![row.cells.join("|")];
            row.kept = 2;
        },
        ROWS,
    ),
    ("PV renamed", |text, _| text.rename(0, "Messung 7"), NAMES),
    ("OP renamed", |text, _| text.rename(2, "Kanal 3"), NAMES),
    ("SP renamed", |text, _| text.rename(1, "X17"), NAMES),
    (
        "PV and OP exchanged",
        |text, _| text.exchange(0, 2),
        &["column", "mistaken", "exchanged", "swapped", "belong"],
    ),
    (
        "PV and SP exchanged",
        |text, _| text.exchange(0, 1),
        &["column", "mistaken", "exchanged", "swapped", "belong", "set point", "sp"],
    ),
    (
        "a name twice",
        |text, _| {
            let name = text.name(1).clone();
            let other = if text.form == Form::Long { 2 } else { 3 };
            *text.name(other) = name;
        },
        NAMES,
    ),
    (
        "a row of units",
        |text, _| text.rows_below(&[&["", "m3/h", "m3/h", "%"]], &[&["", "", "%"]]),
        NAMES,
    ),
    (
        "rows of units and descriptions",
        |text, _| {
            text.rows_below(
                &[&["", "m3/h", "m3/h", "%"], &["", "feed", "feed", "feed"]],
                &[&["", "", "unit"], &["", "the tag", "the value"]],
            )
        },
        NAMES,
    ),
    ("no header", |text, _| text.header = vec![], NAMES),
    (
        "titles above",
        |text, _| {
            text.above.extend(["Trend export".to_owned(), "Plant: North".to_owned(), String::new()])
        },
        NAMES,
    ),
    (
        "a trailer",
        |text, r| {
            text.below = r
                .of_these(&["End of data\n", "$RT_COUNT$;7200\n", "(1200 rows affected)\n"])
                .to_owned()
        },
        ROWS,
    ),
    (
        "a clock that restarts",
        |text, r| {
            let (at, first) = (text.middle(r), text.rows[0].t);
            let from = text.rows[at].t;
            text.rows[at..].iter_mut().for_each(|row| row.t += first - from);
        },
        CLOCKS,
    ),
    (
        "a clock of three runs",
        |text, _| {
            let third = text.rows.len() / 9 * 3;
            let length = text.rows[third].t - text.rows[0].t;
            for run in 1..3 {
                let end = if run == 2 { text.rows.len() } else { 2 * third };
                text.rows[run * third..end].iter_mut().for_each(|row| row.t -= run as f64 * length);
            }
        },
        CLOCKS,
    ),
    ("a gap of an hour", |text, r| text.rest(r).for_each(|row| row.t += 3600.0), CLOCKS),
    (
        "an hour back",
        |text, r| {
            text.rows.iter_mut().for_each(|row| row.t += 4000.0);
            text.rest(r).for_each(|row| row.t -= 3600.0);
        },
        CLOCKS,
    ),
    (
        "rows twice",
        |text, r| {
            for _ in 0..8 {
                let at = r.below(text.rows.len());
                text.rows.insert(at, text.rows[at].clone());
            }
        },
        CLOCKS,
    ),
    (
        "a block twice",
        |text, r| {
            let at = text.middle(r);
            let block = text.rows[at - 30..at].to_vec();
            text.rows.splice(at..at, block);
        },
        CLOCKS,
    ),
    (
        "neighbours exchanged",
        |text, r| {
            for _ in 0..10 {
                let at = r.below(text.rows.len() - 4);
                text.rows.swap(at, at + 3);
            }
        },
        CLOCKS,
    ),
    (
        "a block moved",
        |text, r| {
            let at = text.middle(r);
            text.rows.rotate_left(at)
        },
        CLOCKS,
    ),
    ("newest first", |text, _| text.rows.reverse(), CLOCKS),
    (
        "times without their last digits",
        |text, _| {
            let step = text.rows[6].t - text.rows[0].t;
            text.resolution = (5.0 * step).max(1.0);
        },
        CLOCKS,
    ),
    (
        "shaken times",
        |text, r| {
            let step = (text.rows[3].t - text.rows[0].t) / 3.0;
            text.rows
                .iter_mut()
                .for_each(|row| row.t += 5.0 + step * 0.3 * (r.below(1000) as f64 / 500.0 - 1.0));
        },
        CLOCKS,
    ),
    (
        "rows lost",
        |text, r| {
            let at = text.middle(r);
            let most = if text.form == Form::Long { 60 } else { 20 };
            text.rows.drain(at..at + most);
        },
        CLOCKS,
    ),
    ("a short row", |text, r| text.any_row(r).kept = 2, ROWS),
    ("two rows in one", |text, r| text.any_row(r).end = Some(""), ROWS),
    (
        "a blank line",
        |text, r| {
            let end = text.end;
            text.any_row(r).end = Some(if end == "\n" { "\n\n" } else { "\r\n\r\n" })
        },
        ROWS,
    ),
    ("cut in a number", |text, _| text.last = |t| t.as_bytes()[..t.len() - 6].to_vec(), ROWS),
    ("OP as fractions", |text, _| text.all(2, |op| op / 100.0), UNITS),
    ("OP in mA, unnamed", |text, _| text.all(2, |op| 4.0 + 0.16 * op), UNITS),
    ("OP in counts", |text, _| text.all(2, |op| (40.95 * op).round()), UNITS),
    (
        "OP in mA, named",
        |text, _| {
            text.all(2, |op| 4.0 + 0.16 * op);
            if text.form != Form::Long {
                *text.name(3) += " [mA]"
            }
        },
        UNITS,
    ),
    ("OP reversed", |text, _| text.all(2, |op| 100.0 - op), UNITS),
    (
        "PV in other units",
        |text, _| {
            text.all(0, |pv| 1.8 * pv + 32.0);
            text.all(1, |sp| 1.8 * sp + 32.0)
        },
        UNITS,
    ),
    ("a byte order mark", |text, _| text.last = |t| format!("\u{feff}{t}").into_bytes(), NAMES),
    (
        "UTF-16",
        |text, _| {
            text.last = |t| {
                [0xfeff].into_iter().chain(t.encode_utf16()).flat_map(u16::to_le_bytes).collect()
            }
        },
        NAMES,
    ),
    (
        "Windows-1252",
        |text, _| {
            if text.form != Form::Long {
                *text.name(1) += " [m³/h]"
            }
            text.last = |t| t.chars().map(|c| u8::try_from(u32::from(c)).unwrap_or(b'?')).collect();
        },
        NAMES,
    ),
    ("CR LF", |text, _| text.end = "\r\n", ROWS),
    ("CR", |text, _| text.end = "\r", ROWS),
    (
        "mixed ends",
        |text, _| text.rows.iter_mut().step_by(7).for_each(|row| row.end = Some("\r\n")),
        ROWS,
    ),
    (
        "a zero byte",
        |text, _| {
            text.last = |t| [&t[..t.len() / 2], "\0", &t[t.len() / 2..]].concat().into_bytes()
        },
        ROWS,
    ),
];

/// What became of a spoilt file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Outcome {
    Same,
    OtherNamed,
    Refused,
    OtherSilent,
    OppositeNamed,
    OppositeSilent,
    Panic,
}

struct Spoilt {
    names: Vec<&'static str>,
    outcome: Outcome,
    line: String,
    bytes: Vec<u8>,
    message: Option<String>,
}

fn spoil(index: usize) -> Spoilt {
    let mut random = Random::of(SEED, index);
    let (form, clean) = loop {
        let clean = Sampled::member(SEED, random.below(4000));
        let form = random.of_these(&[Form::Seconds, Form::Dated, Form::German, Form::Long]);
        let found = judged(&Text::of(form, &clean).bytes(), "loop.csv");
        let found =
            found.unwrap_or_else(|e| panic!("a clean file of the form {form:?} is refused: {e}"));
        // Only a clear verdict can be turned.
        let clear = found.grade.accuses() || found.probability.is_some_and(|p| p < 0.2);
        if clear && clean.len() >= 300 && clean.step <= 60.0 {
            break (form, (clean, found));
        }
    };
    let (clean, right) = clean;
    let mut text = Text::of(form, &clean);
    let chosen: Vec<&Mutation> = match index % 10 {
        // Some are spoilt twice.
        0..3 => (0..2).map(|_| &MUTATIONS[random.below(MUTATIONS.len())]).collect(),
        _ => vec![&MUTATIONS[index % MUTATIONS.len()]],
    };
    let names: Vec<_> = chosen.iter().map(|(name, ..)| *name).collect();
    let at = format!("file {index}, {form:?}, {}", names.join(" and "));
    chosen.iter().for_each(|(_, change, _)| change(&mut text, &mut random));
    let bytes = text.bytes();
    let found = catch_unwind(|| judged(&bytes, "loop.csv"));
    let (outcome, line, message) = match found {
        Err(_) => (Outcome::Panic, at, None),
        Ok(Err(message)) => (Outcome::Refused, format!("{at}: {message}"), Some(message)),
        Ok(Ok(found)) => {
            let named = names_it(&found, &right, &chosen);
            // Rows that vanish without a word are a silent change, too.
            let lost = !named && 10 * found.samples < 6 * right.samples;
            let same = found.grade == right.grade && !lost;
            let outcome = match (same, found.is_opposite(&right), named) {
                (true, ..) => Outcome::Same,
                (_, true, true) => Outcome::OppositeNamed,
                (_, true, false) => Outcome::OppositeSilent,
                (_, false, true) => Outcome::OtherNamed,
                (_, false, false) => Outcome::OtherSilent,
            };
            let words = found.new_words(&right);
            (
                outcome,
                format!(
                    "{at}: {} ({:?}), clean {} ({:?}); {words:?}",
                    found.grade, found.probability, right.grade, right.probability
                ),
                None,
            )
        }
    };
    Spoilt { names, outcome, line, bytes, message }
}

/// Whether a new note has a word that names a mutation.
fn names_it(found: &Judged, right: &Judged, chosen: &[&Mutation]) -> bool {
    let words = found.new_words(right).join("\n").to_lowercase();
    chosen.iter().any(|(_, _, named)| named.iter().any(|word| words.contains(word)))
}

#[test]
fn spoilt_files_turn_no_verdict_silently() {
    let files = count("STICTION_FILES", 60);
    let all = for_each(files, spoil);
    let mut table: BTreeMap<&str, BTreeMap<Outcome, usize>> = BTreeMap::new();
    for each in &all {
        let name = if let [one] = each.names[..] { one } else { "two of them" };
        *table.entry(name).or_default().entry(each.outcome).or_default() += 1;
    }
    let mut shown = format!(
        "{:34} {:>6} {:>6} {:>8} {:>7} {:>9} {:>9}\n",
        "mutation", "same", "named", "refused", "SILENT", "opposite", "OPPOSITE"
    );
    for (name, counts) in &table {
        let of = |outcome| counts.get(&outcome).copied().unwrap_or(0);
        let _ = writeln!(
            shown,
            "{name:34} {:6} {:6} {:8} {:7} {:9} {:9}",
            of(Outcome::Same),
            of(Outcome::OtherNamed),
            of(Outcome::Refused),
            of(Outcome::OtherSilent),
            of(Outcome::OppositeNamed),
            of(Outcome::OppositeSilent)
        );
    }
    println!("{shown}");
    // Of a whole run, the lines of all that changed are kept beside the table.
    let kept = folder("reading-mutations");
    let lines: String = all
        .iter()
        .filter(|each| each.outcome != Outcome::Same)
        .fold(String::new(), |text, each| text + &format!("{:?}: {}\n", each.outcome, each.line));
    super::write(&kept, "changed.txt", format!("{shown}\n{lines}"));
    println!("all that changed: {}", kept.join("changed.txt").display());
    let bad: Vec<_> = all
        .iter()
        .filter(|each| matches!(each.outcome, Outcome::Panic | Outcome::OppositeSilent))
        .collect();
    for each in bad.iter().take(20) {
        let name = each.line.split(',').next().unwrap_or_default().replace(' ', "-");
        super::write(&kept, &format!("{name}.csv"), &each.bytes);
    }
    let lines: Vec<&str> = bad.iter().take(20).map(|each| &*each.line).collect();
    // A verdict decides neither before nor after: "probably" one and the other.
    let probably = |each: &&&Spoilt| {
        let words = ["probably fine", "probably sticks"];
        each.outcome == Outcome::OppositeSilent && words.iter().all(|word| each.line.contains(word))
    };
    let turned = bad.iter().filter(probably).count();
    assert!(
        bad.len() == turned && 30 * turned <= files,
        "{} of {files} panic or turn a verdict silently\n{}\n\n{shown}",
        bad.len(),
        lines.join("\n")
    );
}

/// Every option that a refusal of a spoilt file proposes can be given, and leads to another answer than the same
/// refusal.
#[test]
fn advice_on_spoilt_files_leads_on() {
    let files = count("STICTION_FILES", 60);
    let refused: Vec<_> =
        for_each(files, spoil).into_iter().filter(|each| each.message.is_some()).collect();
    let kept = folder("reading-advice");
    let (mut followed, mut none, mut wrong) = (0, vec![], vec![]);
    for (index, each) in refused.iter().enumerate() {
        let name = format!("{index}.csv");
        super::write(&kept, &name, &each.bytes);
        let message = run(&kept, &["inspect", &name]).err;
        let options = super::proposed(&message);
        if options.is_empty() {
            none.push(format!("{}: {}", each.names.join(" and "), message.trim()));
        }
        for (option, value) in options {
            // Only the user knows it.
            if value.contains("COLUMN") || value.contains("TAG") || value.contains("LOW,HIGH") {
                continue;
            }
            let mut arguments = vec!["inspect", &*name, &*option];
            arguments.extend((!value.is_empty()).then_some(&*value));
            let again = run(&kept, &arguments);
            followed += 1;
            let usage = again.err.contains("--help") || again.err.contains("unexpected");
            if usage || again.err.trim() == message.trim() {
                wrong.push(format!(
                    "{}: {option} {value}: {}\n  after: {}",
                    each.names.join(" and "),
                    again.err.trim(),
                    message.trim()
                ));
            }
        }
    }
    println!(
        "advice: {} refusals, {followed} options followed, {} without an option",
        refused.len(),
        none.len()
    );
    none.sort();
    none.dedup();
    super::write(&kept, "without-an-option.txt", none.join("\n"));
    println!("without an option: {}", kept.join("without-an-option.txt").display());
    assert!(
        wrong.is_empty(),
        "{} of {followed} options lead nowhere\n{}\n",
        wrong.len(),
        wrong.join("\n")
    );
}
