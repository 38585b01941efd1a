//! Opening a port, and what to do when it does not open.

use std::io;
use std::time::Duration;

use serialport::{ErrorKind, SerialPort};

/// Longest time that a read or a write waits.
const PATIENCE: Duration = Duration::from_millis(50);

/// Which port, and how fast. Always 8 bits, no parity, one stop bit.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PortSettings {
    /// Path, or a name like `COM3`.
    pub path: String,
    /// Baud rate.
    pub baud_rate: u32,
}

/// Why a port does not open: each with its cure.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum OpenError {
    /// There is no such port.
    #[error(
        "{path} is not there: plug the device in, or name another port (`slamlab-bridge doctor` lists them)"
    )]
    NotFound {
        /// The port.
        path: String,
    },
    /// This user has no permission.
    #[error(
        "{path}: permission denied: add this user to the group that owns it (`sudo usermod -aG dialout $USER`, then log \
         in again), or install the udev rules"
    )]
    Permission {
        /// The port.
        path: String,
    },
    /// Another program has it open.
    #[error(
        "{path} is busy: another program has it open (`fuser {path}` names it; often a second bridge or ModemManager)"
    )]
    Busy {
        /// The port.
        path: String,
    },
    /// The port cannot run at this baud rate.
    #[error("{path} cannot run at {baud_rate} baud: {detail}")]
    Settings {
        /// The port.
        path: String,
        /// The rate.
        baud_rate: u32,
        /// What the system says.
        detail: String,
    },
    /// Something else.
    #[error("{path} does not open: {detail}")]
    Other {
        /// The port.
        path: String,
        /// What the system says.
        detail: String,
    },
}

impl PortSettings {
    /// Opens the port, for this program alone.
    ///
    /// # Errors    [`OpenError`], with cause and cure.
    pub(super) fn open(&self) -> Result<Box<dyn SerialPort>, OpenError> {
        serialport::new(&self.path, self.baud_rate)
            .timeout(PATIENCE)
            .open()
            .map_err(|error| self.explain(&error))
    }

    fn explain(&self, error: &serialport::Error) -> OpenError {
        let (path, detail) = (self.path.clone(), error.to_string());
        match error.kind() {
            ErrorKind::Io(io::ErrorKind::NotFound) => OpenError::NotFound { path },
            ErrorKind::Io(io::ErrorKind::PermissionDenied) => OpenError::Permission { path },
            // The crate's error when another program holds the exclusive lock.
            ErrorKind::NoDevice => OpenError::Busy { path },
            ErrorKind::InvalidInput => OpenError::Settings {
                path,
                baud_rate: self.baud_rate,
                detail,
            },
            _ => OpenError::Other { path, detail },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn settings() -> PortSettings {
        PortSettings {
            path: "/dev/ttyUSB7".into(),
            baud_rate: 115_200,
        }
    }

    #[test]
    fn each_reason_names_its_cure() {
        for (kind, cure) in [
            (ErrorKind::Io(io::ErrorKind::NotFound), "plug the device in"),
            (ErrorKind::Io(io::ErrorKind::PermissionDenied), "dialout"),
            (ErrorKind::NoDevice, "fuser /dev/ttyUSB7"),
            (ErrorKind::InvalidInput, "115200 baud: odd"),
            (ErrorKind::Unknown, "does not open: odd"),
        ] {
            let error = settings().explain(&serialport::Error::new(kind, "odd"));
            assert!(error.to_string().contains(cure), "{error}");
        }
    }

    #[test]
    fn a_port_that_is_not_there_is_named() {
        let error = PortSettings {
            path: "/dev/does-not-exist".into(),
            ..settings()
        };
        assert!(matches!(error.open(), Err(OpenError::NotFound { .. })));
    }
}
