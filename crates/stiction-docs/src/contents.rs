//! The contents of the site: its sections, and the pages of each in their order.
//!
//! A page that is written by hand is a line here: where it stands in the site, its name in the list, and the Markdown
//! file that it is made of. One that is made at `stiction docs` has no such file.

/// A part of the site.
#[derive(Debug, Clone, Copy)]
pub struct Section {
    /// Its name.
    pub title: &'static str,
    /// What a reader finds there, in a line.
    pub about: &'static str,
    /// Its pages.
    pub pages: &'static [Listed],
}

/// A page in the list of contents.
#[derive(Debug, Clone, Copy)]
pub struct Listed {
    /// Its file, from the folder of the site on.
    pub path: &'static str,
    /// Its name in the list.
    pub title: &'static str,
    /// The document it is written in; `None` of a page that is made.
    pub written: Option<Written>,
}

/// A document of the repository.
#[derive(Debug, Clone, Copy)]
pub struct Written {
    /// Its file, from the top of the repository on.
    pub source: &'static str,
    /// What it says, in Markdown.
    pub markdown: &'static str,
}

/// A page written by hand: its place, its name, its document.
macro_rules! written {
    ($path:literal, $title:literal, $source:literal) => {
        Listed {
            path: $path,
            title: $title,
            written: Some(Written {
                source: $source,
                markdown: include_str!(concat!("../../../", $source)),
            }),
        }
    };
}

/// A file of `docs/`: its place in the site, and its bytes.
macro_rules! figure {
    ($path:literal) => {
        ($path, include_bytes!(concat!("../../../docs/", $path)))
    };
}

/// A page that is made: its place and its name.
const fn made_page(path: &'static str, title: &'static str) -> Listed {
    Listed { path, title, written: None }
}

/// The page of all cases.
pub const GALLERY: &str = "gallery.html";
/// The page of all commands.
pub const COMMANDS: &str = "commands.html";
/// The page of all documents in JSON.
pub const SCHEMAS: &str = "schemas.html";
/// The page of the columns of tables.
pub const COLUMNS: &str = "columns.html";
/// The page of the paper's figures.
pub const PAPER: &str = "paper.html";

/// All sections.
pub const CONTENTS: &[Section] = &[
    Section {
        title: "Start",
        about: "What it is, and the first diagnosis.",
        pages: &[
            written!("index.html", "Overview", "docs/index.md"),
            written!("start.html", "A first verdict", "docs/start.md"),
            written!("samples.html", "Sample recordings", "samples/README.md"),
            written!("lab.html", "The lab", "docs/lab.md"),
        ],
    },
    Section {
        title: "Gallery",
        about: "Twelve loops: what they look like, what the verdict says, and what is true.",
        pages: &[made_page(GALLERY, "Twelve loops")],
    },
    Section {
        title: "Guides",
        about: "From a task to its answer, command by command.",
        pages: &[
            written!("guides/engineer.html", "For engineers", "docs/guides/engineer.md"),
            written!("guides/researcher.html", "For researchers", "docs/guides/researcher.md"),
            written!("guides/teacher.html", "For teachers", "docs/guides/teacher.md"),
            written!("guides/fmu.html", "For users of FMUs", "docs/guides/fmu.md"),
            written!("guides/rust.html", "For Rust programmers", "docs/guides/rust.md"),
            written!("python.html", "Python", "python/README.md"),
            written!("cookbook.html", "Cookbook for Rust", "crates/stiction/COOKBOOK.md"),
            written!("fmu.html", "FMUs", "docs/fmu.md"),
        ],
    },
    Section {
        title: "How it works",
        about: "The valve, the loop, its cycle, and how a recording is judged.",
        pages: &[
            written!("valve-model.html", "The valve model", "docs/valve-model.md"),
            written!("closed-loop.html", "The control loop", "docs/closed-loop.md"),
            written!("limit-cycles.html", "Limit cycles", "docs/limit-cycles.md"),
            written!("recordings.html", "Recordings", "docs/recordings.md"),
            written!("diagnosis.html", "Diagnosis", "docs/diagnosis.md"),
            written!("methods.html", "Methods", "docs/methods.md"),
            written!("fit.html", "The loop behind a recording", "docs/fit.md"),
            written!("test.html", "The test", "docs/test.md"),
            written!("compensation.html", "What to do about it", "docs/compensation.md"),
            written!("plant.html", "A plant, day by day", "docs/plant.md"),
            written!("spark.html", "A plant on Spark", "docs/spark.md"),
            written!("population.html", "Simulated loops", "docs/population.md"),
        ],
    },
    Section {
        title: "Reference",
        about: "Every command, key, document, column and function.",
        pages: &[
            made_page(COMMANDS, "Commands"),
            written!("scenarios.html", "Keys of a scenario", "docs/scenarios.md"),
            made_page(SCHEMAS, "JSON documents"),
            made_page(COLUMNS, "Columns of tables"),
            written!("python-api.html", "Python API", "docs/python-api.md"),
            written!("crates.html", "Rust crates", "docs/crates.md"),
        ],
    },
    Section {
        title: "How well it works",
        about: "How often it is right, counted, with what was aimed at and missed.",
        pages: &[
            written!("accuracy.html", "Accuracy", "docs/accuracy.md"),
            written!("scoreboard.html", "The scoreboard", "docs/scoreboard.md"),
            written!(
                "model-card.html",
                "The trained model",
                "crates/stiction-diagnose/model/README.md"
            ),
            written!("benchmarks.html", "Speed", "BENCHMARKS.md"),
        ],
    },
    Section {
        title: "The paper",
        about: "Every figure of the paper, with the command that draws it.",
        pages: &[made_page(PAPER, "Figure by figure")],
    },
    Section {
        title: "Glossary",
        about: "Words as this project uses them.",
        pages: &[written!("glossary.html", "Glossary", "docs/glossary.md")],
    },
];

/// Figures that written pages show: their place in the site, which is that beside `docs/`, and their bytes.
pub const FIGURES: &[(&str, &[u8])] = &[
    figure!("figures/closed-loop-block-diagram.svg"),
    figure!("figures/closed-loop-response.svg"),
    figure!("figures/fmu-communication-step.svg"),
    figure!("figures/index.png"),
    figure!("figures/lab-guess.png"),
    figure!("figures/lab-loop.png"),
    figure!("figures/lab-plant.png"),
    figure!("figures/lab-recordings.png"),
    figure!("figures/map.png"),
    figure!("figures/plant.png"),
    figure!("figures/report.png"),
    figure!("figures/sticking-valve.svg"),
    figure!("figures/valve-model-flow-chart.svg"),
];

/// All pages of the contents, in their order.
pub fn pages() -> impl Iterator<Item = &'static Listed> {
    CONTENTS.iter().flat_map(|section| section.pages)
}

/// The pages that have to be handed in.
pub fn made() -> impl Iterator<Item = &'static str> {
    pages().filter(|page| page.written.is_none()).map(|page| page.path)
}

/// Where a file of the repository is in the site, if it is.
pub(crate) fn place_of(source: &str) -> Option<&'static str> {
    let page = pages().find(|page| page.written.is_some_and(|written| written.source == source));
    let figure = || {
        let shown = source.strip_prefix("docs/")?;
        FIGURES.iter().find(|(path, _)| *path == shown).map(|(path, _)| *path)
    };
    page.map(|page| page.path).or_else(figure)
}
