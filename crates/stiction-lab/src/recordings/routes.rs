//! What is no question in JSON: bytes of a trend, a file that is dropped, a report to be saved.

use super::{Stretch, found, page, trend};
use crate::calls::{Answer, Gate, Wrong, blocking, sent};
use crate::lab::Lab;
use axum::Router;
use axum::body::Body;
use axum::extract::{Query, State};
use axum::http::header;
use axum::response::{IntoResponse, Response};
use axum::routing::{get, post};
use serde::Deserialize;
use std::sync::Arc;
use std::time::Duration;
use tokio::sync::Semaphore;

/// Bytes of a file that is dropped.
pub(super) const DROPPED: usize = 256 << 20;

/// How long a file may take to come.
const IN_TIME: Duration = Duration::from_secs(180);
/// So many files come at a time; others wait, so that those under way are all that is in memory besides what is open.
const AT_ONCE: usize = 2;

/// What a report may do: run its own script, and nothing else.
const OF_A_REPORT: &str = "sandbox allow-scripts allow-modals allow-popups; default-src 'none'; \
     style-src 'unsafe-inline'; script-src 'unsafe-inline'; img-src data:";

#[derive(Deserialize)]
struct Named {
    name: String,
}

#[derive(Deserialize)]
struct Page {
    #[serde(default)]
    save: bool,
    file: String,
    #[serde(rename = "loop")]
    tag: String,
    from: Option<f64>,
    to: Option<f64>,
}

impl Page {
    fn stretch(self) -> Stretch {
        Stretch { file: self.file, tag: self.tag, from: self.from, to: self.to }
    }
}

/// The routes of recordings beside the calls.
pub(crate) fn routes(gate: &Gate) -> Router<Arc<Lab>> {
    let (of_trend, of_page) = (Arc::clone(gate), Arc::clone(gate));
    let trend = move |State(lab): State<Arc<Lab>>, Query(asked): Query<Page>| async move {
        let work =
            move || found(&lab, &asked.stretch()).map(|found| trend::bytes(&found.recording));
        let bytes = blocking(of_trend, work).await?;
        Ok::<_, Wrong>(([(header::CONTENT_TYPE, "application/octet-stream")], bytes))
    };
    let report = move |State(lab): State<Arc<Lab>>, Query(asked): Query<Page>| async move {
        let save = asked.save;
        let (name, html) = blocking(of_page, move || page(&lab, &asked.stretch())).await?;
        Ok::<_, Wrong>(shown(&name, html, save))
    };
    let coming = Arc::new(Semaphore::new(AT_ONCE));
    let upload = move |State(lab): State<Arc<Lab>>,
                       Query(Named { name }): Query<Named>,
                       body: Body| async move {
        let _turn = coming.acquire_owned().await.map_err(Wrong::own)?;
        let bytes = sent(body, DROPPED, IN_TIME).await.map_err(|wrong| {
            wrong.with(format!(
                "{name} is larger than {} MiB, or broke off; name it when you start `stiction lab`, which reads it from \
                 the disk",
                DROPPED >> 20
            ))
        })?;
        let entry = lab.recordings.take(&name, bytes.into())?.entry();
        let json = serde_json::to_vec(&entry).map_err(Wrong::own)?;
        Answer::Ok(([(header::CONTENT_TYPE, "application/json")], json))
    };
    Router::new()
        .route("/api/recordings/trend", get(trend))
        .route("/api/recordings/report", get(report))
        .route("/api/recordings/upload", post(upload))
}

/// A page of a report, to be looked at or saved.
fn shown(name: &str, html: String, save: bool) -> Response {
    let plain = |c: char| if c.is_ascii_alphanumeric() || "-_.".contains(c) { c } else { '_' };
    let name: String = name.chars().map(plain).collect();
    let how = if save { "attachment" } else { "inline" };
    let headers = [
        (header::CONTENT_TYPE, "text/html; charset=utf-8".to_owned()),
        (header::CONTENT_DISPOSITION, format!("{how}; filename=\"{name}\"")),
        (header::CONTENT_SECURITY_POLICY, OF_A_REPORT.to_owned()),
    ];
    (headers, html).into_response()
}
