//! Interprets cells once the role of their column is known.

pub mod mode;
pub mod number;
pub mod quality;
pub mod range;
pub mod signals;
pub mod unit;

/// The word and its meaning in `text`, such as `16=auto`.
fn meaning<T: Copy>(text: &str, names: &[(&str, T)], example: &str) -> Result<(String, T), String> {
    let known = || names.iter().map(|(name, _)| *name).collect::<Vec<_>>().join(", ");
    let wrong = || {
        format!(
            "\"{text}\" is not a word and its meaning, such as {example}; meanings are {}",
            known()
        )
    };
    let (word, meaning) = text.rsplit_once('=').ok_or_else(wrong)?;
    let found = names.iter().find(|(name, _)| name.eq_ignore_ascii_case(meaning.trim()));
    let (_, meaning) = found.ok_or_else(wrong)?;
    Ok((word.trim().to_owned(), *meaning))
}
