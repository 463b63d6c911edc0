//! The documentation as a site: a folder of HTML pages that needs no network.
//!
//! * [`contents`]: the pages, their order, and the Markdown of those written by hand;
//! * [`markdown`]: a page of Markdown as HTML, with links adapted to the site;
//! * [`schema`]: a JSON schema as readable tables.
//!
//! Generated pages, such as the help of the commands, are handed in as Markdown. Nothing here touches a file: a
//! [`Site`] becomes a list of names and bytes, and equal input gives equal output.
//!
//! ```
//! use stiction_docs::{Page, Site, contents};
//!
//! let mut site = Site::new("stiction 0.1.0");
//! for path in contents::made() {
//!     site.add(Page::new(path, "Made", "# Made\n\nBy a program."));
//! }
//! let files = site.files()?;
//! assert!(files.iter().any(|file| file.path == "index.html"));
//! # Ok::<(), stiction_docs::Missing>(())
//! ```
#![forbid(unsafe_code)]

pub mod contents;
pub mod markdown;
pub mod schema;
mod search;
mod template;

use contents::{CONTENTS, FIGURES};
use markdown::Rendered;
use std::collections::BTreeSet;

/// A page handed in to the site.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Page {
    /// File, relative to the folder of the site, with `/` between folders.
    pub path: String,
    /// Title, for the browser and the search.
    pub title: String,
    /// Content, in Markdown. Links are relative to the page's place in the site.
    pub markdown: String,
    /// The page of the contents that it belongs to, if it is not in the contents itself.
    pub under: Option<String>,
}

impl Page {
    /// A page of the contents.
    pub fn new(
        path: impl Into<String>,
        title: impl Into<String>,
        markdown: impl Into<String>,
    ) -> Self {
        let (path, title, markdown) = (path.into(), title.into(), markdown.into());
        Self { path, title, markdown, under: None }
    }

    /// Puts it under a page of the contents.
    #[must_use]
    pub fn under(mut self, path: impl Into<String>) -> Self {
        self.under = Some(path.into());
        self
    }
}

/// A file of the site.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct File {
    /// Name relative to the folder of the site, with `/` between folders.
    pub path: String,
    /// Content.
    pub bytes: Vec<u8>,
}

impl File {
    /// A file of that name.
    pub fn new(path: impl Into<String>, bytes: impl Into<Vec<u8>>) -> Self {
        Self { path: path.into(), bytes: bytes.into() }
    }
}

/// A page of the contents that was not handed in, or a handed-in page without a place in them.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Missing(String);

impl std::fmt::Display for Missing {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} is in the contents or among the pages, but not in both", self.0)
    }
}

impl std::error::Error for Missing {}

/// The site: the pages written by hand, and those handed in.
#[derive(Debug, Clone)]
pub struct Site {
    tool: String,
    pages: Vec<Page>,
    files: Vec<File>,
}

impl Site {
    /// A site with the pages written by hand; `tool` is the program that makes it, with its version.
    pub fn new(tool: impl Into<String>) -> Self {
        Self { tool: tool.into(), pages: vec![], files: vec![] }
    }

    /// Adds a generated page.
    pub fn add(&mut self, page: Page) {
        self.pages.push(page);
    }

    /// Adds a file for pages.
    pub fn file(&mut self, file: File) {
        self.files.push(file);
    }

    /// All files of the site, by name.
    ///
    /// # Errors
    /// If a page of the contents was not added, or an added page is not in the contents.
    pub fn files(&self) -> Result<Vec<File>, Missing> {
        let mut rendered: Vec<Rendered> = vec![];
        for listed in contents::pages() {
            let page = self.pages.iter().find(|page| page.path == listed.path);
            rendered.push(match (listed.written, page) {
                (Some(written), None) => markdown::written(listed, written),
                (None, Some(page)) => markdown::made(page, listed.path),
                _ => return Err(Missing(listed.path.to_owned())),
            });
        }
        let known: BTreeSet<&str> = contents::pages().map(|page| page.path).collect();
        for page in self.pages.iter().filter(|page| !known.contains(&*page.path)) {
            let above = page.under.as_deref().filter(|above| known.contains(above));
            let above = above.ok_or_else(|| Missing(page.path.clone()))?;
            rendered.push(markdown::made(page, above));
        }

        let mut files = vec![
            File::new(template::STYLE_PATH, template::STYLE),
            File::new(template::SCRIPT_PATH, template::SCRIPT),
            File::new(search::PATH, search::index(&rendered)),
        ];
        files.extend(FIGURES.iter().map(|(path, bytes)| File::new(*path, *bytes)));
        let html =
            |page: &Rendered| File::new(&*page.path, template::page(&self.tool, CONTENTS, page));
        files.extend(rendered.iter().map(html));
        files.extend(self.files.iter().cloned());
        files.sort_by(|a, b| a.path.cmp(&b.path));
        Ok(files)
    }
}

/// The relative path from one file of the site to another, with `/` between folders.
pub fn relative(from: &str, to: &str) -> String {
    let folders = |path: &str| -> Vec<String> {
        let mut parts: Vec<String> = path.split('/').map(str::to_owned).collect();
        parts.pop();
        parts
    };
    let (from, target) = (folders(from), folders(to));
    let common = from.iter().zip(&target).take_while(|(a, b)| a == b).count();
    let name = to.rsplit('/').next().unwrap_or(to);
    let up = (common..from.len()).map(|_| "..");
    let down = target[common..].iter().map(String::as_str);
    up.chain(down).chain([name]).collect::<Vec<_>>().join("/")
}

#[cfg(test)]
mod tests {
    use super::relative;

    #[test]
    fn ways_lead_there() {
        assert_eq!(relative("index.html", "fit.html"), "fit.html");
        assert_eq!(relative("guides/a.html", "fit.html"), "../fit.html");
        assert_eq!(relative("guides/a.html", "guides/b.html"), "b.html");
        assert_eq!(relative("a/b/c.html", "a/d/e.html"), "../d/e.html");
    }
}
