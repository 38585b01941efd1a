//! The fleet over HTTP: changes, the map of a robot, and stopping.

use std::sync::Arc;
use std::time::Duration;

use ::zenoh::qos::{CongestionControl, Priority};
use axum::extract::{Path, Query, State};
use axum::http::{StatusCode, header};
use axum::response::{IntoResponse, Response};
use axum::routing::{get, post};
use axum::{Json, Router};
use slamlab_core::wire::message::Watching;

use super::Fleet;
use crate::rights::Name;
use crate::shared::Shared;

/// How long a robot may take to send its map.
const MAP: Duration = Duration::from_secs(5);

pub(crate) fn routes() -> Router<Arc<Shared>> {
    Router::new()
        .route("/fleet.json", get(changes))
        .route("/fleet/map/{name}", get(map))
        .route("/fleet/stop", post(stop_all))
        .route("/fleet/stop/{name}", post(stop))
}

/// Why a request is refused.
enum Refusal {
    Private,
    Router,
    Unknown(String),
    Map(String),
    Failed(::zenoh::Error),
}

impl IntoResponse for Refusal {
    fn into_response(self) -> Response {
        let (status, why) = match self {
            Self::Private => (
                StatusCode::FORBIDDEN,
                "Watching needs the token here, and so does the fleet, whose address has no place for one.\n".to_owned(),
            ),
            Self::Router => (
                StatusCode::SERVICE_UNAVAILABLE,
                "There is no way to the router at the moment.\n".to_owned(),
            ),
            Self::Unknown(name) => (
                StatusCode::NOT_FOUND,
                format!("No robot at the router is called {name}.\n"),
            ),
            Self::Map(name) => (StatusCode::NOT_FOUND, format!("{name} has no map.\n")),
            Self::Failed(error) => (StatusCode::BAD_GATEWAY, format!("Zenoh: {error}\n")),
        };
        (status, why).into_response()
    }
}

/// The query of the request.
#[derive(serde::Deserialize)]
struct Since {
    #[serde(default)]
    since: u64,
}

fn fleet(shared: &Shared) -> Result<&Fleet, Refusal> {
    match shared.about.watching {
        Watching::Token => Err(Refusal::Private),
        Watching::Anyone => shared.fleet.as_deref().ok_or(Refusal::Router),
    }
}

async fn changes(
    State(shared): State<Arc<Shared>>,
    Query(Since { since }): Query<Since>,
) -> Result<Response, Refusal> {
    let fleet = fleet(&shared)?;
    let changes = fleet.with_table(|table| table.since(since, shared.clock.now()));
    let is_connected = fleet.router().is_some();
    let mut told = serde_json::to_value(changes).unwrap_or_default();
    told["connected"] = is_connected.into();
    Ok(Json(told).into_response())
}

/// The robot's last map.
async fn map(
    State(shared): State<Arc<Shared>>,
    Path(name): Path<Name>,
) -> Result<Response, Refusal> {
    let fleet = fleet(&shared)?;
    let session = fleet.router().ok_or(Refusal::Router)?;
    let name = name.to_string();
    let answers = session.get(format!("slamlab/{name}/map")).timeout(MAP);
    let answers = answers.await.map_err(Refusal::Failed)?;
    while let Ok(answer) = answers.recv_async().await {
        if let Ok(sample) = answer.result() {
            let bytes = sample.payload().to_bytes().into_owned();
            return Ok(([(header::CONTENT_TYPE, "application/json")], bytes).into_response());
        }
    }
    Err(Refusal::Map(name))
}

async fn stop_all(State(shared): State<Arc<Shared>>) -> Result<Response, Refusal> {
    let count = fleet(&shared)?.with_table(|table| table.count());
    put_stop(&shared, "*").await?;
    Ok((StatusCode::ACCEPTED, Json(count)).into_response())
}

async fn stop(
    State(shared): State<Arc<Shared>>,
    Path(name): Path<Name>,
) -> Result<Response, Refusal> {
    let name = name.to_string();
    if !fleet(&shared)?.with_table(|table| table.has(&name)) {
        return Err(Refusal::Unknown(name));
    }
    put_stop(&shared, &name).await?;
    Ok((StatusCode::ACCEPTED, Json(1)).into_response())
}

/// Sends a stop, before all other messages, and never dropped when queues are full.
async fn put_stop(shared: &Shared, name: &str) -> Result<(), Refusal> {
    let session = fleet(shared)?.router().ok_or(Refusal::Router)?;
    let stop = session
        .put(format!("slamlab/{name}/stop"), "")
        .congestion_control(CongestionControl::Block)
        .priority(Priority::RealTime)
        .express(true);
    stop.await.map_err(Refusal::Failed)
}
