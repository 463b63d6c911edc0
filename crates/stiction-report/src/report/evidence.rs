//! The result of each method, with a figure of its evidence.

use super::layout::{Card, Fact, number};
use super::views::Context;
use crate::words::sentence;
use stiction_diagnose::finding::{Decision, Finding};
use stiction_diagnose::methods::Subject;

pub use stiction_diagnose::methods::figure;

/// The result of a method on a loop, with its figure and numbers. If it abstains, the reason.
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
