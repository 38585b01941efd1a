//! A client of another version: it is refused in words, and misreads nothing.

use futures_util::StreamExt;
use slamlab_core::wire::message::{ClientHello, PROTOCOL, SCHEMA, ToBridge, close, encode};
use slamlab_core::wire::message::{Format, Header};
use slamlab_tests::calm::async_on_a_calm_machine;
use tokio_tungstenite::tungstenite::Message;

use super::client::{Bridge, Client};
use super::robot::with_robot;

fn hello(schema: u64) -> ToBridge {
    ToBridge::Hello(ClientHello {
        schema,
        name: "of yesterday".into(),
        proof: None,
    })
}

/// Code and reason with which the bridge ends the connection.
async fn farewell(mut client: Client) -> (u16, String) {
    loop {
        match client.socket.next().await {
            Some(Ok(Message::Close(Some(frame)))) => {
                return (frame.code.into(), frame.reason.to_string());
            }
            Some(Ok(_)) => (),
            other => panic!("no word of farewell: {other:?}"),
        }
    }
}

#[test]
fn a_client_of_another_schema_is_refused_with_its_own_code_and_words() {
    async_on_a_calm_machine(async || {
        let (config, memory) = with_robot();
        let bridge = Bridge::start(config).await;
        for query in ["", "?fmt=json"] {
            let mut client = Client::connect(bridge.address, query).await;
            client.say(hello(SCHEMA ^ 1)).await;
            let (code, words) = farewell(client).await;
            assert_eq!(code, close::OTHER_SCHEMA);
            assert!(
                words.contains("another schema") && words.contains("reload the page"),
                "{words}"
            );
        }
        // The right version is accepted in the same way.
        let mut client = bridge.connect().await;
        assert!(!client.enter(None).await);
        assert!(!memory.was_moved());
        bridge.stop().await;
    });
}

#[test]
fn a_client_of_another_protocol_is_refused_alike() {
    async_on_a_calm_machine(async || {
        let (config, _) = with_robot();
        let bridge = Bridge::start(config).await;
        let mut client = bridge.connect().await;
        let header = Header {
            sequence: 1,
            micros: 0,
        };
        let mut bytes = encode(header, &hello(SCHEMA), Format::Binary).unwrap();
        bytes[2] = PROTOCOL + 1;
        client.send(Message::binary(bytes)).await;
        let (code, words) = farewell(client).await;
        assert_eq!(code, close::OTHER_SCHEMA);
        assert!(words.contains("another schema"), "{words}");
        bridge.stop().await;
    });
}
