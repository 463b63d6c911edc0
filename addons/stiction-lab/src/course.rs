//! The course: six lessons, each with a task that the lab checks.
//!
//! A lesson is a page of `docs/course/`, whose numbered list is the questions, and a line of `LESSONS`. The class number
//! draws the valve and the loops, so all students of a class have the same task. The truth is computed anew for each call,
//! and stays on the server until a teacher asks for the answers. Nothing is stored.

mod code;

use crate::calls::{Answer, Wrong};
use crate::exercise;
use crate::guess::{Trend, mixed, share};
use crate::lab::Lab;
use crate::live::Live;
use crate::loops::{self, LoopRequest};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::ops::RangeInclusive;
use stiction_docs::{contents, markdown};
use stiction_figure::figure::{Figure, Panel};
use stiction_model::limit_cycle::{Cycle, Found, Method};

/// Numbers of classes.
const CLASSES: RangeInclusive<u32> = 1..=9999;
/// Characters of the lines of a class.
const LINES: usize = 100_000;

/// How a question is answered.
enum Kind {
    /// By a number, with its unit and the accepted difference: a share of the truth, or an amount in the unit if that
    /// is more.
    Number(&'static str, f64, f64),
    /// By the number of a choice, from 0.
    Choice,
}
use Kind::{Choice, Number};

/// A lesson.
struct Lesson {
    /// Page.
    page: &'static str,
    /// How its questions are answered.
    kinds: &'static [Kind],
    /// Task for a class.
    task: fn(u32) -> Answer<Task>,
}

/// The task of a class.
#[derive(Default)]
struct Task {
    /// The right answer to each question.
    truth: Vec<f64>,
    /// Trends to read: a title, and the signals.
    trends: Vec<(String, Vec<Trend>)>,
    /// The room to work in, with its state.
    room: Option<String>,
}

/// All lessons.
const LESSONS: [Lesson; 6] = [
    Lesson {
        page: "docs/course/valve.md",
        kinds: &[Number("%", 0.1, 0.3), Number("%", 0.1, 0.3), Number("%", 0.1, 0.3)],
        task: valve,
    },
    Lesson {
        page: "docs/course/trend.md",
        kinds: &[Number("s", 0.1, 0.0), Number("%", 0.15, 0.4), Number("%", 0.1, 0.3), Choice],
        task: trend,
    },
    Lesson {
        page: "docs/course/cycle.md",
        kinds: &[Number("s", 0.02, 0.1), Number("%", 0.03, 0.05), Number("s", 0.03, 0.1), Choice],
        task: cycle,
    },
    Lesson {
        page: "docs/course/causes.md",
        kinds: &[Choice, Choice, Choice, Choice],
        task: causes,
    },
    Lesson {
        page: "docs/course/test.md",
        kinds: &[Choice, Number("%", 0.2, 0.4), Choice],
        task: test,
    },
    Lesson {
        page: "docs/course/repair.md",
        kinds: &[Number("s", 0.1, 0.05), Number("%", 0.03, 0.05), Choice, Choice],
        task: repair,
    },
];

/// The flow loop of the first room with the S and J of a class, and other changes.
fn flow(class: u32, lesson: u32, set: &[&str]) -> LoopRequest {
    let own = mixed(u64::from(class) << 8 | u64::from(lesson));
    let tenth = |x: f64| (10.0 * x).round() / 10.0;
    let s = tenth(3.0 + 4.0 * share(mixed(own ^ 1)));
    // In the last lesson tuning must be able to halve the swing.
    let (least, most) = if lesson == 6 { (0.25, 0.35) } else { (0.3, 0.7) };
    let j = tenth(s * (least + (most - least) * share(mixed(own ^ 2))));
    let bands = [format!("valve.S={s}"), format!("valve.J={j}")];
    LoopRequest::new("lab/flow", bands).with(set)
}

/// The exact cycle of a loop, where it has one.
fn exact(asked: &LoopRequest) -> Answer<Option<Cycle>> {
    let found = Found::of(&loops::continuous(asked)?, Method::Exact, false)?;
    Ok(found.cycles.into_iter().next())
}

/// The exact cycle of a loop that has one.
fn cycling(asked: &LoopRequest) -> Answer<Cycle> {
    exact(asked)?.ok_or_else(|| Wrong::own("this class has no loop that cycles; use another class"))
}

/// The last samples of a valve or loop after some time, s. A loop begins with some time in manual at `op`.
fn recorded(
    asked: LoopRequest,
    op: Option<f64>,
    until_s: f64,
    last_s: f64,
    names: &[&str],
) -> Answer<Vec<Trend>> {
    let mut live = Live::of(asked)?;
    let step = live.sample_time();
    if op.is_some() {
        live.by_hand(op);
        live.go((20.0 / step) as usize)?;
        live.by_hand(None);
    }
    let done = live.go((until_s / step).round() as usize)?;
    let from = done.len() - ((last_s / step).round() as usize).min(done.len());
    let time = || (0..done.len() - from).map(|k| k as f64 * step).collect();
    let signals = [("SP", &done.sp), ("PV", &done.pv), ("OP", &done.op), ("VP", &done.vp)];
    let wanted = signals.into_iter().filter(|(name, _)| names.contains(name));
    Ok(wanted.map(|(name, all)| Trend::new(name, time(), &all[from..])).collect())
}

/// 1: a valve on a slow ramp.
fn valve(class: u32) -> Answer<Task> {
    let asked = flow(class, 1, &["input.amplitude=10"]).of("paper/open-loop-stiction");
    let bands = loops::scenario(&asked)?.valve.1;
    let shown = recorded(asked, None, 120.0, 120.0, &["OP", "VP"])?;
    Ok(Task {
        truth: vec![bands.s(), bands.j(), bands.fd()],
        trends: vec![("A valve on a slow ramp".to_owned(), shown)],
        room: None,
    })
}

/// 2: a loop as its plant records it.
fn trend(class: u32) -> Answer<Task> {
    let asked = flow(class, 2, &["noise.sd=0.03"]);
    let Cycle { period_s, half_pp, .. } = cycling(&asked)?;
    // At rest the loop would not cycle. Half of S from the set point of 50 %, the stem rests J/2 from where it should be.
    let off = 50.0 + loops::scenario(&asked)?.valve.1.s() / 2.0;
    let shown = recorded(asked, Some(off), 900.0, 3.5 * period_s, &["SP", "PV", "OP"])?;
    Ok(Task {
        truth: vec![period_s, 2.0 * half_pp.pv, 2.0 * half_pp.op, 0.0],
        trends: vec![("A flow loop in automatic".to_owned(), shown)],
        room: None,
    })
}

/// 3: the properties on which the cycle depends.
fn cycle(class: u32) -> Answer<Task> {
    let asked = flow(class, 3, &[]);
    let bands = loops::scenario(&asked)?.valve.1;
    let doubled = [format!("valve.S={}", 2.0 * bands.s()), format!("valve.J={}", 2.0 * bands.j())];
    let doubled = flow(class, 3, &doubled.each_ref().map(String::as_str));
    let slower = flow(class, 3, &["controller.kc=0.25"]);
    let goes_on = exact(&flow(class, 3, &["valve.J=0"]))?.is_some();
    Ok(Task {
        truth: vec![
            cycling(&asked)?.period_s,
            cycling(&doubled)?.half_pp.pv,
            cycling(&slower)?.period_s,
            f64::from(u8::from(!goes_on)),
        ],
        room: Some(format!("loop?{}", asked.state())),
        trends: vec![],
    })
}

/// The possible causes, in the order of the choices. Each has a scenario, the changes of it, and the shown times, s.
const CAUSES: [(&str, &[&str], [f64; 2]); 5] = [
    ("samples/sticky-flow", &[], [600.0, 1200.0]),
    ("lab/flow", &["valve.S=90", "valve.J=40", "set_point.value=46"], [0.0, 600.0]),
    ("samples/disturbed-flow", &[], [600.0, 1200.0]),
    ("samples/aggressive-flow", &[], [300.0, 600.0]),
    ("samples/quantised-level", &["resolution.pv=0.5"], [3600.0, 7200.0]),
];

/// 4: four loops of different causes, one of them a valve that sticks.
fn causes(class: u32) -> Answer<Task> {
    let own = mixed(u64::from(class) << 8 | 4);
    let mut order: Vec<usize> = (1..CAUSES.len()).collect();
    order.sort_by_key(|k| mixed(own ^ *k as u64));
    let sticks = own as usize % order.len();
    order[sticks] = 0;
    let mut task = Task::default();
    for (cause, name) in order.into_iter().zip('A'..) {
        let (scenario, set, [from_s, to_s]) = CAUSES[cause];
        let drawn = match cause {
            0 => flow(class, 4, &[]),
            2 => LoopRequest::new("", [format!("load.0.period={}", 50 + own % 50)]),
            _ => LoopRequest::new("", []),
        };
        let seed = format!("noise.seed={}", own % 1000);
        let asked = drawn.of(scenario).with(set).with(&[&seed]);
        task.truth.push(cause as f64);
        let shown = recorded(asked, None, to_s, to_s - from_s, &["SP", "PV", "OP"])?;
        task.trends.push((format!("Loop {name}"), shown));
    }
    Ok(task)
}

/// 5: a valve to test by hand.
fn test(class: u32) -> Answer<Task> {
    let (sticks, s) = exercise::truth(class);
    Ok(Task {
        truth: vec![f64::from(u8::from(!sticks)), s, 1.0],
        room: Some(format!("exercise?seed={class}")),
        trends: vec![],
    })
}

/// 6: a loop that is tuned too tightly, with a valve that sticks.
fn repair(class: u32) -> Answer<Task> {
    let hasty = |ti: f64| flow(class, 6, &["controller.kc=0.9", &format!("controller.ti={ti}")]);
    let swing = |ti: f64| Answer::Ok(cycling(&hasty(ti))?.half_pp.pv);
    // The shortest integral time that halves the swing, by bisection.
    let (mut short, mut long) = (HASTY_S, 30.0);
    let half = swing(short)? / 2.0;
    for _ in 0..30 {
        let middle = f64::sqrt(short * long);
        *(if swing(middle)? > half { &mut short } else { &mut long }) = middle;
    }
    let slow = flow(class, 6, &["controller.kc=0.1", "controller.ti=30"]);
    Ok(Task {
        truth: vec![long, cycling(&slow)?.half_pp.pv, 1.0, 2.0],
        room: Some(format!("loop?{}", hasty(HASTY_S).state())),
        trends: vec![],
    })
}

/// The integral time of a loop that is tuned too tightly, s.
const HASTY_S: f64 = 0.3;

/// The requested lesson.
#[derive(Debug, Clone, Copy, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Which {
    /// Number, from 1.
    lesson: u32,
    /// The number of the class, from 1 to 9999.
    class: u32,
}

/// A lesson with its task, without the answers.
#[derive(Debug, Serialize, JsonSchema)]
pub struct Shown {
    /// The titles of all lessons.
    titles: Vec<String>,
    /// The text of this one, as HTML.
    html: String,
    /// The questions.
    questions: Vec<Question>,
    /// Trends to read.
    trends: Vec<Titled>,
    /// The trends as a figure to print.
    svg: Option<String>,
    /// The room to work in, with its state.
    room: Option<String>,
}

/// A question.
#[derive(Debug, Serialize, JsonSchema)]
pub struct Question {
    /// The question.
    ask: String,
    /// The unit of the answer, if it is a number.
    unit: String,
    /// The choices; none if the answer is a number.
    choices: Vec<String>,
}

/// Trends of a loop.
#[derive(Debug, Serialize, JsonSchema)]
pub struct Titled {
    /// Their title.
    title: String,
    /// The signals.
    signals: Vec<Trend>,
}

/// Answers to be checked.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Answered {
    /// The number of the lesson, from 1.
    lesson: u32,
    /// The number of the class.
    class: u32,
    /// The name of the student.
    name: String,
    /// How often the answers were checked, with this one.
    tries: u32,
    /// The answers: numbers, or numbers of choices from 0; null without one.
    answers: Vec<Option<f64>>,
}

/// Checked answers.
#[derive(Debug, Serialize, JsonSchema)]
pub struct Checked {
    /// Whether each is right.
    right: Vec<bool>,
    /// The line for the teacher: name and code.
    line: String,
}

/// A class.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Class {
    /// Number.
    class: u32,
}

/// The answers of a lesson.
#[derive(Debug, Serialize, JsonSchema)]
pub struct Answers {
    /// The title of the lesson.
    title: String,
    /// The answers in order, with the other accepted answers.
    answers: Vec<String>,
}

/// Lines of a class, each with name and code.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Lines {
    /// The lines.
    lines: String,
}

/// The table of a class.
#[derive(Debug, Serialize, JsonSchema)]
pub struct Table {
    /// The results, by student and lesson.
    rows: Vec<Row>,
    /// Lines that were refused, each with the reason.
    refused: Vec<Refused>,
}

/// The result of a student in a lesson.
#[derive(Debug, Serialize, JsonSchema)]
pub struct Row {
    /// The student.
    student: String,
    /// The number of the lesson.
    lesson: u32,
    /// Title.
    title: String,
    /// The number of the class.
    class: u32,
    /// Whether each answer is right.
    right: Vec<bool>,
    /// How often the answers were checked; 7 for 7 or more.
    tries: u32,
}

/// A line without a result.
#[derive(Debug, Serialize, JsonSchema)]
pub struct Refused {
    /// Number, from 1.
    line: usize,
    /// Text.
    text: String,
    /// The reason.
    why: String,
}

impl Lesson {
    fn of(number: u32) -> Answer<&'static Self> {
        let index = (number as usize).wrapping_sub(1);
        LESSONS.get(index).ok_or_else(|| {
            Wrong::gone(format!("there is no lesson {number}; ask for 1 to {}", LESSONS.len()))
        })
    }

    /// Page.
    fn text(&self) -> &'static str {
        contents::markdown_of(self.page).unwrap_or_default()
    }

    /// Title, without `Lesson 1:`.
    fn title(&self) -> String {
        let head = self.text().lines().next().unwrap_or_default();
        head.split_once(": ").map_or(head, |(_, title)| title).to_owned()
    }

    /// Text before the questions, and the questions.
    fn parts(&self) -> (&'static str, Vec<Question>) {
        let list = self.text().find("\n1. ").map_or(0, |before| before + 1);
        let (text, list) = self.text().split_at(list);
        let mut questions: Vec<Question> = vec![];
        for line in list.lines() {
            let words = line.trim();
            let numbered = line.split_once(". ").filter(|(n, _)| n.parse::<u8>().is_ok());
            match (questions.last_mut(), numbered, words.strip_prefix("- ")) {
                (_, Some((_, ask)), _) => {
                    let unit = match self.kinds.get(questions.len()) {
                        Some(Number(unit, ..)) => (*unit).to_owned(),
                        _ => String::new(),
                    };
                    questions.push(Question { ask: ask.to_owned(), unit, choices: vec![] });
                }
                (Some(question), None, Some(choice)) => question.choices.push(choice.to_owned()),
                (Some(question), None, None) if !words.is_empty() => {
                    let longer = question.choices.last_mut().unwrap_or(&mut question.ask);
                    *longer += &format!(" {words}");
                }
                _ => {}
            }
        }
        (text, questions)
    }

    fn task(&self, class: u32) -> Answer<Task> {
        if !CLASSES.contains(&class) {
            return Err(Wrong::request(format!(
                "the number of a class is from {} to {}, not {class}",
                CLASSES.start(),
                CLASSES.end()
            )));
        }
        (self.task)(class)
    }
}

impl Kind {
    fn accepts(&self, truth: f64, answer: Option<f64>) -> bool {
        let most = match self {
            Number(_, share, least) => (share * truth.abs()).max(*least) * (1.0 + 1e-9),
            Choice => 0.0,
        };
        answer.is_some_and(|answer| (answer - truth).abs() <= most)
    }
}

/// A lesson for a class.
///
/// # Errors
/// If there is no such lesson or class.
pub fn lesson(_: &Lab, which: Which) -> Answer<Shown> {
    let lesson = Lesson::of(which.lesson)?;
    let Task { trends, room, .. } = lesson.task(which.class)?;
    let (text, questions) = lesson.parts();
    // One loop is drawn large, to be measured; several are side by side.
    let (height, columns) = if trends.len() == 1 { (230.0, 1) } else { (110.0, 2) };
    let mut figure = Figure::new("").width(900.0).panel_height(height).columns(columns);
    for (title, signals) in &trends {
        for (y, names) in [("PV, SP", ["SP", "PV"]), ("% of span", ["OP", "VP"])] {
            let of = signals.iter().filter(|each| names.contains(&each.name()));
            let panel = of.map(Trend::series).fold(Panel::new("time (s)", y), Panel::with);
            if !panel.series.is_empty() {
                figure = figure.with(panel.title(&**title));
            }
        }
    }
    Ok(Shown {
        titles: LESSONS.iter().map(Lesson::title).collect(),
        html: markdown::unlinked(text),
        questions,
        svg: (!figure.panels.is_empty()).then(|| figure.svg()).transpose().map_err(Wrong::own)?,
        trends: trends.into_iter().map(|(title, signals)| Titled { title, signals }).collect(),
        room,
    })
}

/// Checks answers.
///
/// # Errors
/// If there is no such lesson or class, no name, or another number of answers than of questions.
pub fn check(_: &Lab, asked: Answered) -> Answer<Checked> {
    let lesson = Lesson::of(asked.lesson)?;
    let name = asked.name.split_whitespace().collect::<Vec<_>>().join(" ");
    if name.is_empty() || name.chars().count() > 80 {
        return Err(Wrong::request("enter a name of 1 to 80 letters; the code needs the name"));
    }
    if asked.answers.len() != lesson.kinds.len() {
        return Err(Wrong::request(format!(
            "this lesson has {} questions, and {} answers were sent",
            lesson.kinds.len(),
            asked.answers.len()
        )));
    }
    let truth = lesson.task(asked.class)?.truth;
    let pairs = lesson.kinds.iter().zip(truth).zip(&asked.answers);
    let right: Vec<bool> = pairs.map(|((kind, truth), said)| kind.accepts(truth, *said)).collect();
    let marks = right.iter().rev().fold(0, |marks, right| marks << 1 | u32::from(*right));
    let done =
        code::Result { lesson: asked.lesson, class: asked.class, tries: asked.tries.max(1), marks };
    Ok(Checked { right, line: format!("{name}, {}", done.code(&name)) })
}

/// The answers to all lessons, for the teacher of a class.
///
/// # Errors
/// If there is no such class.
pub fn answers(_: &Lab, class: Class) -> Answer<Vec<Answers>> {
    let of = |lesson: &Lesson| {
        let (_, questions) = lesson.parts();
        let pairs = lesson.kinds.iter().zip(lesson.task(class.class)?.truth).zip(&questions);
        let answer = |((kind, truth), question): ((&Kind, f64), &Question)| match kind {
            Number(unit, share, least) => {
                let most = (share * truth.abs()).max(*least);
                format!("{truth:.2} {unit} (± {most:.2})")
            }
            Choice => question.choices.get(truth as usize).cloned().unwrap_or_default(),
        };
        Ok(Answers { title: lesson.title(), answers: pairs.map(answer).collect() })
    };
    LESSONS.iter().map(of).collect()
}

/// The table of a class from its lines, each with a name and a code.
///
/// # Errors
/// If there are too many.
pub fn read(_: &Lab, asked: Lines) -> Answer<Table> {
    if asked.lines.len() > LINES {
        return Err(Wrong::request(format!("more than {LINES} characters; paste fewer lines")));
    }
    let mut table = Table { rows: vec![], refused: vec![] };
    for (text, line) in asked.lines.lines().zip(1..).filter(|(text, _)| !text.trim().is_empty()) {
        let separates = |c: char| c.is_whitespace() || c == ',' || c == ';';
        let text = text.trim_matches(separates);
        let (name, code) = text.rsplit_once(separates).unwrap_or(("", text));
        let student = name.trim_matches(separates).to_owned();
        match code::Result::read(&student, code) {
            Ok(code::Result { lesson, class, tries, marks }) => {
                let of = Lesson::of(lesson)?;
                let right = (0..of.kinds.len()).map(|k| marks >> k & 1 == 1).collect();
                table.rows.push(Row { student, lesson, title: of.title(), class, right, tries });
            }
            Err(why) => table.refused.push(Refused { line, text: text.to_owned(), why }),
        }
    }
    table.rows.sort_by_key(|row| (row.student.to_lowercase(), row.lesson));
    Ok(table)
}
