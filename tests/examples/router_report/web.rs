//! Requests to a bridge, one per connection.

use std::net::SocketAddr;

use serde_json::Value;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;
use tokio::time::timeout;

use crate::started::NEVER;

/// Status and body.
pub(crate) async fn ask(
    address: SocketAddr,
    method: &str,
    path: &str,
    origin: Option<&str>,
) -> (u16, String) {
    let origin = origin.map_or(String::new(), |origin| format!("Origin: {origin}\r\n"));
    let request =
        format!("{method} {path} HTTP/1.0\r\nHost: {address}\r\n{origin}Content-Length: 0\r\n\r\n");
    let whole = async {
        let mut stream = TcpStream::connect(address).await.unwrap();
        stream.write_all(request.as_bytes()).await.unwrap();
        let mut answer = vec![];
        stream.read_to_end(&mut answer).await.unwrap();
        String::from_utf8(answer).unwrap()
    };
    let answer = timeout(NEVER, whole).await.unwrap();
    let (head, body) = answer.split_once("\r\n\r\n").unwrap();
    let status = head.split(' ').nth(1).unwrap().parse().unwrap();
    (status, body.to_owned())
}

/// All that the bridge knows of the fleet.
pub(crate) async fn fleet(address: SocketAddr) -> Value {
    let (status, body) = ask(address, "GET", "/fleet.json", None).await;
    assert_eq!(status, 200, "{body}");
    serde_json::from_str(&body).unwrap()
}

/// Robots at the router, as the bridge lists them.
pub(crate) fn here(fleet: &Value) -> Vec<&Value> {
    let robots = fleet["robots"].as_array().unwrap();
    robots
        .iter()
        .filter(|robot| robot["here"] == true)
        .collect()
}
