//! What a report says of a loop, as data: for a page that is not written once but asks as it goes.
//!
//! [`told`] is the first screen in words, cheap enough to follow a pointer; [`Folds`] is all the rest, whose figures are
//! drawn when they are looked at.

use super::diagnosis;
use super::layout::{Badge, Block, Card, Fact, Table};
use super::{head, verdict};
use crate::Error;
use crate::document::Loop;
use crate::words::{self, sentence};
use schemars::JsonSchema;
use serde::Serialize;
use stiction_figure::Figure;

/// What an engineer with three minutes must know of a loop.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Told {
    /// The conclusion as a word.
    pub badge: Badge,
    /// The conclusion as a sentence or two.
    pub headline: String,
    /// What a person concluded, if one did.
    pub overruled: Option<String>,
    /// The probability that it sticks, in words; null where there is none.
    pub probability: Option<String>,
    /// Type, time, sample time and file.
    pub line: String,
    /// The numbers that go with the conclusion.
    pub facts: Vec<Fact>,
    /// What to do, first things first.
    pub actions: Vec<String>,
    /// The likeliest causes beside a sticking valve.
    pub causes: Vec<Likely>,
    /// What speaks for the conclusion, and what against it.
    pub sides: Vec<Side>,
    /// What is to be known of the data.
    pub remarks: Vec<String>,
}

/// A cause with its likelihood.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Likely {
    /// The cause.
    pub cause: String,
    /// Its likelihood, in words.
    pub likelihood: String,
}

/// Reasons that point one way.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Side {
    /// Which way.
    pub heading: String,
    /// The reasons.
    pub reasons: Vec<String>,
}

/// What is told of a loop. What an action would bring is left to the [folds](Folds): that takes a fit.
pub fn told(case: &Loop<'_>) -> Told {
    let Loop { diagnosis, source } = *case;
    let causes = head::causes(diagnosis)
        .into_iter()
        .map(|(cause, likelihood)| Likely { cause, likelihood: words::percent(likelihood) });
    let sides = verdict::sides(diagnosis).into_iter().map(|(heading, reasons)| Side {
        heading: heading.to_owned(),
        reasons: reasons.iter().map(|reason| sentence(reason)).collect(),
    });
    Told {
        badge: Badge::from(diagnosis.verdict.grade),
        headline: words::verdict(diagnosis),
        overruled: diagnosis.verdict.overruled.as_ref().map(words::overruled),
        probability: diagnosis.verdict.probability.map(words::percent),
        line: head::line(diagnosis, source),
        facts: head::facts(diagnosis),
        actions: head::actions(diagnosis, None),
        causes: causes.collect(),
        sides: sides.collect(),
        remarks: head::remarks(diagnosis),
    }
}

/// All that a report tells beyond its first screen, in folds.
#[derive(Debug, Clone, PartialEq)]
pub struct Folds(Vec<(String, Vec<Block>)>);

impl Folds {
    /// Those of a loop, whose diagnosis should hold its evidence.
    pub fn of(case: &Loop<'_>) -> Self {
        let folds = diagnosis::section(case).blocks.into_iter().filter_map(|block| match block {
            Block::Details { summary, blocks } => Some((summary, blocks)),
            _ => None,
        });
        Self(folds.collect())
    }

    /// What each is about, in their order.
    pub fn summaries(&self) -> Vec<String> {
        self.0.iter().map(|(summary, _)| summary.clone()).collect()
    }

    /// What one of them tells, with its figures drawn; `None` if there is none of that number.
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
        /// It.
        text: String,
    },
    /// A paragraph.
    Paragraph {
        /// It.
        text: String,
    },
    /// A list, with numbers if the order matters.
    List {
        /// Whether the order matters.
        ordered: bool,
        /// What it lists.
        items: Vec<String>,
    },
    /// Names with values.
    Facts {
        /// They.
        facts: Vec<Fact>,
    },
    /// A table.
    Table {
        /// It.
        table: Table,
    },
    /// A picture.
    Picture {
        /// It, as SVG.
        svg: String,
        /// What it shows.
        caption: String,
    },
    /// What a method says.
    Card {
        /// The method.
        heading: String,
        /// What it says, as a word.
        badge: Option<Badge>,
        /// What it says, as a sentence.
        sentence: String,
        /// Its numbers.
        facts: Vec<Fact>,
        /// What to keep in mind.
        caveats: Vec<String>,
        /// Its table and its picture.
        pieces: Vec<Piece>,
    },
    /// What is shown on demand.
    Details {
        /// What is hidden.
        summary: String,
        /// It.
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
