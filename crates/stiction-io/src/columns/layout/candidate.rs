//! Interprets the name of a column or tag without other names.

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
    /// Whether its name is CO without a tag, the controller output or carbon monoxide.
    pub is_co: bool,
    pub why: String,
}

impl Candidate {
    pub fn recognised(loop_name: Option<String>, role: Role, why: impl Into<String>) -> Self {
        let why = why.into();
        Self { loop_name, role, given: false, is_mv: false, is_cv: false, is_co: false, why }
    }
}

/// Whether a name has a number, like a tag.
pub fn has_number(name: &str) -> bool {
    name.contains(|c: char| c.is_ascii_digit())
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
        let loop_name = mapped.loop_name.clone().or_else(named);
        let why = "an option or mapping names it";
        return Some(Candidate {
            given: true,
            ..Candidate::recognised(loop_name, mapped.role, why)
        });
    }
    if let Some((split, why)) = split(&why) {
        let is = |word| split.role == Role::Signal(Signal::Op) && role::plain(&split.word) == word;
        return Some(Candidate {
            is_mv: is("mv"),
            is_cv: is("cv"),
            is_co: is("co") && !split.loop_name.as_ref().is_some_and(|of| has_number(of)),
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
