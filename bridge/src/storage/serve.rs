//! Recordings over HTTP: a list of those in the folder and in the store (`/recordings.json`), and
//! each of them (`/recordings/NAME`), from the folder if it is still there.
//!
//! Anyone who may watch the robot may see its recordings. If watching needs a token, nobody gets
//! them this way, because a plain request has no place for a proof. The store is rarely asked for
//! its list (`listing`), and for recordings only within limits (`fetches`).

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use axum::body::Body;
use axum::extract::{Extension, Path, State};
use axum::http::{HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};
use axum::routing::get;
use axum::{Json, Router};
use futures_util::TryStreamExt;
use object_store::{ObjectMeta, ObjectStore, ObjectStoreExt};
use serde::Serialize;
use slamlab_core::wire::message::Watching;
use tokio::fs::File;
use tokio::io::AsyncReadExt;

use super::bucket::{Bucket, words};
use super::fetches::TooMany;
use super::ledger::Ledger;
use super::listing::{self, Stored};
use super::uploader::Uploads;
use crate::record::is_piece_in_store;
use crate::shared::{Shared, Visitor};

/// A recording.
#[derive(Debug, Default, Serialize)]
struct Listed {
    name: String,
    bytes: u64,
    /// Whether it is in the bridge's folder.
    here: bool,
    /// Whether it is in the store, complete and compared.
    stored: bool,
    /// Whether it is being written.
    current: bool,
    /// Stored fraction of a recording that is being uploaded, 0 to 1.
    part: f64,
}

/// All of them.
#[derive(Debug, Serialize)]
struct List {
    store: String,
    /// Why nothing can be stored at present, or the store cannot be listed.
    fault: Option<String>,
    recordings: Vec<Listed>,
}

/// `/recordings.json`, `/recordings/NAME`.
pub(crate) fn routes() -> Router<Arc<Shared>> {
    Router::new()
        .route("/recordings.json", get(list))
        .route("/recordings/{name}", get(one))
}

fn uploads(shared: &Shared) -> Result<&Uploads, StatusCode> {
    match shared.about.watching {
        Watching::Token => Err(StatusCode::FORBIDDEN),
        Watching::Anyone => shared.uploads.as_deref().ok_or(StatusCode::NOT_FOUND),
    }
}

fn refusal(status: StatusCode) -> Response {
    if status != StatusCode::FORBIDDEN {
        return nothing();
    }
    let why = "Watching needs the token here, and so do recordings, whose address has no place for one.\n";
    (status, why).into_response()
}

fn nothing() -> Response {
    (StatusCode::NOT_FOUND, "There is no such recording.\n").into_response()
}

fn later(why: TooMany) -> Response {
    let status = match why {
        TooMany::AtOnce => StatusCode::SERVICE_UNAVAILABLE,
        TooMany::AMinute => StatusCode::TOO_MANY_REQUESTS,
    };
    (status, [(header::RETRY_AFTER, "10")], format!("{why}\n")).into_response()
}

async fn list(State(shared): State<Arc<Shared>>) -> Result<Response, Response> {
    let uploads = uploads(&shared).map_err(refusal)?;
    let mut all: BTreeMap<String, Listed> = BTreeMap::new();
    // Store names of the pieces in the folder, which must not be listed twice.
    let mut names_in_store = BTreeSet::new();
    let mut fault = uploads.fault();
    match uploads.pieces() {
        Err(error) => fault = fault.or(Some(error.to_string())),
        Ok(pieces) => {
            for (name, bytes) in pieces {
                let ledger = Ledger::read(&uploads.folder.join(&name)).unwrap_or_default();
                let sent = (ledger.parts.len() as u64 * ledger.part_bytes).min(bytes);
                let is_of_store = ledger.to == uploads.bucket.url;
                if is_of_store {
                    names_in_store.insert(ledger.name_in_store(&name));
                }
                let stored = ledger.stored.is_some() && is_of_store;
                let listed = Listed {
                    bytes,
                    here: true,
                    stored,
                    current: uploads.is_current(&name),
                    part: match stored {
                        true => 1.0,
                        false => sent as f64 / bytes.max(1) as f64,
                    },
                    name: name.clone(),
                };
                all.insert(name, listed);
            }
        }
    }
    match &*uploads.listing.get(ask(uploads.bucket.clone())).await {
        Err(why) => fault = fault.or_else(|| Some(why.clone())),
        Ok(stored) => {
            let elsewhere = |one: &&Stored| !names_in_store.contains(&one.name);
            for Stored { name, bytes } in stored.iter().filter(elsewhere) {
                all.entry(name.clone()).or_insert_with(|| Listed {
                    name: name.clone(),
                    bytes: *bytes,
                    stored: true,
                    part: 1.0,
                    ..Listed::default()
                });
            }
        }
    }
    let list = List {
        store: uploads.bucket.url.clone(),
        fault,
        // The newest first.
        recordings: all.into_values().rev().collect(),
    };
    let never = HeaderValue::from_static("no-store");
    Ok(([(header::CACHE_CONTROL, never)], Json(list)).into_response())
}

/// Asks the store which pieces it has.
async fn ask(bucket: Bucket) -> listing::Answer {
    if let Some(folder) = bucket.missing() {
        let folder = folder.display();
        return Err(format!(
            "{bucket} cannot be listed: the folder {folder} is not there"
        ));
    }
    let folder = Some(bucket.folder()).filter(|folder| !folder.as_ref().is_empty());
    let listed: Result<Vec<_>, _> = bucket.store.list(folder).try_collect().await;
    let objects =
        listed.map_err(|error| format!("{bucket} cannot be listed: {}", words(&error)))?;
    let piece = |object: ObjectMeta| {
        let name = object
            .location
            .filename()
            .filter(|name| is_piece_in_store(name))?;
        Some(Stored {
            name: name.to_owned(),
            bytes: object.size,
        })
    };
    Ok(objects.into_iter().filter_map(piece).collect())
}

/// Bytes of a recording per request to the store.
const FETCHED_AT_ONCE: u64 = 2 << 20;

async fn one(
    State(shared): State<Arc<Shared>>,
    Extension(visitor): Extension<Visitor>,
    Path(name): Path<String>,
) -> Result<Response, Response> {
    let uploads = uploads(&shared).map_err(refusal)?;
    // This also rejects paths that lead elsewhere.
    if !is_piece_in_store(&name) {
        return Err(nothing());
    }
    // Send the length, so that a client that receives less, because the link to the store broke,
    // notices.
    let headers = |bytes: u64| {
        let kind = HeaderValue::from_static("application/octet-stream");
        [
            (header::CONTENT_TYPE, kind),
            (header::CONTENT_LENGTH, HeaderValue::from(bytes)),
        ]
    };
    if let Ok(file) = File::open(uploads.folder.join(&name)).await {
        let length = file.metadata().await.map_or(0, |known| known.len());
        let body = futures_util::stream::try_unfold(file.take(length), async |mut file| {
            let mut read = Vec::with_capacity(1 << 16);
            let count = (&mut file).take(1 << 16).read_to_end(&mut read).await?;
            Ok::<_, std::io::Error>((count > 0).then_some((read, file)))
        });
        return Ok((headers(length), Body::from_stream(body)).into_response());
    }
    let leave = uploads.fetches.begin(visitor.peer, shared.clock.now());
    let leave = leave.map_err(later)?;
    let path = uploads.bucket.path(&name);
    match uploads.bucket.store.head(&path).await {
        Ok(found) => {
            let length = found.size;
            // Fetched in chunks, because each request to the store has a timeout, and a whole
            // recording takes longer over a slow link. All of it counts as one fetch, until it is
            // sent or the client is gone.
            let begin = (uploads.bucket.clone(), path, 0, leave);
            let pieces = move |(bucket, path, from, leave): (Bucket, _, u64, _)| async move {
                if from >= length {
                    return Ok::<_, object_store::Error>(None);
                }
                let to = length.min(from + FETCHED_AT_ONCE);
                let piece = bucket.store.get_range(&path, from..to).await?;
                Ok(Some((piece, (bucket, path, to, leave))))
            };
            let bytes = futures_util::stream::try_unfold(begin, pieces);
            let bucket = uploads.bucket.clone();
            let bytes = bytes.inspect_err(move |error| {
                tracing::warn!(
                    "{name} broke off on its way from {bucket}: {}",
                    words(error)
                );
            });
            Ok((headers(length), Body::from_stream(bytes)).into_response())
        }
        Err(object_store::Error::NotFound { .. }) => Err(nothing()),
        Err(error) => {
            let why = format!(
                "{name} cannot be read from {}: {}\n",
                uploads.bucket,
                words(&error)
            );
            Err((StatusCode::BAD_GATEWAY, why).into_response())
        }
    }
}
