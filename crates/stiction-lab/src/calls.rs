//! What the page can ask for: the calls, each a function from a question to an answer.
//!
//! A call is `POST /api/NAME` with JSON; one function lists them once, and routes, schema and so the page's types follow from it.

use crate::lab::Lab;
use crate::{exercise, guess, live, loops, paper, plant, recordings};
use axum::Router;
use axum::body::{Body, Bytes, HttpBody};
use axum::extract::State;
use axum::http::{StatusCode, header};
use axum::response::{IntoResponse, Response};
use axum::routing::post;
use http_body_util::{BodyExt, LengthLimitError, Limited};
use schemars::{JsonSchema, SchemaGenerator};
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::{Map, Value, json};
use std::sync::Arc;
use std::time::Duration;
use tokio::sync::Semaphore;

/// Why a call has no answer: a sentence that says what to do.
#[derive(Debug, Serialize, JsonSchema)]
pub struct Wrong {
    #[serde(skip)]
    status: StatusCode,
    /// What is wrong.
    pub error: String,
}

impl Wrong {
    /// What was asked for cannot be.
    pub fn asked(error: impl ToString) -> Self {
        Self { status: StatusCode::BAD_REQUEST, error: error.to_string() }
    }

    /// There is no such thing, or no more.
    pub fn gone(error: impl ToString) -> Self {
        Self { status: StatusCode::NOT_FOUND, error: error.to_string() }
    }

    /// The same status in other words.
    pub(crate) fn with(self, error: String) -> Self {
        Self { error, ..self }
    }

    /// The lab is at fault, or busy.
    pub fn own(error: impl ToString) -> Self {
        Self { status: StatusCode::SERVICE_UNAVAILABLE, error: error.to_string() }
    }
}

impl<E: std::error::Error> From<E> for Wrong {
    fn from(error: E) -> Self {
        Self::asked(error)
    }
}

impl IntoResponse for Wrong {
    fn into_response(self) -> Response {
        let json = serde_json::to_string(&self).unwrap_or_default();
        (self.status, [(header::CONTENT_TYPE, "application/json")], json).into_response()
    }
}

/// What a call gives.
pub type Answer<R> = Result<R, Wrong>;

/// Takes the calls, one by one.
trait Visit {
    fn call<A, R>(&mut self, name: &'static str, f: fn(&Lab, A) -> Answer<R>)
    where
        A: DeserializeOwned + JsonSchema + Send + 'static,
        R: Serialize + JsonSchema + Send + 'static;
}

/// All calls.
fn all(to: &mut impl Visit) {
    to.call("scenarios", loops::scenarios);
    to.call("cycle", loops::cycle);
    to.call("map", loops::map);
    to.call("verdict", live::verdict);
    to.call("live/begin", live::begin);
    to.call("live/go", live::go);
    to.call("guess/trends", guess::trends);
    to.call("guess/reveal", guess::reveal);
    to.call("exercise/begin", exercise::begin);
    to.call("exercise/trend", exercise::trend);
    to.call("exercise/carry-out", exercise::carry_out);
    to.call("exercise/read", exercise::read);
    to.call("exercise/reveal", exercise::reveal);
    to.call("paper/figure", paper::figure);
    to.call("recordings", recordings::list);
    to.call("recordings/open", recordings::open);
    to.call("recordings/mapping", recordings::say);
    to.call("recordings/close", recordings::close);
    to.call("recordings/example", recordings::example);
    to.call("recordings/diagnose", recordings::verdict);
    to.call("recordings/details", recordings::details);
    to.call("recordings/override", recordings::conclude);
    to.call("plant/status", plant::status);
    to.call("plant/page", plant::page);
    to.call("plant/loop", plant::history);
    to.call("plant/trend", plant::trend);
    to.call("plant/diagnose", plant::diagnose_window);
    to.call("plant/note", plant::enter_note);
    to.call("plant/snooze", plant::enter_snooze);
    to.call("plant/override", plant::enter_override);
    to.call("plant/scan", plant::begin_scan);
    to.call("plant/stop", plant::stop_scan);
}

/// Bytes of a question.
const QUESTION: usize = 1 << 20;
/// How long a question may take to come.
const IN_TIME: Duration = Duration::from_secs(12);
/// At most so many calls are worked on at a time; others wait.
const AT_ONCE: usize = 8;

/// Lets through as many as are worked on at a time.
pub(crate) type Gate = Arc<Semaphore>;

/// A gate for all that is asked.
pub(crate) fn gate() -> Gate {
    Arc::new(Semaphore::new(AT_ONCE))
}

struct Routes {
    router: Router<Arc<Lab>>,
    gate: Gate,
}

impl Visit for Routes {
    fn call<A, R>(&mut self, name: &'static str, f: fn(&Lab, A) -> Answer<R>)
    where
        A: DeserializeOwned + JsonSchema + Send + 'static,
        R: Serialize + JsonSchema + Send + 'static,
    {
        let gate = Arc::clone(&self.gate);
        let answer = move |State(lab): State<Arc<Lab>>, body: Body| async move {
            let body = sent(body, QUESTION, IN_TIME).await?;
            let asked: A = serde_json::from_slice(&body).map_err(|e| {
                Wrong::asked(format!("{name}: the question is not understood: {e}"))
            })?;
            let json = blocking(gate, move || {
                f(&lab, asked).and_then(|answer| serde_json::to_vec(&answer).map_err(Wrong::own))
            })
            .await?;
            Ok::<_, Wrong>(([(header::CONTENT_TYPE, "application/json")], json))
        };
        let router = std::mem::take(&mut self.router);
        self.router = router.route(&format!("/api/{name}"), post(answer));
    }
}

/// Reads what is sent, which must neither be longer than `most` bytes nor take longer than `in_time`.
pub(crate) async fn sent(body: Body, most: usize, in_time: Duration) -> Answer<Bytes> {
    let long = || Wrong {
        status: StatusCode::PAYLOAD_TOO_LARGE,
        error: format!("at most {most} bytes can be sent here"),
    };
    // What says that it is longer is not read.
    if body.size_hint().lower() > most as u64 {
        return Err(long());
    }
    let slow = || Wrong {
        status: StatusCode::REQUEST_TIMEOUT,
        error: "what was sent did not come in time".to_owned(),
    };
    match tokio::time::timeout(in_time, Limited::new(body, most).collect()).await {
        Ok(Ok(whole)) => Ok(whole.to_bytes()),
        Ok(Err(e)) if e.is::<LengthLimitError>() => Err(long()),
        Ok(Err(_)) | Err(_) => Err(slow()),
    }
}

/// Works on something where it does not hold up other requests.
pub(crate) async fn blocking<R: Send + 'static>(
    gate: Gate,
    work: impl FnOnce() -> Answer<R> + Send + 'static,
) -> Answer<R> {
    let _turn = gate.acquire_owned().await.map_err(Wrong::own)?;
    match tokio::task::spawn_blocking(work).await {
        Ok(done) => done,
        Err(e) => Err(Wrong::own(format!("a fault of the lab's own: {e}"))),
    }
}

/// The routes of all calls.
pub(crate) fn routes(gate: &Gate) -> Router<Arc<Lab>> {
    let mut routes = Routes { router: Router::new(), gate: Arc::clone(gate) };
    all(&mut routes);
    routes.router
}

struct Described {
    generator: SchemaGenerator,
    calls: Map<String, Value>,
}

impl Visit for Described {
    fn call<A, R>(&mut self, name: &'static str, _: fn(&Lab, A) -> Answer<R>)
    where
        A: DeserializeOwned + JsonSchema + Send + 'static,
        R: Serialize + JsonSchema + Send + 'static,
    {
        let ask = self.generator.subschema_for::<A>();
        let answer = self.generator.subschema_for::<R>();
        let both = json!({
            "type": "object",
            "properties": { "ask": ask, "answer": answer },
            "required": ["ask", "answer"],
            "additionalProperties": false,
        });
        self.calls.insert(name.to_owned(), both);
    }
}

/// The JSON schema of all calls: of each by its name, `ask` and `answer`. The page's types are made of it.
pub fn schema() -> Value {
    let mut described = Described { generator: SchemaGenerator::default(), calls: Map::new() };
    all(&mut described);
    let names: Vec<Value> = described.calls.keys().map(|name| name.clone().into()).collect();
    let mut definitions = described.generator.take_definitions(true);
    // All that is declared is sent.
    definitions.values_mut().for_each(closed);
    let mut calls = Value::Object(described.calls);
    closed(&mut calls);
    json!({
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "Calls",
        "type": "object",
        "properties": calls,
        "required": names,
        "additionalProperties": false,
        "$defs": definitions,
    })
}

/// Says of each object in a schema that it has no other fields than those named.
fn closed(schema: &mut Value) {
    match schema {
        Value::Object(map) => {
            map.values_mut().for_each(closed);
            let named = map.get("properties").is_some_and(Value::is_object);
            if named && map.get("type").is_some_and(|kind| kind == "object") {
                map.entry("additionalProperties").or_insert(Value::Bool(false));
            }
        }
        Value::Array(list) => list.iter_mut().for_each(closed),
        _ => {}
    }
}
