//! Many loops as a folder with a page per loop and an index that can be sorted, searched and filtered.

use super::diagnosis::{by_rank, report};
use super::head::sizes;
use super::layout::{Badge, STYLE, Section, TABLES, badge, number};
use super::small_trend::{Small, small_trend};
use crate::Error;
use crate::document::{self, Loop};
use crate::words::{self, percent, rough, spoken};
use maud::{DOCTYPE, Markup, PreEscaped, html};
use std::collections::BTreeMap;
use stiction_diagnose::diagnose::{Diagnosis, Estimate, Grade};
use stiction_diagnose::recording::fitness::Class;
use stiction_figure::page::{head, relative};

/// Name of the index.
pub const INDEX: &str = "index.html";
/// Folder of the loops' pages, beside the index.
const LOOPS: &str = "loops";
/// Width of a small trend, px.
const SMALL: f64 = 120.0;

/// Reports on many loops, with a page for each and an index.
#[derive(Debug, Clone)]
pub struct Folder<'a> {
    tool: String,
    /// The loops, worst first.
    loops: Vec<Loop<'a>>,
}

/// The verdict on several windows of a loop, which heads the page of one of them.
#[derive(Debug, Clone, PartialEq)]
pub struct Heading {
    /// The verdict in one graded word.
    pub grade: Grade,
    /// The verdict, a sentence.
    pub verdict: String,
    /// The probability that the valve sticks.
    pub probability: Option<f64>,
    /// S, percent of span.
    pub s: Option<Estimate>,
    /// J, percent of span.
    pub j: Option<Estimate>,
    /// What to do.
    pub actions: Vec<String>,
    /// Whether the actions of the window follow.
    pub continues: bool,
    /// Which window the figures and the evidence show, a sentence.
    pub shows: String,
    /// Relative path of the sheet of the valve's test.
    pub sheet: Option<String>,
}

impl Heading {
    /// Puts the verdict on all windows in place of that on one.
    fn over(&self, section: &mut Section) {
        section.badge = Badge::from(self.grade);
        section.headline.clone_from(&self.verdict);
        section.reasons.insert(0, self.shows.clone());
        let Some(head) = &mut section.head else { return };
        head.probability = self.grade.shown(self.probability);
        // Those of the window, and its detection limit if S is known.
        head.facts.retain(|fact| match &fact.name {
            name if name.starts_with("detection limit") => self.s.is_none(),
            name => !name.starts_with("S, ") && !name.starts_with("J, "),
        });
        head.facts.splice(0..0, sizes(self.s, self.j));
        let own = std::mem::replace(&mut head.actions, self.actions.clone());
        head.actions.extend(own.into_iter().filter(|_| self.continues));
    }
}

impl<'a> Folder<'a> {
    /// A folder of these loops.
    pub fn new(tool: impl Into<String>, loops: &[Loop<'a>]) -> Self {
        Self { tool: tool.into(), loops: by_rank(loops) }
    }

    /// Number of loops.
    pub fn len(&self) -> usize {
        self.loops.len()
    }

    /// Whether there are no loops.
    pub fn is_empty(&self) -> bool {
        self.loops.is_empty()
    }

    /// Path of the page of a loop, relative to the folder, with `/` between folders.
    pub fn path(&self, place: usize) -> String {
        let name = self.loops.get(place).map_or("", |each| &each.diagnosis.name);
        format!("{LOOPS}/{}", file_name(place, name))
    }

    /// The page of a loop, or a page without loops if there is none at that place.
    ///
    /// # Errors
    /// As [`html`](super::html).
    pub fn page(&self, place: usize) -> Result<String, Error> {
        let one = self.loops.get(place..=place).unwrap_or_default();
        report(&self.tool, one).home(format!("../{INDEX}")).html()
    }

    /// The page under the verdict on several windows of the loop.
    ///
    /// # Errors
    /// As [`html`](super::html).
    pub fn page_under(&self, place: usize, heading: &Heading) -> Result<String, Error> {
        let one = self.loops.get(place..=place).unwrap_or_default();
        let mut report = report(&self.tool, one).home(format!("../{INDEX}"));
        report.sheet.clone_from(&heading.sheet);
        report.sections.iter_mut().for_each(|section| heading.over(section));
        report.html()
    }

    /// The index.
    pub fn index(&self) -> String {
        let title = match self.loops.len() {
            1 => "One control loop".to_owned(),
            n => format!("{n} control loops"),
        };
        let page = html! {
            (DOCTYPE)
            html lang="en" {
                (head(&title, &[STYLE]))
                body.index {
                    header { h1 { (title) } }
                    main { (self.chips()) (self.table()) }
                    footer { p { (self.tool) ", format version " (document::VERSION) } }
                    script { (PreEscaped(TABLES)) }
                }
            }
        };
        page.into_string()
    }

    /// A button for each occurring grade with its count, and a checkbox for one row per valve.
    fn chips(&self) -> Markup {
        let mut counts: BTreeMap<Grade, usize> = BTreeMap::new();
        for each in &self.loops {
            *counts.entry(each.diagnosis.verdict.grade).or_default() += 1;
        }
        let several = self.later().contains(&true);
        html! {
            p.chips data-chips {
                @for (grade, count) in counts {
                    button type="button" data-only=(grade.name()) aria-pressed="false" {
                        (badge(&Badge::from(grade))) " " span data-count { (count) }
                    }
                }
                @if several {
                    label { input type="checkbox" data-first; " only the worst row of each valve" }
                }
            }
        }
    }

    /// For each loop, whether an earlier loop has the same name.
    fn later(&self) -> Vec<bool> {
        let mut seen = std::collections::BTreeSet::new();
        self.loops.iter().map(|each| !seen.insert(&each.diagnosis.name)).collect()
    }

    fn table(&self) -> Markup {
        let heads = [
            ("loop", false),
            ("type", false),
            ("verdict", false),
            ("probability of sticking", true),
            ("S, %", true),
            ("period", true),
            ("PV swing ±", true),
            ("OP travel, %/h", true),
            ("data", false),
            ("trend", false),
            ("file", false),
        ];
        let later = self.later();
        html! {
            div.rows tabindex="0" role="region" aria-label="Loops" {
                table data-sortable {
                    thead {
                        tr {
                            @for (name, is_number) in heads {
                                th scope="col" class=[is_number.then_some("number")] { (name) }
                            }
                        }
                    }
                    tbody {
                        @for (place, each) in self.loops.iter().enumerate() {
                            (row(each, &self.path(place), later[place]))
                        }
                    }
                }
            }
        }
    }
}

fn row(Loop { diagnosis, source, .. }: &Loop<'_>, path: &str, later: bool) -> Markup {
    let verdict = &diagnosis.verdict;
    let data = match diagnosis.fitness.class {
        Class::Fit => "fit",
        Class::Caveats => "caveats",
        Class::Unfit => "not fit",
    };
    let oscillation = diagnosis.oscillation().map(|(_, found)| found);
    let period = oscillation.and_then(|found| found.period_s).filter(|p| p.is_finite());
    let swing = oscillation.and_then(|found| found.amplitude).filter(|a| a.is_finite());
    let unit = diagnosis.pv_unit.as_deref().unwrap_or("");
    let travel = diagnosis.kpis.get("OP travel").and_then(|kpi| kpi.value);
    let s = match (diagnosis.stiction.s, verdict.s_below) {
        (Some(s), _) => Some((s.value, rough(s.value))),
        (None, Some(limit)) if verdict.grade.spares() => {
            Some((limit.value, format!("<\u{a0}{}", rough(limit.value))))
        }
        _ => None,
    };
    let said = verdict.overruled.as_ref().map(words::overruled);
    html! {
        tr data-grade=(verdict.grade.name()) data-later[later] {
            td { a href=(relative(path)) { (diagnosis.name) } }
            td { (diagnosis.loop_type.name()) }
            td data-value=(place_of(verdict.grade)) title=[said] {
                (badge(&Badge::from(verdict.grade)))
                @if verdict.overruled.is_some() { " overruled" }
            }
            (cell(verdict.shown_probability().map(|p| (p, percent(p)))))
            (cell(s))
            (cell(period.map(|p| (p, spoken(p)))))
            (cell(swing.map(|a| (a, format!("{} {unit}", rough(a)).trim_end().to_owned()))))
            (cell(travel.map(|t| (t, rough(t)))))
            td { (data) }
            td { (trend(diagnosis)) }
            td.soft { (source.file) }
        }
    }
}

/// A small trend of the PV, or of the OP if there is no PV.
fn trend(diagnosis: &Diagnosis) -> Markup {
    let drawn = small_trend(diagnosis, Small::Pv, SMALL);
    let drawn = drawn.or_else(|| small_trend(diagnosis, Small::Op, SMALL));
    html! { @if let Some(svg) = drawn { (PreEscaped(svg)) } }
}

/// The rank of a grade, worst first.
fn place_of(grade: Grade) -> usize {
    Grade::ALL.iter().position(|each| *each == grade).unwrap_or(Grade::ALL.len())
}

/// A cell with the number used for sorting and its text.
fn cell(of: Option<(f64, String)>) -> Markup {
    match of {
        Some((value, text)) => html! { td.number data-value=(number(value)) { (text) } },
        None => html! { td.number { "–" } },
    }
}

/// The name of a page's file, made from the place of its loop, which is unique, and from the characters of its name
/// that every file system allows.
pub fn file_name(place: usize, name: &str) -> String {
    format!("{:05}-{}.html", place + 1, plain(name))
}

/// The characters of a name that every file system allows.
pub fn plain(name: &str) -> String {
    let plain = |c: char| if c.is_ascii_alphanumeric() || c == '-' { c } else { '_' };
    name.chars().take(60).map(plain).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_have_names_that_any_system_holds() {
        assert_eq!(file_name(0, "FIC-101"), "00001-FIC-101.html");
        assert_eq!(file_name(11, "../Ü/a b"), "00012-_____a_b.html");
    }
}
