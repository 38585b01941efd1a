//! The page inside the program.
//!
//! In: the path of a request, and the encodings that the browser accepts. Out: the file, its type
//! and its `ETag`.
//!
//! 1. `/` is `index.html`. A file that brotli made smaller when the page was built is stored in
//!    that form only, as `NAME.br`: with the gzip and plain forms as well, a package was twice as
//!    large.
//! 2. Browsers accept brotli only over TLS or from this machine. For others the file is unpacked
//!    and compressed with gzip at its first request, off the threads that carry messages, and
//!    cached. A client that accepts neither gets it plain.
//! 3. The `ETag` is the content's hash and its form: an unchanged file costs a 304, even after an
//!    update of the program.
//! 4. Source maps are left out of the program (`build.rs`): they are as large as everything else
//!    together.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::io::Write as _;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use axum::body::{Body, Bytes};
use axum::http::{HeaderMap, Method, StatusCode, header};
use axum::response::{IntoResponse, Response};
use flate2::Compression;
use flate2::write::GzEncoder;
use rust_embed::EmbeddedFile;

/// How a file of the page is found by its name.
type Find = fn(&str) -> Option<EmbeddedFile>;

#[cfg(has_page)]
fn find(name: &str) -> Option<EmbeddedFile> {
    /// The folder that `SLAMLAB_PAGE` named when the program was built, without its source maps.
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

/// How a file is encoded on the network.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Form {
    Brotli,
    Gzip,
    Plain,
}

impl Form {
    /// Its name in HTTP (RFC 9110 §8.4.1, RFC 7932); none for a file sent as it is.
    fn encoding(self) -> Option<&'static str> {
        match self {
            Self::Brotli => Some("br"),
            Self::Gzip => Some("gzip"),
            Self::Plain => None,
        }
    }

    /// The smallest form that the browser accepts.
    fn taken_by(headers: &HeaderMap) -> Self {
        let offered = headers.get(header::ACCEPT_ENCODING);
        let offered = offered.and_then(|offered| offered.to_str().ok());
        let is_taken = |form: &Self| {
            let encoding = form.encoding().zip(offered);
            encoding.is_some_and(|(encoding, offered)| takes(offered, encoding))
        };
        let small = [Self::Brotli, Self::Gzip];
        small.into_iter().find(is_taken).unwrap_or(Self::Plain)
    }
}

/// The page, with the gzip forms made so far.
pub(crate) struct EmbeddedPage {
    find: Find,
    gzipped: Mutex<BTreeMap<String, Bytes>>,
}

impl EmbeddedPage {
    /// The page inside this program.
    pub(crate) fn new() -> Arc<Self> {
        Self::of(find)
    }

    fn of(find: Find) -> Arc<Self> {
        Arc::new(Self {
            find,
            gzipped: Mutex::default(),
        })
    }

    /// The answer to a request; 404 to everything if there is no page.
    pub(crate) async fn answer(
        self: Arc<Self>,
        method: &Method,
        path: &str,
        headers: &HeaderMap,
    ) -> Response {
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
        let packed = (self.find)(&format!("{name}.br"));
        let form = match packed {
            Some(_) => Form::taken_by(headers),
            None => Form::Plain,
        };
        let is_packed = packed.is_some();
        let Some(file) = packed.or_else(|| (self.find)(name)) else {
            return StatusCode::NOT_FOUND.into_response();
        };
        let kind = mime_guess::from_path(name).first_or_octet_stream();
        let mark = mark(&file, form);
        let common = [
            (header::CONTENT_TYPE, kind.to_string()),
            (header::ETAG, mark.clone()),
            (header::VARY, "accept-encoding".to_owned()),
        ];
        if knows(headers, &mark) {
            return (StatusCode::NOT_MODIFIED, common).into_response();
        }
        let stored = match file.data {
            Cow::Borrowed(all) => Bytes::from_static(all),
            Cow::Owned(all) => Bytes::from(all),
        };
        let data = match is_packed && form != Form::Brotli {
            true => self.formed(name.to_owned(), stored, form).await,
            false => Ok(stored),
        };
        let data = match data {
            Ok(data) => data,
            Err(error) => {
                tracing::error!("{name} of the page cannot be unpacked: {error}");
                return StatusCode::INTERNAL_SERVER_ERROR.into_response();
            }
        };
        // Without this header, the answer to HEAD would say that the file is empty.
        let length = [(header::CONTENT_LENGTH, data.len().to_string())];
        let body = match *method == Method::HEAD {
            true => Body::empty(),
            false => Body::from(data),
        };
        let mut response = (common, length, body).into_response();
        if let Some(encoding) = form.encoding() {
            let value = header::HeaderValue::from_static(encoding);
            response
                .headers_mut()
                .insert(header::CONTENT_ENCODING, value);
        }
        response
    }

    /// Converts a file stored as brotli to another form.
    async fn formed(
        self: Arc<Self>,
        name: String,
        packed: Bytes,
        form: Form,
    ) -> std::io::Result<Bytes> {
        let known = self.gzipped().get(&name).cloned();
        if let Some(known) = known.filter(|_| form == Form::Gzip) {
            return Ok(known);
        }
        let work = move || {
            let mut plain = vec![];
            brotli_decompressor::BrotliDecompress(&mut &*packed, &mut plain)?;
            if form == Form::Plain {
                return Ok(Bytes::from(plain));
            }
            let mut gzip = GzEncoder::new(vec![], Compression::default());
            gzip.write_all(&plain)?;
            let gzipped = Bytes::from(gzip.finish()?);
            self.gzipped().insert(name, gzipped.clone());
            Ok(gzipped)
        };
        let made = tokio::task::spawn_blocking(work).await;
        made.unwrap_or_else(|error| Err(std::io::Error::other(error)))
    }

    fn gzipped(&self) -> MutexGuard<'_, BTreeMap<String, Bytes>> {
        self.gzipped.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Whether `Accept-Encoding` names this encoding, and not with a weight of 0 (RFC 9110 §12.5.3).
fn takes(offered: &str, encoding: &str) -> bool {
    offered.split(',').any(|offer| {
        let (name, weight) = offer.split_once(';').unwrap_or((offer, ""));
        let weight = weight.trim().strip_prefix("q=").map(str::parse::<f32>);
        name.trim().eq_ignore_ascii_case(encoding) && weight != Some(Ok(0.0))
    })
}

fn mark(file: &EmbeddedFile, form: Form) -> String {
    let hash = file.metadata.sha256_hash();
    let half = crate::hexadecimal::write(&hash[..16]);
    format!("\"{half}-{}\"", form.encoding().unwrap_or("plain"))
}

/// Whether the browser already has this content (RFC 9110 §13.1.2).
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
