//! The content of a report on a loop as data, for an interactive page.
//!
//! [`first_screen()`] returns the first screen in words, and is fast enough to follow a pointer. [`Folds`] contains the
//! remaining sections, with figures that are drawn when shown.

use super::diagnosis;
use super::layout::{Badge, Block, Card, Fact, Table};
use super::{head, verdict};
use crate::Error;
use crate::document::Loop;
use crate::words::{self, sentence};
use schemars::JsonSchema;
use serde::Serialize;
use stiction_figure::Figure;

/// The information that an engineer with three minutes needs.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct FirstScreen {
    /// The conclusion as a word.
    pub badge: Badge,
    /// The conclusion as a sentence or two.
    pub headline: String,
    /// The conclusion of a person, if there is one.
    pub overruled: Option<String>,
    /// The probability of sticking, in words; null if unknown.
    pub probability: Option<String>,
    /// Type, time, sample time and file.
    pub line: String,
    /// The numbers that go with the conclusion.
    pub facts: Vec<Fact>,
    /// The actions, most urgent first.
    pub actions: Vec<String>,
    /// The likeliest causes besides a sticking valve.
    pub causes: Vec<Likely>,
    /// Evidence for and against the conclusion.
    pub sides: Vec<Side>,
    /// Remarks on the data.
    pub remarks: Vec<String>,
}

/// A cause with its likelihood.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Likely {
    /// The cause.
    pub cause: String,
    /// Likelihood, in words.
    pub likelihood: String,
}

/// Reasons for or against the conclusion.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Side {
    /// The heading of these reasons.
    pub heading: String,
    /// The reasons.
    pub reasons: Vec<String>,
}

/// The first screen of a loop. The effects of actions need its fit.
pub fn first_screen(case: &Loop<'_>) -> FirstScreen {
    let Loop { diagnosis, source, fitted } = *case;
    let causes = head::causes(diagnosis)
        .into_iter()
        .map(|(cause, likelihood)| Likely { cause, likelihood: words::percent(likelihood) });
    let sides = verdict::sides(diagnosis).into_iter().map(|(heading, reasons)| Side {
        heading: heading.to_owned(),
        reasons: reasons.iter().map(|reason| sentence(reason)).collect(),
    });
    FirstScreen {
        badge: Badge::from(diagnosis.verdict.grade),
        headline: words::verdict(diagnosis),
        overruled: diagnosis.verdict.overruled.as_ref().map(words::overruled),
        probability: diagnosis.verdict.shown_probability().map(words::percent),
        line: head::line(diagnosis, source),
        facts: head::facts(diagnosis),
        actions: head::actions(diagnosis, fitted),
        causes: causes.collect(),
        sides: sides.collect(),
        remarks: head::remarks(diagnosis),
    }
}

/// All content of a report beyond its first screen, in folds.
#[derive(Debug, Clone, PartialEq)]
pub struct Folds(Vec<(String, Vec<Block>)>);

impl Folds {
    /// The folds of a loop, whose diagnosis should contain its evidence.
    pub fn of(case: &Loop<'_>) -> Self {
        let folds = diagnosis::section(case).blocks.into_iter().filter_map(|block| match block {
            Block::Details { summary, blocks } => Some((summary, blocks)),
            _ => None,
        });
        Self(folds.collect())
    }

    /// The titles of the folds, in order.
    pub fn summaries(&self) -> Vec<String> {
        self.0.iter().map(|(summary, _)| summary.clone()).collect()
    }

    /// The content of a fold, with its figures drawn; `None` if there is no fold of that number.
    ///
    /// # Errors
    /// If a figure cannot be drawn.
    pub fn pieces(&self, number: usize) -> Option<Result<Vec<Piece>, Error>> {
        self.0.get(number).map(|(_, blocks)| pieces(blocks))
    }
}

/// A piece of a fold.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
#[serde(tag = "is", rename_all = "kebab-case")]
pub enum Piece {
    /// A heading.
    Heading {
        /// The heading.
        text: String,
    },
    /// A paragraph.
    Paragraph {
        /// The paragraph.
        text: String,
    },
    /// A list, with numbers if the order matters.
    List {
        /// Whether the order matters.
        ordered: bool,
        /// Items.
        items: Vec<String>,
    },
    /// Names with values.
    Facts {
        /// The facts.
        facts: Vec<Fact>,
    },
    /// A table.
    Table {
        /// The table.
        table: Table,
    },
    /// A picture.
    Picture {
        /// The picture, as SVG.
        svg: String,
        /// Caption.
        caption: String,
    },
    /// The result of a method.
    Card {
        /// The method.
        heading: String,
        /// Conclusion, as a word.
        badge: Option<Badge>,
        /// Conclusion, as a sentence.
        sentence: String,
        /// Numbers.
        facts: Vec<Fact>,
        /// Caveats.
        caveats: Vec<String>,
        /// Table and its picture.
        pieces: Vec<Piece>,
    },
    /// Content shown on demand.
    Details {
        /// The title of the content.
        summary: String,
        /// The content.
        pieces: Vec<Piece>,
    },
}

fn pieces(blocks: &[Block]) -> Result<Vec<Piece>, Error> {
    blocks.iter().map(piece).collect()
}

fn piece(block: &Block) -> Result<Piece, Error> {
    Ok(match block {
        Block::Heading(text) => Piece::Heading { text: text.clone() },
        Block::Paragraph(text) => Piece::Paragraph { text: text.clone() },
        Block::List { ordered, items } => Piece::List { ordered: *ordered, items: items.clone() },
        Block::Facts(facts) => Piece::Facts { facts: facts.clone() },
        Block::Table(table) => Piece::Table { table: table.clone() },
        Block::Figure(figure) => picture(figure)?,
        Block::Card(card) => of_card(card)?,
        Block::Details { summary, blocks } => {
            Piece::Details { summary: summary.clone(), pieces: pieces(blocks)? }
        }
    })
}

fn picture(figure: &Figure) -> Result<Piece, Error> {
    Ok(Piece::Picture { svg: figure.svg()?, caption: figure.caption.clone() })
}

fn of_card(card: &Card) -> Result<Piece, Error> {
    let mut inside: Vec<Piece> =
        card.figure.as_ref().map(picture).transpose()?.into_iter().collect();
    inside.extend(card.table.clone().map(|table| Piece::Table { table }));
    Ok(Piece::Card {
        heading: card.heading.clone(),
        badge: card.badge,
        sentence: card.sentence.clone(),
        facts: card.facts.clone(),
        caveats: card.caveats.clone(),
        pieces: inside,
    })
}
