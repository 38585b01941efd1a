//! One slot per robot, with its last messages.

use std::collections::BTreeMap;
use std::time::Duration;

use serde::Serialize;
use slamlab_core::wire::message::{
    DisarmReason, FromBridge, Notice, PoseState, SafetyBody, Severity,
};

/// Most robots that are kept. Others are only counted, and the count is reported.
const MOST: usize = 4096;

/// All robots, by name.
#[derive(Default)]
pub(super) struct Table {
    robots: BTreeMap<String, Robot>,
    revision: u64,
    left_out: u64,
}

/// The last state of a robot. Times are those of reception, µs of this bridge's clock.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub(super) struct Robot {
    name: String,
    /// Whether it is connected to the router.
    here: bool,
    /// When anything was last received.
    heard: u64,
    /// x, y (m), heading (rad), in the map of this robot.
    pose: Option<[f64; 3]>,
    pose_state: Option<PoseState>,
    pose_heard: u64,
    /// Name of its map's file; empty for none, null if it does not map.
    map_file: Option<String>,
    volts: Option<f32>,
    safety: Option<Safety>,
    alert: Option<Alert>,
    /// Address of its page.
    page: Option<String>,
    #[serde(skip)]
    sessions: Vec<String>,
    /// Revision of its last change.
    #[serde(skip)]
    changed: u64,
    /// Revision of the last change of more than what is in [`Moved`].
    #[serde(skip)]
    altered: u64,
}

/// What changes all the time while a robot drives: a fifth of the bytes of the whole slot.
#[derive(Debug, PartialEq, Serialize)]
pub(super) struct Moved {
    name: String,
    heard: u64,
    pose: Option<[f64; 3]>,
    pose_heard: u64,
}

#[derive(Clone, Debug, PartialEq, Serialize)]
struct Safety {
    armed: bool,
    emergency: bool,
    reason: DisarmReason,
    driver: String,
}

#[derive(Clone, Debug, PartialEq, Serialize)]
struct Alert {
    severity: Severity,
    text: String,
    heard: u64,
}

/// The changes since a revision.
#[derive(Debug, Serialize)]
pub(super) struct Changes {
    /// The revision from which to ask next time.
    pub(super) revision: u64,
    /// The present time, µs of this bridge's clock.
    pub(super) now: u64,
    /// Number of robots for which there is no room.
    pub(super) left_out: u64,
    /// Robots that are new, or changed in more than what is in [`Moved`].
    pub(super) robots: Vec<Robot>,
    /// Robots that sent something, but changed in nothing else.
    pub(super) moved: Vec<Moved>,
}

impl Table {
    /// A robot's token appeared: `session` is at the router under this name.
    pub(super) fn came(&mut self, name: &str, session: &str, now: Duration) {
        if !self.robots.contains_key(name) && self.robots.len() >= MOST && !self.forget_one() {
            self.left_out += 1;
            return;
        }
        let robot = self.robots.entry(name.to_owned()).or_default();
        robot.name = name.to_owned();
        robot.here = true;
        robot.heard = micros(now);
        if !robot.sessions.iter().any(|known| known == session) {
            robot.sessions.push(session.to_owned());
        }
        self.revision += 1;
        (robot.changed, robot.altered) = (self.revision, self.revision);
    }

    /// A robot's token disappeared.
    pub(super) fn went(&mut self, name: &str, session: &str) {
        self.change(name, |robot| {
            robot.sessions.retain(|known| known != session);
            robot.here = !robot.sessions.is_empty();
        });
    }

    /// The router is gone, and with it the connection to all robots.
    pub(super) fn all_went(&mut self) {
        self.revision += 1;
        for robot in self.robots.values_mut() {
            robot.sessions.clear();
            robot.here = false;
            (robot.changed, robot.altered) = (self.revision, self.revision);
        }
    }

    /// A robot sent a message; robots without a token are ignored.
    pub(super) fn heard(&mut self, name: &str, message: &FromBridge, now: Duration) {
        let now = micros(now);
        self.change(name, |robot| {
            robot.heard = now;
            match message {
                FromBridge::Safety(state) => robot.safety = Some(state.into()),
                FromBridge::Battery(battery) => robot.volts = Some(battery.volts),
                FromBridge::Mapping(mapping) => robot.map_file = Some(mapping.file.clone()),
                FromBridge::Pose(pose) => {
                    let is_finite = pose.pose.iter().all(|number| number.is_finite());
                    robot.pose = is_finite.then_some(pose.pose.map(rounded));
                    robot.pose_state = Some(pose.state);
                    robot.pose_heard = now;
                }
                FromBridge::Notice(Notice { severity, text }) if *severity != Severity::Info => {
                    robot.alert = Some(Alert {
                        severity: *severity,
                        text: text.clone(),
                        heard: now,
                    });
                }
                _ => (),
            }
        });
    }

    pub(super) fn page(&mut self, name: &str, page: &str) {
        if page.starts_with("http://") || page.starts_with("https://") {
            self.change(name, |robot| robot.page = Some(page.to_owned()));
        }
    }

    /// Changes a known robot, so that the next request gets the change.
    fn change(&mut self, name: &str, change: impl FnOnce(&mut Robot)) {
        if let Some(robot) = self.robots.get_mut(name) {
            let before = robot.clone();
            change(robot);
            self.revision += 1;
            robot.changed = self.revision;
            if !robot.differs_by_motion_alone(before) {
                robot.altered = self.revision;
            }
        }
    }

    /// Whether there is such a robot at the router.
    pub(super) fn has(&self, name: &str) -> bool {
        self.robots.get(name).is_some_and(|robot| robot.here)
    }

    /// Robots at the router.
    pub(super) fn count(&self) -> usize {
        self.robots.values().filter(|robot| robot.here).count()
    }

    /// All changes after `since`; a request with a revision that never was, as after a restart of
    /// the bridge, gets everything.
    pub(super) fn since(&self, since: u64, now: Duration) -> Changes {
        let since = if since > self.revision { 0 } else { since };
        let changed = self.robots.values().filter(|robot| robot.changed > since);
        let (altered, moved): (Vec<&Robot>, Vec<&Robot>) =
            changed.partition(|robot| robot.altered > since);
        Changes {
            revision: self.revision,
            now: micros(now),
            left_out: self.left_out,
            robots: altered.into_iter().cloned().collect(),
            moved: moved.into_iter().map(Robot::moved).collect(),
        }
    }

    /// Makes room by forgetting the robot that has been away longest.
    fn forget_one(&mut self) -> bool {
        let away = self.robots.values().filter(|robot| !robot.here);
        let oldest = away.min_by_key(|robot| robot.heard);
        match oldest.map(|robot| robot.name.clone()) {
            Some(name) => self.robots.remove(&name).is_some(),
            None => false,
        }
    }
}

impl Robot {
    fn moved(&self) -> Moved {
        Moved {
            name: self.name.clone(),
            heard: self.heard,
            pose: self.pose,
            pose_heard: self.pose_heard,
        }
    }

    /// Whether all differences from `before` are in [`Moved`].
    fn differs_by_motion_alone(&self, before: Self) -> bool {
        *self
            == Self {
                heard: self.heard,
                pose: self.pose,
                pose_heard: self.pose_heard,
                changed: self.changed,
                ..before
            }
    }
}

/// Rounds to 0.1 mm and 0.1 mrad: nobody sees more, and a number has 6 digits instead of 17.
fn rounded(number: f64) -> f64 {
    (number * 1e4).round() / 1e4
}

impl From<&SafetyBody> for Safety {
    fn from(state: &SafetyBody) -> Self {
        Self {
            armed: state.armed,
            emergency: state.emergency,
            reason: state.reason,
            driver: state.driver_name.clone(),
        }
    }
}

fn micros(at: Duration) -> u64 {
    u64::try_from(at.as_micros()).unwrap_or(u64::MAX)
}

#[cfg(test)]
mod tests {
    use slamlab_core::wire::message::{BatteryBody, PoseBody};

    use super::*;

    fn at(millis: u64) -> Duration {
        Duration::from_millis(millis)
    }

    fn battery(volts: f32) -> FromBridge {
        let (source, stamp) = (0, 0);
        FromBridge::Battery(BatteryBody {
            source,
            stamp,
            volts,
        })
    }

    #[test]
    fn a_slow_page_gets_the_newest_and_only_what_changed() {
        let mut table = Table::default();
        table.came("a", "1", at(0));
        table.came("b", "2", at(0));
        let first = table.since(0, at(1));
        assert_eq!(first.robots.len(), 2);
        for volts in 0..100_u8 {
            table.heard("b", &battery(f32::from(volts)), at(2));
        }
        let next = table.since(first.revision, at(3));
        let seen: Vec<_> = next.robots.iter().map(|r| (&*r.name, r.volts)).collect();
        assert_eq!(seen, [("b", Some(99.0))]);
        assert!(table.since(next.revision, at(4)).robots.is_empty());
        // The bridge was restarted: its revisions begin anew.
        assert_eq!(table.since(next.revision + 9, at(4)).robots.len(), 2);
    }

    #[test]
    fn who_only_drives_is_told_in_short_and_whatever_else_changes_in_full() {
        let mut table = Table::default();
        table.came("a", "1", at(0));
        table.heard("a", &battery(7.0), at(0));
        let pose = |x, state| {
            FromBridge::Pose(PoseBody {
                stamp: 0,
                pose: [x, 1.0, 2.0],
                cov: [0.0; 6],
                state,
            })
        };
        table.heard("a", &pose(0.0, PoseState::Localised), at(1));
        let mut revision = table.since(0, at(1)).revision;
        let mut next = |table: &Table| {
            let changes = table.since(revision, at(9));
            revision = changes.revision;
            (changes.robots.len(), changes.moved)
        };
        table.heard("a", &pose(3.000_012, PoseState::Localised), at(2));
        let moved = Moved {
            name: "a".into(),
            heard: 2000,
            pose: Some([3.0, 1.0, 2.0]),
            pose_heard: 2000,
        };
        assert_eq!(next(&table), (0, vec![moved]));
        // The same voltage once more is only a sign of life.
        table.heard("a", &battery(7.0), at(3));
        let (altered, moved) = next(&table);
        assert_eq!((altered, moved[0].heard), (0, 3000));
        // The robot moved, but also got lost meanwhile: a page that asked before that gets the
        // whole slot.
        table.heard("a", &pose(4.0, PoseState::Lost), at(4));
        table.heard("a", &pose(5.0, PoseState::Lost), at(5));
        assert_eq!(next(&table), (1, vec![]));
        table.went("a", "1");
        assert_eq!(next(&table), (1, vec![]));
        assert_eq!(next(&table), (0, vec![]));
    }

    #[test]
    fn who_has_no_token_is_not_heard() {
        let mut table = Table::default();
        table.heard("ghost", &battery(7.0), at(0));
        table.page("ghost", "http://127.0.0.1/");
        assert!(table.since(0, at(1)).robots.is_empty());
    }

    #[test]
    fn a_robot_is_away_when_its_last_token_goes() {
        let mut table = Table::default();
        table.came("a", "1", at(0));
        table.came("a", "2", at(0));
        table.went("a", "1");
        assert!(table.has("a"));
        table.went("a", "2");
        assert!(!table.has("a"));
        assert_eq!(table.since(0, at(1)).robots.len(), 1, "it is still shown");
    }

    #[test]
    fn of_too_many_the_one_away_longest_goes_and_none_that_is_here() {
        let mut table = Table::default();
        for number in 0..MOST {
            table.came(&format!("r{number}"), "1", at(number as u64));
        }
        table.came("late", "1", at(9000));
        assert!(!table.has("late"));
        assert_eq!(table.since(0, at(9000)).left_out, 1);
        table.went("r7", "1");
        table.came("late", "1", at(9001));
        assert!(table.has("late"));
        assert_eq!(table.count(), MOST);
    }

    #[test]
    fn a_pose_that_is_no_number_and_a_page_that_is_none_are_not_shown() {
        let mut table = Table::default();
        table.came("a", "1", at(0));
        let pose = |x| {
            FromBridge::Pose(PoseBody {
                stamp: 0,
                pose: [x, 1.0, 2.0],
                cov: [0.0; 6],
                state: PoseState::Localised,
            })
        };
        table.heard("a", &pose(3.0), at(1));
        table.page("a", "javascript:alert(1)");
        let robot = table.since(0, at(1)).robots.remove(0);
        assert_eq!(
            (robot.pose, robot.page.as_deref()),
            (Some([3.0, 1.0, 2.0]), None)
        );
        table.heard("a", &pose(f64::NAN), at(2));
        assert_eq!(table.since(0, at(1)).robots[0].pose, None);
    }
}
