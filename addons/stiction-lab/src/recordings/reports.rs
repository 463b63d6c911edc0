//! Reports as pages of their own, which the browser opens without the token.
//!
//! The address of a report holds 128 random bits, and opens this report only. The page runs in a sandbox, with a
//! separate origin, so its scripts cannot reach the lab.

use crate::calls::{Answer, Wrong};
use crate::guard;
use crate::lab::locked;
use axum::http::{StatusCode, header};
use axum::response::{IntoResponse, Response};
use std::collections::VecDeque;
use std::sync::Mutex;

/// The beginning of the addresses of reports.
pub(crate) const REPORTS: &str = "/report/";
/// How many are kept; the oldest is given up.
const KEPT: usize = 16;

/// What a report may do: run its own script, and nothing else.
const MAY: &str = concat!(
    "sandbox allow-scripts allow-modals allow-popups; ",
    "default-src 'none'; ",
    "style-src 'unsafe-inline'; ",
    "script-src 'unsafe-inline'; ",
    "img-src data:"
);

/// The reports that were opened last.
#[derive(Debug, Default)]
pub(super) struct Reports(Mutex<VecDeque<Report>>);

#[derive(Debug, Clone)]
struct Report {
    secret: String,
    name: String,
    html: String,
}

impl Reports {
    /// Keeps a report, and gives its address.
    pub fn keep(&self, name: &str, html: String) -> Answer<String> {
        let plain = |c: char| if c.is_ascii_alphanumeric() || "-_.".contains(c) { c } else { '_' };
        let secret = guard::secret().map_err(Wrong::own)?;
        let address = format!("{REPORTS}{secret}");
        let mut kept = locked(&self.0);
        kept.push_back(Report { secret, name: name.chars().map(plain).collect(), html });
        while kept.len() > KEPT {
            kept.pop_front();
        }
        Ok(address)
    }

    /// The page at an address, to be looked at or saved.
    pub fn page(&self, secret: &str, save: bool) -> Response {
        let kept = locked(&self.0);
        let found = kept.iter().find(|report| guard::is_same(&report.secret, secret)).cloned();
        drop(kept);
        let Some(Report { name, html, .. }) = found else {
            let words = "The lab no longer keeps this report. Open the report again from the page of the loop.\n";
            return (StatusCode::NOT_FOUND, words).into_response();
        };
        let how = if save { "attachment" } else { "inline" };
        let headers = [
            (header::CONTENT_TYPE, "text/html; charset=utf-8".to_owned()),
            (header::CONTENT_DISPOSITION, format!("{how}; filename=\"{name}\"")),
            (header::CONTENT_SECURITY_POLICY, MAY.to_owned()),
        ];
        // A page in a sandbox cannot ask for a group of pages of its own as well.
        ([("cross-origin-opener-policy", "unsafe-none")], headers, html).into_response()
    }
}
