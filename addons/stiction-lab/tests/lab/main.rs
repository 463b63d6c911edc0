//! The lab as its page, and others, ask it: over HTTP.

mod attacks;
mod course;
mod exercise;
mod http;
mod plant;
mod recordings;
mod schema;

use serde_json::Value;
use std::net::SocketAddr;
use std::sync::Arc;
use stiction_lab::turns::Turns;
use stiction_lab::{Options, bind};

/// A lab that runs, and what its page knows.
struct Open {
    at: SocketAddr,
    token: String,
    turns: Arc<Turns>,
}

/// Opens a lab that is there until the tests end.
fn open(options: &Options) -> Open {
    let server = bind(options).unwrap();
    assert_eq!(server.address(), format!("http://{}/#token={}", server.listens(), server.token()));
    let (at, token, turns) = (server.listens(), server.token().to_owned(), server.turns());
    std::thread::spawn(|| server.serve(std::future::pending()).unwrap());
    Open { at, token, turns }
}

/// Who asks without a name of its own.
fn agent() -> ureq::Agent {
    ureq::Agent::config_builder().http_status_as_error(false).max_redirects(0).build().into()
}

impl Open {
    /// Sends bytes as the page does; the status, and what was answered.
    fn post(&self, path: &str, body: &[u8]) -> (u16, Value) {
        let mut answer = agent()
            .post(format!("http://{}/api/{path}", self.at))
            .header("authorization", format!("Bearer {}", self.token))
            .send(body)
            .unwrap();
        let text = answer.body_mut().with_config().limit(1 << 28).read_to_string().unwrap();
        (answer.status().as_u16(), serde_json::from_str(&text).unwrap_or(Value::String(text)))
    }

    /// Asks, and gives the status and the answer.
    fn call(&self, name: &str, ask: &Value) -> (u16, Value) {
        self.post(name, ask.to_string().as_bytes())
    }

    /// Asks what must be answered.
    fn good(&self, name: &str, ask: &Value) -> Value {
        let (status, answer) = self.call(name, ask);
        assert_eq!(status, 200, "{name} {ask}: {answer}");
        answer
    }
}
