//! A bridge on a free port, and a client that speaks its protocol.

use std::net::SocketAddr;
use std::path::Path;
use std::time::Duration;

use futures_util::{SinkExt, StreamExt};
use slamlab_bridge::rights::Keys;
use slamlab_bridge::token::Token;
use slamlab_bridge::{Config, Limits};
use slamlab_core::robot::Command;
use slamlab_core::wire::message::{
    ClientHello, DriveBody, Format, FromBridge, Header, RobotFigures, SCHEMA, ToBridge, decode,
    encode, proof,
};
use tokio::net::{TcpSocket, TcpStream};
use tokio::sync::oneshot;
use tokio::task::JoinHandle;
use tokio::time::{Instant, timeout};
use tokio_tungstenite::WebSocketStream;
use tokio_tungstenite::tungstenite::Message;

/// A timeout: whatever is awaited comes sooner or never.
const NEVER: Duration = Duration::from_secs(20);

/// A running bridge; it stops when this is dropped.
pub(crate) struct Bridge {
    pub(crate) address: SocketAddr,
    pub(crate) token: String,
    stop: Option<oneshot::Sender<()>>,
    server: JoinHandle<()>,
}

impl Bridge {
    pub(crate) async fn start(config: Config) -> Self {
        let token = Token::random().unwrap();
        let secret = token.reveal().to_owned();
        Self::start_with(config, Keys::Token(token), secret).await
    }

    /// Starts with these rights, of which `token` is the owner's.
    pub(crate) async fn start_with(config: Config, keys: Keys, token: String) -> Self {
        let listener = slamlab_bridge::bind(([127, 0, 0, 1], 0).into())
            .await
            .unwrap();
        let address = listener.local_addr().unwrap();
        let config = Config { keys, ..config };
        let (stop, stopped) = oneshot::channel();
        let server = tokio::spawn(async move {
            let stopped = async {
                let _ = stopped.await;
            };
            slamlab_bridge::run(listener, config, stopped)
                .await
                .unwrap();
        });
        Self {
            address,
            token,
            stop: Some(stop),
            server,
        }
    }

    /// Ends the bridge, and waits until it has ended.
    pub(crate) async fn stop(mut self) {
        drop(self.stop.take());
        timeout(NEVER, &mut self.server).await.unwrap().unwrap();
    }

    /// A client that has read the bridge's hello and said nothing.
    pub(crate) async fn connect(&self) -> Client {
        Client::connect(self.address, "").await
    }

    pub(crate) async fn watcher(&self) -> Client {
        let mut client = self.connect().await;
        client.enter(None).await;
        client
    }

    pub(crate) async fn driver(&self) -> Client {
        let mut client = self.connect().await;
        client.enter(Some(&self.token)).await;
        client
    }

    /// A client that has the lease and armed.
    pub(crate) async fn armed(&self) -> Client {
        let mut client = self.driver().await;
        client.take(false).await;
        client.arm().await;
        client
    }
}

/// A connection from `127.0.0.LAST`.
pub(crate) async fn stream_from(address: SocketAddr, last: u8) -> TcpStream {
    let socket = TcpSocket::new_v4().unwrap();
    socket.bind(([127, 0, 0, last], 0).into()).unwrap();
    socket.connect(address).await.unwrap()
}

/// Waits until the bridge has created, or removed, a file.
pub(crate) async fn until_there(path: &Path, is_there: bool, longest: Duration) {
    let until = Instant::now() + longest;
    while path.exists() != is_there {
        let what = if is_there { "missing" } else { "there" };
        assert!(Instant::now() < until, "{} is {what} still", path.display());
        tokio::time::sleep(Duration::from_millis(10)).await;
    }
}

pub(crate) fn limits() -> Limits {
    Limits::default()
}

/// One connection.
pub(crate) struct Client {
    pub(crate) socket: WebSocketStream<TcpStream>,
    pub(crate) challenge: [u8; 16],
    pub(crate) robot: Option<RobotFigures>,
    pub(crate) sequence: u32,
    /// Newest time of the bridge that was received, µs.
    pub(crate) seen: u64,
    pub(crate) epoch: u32,
    format: Format,
}

/// What arrived.
#[derive(Debug)]
pub(crate) enum Came {
    Message(FromBridge),
    Closed(u16),
    /// The connection broke off without a close frame.
    Lost,
}

impl Client {
    pub(crate) async fn connect(address: SocketAddr, query: &str) -> Self {
        let stream = TcpStream::connect(address).await.unwrap();
        Self::over(stream, address, query).await
    }

    /// A client with small socket buffers.
    pub(crate) async fn connect_narrow(address: SocketAddr, bytes: u32) -> Self {
        let socket = TcpSocket::new_v4().unwrap();
        socket.set_recv_buffer_size(bytes).unwrap();
        let stream = socket.connect(address).await.unwrap();
        Self::over(stream, address, "").await
    }

    /// A client with another address of this machine, `127.0.0.LAST`.
    pub(crate) async fn connect_from(address: SocketAddr, last: u8) -> Self {
        let stream = stream_from(address, last).await;
        Self::over(stream, address, "").await
    }

    async fn over(stream: TcpStream, address: SocketAddr, query: &str) -> Self {
        stream.set_nodelay(true).unwrap();
        let url = format!("ws://{address}/ws{query}");
        let (socket, _) = tokio_tungstenite::client_async(url, stream).await.unwrap();
        let mut client = Self {
            socket,
            challenge: [0; 16],
            robot: None,
            sequence: 0,
            seen: 0,
            epoch: 0,
            format: if query.contains("json") {
                Format::Json
            } else {
                Format::Binary
            },
        };
        (client.challenge, client.robot) = client
            .wait(|message| match message {
                FromBridge::Hello(hello) => Some((hello.challenge, hello.robot.clone())),
                _ => None,
            })
            .await;
        client
    }

    /// Says hello; returns whether it may drive.
    pub(crate) async fn enter(&mut self, token: Option<&str>) -> bool {
        let hello = self.hello(token);
        self.say(hello).await;
        self.wait(|message| match message {
            FromBridge::Welcome(welcome) => Some(welcome.may_drive),
            _ => None,
        })
        .await
    }

    pub(crate) fn hello(&self, token: Option<&str>) -> ToBridge {
        ToBridge::Hello(ClientHello {
            schema: SCHEMA,
            name: "test".into(),
            proof: token.map(|token| proof(token, &self.challenge)),
        })
    }

    pub(crate) async fn take(&mut self, force: bool) {
        self.say(ToBridge::Take { force }).await;
        self.epoch = self
            .wait(|message| match message {
                FromBridge::Granted(lease) => Some(lease.epoch),
                _ => None,
            })
            .await;
    }

    /// Arms, once the robot is there.
    pub(crate) async fn arm(&mut self) {
        let epoch = self.epoch;
        loop {
            self.say(ToBridge::Arm { epoch }).await;
            let armed = self
                .wait(|message| match message {
                    FromBridge::Safety(state) if state.armed => Some(true),
                    FromBridge::Refused(_) => Some(false),
                    _ => None,
                })
                .await;
            if armed {
                return;
            }
        }
    }

    pub(crate) async fn drive(&mut self, forward: f64, turn: f64) {
        let motion = Command::Velocity { forward, turn };
        let body = self.body(motion);
        self.say(ToBridge::Drive(body)).await;
    }

    pub(crate) fn body(&self, motion: Command) -> DriveBody {
        DriveBody {
            epoch: self.epoch,
            seen: self.seen,
            ttl_millis: 300,
            motion,
        }
    }

    pub(crate) async fn say(&mut self, message: ToBridge) {
        self.sequence += 1;
        let header = Header {
            sequence: self.sequence,
            micros: 0,
        };
        let bytes = encode(header, &message, self.format).unwrap();
        let message = match self.format {
            Format::Binary => Message::binary(bytes),
            Format::Json => Message::text(String::from_utf8(bytes).unwrap()),
        };
        // If the bridge has already closed, reading will show it.
        let _ = self.socket.send(message).await;
    }

    pub(crate) async fn send(&mut self, message: Message) {
        let _ = self.socket.send(message).await;
    }

    pub(crate) async fn next(&mut self) -> Came {
        loop {
            let Some(Ok(message)) = timeout(NEVER, self.socket.next()).await.unwrap() else {
                return Came::Lost;
            };
            let bytes = match message {
                Message::Binary(bytes) => bytes.to_vec(),
                Message::Text(text) => text.as_bytes().to_vec(),
                Message::Close(frame) => return Came::Closed(frame.map_or(0, |f| f.code.into())),
                _ => continue,
            };
            let (header, message) = decode(&bytes, self.format).unwrap();
            self.seen = header.micros;
            return Came::Message(message);
        }
    }

    /// Reads until `find` returns something.
    pub(crate) async fn wait<T>(&mut self, mut find: impl FnMut(&FromBridge) -> Option<T>) -> T {
        let until = tokio::time::Instant::now() + NEVER;
        while tokio::time::Instant::now() < until {
            match self.next().await {
                Came::Message(message) => {
                    if let Some(found) = find(&message) {
                        return found;
                    }
                }
                other => panic!("the connection ended: {other:?}"),
            }
        }
        panic!("it never came");
    }

    /// Reads to the end; returns the close code.
    pub(crate) async fn end(&mut self) -> Option<u16> {
        loop {
            match self.next().await {
                Came::Message(..) => (),
                Came::Closed(code) => return Some(code),
                Came::Lost => return None,
            }
        }
    }

    /// Drives for a while at 20 Hz, reading what arrives.
    pub(crate) async fn drive_for(&mut self, duration: Duration, forward: f64) {
        let motion = Command::Velocity { forward, turn: 0.0 };
        let drive = |client: &Self| ToBridge::Drive(client.body(motion));
        self.repeat(duration, drive).await;
    }

    /// Keeps the present manoeuvre alive for a while.
    pub(crate) async fn hold_for(&mut self, duration: Duration) {
        let hold = |client: &Self| ToBridge::Hold {
            epoch: client.epoch,
            seen: client.seen,
            ttl_millis: 300,
        };
        self.repeat(duration, hold).await;
    }

    async fn repeat(&mut self, duration: Duration, message: impl Fn(&Self) -> ToBridge) {
        let mut ticks = tokio::time::interval(Duration::from_millis(50));
        let until = tokio::time::Instant::now() + duration;
        while tokio::time::Instant::now() < until {
            tokio::select! {
                _ = ticks.tick() => self.say(message(self)).await,
                came = self.next() => assert!(matches!(came, Came::Message(..)), "{came:?}"),
            }
        }
    }
}
