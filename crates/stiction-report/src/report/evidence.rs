//! What each method says, with a figure of what it says it by.

use super::layout::{Card, Fact, number};
use super::views::Context;
use crate::words::sentence;
use stiction_diagnose::finding::{Decision, Finding};
use stiction_diagnose::methods::Subject;

pub use stiction_diagnose::methods::figure;

/// What a method says of a loop, with its figure and its numbers; of one that abstains, why.
pub fn card(finding: &Finding, subject: Option<&Subject<'_>>, context: &Context<'_>) -> Card {
    let mut card =
        Card::new(finding.method.title, sentence(&finding.reason)).badge(finding.decision);
    card.caveats = finding.caveats.iter().map(|caveat| sentence(caveat)).collect();
    if finding.decision != Decision::Abstains {
        card.figure = subject.and_then(|subject| figure(finding, subject, context));
    }
    let numbers = finding.numbers.iter();
    card.facts.extend(numbers.map(|each| Fact::new(each.name, number(each.value), each.unit)));
    card
}
