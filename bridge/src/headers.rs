//! The headers of every answer: what the page may do, and what may be cached.

use axum::http::HeaderMap;
use axum::http::header::{self, HeaderName, HeaderValue};

/// The page loads everything from here and nothing from elsewhere; scripts and styles are files,
/// never inline. `wasm-unsafe-eval` allows compiling WebAssembly, not evaluating strings.
pub const CONTENT_SECURITY_POLICY: &str = "default-src 'none'; script-src 'self' 'wasm-unsafe-eval'; \
    worker-src 'self'; connect-src 'self'; style-src 'self'; img-src 'self' data: blob:; font-src 'self'; \
    manifest-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

/// Sent with every answer, including errors. The opener and embedder policies make the page
/// cross-origin isolated, which gives its clocks their full resolution.
const FENCE: [(&str, &str); 7] = [
    ("content-security-policy", CONTENT_SECURITY_POLICY),
    ("x-content-type-options", "nosniff"),
    ("referrer-policy", "no-referrer"),
    (
        "permissions-policy",
        "camera=(), microphone=(), geolocation=(), payment=(), usb=(), serial=(self), gamepad=(self)",
    ),
    ("cross-origin-opener-policy", "same-origin"),
    ("cross-origin-embedder-policy", "require-corp"),
    ("cross-origin-resource-policy", "same-origin"),
];

/// Adds the fence and the caching rule for the answer to a request of `path`.
pub(crate) fn add(headers: &mut HeaderMap, path: &str, success: bool) {
    for (name, value) in FENCE {
        headers.insert(
            HeaderName::from_static(name),
            HeaderValue::from_static(value),
        );
    }
    // Source maps are JSON, but lists of media types do not contain them.
    if success && path.ends_with(".map") {
        let json = HeaderValue::from_static("application/json");
        headers.insert(header::CONTENT_TYPE, json);
    }
    let caching = match (success, has_content_hash(path)) {
        (false, _) => "no-store",
        (true, true) => "public, max-age=31536000, immutable",
        // Cached, but revalidated at each load: a rebuilt page is seen at once, an unchanged one
        // costs a 304.
        (true, false) => "no-cache",
    };
    headers.insert(header::CACHE_CONTROL, HeaderValue::from_static(caching));
}

/// Whether the file's name carries a hash of its content, as esbuild writes it: `main-Q3KX7ABC.js`.
fn has_content_hash(path: &str) -> bool {
    let name = path.rsplit('/').next().unwrap_or(path);
    let stem = name.split('.').next().unwrap_or(name);
    stem.rsplit_once('-').is_some_and(|(_, hash)| {
        hash.len() == 8
            && hash
                .bytes()
                .all(|b| b.is_ascii_uppercase() || b.is_ascii_digit())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_source_map_has_its_type() {
        let kind = |path, success| {
            let mut headers = HeaderMap::new();
            add(&mut headers, path, success);
            headers.get(header::CONTENT_TYPE).cloned()
        };
        let json = HeaderValue::from_static("application/json");
        assert_eq!(kind("/main-Q3KX7ABC.js.map", true), Some(json));
        assert_eq!(kind("/main-Q3KX7ABC.js.map", false), None);
        assert_eq!(kind("/main-Q3KX7ABC.js", true), None);
    }

    /// On a server that sends no headers, the page itself asks for the same policy, except for
    /// framing, which only a header can restrict.
    #[test]
    fn the_page_asks_for_the_same_policy_where_no_header_does() {
        let page = include_str!("../../www/index.html");
        let meta = "<meta http-equiv=\"Content-Security-Policy\" content=\"";
        let (_, rest) = page.split_once(meta).unwrap();
        let (policy, _) = rest.split_once('"').unwrap();
        assert_eq!(
            format!("{policy}; frame-ancestors 'none'"),
            CONTENT_SECURITY_POLICY
        );
    }

    #[test]
    fn only_names_with_a_hash_are_immutable() {
        for path in ["/main-Q3KX7ABC.js", "/chunks/a-b-22222222.js.map"] {
            assert!(has_content_hash(path), "{path}");
        }
        for path in [
            "/",
            "/main.js",
            "/slamlab_web_bg.wasm",
            "/uplot-min.css",
            "/a-Q3KX7ab.js",
        ] {
            assert!(!has_content_hash(path), "{path}");
        }
    }
}
