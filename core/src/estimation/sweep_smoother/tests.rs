use nalgebra::{DMatrix, DVector, Matrix3};

use super::*;
use crate::robot::Odometry;

/// The unit of time, µs: odometry comes every second grain, beams and fixes fall on grains.
const GRAIN_MICROS: u64 = 5_000;
const BEAMS: usize = 9;
/// Grains from the first beam of a sweep to its last.
const SWEEP: usize = 16;

fn stamp(grain: usize) -> Stamp {
    Stamp(1_000_000 + grain as u64 * GRAIN_MICROS)
}

fn smooth(
    smoother: &mut SweepSmoother,
    scan: &Scan,
    fixes: &[Fix],
    history: &MotionHistory,
) -> Vec<BeamPose> {
    smoother.smooth(scan, &history.since_beams(scan), fixes, history)
}

/// What a robot that only turns measures: odometry by grains, and where walls were recognised.
struct Drive {
    /// Rotation and its variance in each grain; both halves of a reading are alike.
    turns: Vec<(f64, f64)>,
    /// Grain, heading, variance.
    walls: Vec<(usize, f64, f64)>,
}

impl Drive {
    /// All headings given all measurements, by one least-squares problem: an independent ground
    /// truth.
    fn batch(&self) -> (DVector<f64>, DMatrix<f64>) {
        let n = self.turns.len() + 1;
        let (mut information, mut vector) = (DMatrix::zeros(n, n), DVector::zeros(n));
        // Known at the start.
        information[(0, 0)] = 1e14;
        for (i, (turn, variance)) in self.turns.iter().enumerate() {
            let w = 1.0 / variance;
            information[(i, i)] += w;
            information[(i + 1, i + 1)] += w;
            information[(i, i + 1)] -= w;
            information[(i + 1, i)] -= w;
            vector[i] -= w * turn;
            vector[i + 1] += w * turn;
        }
        for &(grain, heading, variance) in &self.walls {
            information[(grain, grain)] += 1.0 / variance;
            vector[grain] += heading / variance;
        }
        let cov = information.try_inverse().unwrap();
        (&cov * vector, cov)
    }

    fn odometry(&self, reading: usize) -> Odometry {
        let (a, b) = (self.turns[2 * reading], self.turns[2 * reading + 1]);
        let mut cov = Matrix3::zeros();
        cov[(2, 2)] = a.1 + b.1;
        Odometry {
            from: stamp(2 * reading),
            to: stamp(2 * reading + 2),
            motion: Pose2::new(0.0, 0.0, a.0 + b.0),
            cov,
        }
    }

    /// The drive up to a grain.
    fn until(&self, grain: usize) -> Self {
        Self {
            turns: self.turns[..grain].to_vec(),
            walls: self
                .walls
                .iter()
                .copied()
                .filter(|w| w.0 <= grain)
                .collect(),
        }
    }
}

fn drive() -> Drive {
    let reading = |i: usize| {
        let i = i as f64;
        (
            0.01 + 0.004 * libm::sin(2.0 * i),
            4e-5 * (1.2 + libm::sin(3.0 * i)),
        )
    };
    Drive {
        turns: (0..2 * SWEEP + 4).map(|grain| reading(grain / 2)).collect(),
        // The third one lies between the sweeps' beams, the last one at the very end of a beam.
        walls: vec![
            (5, 0.09, 3e-5),
            (11, 0.08, 1e-4),
            (18, 0.25, 5e-5),
            (27, 0.23, 2e-5),
            (30, 0.34, 8e-5),
        ],
    }
}

fn scan_ending_at(grain: usize) -> Scan {
    Scan {
        stamp: stamp(grain),
        robot_from_sensor: Pose2::identity(),
        bearings: (0..BEAMS).map(|i| i as f64 * 0.1).collect(),
        ranges: vec![1.0; BEAMS],
        sigmas: vec![0.01; BEAMS],
        bearing_sigma: 0.0,
        max_range: 6.0,
        sweep: SWEEP as f64 * GRAIN_MICROS as f64 * 1e-6,
        qualities: vec![],
    }
}

/// A filter over the heading alone, as the smoother expects to have run.
struct Filter {
    heading: f64,
    variance: f64,
    grain: usize,
}

impl Filter {
    fn advance(&mut self, drive: &Drive, to: usize) {
        for (turn, variance) in &drive.turns[self.grain..to] {
            self.heading += turn;
            self.variance += variance;
        }
        self.grain = to;
    }

    fn fixes(&mut self, drive: &Drive, until: usize) -> Vec<Fix> {
        let from = self.grain;
        let walls = drive.walls.iter().filter(|w| w.0 > from && w.0 <= until);
        let fixes = walls
            .map(|&(grain, heading, variance)| {
                self.advance(drive, grain);
                let before = Pose2::new(0.0, 0.0, self.heading);
                let gain = self.variance / (self.variance + variance);
                self.heading += gain * (heading - self.heading);
                self.variance *= 1.0 - gain;
                Fix {
                    seconds: stamp(grain).seconds(),
                    before,
                    after: Pose2::new(0.0, 0.0, self.heading),
                    heading_variance: variance,
                }
            })
            .collect();
        self.advance(drive, until);
        fixes
    }
}

#[test]
fn headings_and_variances_are_those_of_all_measurements_solved_at_once() {
    let drive = drive();
    let (mut smoother, mut history) = (SweepSmoother::default(), MotionHistory::new(5.0));
    let mut filter = Filter {
        heading: 0.0,
        variance: 0.0,
        grain: 0,
    };
    // Each sweep is read two grains after its last beam.
    for (end, read) in [(SWEEP, SWEEP + 2), (2 * SWEEP + 2, 2 * SWEEP + 4)] {
        for reading in filter.grain / 2..read / 2 {
            history.push(&drive.odometry(reading));
        }
        let fixes = filter.fixes(&drive, read);
        let poses = smooth(&mut smoother, &scan_ending_at(end), &fixes, &history);
        let (headings, cov) = drive.until(read).batch();
        assert_eq!(poses.len(), BEAMS);
        for (beam, pose) in poses.iter().enumerate() {
            let grain = end - SWEEP + beam * SWEEP / (BEAMS - 1);
            let heading = filter.heading + pose.robot_from_then.heading();
            assert!((heading - headings[grain]).abs() < 1e-9, "beam {beam}");
            let (got, expect) = (pose.heading_variance, cov[(grain, grain)]);
            assert!((got - expect).abs() < 1e-10, "beam {beam}: {got} {expect}");
        }
    }
}

#[test]
fn without_fixes_odometry_places_the_beams_and_its_variance_gathers_over_the_sweeps() {
    let drive = Drive {
        walls: vec![],
        ..drive()
    };
    let (mut smoother, mut history) = (SweepSmoother::default(), MotionHistory::new(5.0));
    for reading in 0..SWEEP / 2 {
        history.push(&drive.odometry(reading));
    }
    let first = smooth(&mut smoother, &scan_ending_at(SWEEP), &[], &history);
    let of = |from: usize, to: usize| drive.turns[from..to].iter().map(|t| t.1).sum::<f64>();
    assert!(first[0].heading_variance.abs() < 1e-15);
    assert!((first[BEAMS - 1].heading_variance - of(0, SWEEP)).abs() < 1e-12);
    assert_eq!(first[BEAMS - 1].robot_from_then, Pose2::identity());
    for reading in SWEEP / 2..SWEEP {
        history.push(&drive.odometry(reading));
    }
    let second = smooth(&mut smoother, &scan_ending_at(2 * SWEEP), &[], &history);
    assert!((second[0].heading_variance - of(0, SWEEP)).abs() < 1e-12);
    assert!((second[BEAMS - 1].heading_variance - of(0, 2 * SWEEP)).abs() < 1e-12);
    let turned: f64 = drive.turns[SWEEP..2 * SWEEP].iter().map(|t| t.0).sum();
    assert!((second[0].robot_from_then.heading() + turned).abs() < 1e-12);
}

#[test]
fn a_standing_robot_is_sure_of_its_beams_and_a_fix_moves_them_all() {
    let mut history = MotionHistory::new(5.0);
    for reading in 0..SWEEP / 2 {
        history.push(&Odometry {
            motion: Pose2::identity(),
            cov: Matrix3::zeros(),
            ..drive().odometry(reading)
        });
    }
    let fix = Fix {
        seconds: stamp(9).seconds(),
        before: Pose2::new(1.0, 2.0, 3.0),
        after: Pose2::new(1.01, 1.98, 3.02),
        heading_variance: 1e-4,
    };
    let poses = smooth(
        &mut SweepSmoother::default(),
        &scan_ending_at(SWEEP),
        &[fix],
        &history,
    );
    for pose in poses {
        assert_eq!(pose.heading_variance, 0.0);
        let moved = pose.robot_from_then;
        let off = moved.x().abs() + moved.y().abs() + moved.heading().abs();
        assert!(off < 1e-12, "{moved:?}");
    }
}
