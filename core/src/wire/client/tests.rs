use super::super::message::{BridgeHeartbeat, CHALLENGE_BYTES, DisarmReason, Role, Watching};
use super::*;

/// The bridge's end, scripted by hand.
#[derive(Default)]
struct Bridge {
    sequence: u32,
    micros: u64,
}

impl Bridge {
    fn says(&mut self, message: &FromBridge) -> Vec<u8> {
        self.sequence += 1;
        let header = Header {
            sequence: self.sequence,
            micros: self.micros,
        };
        encode(header, message, Format::Binary).unwrap()
    }

    fn hello(&mut self) -> Vec<u8> {
        self.says(&FromBridge::Hello(BridgeHello {
            version: "1.2.3".to_owned(),
            schema: SCHEMA,
            challenge: [7; CHALLENGE_BYTES],
            watching: Watching::Anyone,
            robot: None,
            watchdog_millis: 200,
            lease_millis: 2000,
        }))
    }

    fn welcome(&mut self) -> Vec<u8> {
        let welcome = Welcome {
            client: 3,
            may_drive: true,
            role: Role::Driver,
            name: String::new(),
        };
        self.says(&FromBridge::Welcome(welcome))
    }

    fn safety(&mut self, driver: Option<u32>, armed: bool) -> Vec<u8> {
        self.says(&FromBridge::Safety(SafetyBody {
            driver,
            driver_name: "phone".to_owned(),
            armed,
            emergency: false,
            reason: DisarmReason::Start,
        }))
    }
}

fn said(client: &mut Client) -> Vec<ToBridge> {
    let outgoing = client.take_outgoing();
    let read = |bytes: Vec<u8>| decode::<ToBridge>(&bytes, Format::Binary).unwrap().1;
    outgoing.into_iter().map(read).collect()
}

/// A client that was let in.
fn inside(bridge: &mut Bridge) -> Client {
    let mut client = Client::new("desk", Some("secret"));
    client.receive(0, &bridge.hello()).unwrap();
    client.receive(1, &bridge.welcome()).unwrap();
    client.take_outgoing();
    client
}

#[test]
fn the_hello_is_answered_with_a_proof_and_never_with_the_token() {
    let mut bridge = Bridge::default();
    let mut client = Client::new("desk", Some("secret"));
    client.receive(0, &bridge.hello()).unwrap();
    let outgoing = client.take_outgoing();
    assert!(!outgoing[0].windows(6).any(|bytes| bytes == b"secret"));
    let (_, message) = decode::<ToBridge>(&outgoing[0], Format::Binary).unwrap();
    let ToBridge::Hello(hello) = message else {
        panic!("{message:?}");
    };
    assert_eq!(hello.proof, Some(proof("secret", &[7; CHALLENGE_BYTES])));
    assert!(!client.is_in());
    client.receive(1, &bridge.welcome()).unwrap();
    assert!(client.is_in() && client.may_drive());
}

#[test]
fn another_schema_and_a_wrong_order_are_refused_in_words() {
    let mut bridge = Bridge::default();
    let mut client = Client::new("desk", None);
    let error = client.receive(0, &bridge.welcome()).unwrap_err();
    assert_eq!(
        error.to_string(),
        "the bridge sent something before its hello"
    );
    let hello = BridgeHello {
        version: "0.0.1".to_owned(),
        schema: 1,
        challenge: [0; CHALLENGE_BYTES],
        watching: Watching::Anyone,
        robot: None,
        watchdog_millis: 200,
        lease_millis: 2000,
    };
    let error = client.receive(0, &bridge.says(&FromBridge::Hello(hello)));
    let error = error.unwrap_err().to_string();
    assert!(
        error.contains("0.0.1") && error.contains("reload"),
        "{error}"
    );
    assert!(client.take_outgoing().is_empty());
}

#[test]
fn nothing_drives_before_lease_and_arm_and_each_command_says_what_was_seen() {
    let mut bridge = Bridge::default();
    let mut client = inside(&mut bridge);
    let motion = Command::Velocity {
        forward: 0.1,
        turn: 0.0,
    };
    assert!(!client.drive(5, motion));
    client.arm(5);
    assert!(said(&mut client).is_empty());
    client.take(6, false);
    assert_eq!(said(&mut client), [ToBridge::Take { force: false }]);
    let lease = Lease {
        epoch: 9,
        millis: 2000,
    };
    let granted = bridge.says(&FromBridge::Granted(lease));
    client.receive(7, &granted).unwrap();
    client.receive(7, &bridge.safety(Some(3), false)).unwrap();
    assert!(!client.drive(8, motion), "not armed yet");
    client.arm(8);
    bridge.micros = 123_456;
    client.receive(9, &bridge.safety(Some(3), true)).unwrap();
    said(&mut client);
    assert!(client.drive(10, motion));
    let drive = DriveBody {
        epoch: 9,
        seen: 123_456,
        ttl_millis: TTL_MILLIS,
        motion,
    };
    assert_eq!(said(&mut client), [ToBridge::Drive(drive)]);
}

#[test]
fn a_lease_that_somebody_else_took_ends_driving() {
    let mut bridge = Bridge::default();
    let mut client = inside(&mut bridge);
    let lease = Lease {
        epoch: 9,
        millis: 2000,
    };
    let granted = bridge.says(&FromBridge::Granted(lease));
    client.receive(7, &granted).unwrap();
    client.receive(8, &bridge.safety(Some(3), true)).unwrap();
    assert!(client.is_armed());
    client.receive(9, &bridge.safety(Some(4), true)).unwrap();
    assert!(!client.is_armed() && !client.has_lease());
    assert!(!client.drive(10, Command::Stop));
}

#[test]
fn heartbeats_go_out_each_second_and_silence_is_noticed() {
    let mut bridge = Bridge::default();
    let mut client = inside(&mut bridge);
    let mut beats = 0;
    for step in 0..40 {
        client.tick(step * 100_000).unwrap();
        let said = said(&mut client);
        beats += said.iter().filter(|m| **m == ToBridge::Heartbeat).count();
    }
    assert_eq!(beats, 4);
    let error = client.tick(6_000_000).unwrap_err();
    assert!(error.to_string().contains("silent for 5 s"), "{error}");
}

#[test]
fn a_probe_tells_the_networks_delay_apart_from_the_bridges() {
    let mut bridge = Bridge::default();
    let mut client = inside(&mut bridge);
    client.tick(1_000_000).unwrap();
    let answer = ProbeAnswer {
        token: 1_000_000,
        came_micros: 50_000,
        robot_micros: 40_000,
        robot_came_micros: 44_000,
    };
    // The bridge took 2 ms to answer; the whole took 12 ms.
    bridge.micros = 52_000;
    let probe = bridge.says(&FromBridge::Probe(answer));
    client.receive(1_012_000, &probe).unwrap();
    let delays = client.delays().unwrap();
    assert!((delays.round_trip - 0.010).abs() < 1e-9, "{delays:?}");
    assert!((delays.reading_age - 0.006).abs() < 1e-9, "{delays:?}");
}

#[test]
fn whatever_comes_is_an_error_or_a_message_and_never_a_panic() {
    let mut bridge = Bridge::default();
    let beat = bridge.says(&FromBridge::Heartbeat(BridgeHeartbeat {
        dropped: 1,
        clients: 2,
        robot_micros: 3,
    }));
    for cut in 0..beat.len() {
        let mut client = inside(&mut Bridge::default());
        assert!(client.receive(0, &beat[..cut]).is_err(), "cut at {cut}");
    }
}
