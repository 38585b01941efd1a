//! Named rights, over real sockets: created, revoked and changed while the bridge runs.

use std::fs;
use std::time::{Duration, Instant};

use futures_util::{SinkExt, StreamExt};
use serde_json::{Value, json};
use slamlab_bridge::Limits;
use slamlab_bridge::token::Token;
use slamlab_core::wire::message::{
    DisarmReason, FromBridge, RefusalReason, Role, ToBridge, Watching, close, proof,
};
use slamlab_tests::calm::async_on_a_calm_machine;
use tokio::net::TcpStream;
use tokio::time::timeout;
use tokio_tungstenite::WebSocketStream;
use tokio_tungstenite::tungstenite::Message;

use super::client::Bridge;
use super::rights_stand::{Stand, drive_on};

const NEVER: Duration = Duration::from_secs(20);

#[test]
fn a_right_that_is_taken_away_stops_the_robot_at_once_and_shows_its_holder_out() {
    async_on_a_calm_machine(async || {
        let stand = Stand::start(Watching::Anyone).await;
        let token = stand.add("anna", Role::Driver);
        let mut anna = stand.enter(&token).await;
        anna.take(false).await;
        anna.arm().await;
        anna.drive(0.1, 0.0).await;
        let mut watcher = stand.bridge.watcher().await;
        let driver = watcher
            .wait(|message| match message {
                FromBridge::Safety(state) => Some(state.driver_name.clone()),
                _ => None,
            })
            .await;
        assert!(driver.starts_with("anna ("), "{driver}");
        let from = Instant::now();
        stand.revoke("anna");
        // Driving on without a pause does not help.
        assert_eq!(drive_on(&mut anna).await, Some(close::REVOKED));
        let after = from.elapsed();
        assert!(after.as_millis() < 1500, "{after:?}");
        let why = watcher
            .wait(|message| match message {
                FromBridge::Safety(state) if !state.armed && state.driver.is_none() => {
                    Some(state.reason)
                }
                _ => None,
            })
            .await;
        assert_eq!(why, DisarmReason::Revoked);
        assert!(!stand.is_good(&token).await);
        stand.memory.stopped_after(from).await;
        let (lines, _folder) = stand.stop().await;
        let what: Vec<_> = lines
            .iter()
            .map(|line| line["what"].as_str().unwrap())
            .collect();
        let expected = [
            "begins",
            "lease",
            "drives",
            "revoked",
            "stops",
            "lease-ends",
        ];
        assert_eq!(what[..6], expected, "{what:?}");
        assert_eq!(lines[1]["who"]["name"], "anna");
        assert_eq!(lines[1]["who"]["role"], "driver");
        assert_eq!(lines[4]["cause"], "revoked");
        assert_eq!(lines[4]["who"]["name"], "anna");
        assert!(what.contains(&"refused"), "{what:?}");
        let text = serde_json::to_string(&lines).unwrap();
        assert!(!text.contains(&token), "a token stands in the audit");
    });
}

#[test]
fn each_role_may_do_what_is_its_own() {
    async_on_a_calm_machine(async || {
        let stand = Stand::start(Watching::Token).await;
        let [wall, anna, bert] = [
            ("wall", Role::Watcher),
            ("anna", Role::Driver),
            ("bert", Role::Driver),
        ]
        .map(|(name, role)| stand.add(name, role));
        let mut wall_client = stand.enter(&wall).await;
        wall_client.say(ToBridge::Take { force: true }).await;
        assert_eq!(wall_client.end().await, Some(close::NO_RIGHT));
        let mut nobody = stand.bridge.connect().await;
        nobody.say(nobody.hello(None)).await;
        assert_eq!(nobody.end().await, Some(close::ACCESS));

        let mut anna = stand.enter(&anna).await;
        anna.take(false).await;
        anna.arm().await;
        let mut wall_client = stand.enter(&wall).await;
        wall_client.say(ToBridge::Stop).await;
        let reason = anna
            .wait(|message| match message {
                FromBridge::Safety(state) if !state.armed => Some(state.reason),
                _ => None,
            })
            .await;
        assert_eq!(reason, DisarmReason::Stop);
        // A driver takes over from a driver, an owner from anybody, nobody from an owner.
        let mut bert = stand.enter(&bert).await;
        bert.take(true).await;
        assert_eq!(anna.end().await, Some(close::TAKEN_OVER));
        let mut owner = stand.bridge.driver().await;
        owner.take(true).await;
        assert_eq!(bert.end().await, Some(close::TAKEN_OVER));
        let clara = stand.add("clara", Role::Driver);
        let mut clara = stand.enter(&clara).await;
        clara.say(ToBridge::Take { force: true }).await;
        let refusal = clara
            .wait(|message| match message {
                FromBridge::Refused(reason) => Some(*reason),
                _ => None,
            })
            .await;
        assert_eq!(refusal, RefusalReason::Held);
        stand.stop().await;
    });
}

#[test]
fn a_file_that_is_spoilt_gives_nobody_a_right_and_the_owner_keeps_his() {
    async_on_a_calm_machine(async || {
        let stand = Stand::start(Watching::Anyone).await;
        let token = stand.add("anna", Role::Driver);
        let mut anna = stand.enter(&token).await;
        let good = fs::read_to_string(stand.rights.path()).unwrap();
        fs::write(stand.rights.path(), format!("{good}oops")).unwrap();
        assert_eq!(anna.end().await, Some(close::REVOKED));
        assert!(!stand.is_good(&token).await);
        assert!(stand.is_good(&stand.bridge.token).await);
        fs::write(stand.rights.path(), &good).unwrap();
        stand.enter(&token).await;
        // A changed role makes it another right.
        let mut anna = stand.enter(&token).await;
        fs::write(
            stand.rights.path(),
            good.replace("\"driver\"", "\"watcher\""),
        )
        .unwrap();
        assert_eq!(anna.end().await, Some(close::REVOKED));
        let mut anna = stand.enter(&token).await;
        anna.say(ToBridge::Take { force: false }).await;
        assert_eq!(anna.end().await, Some(close::NO_RIGHT));
        stand.stop().await;
    });
}

#[test]
fn a_new_token_of_the_owner_replaces_the_old_one_without_a_restart() {
    async_on_a_calm_machine(async || {
        let stand = Stand::start(Watching::Anyone).await;
        let old = stand.bridge.token.clone();
        let mut owner = stand.bridge.driver().await;
        owner.take(false).await;
        let new = Token::renew(&stand.folder.path().join("token")).unwrap();
        assert_eq!(owner.end().await, Some(close::REVOKED));
        assert!(!stand.is_good(&old).await);
        let mut owner = stand.enter(new.reveal()).await;
        owner.take(false).await;
        stand.stop().await;
    });
}

/// Otherwise many watchers' tokens would leave no place for a driver.
#[test]
fn a_watcher_with_a_token_is_a_watcher_to_the_limits() {
    async_on_a_calm_machine(async || {
        let limits = Limits {
            watchers: 2,
            ..Limits::default()
        };
        let stand = Stand::start_with(Watching::Token, limits).await;
        let [wall, anna] = [("wall", Role::Watcher), ("anna", Role::Driver)]
            .map(|(name, role)| stand.add(name, role));
        let _two = [stand.enter(&wall).await, stand.enter(&wall).await];
        let mut third = stand.bridge.connect().await;
        third.say(third.hello(Some(&wall))).await;
        assert_eq!(third.end().await, Some(close::FULL));
        stand.enter(&anna).await.take(false).await;
        stand.stop().await;
    });
}

/// The same rules, the same end.
#[test]
fn rosbridge_goes_by_the_same_rights() {
    async_on_a_calm_machine(async || {
        let stand = Stand::start(Watching::Anyone).await;
        let wall = stand.add("wall", Role::Watcher);
        let anna = stand.add("anna", Role::Driver);
        stand.enter(&anna).await;
        let mut socket = rosbridge(&stand.bridge, &wall, "wall", "watcher").await;
        let answer = call(&mut socket, "/slamlab/take", json!({})).await;
        assert_eq!(answer["result"], false);
        assert_eq!(answer["values"]["reason"], "no-right");
        let mut socket = rosbridge(&stand.bridge, &anna, "anna", "driver").await;
        let answer = call(&mut socket, "/slamlab/take", json!({})).await;
        assert_eq!(answer["result"], true, "{answer}");
        // As soon as the robot is there.
        let arms = async {
            while call(&mut socket, "/slamlab/arm", json!({})).await["result"] != true {
                tokio::time::sleep(Duration::from_millis(10)).await;
            }
        };
        timeout(NEVER, arms).await.unwrap();
        let from = Instant::now();
        stand.revoke("anna");
        let code = loop {
            match timeout(NEVER, socket.next()).await.unwrap() {
                Some(Ok(Message::Close(frame))) => break frame.map(|frame| u16::from(frame.code)),
                Some(Ok(_)) => (),
                _ => break None,
            }
        };
        assert_eq!(code, Some(close::REVOKED));
        stand.memory.stopped_after(from).await;
        stand.stop().await;
    });
}

type Socket = WebSocketStream<TcpStream>;

/// A client of rosbridge that has shown a token.
async fn rosbridge(bridge: &Bridge, token: &str, name: &str, role: &str) -> Socket {
    let stream = TcpStream::connect(bridge.address).await.unwrap();
    let url = format!("ws://{}/rosbridge", bridge.address);
    let (mut socket, _) = tokio_tungstenite::client_async(url, stream).await.unwrap();
    let answer = call(&mut socket, "/slamlab/challenge", json!({})).await;
    let challenge = answer["values"]["challenge"].as_str().unwrap();
    let bytes: Vec<u8> = (0..challenge.len() / 2)
        .map(|at| u8::from_str_radix(&challenge[2 * at..2 * at + 2], 16).unwrap())
        .collect();
    let shown = proof(token, &bytes.try_into().unwrap());
    let hex: String = shown.iter().map(|byte| format!("{byte:02x}")).collect();
    let answer = call(&mut socket, "/slamlab/enter", json!({ "proof": hex })).await;
    assert_eq!(answer["values"], json!({ "name": name, "role": role }));
    socket
}

async fn call(socket: &mut Socket, service: &str, args: Value) -> Value {
    let call = json!({ "op": "call_service", "service": service, "args": args });
    socket.send(Message::text(call.to_string())).await.unwrap();
    loop {
        let message = timeout(NEVER, socket.next()).await.unwrap();
        let Some(Ok(message)) = message else {
            panic!("{service}: the connection ended");
        };
        let Message::Text(text) = message else {
            continue;
        };
        let answer: Value = serde_json::from_str(&text).unwrap();
        if answer["op"] == "service_response" {
            return answer;
        }
    }
}
