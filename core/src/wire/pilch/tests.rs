//! The datagrams byte by byte as the paper draws them, and the rules of the server.

use proptest::prelude::*;

use super::server::{Server, ServerEvent};
use super::*;
use crate::robot::Stamp;

fn at(seconds: f64) -> Stamp {
    Stamp::from_seconds(seconds)
}

#[test]
fn requests_are_those_of_the_source() {
    let path = || "/dev/ttyUSB0".to_owned();
    // Figs. 3.15, 3.17, 3.19, 3.20; 115200 = 0x0001C200.
    let connect = [&[1, 0, 0x00, 0xC2, 0x01, 0x00, 12][..], b"/dev/ttyUSB0"].concat();
    for (request, bytes) in [
        (Request::Hello("HELLO".into()), b"\xFF\x00HELLO".to_vec()),
        (Request::Heartbeat, vec![0xFF, 2]),
        (
            Request::Connect {
                baud: 115_200,
                path: path(),
            },
            connect,
        ),
        (Request::Start, vec![1, 1]),
        (Request::Stop, vec![1, 2]),
        (
            Request::Send {
                samples: 360,
                interval: 200,
            },
            vec![1, 3, 0x68, 1, 0, 0, 200, 0, 0, 0],
        ),
    ] {
        assert_eq!(request.encode(), bytes);
        assert_eq!(Request::decode(&bytes), Ok(request));
    }
    assert_eq!(
        Request::Hello("HELLO".into()).encode().len(),
        7,
        "the paper says 7 bytes"
    );
}

#[test]
fn replies_are_those_of_the_source() {
    let devices = vec![
        Device {
            id: 1,
            name: "LIDAR".into(),
        },
        Device {
            id: 2,
            name: "GPIO".into(),
        },
    ];
    // Quality 15, 90°, 1 m, as in a node of the sensor.
    let node = Node {
        starts: true,
        quality: 15,
        angle: 5760,
        distance: 4000,
    };
    for (reply, bytes) in [
        (Reply::Devices(devices), b"\xFF\x011:LIDAR##2:GPIO".to_vec()),
        (Reply::State(DeviceState::Sending), vec![1, 4, 3]),
        (
            Reply::Readings(vec![node]),
            vec![1, 3, 1, 0, 0, 0, 0x3D, 0x01, 0x2D, 0xA0, 0x0F],
        ),
    ] {
        assert_eq!(reply.encode(), bytes);
        assert_eq!(Reply::decode(&bytes), Ok(reply));
    }
}

#[test]
fn states_have_the_numbers_of_the_source() {
    use DeviceState::{Connected, Fault, Measuring, Sending, Waiting};
    for (number, state) in (0..).zip([Waiting, Connected, Measuring, Sending, Fault]) {
        assert_eq!(Reply::State(state).encode(), [1, 4, number]);
        assert_eq!(Reply::decode(&[1, 4, number]), Ok(Reply::State(state)));
    }
}

#[test]
fn what_is_wrong_with_a_datagram_is_named() {
    let request = |bytes: &[u8]| Request::decode(bytes).unwrap_err().to_string();
    assert!(request(&[]).contains("begins with []"));
    assert!(request(&[7, 7]).contains("begins with [07, 07]"));
    assert!(request(&[1, 3, 0]).contains("has 3 bytes, expected 10"));
    assert!(request(&[1, 0, 0, 0, 0, 0, 5, b'/']).contains("has 8 bytes, expected 12"));
    assert!(request(&[0xFF, 0, 0xC3]).contains("not UTF-8"));
    let reply = |bytes: &[u8]| Reply::decode(bytes).unwrap_err().to_string();
    assert!(reply(&[1, 4, 5]).contains("state 5"));
    assert!(reply(&[1, 3, 0xFF, 0xFF, 0xFF, 0xFF]).contains("has 6 bytes"));
    assert!(reply(b"\xFF\x01lidar").contains("id:name"));
}

fn events(server: &mut Server<&'static str>) -> Vec<ServerEvent<&'static str>> {
    std::iter::from_fn(|| server.next_event()).collect()
}

fn sent(to: &'static str, reply: &Reply) -> ServerEvent<&'static str> {
    ServerEvent::Send {
        to,
        datagram: reply.encode(),
    }
}

fn say(server: &mut Server<&'static str>, from: &'static str, request: &Request, seconds: f64) {
    server.receive(from, &request.encode(), at(seconds));
}

fn greeted() -> Server<&'static str> {
    let mut server = Server::new(vec![DEFAULT_PATH.into()]);
    say(&mut server, "pi", &Request::Hello(HELLO.into()), 0.0);
    events(&mut server);
    server
}

#[test]
fn there_is_one_client_until_it_is_silent() {
    let mut server = Server::new(vec![DEFAULT_PATH.into()]);
    let hello = Request::Hello(HELLO.into());
    say(&mut server, "pi", &hello, 0.0);
    let list = Reply::Devices(vec![Device {
        id: 1,
        name: "LIDAR".into(),
    }]);
    assert_eq!(events(&mut server), [sent("pi", &list)]);
    say(&mut server, "eve", &hello, 1.0);
    say(&mut server, "eve", &Request::Start, 1.0);
    assert_eq!(events(&mut server), []);
    say(&mut server, "pi", &Request::Heartbeat, 4.0);
    server.tick(at(8.9));
    assert_eq!(server.client(), Some(&"pi"));
    // Orders do not replace the heartbeat.
    say(&mut server, "pi", &Request::Start, 8.9);
    assert_eq!(events(&mut server), [ServerEvent::Start]);
    server.tick(at(9.1));
    assert_eq!(server.client(), None);
    assert_eq!(events(&mut server), [ServerEvent::Stop]);
    say(&mut server, "eve", &hello, 9.2);
    assert_eq!(server.client(), Some(&"eve"));
}

#[test]
fn without_a_greeting_nobody_is_heard() {
    let mut server = Server::new(vec![DEFAULT_PATH.into()]);
    say(&mut server, "eve", &Request::Start, 0.0);
    server.receive("eve", &[9, 9, 9], at(0.0));
    assert_eq!(events(&mut server), []);
}

#[test]
fn only_paths_of_the_list_are_opened() {
    let mut server = greeted();
    let connect = |path: &str| Request::Connect {
        baud: 115_200,
        path: path.into(),
    };
    say(&mut server, "pi", &connect("/etc/passwd"), 0.1);
    assert_eq!(
        events(&mut server),
        [sent("pi", &Reply::State(DeviceState::Fault))]
    );
    say(&mut server, "pi", &connect("/dev/ttyUSB0"), 0.2);
    let path = "/dev/ttyUSB0".into();
    assert_eq!(
        events(&mut server),
        [ServerEvent::Connect {
            baud: 115_200,
            path
        }]
    );
}

#[test]
fn a_flood_is_heard_up_to_the_rate_and_the_next_second_is_new() {
    let mut server = greeted();
    for _ in 0..1000 {
        say(&mut server, "pi", &Request::Start, 0.5);
    }
    // The greeting was the first of the hundred.
    assert_eq!(events(&mut server).len(), 99);
    say(&mut server, "pi", &Request::Heartbeat, 1.1);
    say(&mut server, "pi", &Request::Start, 1.1);
    assert_eq!(events(&mut server), [ServerEvent::Start]);
}

#[test]
fn a_flood_of_strangers_does_not_drown_the_client() {
    let mut server = greeted();
    for _ in 0..1000 {
        say(&mut server, "eve", &Request::Start, 0.5);
    }
    assert_eq!(events(&mut server), []);
    say(&mut server, "pi", &Request::Start, 0.6);
    assert_eq!(events(&mut server), [ServerEvent::Start]);
}

#[test]
fn readings_are_sent_as_asked_for() {
    let mut server = greeted();
    let nodes = |count: u16| {
        (0..count).map(|k| Node {
            starts: false,
            quality: 9,
            angle: k,
            distance: k,
        })
    };
    server.publish(nodes(10));
    server.set_state(DeviceState::Measuring);
    say(
        &mut server,
        "pi",
        &Request::Send {
            samples: 4,
            interval: 100,
        },
        1.0,
    );
    let states = [DeviceState::Measuring, DeviceState::Sending]
        .map(|state| sent("pi", &Reply::State(state)));
    assert_eq!(events(&mut server), states);
    server.publish(nodes(10));
    for millis in (1000..=1250).step_by(50) {
        server.tick(at(f64::from(millis) * 1e-3));
    }
    let expected: Vec<_> = [0..4, 4..8, 8..10]
        .map(|part| {
            sent(
                "pi",
                &Reply::Readings(nodes(10).collect::<Vec<_>>()[part].to_vec()),
            )
        })
        .into();
    assert_eq!(events(&mut server), expected);
    say(&mut server, "pi", &Request::Stop, 2.0);
    server.publish(nodes(10));
    server.tick(at(3.0));
    assert_eq!(events(&mut server), [ServerEvent::Stop]);
}

proptest! {
    #[test]
    fn any_datagram_is_read_or_refused(bytes in prop::collection::vec(any::<u8>(), 0..200), first in 0..4_u8) {
        let head = [[0xFF, bytes.len() as u8 % 4], [1, first]];
        for head in head {
            let datagram = [&head[..], &bytes].concat();
            if let Ok(request) = Request::decode(&datagram) {
                prop_assert_eq!(request.encode(), datagram.clone());
            }
            if let Ok(reply) = Reply::decode(&datagram) {
                prop_assert_eq!(Reply::decode(&reply.encode()), Ok(reply));
            }
        }
    }

    #[test]
    fn any_datagrams_leave_a_server_standing(
        datagrams in prop::collection::vec((any::<bool>(), prop::collection::vec(any::<u8>(), 0..20)), 0..100),
    ) {
        let mut server = greeted();
        for (k, (is_client, datagram)) in datagrams.iter().enumerate() {
            server.receive(if *is_client { "pi" } else { "eve" }, datagram, at(k as f64 * 0.01));
        }
        let is_opening = |event: &ServerEvent<_>| matches!(event, ServerEvent::Connect { .. });
        prop_assert!(!events(&mut server).iter().any(is_opening));
    }
}
