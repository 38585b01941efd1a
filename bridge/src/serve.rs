//! Answers requests: foreign hosts are refused, files are found, headers are added.

use std::future::Future;
use std::io;
use std::path::{Path, PathBuf};
use std::time::Duration;

use axum::Router;
use axum::extract::Request;
use axum::http::{StatusCode, Uri, header};
use axum::middleware::{self, Next};
use axum::response::{IntoResponse, Response};
use tokio::net::TcpListener;
use tokio::sync::watch;
use tower_http::services::ServeDir;

use crate::{headers, host};

/// How long open requests may take to end after the shutdown began.
const GRACE: Duration = Duration::from_secs(2);

/// Why the bridge does not serve, or no longer.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RunError {
    /// The folder holds no page.
    #[error(
        "there is no page in {}: index.html is missing; build it with `cargo xtask build`, or name its folder with \
         --page DIR", dir.display()
    )]
    NoPage {
        /// The folder that was looked into.
        dir: PathBuf,
    },
    /// The socket failed.
    #[error("serving stopped: {0}")]
    Io(#[from] io::Error),
}

/// Serves the page in `page_dir` on `listener` until `shutdown` ends, then lets open requests end within two seconds.
///
/// # Errors
/// [`RunError::NoPage`] at once if the folder has no `index.html`; [`RunError::Io`] if the socket fails.
pub async fn run(
    listener: TcpListener,
    page_dir: PathBuf,
    shutdown: impl Future<Output = ()> + Send + 'static,
) -> Result<(), RunError> {
    check_page(&page_dir)?;
    let (stop, mut stopped) = watch::channel(false);
    let mut graceful = stopped.clone();
    let server = axum::serve(listener, router(&page_dir)).with_graceful_shutdown(async move {
        let _ = graceful.wait_for(|stop| *stop).await;
    });
    tokio::spawn(async move {
        shutdown.await;
        let _ = stop.send(true);
    });
    let too_late = async {
        let _ = stopped.wait_for(|stop| *stop).await;
        tokio::time::sleep(GRACE).await;
    };
    tokio::select! {
        result = server => result.map_err(RunError::Io),
        () = too_late => {
            tracing::warn!("some requests were still open after {} s and were cut off", GRACE.as_secs());
            Ok(())
        }
    }
}

/// Whether `page_dir` holds a page.
///
/// # Errors
/// [`RunError::NoPage`] if it has no `index.html`.
pub fn check_page(page_dir: &Path) -> Result<(), RunError> {
    if page_dir.join("index.html").is_file() {
        Ok(())
    } else {
        Err(RunError::NoPage {
            dir: page_dir.to_owned(),
        })
    }
}

fn router(page_dir: &Path) -> Router {
    let files = ServeDir::new(page_dir)
        .precompressed_br()
        .precompressed_gzip();
    Router::new()
        .fallback_service(files)
        .layer(middleware::from_fn(fence))
}

/// Refuses foreign hosts, gives errors a sentence, and adds the headers.
async fn fence(request: Request, next: Next) -> Response {
    let path = request.uri().path().to_owned();
    let mut response = if is_for_us(&request) {
        explain(next.run(request).await, &path)
    } else {
        (
            StatusCode::MISDIRECTED_REQUEST,
            "slamlab answers only to an IP address, localhost or a .local name.\n",
        )
            .into_response()
    };
    let success = response.status().is_success() || response.status() == StatusCode::NOT_MODIFIED;
    headers::add(response.headers_mut(), &path, success);
    response
}

/// Both places that can name a host must name one of ours: the `Host` header, and the target if it is absolute.
fn is_for_us(request: &Request) -> bool {
    let mut hosts = request.headers().get_all(header::HOST).iter();
    let header = hosts.next().and_then(|host| host.to_str().ok());
    let target = Uri::authority(request.uri()).map(axum::http::uri::Authority::as_str);
    hosts.next().is_none() && header.is_some_and(host::is_ours) && target.is_none_or(host::is_ours)
}

fn explain(response: Response, path: &str) -> Response {
    match response.status() {
        StatusCode::NOT_FOUND => (
            StatusCode::NOT_FOUND,
            format!("There is no {path} in this page.\n"),
        )
            .into_response(),
        _ => response,
    }
}
