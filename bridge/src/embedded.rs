//! The page inside the program.
//!
//! In: the path of a request, and what the browser can take. Out: the file, its type and its mark.
//!
//! 1. `/` is `index.html`. Files that were compressed when the page was built stand beside the
//!    others, as `NAME.br` and `NAME.gz`; a browser that takes one of them gets the smallest.
//!    Browsers take brotli over TLS and on this machine only.
//! 2. The mark (`ETag`) is the content's hash: an unchanged file costs a 304, whatever the
//!    program's own age.
//! 3. Source maps stay out of the program (`build.rs`): they are as large as all the rest.

use axum::body::Body;
use axum::http::{HeaderMap, Method, StatusCode, header};
use axum::response::{IntoResponse, Response};
use rust_embed::EmbeddedFile;

/// How a file of the page is found by its name.
type Find = fn(&str) -> Option<EmbeddedFile>;

#[cfg(has_page)]
fn find(name: &str) -> Option<EmbeddedFile> {
    /// What `SLAMLAB_PAGE` named when the program was built, but for its source maps.
    #[derive(rust_embed::RustEmbed)]
    #[folder = "$SLAMLAB_PAGE_FOLDER"]
    struct Built;

    <Built as rust_embed::RustEmbed>::get(name)
}

#[cfg(not(has_page))]
fn find(_: &str) -> Option<EmbeddedFile> {
    None
}

/// Whether the program was built with the page in it.
#[must_use]
pub(crate) const fn is_there() -> bool {
    cfg!(has_page)
}

/// The answer of the page inside the program; 404 to everything where there is none.
pub(crate) fn answer(method: &Method, path: &str, headers: &HeaderMap) -> Response {
    answer_from(find, method, path, headers)
}

fn answer_from(find: Find, method: &Method, path: &str, headers: &HeaderMap) -> Response {
    if method != Method::GET && method != Method::HEAD {
        return (
            StatusCode::METHOD_NOT_ALLOWED,
            [(header::ALLOW, "GET, HEAD")],
        )
            .into_response();
    }
    let name = match path.strip_prefix('/').unwrap_or(path) {
        "" => "index.html",
        name => name,
    };
    let Some(plain) = find(name) else {
        return StatusCode::NOT_FOUND.into_response();
    };
    let kind = plain.metadata.mimetype().to_owned();
    let (file, encoding) = smallest(find, name, headers).unwrap_or((plain, "identity"));
    let mark = mark(&file);
    let common = [
        (header::CONTENT_TYPE, kind),
        (header::ETAG, mark.clone()),
        (header::VARY, "accept-encoding".to_owned()),
    ];
    if knows(headers, &mark) {
        return (StatusCode::NOT_MODIFIED, common).into_response();
    }
    // Without it, a HEAD would say that the file is empty.
    let length = [(header::CONTENT_LENGTH, file.data.len().to_string())];
    let body = match *method == Method::HEAD {
        true => Body::empty(),
        false => Body::from(file.data),
    };
    let mut response = (common, length, body).into_response();
    if encoding != "identity" {
        let value = header::HeaderValue::from_static(encoding);
        response
            .headers_mut()
            .insert(header::CONTENT_ENCODING, value);
    }
    response
}

/// The compressed form that the browser takes, and its name.
fn smallest(find: Find, name: &str, headers: &HeaderMap) -> Option<(EmbeddedFile, &'static str)> {
    let offered = headers.get(header::ACCEPT_ENCODING)?.to_str().ok()?;
    [("br", "br"), ("gz", "gzip")]
        .into_iter()
        .filter(|(_, encoding)| takes(offered, encoding))
        .find_map(|(ending, encoding)| Some((find(&format!("{name}.{ending}"))?, encoding)))
}

/// Whether `Accept-Encoding` names this encoding, and not with a weight of 0 (RFC 9110 §12.5.3).
fn takes(offered: &str, encoding: &str) -> bool {
    offered.split(',').any(|offer| {
        let (name, weight) = offer.split_once(';').unwrap_or((offer, ""));
        let weight = weight.trim().strip_prefix("q=").map(str::parse::<f32>);
        name.trim().eq_ignore_ascii_case(encoding) && weight != Some(Ok(0.0))
    })
}

fn mark(file: &EmbeddedFile) -> String {
    let hash = file.metadata.sha256_hash();
    let half: String = hash[..16]
        .iter()
        .map(|byte| format!("{byte:02x}"))
        .collect();
    format!("\"{half}\"")
}

/// Whether the browser has this very content (RFC 9110 §13.1.2).
fn knows(headers: &HeaderMap, mark: &str) -> bool {
    let known = headers.get(header::IF_NONE_MATCH);
    known
        .and_then(|known| known.to_str().ok())
        .is_some_and(|known| {
            known.split(',').any(|known| {
                let known = known.trim();
                known == "*" || known.strip_prefix("W/").unwrap_or(known) == mark
            })
        })
}

#[cfg(test)]
mod tests;
