//! The decoders of wire protocols, each with real input to begin with and the laws that it keeps
//! whatever the input.
//!
//! A stream decoder gives the same in pieces as at once. A decoded message is encoded to something
//! that decodes to the same.

use std::hash::{DefaultHasher, Hash, Hasher};

use slamlab_core::device::source::SourceEvent;
use slamlab_core::device::udp::UdpLidar;
use slamlab_core::device::{Device as _, Kind, Lidar, Want};
use slamlab_core::geom::Pose2;
use slamlab_core::robot::{Scan, Stamp};
use slamlab_core::wire::message::{Format, FromBridge, Packet, ToBridge, decode, encode};
use slamlab_core::wire::rp6::{Command, Decoder, Report};
use slamlab_core::wire::{ld06, pilch, rp6, rplidar};

use super::seeds;

/// A decoder.
pub struct Target {
    /// Its name, which is also that of its folder of crashes.
    pub name: &'static str,
    /// Real input.
    pub seeds: fn() -> Vec<Vec<u8>>,
    /// What became of an input, in one number; or the law that it broke.
    pub run: fn(&[u8]) -> Result<u64, String>,
}

/// The targets for wire protocols.
pub(super) const WIRES: &[Target] = &[
    Target {
        name: "rp6-reports",
        seeds: seeds::rp6_reports,
        run: |input| frames::<Report>(input),
    },
    Target {
        name: "rp6-commands",
        seeds: seeds::rp6_commands,
        run: |input| frames::<Command>(input),
    },
    Target {
        name: "rp6-link",
        seeds: seeds::rp6_reports,
        run: rp6_link,
    },
    Target {
        name: "rplidar-standard",
        seeds: seeds::rplidar_standard,
        run: rplidar_answers,
    },
    Target {
        name: "rplidar-express",
        seeds: seeds::rplidar_express,
        run: rplidar_answers,
    },
    Target {
        name: "rplidar-device",
        seeds: seeds::rplidar_standard,
        run: |input| lidar("rplidar", input),
    },
    Target {
        name: "rplidar-requests",
        seeds: seeds::rplidar_requests,
        run: rplidar_requests_run,
    },
    Target {
        name: "ld06",
        seeds: seeds::ld06_seeds,
        run: ld06_run,
    },
    Target {
        name: "pilch",
        seeds: seeds::pilch_seeds,
        run: pilch_run,
    },
    Target {
        name: "messages-binary",
        seeds: || seeds::messages(Format::Binary),
        run: |input| message(input, Format::Binary),
    },
    Target {
        name: "messages-json",
        seeds: || seeds::messages(Format::Json),
        run: |input| message(input, Format::Json),
    },
];

/// One number for what became of an input. Numbers within words do not count, or each input would
/// be different.
pub fn outcome(what: &impl std::fmt::Debug) -> u64 {
    let text: String = format!("{what:?}")
        .chars()
        .filter(|c| !c.is_ascii_digit())
        .take(200)
        .collect();
    let mut hasher = DefaultHasher::new();
    text.hash(&mut hasher);
    hasher.finish()
}

/// A law: both must be equal.
pub(super) fn same<T: PartialEq + std::fmt::Debug>(
    at_once: &T,
    in_pieces: &T,
) -> Result<(), String> {
    match at_once == in_pieces {
        true => Ok(()),
        false => Err(format!("at once {at_once:?}, in pieces {in_pieces:?}")),
    }
}

/// Pieces of 1, 2, 3, 5, 7, 1 … bytes.
pub(super) fn pieces(mut input: &[u8]) -> impl Iterator<Item = &[u8]> {
    let mut lengths = [1, 2, 3, 5, 7].into_iter().cycle();
    std::iter::from_fn(move || {
        let length = lengths.next()?.min(input.len());
        let (piece, rest) = input.split_at(length);
        input = rest;
        (length > 0).then_some(piece)
    })
}

fn frames<M: rp6::Message + std::fmt::Debug>(input: &[u8]) -> Result<u64, String> {
    let read = |decoder: &mut Decoder<M>, bytes: &[u8]| -> Vec<String> {
        decoder
            .push(bytes)
            .map(|frame| format!("{} {:?}", frame.sequence, frame.message))
            .collect()
    };
    let (mut whole, mut parts) = (Decoder::default(), Decoder::default());
    let at_once = read(&mut whole, input);
    let in_pieces: Vec<String> = pieces(input)
        .flat_map(|piece| read(&mut parts, piece))
        .collect();
    same(&at_once, &in_pieces)?;
    same(&whole.tally(), &parts.tally())?;
    Ok(outcome(&at_once))
}

fn rp6_link(input: &[u8]) -> Result<u64, String> {
    let mut link = rp6::Link::new(Stamp(0), 1);
    let mut events = vec![];
    for (k, piece) in (0..).zip(pieces(input)) {
        let now = Stamp(k * 20_000);
        link.receive(piece, now);
        link.tick(now);
        events.extend(std::iter::from_fn(|| link.next_event()).map(|event| format!("{event:?}")));
        let _ = link.take_output();
        if link.is_armed() {
            return Err("the line armed the link".into());
        }
    }
    Ok(outcome(&(link.phase(), events.len().min(9))))
}

fn rplidar_answers(input: &[u8]) -> Result<u64, String> {
    let (mut whole, mut parts) = (
        rplidar::decoder::Decoder::default(),
        rplidar::decoder::Decoder::default(),
    );
    whole.extend(input);
    let at_once: Vec<String> = whole.by_ref().map(|answer| format!("{answer:?}")).collect();
    let mut in_pieces = vec![];
    for piece in pieces(input) {
        parts.extend(piece);
        in_pieces.extend(parts.by_ref().map(|answer| format!("{answer:?}")));
    }
    same(&at_once, &in_pieces)?;
    same(&whole.tally(), &parts.tally())?;
    let kinds: Vec<&str> = at_once
        .iter()
        .map(|answer| &answer[..answer.len().min(12)])
        .collect();
    Ok(outcome(&kinds))
}

/// A lidar whose line delivers these bytes.
fn lidar(kind: &str, input: &[u8]) -> Result<u64, String> {
    let kind = Kind::named(kind).ok_or("no such kind")?;
    let mut device = (kind.open)("fuzz".into(), Pose2::identity());
    device.opened(Stamp(0));
    let mut wants = vec![];
    for (k, piece) in (0..).zip(pieces(input)) {
        let now = Stamp(k * 5_000);
        device.receive(piece, now);
        device.tick(now);
        while let Some(want) = device.next_want() {
            if let Want::Report(SourceEvent::Scan(scan)) = &want {
                valid(scan)?;
            }
            let text = format!("{want:?}");
            wants.push(text.chars().take(24).collect::<String>());
        }
    }
    Ok(outcome(&wants))
}

/// What is passed on keeps its promises.
fn valid(scan: &Scan) -> Result<(), String> {
    scan.validate()
        .map_err(|error| format!("a scan was handed on: {error}"))
}

fn rplidar_requests_run(input: &[u8]) -> Result<u64, String> {
    let (mut whole, mut parts) = (
        rplidar::request::RequestDecoder::default(),
        rplidar::request::RequestDecoder::default(),
    );
    whole.extend(input);
    let at_once: Vec<_> = whole.by_ref().collect();
    let mut in_pieces = vec![];
    for piece in pieces(input) {
        parts.extend(piece);
        in_pieces.extend(parts.by_ref());
    }
    same(&at_once, &in_pieces)?;
    Ok(outcome(&at_once))
}

fn ld06_run(input: &[u8]) -> Result<u64, String> {
    let (mut whole, mut parts) = (ld06::Decoder::default(), ld06::Decoder::default());
    whole.extend(input);
    let at_once: Vec<_> = whole.by_ref().collect();
    let mut in_pieces = vec![];
    for piece in pieces(input) {
        parts.extend(piece);
        in_pieces.extend(parts.by_ref());
    }
    same(&at_once, &in_pieces)?;
    same(&whole.tally(), &parts.tally())?;
    lidar("ld06", input)
}

fn pilch_run(input: &[u8]) -> Result<u64, String> {
    let request = pilch::Request::decode(input);
    if let Ok(request) = &request {
        same(
            &pilch::Request::decode(&request.encode()).as_ref(),
            &Ok(request),
        )?;
    }
    let reply = pilch::Reply::decode(input);
    let mut server = pilch::server::Server::new(vec![pilch::DEFAULT_PATH.into()]);
    server.receive(1, b"\xFF\x00HELLO", Stamp(0));
    server.receive(1, input, Stamp(1000));
    server.tick(Stamp(2000));
    let events = std::iter::from_fn(|| server.next_event()).count();
    let mut client = Lidar::new("fuzz", UdpLidar::new("/dev/ttyUSB0"), Pose2::identity());
    client.opened(Stamp(0));
    client.receive(b"\xFF\x011:LIDAR", Stamp(500));
    client.receive(input, Stamp(1000));
    client.tick(Stamp(2000));
    let mut wants = 0;
    while let Some(want) = client.next_want() {
        if let Want::Report(SourceEvent::Scan(scan)) = &want {
            valid(scan)?;
        }
        wants += 1;
    }
    let words = |error: String| error.chars().take(30).collect::<String>();
    Ok(outcome(&(
        request.map_err(|error| words(error.to_string())).is_ok(),
        reply.map_err(|error| words(error.to_string())),
        events,
        wants,
    )))
}

fn message(input: &[u8], format: Format) -> Result<u64, String> {
    let to = round_trip::<ToBridge>(input, format)?;
    let from = round_trip::<FromBridge>(input, format)?;
    if let Ok((_, FromBridge::Scan(body))) = decode::<FromBridge>(input, format)
        && let Ok(scan) = body.scan()
    {
        valid(&scan)?;
    }
    Ok(outcome(&(to, from)))
}

fn round_trip<M: Packet + std::fmt::Debug>(input: &[u8], format: Format) -> Result<String, String> {
    let (header, message) = match decode::<M>(input, format) {
        Ok(decoded) => decoded,
        Err(error) => return Ok(error.to_string().chars().take(40).collect()),
    };
    let bytes =
        encode(header, &message, format).map_err(|error| format!("does not encode: {error}"))?;
    let (_, again) =
        decode::<M>(&bytes, format).map_err(|error| format!("does not decode again: {error}"))?;
    // NaN is not equal to itself; its text is.
    same(&format!("{message:?}"), &format!("{again:?}"))?;
    Ok(format!("{message:?}").chars().take(16).collect())
}
