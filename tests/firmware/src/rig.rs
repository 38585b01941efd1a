//! What hangs on the chip: motors, encoders, rangers, battery, bumpers.
//!
//! In: the chip's registers. Out: edges, voltages and levels at its pins, and where the robot is.
//!
//! 1. In each slice of time the duty and direction of each motor become a voltage, and the motor of
//!    the simulation turns by it.
//! 2. Each count of a shaft's angle is an edge at its encoder's pin; there is at most one in a
//!    slice.
//! 3. The ranger that the select lines choose gives the voltage that the caller set, or, in a
//!    world, that of the wall where the servo's last pulse points it. A ranger measures once in 38
//!    ms and holds its output meanwhile.
//! 4. In a world a wall stops the body and presses the bumpers; the tracks slip on.

use std::f64::consts::{FRAC_PI_2, PI};

use anyhow::Result;
use nalgebra::Vector2;
use slamlab_core::geom::{Pose2, sin_cos};
use slamlab_core::robot::{RobotModel, Sharp, Tracks};
use slamlab_core::sim::{Caster, Motor, World};

use crate::Chip;
use crate::chip::FREQUENCY;

/// Cycles of a slice: a quarter of a millisecond, in which a track at full speed makes a third of a
/// count.
const SLICE: u64 = FREQUENCY / 4_000;
/// Duty of full voltage.
const DUTY_TOP: f64 = 210.0;
/// Encoders' pins on port D: left, right.
const ENCODER_PINS: [u32; 2] = [2, 3];
/// Slices of a ranger's cycle.
const RANGER_CYCLE: u64 = 153;
/// Beyond this nothing comes back, m.
const FARTHEST: f64 = 10.0;
/// Directions of the rangers on the servo, rad.
const RANGER_ANGLES: [f64; 4] = [0.0, FRAC_PI_2, PI, -FRAC_PI_2];

/// A chip and its robot.
pub struct Rig {
    /// The chip.
    pub chip: Chip,
    model: RobotModel,
    motors: [Motor; 2],
    counts: [i64; 2],
    levels: [bool; 2],
    /// Torque that brakes each shaft, N m.
    pub brakes: [f64; 2],
    /// Whether the encoders' cables are on.
    pub encoders_on: [bool; 2],
    /// Voltages of the four rangers, V.
    pub ranger_volts: [f64; 4],
    pose: Pose2,
    walls: Option<Caster>,
    slices: u64,
    is_touching: bool,
    contacts: u32,
}

impl Rig {
    /// A robot that stands, its motors as the model has them but for a part of their constants:
    /// left, right.
    ///
    /// # Errors
    /// As of [`Chip::new`].
    pub fn new(mismatch: [f64; 2]) -> Result<Self> {
        let model = RobotModel::rp6();
        let seconds = SLICE as f64 / FREQUENCY as f64;
        let motor = |part| Motor::new(&model.drive.left.with_stronger_magnet(part), seconds);
        let mut rig = Self {
            chip: Chip::new(crate::firmware()?)?,
            model,
            motors: mismatch.map(motor),
            counts: [0; 2],
            levels: [false; 2],
            brakes: [0.0; 2],
            encoders_on: [true; 2],
            ranger_volts: [0.0; 4],
            pose: Pose2::identity(),
            walls: None,
            slices: 0,
            is_touching: false,
            contacts: 0,
        };
        // 7.2 V behind a divider by two; the currents' sensors at rest.
        rig.chip.set_millivolts(7, 3_600);
        rig.chip.set_millivolts(6, 100);
        rig.chip.set_millivolts(5, 120);
        rig.press_bumpers([false; 2]);
        Ok(rig)
    }

    /// The same robot at the start of a world.
    ///
    /// # Errors
    /// As of [`Chip::new`].
    pub fn in_world(world: &World) -> Result<Self> {
        let mut rig = Self::new([0.0; 2])?;
        rig.pose = world.start;
        rig.walls = Some(Caster::new(world.walls()));
        Ok(rig)
    }

    /// The figures of the robot.
    #[must_use]
    pub fn model(&self) -> &RobotModel {
        &self.model
    }

    /// Time since power-on, s.
    #[must_use]
    pub fn seconds(&self) -> f64 {
        self.chip.cycle() as f64 / FREQUENCY as f64
    }

    /// True ways of the tracks since power-on, m.
    #[must_use]
    pub fn ways(&self) -> [f64; 2] {
        self.motors
            .map(|motor| motor.angle() * self.model.drive.metres_per_radian)
    }

    /// True counts of the shafts since power-on.
    #[must_use]
    pub fn counts(&self) -> [i64; 2] {
        self.counts
    }

    /// True speeds of the tracks, m/s.
    #[must_use]
    pub fn speeds(&self) -> [f64; 2] {
        self.motors
            .map(|motor| motor.speed() * self.model.drive.metres_per_radian)
    }

    /// Where the robot is, by what its tracks really ran.
    #[must_use]
    pub fn pose(&self) -> Pose2 {
        self.pose
    }

    /// How often it began to touch a wall.
    #[must_use]
    pub fn contacts(&self) -> u32 {
        self.contacts
    }

    /// Presses the left and the right bumper.
    pub fn press_bumpers(&mut self, pressed: [bool; 2]) {
        self.chip.set_pin(b'B', 0, pressed[0]);
        self.chip.set_pin(b'C', 6, pressed[1]);
    }

    /// Runs one slice.
    ///
    /// # Errors
    /// As of [`Chip::run_until`].
    pub fn step(&mut self) -> Result<()> {
        let before = self.ways();
        let (duties, backwards) = (self.chip.duties(), self.chip.backwards());
        for side in 0..2 {
            let part = f64::from(duties[side]) / DUTY_TOP;
            let voltage = self.model.drive.battery * if backwards[side] { -part } else { part };
            self.motors[side].step(voltage, 0.0, self.brakes[side]);
            self.count(side);
        }
        let [left, right] = self.ways();
        let tracks = Tracks {
            left: left - before[0],
            right: right - before[1],
        };
        self.move_by(&tracks);
        self.measure();
        let volts = self.ranger_volts[self.chip.selected_ranger()];
        self.chip.set_millivolts(0, (volts * 1e3).round() as u32);
        let slice = self.chip.cycle() / SLICE + 1;
        self.chip.run_until(slice * SLICE)
    }

    fn move_by(&mut self, tracks: &Tracks) {
        let aim = self.pose * tracks.motion(self.model.track_width);
        let Some(walls) = &self.walls else {
            self.pose = aim;
            return;
        };
        let radius = self.model.radius();
        let is_free = walls.clearance(aim.position(), radius) >= radius;
        // Turning on the spot a disc touches nothing.
        let stays = self.pose.position();
        self.pose = match is_free {
            true => aim,
            false => Pose2::new(stays.x, stays.y, aim.heading()),
        };
        self.contacts += u32::from(!is_free && !self.is_touching);
        self.is_touching = !is_free;
        self.press_bumpers([!is_free; 2]);
    }

    /// One ranger after the other measures, each once in its cycle.
    fn measure(&mut self) {
        self.slices += 1;
        let ranger = (self.slices % RANGER_CYCLE) as usize;
        let (Some(walls), Some(angle), Some(pulse)) = (
            &self.walls,
            RANGER_ANGLES.get(ranger),
            self.chip.servo_pulse(),
        ) else {
            return;
        };
        let servo = (pulse - 1_500.0) / 1_000.0 * FRAC_PI_2;
        let (sin, cos) = sin_cos(self.pose.heading() + servo + angle);
        let hit = walls.cast(self.pose.position(), Vector2::new(cos, sin), FARTHEST);
        let range = hit.map_or(FARTHEST, |hit| hit.distance);
        self.ranger_volts[ranger] = Sharp::Long.volts_at(range);
    }

    fn count(&mut self, side: usize) {
        let angle = self.motors[side].angle() / self.model.radians_per_count();
        let count = angle.floor() as i64;
        if count != self.counts[side] && self.encoders_on[side] {
            self.levels[side] = !self.levels[side];
            self.chip
                .set_pin(b'D', ENCODER_PINS[side], self.levels[side]);
        }
        self.counts[side] = count;
    }
}
