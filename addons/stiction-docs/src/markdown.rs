//! A page of Markdown as HTML: headings with anchors, links adapted to the site.

use crate::contents::{Listed, Written, pages, place_of};
use crate::{Page, relative};
use pulldown_cmark::{
    CodeBlockKind, CowStr, Event, HeadingLevel, LinkType, Options, Parser, Tag, TagEnd, html,
};
use std::collections::BTreeMap;

/// A page as HTML, with its title and links.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Rendered {
    /// File in the site.
    pub path: String,
    /// Title.
    pub title: String,
    /// The page of the contents that it is, or belongs to.
    pub listed: String,
    /// Content, as HTML.
    pub html: String,
    /// Headings, and the plain text under each.
    pub parts: Vec<Part>,
}

/// The text under a heading.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Part {
    /// Level of the heading: 1 for the title of the page.
    pub level: usize,
    /// The heading.
    pub heading: String,
    /// Anchor.
    pub anchor: String,
    /// The text under it, without markup.
    pub text: String,
}

/// A page of the contents written by hand.
pub(crate) fn written(listed: &Listed, written: Written) -> Rendered {
    render(listed.path, listed.title, listed.path, written.markdown, Some(written.source))
}

/// A generated page, with the page of the contents that it is or belongs to.
pub(crate) fn made(page: &Page, listed: &str) -> Rendered {
    render(&page.path, &page.title, listed, &page.markdown, None)
}

/// Markdown as HTML for a place outside the site: its links become plain text.
pub fn unlinked(markdown: &str) -> String {
    let is_link = |event: &Event<'_>| {
        matches!(event, Event::Start(Tag::Link { .. }) | Event::End(TagEnd::Link))
    };
    let mut text = String::new();
    let events = Parser::new_ext(markdown, Options::ENABLE_TABLES);
    html::push_html(&mut text, events.filter(|event| !is_link(event)));
    text
}

/// Renders Markdown. `source` is the file of the repository from which its links start, if any.
fn render(path: &str, title: &str, listed: &str, markdown: &str, source: Option<&str>) -> Rendered {
    let options =
        Options::ENABLE_TABLES | Options::ENABLE_FOOTNOTES | Options::ENABLE_STRIKETHROUGH;
    // Comments for programs are not for readers.
    let events: Vec<Event<'_>> = Parser::new_ext(markdown, options)
        .filter(|event| !matches!(event, Event::Html(text) if text.starts_with("<!--")))
        .collect();
    let mut page =
        Writer { path, source, anchors: BTreeMap::new(), parts: vec![], here: 0, done: vec![] };
    // A document for reading elsewhere has no title of its own, and its chapters have the level of one.
    let untitled =
        !matches!(events.first(), Some(Event::Start(Tag::Heading { level: HeadingLevel::H1, .. })));
    if untitled {
        page.heading(1, title, vec![Event::Text(title.to_owned().into())]);
    }
    page.write(events, usize::from(untitled));
    let mut text = String::new();
    html::push_html(&mut text, page.done.into_iter());
    let (path, title, listed) = (path.to_owned(), title.to_owned(), listed.to_owned());
    Rendered { path, title, listed, html: text, parts: page.parts }
}

/// A page during writing.
struct Writer<'a> {
    path: &'a str,
    source: Option<&'a str>,
    /// Number of uses of each anchor.
    anchors: BTreeMap<String, usize>,
    parts: Vec<Part>,
    /// The current part.
    here: usize,
    done: Vec<Event<'a>>,
}

impl<'a> Writer<'a> {
    /// Writes events; all headings are lowered by `deeper` levels.
    fn write(&mut self, events: Vec<Event<'a>>, deeper: usize) {
        let mut events = events.into_iter().peekable();
        // Target of a link outside the site, and the language of a block of code.
        let mut untied: Vec<Option<String>> = vec![];
        // Whether a table explains words, and its part.
        let (mut explains, mut section) = (false, self.here);
        while let Some(event) = events.next() {
            match event {
                Event::Start(Tag::Heading { level, .. }) => {
                    let inner: Vec<Event<'a>> = events
                        .by_ref()
                        .take_while(|event| !matches!(event, Event::End(TagEnd::Heading(_))))
                        .collect();
                    let plain: String = inner.iter().filter_map(plain).collect();
                    self.heading(level as usize + deeper, &plain, inner);
                }
                Event::Start(Tag::CodeBlock(kind)) => {
                    let code: String = events
                        .by_ref()
                        .take_while(|event| !matches!(event, Event::End(TagEnd::CodeBlock)))
                        .filter_map(|event| plain(&event).map(str::to_owned))
                        .collect();
                    self.code(&kind, &code);
                }
                Event::Start(Tag::Table(columns)) => {
                    // A table wider than the page can be scrolled, also with keys.
                    self.raw("<div class=\"rows\" role=\"region\" aria-label=\"Table\" tabindex=\"0\">\n");
                    self.done.push(Event::Start(Tag::Table(columns)));
                }
                Event::End(TagEnd::Table) => {
                    self.done.push(Event::End(TagEnd::Table));
                    self.raw("</div>\n");
                    (self.here, explains) = (section, false);
                }
                Event::Start(Tag::TableHead) => {
                    let until = |event: &Event<'_>| !matches!(event, Event::End(TagEnd::TableHead));
                    let head: Vec<Event<'a>> = events.by_ref().take_while(until).collect();
                    // A table without heads explains words, one per row: they are searched as headings are.
                    explains = head.iter().all(|event| plain(event).is_none());
                    section = self.here;
                    self.done.push(Event::Start(Tag::TableHead));
                    self.write(head, 0);
                    self.push(Event::End(TagEnd::TableHead));
                }
                Event::Start(Tag::TableRow) if explains => {
                    let until = |event: &Event<'_>| !matches!(event, Event::End(TagEnd::TableCell));
                    let word: Vec<Event<'a>> = events.by_ref().take_while(until).skip(1).collect();
                    self.word(section, word);
                }
                Event::Start(Tag::Link { link_type, dest_url, title, id }) => {
                    match self.target(&dest_url) {
                        Ok(there) => {
                            // A link named after its file is shown with its title.
                            let title_of = self.title_of(&dest_url);
                            if let (Some(Event::Text(said) | Event::Code(said)), Some(name)) =
                                (events.peek_mut(), title_of)
                                && said.ends_with(".md")
                            {
                                *said = name.into();
                            }
                            let dest_url = CowStr::from(there);
                            untied.push(None);
                            self.done.push(Event::Start(Tag::Link {
                                link_type,
                                dest_url,
                                title,
                                id,
                            }));
                        }
                        Err(file) => untied.push(Some(file)),
                    }
                }
                Event::End(TagEnd::Link) => match untied.pop() {
                    Some(Some(file)) => {
                        let said = self.done.last().is_some_and(
                            |event| matches!(event, Event::Text(text) | Event::Code(text) if file.ends_with(text.trim_end_matches('/'))),
                        );
                        if !said {
                            self.push(Event::Text(" (".into()));
                            self.push(Event::Code(file.into()));
                            self.push(Event::Text(")".into()));
                        }
                    }
                    _ => self.done.push(Event::End(TagEnd::Link)),
                },
                Event::Start(Tag::Image { dest_url, title, id, .. }) => {
                    // The text of figures is not searched, because the text around them has the same content.
                    let shown = self.target(&dest_url).unwrap_or_default();
                    let (link_type, dest_url) = (LinkType::Inline, CowStr::from(shown));
                    self.done.push(Event::Start(Tag::Image { link_type, dest_url, title, id }));
                    for event in events.by_ref() {
                        let ends = matches!(event, Event::End(TagEnd::Image));
                        self.done.push(event);
                        if ends {
                            break;
                        }
                    }
                }
                event => self.push(event),
            }
        }
    }

    /// Writes an event, and keeps its text for the search.
    fn push(&mut self, event: Event<'a>) {
        if let Some(part) = self.parts.get_mut(self.here) {
            match &event {
                Event::Text(text) | Event::Code(text) => part.text.push_str(text),
                Event::SoftBreak
                | Event::HardBreak
                | Event::End(
                    TagEnd::Paragraph | TagEnd::TableCell | TagEnd::Item | TagEnd::TableHead,
                ) => part.text.push(' '),
                Event::Html(html) => part.text.push_str(&without_tags(html)),
                _ => {}
            }
        }
        self.done.push(event);
    }

    fn raw(&mut self, html: impl Into<CowStr<'a>>) {
        self.done.push(Event::Html(html.into()));
    }

    fn heading(&mut self, level: usize, plain: &str, inner: Vec<Event<'a>>) {
        let level = level.min(6);
        let plain = plain.trim();
        let anchor = self.anchor(plain);
        let heading = plain.to_owned();
        self.here = self.parts.len();
        self.parts.push(Part { level, heading, anchor: anchor.clone(), text: String::new() });
        self.raw(format!("<h{level} id=\"{anchor}\">"));
        self.write(inner, 0);
        // The heading is known; its text follows.
        if let Some(part) = self.parts.get_mut(self.here) {
            part.text.clear();
        }
        if level > 1 {
            let name = escaped(plain);
            self.raw(format!(
                " <a class=\"anchor\" href=\"#{anchor}\" aria-label=\"Link to {name}\">#</a>"
            ));
        }
        self.raw(format!("</h{level}>\n"));
    }

    /// Writes the first cell of an explaining row.
    fn word(&mut self, section: usize, inner: Vec<Event<'a>>) {
        let heading = inner.iter().filter_map(plain).collect::<String>().trim().to_owned();
        let anchor = self.anchor(&heading);
        let level = self.parts.get(section).map_or(2, |part| part.level + 1);
        self.here = self.parts.len();
        self.parts.push(Part { level, heading, anchor: anchor.clone(), text: String::new() });
        self.done.push(Event::Start(Tag::TableRow));
        self.done.push(Event::Start(Tag::TableCell));
        self.raw(format!("<span id=\"{anchor}\">"));
        self.write(inner, 0);
        self.raw("</span>");
        self.done.push(Event::End(TagEnd::TableCell));
        if let Some(part) = self.parts.get_mut(self.here) {
            part.text.clear();
        }
    }

    /// The anchor of a heading, as code hosts make it; repeated names get a number.
    fn anchor(&mut self, heading: &str) -> String {
        let anchor: String = heading
            .to_lowercase()
            .chars()
            .filter_map(|c| match c {
                ' ' => Some('-'),
                c if c.is_alphanumeric() || c == '-' || c == '_' => Some(c),
                _ => None,
            })
            .collect();
        let count = self.anchors.entry(anchor.clone()).or_default();
        *count += 1;
        if *count == 1 { anchor } else { format!("{anchor}-{}", *count - 1) }
    }

    fn code(&mut self, kind: &CodeBlockKind<'_>, code: &str) {
        let language = match kind {
            CodeBlockKind::Fenced(info) => info.split([',', ' ']).next().unwrap_or("").to_owned(),
            CodeBlockKind::Indented => String::new(),
        };
        let shown = match &*language {
            "rust" => without_hidden_lines(code),
            _ => code.to_owned(),
        };
        if let Some(part) = self.parts.get_mut(self.here) {
            part.text.push_str(&format!(" {shown} "));
        }
        let class = match &*language {
            "" => String::new(),
            language => format!(" class=\"language-{}\"", escaped(language)),
        };
        let lines = with_comments(&language, &shown);
        self.raw(format!("<pre tabindex=\"0\"><code{class}>{lines}</code></pre>\n"));
    }

    /// The title of the page at the end of a link, if it is in the contents.
    fn title_of(&self, link: &str) -> Option<&'static str> {
        let file = self.file_of(link.split('#').next()?)?;
        pages().find(|page| place_of(&file) == Some(page.path)).map(|page| page.title)
    }

    /// The file of the repository in a relative link.
    fn file_of(&self, link: &str) -> Option<String> {
        let mut parts: Vec<&str> = self.source?.split('/').collect();
        parts.pop();
        for part in link.split('/') {
            match part {
                "." | "" => {}
                ".." => drop(parts.pop()),
                part => parts.push(part),
            }
        }
        Some(parts.join("/"))
    }

    /// The target of a link on this page, or the file of the repository that is not in the site.
    fn target(&self, link: &str) -> Result<String, String> {
        if link.starts_with('#') || link.contains("://") || link.starts_with("mailto:") {
            return Ok(link.to_owned());
        }
        let (file, anchor) = link.split_once('#').map_or((link, None), |(a, b)| (a, Some(b)));
        let Some(file) = self.file_of(file) else { return Ok(link.to_owned()) };
        let place = place_of(&file).or_else(|| place_of(&format!("{file}/README.md")));
        let there = place.map(|place| relative(self.path, place)).ok_or(file)?;
        Ok(anchor.map_or(there.clone(), |anchor| format!("{there}#{anchor}")))
    }
}

fn plain<'e>(event: &'e Event<'_>) -> Option<&'e str> {
    match event {
        Event::Text(text) | Event::Code(text) => Some(text),
        Event::SoftBreak => Some(" "),
        _ => None,
    }
}

/// Lines that documentation tests need and readers do not.
fn without_hidden_lines(code: &str) -> String {
    code.lines()
        .filter(|line| *line != "#" && !line.starts_with("# "))
        .flat_map(|line| [line, "\n"])
        .collect()
}

/// Code with its comments marked, escaped.
fn with_comments(language: &str, code: &str) -> String {
    let sign = match language {
        "sh" | "bash" | "toml" | "python" | "pycon" => "#",
        "rust" => "//",
        _ => return escaped(code),
    };
    let mut html = String::new();
    for line in code.split_inclusive('\n') {
        let begins = line.match_indices(sign).map(|(at, _)| at).find(|at| {
            let before = &line[..*at];
            // Not within a word or a text.
            (before.is_empty() || before.ends_with(' ')) && before.matches('"').count() % 2 == 0
        });
        let (code, comment) = line.split_at(begins.unwrap_or(line.len()));
        html += &if sign == "#" { with_options(language, code) } else { escaped(code) };
        match comment.strip_suffix('\n') {
            _ if comment.is_empty() => {}
            Some(comment) => {
                html += &format!("<span class=\"comment\">{}</span>\n", escaped(comment))
            }
            None => html += &format!("<span class=\"comment\">{}</span>", escaped(comment)),
        }
    }
    html
}

/// An escaped line of a shell session. Its options are marked, so that a narrow page does not break them at hyphens.
fn with_options(language: &str, line: &str) -> String {
    if !matches!(language, "sh" | "bash") {
        return escaped(line);
    }
    let words = line.split_inclusive([' ', '\n']).map(|word| {
        let (option, gap) = word.split_at(word.trim_end().len());
        match option.starts_with('-') {
            true => format!("<span class=\"option\">{}</span>{gap}", escaped(option)),
            false => escaped(word),
        }
    });
    words.collect()
}

/// HTML as visible text.
fn without_tags(html: &str) -> String {
    let mut text = String::new();
    let mut inside = false;
    for c in html.chars() {
        match c {
            '<' => {
                inside = true;
                text.push(' ');
            }
            '>' => inside = false,
            c if !inside => text.push(c),
            _ => {}
        }
    }
    text.replace("&lt;", "<").replace("&gt;", ">").replace("&quot;", "\"").replace("&amp;", "&")
}

/// Text escaped for HTML.
pub fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// Text escaped for a line or a cell of Markdown, with code as the only markup.
pub fn literal(text: &str) -> String {
    let mut out = String::new();
    let mut code = false;
    for c in text.chars() {
        code ^= c == '`';
        match c {
            '\n' => out.push(' '),
            '|' => out.push_str("\\|"),
            '<' | '>' | '*' | '_' | '[' | ']' | '#' if !code => out.extend(['\\', c]),
            c => out.push(c),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(markdown: &str) -> Rendered {
        render("guides/a.html", "A", "guides/a.html", markdown, Some("docs/guides/a.md"))
    }

    #[test]
    fn links_lead_to_pages_and_files_elsewhere_are_named() {
        let html = of("# A\n[fit](../fit.md#how) [licence](../../LICENSE-MIT) [`samples/`](../../samples) [x](#a)").html;
        assert!(html.contains("<a href=\"../fit.html#how\">fit</a>"), "{html}");
        assert!(html.contains("licence (<code>LICENSE-MIT</code>)"), "{html}");
        assert!(html.contains("<a href=\"../samples.html\"><code>samples/</code></a>"), "{html}");
        assert!(html.contains("<a href=\"#a\">x</a>"), "{html}");
        let html = of("# A\n[../fit.md](../fit.md) `a.md`").html;
        assert!(html.contains("<a href=\"../fit.html\">The loop behind a recording</a>"), "{html}");
    }

    #[test]
    fn headings_have_anchors_of_their_own() {
        let page = of("# A\n## `[valve]`, and S\none\n## Same\ntwo\n## Same\n");
        let anchors: Vec<&str> = page.parts.iter().map(|part| &*part.anchor).collect();
        assert_eq!(anchors, ["a", "valve-and-s", "same", "same-1"]);
        assert_eq!(page.parts[1].text.trim(), "one");
    }

    #[test]
    fn words_that_a_table_explains_can_be_found() {
        let page = of(
            "# A\n## B\n\n| | |\n|---|---|\n| dead *band* | A width. |\n\nAfter.\n\n| a | b |\n|---|---|\n| c | d |\n",
        );
        let parts: Vec<_> = page.parts.iter().map(|p| (&*p.anchor, p.text.trim())).collect();
        assert_eq!(parts[2], ("dead-band", "A width."));
        assert!(
            parts.len() == 3 && parts[1].1.contains("After.") && parts[1].1.contains("c d"),
            "{parts:?}"
        );
        assert!(
            page.html.contains(
                "<td><span id=\"dead-band\">dead <em>band</em></span></td><td>A width.</td>"
            ),
            "{}",
            page.html
        );
    }

    #[test]
    fn a_document_without_title_gets_one() {
        let page = of("First words.\n\n# Chapter\n");
        assert!(page.html.starts_with("<h1 id=\"a\">A</h1>"), "{}", page.html);
        assert!(page.html.contains("<h2 id=\"chapter\">"), "{}", page.html);
    }

    #[test]
    fn comments_are_marked_and_code_is_escaped() {
        let html = of(
            "# A\n```sh\na <b> # \"c\"\n```\n\n```rust\n# hidden\nlet a = \"# //\"; // b\n```\n",
        )
        .html;
        assert!(
            html.contains("a &lt;b&gt; <span class=\"comment\"># &quot;c&quot;</span>\n"),
            "{html}"
        );
        assert!(
            html.contains("; <span class=\"comment\">// b</span>\n") && !html.contains("hidden")
        );
    }

    #[test]
    fn literal_text_stays_as_it_is() {
        let text = "a|b <c> *d* `e_f`";
        let html = of(&format!("# A\n\n| x |\n|---|\n| {} |\n", literal(text))).html;
        assert!(html.contains("<td>a|b &lt;c&gt; *d* <code>e_f</code></td>"), "{html}");
    }
}
