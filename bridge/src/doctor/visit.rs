//! Probes a device on its port for a few seconds.

use std::time::{Duration, Instant};

use slamlab_core::robot::Stamp;
use slamlab_core::wire::message::DeviceState;

use super::finding::Measured;
use crate::serial::{Channel as _, Device, Line, OpenError, PortSettings, Received, Want, note};
use crate::source::SourceEvent;

/// How long one read waits for bytes.
const TURN: Duration = Duration::from_millis(5);
/// Scans, or readings of odometry, that are enough.
const ENOUGH_SCANS: u64 = 10;
const ENOUGH_ODOMETRIES: u64 = 100;
/// Number of first bytes that are kept, to see whether they are text.
const MOST_KEPT: usize = 256;
/// Bytes of text needed to call it text, and the longest piece of it that is shown.
const ENOUGH_TEXT: usize = 16;
const LONGEST_TEXT: usize = 60;
/// Time for a stop to be sent before the port closes.
const LAST_WORDS: Duration = Duration::from_millis(100);

/// What came from the device.
#[derive(Debug, Default)]
pub(super) struct Visit {
    /// The model that the device reports; empty if none did.
    pub(super) model: String,
    /// Cause and cure of the last fault.
    pub(super) detail: String,
    pub(super) state: DeviceState,
    /// Why the line broke.
    pub(super) broken: Option<String>,
    /// Number of bytes received.
    pub(super) bytes: u64,
    /// The first of them.
    first: Vec<u8>,
    began: Option<Instant>,
    ended: Option<Instant>,
    scans: Vec<(Stamp, usize)>,
    odometries: u64,
    /// Damaged frames and stray bytes.
    damage: [u64; 2],
    /// Damage at the moment when data began: listening that begins in the middle of a frame is not
    /// the line's fault.
    damage_before: [u64; 2],
}

/// Opens the device's line and lets it work: waits up to `to_answer` until it identifies itself,
/// then up to `to_work` until enough data came or it is in fault.
///
/// # Errors    Why the port does not open.
pub(super) fn visit(
    device: &mut dyn Device,
    path: &str,
    to_answer: Duration,
    to_work: Duration,
) -> Result<Visit, OpenError> {
    let mut line = Line::open(&PortSettings {
        path: path.into(),
        baud_rate: device.baud_rate(),
    })?;
    let mut seen = Visit::default();
    let opened = Instant::now();
    let mut until = opened + to_answer;
    let now = || Stamp(opened.elapsed().as_micros() as u64);
    device.opened(now());
    while Instant::now() < until && seen.broken.is_none() && !seen.is_enough() {
        match line.receive(TURN) {
            Received::Bytes(bytes, _) => {
                seen.bytes += bytes.len() as u64;
                let room = MOST_KEPT.saturating_sub(seen.first.len());
                seen.first.extend(bytes.iter().take(room));
                device.receive(&bytes, now());
            }
            Received::Nothing => (),
            Received::Broken(error) => seen.broken = Some(error.to_string()),
        }
        device.tick(now());
        let was_silent = seen.is_silent();
        seen.fulfil(device, &mut line);
        if was_silent && !seen.is_silent() {
            until = Instant::now() + to_work;
        }
    }
    device.close(now());
    seen.fulfil(device, &mut line);
    std::thread::sleep(LAST_WORDS);
    Ok(seen)
}

impl Visit {
    /// How the device worked.
    pub(super) fn measured(&self) -> Measured {
        let seconds = match (self.began, self.ended) {
            (Some(began), Some(ended)) => (ended - began).as_secs_f64(),
            _ => 0.0,
        };
        let turns = self.scans.len().saturating_sub(1) as f64;
        let [first, last] = [self.scans.first(), self.scans.last()]
            .map(|scan| scan.map_or(Stamp(0), |scan| scan.0));
        let ([damaged, skipped], before) = (self.damage, self.damage_before);
        Measured {
            seconds,
            scans: self.scans.len() as u64,
            scans_per_second: if last > first {
                turns / last.since(first)
            } else {
                0.0
            },
            beams: self.scans.last().map_or(0, |scan| scan.1),
            odometries: self.odometries,
            damaged: damaged.saturating_sub(before[0]),
            skipped: skipped.saturating_sub(before[1]),
        }
    }

    /// The first non-empty line of what came, if it is text.
    pub(super) fn text(&self) -> Option<String> {
        let is_text = |byte: &u8| byte.is_ascii_graphic() || byte.is_ascii_whitespace();
        let text = str::from_utf8(&self.first).ok()?;
        let is_text = self.first.len() >= ENOUGH_TEXT && self.first.iter().all(is_text);
        let line = text.lines().map(str::trim).find(|line| !line.is_empty())?;
        is_text.then(|| line.chars().take(LONGEST_TEXT).collect())
    }

    /// Whether neither the device nor its boot loader has said anything.
    fn is_silent(&self) -> bool {
        self.model.is_empty() && self.detail.is_empty()
    }

    fn is_enough(&self) -> bool {
        self.state == DeviceState::Fault
            || self.scans.len() as u64 >= ENOUGH_SCANS
            || self.odometries >= ENOUGH_ODOMETRIES
    }

    fn fulfil(&mut self, device: &mut dyn Device, line: &mut Line) {
        while let Some(want) = device.next_want() {
            match want {
                Want::Write(bytes) => {
                    if let Err(error) = line.send(bytes) {
                        self.broken = Some(error.to_string());
                    }
                }
                Want::Dtr(is_set) => line.set_dtr(is_set),
                Want::Report(event) => self.see(event),
                Want::Note(weight, text) => note(&device.profile().name, weight, &text),
                Want::Well | Want::Reopen => (),
            }
        }
    }

    fn see(&mut self, event: SourceEvent) {
        match event {
            SourceEvent::Device {
                state,
                model,
                detail,
            } => {
                // Keep the fault when the device is then stopped.
                if !(self.state == DeviceState::Fault
                    && detail.is_empty()
                    && state == DeviceState::Waiting)
                {
                    (self.state, self.detail) = (state, detail);
                }
                self.model = model;
            }
            SourceEvent::Link(link) => self.damage = [link.damaged, link.skipped],
            SourceEvent::Scan(scan) => {
                self.data();
                self.scans.push((scan.stamp, scan.len()));
            }
            SourceEvent::Odometry(_) => {
                self.data();
                self.odometries += 1;
            }
            _ => (),
        }
    }

    fn data(&mut self) {
        if self.began.is_none() {
            self.began = Some(Instant::now());
            self.damage_before = self.damage;
        }
        self.ended = Some(Instant::now());
    }
}
