//! Invalid settings: the bridge does not start, and says in one line what is wrong where.

use serde_json::{Value, json};

use crate::process::fails;

pub(crate) async fn report() -> (bool, Value) {
    let folder = tempfile::tempdir().unwrap();
    let empty = folder.path().join("empty.pem");
    std::fs::write(&empty, "nothing").unwrap();
    let empty = empty.to_str().unwrap();
    let tcp = "tcp/127.0.0.1:7447";
    let tls = "tls/localhost:7447";
    let cases: [(&[&str], &str); 9] = [
        (&["--zenoh", "127.0.0.1:7447"], "it has no `/`"),
        (&["--zenoh", "quic/a:1"], "neither tcp nor tls"),
        (&["--zenoh-name", "x"], "zenoh router is missing"),
        (&["--zenoh", tcp, "--zenoh-name", "a/b"], "a/b"),
        (&["--zenoh", tls], "zenoh ca is missing"),
        (
            &["--zenoh", tls, "--zenoh-ca", "/nowhere.pem"],
            "/nowhere.pem",
        ),
        (
            &["--zenoh", tls, "--zenoh-ca", empty],
            "expected a certificate in PEM",
        ),
        (&["--zenoh", tcp, "--private"], "private"),
        (
            &["--zenoh", tcp, "--ros-domain", "0", "--ros-right", "nobody"],
            "ros-right nobody",
        ),
    ];
    let mut all = vec![];
    let mut holds = true;
    for (flags, words) in cases {
        let said = fails(flags).await;
        let is_said = said.as_deref().is_some_and(|said| said.contains(words));
        holds &= is_said;
        all.push(json!({ "flags": flags.join(" "), "holds": is_said, "said": said }));
    }
    (holds, json!(all))
}
