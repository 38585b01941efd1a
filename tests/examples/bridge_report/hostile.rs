//! Clients without the token that try to disturb others. They run in a separate process, so their
//! own cost is not measured.

use std::net::SocketAddr;
use std::time::Duration;

use futures_util::{SinkExt, StreamExt};
use slamlab_core::wire::message::{Format, Header, ToBridge, encode};
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;
use tokio::time::{sleep, timeout};
use tokio_tungstenite::tungstenite::Message;
use tokio_tungstenite::tungstenite::protocol::frame::Frame;
use tokio_tungstenite::tungstenite::protocol::frame::coding::{Data, OpCode};

use crate::client::Client;

/// Kinds of attack; the clients take them in turn.
#[derive(Clone, Copy)]
enum Way {
    StopBursts,
    ProbeBursts,
    Fragments,
    HalfOpen,
    SlowReader,
}

const WAYS: [Way; 5] = [
    Way::StopBursts,
    Way::ProbeBursts,
    Way::Fragments,
    Way::HalfOpen,
    Way::SlowReader,
];
/// Messages at once.
const BURST: usize = 390;
/// Pause between two connections of the same client.
const AGAIN: Duration = Duration::from_millis(50);

/// Runs until it is killed: `count` clients, each of which comes back whenever it is thrown out.
pub(crate) async fn run(address: SocketAddr, count: usize) {
    for way in WAYS.into_iter().cycle().take(count) {
        tokio::spawn(async move {
            loop {
                // A refused connection ends in a panic, so it runs in a task.
                let once = tokio::spawn(attack(way, address));
                let _ = timeout(Duration::from_secs(20), once).await;
                sleep(AGAIN).await;
            }
        });
    }
    std::future::pending().await
}

async fn attack(way: Way, address: SocketAddr) {
    match way {
        Way::StopBursts => bursts(address, &ToBridge::Stop).await,
        Way::ProbeBursts => bursts(address, &ToBridge::Probe { token: 1 }).await,
        Way::Fragments => fragments(address).await,
        Way::HalfOpen => half_open(address).await,
        Way::SlowReader => {
            let mut client = Client::connect_narrow(address, 2048).await;
            let hello = client.hello(None);
            client.say(hello).await;
            // It keeps itself alive, and reads nothing.
            loop {
                sleep(Duration::from_secs(1)).await;
                client.say(ToBridge::Heartbeat).await;
            }
        }
    }
}

async fn bursts(address: SocketAddr, message: &ToBridge) {
    let mut client = Client::connect(address, "").await;
    client.enter(None).await;
    for sequence in 2..BURST as u32 + 2 {
        let header = Header {
            sequence,
            micros: 0,
        };
        let bytes = encode(header, message, Format::Binary).unwrap();
        if client.socket.feed(Message::binary(bytes)).await.is_err() {
            return;
        }
    }
    let _ = client.socket.flush().await;
    client.end().await;
}

/// A message that never ends, in the smallest fragments.
async fn fragments(address: SocketAddr) {
    let mut client = Client::connect(address, "").await;
    client.enter(None).await;
    let mut code = OpCode::Data(Data::Binary);
    loop {
        let frame = Frame::message(Vec::<u8>::new(), code, false);
        code = OpCode::Data(Data::Continue);
        if client.socket.feed(Message::Frame(frame)).await.is_err() {
            return;
        }
        // Messages of the bridge must be read, or it closes the connection for that reason.
        let _ = timeout(Duration::ZERO, client.socket.next()).await;
    }
}

/// Half a request, and nothing more.
async fn half_open(address: SocketAddr) {
    let mut stream = TcpStream::connect(address).await.unwrap();
    let _ = stream.write_all(b"GET /ws HTTP/1.1\r\nHost: 127").await;
    let _ = stream.read(&mut [0; 64]).await;
}
