//! The server: connections, their number and their time.

use crate::assets::ASSETS;
use crate::calls;
use crate::guard::{Guard, guard};
use crate::lab::{Lab, Options};
use crate::recordings;
use axum::extract::DefaultBodyLimit;
use axum::http::header;
use axum::routing::get;
use axum::{Router, middleware};
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::service::TowerToHyperService;
use std::future::Future;
use std::io;
use std::net::{SocketAddr, TcpListener};
use std::sync::Arc;
use std::time::Duration;
use tokio::sync::Semaphore;

/// Connections that are open at a time; others wait to be taken.
const CONNECTIONS: usize = 128;
/// How long the head of a request may take, and how long a connection may be idle.
const HEAD: Duration = Duration::from_secs(20);
/// Bytes of a question.
const QUESTION: usize = 1 << 20;
/// How long answers that are under way are waited for at the end.
const END: Duration = Duration::from_millis(500);

/// A server that listens.
#[derive(Debug)]
pub struct Server {
    listener: TcpListener,
    address: SocketAddr,
    guard: Arc<Guard>,
    lab: Arc<Lab>,
}

/// Opens a lab.
///
/// # Errors
/// If the port cannot be had.
pub fn bind(options: &Options) -> io::Result<Server> {
    let listener = TcpListener::bind((options.host, options.port))?;
    listener.set_nonblocking(true)?;
    let address = listener.local_addr()?;
    let guard = Arc::new(Guard::new(address)?);
    Ok(Server { listener, address, guard, lab: Arc::new(Lab::new(options)) })
}

impl Server {
    /// Where it listens.
    pub fn listens(&self) -> SocketAddr {
        self.address
    }

    /// The token that it asks for.
    pub fn token(&self) -> &str {
        self.guard.token()
    }

    /// The address to open, with its token.
    pub fn address(&self) -> String {
        format!("http://{}/?token={}", self.address, self.token())
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
            // Without a signal to wait for it ends as any process does.
            if tokio::signal::ctrl_c().await.is_err() {
                std::future::pending::<()>().await;
            }
        })
    }

    fn router(&self) -> Router {
        let gate = calls::gate();
        let mut router = calls::routes(&gate)
            .layer(DefaultBodyLimit::max(QUESTION))
            .merge(recordings::routes(&gate));
        for asset in &ASSETS {
            let answer = move || async move { ([(header::CONTENT_TYPE, asset.kind)], asset.bytes) };
            router = router.route(asset.path, get(answer));
        }
        router
            .layer(middleware::from_fn_with_state(Arc::clone(&self.guard), guard))
            .with_state(Arc::clone(&self.lab))
    }

    async fn accept(&self) -> io::Result<()> {
        let listener = tokio::net::TcpListener::from_std(self.listener.try_clone()?)?;
        let service = TowerToHyperService::new(self.router());
        let gate = Arc::new(Semaphore::new(CONNECTIONS));
        loop {
            let Ok(turn) = Arc::clone(&gate).acquire_owned().await else { return Ok(()) };
            let stream = match listener.accept().await {
                Ok((stream, _)) => stream,
                // One that was given up meanwhile, or too many files for now.
                Err(_) => {
                    tokio::time::sleep(Duration::from_millis(50)).await;
                    continue;
                }
            };
            let service = service.clone();
            tokio::spawn(async move {
                let _turn = turn;
                let _ = stream.set_nodelay(true);
                // What goes wrong on a connection is the other side's to see.
                let _ = hyper::server::conn::http1::Builder::new()
                    .timer(TokioTimer::new())
                    .header_read_timeout(HEAD)
                    .serve_connection(TokioIo::new(stream), service)
                    .await;
            });
        }
    }
}
