//! Formats numbers, durations, paragraphs and columns for a terminal.

use crate::shown::name;
use anstyle::{AnsiColor, Reset, Style};
use std::borrow::Cow;
use stiction::diagnose::Grade;
use stiction_report::report::{Badge, Block, Column, Fact, Section, Table};
use unicode_width::UnicodeWidthStr;

/// A number with at most four digits, as in reports but with an ASCII minus sign.
pub fn number(value: f64) -> String {
    stiction_report::report::layout::number(value).replace('\u{2212}', "-")
}

/// A paragraph broken into lines of at most `width` columns, between words.
pub fn wrapped(text: &str, width: usize) -> Vec<String> {
    let mut lines = vec![String::new()];
    for word in text.split_whitespace() {
        let last = lines.len() - 1;
        let line = &mut lines[last];
        if !line.is_empty() && width_of(line) + 1 + width_of(word) > width {
            lines.push(word.to_owned());
        } else {
            if !line.is_empty() {
                line.push(' ');
            }
            line.push_str(word);
        }
    }
    lines
}

/// A paragraph of lines with at most `width` columns. `head` precedes the first line, and blanks precede the others.
pub fn hanging(head: &str, text: &str, width: usize) -> String {
    let blank = " ".repeat(head.len());
    let lines = wrapped(text, width).into_iter().enumerate();
    lines.map(|(k, line)| format!("{}{line}\n", if k == 0 { head } else { &blank })).collect()
}

/// A paragraph of 96 columns.
pub fn paragraph(text: &str) -> String {
    hanging("", text, 96)
}

/// A paragraph below its name.
pub fn field(name: &str, text: &str) -> String {
    hanging(&format!("{name:10}"), text, 88)
}

/// Characters that begin a coloured word, by colour, and one that ends it. Unicode reserves them for internal use by
/// programs. Control characters are escaped on output, so colours are inserted after that.
const COLOURS: [(char, AnsiColor); 5] = [
    ('\u{fdd0}', AnsiColor::Red),
    ('\u{fdd1}', AnsiColor::Yellow),
    ('\u{fdd2}', AnsiColor::Cyan),
    ('\u{fdd3}', AnsiColor::Green),
    ('\u{fdd4}', AnsiColor::Blue),
];
const END: char = '\u{fdd5}';

/// A word on the verdict in the colour of its grade. Output other than a terminal gets no colour.
pub fn coloured(grade: Grade, word: &str) -> String {
    let place = match grade {
        Grade::Sticks | Grade::DoesNotRespond => 0,
        Grade::ProbablySticks => 1,
        Grade::Unclear => 2,
        Grade::ProbablyFine | Grade::NoneVisible | Grade::TooLittle | Grade::Fine => 3,
        Grade::CannotAnswer => 4,
    };
    format!("{}{word}{END}", COLOURS[place].0)
}

fn is_mark(c: &char) -> bool {
    ('\u{fdd0}'..=END).contains(c)
}

/// Text with the colours of a terminal.
pub fn painted(text: &str) -> String {
    let mut out = String::new();
    for c in text.chars() {
        match COLOURS.iter().find(|(mark, _)| *mark == c) {
            Some((_, colour)) => {
                let style = Style::new().bold().fg_color(Some((*colour).into()));
                out += &style.render().to_string();
            }
            None if c == END => out += &Reset.render().to_string(),
            None => out.push(c),
        }
    }
    out
}

/// Width of a text in columns, without its colours.
fn width_of(text: &str) -> usize {
    text.chars().filter(|c| !is_mark(c)).collect::<String>().width()
}

/// Rows in columns separated by two blanks. `right` marks columns aligned right.
pub fn columns(rows: &[impl AsRef<[String]>], right: &[bool]) -> String {
    // A cell is one line, with any tag.
    let rows: Vec<Vec<Cow<'_, str>>> =
        rows.iter().map(|row| row.as_ref().iter().map(|cell| name(cell)).collect()).collect();
    let width: Vec<usize> = (0..right.len())
        .map(|c| rows.iter().map(|row| width_of(&row[c])).max().unwrap_or(0))
        .collect();
    let mut out = String::new();
    for row in &rows {
        let mut line = String::new();
        for (c, cell) in row.iter().enumerate() {
            let blank = " ".repeat(width[c] - width_of(cell));
            let (before, after) =
                if right[c] { (blank.as_str(), "") } else { ("", blank.as_str()) };
            line += &format!("{before}{cell}{after}  ");
        }
        out += line.trim_end();
        out.push('\n');
    }
    out
}

/// A table of a report in columns, its caption above it. Graded words have colours instead of symbols.
pub fn plain(table: &Table) -> String {
    let cell = |cell: &String| {
        let grade = Grade::ALL.into_iter().find(|grade| Badge::from(*grade).text() == *cell);
        grade.map_or_else(|| cell.clone(), |grade| coloured(grade, grade.name()))
    };
    let mut rows = vec![table.columns.iter().map(Column::head).collect::<Vec<_>>()];
    rows.extend(table.rows.iter().map(|row| row.iter().map(cell).collect()));
    let right: Vec<bool> = table.columns.iter().map(|column| column.number).collect();
    typed(&(paragraph(&table.caption).trim_start().to_owned() + &columns(&rows, &right)))
}

/// Names with values, the values in one column.
pub fn facts(facts: &[Fact]) -> String {
    let wide = facts.iter().map(|fact| width_of(&fact.name)).max().unwrap_or(0);
    let row = |fact: &Fact| {
        let value = format!("{} {}", fact.value, fact.unit);
        hanging(&format!("  {:wide$}  ", fact.name), &value, 92 - wide)
    };
    typed(&facts.iter().map(row).collect::<String>())
}

/// A section of a report, without figures and folds.
pub fn section(section: &Section) -> String {
    let mut out = format!("{}: {}\n", name(&section.name), section.badge.word);
    out += &hanging("  ", &section.headline, 94);
    out += &facts(&section.facts);
    out.extend(section.reasons.iter().map(|reason| hanging("  - ", reason, 92)));
    if !section.blocks.is_empty() {
        out.push('\n');
    }
    typed(&out) + &blocks(&section.blocks)
}

/// Pieces of a report, without figures and folds.
pub fn blocks(blocks: &[Block]) -> String {
    let one = |block: &Block| match block {
        Block::Heading(heading) => format!("\n{heading}\n"),
        Block::Paragraph(text) => paragraph(text),
        Block::List { ordered, items } => (1..)
            .zip(items)
            .map(|(k, item)| {
                hanging(&if *ordered { format!("{k}. ") } else { "- ".into() }, item, 93)
            })
            .collect(),
        Block::Facts(named) => facts(named),
        Block::Table(table) => plain(table),
        _ => String::new(),
    };
    typed(&blocks.iter().map(one).collect::<String>())
}

/// Text without characters that some terminals lack.
fn typed(text: &str) -> String {
    text.replace(['\u{2212}', '\u{2013}'], "-").replace('\u{a0}', " ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short() {
        for (value, text) in [
            (0.0, "0"),
            (1.0, "1"),
            (0.123456, "0.1235"),
            (-12.3456, "-12.35"),
            (12345.6, "12346"),
            (100.0, "100"),
            (1.5e-7, "1.5e-7"),
            (2e9, "2e9"),
        ] {
            assert_eq!(number(value), text);
        }
    }

    #[test]
    fn paragraphs_and_columns() {
        assert_eq!(wrapped("one two  three", 7), ["one two", "three"]);
        assert_eq!(hanging("- ", "one two", 3), "- one\n  two\n");
        let rows = [["a", "1"], ["long", "22"]].map(|row| row.map(str::to_owned));
        assert_eq!(columns(&rows, &[false, true]), "a      1\nlong  22\n");
    }

    #[test]
    fn tables_of_reports() {
        let table = Table::new("Some.").words("a|b").numbers("c", "%").row(["x", "\u{2212}1"]);
        assert_eq!(plain(&table), "Some.\na|b  c (%)\nx       -1\n");
        let text = "Some.\n\n| a\\|b | c (%) |\n|---|---:|\n| x | \u{2212}1 |\n";
        assert_eq!(table.markdown(), text);
    }
}
