//! The state of a device and its line, reported only when it changes; the line once a second too.

use crate::robot::Stamp;
use crate::wire::Tally;
use crate::wire::message::{DeviceState, LinkBody, LinkState};

use crate::device::source::SourceEvent;

/// Seconds between two reports of a line that does not change.
const NOW_AND_THEN: f64 = 1.0;

/// State of a device and its line, as last reported.
#[derive(Debug)]
pub(super) struct Report {
    /// What the device is, as it said itself.
    pub(super) model: String,
    /// For a fault: cause and cure.
    pub(super) detail: String,
    /// As last reported.
    last: Option<(DeviceState, String, String)>,
    link: LinkBody,
    /// Counts of lines before this one: each line's decoder begins at 0.
    earlier: [u64; 2],
    link_reported: Stamp,
}

impl Default for Report {
    fn default() -> Self {
        Self {
            model: String::new(),
            detail: String::new(),
            last: None,
            link: LinkBody::new(LinkState::Down),
            earlier: [0; 2],
            link_reported: Stamp(0),
        }
    }
}

impl Report {
    /// A new line: its decoder counts from 0.
    pub(super) fn reopened(&mut self) {
        self.earlier = [self.link.damaged, self.link.skipped];
    }

    /// What became of the line's bytes so far.
    pub(super) fn count(&mut self, tally: Tally) {
        let [damaged, skipped] = self.earlier;
        self.link.damaged = damaged + tally.rejected;
        self.link.skipped = skipped + tally.discarded;
    }

    /// The events of a change, if it is one.
    pub(super) fn change(
        &mut self,
        state: DeviceState,
        link: LinkState,
    ) -> impl Iterator<Item = SourceEvent> + use<> {
        let now = (state, self.model.clone(), self.detail.clone());
        let device = (self.last.as_ref() != Some(&now)).then(|| SourceEvent::Device {
            state,
            model: now.1.clone(),
            detail: now.2.clone(),
        });
        let link = self.change_link(link);
        self.last = Some(now);
        link.into_iter().chain(device)
    }

    /// The events of a line that broke, or could not be opened; `why` says cause and cure.
    pub(super) fn broken(&mut self, why: String) -> impl Iterator<Item = SourceEvent> + use<> {
        self.detail = why;
        self.change(DeviceState::Waiting, LinkState::Down)
    }

    /// The event of a change of the line, if it is one.
    pub(super) fn change_link(&mut self, link: LinkState) -> Option<SourceEvent> {
        let has_changed = self.link.state != link;
        self.link.state = link;
        has_changed.then_some(SourceEvent::Link(self.link))
    }

    /// The line, once a second.
    pub(super) fn link_now_and_then(&mut self, now: Stamp) -> Option<SourceEvent> {
        (now.since(self.link_reported) >= NOW_AND_THEN).then(|| {
            self.link_reported = now;
            SourceEvent::Link(self.link)
        })
    }

    /// Sets how long an acknowledgement takes, s.
    pub(super) fn set_round_trip(&mut self, seconds: f64) {
        self.link.round_trip = Some(seconds as f32);
    }
}
