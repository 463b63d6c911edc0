//! The diagnosis of a loop together with its source file.

use crate::diagnose::Diagnosis;
use std::fmt;
use std::ops::Deref;

#[cfg(feature = "report")]
use stiction_report::{
    document::{Document, Loop, Source},
    report::{Fitted, html},
};

/// The [`Diagnosis`] of one loop of a file, whose fields can be read directly, and the file.
#[derive(Debug, Clone, PartialEq)]
pub struct Found {
    /// Name of the file, as messages show it.
    pub origin: String,
    /// SHA-256 of its bytes, in hexadecimal.
    pub sha256: String,
    /// The diagnosis.
    pub diagnosis: Diagnosis,
}

impl Deref for Found {
    type Target = Diagnosis;

    fn deref(&self) -> &Diagnosis {
        &self.diagnosis
    }
}

/// The diagnosis in one line.
impl fmt::Display for Found {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.diagnosis.fmt(f)
    }
}

#[cfg(feature = "report")]
impl Found {
    /// The report on this loop.
    pub fn report(&self) -> Report<'_> {
        Report::of(std::slice::from_ref(self))
    }
}

/// Name and version of this library, as reports and documents show them.
#[cfg(feature = "report")]
const TOOL: &str = concat!("stiction ", env!("CARGO_PKG_VERSION"));

/// The report on some loops, as a self-contained page or as a document for programs.
#[cfg(feature = "report")]
#[derive(Debug, Clone)]
pub struct Report<'a> {
    found: &'a [Found],
    sources: Vec<Source>,
}

#[cfg(feature = "report")]
impl<'a> Report<'a> {
    /// The report on all of `found`, worst first.
    pub fn of(found: &'a [Found]) -> Self {
        let source = |f: &Found| Source { file: f.origin.clone(), sha256: f.sha256.clone() };
        Self { found, sources: found.iter().map(source).collect() }
    }

    fn loops(&self) -> Vec<Loop<'_>> {
        let loops = self.found.iter().zip(&self.sources);
        loops.map(|(found, source)| Loop::new(source, &found.diagnosis)).collect()
    }

    /// The page, as HTML that needs no other file and no network.
    ///
    /// # Errors
    /// If a figure cannot be drawn, which is not expected.
    pub fn html(&self) -> Result<String, stiction_report::Error> {
        let loops = self.loops();
        let fits: Vec<_> = loops.iter().map(|each| Fitted::of_accused(each.diagnosis)).collect();
        let fitted = loops.iter().zip(&fits).map(|(each, fit)| each.with_fit(fit));
        html(TOOL, &fitted.collect::<Vec<_>>())
    }

    /// What `stiction diagnose --json` prints of these loops.
    pub fn document(&self) -> Document<'_> {
        Document::new(TOOL, self.loops())
    }

    /// Writes the page to the file at `path`, either whole or not at all (see [`stiction_io::whole`]).
    ///
    /// # Errors
    /// If a figure cannot be drawn or the file cannot be written.
    pub fn save(&self, path: impl AsRef<std::path::Path>) -> std::io::Result<()> {
        let page = self.html().map_err(std::io::Error::other)?;
        stiction_io::whole::write(path.as_ref(), page.as_bytes())
    }
}

#[cfg(all(test, feature = "report"))]
mod tests {
    /// A failed write leaves the existing report unchanged.
    #[test]
    fn a_report_is_saved_whole_or_not_at_all() {
        let samples = concat!(env!("CARGO_MANIFEST_DIR"), "/../../samples/FIC101-sticky.csv");
        let found = crate::read(samples).unwrap().diagnose().unwrap();
        let folder = std::env::temp_dir().join(format!("stiction-save-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let page = folder.join("page.html");
        super::Report::of(&found).save(&page).unwrap();
        let whole = std::fs::read_to_string(&page).unwrap();
        assert!(whole.trim_end().ends_with("</html>"));
        let mut permissions = std::fs::metadata(&page).unwrap().permissions();
        permissions.set_readonly(true);
        std::fs::set_permissions(&page, permissions).unwrap();
        assert!(found[0].report().save(&page).is_err());
        assert_eq!(std::fs::read_to_string(&page).unwrap(), whole);
        std::fs::remove_dir_all(&folder).unwrap();
    }
}
