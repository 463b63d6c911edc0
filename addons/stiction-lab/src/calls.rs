//! The calls of the page: each is a function from a question to an answer.
//!
//! A call is `POST /api/NAME` with JSON. One function lists all calls; routes, schema and the page's types follow from it.

use crate::lab::Lab;
use crate::turns::{Cost, Turns, Wanted};
use crate::{course, exercise, guess, live, loops, paper, plant, recordings};
use axum::Router;
use axum::body::{Body, HttpBody};
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

/// Why a call has no answer: a sentence with the remedy.
#[derive(Debug, Serialize, JsonSchema)]
pub struct Wrong {
    #[serde(skip)]
    status: StatusCode,
    /// What is wrong.
    pub error: String,
}

impl Wrong {
    /// The question is wrong.
    pub fn request(error: impl ToString) -> Self {
        Self { status: StatusCode::BAD_REQUEST, error: error.to_string() }
    }

    /// The requested object does not exist, or no longer exists.
    pub fn gone(error: impl ToString) -> Self {
        Self { status: StatusCode::NOT_FOUND, error: error.to_string() }
    }

    /// What kind of failure it is.
    pub(crate) fn status(&self) -> StatusCode {
        self.status
    }

    /// The failure with a different text.
    pub(crate) fn with(self, error: String) -> Self {
        Self { error, ..self }
    }

    /// The lab has failed, or is busy.
    pub fn own(error: impl ToString) -> Self {
        Self { status: StatusCode::SERVICE_UNAVAILABLE, error: error.to_string() }
    }
}

impl<E: std::error::Error> From<E> for Wrong {
    fn from(error: E) -> Self {
        Self::request(error)
    }
}

impl IntoResponse for Wrong {
    fn into_response(self) -> Response {
        let json = serde_json::to_string(&self).unwrap_or_default();
        (self.status, [(header::CONTENT_TYPE, "application/json")], json).into_response()
    }
}

/// The result of a call.
pub type Answer<R> = Result<R, Wrong>;

/// A function that answers a call, and stops when no client waits for the answer.
trait Answers<A, R>: Fn(&Lab, A, &Wanted) -> Answer<R> + Clone + Send + Sync + 'static {}
impl<A, R, F: Fn(&Lab, A, &Wanted) -> Answer<R> + Clone + Send + Sync + 'static> Answers<A, R>
    for F
{
}

/// Receives the calls, one by one.
trait Visit {
    /// A call that can be stopped before its end.
    fn watched<A, R>(&mut self, name: &'static str, cost: Cost, f: impl Answers<A, R>)
    where
        A: DeserializeOwned + JsonSchema + Send + 'static,
        R: Serialize + JsonSchema + Send + 'static;

    /// A call that continues to its end.
    fn call<A, R>(&mut self, name: &'static str, cost: Cost, f: fn(&Lab, A) -> Answer<R>)
    where
        A: DeserializeOwned + JsonSchema + Send + 'static,
        R: Serialize + JsonSchema + Send + 'static,
    {
        self.watched(name, cost, move |lab: &Lab, asked: A, _: &Wanted| f(lab, asked));
    }
}

/// All calls.
fn all(to: &mut impl Visit) {
    use Cost::{High, Low, Medium};
    to.call("scenarios", Low, loops::scenarios);
    to.call("cycle", Low, loops::cycle);
    to.watched("map", High, loops::map);
    to.watched("verdict", Medium, live::verdict);
    to.call("live/begin", Low, live::begin);
    to.call("live/go", Low, live::go);
    to.call("guess/trends", Medium, guess::trends);
    to.call("guess/reveal", Medium, guess::reveal);
    to.call("exercise/begin", Medium, exercise::begin);
    to.call("exercise/trend", Medium, exercise::trend);
    to.call("exercise/carry-out", Medium, exercise::carry_out);
    to.call("exercise/read", Medium, exercise::read);
    to.call("exercise/reveal", Medium, exercise::reveal);
    to.call("course/lesson", Medium, course::lesson);
    to.call("course/check", Medium, course::check);
    to.call("course/answers", Medium, course::answers);
    to.call("course/read", Low, course::read);
    to.call("paper/figure", Medium, paper::figure);
    to.call("recordings", Low, recordings::list);
    to.call("recordings/open", Medium, recordings::open);
    to.call("recordings/mapping", Medium, recordings::say);
    to.call("recordings/close", Low, recordings::close);
    to.call("recordings/example", Medium, recordings::example);
    to.watched("recordings/diagnose", Medium, recordings::verdict);
    to.watched("recordings/details", Medium, recordings::details);
    to.watched("recordings/report", Medium, recordings::report);
    to.call("recordings/override", Low, recordings::conclude);
    to.call("plant/status", Low, plant::status);
    to.call("plant/page", Low, plant::page);
    to.call("plant/loop", Low, plant::history);
    to.call("plant/trend", Medium, plant::trend);
    to.watched("plant/diagnose", Medium, plant::diagnose_window);
    to.call("plant/note", Low, plant::enter_note);
    to.call("plant/snooze", Low, plant::enter_snooze);
    to.call("plant/override", Low, plant::enter_override);
    to.call("plant/scan", Low, plant::begin_scan);
    to.call("plant/stop", Low, plant::stop_scan);
}

/// Number of bytes of a question.
const QUESTION: usize = 1 << 20;
/// How long a question may take to come.
const IN_TIME: Duration = Duration::from_secs(12);

struct Routes {
    router: Router<Arc<Lab>>,
    turns: Arc<Turns>,
}

impl Visit for Routes {
    fn watched<A, R>(&mut self, name: &'static str, cost: Cost, f: impl Answers<A, R>)
    where
        A: DeserializeOwned + JsonSchema + Send + 'static,
        R: Serialize + JsonSchema + Send + 'static,
    {
        let turns = Arc::clone(&self.turns);
        let answer = move |State(lab): State<Arc<Lab>>, body: Body| async move {
            let body = sent(body, QUESTION, IN_TIME, |_| Ok(())).await?;
            let asked: A = serde_json::from_slice(&body).map_err(|e| {
                Wrong::request(format!("{name}: the request is not valid JSON for this call ({e})"))
            })?;
            let work = move |wanted: &Wanted| {
                let answer = f(&lab, asked, wanted)?;
                serde_json::to_vec(&answer).map_err(Wrong::own)
            };
            let json = turns.take(cost, work).await?;
            Ok::<_, Wrong>(([(header::CONTENT_TYPE, "application/json")], json))
        };
        let router = std::mem::take(&mut self.router);
        self.router = router.route(&format!("/api/{name}"), post(answer));
    }
}

/// Reads a body of at most `most` bytes, which must arrive within `in_time`. `take` is called with the size of each piece, and
/// may refuse it.
pub(crate) async fn sent(
    body: Body,
    most: usize,
    in_time: Duration,
    mut take: impl FnMut(usize) -> Answer<()>,
) -> Answer<Vec<u8>> {
    let long = || Wrong {
        status: StatusCode::PAYLOAD_TOO_LARGE,
        error: format!("at most {most} bytes can be sent here"),
    };
    // A body that is announced as longer is not read.
    if body.size_hint().lower() > most as u64 {
        return Err(long());
    }
    let slow = || Wrong {
        status: StatusCode::REQUEST_TIMEOUT,
        error: "the request did not arrive in time; send it again".to_owned(),
    };
    let mut body = Limited::new(body, most);
    let whole = async {
        let mut whole = vec![];
        while let Some(frame) = body.frame().await {
            let frame =
                frame.map_err(|e| if e.is::<LengthLimitError>() { long() } else { slow() })?;
            if let Ok(piece) = frame.into_data() {
                take(piece.len())?;
                whole.extend_from_slice(&piece);
            }
        }
        Ok(whole)
    };
    tokio::time::timeout(in_time, whole).await.unwrap_or_else(|_| Err(slow()))
}

/// The routes of all calls.
pub(crate) fn routes(turns: &Arc<Turns>) -> Router<Arc<Lab>> {
    let mut routes = Routes { router: Router::new(), turns: Arc::clone(turns) };
    all(&mut routes);
    routes.router
}

struct Described {
    generator: SchemaGenerator,
    calls: Map<String, Value>,
}

impl Visit for Described {
    fn watched<A, R>(&mut self, name: &'static str, _: Cost, _: impl Answers<A, R>)
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

/// The JSON schema of all calls, with `ask` and `answer` of each. The page's types are made of it.
pub fn schema() -> Value {
    let mut described = Described { generator: SchemaGenerator::default(), calls: Map::new() };
    all(&mut described);
    let names: Vec<Value> = described.calls.keys().map(|name| name.clone().into()).collect();
    let mut definitions = described.generator.take_definitions(true);
    // All declared fields are sent.
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

/// Forbids additional fields in all objects of a schema.
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
