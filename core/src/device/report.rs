//! What a device wants done, and the state of device and line. State is reported only when it
//! changes; that of the line also once a second.

use std::collections::VecDeque;

use crate::robot::Stamp;
use crate::wire::Tally;
use crate::wire::message::{DeviceState, LinkBody, LinkState};

use crate::device::line::{Want, Weight};
use crate::device::source::SourceEvent;

/// Seconds between two reports of a line that does not change.
const NOW_AND_THEN: f64 = 1.0;

/// What a device wants done, in order; and its own state and that of its line, as last reported.
#[derive(Debug, Default)]
pub(super) struct Report {
    wants: VecDeque<Want>,
    /// The device's description of itself; reported with the next change.
    pub(super) model: String,
    /// For a fault: cause and cure; reported with the next change.
    pub(super) detail: String,
    /// As last reported.
    last: Option<(DeviceState, String, String)>,
    link: LinkBody,
    /// Counts of earlier lines: each line's decoder begins at 0.
    earlier: [u64; 2],
    link_reported: Stamp,
}

impl Report {
    /// Adds something to be done after all earlier wants.
    pub(super) fn want(&mut self, want: Want) {
        self.wants.push_back(want);
    }

    /// Wants bytes written.
    pub(super) fn write(&mut self, bytes: Vec<u8>) {
        self.want(Want::Write(bytes));
    }

    /// Reports an event.
    pub(super) fn emit(&mut self, event: SourceEvent) {
        self.want(Want::Report(event));
    }

    /// Writes into the log of the owner of the line.
    pub(super) fn note(&mut self, weight: Weight, text: String) {
        self.want(Want::Note(weight, text));
    }

    /// The next thing to do.
    pub(super) fn next_want(&mut self) -> Option<Want> {
        self.wants.pop_front()
    }

    /// A new line: its decoder counts from 0.
    pub(super) fn reopened(&mut self) {
        self.earlier = [self.link.damaged, self.link.skipped];
    }

    /// Takes the counts of the line's bytes so far.
    pub(super) fn count(&mut self, tally: Tally) {
        let [damaged, skipped] = self.earlier;
        self.link.damaged = damaged + tally.rejected;
        self.link.skipped = skipped + tally.discarded;
    }

    /// Reports device and line if either has changed.
    pub(super) fn change(&mut self, state: DeviceState, link: LinkState) {
        self.change_link(link);
        let now = Some((state, self.model.clone(), self.detail.clone()));
        if self.last != now {
            self.last = now;
            self.emit(SourceEvent::Device {
                state,
                model: self.model.clone(),
                detail: self.detail.clone(),
            });
        }
    }

    /// The line broke, or could not be opened; `why` names cause and cure. Its pending wants are
    /// dropped.
    pub(super) fn broken(&mut self, why: String) {
        self.wants.clear();
        self.detail = why;
        self.change(DeviceState::Waiting, LinkState::Down);
    }

    /// Reports the line if its state has changed.
    pub(super) fn change_link(&mut self, link: LinkState) {
        if self.link.state != link {
            self.link.state = link;
            self.emit(SourceEvent::Link(self.link));
        }
    }

    /// Reports the line, once a second.
    pub(super) fn link_now_and_then(&mut self, now: Stamp) {
        if now.since(self.link_reported) >= NOW_AND_THEN {
            self.link_reported = now;
            self.emit(SourceEvent::Link(self.link));
        }
    }

    /// Sets how long an acknowledgement takes, s.
    pub(super) fn set_round_trip(&mut self, seconds: f64) {
        self.link.round_trip = Some(seconds as f32);
    }
}
