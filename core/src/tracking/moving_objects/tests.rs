//! A lidar of 360 beams in a room of 8 by 8 m with a pillar, whose map grows with each scan.

use super::*;
use crate::geom::unit_vector;
use crate::map::{CellState, GridConfig};
use crate::points::fixture::{beam, scan_of};

const HALF: f64 = 4.0;
const PILLAR: (f64, f64, f64) = (1.5, -1.5, 0.2);
const STEP: f64 = 0.2;
type Disc = (f64, f64, f64);

/// Distance to the first thing along a unit direction, m.
fn range(from: Point2<f64>, along: Vector2<f64>, discs: &[Disc]) -> f64 {
    let side = |at: f64, along: f64| match along {
        a if a.abs() < 1e-12 => f64::INFINITY,
        a => (HALF * a.signum() - at) / a,
    };
    let to_disc = |&(x, y, radius): &Disc| {
        let to = Point2::new(x, y) - from;
        let middle = to.dot(&along);
        let root = radius * radius - (to.norm_squared() - middle * middle);
        match root < 0.0 || middle < 0.0 {
            true => f64::INFINITY,
            false => middle - root.sqrt(),
        }
    };
    let walls = side(from.x, along.x).min(side(from.y, along.y));
    discs.iter().map(to_disc).fold(walls, f64::min)
}

fn sweep(pose: &Pose2, person: Option<Disc>, number: usize) -> Points {
    let discs: Vec<Disc> = std::iter::once(PILLAR).chain(person).collect();
    let see = |beam_idx: usize| {
        let local = unit_vector((beam_idx as f64 - 180.0).to_radians());
        let far = range(pose.position(), pose.rotate(local), &discs);
        beam(beam_idx, Point2::origin(), Point2::from(local * far), true)
    };
    Points {
        stamp: Stamp::from_seconds(STEP * number as f64),
        ..scan_of((0..360).map(see))
    }
}

/// A run in which the true pose is known except for `error`, and its results.
struct Run {
    moving: MovingObjects,
    grid: Grid,
    pose: Pose2,
    number: usize,
}

impl Run {
    fn new(config: TrackingConfig) -> Self {
        Self {
            moving: MovingObjects::new(config),
            grid: Grid::new(GridConfig::default()).unwrap(),
            pose: Pose2::identity(),
            number: 0,
        }
    }

    /// Takes a scan after a step, placed wrongly by `error`; returns the numbers of the beams that
    /// were taken out.
    fn step(&mut self, step: &Pose2, person: Option<Disc>, error: &Pose2) -> Vec<usize> {
        self.pose = self.pose * *step;
        let mut points = sweep(&self.pose, person, self.number);
        let map_from_robot = self.pose * *error;
        let (moving, grid) = (&mut self.moving, &self.grid);
        let out = moving
            .taken_out(&points, step, grid, &map_from_robot)
            .to_vec();
        let matched = Matched {
            motion: None,
            cov: Matrix3::from_diagonal_element(1e-4),
        };
        moving.update(&points, step, grid, &map_from_robot, &matched);
        points.beams.retain(|beam| !out.contains(&beam.beam_idx));
        self.grid.insert(&points, &map_from_robot);
        self.number += 1;
        out
    }

    fn moving(&self) -> Vec<Track> {
        let tracks = self.moving.tracks().iter().copied();
        tracks.filter(|t| t.motion == TrackMotion::Moving).collect()
    }

    fn is_occupied(&self, x: f64, y: f64) -> bool {
        self.grid.state(self.grid.cell_at(Point2::new(x, y))) == CellState::Occupied
    }
}

/// The defaults, and moving objects are kept out.
fn keeping_out() -> TrackingConfig {
    TrackingConfig {
        keeps_out: true,
        ..TrackingConfig::default()
    }
}

#[test]
fn who_walks_is_followed_and_kept_out_by_each_association() {
    for (name, association, _) in TrackAssociation::ALL {
        let mut run = Run::new(TrackingConfig {
            association,
            ..keeping_out()
        });
        let still = Pose2::identity();
        let drive = Pose2::new(0.03, 0.0, 0.02);
        for _ in 0..10 {
            assert_eq!(
                run.step(&drive, None, &still),
                [0; 0],
                "{name}: nobody is there"
            );
        }
        let (mut ids, mut out, mut theirs) = (vec![], 0, 0);
        for number in 0..24 {
            let at = (2.0, 2.8 - 0.16 * number as f64, 0.22);
            let taken = run.step(&drive, Some(at), &still);
            let is_theirs = |beam: &usize| {
                let local = unit_vector((*beam as f64 - 180.0).to_radians());
                let (from, along) = (run.pose.position(), run.pose.rotate(local));
                range(from, along, &[PILLAR, at]) < range(from, along, &[PILLAR]) - 1e-9
            };
            let behind = !(0..360).any(|beam| is_theirs(&beam));
            if number < 8 || behind {
                continue;
            }
            assert!(
                taken.iter().filter(|b| !is_theirs(b)).count() <= 12,
                "{name}: {taken:?}"
            );
            theirs += (0..360).filter(is_theirs).count();
            out += taken.iter().filter(|b| is_theirs(b)).count();
            let [track] = run.moving()[..] else {
                panic!("{name}, {number}: {:?}", run.moving.tracks());
            };
            ids.push(track.id);
            let off = run.pose * track.position - Point2::new(at.0, at.1);
            assert!(off.length() < 0.15, "{name}: {off}");
            let velocity = run.pose.rotate(track.velocity);
            assert!(
                (velocity - Vector2::new(0.0, -0.8)).length() < 0.5,
                "{name}, {number}: {velocity}"
            );
        }
        ids.dedup();
        assert_eq!(ids.len(), 1, "{name}: {ids:?}");
        assert!(
            out as f64 > 0.9 * theirs as f64,
            "{name}: {out} of {theirs}"
        );
    }
}

#[test]
fn a_pose_that_is_off_makes_nobody_walk_and_drops_no_wall() {
    for error in [
        Pose2::new(0.3, 0.1, 0.0),
        Pose2::new(0.0, 0.0, 0.12),
        Pose2::new(-0.2, 0.2, -0.08),
    ] {
        let mut run = Run::new(keeping_out());
        let drive = Pose2::new(0.02, 0.0, 0.03);
        for number in 0..80 {
            let is_off = (30..34).contains(&number) || number >= 50;
            let error = if is_off { error } else { Pose2::identity() };
            let out = run.step(&drive, None, &error);
            assert!(run.moving().is_empty(), "{number}: {:?}", run.moving());
            assert!(out.is_empty(), "{number}: {out:?}");
        }
    }
}

#[test]
fn what_was_put_down_is_mapped_and_who_stops_is_later() {
    let still = Pose2::identity();
    let mut run = Run::new(TrackingConfig {
        memory: 6.0,
        ..keeping_out()
    });
    for _ in 0..10 {
        run.step(&still, None, &still);
    }
    for _ in 0..40 {
        assert_eq!(run.step(&still, Some((2.0, 1.0, 0.2)), &still), [0; 0]);
    }
    // As seen from the sensor at the origin.
    let front = Vector2::new(2.0, 1.0).normalize() * (5.0_f64.sqrt() - 0.2);
    assert!(run.is_occupied(front.x, front.y));

    // Walks for two seconds and a half, then stands.
    let walker = |number: usize| Some((-0.8 + 0.14 * number.min(12) as f64, 2.0, 0.2));
    let out: Vec<bool> = (0..80)
        .map(|number| !run.step(&still, walker(number), &still).is_empty())
        .collect();
    assert!(out[8..38].iter().all(|out| *out), "{out:?}");
    assert!(!out[60..].iter().any(|out| *out), "{out:?}");
}

#[test]
fn it_can_be_switched_off_and_begins_anew_after_a_pause() {
    let still = Pose2::identity();
    let mut run = Run::new(keeping_out());
    for number in 0..25 {
        let at = (2.0, 2.0 - 0.16 * number.max(10) as f64, 0.22);
        run.step(&still, (number >= 10).then_some(at), &still);
    }
    assert_eq!(run.moving().len(), 1);
    run.moving.reconfigure(TrackingConfig {
        is_on: false,
        ..keeping_out()
    });
    assert!(run.moving.tracks().is_empty());
    run.moving.reconfigure(keeping_out());
    run.number += 100;
    assert_eq!(run.step(&still, None, &still), [0; 0]);
    assert!(run.moving.tracks().is_empty());
}
