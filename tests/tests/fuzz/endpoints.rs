//! Messages of other tools to a running bridge: JSON of rosbridge and of Foxglove, over real
//! sockets.
//!
//! Each input is the first message of a connection of its own. A second message, which is always
//! answered, shows when the input was processed. Laws: the connection is answered or closed, no
//! task of the bridge panics, the bridge lives on, and a client that showed no token cannot move
//! the robot.

use std::collections::BTreeSet;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};
use std::time::Duration;

use futures_util::{SinkExt, StreamExt};
use serde_json::Value;
use slamlab_bridge::source::{Order, Port, Profile, Source, SourceEvent, Waited};
use slamlab_bridge::{Config, Limits};
use slamlab_core::robot::RobotModel;
use slamlab_core::wire::message::{LinkBody, LinkState};
use slamlab_tests::fuzz::{Target, outcome};
use tokio::net::TcpStream;
use tokio::runtime::Runtime;
use tokio::time::timeout;
use tokio_tungstenite::tungstenite::Message;
use tokio_tungstenite::tungstenite::client::IntoClientRequest;
use tokio_tungstenite::tungstenite::http::HeaderValue;

/// The targets that need a bridge.
pub(crate) const ENDPOINTS: &[Target] = &[
    Target {
        name: "rosbridge",
        seeds: rosbridge_seeds,
        run: |input| ask(&ROSBRIDGE, input),
    },
    Target {
        name: "foxglove",
        seeds: foxglove_seeds,
        run: |input| ask(&FOXGLOVE, input),
    },
];

/// A timeout: whatever is awaited comes sooner or never.
const NEVER: Duration = Duration::from_secs(60);
/// The close code with which the bridge ends.
const GOING_AWAY: u16 = 1001;

struct Endpoint {
    path: &'static str,
    protocol: Option<&'static str>,
    /// A message that is always answered, and how to recognise the answer.
    last: fn() -> Message,
    is_answer: fn(&Value) -> bool,
}

const ROSBRIDGE: Endpoint = Endpoint {
    path: "/rosbridge",
    protocol: None,
    last: || Message::text(r#"{"op":"call_service","id":"the last","service":"/nowhere"}"#),
    is_answer: |said| said["id"] == "the last",
};
const FOXGLOVE: Endpoint = Endpoint {
    path: "/foxglove",
    protocol: Some("foxglove.sdk.v1"),
    last: || Message::binary(vec![0]),
    is_answer: |said| {
        said["message"]
            .as_str()
            .is_some_and(|text| text.contains("a binary message"))
    },
};

fn texts(texts: &[&str]) -> Vec<Vec<u8>> {
    texts.iter().map(|text| text.as_bytes().to_vec()).collect()
}

fn rosbridge_seeds() -> Vec<Vec<u8>> {
    texts(&[
        r#"{"op":"subscribe","id":"subscribe:/scan:1","type":"sensor_msgs/LaserScan","topic":"/scan","compression":"none","throttle_rate":100,"queue_length":0}"#,
        r#"{"op":"unsubscribe","topic":"/odom"}"#,
        r#"{"op":"advertise","topic":"/cmd_vel","type":"geometry_msgs/Twist"}"#,
        r#"{"op":"publish","topic":"/cmd_vel","msg":{"linear":{"x":0.1,"y":0,"z":0},"angular":{"x":0,"y":0,"z":-0.5}}}"#,
        r#"{"op":"call_service","id":"a","service":"/slamlab/challenge","args":{}}"#,
        r#"{"op":"call_service","service":"/slamlab/enter","args":{"proof":"00ff"}}"#,
        r#"{"op":"call_service","service":"/slamlab/take","args":{"force":true}}"#,
        r#"{"op":"call_service","service":"/slamlab/arm"}"#,
        r#"{"op":"call_service","service":"/slamlab/stop"}"#,
        r#"{"op":"unadvertise","topic":"/cmd_vel"}"#,
        r#"{"op":"png","data":"\u00e9"}"#,
    ])
}

fn foxglove_seeds() -> Vec<Vec<u8>> {
    texts(&[
        r#"{"op":"subscribe","subscriptions":[{"id":0,"channelId":3},{"id":4294967295,"channelId":0}]}"#,
        r#"{"op":"unsubscribe","subscriptionIds":[1,2]}"#,
        r#"{"op":"setParameters","parameters":[{"name":"a","value":[1.5,null]}]}"#,
    ])
}

fn ask(endpoint: &Endpoint, input: &[u8]) -> Result<u64, String> {
    let bridge = bridge();
    let conversation = async { timeout(NEVER, converse(endpoint, bridge.address, input)).await };
    let seen = bridge.runtime.block_on(conversation);
    let seen = seen.map_err(|_| "neither answered nor closed".to_owned())??;
    if PANICKED.swap(false, Ordering::SeqCst) {
        return Err("a task of the bridge panicked".to_owned());
    }
    let moved = bridge.moved.lock().unwrap_or_else(PoisonError::into_inner);
    match *moved {
        Some(order) => Err(format!("somebody without the token gave {order:?}")),
        None => Ok(outcome(&seen)),
    }
}

/// What was answered up to the last question, and the code if the connection was closed.
async fn converse(
    endpoint: &Endpoint,
    address: std::net::SocketAddr,
    input: &[u8],
) -> Result<BTreeSet<String>, String> {
    let lost = |error: &dyn std::fmt::Display| format!("the bridge is gone: {error}");
    let stream = TcpStream::connect(address).await.map_err(|e| lost(&e))?;
    // Its port is free again at once, because there are thousands of inputs a second.
    stream.set_zero_linger().map_err(|e| lost(&e))?;
    let url = format!("ws://{address}{}", endpoint.path);
    let mut request = url.into_client_request().map_err(|e| lost(&e))?;
    if let Some(protocol) = endpoint.protocol {
        let protocol = HeaderValue::from_static(protocol);
        request
            .headers_mut()
            .insert("sec-websocket-protocol", protocol);
    }
    let (mut socket, _) = tokio_tungstenite::client_async(request, stream)
        .await
        .map_err(|e| lost(&e))?;
    let text = String::from_utf8_lossy(input).into_owned();
    // A connection that the first message ended does not accept a second one.
    let _ = socket.send(Message::text(text)).await;
    let _ = socket.send((endpoint.last)()).await;
    let mut seen = BTreeSet::new();
    loop {
        match socket.next().await {
            Some(Ok(Message::Close(Some(frame)))) if u16::from(frame.code) != GOING_AWAY => {
                seen.insert(format!("closed {}", frame.reason));
                return Ok(seen);
            }
            Some(Ok(Message::Text(said))) => {
                let said: Value =
                    serde_json::from_str(&said).map_err(|e| format!("{said}: {e}"))?;
                if (endpoint.is_answer)(&said) {
                    return Ok(seen);
                }
                // Readings arrive at any time.
                if said["op"] != "publish" {
                    let words =
                        |key: &str| said[key].to_string().chars().take(40).collect::<String>();
                    seen.insert(format!(
                        "{} {} {}",
                        words("op"),
                        words("msg"),
                        words("message")
                    ));
                }
            }
            Some(Ok(Message::Ping(_) | Message::Pong(_) | Message::Binary(_))) => (),
            // The system drops the close frame of a connection with unread data.
            Some(Err(_)) | None => {
                seen.insert("closed".to_owned());
                return Ok(seen);
            }
            Some(Ok(other)) => return Err(format!("it said {other:?}")),
        }
    }
}

/// Set if one of the bridge's threads panicked.
static PANICKED: AtomicBool = AtomicBool::new(false);
const THREADS: &str = "bridge";

struct Running {
    runtime: Runtime,
    address: std::net::SocketAddr,
    moved: Arc<Mutex<Option<Order>>>,
}

/// One bridge for all inputs: what one input breaks, the next one finds broken.
fn bridge() -> &'static Running {
    static BRIDGE: OnceLock<Running> = OnceLock::new();
    BRIDGE.get_or_init(|| {
        let runtime = tokio::runtime::Builder::new_multi_thread()
            .thread_name(THREADS)
            .enable_all()
            .build()
            .unwrap();
        let tell = std::panic::take_hook();
        std::panic::set_hook(Box::new(move |info| {
            if std::thread::current().name() == Some(THREADS) {
                PANICKED.store(true, Ordering::SeqCst);
            }
            tell(info);
        }));
        let moved = Arc::new(Mutex::new(None));
        let listener = runtime
            .block_on(slamlab_bridge::bind(([127, 0, 0, 1], 0).into()))
            .unwrap();
        let address = listener.local_addr().unwrap();
        let config = Config {
            sources: vec![Box::new(Watchman(Arc::clone(&moved)))],
            keys: slamlab_bridge::rights::Keys::Token(
                slamlab_bridge::token::Token::random().unwrap(),
            ),
            rosbridge: true,
            foxglove: true,
            limits: Limits {
                heartbeat: NEVER,
                hello: NEVER,
                sockets: 4096,
                per_address: 4096,
                watchers: 4096,
                watchers_per_address: 4096,
                watcher_rate: 200,
                ..Limits::default()
            },
            ..Config::default()
        };
        runtime.spawn(slamlab_bridge::run(
            listener,
            config,
            std::future::pending(),
        ));
        Running {
            runtime,
            address,
            moved,
        }
    })
}

/// A robot that is up, and records who moves it.
struct Watchman(Arc<Mutex<Option<Order>>>);

impl Source for Watchman {
    fn profile(&self) -> Profile {
        Profile {
            name: "watchman".into(),
            robot: Some(RobotModel::rp6()),
            takes_orders: true,
            scans_on_command: false,
        }
    }

    fn run(self: Box<Self>, port: Port) {
        port.send(SourceEvent::Link(LinkBody::new(LinkState::Up)));
        loop {
            match port.wait(NEVER) {
                Waited::Closed => return,
                Waited::Order(order) if is_motion(&order) => {
                    *self.0.lock().unwrap_or_else(PoisonError::into_inner) = Some(order);
                }
                _ => (),
            }
        }
    }
}

fn is_motion(order: &Order) -> bool {
    use slamlab_core::robot::Command;
    !matches!(
        order,
        Order::Command(Command::Stop) | Order::EmergencyStop | Order::ResetEmergencyStop
    )
}
