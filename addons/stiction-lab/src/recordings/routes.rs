//! Routes beside the calls: bytes of a trend, a file that is dropped, the page of a report.

use super::{Stretch, found, reports::REPORTS, trend};
use crate::calls::{Answer, Wrong, sent};
use crate::lab::Lab;
use crate::turns::{Cost, Turns, Wanted};
use axum::Router;
use axum::body::Body;
use axum::extract::{Path, Query, State};
use axum::http::{StatusCode, header};
use axum::routing::{get, post};
use serde::Deserialize;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Duration;

/// The largest size of a dropped file, bytes.
pub(super) const DROPPED: usize = 256 << 20;

/// How long a file may take to come.
const IN_TIME: Duration = Duration::from_secs(180);
/// Number of bytes of files that are arriving, together at most. A slow receiver takes only the data that have arrived,
/// and delays no other.
const ARRIVING: usize = 2 * DROPPED;

/// The share of a file in the bytes that are arriving.
struct Share {
    of: Arc<AtomicUsize>,
    own: usize,
}

impl Share {
    fn grow(&mut self, bytes: usize) -> Answer<()> {
        self.own += bytes;
        if self.of.fetch_add(bytes, Ordering::Relaxed) + bytes > ARRIVING {
            return Err(Wrong::own(
                "other files are arriving, and there is no memory for another; drop this file again when the others have arrived",
            ));
        }
        Ok(())
    }
}

impl Drop for Share {
    fn drop(&mut self) {
        self.of.fetch_sub(self.own, Ordering::Relaxed);
    }
}

#[derive(Deserialize)]
struct Named {
    name: String,
}

#[derive(Deserialize)]
struct Of {
    file: String,
    #[serde(rename = "loop")]
    tag: String,
}

#[derive(Deserialize)]
struct How {
    #[serde(default)]
    save: bool,
}

/// The routes of recordings beside the calls.
pub(crate) fn routes(turns: &Arc<Turns>) -> Router<Arc<Lab>> {
    let turns = Arc::clone(turns);
    let trend = move |State(lab): State<Arc<Lab>>, Query(Of { file, tag }): Query<Of>| async move {
        let all = Stretch { file, tag, from: None, to: None };
        let work = move |_: &Wanted| found(&lab, &all).map(|found| trend::bytes(&found.recording));
        let bytes = turns.take(Cost::Medium, work).await?;
        Ok::<_, Wrong>(([(header::CONTENT_TYPE, "application/octet-stream")], bytes))
    };
    let report = move |State(lab): State<Arc<Lab>>,
                       Path(secret): Path<String>,
                       Query(How { save }): Query<How>| async move {
        lab.recordings.reports.page(&secret, save)
    };
    let arriving = Arc::new(AtomicUsize::new(0));
    let upload = move |State(lab): State<Arc<Lab>>,
                       Query(Named { name }): Query<Named>,
                       body: Body| async move {
        let mut share = Share { of: arriving, own: 0 };
        let sent = sent(body, DROPPED, IN_TIME, |bytes| share.grow(bytes)).await;
        let bytes = sent.map_err(|wrong| match wrong.status() {
            StatusCode::SERVICE_UNAVAILABLE => wrong,
            _ => wrong.with(format!(
                "{name} is larger than {} MiB, or was cut off; name it in the command `stiction lab`, which reads it from \
                 disk",
                DROPPED >> 20
            )),
        })?;
        let entry = lab.recordings.take(&name, bytes)?.entry();
        let json = serde_json::to_vec(&entry).map_err(Wrong::own)?;
        Answer::Ok(([(header::CONTENT_TYPE, "application/json")], json))
    };
    Router::new()
        .route("/api/recordings/trend", get(trend))
        .route(&format!("{REPORTS}{{secret}}"), get(report))
        .route("/api/recordings/upload", post(upload))
}
