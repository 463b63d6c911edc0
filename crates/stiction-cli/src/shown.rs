//! Makes text safe for a terminal.

use std::borrow::Cow;

/// Text that is safe for a terminal. Control characters, and those that change the reading direction, are written as
/// `\u{1b}`. Line breaks are kept.
pub fn shown(text: &str) -> Cow<'_, str> {
    escaped(text, |c| steers(c) && !matches!(c, '\n' | '\t'))
}

/// Safe text within a line, such as a tag or a file name.
pub fn name(text: &str) -> Cow<'_, str> {
    escaped(text, steers)
}

/// Whether a character controls a terminal or the reading direction.
pub fn steers(c: char) -> bool {
    c.is_control()
        || matches!(c, '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
}

fn escaped(text: &str, is_meant: impl Fn(char) -> bool) -> Cow<'_, str> {
    if !text.contains(&is_meant) {
        return text.into();
    }
    let mut out = String::new();
    for c in text.chars() {
        if is_meant(c) { out.extend(c.escape_unicode()) } else { out.push(c) }
    }
    out.into()
}

#[cfg(test)]
mod tests {
    use super::{name, shown};

    #[test]
    fn what_steers_a_terminal_is_written_out() {
        assert_eq!(shown("a\tb\nc \u{1b}[2J"), "a\tb\nc \\u{1b}[2J");
        assert_eq!(name("a\nb\r\u{202e}\u{9b}"), "a\\u{a}b\\u{d}\\u{202e}\\u{9b}");
        assert_eq!(shown("Hägglund, 5 ÷ 2 − 1"), "Hägglund, 5 ÷ 2 − 1");
    }
}
