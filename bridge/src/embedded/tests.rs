//! Tests the handler on a small page that is really embedded: `bridge/tests/page`.

use std::io::Read as _;

use axum::body::to_bytes;
use flate2::read::GzDecoder;
use rust_embed::RustEmbed;

use super::*;

#[derive(RustEmbed)]
#[folder = "tests/page"]
struct Small;

async fn ask(path: &str, headers: &[(header::HeaderName, &'static str)]) -> Response {
    let headers = headers
        .iter()
        .map(|(name, value)| (name.clone(), header::HeaderValue::from_static(value)))
        .collect();
    let page = EmbeddedPage::of(Small::get);
    page.answer(&Method::GET, path, &headers).await
}

fn head<'a>(response: &'a Response, name: &header::HeaderName) -> &'a str {
    let value = response.headers().get(name);
    value.map_or("", |value| value.to_str().unwrap())
}

async fn text(response: Response) -> String {
    let bytes = to_bytes(response.into_body(), 1_000_000).await.unwrap();
    String::from_utf8_lossy(&bytes).into_owned()
}

#[tokio::test]
async fn each_file_has_its_type_and_the_root_is_the_index() {
    for (path, kind) in [
        ("/", "text/html"),
        ("/index.html", "text/html"),
        ("/main-Q3KX7ABC.js", "text/javascript"),
        ("/a.wasm", "application/wasm"),
    ] {
        let answer = ask(path, &[]).await;
        assert_eq!(answer.status(), StatusCode::OK, "{path}");
        assert!(
            head(&answer, &header::CONTENT_TYPE).starts_with(kind),
            "{path}: {answer:?}"
        );
        assert_eq!(head(&answer, &header::CONTENT_ENCODING), "");
    }
    assert_eq!(
        text(ask("/", &[]).await).await,
        "<!doctype html><title>slamlab</title>"
    );
}

/// The content that Node's zlib compressed into `main-Q3KX7ABC.js.br`.
fn script() -> String {
    "export const walls = [];\n".repeat(40)
}

async fn bytes(response: Response) -> Vec<u8> {
    to_bytes(response.into_body(), 1_000_000)
        .await
        .unwrap()
        .to_vec()
}

#[tokio::test]
async fn the_smallest_form_that_the_browser_takes_is_sent() {
    let packed = Small::get("main-Q3KX7ABC.js.br").unwrap().data;
    for (offered, encoding) in [
        ("gzip, deflate, br, zstd", "br"),
        ("gzip, deflate", "gzip"),
        ("gzip, br;q=0", "gzip"),
        ("GZIP;q=0.5", "gzip"),
        ("br;q=0, gzip;q=0", ""),
        ("brotli", ""),
        ("", ""),
    ] {
        let answer = ask("/main-Q3KX7ABC.js", &[(header::ACCEPT_ENCODING, offered)]).await;
        let sent = head(&answer, &header::CONTENT_ENCODING).to_owned();
        assert_eq!(sent, encoding, "{offered}");
        assert!(head(&answer, &header::CONTENT_TYPE).starts_with("text/javascript"));
        let length = head(&answer, &header::CONTENT_LENGTH).to_owned();
        let body = bytes(answer).await;
        assert_eq!(length, body.len().to_string());
        match encoding {
            "br" => assert_eq!(body, &*packed),
            "gzip" => {
                let mut plain = String::new();
                GzDecoder::new(&*body).read_to_string(&mut plain).unwrap();
                assert_eq!(plain, script(), "{offered}");
                assert!(body.len() < plain.len() / 4);
            }
            _ => assert_eq!(body, script().as_bytes(), "{offered}"),
        }
    }
    // A file that did not shrink is sent as it is.
    let answer = ask("/a.wasm", &[(header::ACCEPT_ENCODING, "br, gzip")]).await;
    assert_eq!(head(&answer, &header::CONTENT_ENCODING), "");
}

#[tokio::test]
async fn a_form_is_made_once() {
    let page = EmbeddedPage::of(Small::get);
    let headers = HeaderMap::from_iter([(
        header::ACCEPT_ENCODING,
        header::HeaderValue::from_static("gzip"),
    )]);
    let ask = || Arc::clone(&page).answer(&Method::GET, "/main-Q3KX7ABC.js", &headers);
    let first = bytes(ask().await).await;
    assert_eq!(page.gzipped().len(), 1);
    // The cached form is sent.
    let kept = Bytes::from_static(b"kept");
    page.gzipped().insert("main-Q3KX7ABC.js".into(), kept);
    assert_eq!(bytes(ask().await).await, b"kept");
    assert_ne!(first, b"kept");
}

#[tokio::test]
async fn what_the_browser_has_is_not_sent_again() {
    let first = ask("/a.wasm", &[]).await;
    let mark = head(&first, &header::ETAG).to_owned();
    let mark: &'static str = mark.leak();
    let again = ask("/a.wasm", &[(header::IF_NONE_MATCH, mark)]).await;
    assert_eq!(again.status(), StatusCode::NOT_MODIFIED);
    assert_eq!(text(again).await, "");
    for other in ["\"0\"", "", "W/\"0\", \"1\""] {
        let answer = ask("/a.wasm", &[(header::IF_NONE_MATCH, other)]).await;
        assert_eq!(answer.status(), StatusCode::OK, "{other}");
    }
    // Each form has its own `ETag`.
    let mut marks = vec![];
    for offered in ["br", "gzip", ""] {
        let answer = ask("/main-Q3KX7ABC.js", &[(header::ACCEPT_ENCODING, offered)]).await;
        marks.push(head(&answer, &header::ETAG).to_owned());
    }
    marks.sort();
    marks.dedup();
    assert_eq!(marks.len(), 3);
}

#[tokio::test]
async fn nothing_else_is_there() {
    for path in [
        "/nothing.js",
        "/../Cargo.toml",
        "/%2e%2e/Cargo.toml",
        "/fonts/",
        "//index.html",
    ] {
        let answer = ask(path, &[]).await;
        assert_eq!(answer.status(), StatusCode::NOT_FOUND, "{path}");
    }
    let page = EmbeddedPage::of(Small::get);
    let none = HeaderMap::new();
    let posted = Arc::clone(&page).answer(&Method::POST, "/", &none).await;
    assert_eq!(posted.status(), StatusCode::METHOD_NOT_ALLOWED);
    let asked = page.answer(&Method::HEAD, "/a.wasm", &none).await;
    assert_eq!(head(&asked, &header::CONTENT_LENGTH), "4");
    assert_eq!(text(asked).await, "");
}
