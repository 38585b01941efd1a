//! The mapper's thread: takes the hub's messages, maps, and publishes its results.

use std::sync::Arc;
use std::sync::mpsc::Receiver;
use std::time::Duration;

use slamlab_core::estimation::SavedMap;
use slamlab_core::format::map_server::{MapMode, OccupancyMap};
use slamlab_core::live::{Homing, Live, Note};
use slamlab_core::slam::Method;
use slamlab_core::wire::message::{
    BridgeHello, Format, FromBridge, Header, MapBody, MappingBody, Severity, ToBridge, decode,
    encode,
};
use tokio::sync::{mpsc, watch};

use super::keeper::{Keeper, packed};
use super::{Asked, Ready, Shown};
use crate::clock::Clock;
use crate::hub::FromClient;
use crate::hub::outbox::{Next, Outbox};
use crate::record::ros::MOST_CELLS;
use crate::safety::ClientId;

/// Interval between checks of what is due.
const TICK: Duration = Duration::from_millis(50);
/// Interval between published maps; twenty times what one map takes, if that is longer.
const MAP_EVERY: Duration = Duration::from_secs(1);
const MAP_SHARE: u32 = 20;
/// Interval between reports of its state.
const REPORT: Duration = Duration::from_secs(1);

/// The mapper's way to the hub, for a robot that goes home.
#[derive(Debug)]
pub(crate) struct ToHub {
    pub(crate) client: ClientId,
    pub(crate) hub: mpsc::Sender<FromClient>,
}

impl ToHub {
    /// A message that finds no room at the hub is dropped: if the messages that drive the robot are
    /// not repeated, it stops.
    fn say(&self, what: FromClient) {
        let _ = self.hub.try_send(what);
    }
}

/// See the module.
pub(super) struct Mapper {
    live: Live,
    homing: Option<Homing>,
    next_tick: Duration,
    outbox: Arc<Outbox>,
    to_hub: ToHub,
    clock: Clock,
    shown: watch::Sender<Shown>,
    asks: Receiver<Asked>,
    keeper: Option<Keeper>,
    /// The fault that all clients were told last.
    fence_fault: Option<String>,
    save_every: Duration,
    sequence: u32,
    /// Number of scans up to which pose and map were published.
    posed: usize,
    drawn: usize,
    revision: u64,
    /// It was logged that the map is too large for other tools.
    is_large: bool,
    /// Number of scans in the last map handed to the keeper.
    handed: usize,
    next_map: Duration,
    next_report: Duration,
    next_save: Duration,
}

impl Mapper {
    pub(super) fn new(
        ready: Ready,
        outbox: Arc<Outbox>,
        to_hub: ToHub,
        clock: Clock,
        shown: watch::Sender<Shown>,
        asks: Receiver<Asked>,
    ) -> Self {
        let now = clock.now();
        Self {
            live: ready.live,
            homing: ready.home.map(|home| Homing::new(home.when)),
            next_tick: now,
            outbox,
            to_hub,
            clock,
            shown,
            asks,
            keeper: ready.keeper,
            fence_fault: None,
            save_every: ready.save_every,
            sequence: 0,
            posed: 0,
            drawn: 0,
            revision: 0,
            is_large: false,
            handed: 0,
            next_map: now,
            next_report: now,
            next_save: now + ready.save_every,
        }
    }

    /// Maps until the outbox is closed; then the map is written.
    pub(super) fn run(mut self, hello: BridgeHello) {
        self.receive(&FromBridge::Hello(hello));
        // A loaded map is there before the first scan.
        self.show_map();
        loop {
            match self.outbox.next_within(TICK) {
                Some(Next::Message(message)) => self.receive(&message),
                Some(Next::Close(_)) => break,
                None => (),
            }
            while let Ok(asked) = self.asks.try_recv() {
                self.obey(asked);
            }
            self.drive();
            self.show();
        }
        self.finish();
    }

    /// Receives a message as a page would.
    fn receive(&mut self, message: &FromBridge) {
        self.sequence = self.sequence.wrapping_add(1);
        let now = self.clock.now().as_micros() as u64;
        let header = Header {
            sequence: self.sequence,
            micros: now,
        };
        let received = encode(header, message, Format::Binary)
            .map_err(|error| error.to_string())
            .and_then(|bytes| {
                let received = self.live.receive(now, &bytes);
                received.map_err(|error| error.to_string())
            });
        if let Err(why) = received {
            tracing::warn!("mapping: a message was left out: {why}");
        }
        self.flush();
        for note in self.live.take_notes() {
            tracing::info!("mapping: {}", note.text);
        }
    }

    /// Lets the robot go home, if it may.
    fn drive(&mut self) {
        let now = self.clock.now();
        let Some(homing) = self.homing.as_mut().filter(|_| now >= self.next_tick) else {
            return;
        };
        self.next_tick = now + TICK;
        let micros = now.as_micros() as u64;
        if let Some(Note { severity, text }) = homing.step(micros, &mut self.live) {
            self.to_hub.say(FromClient::Notice(severity, text));
        }
        // A silent hub is only busy, because it is in the same program: ignore the timeout.
        let _ = self.live.tick(micros);
        self.flush();
    }

    /// Sends what drives the robot. The messages that keep a connection alive are not needed with
    /// the program's own hub.
    fn flush(&mut self) {
        for bytes in self.live.take_outgoing() {
            let Ok((header, message)) = decode::<ToBridge>(&bytes, Format::Binary) else {
                continue;
            };
            if matches!(
                message,
                ToBridge::Hello(_) | ToBridge::Heartbeat | ToBridge::Probe { .. }
            ) {
                continue;
            }
            let (client, now) = (self.to_hub.client, self.clock.now());
            self.to_hub
                .say(FromClient::Message(client, header, message, now));
        }
    }

    fn obey(&mut self, asked: Asked) {
        match asked {
            Asked::Reset => {
                let unsaved = self.unsaved();
                self.live.begin_anew();
                if let Some(keeper) = &mut self.keeper {
                    keeper.move_aside(unsaved);
                }
                (self.posed, self.drawn, self.handed) = (0, 0, 0);
                self.next_save = self.clock.now() + self.save_every;
                self.show_map();
                self.report();
            }
            Asked::Fence(zones) => {
                let unsaved = self.unsaved();
                if let Some(keeper) = &self.keeper {
                    keeper.fence(unsaved, zones);
                }
            }
            Asked::Pack(answer) => {
                let (map, title) = (self.saved_map(), self.title());
                let method = self.live.session().slam().method();
                // Packing takes long, and must not delay the next scan.
                std::thread::spawn(move || {
                    let bytes = match map {
                        Some(map) => packed(title, vec![], map),
                        None if method != Method::ScanMatching => Err(format!(
                            "only scan-matching has such a file, not {}",
                            method.name()
                        )),
                        None => Err("nothing is mapped yet".to_owned()),
                    };
                    // The client that asked may be gone.
                    let _ = answer.send(bytes);
                });
            }
        }
    }

    fn show(&mut self) {
        let now = self.clock.now();
        let scans = self.live.session().scans();
        if scans != self.posed {
            self.posed = scans;
            let pose = self
                .live
                .pose()
                .map(|pose| Arc::new(FromBridge::Pose(pose)));
            self.shown.send_modify(|shown| shown.pose = pose);
        }
        if scans != self.drawn && now >= self.next_map {
            self.show_map();
            let took = self.clock.now().saturating_sub(now);
            self.next_map = now + MAP_EVERY.max(MAP_SHARE * took);
        }
        if now >= self.next_save {
            self.next_save = now + self.save_every;
            self.save();
        }
        if now >= self.next_report {
            self.next_report = now + REPORT;
            self.report();
        }
    }

    /// Publishes the map, if it has changed.
    fn show_map(&mut self) {
        let session = self.live.session();
        self.drawn = session.scans();
        // None if the map has no known cell, or is too large.
        let cells = OccupancyMap::of_grid(session.slam().grid(), MapMode::Trinary).ok();
        let body = cells
            .as_ref()
            .map_or_else(MapBody::default, |cells| MapBody::new(0, cells));
        let is_same = match self.shown.borrow().map.as_deref() {
            Some(FromBridge::Map(before)) => {
                let revision = body.revision;
                MapBody {
                    revision,
                    ..before.clone()
                } == body
            }
            _ => cells.is_none(),
        };
        if is_same {
            return;
        }
        let count = cells.as_ref().map_or(0, |cells| cells.cells.len());
        if count > MOST_CELLS && !std::mem::replace(&mut self.is_large, true) {
            tracing::warn!(
                "the map has {count} cells: Foxglove and rosbridge are sent none of more than {MOST_CELLS}"
            );
        }
        self.revision += 1;
        let revision = self.revision;
        let map = Arc::new(FromBridge::Map(MapBody { revision, ..body }));
        self.shown.send_modify(|shown| {
            shown.map = Some(map);
            shown.cells = cells.map(|cells| (revision, Arc::new(cells)));
        });
    }

    fn report(&mut self) {
        let session = self.live.session();
        let kept = self.keeper.as_ref().map(Keeper::kept).unwrap_or_default();
        // A notice, so that whoever drew the fence sees it wherever they look.
        if kept.fence_fault != self.fence_fault {
            let (severity, text) = match &kept.fence_fault {
                Some(why) => (Severity::Error, format!("{why}.")),
                None => (Severity::Info, "The geofence is kept now.".to_owned()),
            };
            self.to_hub.say(FromClient::Notice(severity, text));
            self.fence_fault.clone_from(&kept.fence_fault);
        }
        let body = FromBridge::Mapping(MappingBody {
            method: session.slam().method().name().to_owned(),
            scans: session.scans() as u64,
            file: self.file_name(),
            saved: kept.scans,
            fault: kept.fault.or(kept.fence_fault),
        });
        let is_same = self.shown.borrow().mapping.as_deref() == Some(&body);
        if !is_same {
            let mapping = Some(Arc::new(body));
            self.shown.send_modify(|shown| shown.mapping = mapping);
        }
    }

    fn file_name(&self) -> String {
        let keeper = self.keeper.as_ref();
        keeper.map_or(String::new(), |keeper| keeper.name.clone())
    }

    fn title(&self) -> String {
        let name = self.file_name();
        name.strip_suffix(".slamlab").unwrap_or(&name).to_owned()
    }

    /// Hands the map to the keeper if it holds scans that the keeper does not have.
    fn save(&mut self) {
        let Some((map, scans)) = self.unsaved() else {
            return;
        };
        // A map that could not be written is handed over again.
        if let Some(keeper) = &self.keeper
            && keeper.save(map, scans)
            && keeper.kept().fault.is_none()
        {
            self.handed = scans as usize;
        }
    }

    /// The map, if it holds scans of this run that are not in the file. An empty map never replaces
    /// one that holds something.
    fn unsaved(&self) -> Option<(SavedMap, u64)> {
        self.keeper.as_ref()?;
        let scans = self.live.session().scans();
        if scans == self.handed {
            return None;
        }
        self.saved_map().map(|map| (map, scans as u64))
    }

    fn saved_map(&self) -> Option<SavedMap> {
        let slam = self.live.session().slam();
        let holds_something = slam.view().map?.trajectory().next().is_some();
        let times = self.keeper.as_ref().map(|keeper| keeper.times.clone());
        slam.saved_map(times.unwrap_or_default())
            .filter(|_| holds_something)
    }

    fn finish(mut self) {
        let last = self.unsaved();
        if let Some(keeper) = self.keeper.take() {
            let name = keeper.name.clone();
            let kept = keeper.finish(last);
            match kept.fault {
                None => tracing::info!("{name}: {} scans of this run", kept.scans),
                Some(why) => tracing::error!("{why}"),
            }
        }
    }
}
