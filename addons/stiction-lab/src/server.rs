//! The server and its connections.

use crate::assets::ASSETS;
use crate::calls;
use crate::guard::{Guard, guard};
use crate::lab::{Lab, Options};
use crate::places::Places;
use crate::recordings;
use crate::turns::Turns;
use axum::http::header;
use axum::routing::get;
use axum::{Router, middleware};
use hyper::Request;
use hyper::body::Incoming;
use hyper::service::{Service as _, service_fn};
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::service::TowerToHyperService;
use std::future::Future;
use std::io;
use std::net::{SocketAddr, TcpListener};
use std::sync::Arc;
use std::time::Duration;

/// How long the head of a request may take, and how long a connection may be idle.
const HEAD: Duration = Duration::from_secs(20);
/// Number of bytes of the head of a request, at most.
const HEAD_SIZE: usize = 64 << 10;
/// How long the server waits at its end for answers that are under way.
const END: Duration = Duration::from_millis(500);

/// A server that listens.
#[derive(Debug)]
pub struct Server {
    listener: TcpListener,
    address: SocketAddr,
    guard: Arc<Guard>,
    lab: Arc<Lab>,
    turns: Arc<Turns>,
}

/// Opens a lab.
///
/// # Errors
/// If the port is not free.
pub fn bind(options: &Options) -> io::Result<Server> {
    let listener = TcpListener::bind((options.host, options.port))?;
    listener.set_nonblocking(true)?;
    let address = listener.local_addr()?;
    let guard = Arc::new(Guard::new(address)?);
    Ok(Server { listener, address, guard, lab: Arc::new(Lab::new(options)), turns: Arc::default() })
}

impl Server {
    /// Where it listens.
    pub fn listens(&self) -> SocketAddr {
        self.address
    }

    /// The token that it requires.
    pub fn token(&self) -> &str {
        self.guard.token()
    }

    /// The address to open. The token follows `#`, so no browser sends it.
    pub fn address(&self) -> String {
        format!("http://{}/#token={}", self.address, self.token())
    }

    /// The turns of calls, to be watched from outside.
    pub fn turns(&self) -> Arc<Turns> {
        Arc::clone(&self.turns)
    }

    /// Answers until `stop` ends.
    ///
    /// # Errors
    /// If the machine gives no threads, or takes the listener away.
    pub fn serve(self, stop: impl Future<Output = ()>) -> io::Result<()> {
        let runtime = tokio::runtime::Builder::new_multi_thread()
            .worker_threads(2)
            .enable_all()
            .thread_name("lab")
            .build()?;
        let served = runtime.block_on(async {
            tokio::select! {
                served = self.accept() => served,
                () = stop => Ok(()),
            }
        });
        runtime.shutdown_timeout(END);
        served
    }

    /// Answers until Ctrl-C.
    ///
    /// # Errors
    /// As [`serve`](Self::serve).
    pub fn serve_until_interrupted(self) -> io::Result<()> {
        self.serve(async {
            // Without signals it ends as any process does.
            if tokio::signal::ctrl_c().await.is_err() {
                std::future::pending::<()>().await;
            }
        })
    }

    fn router(&self) -> Router {
        let mut router = calls::routes(&self.turns).merge(recordings::routes(&self.turns));
        for asset in &ASSETS {
            let answer = move || async move { ([(header::CONTENT_TYPE, asset.kind)], asset.bytes) };
            router = router.route(asset.path, get(answer));
        }
        router
            .layer(middleware::from_fn_with_state(Arc::clone(&self.guard), guard))
            .with_state(Arc::clone(&self.lab))
    }

    /// Accepts connections. Each new connection has a [place](Places).
    async fn accept(&self) -> io::Result<()> {
        let listener = tokio::net::TcpListener::from_std(self.listener.try_clone()?)?;
        let service = TowerToHyperService::new(self.router());
        let places = Arc::new(Places::default());
        loop {
            let stream = match listener.accept().await {
                Ok((stream, _)) => stream,
                // The other side has left already, or too many files are open.
                Err(_) => {
                    tokio::time::sleep(Duration::from_millis(50)).await;
                    continue;
                }
            };
            let (service, place) = (service.clone(), places.take());
            tokio::spawn(async move {
                let _ = stream.set_nodelay(true);
                let here = Arc::clone(&place);
                let placed = service_fn(move |mut request: Request<Incoming>| {
                    request.extensions_mut().insert(Arc::clone(&here));
                    service.call(request)
                });
                let connection = hyper::server::conn::http1::Builder::new()
                    .timer(TokioTimer::new())
                    .header_read_timeout(HEAD)
                    .max_buf_size(HEAD_SIZE)
                    .serve_connection(TokioIo::new(stream), placed);
                tokio::select! {
                    // Only the other side can see what goes wrong on a connection.
                    _ = connection => {}
                    () = place.must_leave() => {}
                }
                place.leaves();
            });
        }
    }
}
