//! Places of connections: who has shown no token gets few, for a short time, and gives way to who comes after.
//!
//! So whoever holds open as many connections as the machine has keeps nobody out: a page asks as soon as it is
//! connected, is known by its token, and then nobody takes its place.

use axum::body::Body;
use hyper::body::{Bytes, Frame, SizeHint};
use std::collections::VecDeque;
use std::pin::Pin;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::task::{Context, Poll, ready};
use std::time::Duration;
use tokio::sync::Notify;
use tokio::time::{Instant, Sleep, sleep};

/// Connections of who is known; others wait to be taken.
const KNOWN: usize = 128;
/// Connections of strangers; the oldest gives way to the next.
const STRANGERS: usize = 64;
/// How long one may be a stranger.
const STRANGE: Duration = Duration::from_secs(5);
/// How long the next piece of a question may take.
const PIECE: Duration = Duration::from_secs(10);

/// The places of all connections.
#[derive(Debug, Default)]
pub(crate) struct Places {
    taken: Mutex<Taken>,
    free: Notify,
}

#[derive(Debug, Default)]
struct Taken {
    known: usize,
    strangers: VecDeque<Arc<Place>>,
}

/// The place of a connection.
#[derive(Debug)]
pub(crate) struct Place {
    places: Arc<Places>,
    is_known: AtomicBool,
    give_way: Notify,
}

impl Places {
    fn taken(&self) -> MutexGuard<'_, Taken> {
        self.taken.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Waits until one more could become known.
    pub async fn wait(&self) {
        while self.taken().known >= KNOWN {
            // Whether one leaves or not, it is looked again in a moment.
            let _ = tokio::time::timeout(Duration::from_millis(50), self.free.notified()).await;
        }
    }

    /// A place for a stranger.
    pub fn take(self: &Arc<Self>) -> Arc<Place> {
        let place = Arc::new(Place {
            places: Arc::clone(self),
            is_known: AtomicBool::new(false),
            give_way: Notify::new(),
        });
        let mut taken = self.taken();
        taken.strangers.push_back(Arc::clone(&place));
        if taken.strangers.len() > STRANGERS {
            taken.strangers.pop_front().inspect(|oldest| oldest.give_way.notify_one());
        }
        place
    }

    /// Whoever was there has left.
    pub fn leave(&self, place: &Arc<Place>) {
        let mut taken = self.taken();
        match place.is_known.load(Ordering::Relaxed) {
            true => taken.known -= 1,
            false => taken.strangers.retain(|other| !Arc::ptr_eq(other, place)),
        }
        self.free.notify_one();
    }
}

impl Place {
    /// Whoever is here has shown the token.
    pub fn is_known_now(self: &Arc<Self>) {
        let mut taken = self.places.taken();
        if !self.is_known.swap(true, Ordering::Relaxed) {
            taken.known += 1;
            taken.strangers.retain(|other| !Arc::ptr_eq(other, self));
        }
    }

    /// Ends when whoever is here must leave.
    pub async fn must_leave(&self) {
        tokio::select! {
            () = self.give_way.notified() => {}
            () = sleep(STRANGE) => {}
        }
        if self.is_known.load(Ordering::Relaxed) {
            std::future::pending::<()>().await;
        }
    }
}

/// A body whose next piece must come in time.
pub(crate) struct Paced {
    body: Body,
    until: Pin<Box<Sleep>>,
}

impl Paced {
    /// The body, paced.
    pub fn of(body: Body) -> Body {
        Body::new(Self { body, until: Box::pin(sleep(PIECE)) })
    }
}

impl hyper::body::Body for Paced {
    type Data = Bytes;
    type Error = axum::BoxError;

    fn poll_frame(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
    ) -> Poll<Option<Result<Frame<Bytes>, axum::BoxError>>> {
        if let Poll::Ready(frame) = Pin::new(&mut self.body).poll_frame(context) {
            self.until.as_mut().reset(Instant::now() + PIECE);
            return Poll::Ready(frame.map(|frame| frame.map_err(Into::into)));
        }
        ready!(self.until.as_mut().poll(context));
        Poll::Ready(Some(Err("the question does not go on".into())))
    }

    fn is_end_stream(&self) -> bool {
        self.body.is_end_stream()
    }

    fn size_hint(&self) -> SizeHint {
        self.body.size_hint()
    }
}
