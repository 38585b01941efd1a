//! Velocities from other tools, and how old they are.

use std::collections::BTreeMap;
use std::time::Duration;

use slamlab_core::robot::{Command, Stamp};
use slamlab_core::wire::ClockMap;

use super::attachment::Attachment;
use super::names::Gid;

/// Most publishers of velocities that are told apart.
const MOST: usize = 8;

/// Reads the speeds of a `geometry_msgs/Twist`, after a header if it is stamped; none if the bytes
/// are not one. Components that a robot on a plane cannot follow are left out.
pub(super) fn velocity(cdr: &[u8], is_stamped: bool) -> Option<Command> {
    // Encapsulation: CDR, little-endian. Alignment counts from its end.
    let body = cdr.strip_prefix(&[0, 1])?.get(2..)?;
    let at = match is_stamped {
        false => 0,
        // Time, then the frame with its closing zero.
        true => {
            let length = body.get(8..)?.first_chunk().copied()?;
            let end = 12_usize.checked_add(u32::from_le_bytes(length) as usize)?;
            end.checked_next_multiple_of(8)?
        }
    };
    let number = |place: usize| {
        let bytes = body.get(at..)?.get(8 * place..)?.first_chunk()?;
        Some(f64::from_le_bytes(*bytes))
    };
    let [forward, _, _, _, _, turn] = [
        number(0)?,
        number(1)?,
        number(2)?,
        number(3)?,
        number(4)?,
        number(5)?,
    ];
    (forward.is_finite() && turn.is_finite()).then_some(Command::Velocity { forward, turn })
}

/// When messages were sent, by the bridge's clock.
///
/// Clocks are not compared. For each publisher the least delay so far counts as zero, and a message
/// that took longer is older by the difference ([`ClockMap`]). This cannot detect a publisher that
/// was late from its first message on; but its silence is detected.
#[derive(Debug, Default)]
pub(super) struct Ages(BTreeMap<Gid, Publisher>);

#[derive(Debug)]
struct Publisher {
    clock: ClockMap,
    sequence: i64,
    nanos: i64,
    heard: Duration,
}

impl Ages {
    /// When a message was sent, µs of the bridge's clock; none if its number repeats or is older
    /// than an earlier one, or its time is older.
    pub(super) fn said(&mut self, of: Attachment, now: Duration) -> Option<u64> {
        let said = Stamp(u64::try_from(of.nanos).ok()? / 1000);
        let came = Stamp(now.as_micros() as u64);
        if self.0.len() >= MOST && !self.0.contains_key(&of.gid) {
            let oldest = self.0.iter().min_by_key(|(_, publisher)| publisher.heard);
            let oldest = oldest.map(|(gid, _)| *gid);
            oldest.and_then(|gid| self.0.remove(&gid));
        }
        let publisher = self.0.entry(of.gid).or_insert_with(|| Publisher {
            clock: ClockMap::new(0.0),
            sequence: i64::MIN,
            nanos: i64::MIN,
            heard: now,
        });
        if of.sequence <= publisher.sequence || of.nanos < publisher.nanos {
            return None;
        }
        (publisher.sequence, publisher.nanos) = (of.sequence, of.nanos);
        publisher.heard = now;
        publisher.clock.observe(said, came);
        let host = publisher.clock.host_time(said)?;
        Some(host.min(came).0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn twist(head: &[u8]) -> Vec<u8> {
        let numbers = [0.1, 0.0, 0.0, 0.0, 0.0, -0.5_f64];
        let body = numbers.iter().flat_map(|number| number.to_le_bytes());
        [0, 1, 0, 0]
            .into_iter()
            .chain(head.iter().copied())
            .chain(body)
            .collect()
    }

    #[test]
    fn forward_and_turn_are_read_behind_a_header_too() {
        let expect = Some(Command::Velocity {
            forward: 0.1,
            turn: -0.5,
        });
        assert_eq!(velocity(&twist(&[]), false), expect);
        // 8 bytes of time, 4 of length, `ab` and a zero, one of padding.
        let head = [1, 0, 0, 0, 2, 0, 0, 0, 3, 0, 0, 0, b'a', b'b', 0, 0];
        assert_eq!(velocity(&twist(&head), true), expect);
    }

    #[test]
    fn what_is_no_twist_is_none() {
        let whole = twist(&[]);
        for cut in 0..whole.len() {
            assert_eq!(velocity(&whole[..cut], false), None, "{cut}");
        }
        let long = [0, 0, 0, 0, 0, 0, 0, 0, 255, 255, 255, 255];
        assert_eq!(velocity(&twist(&long), true), None);
        let mut big_endian = whole.clone();
        big_endian[1] = 0;
        assert_eq!(velocity(&big_endian, false), None);
        let mut endless = whole;
        endless[4..12].copy_from_slice(&f64::INFINITY.to_le_bytes());
        assert_eq!(velocity(&endless, false), None);
    }

    #[test]
    fn what_waited_on_the_way_is_as_old_as_it_waited_longer_than_others() {
        let mut ages = Ages::default();
        let at = |sequence: i64, millis: u64| {
            let sent = Duration::from_secs(1_700_000_000) + Duration::from_millis(millis);
            Attachment::new(sequence, sent, [1; 16])
        };
        let bridge = |millis: u64| Duration::from_millis(5000 + millis);
        for k in 0..100 {
            let said = ages
                .said(at(k, 50 * k as u64), bridge(50 * k as u64 + 3))
                .unwrap();
            assert!(said.abs_diff(bridge(50 * k as u64 + 3).as_micros() as u64) < 100);
        }
        let late = ages.said(at(100, 5000), bridge(5503)).unwrap();
        assert!(
            late.abs_diff(bridge(5003).as_micros() as u64) < 30_000,
            "{late}"
        );
        assert_eq!(ages.said(at(100, 5050), bridge(5504)), None, "a repetition");
        assert_eq!(ages.said(at(101, 4000), bridge(5504)), None, "from before");
    }
}
