//! The handler against a small page that is really embedded: `bridge/tests/page`.

use axum::body::to_bytes;
use rust_embed::RustEmbed;

use super::*;

#[derive(RustEmbed)]
#[folder = "tests/page"]
struct Small;

fn ask(path: &str, headers: &[(header::HeaderName, &'static str)]) -> Response {
    let headers = headers
        .iter()
        .map(|(name, value)| (name.clone(), header::HeaderValue::from_static(value)))
        .collect();
    answer_from(Small::get, &Method::GET, path, &headers)
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
        let answer = ask(path, &[]);
        assert_eq!(answer.status(), StatusCode::OK, "{path}");
        assert!(
            head(&answer, &header::CONTENT_TYPE).starts_with(kind),
            "{path}: {answer:?}"
        );
        assert_eq!(head(&answer, &header::CONTENT_ENCODING), "");
    }
    assert_eq!(
        text(ask("/", &[])).await,
        "<!doctype html><title>slamlab</title>"
    );
}

#[tokio::test]
async fn the_smallest_form_that_the_browser_takes_is_sent() {
    for (offered, encoding, body) in [
        ("gzip, deflate, br, zstd", "br", "packed by brotli"),
        ("gzip, deflate", "gzip", "packed by gzip"),
        ("gzip, br;q=0", "gzip", "packed by gzip"),
        ("GZIP;q=0.5", "gzip", "packed by gzip"),
        ("br;q=0, gzip;q=0", "", "export {};\n"),
        ("brotli", "", "export {};\n"),
        ("", "", "export {};\n"),
    ] {
        let answer = ask("/main-Q3KX7ABC.js", &[(header::ACCEPT_ENCODING, offered)]);
        assert_eq!(
            head(&answer, &header::CONTENT_ENCODING),
            encoding,
            "{offered}"
        );
        assert!(head(&answer, &header::CONTENT_TYPE).starts_with("text/javascript"));
        assert_eq!(
            head(&answer, &header::CONTENT_LENGTH),
            body.len().to_string()
        );
        assert_eq!(text(answer).await, body, "{offered}");
    }
    // A file that did not shrink goes as it is.
    let answer = ask("/a.wasm", &[(header::ACCEPT_ENCODING, "br, gzip")]);
    assert_eq!(head(&answer, &header::CONTENT_ENCODING), "");
}

#[tokio::test]
async fn what_the_browser_has_is_not_sent_again() {
    let first = ask("/a.wasm", &[]);
    let mark = head(&first, &header::ETAG).to_owned();
    let mark: &'static str = mark.leak();
    let again = ask("/a.wasm", &[(header::IF_NONE_MATCH, mark)]);
    assert_eq!(again.status(), StatusCode::NOT_MODIFIED);
    assert_eq!(text(again).await, "");
    for other in ["\"0\"", "", "W/\"0\", \"1\""] {
        let answer = ask("/a.wasm", &[(header::IF_NONE_MATCH, other)]);
        assert_eq!(answer.status(), StatusCode::OK, "{other}");
    }
    // Another form is another content.
    let packed = ask("/main-Q3KX7ABC.js", &[(header::ACCEPT_ENCODING, "br")]);
    assert_ne!(
        head(&packed, &header::ETAG),
        head(&ask("/main-Q3KX7ABC.js", &[]), &header::ETAG)
    );
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
        assert_eq!(ask(path, &[]).status(), StatusCode::NOT_FOUND, "{path}");
    }
    let posted = answer_from(Small::get, &Method::POST, "/", &HeaderMap::new());
    assert_eq!(posted.status(), StatusCode::METHOD_NOT_ALLOWED);
    let asked = answer_from(Small::get, &Method::HEAD, "/a.wasm", &HeaderMap::new());
    assert_eq!(head(&asked, &header::CONTENT_LENGTH), "4");
    assert_eq!(text(asked).await, "");
}
