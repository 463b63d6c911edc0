//! The parts of a report, and the page that contains them.

use crate::Error;
use crate::document::Source;
use crate::words::{PROBABILITY, percent};
use maud::{DOCTYPE, Markup, PreEscaped, html};
use schemars::JsonSchema;
use serde::Serialize;
use std::collections::BTreeMap;
use stiction_diagnose::diagnose::VerdictClass;
use stiction_diagnose::finding::Decision;
use stiction_diagnose::recording::fitness::Class;
use stiction_diagnose::recording::understood::Row;
use stiction_figure::figure::Figure;
use stiction_figure::page::{head, relative};

pub use stiction_diagnose::spoken::number;

/// The style of all pages.
pub const STYLE: &str = include_str!("style.css");
const SCRIPT: &str = include_str!("../interactive.js");
/// The script of tables that can be sorted, searched and filtered.
pub const TABLES: &str = include_str!("../tables.js");

/// A report on one loop or several.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Report {
    /// Title of the page.
    pub title: String,
    /// Introduction, a paragraph; empty for none.
    pub introduction: String,
    /// Content on all loops together, before the sections.
    pub blocks: Vec<Block>,
    /// One section per loop, in order of priority.
    pub sections: Vec<Section>,
    /// Name and version of the program, such as `stiction 0.1.0`.
    pub tool: String,
    /// The input files.
    pub sources: Vec<Source>,
    /// Relative path of the page that lists this page among others; `None` for a separate report.
    pub home: Option<String>,
    /// Relative path of the sheet of the valve's test, named beside the page above.
    pub sheet: Option<String>,
}

/// The part of a report on one loop.
#[derive(Debug, Clone, PartialEq)]
pub struct Section {
    /// Name of the loop.
    pub name: String,
    /// The conclusion as a word.
    pub badge: Badge,
    /// The conclusion as a sentence.
    pub headline: String,
    /// Content of the first screen; `None` for only the name, the conclusion and the facts.
    pub head: Option<Head>,
    /// Reasons, in sentences.
    pub reasons: Vec<String>,
    /// The numbers that go with the conclusion.
    pub facts: Vec<Fact>,
    /// All other content.
    pub blocks: Vec<Block>,
}

/// The first screen of a loop.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Head {
    /// Type, time and file.
    pub line: String,
    /// The probability that the valve sticks, where there is one.
    pub probability: Option<f64>,
    /// Numbers on the size of the problem.
    pub facts: Vec<Fact>,
    /// The actions, most urgent first.
    pub actions: Vec<String>,
    /// Lines of evidence, with the probability of sticking by each alone.
    pub lines: Vec<(String, f64)>,
    /// Whether these are means of several windows. Several windows together may be more certain than each.
    pub lines_are_means: bool,
    /// Other possible causes, with the likelihood of each.
    pub causes: Vec<(String, f64)>,
    /// Remarks on the data.
    pub remarks: Vec<String>,
    /// PV and OP over time.
    pub trend: Option<Figure>,
    /// Length of one cycle on the time axis of the trend.
    pub cycle: Option<f64>,
    /// PV over OP.
    pub map: Option<Figure>,
}

/// A word with a symbol. On screen it has a colour, but the symbol alone is sufficient.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema)]
pub struct Badge {
    /// The symbol.
    pub symbol: &'static str,
    /// The word.
    pub word: &'static str,
    /// Meaning for the reader.
    pub tone: Tone,
}

/// The meaning of a word for the reader.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Tone {
    /// Something is wrong.
    Bad,
    /// Something is probably wrong.
    Warning,
    /// Nothing is wrong.
    Good,
    /// The answer is unknown.
    Open,
}

/// A named value.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub struct Fact {
    /// Name.
    pub name: String,
    /// The value as text, such as [`number`] writes it.
    pub value: String,
    /// Unit; empty for none.
    pub unit: String,
}

/// A piece of a section.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Block {
    /// A heading.
    Heading(String),
    /// A paragraph.
    Paragraph(String),
    /// A list, with numbers if the order matters.
    List {
        /// Whether the order matters.
        ordered: bool,
        /// Items.
        items: Vec<String>,
    },
    /// Names with values.
    Facts(Vec<Fact>),
    /// A table.
    Table(Table),
    /// A figure with its caption below.
    Figure(Box<Figure>),
    /// Evidence: a sentence with its figure and its numbers.
    Card(Box<Card>),
    /// Content shown on demand, and always in print.
    Details {
        /// The title of the content.
        summary: String,
        /// The content.
        blocks: Vec<Block>,
    },
}

/// A table.
#[derive(Debug, Clone, PartialEq, Default, Serialize, JsonSchema)]
pub struct Table {
    /// Caption.
    pub caption: String,
    /// Columns.
    pub columns: Vec<Column>,
    /// Rows; each has a cell for every column.
    pub rows: Vec<Vec<String>>,
    /// Targets of links in the first cells of the rows, as relative paths with `/` between folders; empty for none.
    pub links: Vec<String>,
    /// Whether the reader can sort and search its rows.
    pub sortable: bool,
}

/// The title of a column.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub struct Column {
    /// Name.
    pub name: String,
    /// Unit of all cells; empty for none.
    pub unit: String,
    /// Whether its cells are numbers, which are aligned right.
    pub number: bool,
}

/// A piece of evidence.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Card {
    /// Heading, such as the title of a method.
    pub heading: String,
    /// Conclusion, as a word.
    pub badge: Option<Badge>,
    /// Conclusion, as a sentence.
    pub sentence: String,
    /// Figure.
    pub figure: Option<Figure>,
    /// Numbers.
    pub facts: Vec<Fact>,
    /// More numbers.
    pub table: Option<Table>,
    /// Caveats.
    pub caveats: Vec<String>,
}

impl Report {
    /// A report without sections.
    pub fn new(title: impl Into<String>, tool: impl Into<String>) -> Self {
        Self { title: title.into(), tool: tool.into(), ..Self::default() }
    }

    stiction_figure::setters! {
        /// Sets the introduction.
        fn introduction(introduction: impl Into<String>) => introduction = introduction.into();
        /// Sets the relative path of the page that lists this page among others.
        fn home(home: impl Into<String>) => home = Some(home.into());
        /// Adds a block before the sections.
        fn block(block: impl Into<Block>) => blocks.push(block.into());
    }

    /// Adds a heading with blocks, if there are any.
    #[must_use]
    pub fn titled<B: Into<Block>>(
        mut self,
        heading: &str,
        blocks: impl IntoIterator<Item = B>,
    ) -> Self {
        let mut blocks = blocks.into_iter().map(Into::into).peekable();
        if blocks.peek().is_some() {
            self.blocks.push(Block::Heading(heading.to_owned()));
        }
        self.blocks.extend(blocks);
        self
    }

    stiction_figure::setters! {
        /// Adds a section.
        fn with(section: Section) => sections.push(section);
    }

    /// Adds an input file. Repeated files are listed once.
    #[must_use]
    pub fn source(mut self, source: &Source) -> Self {
        if !self.sources.contains(source) {
            self.sources.push(source.clone());
        }
        self
    }

    /// The report as an HTML document; equal reports give equal bytes.
    ///
    /// # Errors
    /// If a figure is malformed; see [`Error`].
    pub fn html(&self) -> Result<String, Error> {
        let mut page = Page::default();
        let document = html! {
            (DOCTYPE)
            html lang="en" {
                (head(&self.title, &[&compact(STYLE)]))
                body {
                    @if let Some(home) = &self.home {
                        nav.home {
                            a href=(relative(home)) { "All loops" }
                            @if let Some(sheet) = &self.sheet { " | " a href=(relative(sheet)) { "Test sheet" } }
                        }
                    }
                    @let alone = matches!(&self.sections[..], [one] if one.head.is_some());
                    @if !alone {
                        header {
                            h1 { (self.title) }
                            @if !self.introduction.is_empty() { p { (self.introduction) } }
                        }
                    }
                    @if self.sections.len() > 1 { (contents(&self.sections)) }
                    main {
                        (page.blocks(&self.blocks)?)
                        @for (number, section) in (1..).zip(&self.sections) {
                            (page.section(number, section, alone)?)
                        }
                    }
                    footer {
                        @if alone { p { (self.introduction) } }
                        p { (self.tool) }
                        @for source in &self.sources {
                            p { (source.file) ": SHA-256 " code { (source.sha256) } }
                        }
                    }
                    script { (PreEscaped(compact(SCRIPT))) }
                    @if page.sortable { script { (PreEscaped(TABLES)) } }
                }
            }
        };
        Ok(drawn_once(&document.into_string()))
    }
}

/// A style or script without indentation and lines of comments.
fn compact(text: &str) -> String {
    let lines =
        text.lines().map(str::trim).filter(|line| !line.is_empty() && !line.starts_with("//"));
    lines.fold(String::new(), |text, line| text + line + "\n")
}

/// A picture without needless spaces, because a page has hundreds of them.
fn terse(svg: &str) -> String {
    svg.replace("\" />", "\"/>")
}

/// Draws curves that occur several times once, such as the PV behind several fits, and refers to them.
///
/// Only curves of still pictures are shared, because the script changes the curves of live pictures. The script
/// recognises them by their scale.
fn drawn_once(page: &str) -> String {
    const PATH: &str = "<path d=\"";
    /// Shorter curves are not worth it.
    const LEAST: usize = 90;
    let curve = |piece: &str| -> Option<(usize, usize)> {
        let length = piece.find('"')?;
        let end = piece.find('>')?;
        (length >= LEAST && piece[length..end].contains(" transform=\"scale("))
            .then_some((length, end))
    };
    let pieces: Vec<&str> = page.split(PATH).collect();
    let mut numbers: BTreeMap<&str, usize> = BTreeMap::new();
    for piece in &pieces[1..] {
        if let Some((length, _)) = curve(piece) {
            *numbers.entry(&piece[..length]).or_default() += 1;
        }
    }
    numbers.retain(|_, number| *number > 1);
    for (name, number) in numbers.values_mut().enumerate() {
        *number = name;
    }
    let mut whole = pieces[0].to_owned();
    for piece in &pieces[1..] {
        let known =
            curve(piece).and_then(|(length, _)| Some((length, numbers.get(&piece[..length])?)));
        match known {
            Some((length, number)) => {
                whole += &format!("<use href=\"#c{number}\"{}", &piece[length + 1..]);
            }
            None => {
                whole += PATH;
                whole += piece;
            }
        }
    }
    let curves: String =
        numbers.iter().map(|(d, number)| format!("<path id=\"c{number}\" d=\"{d}\"/>")).collect();
    match curves.is_empty() {
        true => whole,
        false => whole.replacen(
            "<main>",
            &format!("<svg width=\"0\" height=\"0\" style=\"position:absolute\" aria-hidden=\"true\"><defs>{curves}</defs></svg><main>"),
            1,
        ),
    }
}

impl Section {
    /// A section with only a name and a conclusion.
    pub fn new(name: impl Into<String>, badge: Badge, headline: impl Into<String>) -> Self {
        Self {
            name: name.into(),
            badge,
            headline: headline.into(),
            head: None,
            reasons: Vec::new(),
            facts: Vec::new(),
            blocks: Vec::new(),
        }
    }

    stiction_figure::setters! {
        /// Adds a reason.
        fn reason(reason: impl Into<String>) => reasons.push(reason.into());
        /// Adds a number that goes with the conclusion.
        fn fact(fact: Fact) => facts.push(fact);
        /// Adds a block.
        fn with(block: impl Into<Block>) => blocks.push(block.into());
    }

    /// Adds several blocks, or an optional block.
    #[must_use]
    pub fn with_all<B: Into<Block>>(mut self, blocks: impl IntoIterator<Item = B>) -> Self {
        self.blocks.extend(blocks.into_iter().map(Into::into));
        self
    }

    /// Adds a paragraph.
    #[must_use]
    pub fn paragraph(self, text: impl Into<String>) -> Self {
        self.with(Block::Paragraph(text.into()))
    }

    /// Adds a list whose order does not matter, if it has items.
    #[must_use]
    pub fn list(self, items: Vec<String>) -> Self {
        let list = (!items.is_empty()).then_some(Block::List { ordered: false, items });
        self.with_all(list)
    }

    /// Adds a fold with the content that `fill` adds to an empty section. Without content, adds nothing.
    #[must_use]
    pub fn fold(self, summary: impl Into<String>, fill: impl FnOnce(Self) -> Self) -> Self {
        let empty = Self::new("", self.badge, "");
        let blocks = fill(empty).blocks;
        match blocks.is_empty() {
            true => self,
            false => self.with(Block::Details { summary: summary.into(), blocks }),
        }
    }

    /// Adds a heading.
    #[must_use]
    pub fn heading(self, heading: impl Into<String>) -> Self {
        self.with(Block::Heading(heading.into()))
    }
}

impl Block {
    /// Content shown on demand.
    pub fn details(summary: impl Into<String>, block: impl Into<Self>) -> Self {
        Self::Details { summary: summary.into(), blocks: vec![block.into()] }
    }
}

impl From<Figure> for Block {
    fn from(figure: Figure) -> Self {
        Self::Figure(Box::new(figure))
    }
}

impl From<Card> for Block {
    fn from(card: Card) -> Self {
        Self::Card(Box::new(card))
    }
}

impl From<Table> for Block {
    fn from(table: Table) -> Self {
        Self::Table(table)
    }
}

impl From<VerdictClass> for Badge {
    fn from(class: VerdictClass) -> Self {
        let (symbol, tone) = match class {
            VerdictClass::Sticks => ("●", Tone::Bad),
            VerdictClass::DoesNotStick => ("○", Tone::Good),
            VerdictClass::DoesNotRespond => ("■", Tone::Bad),
            _ => ("?", Tone::Open),
        };
        Self { symbol, word: class.name(), tone }
    }
}

impl From<Decision> for Badge {
    fn from(decision: Decision) -> Self {
        let (symbol, tone) = match decision {
            Decision::Sticks => ("●", Tone::Bad),
            Decision::DoesNotStick => ("○", Tone::Good),
            Decision::Nonlinear => ("◆", Tone::Bad),
            Decision::Linear => ("◇", Tone::Good),
            Decision::Undecided => ("?", Tone::Open),
            Decision::Abstains => ("–", Tone::Open),
        };
        Self { symbol, word: decision.name(), tone }
    }
}

impl From<Class> for Badge {
    fn from(class: Class) -> Self {
        let (symbol, tone) = match class {
            Class::Fit => ("✓", Tone::Good),
            Class::Caveats => ("!", Tone::Open),
            Class::Unfit => ("✕", Tone::Bad),
        };
        Self { symbol, word: class.name(), tone }
    }
}

impl Badge {
    /// As HTML of the class `badge` and the class of its tone: `bad`, `warning`, `good` or `open`.
    pub fn html(&self) -> String {
        badge(self).into_string()
    }

    /// Symbol and word, for a cell of a table.
    pub fn text(&self) -> String {
        // With a non-breaking space.
        format!("{} {}", self.symbol, self.word).replace(' ', "\u{a0}")
    }
}

impl Fact {
    /// A named value with its unit; empty for none.
    pub fn new(name: impl Into<String>, value: impl ToString, unit: impl Into<String>) -> Self {
        Self { name: name.into(), value: value.to_string(), unit: unit.into() }
    }
}

impl Table {
    /// A table without columns.
    pub fn new(caption: impl Into<String>) -> Self {
        Self { caption: caption.into(), ..Self::default() }
    }

    stiction_figure::setters! {
        /// Lets the reader sort and search its rows.
        fn sortable() => sortable = true;
        /// Adds a column of words.
        fn words(name: impl Into<String>) => columns.push(Column { name: name.into(), unit: String::new(), number: false });
        /// Adds a column of numbers with a unit; empty for none.
        fn numbers(name: impl Into<String>, unit: impl Into<String>) => columns.push(Column { name: name.into(), unit: unit.into(), number: true });
    }

    /// Adds the columns of a line such as `method | #recall | #time [s]`. Columns of numbers begin with `#`, and units
    /// are in brackets.
    #[must_use]
    pub fn columns(self, line: &str) -> Self {
        line.split('|').map(str::trim).fold(self, |table, column| match column.strip_prefix('#') {
            None => table.words(column),
            Some(column) => {
                let (name, unit) = column.split_once(" [").unwrap_or((column, ""));
                table.numbers(name, unit.trim_end_matches(']'))
            }
        })
    }

    /// Adds a row.
    #[must_use]
    pub fn row<T: Into<String>>(mut self, cells: impl IntoIterator<Item = T>) -> Self {
        self.rows.push(cells.into_iter().map(Into::into).collect());
        self
    }

    /// What was understood of a recording, as a table.
    pub fn understood(caption: impl Into<String>, rows: &[Row]) -> Self {
        let table = Row::TITLES.into_iter().fold(Self::new(caption), Self::words);
        rows.iter().fold(table, |table, row| table.row(row.cells()))
    }

    /// The table in Markdown, its caption above it.
    pub fn markdown(&self) -> String {
        let line = |cells: &[String]| {
            let cells: Vec<String> = cells.iter().map(|cell| cell.replace('|', "\\|")).collect();
            format!("| {} |\n", cells.join(" | "))
        };
        let mut out = String::new();
        if !self.caption.is_empty() {
            out += &format!("{}\n\n", self.caption);
        }
        out += &line(&self.columns.iter().map(Column::head).collect::<Vec<_>>());
        let rule = |column: &Column| if column.number { "---:|" } else { "---|" };
        out += &format!("|{}\n", self.columns.iter().map(rule).collect::<String>());
        self.rows.iter().for_each(|row| out += &line(row));
        out
    }
}

impl Column {
    /// Name, with its unit.
    pub fn head(&self) -> String {
        match &self.unit[..] {
            "" => self.name.clone(),
            unit => format!("{} ({unit})", self.name),
        }
    }
}

impl Card {
    /// A card with a heading and a sentence.
    pub fn new(heading: impl Into<String>, sentence: impl Into<String>) -> Self {
        Self { heading: heading.into(), sentence: sentence.into(), ..Self::default() }
    }

    stiction_figure::setters! {
        /// Sets its conclusion as a word.
        fn badge(badge: impl Into<Badge>) => badge = Some(badge.into());
        /// Sets the figure.
        fn figure(figure: Figure) => figure = Some(figure);
        /// Adds a number.
        fn fact(fact: Fact) => facts.push(fact);
        /// Sets the table.
        fn table(table: Table) => table = Some(table);
        /// Adds a caveat.
        fn caveat(caveat: impl Into<String>) => caveats.push(caveat.into());
    }
}

/// The state of a page while it is written.
#[derive(Default)]
struct Page {
    /// Number of its figures.
    figures: usize,
    /// Whether it has sortable tables.
    sortable: bool,
}

impl Page {
    fn section(&mut self, number: usize, section: &Section, alone: bool) -> Result<Markup, Error> {
        Ok(html! {
            section.loop.alone[alone] #{ "loop-" (number) } data-scope {
                @if alone { h1 { (section.name) } } @else { h2 { (section.name) } }
                @if let Some(head) = &section.head { (self.head(section, head)?) } @else { div.banner {
                    p.verdict { (badge(&section.badge)) " " (section.headline) }
                    (facts(&section.facts))
                    @if !section.reasons.is_empty() { ul.reasons { (listed(&section.reasons)) } }
                } }
                (self.blocks(&section.blocks)?)
            }
        })
    }

    fn head(&mut self, section: &Section, head: &Head) -> Result<Markup, Error> {
        Ok(html! {
            p.line { (head.line) }
            div.head {
                div.said {
                    p.verdict { (badge(&section.badge)) }
                    @if let Some((share, words)) = head.likelihood() {
                        p.probability title=(PROBABILITY) { (bar(share)) " sticks: " (words) }
                    }
                    p.headline { (section.headline) }
                    @if !section.reasons.is_empty() { ul.reasons { (listed(&section.reasons)) } }
                    (facts(&head.facts))
                    @if !head.actions.is_empty() {
                        p.do { "Actions" }
                        ol { (listed(&head.actions)) }
                    }
                }
                div.seen {
                    @if let Some(trend) = &head.trend {
                        @if let Some(cycle) = head.cycle {
                            p.spans data-cycle=(cycle) {
                                @for (cycles, word) in [("1", "1 cycle"), ("10", "10 cycles"), ("", "all")] {
                                    button type="button" data-cycles=(cycles) aria-pressed=(cycles.is_empty()) { (word) }
                                }
                            }
                        }
                        (self.figure(trend)?)
                    }
                    div.beside {
                        @if let Some(map) = &head.map { (self.figure(map)?) }
                        div {
                            (likelihoods(match head.lines_are_means {
                                true => "Probability of sticking by each line of evidence alone, mean of the windows",
                                false => "Probability of sticking by each line of evidence alone",
                            }, &head.lines))
                            (likelihoods("Other possible causes", &head.causes))
                            ul.remarks { (listed(&head.remarks)) }
                        }
                    }
                }
            }
        })
    }

    fn blocks(&mut self, blocks: &[Block]) -> Result<Markup, Error> {
        Ok(html! {
            @for block in blocks {
                @match block {
                    Block::Heading(text) => h3 { (text) },
                    Block::Paragraph(text) => p { (text) },
                    Block::List { items, .. } if items.is_empty() => {},
                    Block::List { ordered: true, items } => ol { (listed(items)) },
                    Block::List { ordered: false, items } => ul { (listed(items)) },
                    Block::Facts(named) => (facts(named)),
                    Block::Table(table) => (self.table(table)),
                    Block::Figure(figure) => (self.figure(figure)?),
                    Block::Card(card) => (self.card(card)?),
                    Block::Details { summary, blocks } => details {
                        summary { (summary) }
                        (self.blocks(blocks)?)
                    },
                }
            }
        })
    }

    fn card(&mut self, card: &Card) -> Result<Markup, Error> {
        Ok(html! {
            article.card {
                h4 { (card.heading) @if let Some(word) = &card.badge { " " (badge(word)) } }
                p { (card.sentence) }
                @if !card.caveats.is_empty() { ul.caveats { (listed(&card.caveats)) } }
                @if let Some(figure) = &card.figure { (self.still(figure)?) }
                (facts(&card.facts))
                @if let Some(table) = &card.table { (self.table(table)) }
            }
        })
    }

    /// A figure without data for scripts, because many figures would make the page half as large again.
    fn still(&mut self, figure: &Figure) -> Result<Markup, Error> {
        let id = self.id();
        let svg = figure.still(&id)?;
        Ok(html! {
            figure {
                div.sheet tabindex="0" { (PreEscaped(terse(&svg))) }
                @if !figure.caption.is_empty() { figcaption #(Figure::caption_id(&id)) { (figure.caption) } }
            }
        })
    }

    /// A name that is unique among the figures of the page.
    fn id(&mut self) -> String {
        self.figures += 1;
        format!("f{}", self.figures)
    }

    fn figure(&mut self, figure: &Figure) -> Result<Markup, Error> {
        let id = self.id();
        let live = figure.live(&id)?;
        Ok(html! {
            figure #(id) data-live {
                div.sheet tabindex="0" { (PreEscaped(terse(&live.svg))) }
                script type="application/json" { (PreEscaped(live.data)) }
                @if !figure.caption.is_empty() { figcaption #(Figure::caption_id(&id)) { (figure.caption) } }
            }
        })
    }

    fn table(&mut self, table: &Table) -> Markup {
        self.sortable |= table.sortable;
        let class = |column: &Column| column.number.then_some("number");
        html! {
            div.rows tabindex="0" role="region" aria-label=(if table.caption.is_empty() { "Table" } else { &table.caption }) {
                table data-sortable[table.sortable] {
                    @if !table.caption.is_empty() { caption { (table.caption) } }
                    thead {
                        tr {
                            @for column in &table.columns {
                                th scope="col" class=[class(column)] {
                                    (column.name)
                                    @if !column.unit.is_empty() { " " span.unit { (column.unit) } }
                                }
                            }
                        }
                    }
                    tbody {
                        @for (index, row) in table.rows.iter().enumerate() {
                            @let mut link = table.links.get(index).filter(|link| !link.is_empty());
                            tr {
                                @for (cell, column) in row.iter().zip(&table.columns) {
                                    td class=[class(column)] {
                                        // The first cell has a data-value.
                                        @if let Some(path) = link.take() {
                                            a href=(relative(path)) { (cell) }
                                        } @else {
                                            (cell)
                                        }
                                    }
                                }
                            }
                        }
                    }
                }
            }
        }
    }
}

fn contents(sections: &[Section]) -> Markup {
    html! {
        nav aria-label="Loops" {
            h2 { "Loops" }
            ol {
                @for (number, section) in (1..).zip(sections) {
                    li {
                        a href={ "#loop-" (number) } { (section.name) } " "
                        (badge(&section.badge)) " "
                        span.soft { (section.headline) }
                    }
                }
            }
        }
    }
}

pub(super) fn badge(badge: &Badge) -> Markup {
    let tone = match badge.tone {
        Tone::Bad => "bad",
        Tone::Warning => "warning",
        Tone::Good => "good",
        Tone::Open => "open",
    };
    html! { span.badge.(tone) { span aria-hidden="true" { (badge.symbol) } " " (badge.word) } }
}

/// Names with their likelihoods as bars.
fn likelihoods(heading: &str, of: &[(String, f64)]) -> Markup {
    html! {
        @if !of.is_empty() {
            p.do { (heading) }
            ul.causes {
                @for (name, likelihood) in of {
                    li { (bar(*likelihood)) " " (name) ", " (percent(*likelihood)) }
                }
            }
        }
    }
}

/// A share of one as a bar.
fn bar(share: f64) -> Markup {
    html! {
        span.bar aria-hidden="true" { i style={ "width:" (format!("{:.0}", 100.0 * share)) "%" } {} }
    }
}

fn facts(facts: &[Fact]) -> Markup {
    html! {
        @if !facts.is_empty() {
            dl.facts {
                @for fact in facts {
                    @let gap = if fact.unit.is_empty() { "" } else { "\u{a0}" };
                    div { dt { (fact.name) } dd { (fact.value) (gap) (fact.counted()) } }
                }
            }
        }
    }
}

impl Fact {
    /// Unit, in the singular for one.
    fn counted(&self) -> &str {
        match &*self.unit {
            "samples" if self.value == "1" => "sample",
            unit => unit,
        }
    }
}

/// The items of a list.
fn listed(texts: &[String]) -> Markup {
    html! { @for text in texts { li { (text) } } }
}
