//! How a driver works.

use super::super::answer::Rate;
use crate::wire::revolution::RevolutionConfig;

/// What an A1 answers: 2 000 and 4 000 readings a second.
pub(super) const RATE_OF_A1: Rate = Rate {
    standard_micros: 500,
    express_micros: 250,
};

/// How readings come.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ScanMode {
    /// One by one, with quality.
    #[default]
    Standard,
    /// 32 in a capsule: twice as many, checked by a sum, without quality. Firmware 1.17 and later.
    Express,
}

/// How a [`super::Driver`] works.
#[derive(Clone, Debug, PartialEq)]
pub struct DriverConfig {
    /// The sensor and where it sits.
    pub revolution: RevolutionConfig,
    /// How readings come. Default: one by one.
    pub mode: ScanMode,
    /// Duty of the motor, of 1023, for sensors that are told by a request (A2, A3). Default `None`: the A1 is not.
    pub motor_duty: Option<u16>,
}

impl Default for DriverConfig {
    fn default() -> Self {
        Self {
            revolution: RevolutionConfig::rplidar(),
            mode: ScanMode::Standard,
            motor_duty: None,
        }
    }
}
