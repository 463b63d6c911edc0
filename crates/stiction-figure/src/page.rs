//! A self-contained HTML page that shows figures with their captions and parameters.
//!
//! The page needs no network and no scripts, and uses the reader's fonts. It has a light and a dark theme, and prints
//! on A4.

use maud::{DOCTYPE, Markup, PreEscaped, html};

/// A page: a title, an introduction and a list of figures.
#[derive(Debug, Clone, PartialEq)]
pub struct Page {
    /// Title of the page.
    pub title: String,
    /// Introduction, a paragraph.
    pub introduction: String,
    /// The figures in order.
    pub entries: Vec<Entry>,
    /// Name and version of the program, such as `stiction 0.1.0`.
    pub tool: String,
}

/// A figure with its texts.
#[derive(Debug, Clone, PartialEq)]
pub struct Entry {
    /// Heading, such as `Figure 5`.
    pub heading: String,
    /// The picture.
    pub picture: Picture,
    /// Caption, one line.
    pub caption: String,
    /// Parameters. Without parameters the page has no table.
    pub parameters: Vec<Parameter>,
}

/// The source of a picture.
#[derive(Debug, Clone, PartialEq)]
pub enum Picture {
    /// An SVG document, such as the output of [`Figure::svg`](crate::Figure::svg). It is inserted unchanged and must
    /// be trusted.
    Inline(String),
    /// A file beside the page, by its path relative to the page, with `/` between folders.
    File(String),
}

/// A row of the table of parameters.
#[derive(Debug, Clone, PartialEq)]
pub struct Parameter {
    /// Name, such as `slip jump J`.
    pub name: String,
    /// Value as text.
    pub value: String,
    /// Unit; empty for none.
    pub unit: String,
}

impl Page {
    /// A page without figures.
    pub fn new(
        title: impl Into<String>,
        introduction: impl Into<String>,
        tool: impl Into<String>,
    ) -> Self {
        Self {
            title: title.into(),
            introduction: introduction.into(),
            entries: Vec::new(),
            tool: tool.into(),
        }
    }

    crate::setters! {
        /// Adds a figure.
        fn with(entry: Entry) => entries.push(entry);
    }

    /// The page as an HTML document; equal pages give equal bytes.
    pub fn html(&self) -> String {
        let document = html! {
            (DOCTYPE)
            html lang="en" {
                (head(&self.title, &[STYLE]))
                body {
                    header { h1 { (self.title) } p { (self.introduction) } }
                    main { @for entry in &self.entries { (entry.html()) } }
                    footer { (self.tool) }
                }
            }
        };
        document.into_string()
    }
}

impl Entry {
    /// An entry without parameters.
    pub fn new(heading: impl Into<String>, picture: Picture, caption: impl Into<String>) -> Self {
        Self { heading: heading.into(), picture, caption: caption.into(), parameters: Vec::new() }
    }

    /// Adds a parameter.
    #[must_use]
    pub fn parameter(
        mut self,
        name: impl Into<String>,
        value: impl ToString,
        unit: impl Into<String>,
    ) -> Self {
        let parameter =
            Parameter { name: name.into(), value: value.to_string(), unit: unit.into() };
        self.parameters.push(parameter);
        self
    }

    fn html(&self) -> Markup {
        html! {
            section {
                h2 { (self.heading) }
                figure {
                    div.sheet {
                        @match &self.picture {
                            Picture::Inline(svg) => (PreEscaped(svg)),
                            Picture::File(path) => img src=(relative(path)) alt=(self.caption);,
                        }
                    }
                    figcaption { (self.caption) }
                }
                @if !self.parameters.is_empty() {
                    table {
                        thead {
                            tr {
                                @for name in ["Parameter", "Value", "Unit"] {
                                    th scope="col" { (name) }
                                }
                            }
                        }
                        tbody {
                            @for p in &self.parameters {
                                tr { th scope="row" { (p.name) } td { (p.value) } td { (p.unit) } }
                            }
                        }
                    }
                }
            }
        }
    }
}

/// The head of each page, with its title and styles.
pub fn head(title: &str, styles: &[&str]) -> Markup {
    html! {
        head {
            meta charset="utf-8";
            meta name="generator" content="stiction";
            meta name="viewport" content="width=device-width, initial-scale=1";
            title { (title) }
            style { @for style in styles { (PreEscaped(style)) } }
        }
    }
}

/// `path` as a reference that can only lead to a file near the page. A colon or a leading slash cannot redirect it.
pub fn relative(path: &str) -> String {
    let mut reference = String::from("./");
    for byte in path.trim_start_matches('/').bytes() {
        match byte {
            b'a'..=b'z' | b'A'..=b'Z' | b'0'..=b'9' | b'-' | b'.' | b'_' | b'~' | b'/' => {
                reference.push(char::from(byte));
            }
            _ => reference.push_str(&format!("%{byte:02X}")),
        }
    }
    reference
}

const STYLE: &str = "
:root { color-scheme: light dark; --ink: #1c1c1e; --paper: #ffffff; --soft: #5f6368; --line: #d9dce1; }
@media (prefers-color-scheme: dark) {
  :root { --ink: #e8e8ea; --paper: #17181b; --soft: #a0a4ab; --line: #3a3d43; }
}
* { box-sizing: border-box; }
body {
  margin: 0 auto; padding: 2.5rem 1.25rem 3rem; max-width: 56rem;
  font: 1rem/1.55 system-ui, -apple-system, 'Segoe UI', Roboto, 'Helvetica Neue', Arial, sans-serif;
  color: var(--ink); background: var(--paper);
}
h1 { margin: 0 0 .5rem; font-size: 1.8rem; line-height: 1.25; }
h2 { margin: 0 0 .75rem; font-size: 1.2rem; line-height: 1.3; }
header p { max-width: 44rem; margin: 0; }
section { margin-top: 2.75rem; padding-top: 1.5rem; border-top: 1px solid var(--line); }
figure { margin: 0; }
.sheet { padding: .5rem; background: #fff; border: 1px solid var(--line); border-radius: 4px; text-align: center; overflow-x: auto; }
.sheet svg, .sheet img { display: block; margin: 0 auto; max-width: 100%; height: auto; }
figcaption { margin-top: .6rem; color: var(--soft); }
table { margin-top: .9rem; border-collapse: collapse; font-size: .9rem; font-variant-numeric: tabular-nums; }
th, td { padding: .2rem 1.5rem .2rem 0; border-bottom: 1px solid var(--line); text-align: left; font-weight: normal; overflow-wrap: anywhere; }
thead th { color: var(--soft); }
th + td, thead th:nth-child(2) { text-align: right; }
footer { margin-top: 3rem; padding-top: 1rem; border-top: 1px solid var(--line); color: var(--soft); font-size: .85rem; }
@page { size: A4; margin: 18mm 16mm; }
@media print {
  :root { color-scheme: light; --ink: #000; --paper: #fff; --soft: #444; --line: #bbb; }
  body { padding: 0; max-width: none; font-size: 10pt; }
  section { break-inside: avoid; margin-top: 1.5rem; padding-top: 1rem; }
  .sheet { border: 0; padding: 0; }
}
";

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_are_only_found_near_the_page() {
        for (path, want) in [
            ("fig5.svg", "./fig5.svg"),
            ("figures/OP–VP map.svg", "./figures/OP%E2%80%93VP%20map.svg"),
            ("https://example.org/a.svg", "./https%3A//example.org/a.svg"),
            ("//example.org/a.svg", "./example.org/a.svg"),
            ("javascript:alert(1)", "./javascript%3Aalert%281%29"),
            ("a\" onload=\"b", "./a%22%20onload%3D%22b"),
        ] {
            assert_eq!(relative(path), want);
        }
    }
}
