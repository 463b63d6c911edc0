//! Places of connections. A new connection always gets a place. If no place is free, an older connection is closed.
//!
//! | who | places | gives way |
//! |---|---|---|
//! | has not shown the token | 64, for 5 s | the oldest first |
//! | has shown it, and sends a question or nothing | 128, with the next row | the one that has been quiet longest, first |
//! | has asked, and waits for the answer | | the one that has waited longest, if all 128 wait |
//!
//! So neither silent connections nor half-sent questions keep anybody out.

use crate::lab::locked;
use axum::body::{Body, HttpBody};
use hyper::body::{Bytes, Frame, SizeHint};
use std::collections::VecDeque;
use std::pin::Pin;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::task::{Context, Poll, ready};
use std::time::Duration;
use tokio::sync::Notify;
use tokio::time::{Instant, Sleep, sleep};

/// Connections that have shown the token.
const KNOWN: usize = 128;
/// Connections that have not.
const STRANGERS: usize = 64;
/// How long a connection may go without showing the token.
const STRANGE: Duration = Duration::from_secs(5);
/// How long the next piece of a question may take.
const PIECE: Duration = Duration::from_secs(10);

/// The places of all connections, the first to give way first.
#[derive(Debug, Default)]
pub(crate) struct Places(Mutex<Taken>);

#[derive(Debug, Default)]
struct Taken {
    strangers: VecDeque<Arc<Place>>,
    quiet: VecDeque<Arc<Place>>,
    waiting: VecDeque<Arc<Place>>,
}

/// The place of a connection.
#[derive(Debug)]
pub(crate) struct Place {
    places: Arc<Places>,
    is_known: AtomicBool,
    give_way: Notify,
}

impl Places {
    /// A place for a connection that has not shown the token.
    pub fn take(self: &Arc<Self>) -> Arc<Place> {
        let place = Arc::new(Place {
            places: Arc::clone(self),
            is_known: AtomicBool::new(false),
            give_way: Notify::new(),
        });
        place.moves(|taken| &mut taken.strangers);
        place
    }
}

impl Taken {
    fn remove(&mut self, place: &Arc<Place>) {
        for of in [&mut self.strangers, &mut self.quiet, &mut self.waiting] {
            of.retain(|other| !Arc::ptr_eq(other, place));
        }
    }

    /// Connections that must give way, as there are too many.
    fn too_many(&mut self) -> Option<Arc<Place>> {
        if self.strangers.len() > STRANGERS {
            return self.strangers.pop_front();
        }
        if self.quiet.len() + self.waiting.len() <= KNOWN {
            return None;
        }
        // The one that has just come is the last of the quiet ones, and stays.
        if self.quiet.len() > 1 { self.quiet.pop_front() } else { self.waiting.pop_front() }
    }
}

impl Place {
    /// Moves the connection behind the others of its kind.
    fn moves(self: &Arc<Self>, to: impl FnOnce(&mut Taken) -> &mut VecDeque<Arc<Self>>) {
        let mut taken = locked(&self.places.0);
        taken.remove(self);
        to(&mut taken).push_back(Arc::clone(self));
        while let Some(other) = taken.too_many() {
            other.give_way.notify_one();
        }
    }

    /// The token was shown, or an answer given.
    pub fn is_quiet(self: &Arc<Self>) {
        self.is_known.store(true, Ordering::Relaxed);
        self.moves(|taken| &mut taken.quiet);
    }

    /// A whole question has come.
    fn waits(self: &Arc<Self>) {
        self.moves(|taken| &mut taken.waiting);
    }

    /// The connection has ended.
    pub fn leaves(self: &Arc<Self>) {
        locked(&self.places.0).remove(self);
    }

    /// Ends when the connection must be closed.
    pub async fn must_leave(&self) {
        tokio::select! {
            () = self.give_way.notified() => return,
            () = sleep(STRANGE) => {}
        }
        if self.is_known.load(Ordering::Relaxed) {
            self.give_way.notified().await;
        }
    }
}

/// A body whose next piece must come in time; its end is the end of the question.
pub(crate) struct Paced {
    body: Body,
    until: Pin<Box<Sleep>>,
    place: Option<Arc<Place>>,
}

impl Paced {
    /// The body, paced.
    pub fn of(body: Body, place: Option<Arc<Place>>) -> Body {
        let mut paced = Self { body, until: Box::pin(sleep(PIECE)), place };
        paced.look_for_end();
        Body::new(paced)
    }

    fn look_for_end(&mut self) {
        if self.body.is_end_stream() {
            self.place.take().inspect(Place::waits);
        }
    }
}

impl HttpBody for Paced {
    type Data = Bytes;
    type Error = axum::BoxError;

    fn poll_frame(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
    ) -> Poll<Option<Result<Frame<Bytes>, axum::BoxError>>> {
        if let Poll::Ready(frame) = Pin::new(&mut self.body).poll_frame(context) {
            self.until.as_mut().reset(Instant::now() + PIECE);
            self.look_for_end();
            return Poll::Ready(frame.map(|frame| frame.map_err(Into::into)));
        }
        ready!(self.until.as_mut().poll(context));
        Poll::Ready(Some(Err("the request has stopped".into())))
    }

    fn is_end_stream(&self) -> bool {
        self.body.is_end_stream()
    }

    fn size_hint(&self) -> SizeHint {
        self.body.size_hint()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn silent_connections_give_way_before_those_that_wait_for_an_answer() {
        let places = Arc::new(Places::default());
        let connect = || {
            let place = places.take();
            place.is_quiet();
            place
        };
        let stays = |place: &Arc<Place>| {
            let taken = locked(&places.0);
            taken.quiet.iter().chain(&taken.waiting).any(|other| Arc::ptr_eq(other, place))
        };
        let first = connect();
        first.waits();
        let silent = connect();
        let others: Vec<_> = (0..KNOWN - 2).map(|_| connect()).collect();
        assert!(stays(&first) && stays(&silent));
        let next = connect();
        assert!(stays(&first) && !stays(&silent) && stays(&next));
        // If all wait for answers, the one that has waited longest gives way to the one that comes.
        others.iter().chain([&next]).for_each(Place::waits);
        let last = connect();
        assert!(!stays(&first) && stays(&others[0]) && stays(&last));
        // Strangers take nothing from the others.
        let strangers: Vec<_> = (0..1000).map(|_| places.take()).collect();
        assert_eq!(locked(&places.0).strangers.len(), STRANGERS);
        assert!(stays(&last) && others.iter().all(stays));
        strangers.iter().for_each(Place::leaves);
        assert_eq!(locked(&places.0).strangers.len(), 0);
    }
}
