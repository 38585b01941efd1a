//! Tells systemd how the bridge does, where it was started by it (`Type=notify`, `WatchdogSec=`); else nothing happens.
//!
//! The sign of life comes from the hub, which has the robot: a bridge whose hub hangs is started anew.

/// The bridge serves.
pub(crate) fn ready() {
    tell(Word::Ready);
}

/// The hub lives. Called each second.
pub(crate) fn alive() {
    tell(Word::Alive);
}

/// The bridge ends.
pub(crate) fn stopping() {
    tell(Word::Stopping);
}

#[derive(Clone, Copy, Debug)]
enum Word {
    Ready,
    Alive,
    Stopping,
}

#[cfg(target_os = "linux")]
fn tell(word: Word) {
    use sd_notify::NotifyState;
    let state = match word {
        Word::Ready => NotifyState::Ready,
        Word::Alive => NotifyState::Watchdog,
        Word::Stopping => NotifyState::Stopping,
    };
    if let Err(error) = sd_notify::notify(&[state]) {
        tracing::debug!("systemd was not told {word:?}: {error}");
    }
}

#[cfg(not(target_os = "linux"))]
fn tell(_: Word) {}
