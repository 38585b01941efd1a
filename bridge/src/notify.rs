//! Reports the bridge's state to systemd, if systemd started it (`Type=notify`, `WatchdogSec=`);
//! otherwise nothing happens.
//!
//! The watchdog signal comes from the hub, which controls the robot: a bridge whose hub hangs is
//! restarted.

/// The bridge serves.
pub(crate) fn ready() {
    tell("READY=1");
}

/// The hub lives. Called each second.
pub(crate) fn alive() {
    tell("WATCHDOG=1");
}

/// The bridge ends.
pub(crate) fn stopping() {
    tell("STOPPING=1");
}

#[cfg(target_os = "linux")]
fn tell(state: &str) {
    if let Err(error) = sd_notify::notify(&[sd_notify::NotifyState::Custom(state)]) {
        tracing::debug!("systemd did not take {state}: {error}");
    }
}

#[cfg(not(target_os = "linux"))]
fn tell(_: &str) {}
