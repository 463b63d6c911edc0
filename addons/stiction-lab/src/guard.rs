//! Access to the lab. Only requests from its own page with the token are answered.
//!
//! The page itself, without data, is served to anybody. Every call needs the token, 128 random bits, in the header
//! `Authorization`. The printed address carries the token behind `#`, so browsers never send it. The page moves the
//! token to the session storage of its origin, which includes the port. No cookie is set, as browsers send cookies to
//! every port of a host.
//!
//! | attack | what stops it |
//! |---|---|
//! | a page of another site, or of another port of this machine, asks | it does not have the token; an `Origin` other than the lab's own is refused |
//! | a foreign name that resolves to this machine (DNS rebinding) | a `Host` other than the lab's own is refused |
//! | another user of the machine asks | the token |
//! | very many connections | connections that have not shown the token have few places, for seconds, and give way (`places`) |
//! | abandoned costly calls | costly calls take turns among themselves, and stop when nobody waits ([`turns`](crate::turns)) |
//! | a script in a recording's name | a strict policy on what the page may load; no text is interpreted as markup |
//! | a script in a report | a sandbox with an origin of its own |
//!
//! To open the browser, the command passes it the address as an argument. Where users can list each other's processes,
//! other users can read the token during that moment. `--no-open` avoids this.

use crate::assets::ASSETS;
use crate::places::{Paced, Place};
use crate::recordings::REPORTS;
use axum::extract::{Request, State};
use axum::http::{HeaderMap, HeaderValue, Method, StatusCode, header};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};
use std::net::SocketAddr;
use std::sync::Arc;

/// What is asked of every request.
#[derive(Debug)]
pub(crate) struct Guard {
    token: String,
    /// The names by which the lab is asked, with its port.
    hosts: Vec<String>,
}

/// 128 random bits, as text.
pub(crate) fn secret() -> std::io::Result<String> {
    let mut bytes = [0u8; 16];
    getrandom::fill(&mut bytes).map_err(std::io::Error::other)?;
    Ok(bytes.iter().map(|byte| format!("{byte:02x}")).collect())
}

/// Whether a text is a secret; takes as long for all texts of its length.
pub(crate) fn is_same(secret: &str, said: &str) -> bool {
    let different = said.bytes().zip(secret.bytes()).fold(0, |sum, (a, b)| sum | (a ^ b));
    said.len() == secret.len() && different == 0
}

/// What the page may load: its own script, style and answers only.
const POLICY: &str = concat!(
    "default-src 'none'; ",
    "script-src 'self'; ",
    "style-src 'self'; ",
    "img-src 'self' data: blob:; ",
    "connect-src 'self'; ",
    "frame-src 'self'; ",
    "base-uri 'none'; ",
    "form-action 'none'; ",
    "frame-ancestors 'none'"
);

const ELSEWHERE: &str = "the lab serves only its own page";

/// Whether anybody may load something: the page itself, which holds no data, and reports by their secret addresses.
fn is_open(request: &Request) -> bool {
    let path = request.uri().path();
    ASSETS.iter().any(|asset| asset.path == path) || path.starts_with(REPORTS)
}

impl Guard {
    /// A guard with a new token.
    ///
    /// # Errors
    /// If the machine gives no random numbers.
    pub fn new(bound: SocketAddr) -> std::io::Result<Self> {
        let port = bound.port();
        let mut hosts = vec![format!("localhost:{port}"), bound.to_string()];
        for name in ["127.0.0.1", "[::1]"] {
            hosts.push(format!("{name}:{port}"));
        }
        Ok(Self { token: secret()?, hosts })
    }

    /// What the token is.
    pub fn token(&self) -> &str {
        &self.token
    }

    fn is_host(&self, host: &str) -> bool {
        self.hosts.iter().any(|own| own.eq_ignore_ascii_case(host))
    }

    /// Whether headers have the token, as `Authorization: Bearer`.
    fn is_known(&self, headers: &HeaderMap) -> bool {
        let lines = headers.get_all(header::AUTHORIZATION).iter();
        lines
            .filter_map(|line| line.to_str().ok()?.strip_prefix("Bearer "))
            .any(|token| is_same(&self.token, token.trim()))
    }

    /// Why a request is not answered.
    fn refusal(&self, request: &Request) -> Option<(StatusCode, &'static str)> {
        let headers = request.headers();
        let text =
            |name| headers.get(name).map(|value: &HeaderValue| value.to_str().unwrap_or("?"));
        if !text(header::HOST).is_some_and(|host| self.is_host(host)) {
            return Some((StatusCode::MISDIRECTED_REQUEST, "the lab does not serve this host"));
        }
        let own = |origin: &str| origin.strip_prefix("http://").is_some_and(|of| self.is_host(of));
        // A page in a sandbox has the origin "null", and nothing to ask for.
        if text(header::ORIGIN).is_some_and(|origin| !own(origin)) {
            return Some((StatusCode::FORBIDDEN, ELSEWHERE));
        }
        let site = headers.get("sec-fetch-site").and_then(|site| site.to_str().ok());
        if matches!(site, Some("cross-site" | "same-site")) && request.method() != Method::GET {
            return Some((StatusCode::FORBIDDEN, ELSEWHERE));
        }
        None
    }
}

/// Passes only permitted requests, and sets the headers that limit what a page of the lab may do.
pub(crate) async fn guard(
    State(guard): State<Arc<Guard>>,
    request: Request,
    next: Next,
) -> Response {
    let mut response = match guard.refusal(&request) {
        Some((status, why)) => (status, format!("{why}\n")).into_response(),
        None if guard.is_known(request.headers()) => {
            let place = request.extensions().get::<Arc<Place>>().cloned();
            place.iter().for_each(Place::is_quiet);
            let paced = request.map(|body| Paced::of(body, place.clone()));
            let response = next.run(paced).await;
            place.iter().for_each(Place::is_quiet);
            response
        }
        None if is_open(&request) => next.run(request).await,
        None => {
            let words = "The lab serves only requests with the token of the address that `stiction lab` has printed.\n";
            (StatusCode::UNAUTHORIZED, words).into_response()
        }
    };
    let headers = response.headers_mut();
    for (name, value) in [
        (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
        (header::REFERRER_POLICY, "no-referrer"),
        (header::CACHE_CONTROL, "no-store"),
    ] {
        headers.insert(name, HeaderValue::from_static(value));
    }
    headers.insert("cross-origin-resource-policy", HeaderValue::from_static("same-origin"));
    // Reports have their own.
    headers
        .entry("cross-origin-opener-policy")
        .or_insert_with(|| HeaderValue::from_static("same-origin"));
    headers
        .entry(header::CONTENT_SECURITY_POLICY)
        .or_insert_with(|| HeaderValue::from_static(POLICY));
    response
}
