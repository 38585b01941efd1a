//! Answers requests: refuses foreign hosts, finds files, adds headers, and starts WebSockets.

use std::sync::Arc;

use axum::extract::{Extension, Query, Request, State, WebSocketUpgrade};
use axum::http::{StatusCode, Uri, header};
use axum::middleware::{self, Next};
use axum::response::{IntoResponse, Redirect, Response};
use axum::routing::get;
use axum::{Json, Router};
use slamlab_core::wire::message::{Format, Watching};
use tower_http::services::ServeDir;

use crate::access_log::Kind;
use crate::embedded::EmbeddedPage;
use crate::page::Page;
use crate::shared::{Limits, Shared, Visitor};
use crate::{connection, foxglove, headers, host, mapping, rosbridge};

/// Path of the WebSocket.
pub(crate) const SOCKET_PATH: &str = "/ws";

/// Longest map as JSON, bytes, with room for the rest of its message; see
/// [`crate::record::ros::MOST_CELLS`].
const LONGEST_MAP: usize = 4 * crate::record::ros::MOST_CELLS;

/// All routes. `trust` serves what a device needs to trust the bridge.
pub(crate) fn router(shared: &Arc<Shared>, trust: Router) -> Router {
    let mut sockets = Router::new().route(SOCKET_PATH, get(socket));
    if shared.foxglove {
        sockets = sockets.route(foxglove::PATH, get(foxglove_socket));
    }
    if shared.rosbridge {
        sockets = sockets.route(rosbridge::PATH, get(rosbridge_socket));
    }
    let own_pages = middleware::from_fn_with_state(Arc::clone(shared), own_pages_only);
    let router = Router::new()
        .route("/healthz", get(async || "ok\n"))
        .route("/metrics", get(metrics))
        .route("/bridge.json", get(about))
        .merge(sockets.route_layer(own_pages.clone()));
    let router = match shared.mapping.is_some() {
        true => router.merge(mapping::routes()),
        false => router,
    };
    #[cfg(feature = "storage")]
    let router = match shared.uploads.is_some() {
        true => router.merge(crate::storage::routes()),
        false => router,
    };
    #[cfg(feature = "zenoh")]
    let router = match shared.fleet.is_some() {
        true => router.merge(crate::zenoh::routes().route_layer(own_pages)),
        false => router,
    };
    let router = match &shared.page {
        Some(Page::Folder(folder)) => {
            let files = ServeDir::new(folder)
                .precompressed_br()
                .precompressed_gzip();
            router.fallback_service(files)
        }
        Some(Page::Embedded) => {
            let page = EmbeddedPage::new();
            router.fallback(move |request: Request| async move {
                let (method, path) = (request.method(), request.uri().path());
                page.answer(method, path, request.headers()).await
            })
        }
        None => router,
    };
    router
        .with_state(Arc::clone(shared))
        .merge(trust)
        .layer(middleware::from_fn_with_state(
            Arc::clone(&shared.hosts),
            fence,
        ))
}

/// Redirects `http` to `https` on a bridge that speaks TLS. The only other thing served unencrypted
/// is how to trust the bridge.
pub(crate) fn redirector(shared: &Shared, trust: Router) -> Router {
    let redirect = async |request: Request| {
        let host = request.headers().get(header::HOST);
        let host = host.and_then(|host| host.to_str().ok()).unwrap_or("");
        let path = request
            .uri()
            .path_and_query()
            .map_or("/", |path| path.as_str());
        Redirect::permanent(&format!("https://{host}{path}"))
    };
    let fence = middleware::from_fn_with_state(Arc::clone(&shared.hosts), fence);
    trust.fallback(redirect).layer(fence)
}

/// What is behind the bridge. If watching needs the token, it says only that there is a bridge and
/// where to show the token, which the page must know.
async fn about(State(shared): State<Arc<Shared>>) -> Response {
    let about = &shared.about;
    if about.watching == Watching::Anyone || about.sources.is_empty() {
        return Json(about.clone()).into_response();
    }
    let only = serde_json::json!({ "websocket": about.websocket, "watching": about.watching });
    (StatusCode::FORBIDDEN, Json(only)).into_response()
}

async fn metrics(State(shared): State<Arc<Shared>>) -> Response {
    if shared.about.watching == Watching::Token {
        const WHY: &str = "Watching needs the token here, and so do figures, which have none.\n";
        return (StatusCode::FORBIDDEN, WHY).into_response();
    }
    const KIND: &str = "text/plain; version=0.0.4";
    ([(header::CONTENT_TYPE, KIND)], shared.metrics.text()).into_response()
}

/// The query of the WebSocket's address.
#[derive(serde::Deserialize)]
struct Wishes {
    fmt: Option<String>,
}

/// A page of another origin must not use the robot through the browser of somebody who has access
/// (cross-site WebSocket hijacking).
async fn own_pages_only(
    State(shared): State<Arc<Shared>>,
    Extension(visitor): Extension<Visitor>,
    request: Request,
    next: Next,
) -> Response {
    let headers = request.headers();
    let mut origins = headers.get_all(header::ORIGIN).iter();
    let origin = origins.next().map(|origin| origin.to_str().unwrap_or(""));
    let host = headers.get(header::HOST);
    let host = host.and_then(|host| host.to_str().ok());
    if origins.next().is_some()
        || !host::is_allowed_origin(origin, host, shared.is_tls, &shared.origins)
    {
        let peer = visitor.peer;
        let of = origin.unwrap_or("more than one origin");
        let what = format_args!("a page of {of:?} in a browser at {peer} was refused");
        shared.log.note(shared.clock.now(), Kind::Origin, what);
        const WHY: &str = "This page may not use the bridge; see --allow-origin.\n";
        return (StatusCode::FORBIDDEN, WHY).into_response();
    }
    next.run(request).await
}

/// Limits the message size and buffers of one socket.
fn limited(upgrade: WebSocketUpgrade, limits: &Limits) -> WebSocketUpgrade {
    upgrade
        .max_message_size(limits.message)
        .max_frame_size(limits.message)
        .read_buffer_size(8 * 1024)
        .write_buffer_size(0)
        .max_write_buffer_size(1024 * 1024)
}

/// The same for other tools, with room for the maps that a mapping bridge sends them cell by cell.
fn with_maps(upgrade: WebSocketUpgrade, shared: &Shared) -> WebSocketUpgrade {
    let upgrade = limited(upgrade, &shared.limits);
    match shared.mapping {
        Some(_) => upgrade.max_write_buffer_size(LONGEST_MAP),
        None => upgrade,
    }
}

/// Serves a WebSocket until it ends, or until it must make room before it was let in.
async fn while_in_place(visitor: &Visitor, session: impl Future<Output = ()>) {
    tokio::select! {
        () = session => (),
        () = visitor.place.pushed_out() => (),
    }
}

/// For Foxglove and similar tools, which can only watch.
async fn foxglove_socket(
    State(shared): State<Arc<Shared>>,
    Extension(visitor): Extension<Visitor>,
    upgrade: WebSocketUpgrade,
) -> Response {
    if shared.about.watching != Watching::Anyone {
        shared.metrics.intruders.add(1);
        const WHY: &str = "Watching needs the token here, and Foxglove cannot show one.\n";
        return (StatusCode::FORBIDDEN, WHY).into_response();
    }
    let upgrade = with_maps(upgrade, &shared).protocols(foxglove::PROTOCOLS);
    if upgrade.selected_protocol().is_none() {
        let why = format!(
            "Ask for one of the sub-protocols {}.\n",
            foxglove::PROTOCOLS.join(", ")
        );
        return (StatusCode::BAD_REQUEST, why).into_response();
    }
    upgrade.on_upgrade(async move |socket| {
        while_in_place(&visitor, foxglove::run(socket, &shared, &visitor)).await;
    })
}

/// For scripts that use roslib.
async fn rosbridge_socket(
    State(shared): State<Arc<Shared>>,
    Extension(visitor): Extension<Visitor>,
    upgrade: WebSocketUpgrade,
) -> Response {
    with_maps(upgrade, &shared).on_upgrade(async move |socket| {
        while_in_place(&visitor, rosbridge::run(socket, &shared, &visitor)).await;
    })
}

async fn socket(
    State(shared): State<Arc<Shared>>,
    Extension(visitor): Extension<Visitor>,
    Query(wishes): Query<Wishes>,
    upgrade: WebSocketUpgrade,
) -> Response {
    let format = match wishes.fmt.as_deref() {
        None | Some("binary") => Format::Binary,
        Some("json") => Format::Json,
        Some(_) => {
            return (StatusCode::BAD_REQUEST, "fmt is `binary` or `json`.\n").into_response();
        }
    };
    limited(upgrade, &shared.limits).on_upgrade(async move |socket| {
        let session = connection::run(socket, &shared, &visitor, format);
        while_in_place(&visitor, session).await;
    })
}

/// Refuses foreign hosts, explains missing paths, and adds the headers.
async fn fence(State(hosts): State<Arc<[String]>>, request: Request, next: Next) -> Response {
    let path = request.uri().path().to_owned();
    let mut response = if is_for_us(&request, &hosts) {
        explain(next.run(request).await, &path)
    } else {
        const WHY: &str = "slamlab answers only to an IP address, localhost, a .local name, and the names of --allow-host.\n";
        (StatusCode::MISDIRECTED_REQUEST, WHY).into_response()
    };
    let success = response.status().is_success() || response.status() == StatusCode::NOT_MODIFIED;
    headers::add(response.headers_mut(), &path, success);
    response
}

/// Both places that can name a host must name one of ours: the `Host` header, and the target if it
/// is absolute.
fn is_for_us(request: &Request, hosts: &[String]) -> bool {
    let mut named = request.headers().get_all(header::HOST).iter();
    let header = named.next().and_then(|host| host.to_str().ok());
    let target = Uri::authority(request.uri()).map(axum::http::uri::Authority::as_str);
    let is_ours = |authority| host::is_ours(authority, hosts);
    named.next().is_none() && header.is_some_and(is_ours) && target.is_none_or(is_ours)
}

/// Answers 404 with a sentence, unless the response already has one, which knows better what is
/// missing.
fn explain(response: Response, path: &str) -> Response {
    let has_sentence = response.headers().contains_key(header::CONTENT_TYPE);
    if response.status() != StatusCode::NOT_FOUND || has_sentence {
        return response;
    }
    let why = format!("There is no {path} in this page.\n");
    (StatusCode::NOT_FOUND, why).into_response()
}

#[cfg(test)]
mod tests {
    use super::*;

    async fn said(response: Response) -> String {
        let explained = explain(response, "/fleet/stop/none");
        assert_eq!(explained.status(), StatusCode::NOT_FOUND);
        let body = axum::body::to_bytes(explained.into_body(), 1000).await;
        String::from_utf8(body.unwrap().to_vec()).unwrap()
    }

    /// Regression: the sentence about the page replaced the answer to a stop for a robot that is
    /// not there.
    #[tokio::test]
    async fn an_own_sentence_of_what_is_missing_is_not_replaced() {
        const OWN: &str = "No robot at the router is called none.\n";
        assert_eq!(
            said((StatusCode::NOT_FOUND, OWN).into_response()).await,
            OWN
        );
        assert_eq!(
            said(StatusCode::NOT_FOUND.into_response()).await,
            "There is no /fleet/stop/none in this page.\n"
        );
    }
}
