//! The map as files, over HTTP: for ROS's map_server (`/map.yaml`, which names its image), and with
//! everything that a run needs to go on in it (`/map.slamlab`).
//!
//! Anyone who may watch the robot may see the map. If watching needs a token, nobody gets the map
//! this way, because a plain request has no place for a proof: it is sent over the sockets only.

use std::sync::{Arc, PoisonError};
use std::time::Duration;

use axum::Router;
use axum::extract::{Path, State};
use axum::http::{HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};
use axum::routing::get;
use slamlab_core::format::map_server::{self, MapFiles, MapImage, MapMode, OccupancyMap};
use slamlab_core::wire::message::Watching;
use tokio::sync::{Mutex, oneshot};
use tokio::time::Instant;

use super::{Asked, Mapping};
use crate::shared::Shared;

/// Number of descriptions whose images are kept.
const MOST_DESCRIBED: usize = 4;
/// How long a packed map is served again.
const PACKED_FOR: Duration = Duration::from_secs(5);
/// Longest wait for the mapper, which may be busy with a large loop closure.
const LONGEST: Duration = Duration::from_secs(30);

/// The last packed map. It is locked while a new one is packed, so other requests wait for that
/// one.
#[derive(Debug, Default)]
pub(super) struct Packed(Mutex<Option<(Instant, Arc<Vec<u8>>)>>);

/// `/map.yaml`, `/map.pgm`, `/map.slamlab`.
pub(crate) fn routes() -> Router<Arc<Shared>> {
    Router::new()
        .route("/map.yaml", get(yaml))
        .route("/map.pgm", get(newest_image))
        .route("/map/{image}", get(image))
        .route("/map.slamlab", get(saved))
}

/// Why a map is not served.
enum No {
    Private,
    Nothing,
    Gone,
    Failed(String),
}

impl IntoResponse for No {
    fn into_response(self) -> Response {
        let (status, why) = match self {
            Self::Private => (
                StatusCode::FORBIDDEN,
                "Watching needs the token here, and so does the map, whose address has no place for one.\n".to_owned(),
            ),
            Self::Nothing => (
                StatusCode::SERVICE_UNAVAILABLE,
                "Nothing is mapped yet.\n".to_owned(),
            ),
            Self::Gone => (
                StatusCode::GONE,
                "This image is too old, or never was: read /map.yaml again.\n".to_owned(),
            ),
            Self::Failed(why) => (
                StatusCode::SERVICE_UNAVAILABLE,
                format!("The map cannot be packed: {why}.\n"),
            ),
        };
        (status, why).into_response()
    }
}

fn mapping(shared: &Shared) -> Result<&Mapping, No> {
    if shared.about.watching == Watching::Token {
        return Err(No::Private);
    }
    shared.mapping.as_deref().ok_or(No::Nothing)
}

async fn yaml(State(shared): State<Arc<Shared>>) -> Result<Response, No> {
    let mapping = mapping(&shared)?;
    let (revision, cells) = mapping.newest()?;
    let name = format!("map/{revision}.pgm");
    let yaml = files(&cells, &name)?.yaml;
    mapping.describe(revision, cells);
    Ok(as_file("application/yaml", yaml.into_bytes()))
}

async fn newest_image(State(shared): State<Arc<Shared>>) -> Result<Response, No> {
    let (_, cells) = mapping(&shared)?.newest()?;
    Ok(as_file(PGM, files(&cells, "map.pgm")?.image))
}

async fn image(
    State(shared): State<Arc<Shared>>,
    Path(image): Path<String>,
) -> Result<Response, No> {
    let revision = image.strip_suffix(".pgm");
    let revision = revision.and_then(|number| number.parse().ok());
    let cells = mapping(&shared)?.described(revision.ok_or(No::Gone)?);
    let cells = cells.ok_or(No::Gone)?;
    Ok(as_file(PGM, files(&cells, &image)?.image))
}

async fn saved(State(shared): State<Arc<Shared>>) -> Result<Response, No> {
    let bytes = mapping(&shared)?.packed().await?;
    Ok(as_file("application/octet-stream", bytes.to_vec()))
}

/// Source: RFC 2045 §6.3, for unregistered types.
const PGM: &str = "image/x-portable-graymap";

fn files(cells: &OccupancyMap, name: &str) -> Result<MapFiles, No> {
    map_server::write(cells, MapMode::Trinary, MapImage::Pgm, name)
        .map_err(|error| No::Failed(error.to_string()))
}

/// Not cached, because the map changes.
fn as_file(kind: &'static str, bytes: Vec<u8>) -> Response {
    let kind = HeaderValue::from_static(kind);
    let never = HeaderValue::from_static("no-store");
    let headers = [(header::CONTENT_TYPE, kind), (header::CACHE_CONTROL, never)];
    (headers, bytes).into_response()
}

impl Mapping {
    fn newest(&self) -> Result<(u64, Arc<OccupancyMap>), No> {
        self.shown.borrow().cells.clone().ok_or(No::Nothing)
    }

    fn describe(&self, revision: u64, cells: Arc<OccupancyMap>) {
        let mut all = (self.described.lock()).unwrap_or_else(PoisonError::into_inner);
        if all.iter().all(|(known, _)| *known != revision) {
            all.push_back((revision, cells));
        }
        while all.len() > MOST_DESCRIBED {
            all.pop_front();
        }
    }

    fn described(&self, revision: u64) -> Option<Arc<OccupancyMap>> {
        let all = (self.described.lock()).unwrap_or_else(PoisonError::into_inner);
        let mut all = all.iter().filter(|(known, _)| *known == revision);
        all.next().map(|(_, cells)| Arc::clone(cells))
    }

    /// The map as the bytes of a `.slamlab` file, not older than [`PACKED_FOR`].
    async fn packed(&self) -> Result<Arc<Vec<u8>>, No> {
        let mut last = self.packed.0.lock().await;
        if let Some((at, bytes)) = &*last
            && at.elapsed() < PACKED_FOR
        {
            return Ok(Arc::clone(bytes));
        }
        let (answer, packed) = oneshot::channel();
        let busy = || No::Failed("the mapper is busy".to_owned());
        self.asked
            .try_send(Asked::Pack(answer))
            .map_err(|_| busy())?;
        let packed = tokio::time::timeout(LONGEST, packed).await;
        let packed = packed.map_err(|_| busy())?.map_err(|_| busy())?;
        let bytes = Arc::new(packed.map_err(No::Failed)?);
        *last = Some((Instant::now(), Arc::clone(&bytes)));
        Ok(bytes)
    }
}
