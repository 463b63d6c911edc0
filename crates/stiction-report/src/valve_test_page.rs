//! The page of a valve test or signature, or of two tests before and after a repair, for the records of the maintenance
//! planner.

use crate::Error;
use crate::document::Source;
use crate::report::layout::{Badge, Fact, Report, Section, Table};
use crate::report::views::{self, Context};
use crate::valve_test_figure::{self, Ramped};
use crate::words::{self, percent, rough, sentence};
use stiction_diagnose::diagnose::Estimate;
use stiction_diagnose::recording::Recording;
use stiction_diagnose::spoken::{counted, time};
use stiction_diagnose::valve_test::{
    Comparison, PlanComparison, Signature, TestReading, same_loop,
};
use stiction_figure::{Annotation, Figure};

/// A test with its recording.
#[derive(Debug, Clone, Copy)]
pub struct Tested<'a> {
    /// The file of the recording.
    pub source: &'a Source,
    /// The recording.
    pub recording: &'a Recording,
    /// The result of the test.
    pub test: &'a TestReading,
}

/// A time on the recording's clock as a date in plant time, or as elapsed time if there is no date.
pub fn moment(recording: &Recording, at: f64) -> String {
    at_moment(&context(recording), at)
}

fn at_moment(context: &Context<'_>, at: f64) -> String {
    context.date(at).unwrap_or_else(|| time(at))
}

fn context(recording: &Recording) -> Context<'_> {
    Context {
        start: recording.start,
        plant_time: Some(&recording.plant_time),
        pv_unit: recording.pv.as_ref().and_then(|pv| pv.unit.as_deref()),
        modes: recording.mode.as_ref(),
        period_s: None,
    }
}

/// Start and end of a test.
fn span(recording: &Recording, test: &TestReading) -> String {
    format!("{} to {}", moment(recording, test.from_s), moment(recording, test.to_s))
}

/// S of a test in words, or its limit.
fn s_in_words(test: &TestReading) -> String {
    match (test.s, test.s_below) {
        (Some(s), _) => words::interval(s),
        (None, Some(limit)) => format!("below {} % (95 % confidence)", rough(limit)),
        (None, None) => "not known".to_owned(),
    }
}

/// Two results side by side: the name of each value, and how to write it of one result.
fn side_by_side<T: Copy>(
    caption: &str,
    [before, after]: [T; 2],
    rows: &[(&str, &dyn Fn(T) -> String)],
) -> Table {
    let table = Table::new(caption).words("").words("before").words("after");
    let row = |table: Table, (name, of): &(&str, &dyn Fn(T) -> String)| {
        table.row([(*name).to_owned(), of(before), of(after)])
    };
    rows.iter().fold(table, row)
}

fn estimate(of: Option<Estimate>) -> String {
    of.map_or("–".to_owned(), words::interval)
}

fn difference(found: &Comparison) -> Fact {
    let d = found.difference.map_or("not known".to_owned(), |d| d.words().replace('-', "\u{2212}"));
    Fact::new("difference of S, with its 90 % interval", d, "")
}

/// A warning if the tags of two recordings differ.
pub fn caution(before: Tested<'_>, after: Tested<'_>) -> Option<String> {
    let (a, b) = (&before.recording.name, &after.recording.name);
    (!same_loop(a, b)).then(|| {
        format!(
            "The recordings have different tags, {a} and {b}. The comparison holds only if both recordings are of the same valve."
        )
    })
}

/// The result of a test, without its figures and turns.
pub fn in_brief(tested: Tested<'_>) -> Section {
    let Tested { recording, test, .. } = tested;
    let badge = Badge { word: test.word(), ..Badge::from(test.class) };
    let mut section = Section::new(&recording.name, badge, headline(test));
    section.facts = facts(tested);
    section.reasons = reasons(test);
    section
}

fn reasons(test: &TestReading) -> Vec<String> {
    test.reasons.iter().chain(&test.advice).map(|text| sentence(text)).collect()
}

/// The page of one test.
///
/// # Errors
/// If a figure cannot be drawn. This is not expected, because signals out of range are left out.
pub fn reading(tool: &str, tested: Tested<'_>) -> Result<String, Error> {
    let context = context(tested.recording);
    let section = drawn(in_brief(tested), answers(tested.test, &context));
    let section = of_test(section, tested.test, &context).heading("Agreed").with(agreed());
    let report = Report::new(format!("Valve test of {}", section.name), tool);
    report.source(tested.source).with(section).html()
}

/// The comparison of two tests with a repair between them, without figures and turns.
pub fn compared(before: Tested<'_>, after: Tested<'_>, found: &Comparison) -> Section {
    let mut section = in_brief(after);
    let caution = caution(before, after);
    section.headline =
        caution.iter().chain(&found.sentences).cloned().collect::<Vec<_>>().join(" ");
    section.facts = vec![difference(found)];
    section.reasons.clear();
    section.with(side_by_side(
        "The two tests, side by side.",
        [before, after],
        &[
            ("recording", &|of| of.recording.name.clone()),
            ("test", &|of| span(of.recording, of.test)),
            ("verdict", &|of| of.test.word().to_owned()),
            ("probability that it sticks", &|of| percent(of.test.probability)),
            ("S", &|of| s_in_words(of.test)),
            ("J", &|of| estimate(of.test.j)),
            ("response time", &|of| of.test.response_s.map_or("–".to_owned(), time)),
            ("turns", &|of| {
                let answered = of.test.steps.iter().filter(|step| step.answered).count();
                format!("{}, {answered} answered", of.test.turned)
            }),
        ],
    ))
}

/// The page of two tests with a repair between them.
///
/// # Errors
/// As for [`reading()`].
pub fn comparison(
    tool: &str,
    before: Tested<'_>,
    after: Tested<'_>,
    found: &Comparison,
) -> Result<String, Error> {
    let title = |word: &str, of: Tested<'_>| match of.recording.start {
        Some(_) => format!("{word}, {}", moment(of.recording, of.test.from_s)),
        None => word.to_owned(),
    };
    let (old, new) = (title("before", before), title("after", after));
    let tests = [(&*old, before.test), (&*new, after.test)];
    let mut section = drawn(
        compared(before, after, found),
        valve_test_figure::before_and_after(tests, context(after.recording).pv_unit).width(WIDTH),
    );
    section = section.heading("Agreed").with(agreed());
    for (word, one) in [("Before the repair", before), ("After the repair", after)] {
        section = section.heading(word).list(reasons(one.test));
        section = of_test(section, one.test, &context(one.recording));
    }
    let report = Report::new(format!("Valve of {} before and after a repair", section.name), tool);
    report.source(before.source).source(after.source).with(section).html()
}

/// A signature with its recording.
#[derive(Debug, Clone, Copy)]
pub struct Signed<'a> {
    /// The file of the recording.
    pub source: &'a Source,
    /// The recording.
    pub recording: &'a Recording,
    /// The result.
    pub signature: &'a Signature,
}

impl<'a> Signed<'a> {
    /// Start and end of the ramps.
    fn span(self) -> String {
        let of = self.signature;
        format!("{} to {}", moment(self.recording, of.from_s), moment(self.recording, of.to_s))
    }

    /// The recorded OP and VP of the ramps.
    pub fn ramped(self) -> Ramped<'a> {
        Ramped::of(self.recording, self.signature)
    }

    /// The result, without its figure.
    pub fn in_brief(self) -> Section {
        let badge = Badge::from(self.signature.class);
        let mut section = Section::new(&self.recording.name, badge, self.headline());
        section.facts = self.facts();
        section.reasons = self.reasons();
        section
    }

    fn reasons(self) -> Vec<String> {
        self.signature.reasons.iter().map(|text| sentence(text)).collect()
    }

    fn facts(self) -> Vec<Fact> {
        let of = self.signature;
        let estimate = |of: Option<Estimate>| of.map_or("not known".to_owned(), words::interval);
        vec![
            Fact::new("ramps", format!("{}, {}", of.ramps, self.span()), ""),
            Fact::new("S, stick band plus dead band", estimate(of.s), ""),
            Fact::new("J, slip jump", estimate(of.j), ""),
            Fact::new(
                match of.characteristic {
                    Some(_) => "travel of the PV, as a position",
                    None => "travel of the stem",
                },
                format!("{} to {}", rough(of.vp[0]), rough(of.vp[1])),
                "%",
            ),
        ]
    }

    fn headline(self) -> String {
        use stiction_diagnose::diagnose::VerdictClass as Class;
        let s = self.signature.s.map_or("not known".to_owned(), words::interval);
        match self.signature.class {
            Class::Sticks => match self.signature.binds {
                Some([from, to]) => format!(
                    "The valve sticks, and binds between {} and {} % of its stroke. Elsewhere S is {s}.",
                    rough(from),
                    rough(to)
                ),
                None => format!("The valve sticks. S is {s}."),
            },
            Class::DoesNotStick => format!("The valve does not stick. S is {s}."),
            Class::DoesNotRespond => "The valve does not respond to the OP.".to_owned(),
            Class::CannotTell => "The signature is inconclusive.".to_owned(),
        }
    }
}

/// The page of one signature.
///
/// # Errors
/// As for [`reading()`].
pub fn signature(tool: &str, of: Signed<'_>) -> Result<String, Error> {
    let figure = valve_test_figure::signature("", &of.ramped()).width(WIDTH);
    let section = drawn(of.in_brief(), Figure { title: String::new(), ..figure });
    let section = section.heading("Agreed").with(agreed());
    let report = Report::new(format!("Valve signature of {}", section.name), tool);
    report.source(of.source).with(section).html()
}

/// The comparison of two signatures with a repair between them, without figures.
pub fn compared_signatures(both: [Signed<'_>; 2], found: &Comparison) -> Section {
    let mut section = both[1].in_brief();
    section.headline = found.sentences.join(" ");
    section.facts = vec![difference(found)];
    section.reasons.clear();
    section.with(side_by_side(
        "The two signatures, side by side.",
        both,
        &[
            ("recording", &|of| of.recording.name.clone()),
            ("ramps", &|of| of.span()),
            ("verdict", &|of| of.signature.class.name().to_owned()),
            ("S", &|of| estimate(of.signature.s)),
            ("J", &|of| estimate(of.signature.j)),
            ("binds between", &|of| {
                let words = |[from, to]: [f64; 2]| format!("{} and {} %", rough(from), rough(to));
                of.signature.binds.map_or("–".to_owned(), words)
            }),
        ],
    ))
}

/// The page of two signatures with a repair between them.
///
/// # Errors
/// As for [`reading()`].
pub fn signatures(
    tool: &str,
    [before, after]: [Signed<'_>; 2],
    found: &Comparison,
) -> Result<String, Error> {
    let both = [before.ramped(), after.ramped()];
    let figure = valve_test_figure::signatures([("before", &both[0]), ("after", &both[1])]);
    let section = drawn(compared_signatures([before, after], found), figure.width(WIDTH));
    let mut section = section.heading("Agreed").with(agreed());
    for (word, one) in [("Before the repair", before), ("After the repair", after)] {
        section = section.heading(word).list(one.reasons());
    }
    let report = Report::new(format!("Valve of {} before and after a repair", section.name), tool);
    report.source(before.source).source(after.source).with(section).html()
}

/// Width of a figure that fits a phone, px.
const WIDTH: f64 = 560.0;

/// The answers to the turns.
pub(crate) fn answers(test: &TestReading, context: &Context<'_>) -> Figure {
    let figure = valve_test_figure::figure("", context.pv_unit, test).width(WIDTH);
    Figure { title: String::new(), ..figure }
}

fn headline(test: &TestReading) -> String {
    use stiction_diagnose::diagnose::VerdictClass as Class;
    let p = percent(test.probability);
    match test.class {
        Class::Sticks => format!("The valve sticks. S is {}.", s_in_words(test)),
        Class::DoesNotStick => {
            format!("The valve {}. S is {}.", test.word(), s_in_words(test))
        }
        Class::DoesNotRespond => "The valve does not respond to the OP.".to_owned(),
        Class::CannotTell if test.is_elsewhere() => format!(
            "The test is inconclusive. A dead band downstream of the valve explains the answers better than a dead band of the valve, whose probability is {p}."
        ),
        Class::CannotTell => {
            format!("The test is inconclusive. The probability that the valve sticks is {p}.")
        }
    }
}

fn facts(of: Tested<'_>) -> Vec<Fact> {
    let test = of.test;
    let mut all = vec![
        Fact::new("test", span(of.recording, test), ""),
        Fact::new("probability that it sticks", percent(test.probability), ""),
        Fact::new("S, stick band plus dead band", s_in_words(test), ""),
    ];
    all.extend(test.j.map(|j| Fact::new("J, slip jump", words::interval(j), "")));
    all.extend(test.response_s.map(|s| Fact::new("response time", time(s), "")));
    all.push(Fact::new("source of the turns", format!("the {}", test.known_by.name()), ""));
    all
}

/// Adds the comparison of a test with its plan, if planned.
pub fn carried(section: Section, test: &TestReading) -> Section {
    match &test.plan {
        Some(carried) => section.with(planned(carried)).list(carried.remarks.clone()),
        None => section,
    }
}

/// The trend, the comparison with the plan, and the turns of a test, if it has any.
pub(crate) fn of_test(mut section: Section, test: &TestReading, context: &Context<'_>) -> Section {
    if let Some(figure) = trend(test, context) {
        section = drawn(section, figure);
    }
    let table = (!test.steps.is_empty()).then(|| turns(test, context));
    carried(section, test).with_all(table)
}

/// A figure that cannot be drawn is left out.
fn drawn(section: Section, figure: Figure) -> Section {
    if figure.check().is_ok() { section.with(figure) } else { section }
}

/// The test and the time around it.
fn trend(test: &TestReading, context: &Context<'_>) -> Option<Figure> {
    let last = test.recorded.iter().rfind(|segment| !segment.is_empty())?;
    let axis = context.time_axis(last.from + last.duration());
    let mut figure = views::trends(&test.recorded, 0, context)?;
    let band = Annotation::x_band(axis.at(test.from_s), axis.at(test.to_s), "test");
    let panels = std::mem::take(&mut figure.panels).into_iter();
    figure.panels = panels.map(|panel| panel.note(band.clone())).collect();
    Some(figure)
}

/// The planned and actual sizes.
fn planned(carried: &PlanComparison) -> Table {
    let table = Table::new(format!(
        "Test and plan: the test has {}, and the plan has at least {} for the planned sizes below.",
        counted(carried.turns, "turn"),
        carried.turns_planned
    ))
    .columns(
        "#part | #planned [%] | #made [%] | #turns | #answered | #hold at most | #longest hold",
    );
    let or = |value: Option<f64>, words: fn(f64) -> String| value.map_or("–".to_owned(), words);
    carried.sizes.iter().fold(table, |table, size| {
        table.row([
            size.part.to_string(),
            or(size.planned, rough),
            or(size.made, rough),
            size.turns.to_string(),
            size.answered.to_string(),
            or(size.hold_planned_s, time),
            or(size.hold_s, time),
        ])
    })
}

fn turns(test: &TestReading, context: &Context<'_>) -> Table {
    let unit = test.unit(context.pv_unit);
    let caption =
        format!("The turns, with the answer of the {} and its standard deviation.", test.who());
    let table = Table::new(caption)
        .columns("#turn | set at | #OP [%] | #turned by [%]")
        .numbers("answer", unit)
        .numbers("deviation", unit)
        .words("answered");
    let least = test.steps.iter().filter_map(|step| step.error).fold(f64::INFINITY, f64::min);
    // All answers have the digits that show the least deviation to a tenth.
    let digits = match least > 0.0 && least < 1.0 {
        true => (1.0 - least.log10().floor()).clamp(0.0, 9.0) as usize,
        false => 1,
    };
    (1..).zip(&test.steps).fold(table, |table, (k, step)| {
        let or = |value: Option<f64>| value.map_or("–".to_owned(), rough);
        let fixed = |value: Option<f64>| match value {
            Some(value) => format!("{value:.digits$}").replace('-', "\u{2212}"),
            None => "–".to_owned(),
        };
        table.row([
            format!("{k}"),
            at_moment(context, step.at_s),
            format!("{:.2}", step.op),
            or(step.travel),
            fixed(step.answer),
            fixed(step.error),
            if step.answered { "yes" } else { "no" }.to_owned(),
        ])
    })
}

/// Lines to sign.
fn agreed() -> Table {
    let table = Table::new("").words("for").words("name").words("date").words("signature");
    let (line, date) = ("_________", "______");
    let people = ["operation", "maintenance"];
    people.into_iter().fold(table, |table, of| table.row([of, line, date, line]))
}
