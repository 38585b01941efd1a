//! What was found at a port, and how it is printed.

use std::fmt;

use slamlab_core::device::{Kind, UsbAdapter};

/// What a device sent while it was watched.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Measured {
    /// How long data came, s.
    pub seconds: f64,
    /// Number of scans.
    pub scans: u64,
    /// Scans per second, by their own stamps.
    pub scans_per_second: f64,
    /// Beams of the last scan.
    pub beams: usize,
    /// Number of odometry readings.
    pub odometries: u64,
    /// Frames that arrived damaged.
    pub damaged: u64,
    /// Bytes that belonged to no frame.
    pub skipped: u64,
}

/// What was found at a port.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Finding {
    /// The port.
    pub path: String,
    /// The kind of device that answers.
    pub kind: Option<&'static Kind>,
    /// The USB adapter of the port, if it is one that usually comes with a known device.
    pub adapter: Option<UsbAdapter>,
    /// The model that the device reports.
    pub model: String,
    /// How well it works.
    pub measured: Measured,
    /// What is wrong, why, and what helps, each a sentence; empty where all is well.
    pub problems: Vec<String>,
}

impl Finding {
    /// Whether something answers and nothing is wrong.
    #[must_use]
    pub fn is_well(&self) -> bool {
        self.kind.is_some() && self.problems.is_empty()
    }

    /// How the device is named on the command line of `serve`.
    #[must_use]
    pub fn source(&self) -> Option<String> {
        Some(format!("{}:{}", self.kind?.name, self.path))
    }

    /// Titles of the kinds that usually come with the port's adapter.
    fn usual(&self) -> Vec<&'static str> {
        let adapter = self.adapter.as_slice();
        let kinds =
            Kind::distinct().filter(|kind| kind.adapters.iter().any(|a| adapter.contains(a)));
        kinds.map(|kind| kind.title).collect()
    }
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let what = match (self.kind, self.model.as_str()) {
            (None, _) => "nothing that is known",
            (Some(kind), "") => kind.title,
            (Some(_), model) => model,
        };
        write!(f, "{}: {what}", self.path)?;
        if let (None, Some(adapter)) = (self.kind, self.adapter) {
            let titles = self.usual().join(" or ");
            let chip = adapter.chip;
            write!(f, "\n  its USB adapter is a {chip}, as of an {titles}")?;
        }
        let m = &self.measured;
        if m.scans > 0 {
            write!(
                f,
                "\n  {:.1} scans/s of {} beams",
                m.scans_per_second, m.beams
            )?;
        }
        if m.odometries > 0 {
            write!(
                f,
                "\n  odometry {:.0} times a second",
                m.odometries as f64 / m.seconds
            )?;
        }
        if m.scans + m.odometries > 0 {
            write!(
                f,
                "\n  {} damaged frames, {} stray bytes in {:.1} s",
                m.damaged, m.skipped, m.seconds
            )?;
        }
        for sentence in &self.problems {
            write!(f, "\n  PROBLEM {sentence}")?;
        }
        if let (true, Some(source)) = (self.is_well(), self.source()) {
            write!(
                f,
                "\n  well; use it with: slamlab-bridge serve --source {source}"
            )?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_finding_says_what_where_how_and_what_to_do() {
        let mut finding = Finding {
            path: "/dev/ttyUSB0".into(),
            kind: Kind::named("rplidar"),
            adapter: None,
            model: "RPLIDAR A1M8".into(),
            measured: Measured {
                seconds: 2.0,
                scans: 11,
                scans_per_second: 5.5,
                beams: 360,
                ..Measured::default()
            },
            problems: vec![],
        };
        let text = finding.to_string();
        assert_eq!(
            text,
            "/dev/ttyUSB0: RPLIDAR A1M8\n  5.5 scans/s of 360 beams\n  0 damaged frames, 0 stray bytes in 2.0 s\n  well; \
             use it with: slamlab-bridge serve --source rplidar:/dev/ttyUSB0"
        );
        finding.problems.push("weak power".into());
        assert!(finding.to_string().ends_with("PROBLEM weak power") && !finding.is_well());
    }

    #[test]
    fn the_adapter_of_a_silent_device_tells_what_it_may_be() {
        let finding = Finding {
            path: "/dev/ttyUSB0".into(),
            kind: None,
            adapter: Kind::named("ld06").map(|kind| kind.adapters[0]),
            model: String::new(),
            measured: Measured::default(),
            problems: vec![],
        };
        let text = finding.to_string();
        assert!(
            text.ends_with("its USB adapter is a CP2102, as of an RPLIDAR or LD06"),
            "{text}"
        );
    }
}
