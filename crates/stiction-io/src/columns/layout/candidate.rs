//! Interprets the name of a column or tag on its own.

use super::given::Given;
use crate::columns::role::{self, Role, Signal};

/// A name that was split into its parts, or whose parts the user gave.
pub struct Candidate {
    pub loop_name: Option<String>,
    pub role: Role,
    pub given: bool,
    /// Whether its name is MV, the manipulated variable or the measured valve position.
    pub is_mv: bool,
    /// Whether its name is CV, the control variable or the controlled variable.
    pub is_cv: bool,
    pub why: String,
}

impl Candidate {
    pub fn recognised(loop_name: Option<String>, role: Role, why: impl Into<String>) -> Self {
        Self { loop_name, role, given: false, is_mv: false, is_cv: false, why: why.into() }
    }
}

/// The role of `name` as given or else from its parts.
pub fn candidate(name: &str, given: &Given<'_>) -> Option<Candidate> {
    let options = given.options;
    let split = |why: &dyn Fn(&role::Split) -> String| {
        let by_pattern = options.pattern.as_ref().and_then(|p| p.split(name, &options.signals));
        let by_pattern = by_pattern.map(|split| {
            let pattern = options.pattern.as_ref().map_or("", |pattern| pattern.text());
            let why = format!("it matches the pattern {pattern}");
            (split, why)
        });
        by_pattern.or_else(|| {
            let split = role::split(name, &options.signals)?;
            let why = why(&split);
            Some((split, why))
        })
    };
    let why = |split: &role::Split| match split.role {
        Role::Quality(_) => "its name ends with a word for a quality".to_owned(),
        role if split.loop_name.is_some() => {
            format!("it ends with {}, a word for {role}", split.word)
        }
        role => format!("its name is a word for {role}"),
    };
    if let Some(mapped) = given.mapped(name) {
        let named = || split(&why).and_then(|(split, _)| split.loop_name);
        return Some(Candidate {
            loop_name: mapped.loop_name.clone().or_else(named),
            role: mapped.role,
            given: true,
            is_mv: false,
            is_cv: false,
            why: "an option or mapping names it".to_owned(),
        });
    }
    if let Some((split, why)) = split(&why) {
        let is = |word| split.role == Role::Signal(Signal::Op) && role::plain(&split.word) == word;
        return Some(Candidate {
            is_mv: is("mv"),
            is_cv: is("cv"),
            ..Candidate::recognised(split.loop_name, split.role, why)
        });
    }
    match role::of_rows(name) {
        Some(role @ Role::Quality(None)) => Some(Candidate::recognised(
            None,
            role,
            "its name is a word for the quality of all signals",
        )),
        _ => None,
    }
}
