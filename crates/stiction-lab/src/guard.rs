//! Who may ask: a page of this lab, opened by who knows its token.
//!
//! | attack | what stops it |
//! |---|---|
//! | a page of another site asks | the token is in a cookie that no other site's requests carry (`SameSite=Strict`); an `Origin` other than the lab's own is refused |
//! | a name that comes to mean this machine (DNS rebinding) | a `Host` other than the lab's own is refused |
//! | another user of the machine | the token, 128 random bits |
//! | as many connections as there can be | who has not shown the token has few places, for seconds, and gives way (`places`) |
//! | a script in a recording's name | a strict policy on what the page may load, no text is taken for markup |

use crate::places::{Paced, Place};
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
    /// The cookie that holds the token; one a port, as browsers keep them by name only.
    cookie: String,
}

/// What the page may load: its own script and style, its own answers, and nothing from anywhere else.
const POLICY: &str = "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data: blob:; \
     connect-src 'self'; frame-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

impl Guard {
    /// A guard with a new token.
    ///
    /// # Errors
    /// If the machine gives no random numbers.
    pub fn new(bound: SocketAddr) -> std::io::Result<Self> {
        let mut bytes = [0u8; 16];
        getrandom::fill(&mut bytes).map_err(std::io::Error::other)?;
        let token = bytes.iter().map(|byte| format!("{byte:02x}")).collect();
        let port = bound.port();
        let mut hosts = vec![format!("localhost:{port}"), bound.to_string()];
        for name in ["127.0.0.1", "[::1]"] {
            hosts.push(format!("{name}:{port}"));
        }
        Ok(Self { token, hosts, cookie: format!("stiction_lab_{port}") })
    }

    /// What the token is.
    pub fn token(&self) -> &str {
        &self.token
    }

    fn is_host(&self, host: &str) -> bool {
        self.hosts.iter().any(|own| own.eq_ignore_ascii_case(host))
    }

    /// Whether a text is the token; as long for all that are as long.
    fn is_token(&self, said: &str) -> bool {
        let different = said.bytes().zip(self.token.bytes()).fold(0, |sum, (a, b)| sum | (a ^ b));
        said.len() == self.token.len() && different == 0
    }

    /// Whether headers bear the token, as a cookie or as `Authorization: Bearer`.
    fn is_known(&self, headers: &HeaderMap) -> bool {
        let texts = |name| headers.get_all(name).iter().filter_map(|value| value.to_str().ok());
        let of_cookies = texts(header::COOKIE)
            .flat_map(|line| line.split(';'))
            .filter_map(|cookie| cookie.trim().split_once('='))
            .any(|(name, value)| name == self.cookie && self.is_token(value));
        let bearer = texts(header::AUTHORIZATION)
            .filter_map(|line| line.strip_prefix("Bearer "))
            .any(|token| self.is_token(token.trim()));
        of_cookies || bearer
    }

    /// Why a request is not answered.
    fn refusal(&self, request: &Request) -> Option<(StatusCode, &'static str)> {
        let headers = request.headers();
        let text =
            |name| headers.get(name).map(|value: &HeaderValue| value.to_str().unwrap_or("?"));
        if !text(header::HOST).is_some_and(|host| self.is_host(host)) {
            return Some((StatusCode::MISDIRECTED_REQUEST, "this lab is not known by that name"));
        }
        let own = |origin: &str| origin.strip_prefix("http://").is_some_and(|of| self.is_host(of));
        // A page in a sandbox has the origin "null", and nothing to ask for.
        if text(header::ORIGIN).is_some_and(|origin| !own(origin)) {
            return Some((
                StatusCode::FORBIDDEN,
                "a page from elsewhere has nothing to ask of this lab",
            ));
        }
        let site = headers.get("sec-fetch-site").and_then(|site| site.to_str().ok());
        if matches!(site, Some("cross-site" | "same-site")) && request.method() != Method::GET {
            return Some((
                StatusCode::FORBIDDEN,
                "a page from elsewhere has nothing to ask of this lab",
            ));
        }
        None
    }
}

/// Lets through what may be answered, and tells browsers what a page of the lab may do.
pub(crate) async fn guard(
    State(guard): State<Arc<Guard>>,
    request: Request,
    next: Next,
) -> Response {
    let mut response = match guard.refusal(&request) {
        Some((status, why)) => (status, format!("{why}\n")).into_response(),
        None if guard.is_known(request.headers()) => {
            known(&request);
            next.run(request.map(Paced::of)).await
        }
        None => welcome(&guard, &request),
    };
    let headers = response.headers_mut();
    for (name, value) in [
        (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
        (header::REFERRER_POLICY, "no-referrer"),
        (header::CACHE_CONTROL, "no-store"),
    ] {
        headers.insert(name, HeaderValue::from_static(value));
    }
    for name in ["cross-origin-opener-policy", "cross-origin-resource-policy"] {
        headers.insert(name, HeaderValue::from_static("same-origin"));
    }
    // A page of its own kind, such as a report, has said what it may do.
    headers
        .entry(header::CONTENT_SECURITY_POLICY)
        .or_insert_with(|| HeaderValue::from_static(POLICY));
    response
}

/// Keeps the place of a connection on which the token was shown.
fn known(request: &Request) {
    request.extensions().get::<Arc<Place>>().inspect(|place| place.is_known_now());
}

/// Who comes with the token in the address gets it as a cookie; others are told where to look.
fn welcome(guard: &Guard, request: &Request) -> Response {
    let said =
        request.uri().query().unwrap_or("").split('&').find_map(|of| of.strip_prefix("token="));
    let at_door = request.uri().path() == "/" && request.method() == Method::GET;
    if at_door && said.is_some_and(|token| guard.is_token(token)) {
        known(request);
        let cookie = format!("{}={}; HttpOnly; SameSite=Strict; Path=/", guard.cookie, guard.token);
        // The address that stays, in the history too, is one without the token.
        return (StatusCode::SEE_OTHER, [(header::LOCATION, "/"), (header::SET_COOKIE, &*cookie)])
            .into_response();
    }
    let words = "This lab opens by the address that `stiction lab` has printed, with its token.\n";
    (StatusCode::UNAUTHORIZED, words).into_response()
}
