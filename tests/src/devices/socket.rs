//! A socket for a device: a pseudo-terminal under a permanent path, and a thread that acts as its
//! clock.
//!
//! 1. Plugging in creates a pseudo-terminal and points the path to it; pulling out closes it, so
//!    the bridge sees the same as with a real pulled cable.
//! 2. Every few milliseconds the thread lets the device read and write. Time is real, because the
//!    bridge's is; the device's time only lags behind if the machine starves the thread.
//! 3. If the bridge has set a baud rate other than the device's, both see noise.

use std::fs;
use std::io;
use std::os::fd::{AsFd, OwnedFd};
use std::os::unix::fs::symlink;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use rustix::fs::{Mode, OFlags};
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use rustix::termios::{OptionalActions, tcgetattr, tcsetattr};
use tempfile::TempDir;

use super::Device;
use super::spoil::{Faults, Line};

/// Interval between two looks at the line.
const BEAT: Duration = Duration::from_millis(2);
/// If the machine delays the thread for longer than this, s, the device's time stops meanwhile:
/// otherwise it would send at once what it should have sent in a second, which no line could carry.
pub(super) const MOST_AT_ONCE: f64 = 0.05;

/// A device in its socket; dropping it unplugs the device and ends its thread.
#[derive(Debug)]
pub struct Socket<D> {
    shared: Arc<Mutex<Shared<D>>>,
    path: PathBuf,
    _folder: TempDir,
    thread: Option<JoinHandle<()>>,
}

#[derive(Debug)]
struct Shared<D> {
    device: D,
    faults: Faults,
    is_plugged: bool,
    cut_in_the_middle: bool,
    has_ended: bool,
    lost: Duration,
}

impl<D: Device> Socket<D> {
    /// A device that is plugged in.
    ///
    /// # Errors    The system has no pseudo-terminals, folders or threads left.
    pub fn plugged(device: D) -> io::Result<Self> {
        Self::plugged_with(device, Faults::default())
    }

    /// The same on a line that is faulty from the first byte: a lidar speaks as soon as it has
    /// power.
    ///
    /// # Errors    As [`Socket::plugged`].
    pub fn plugged_with(device: D, faults: Faults) -> io::Result<Self> {
        let socket = Self::unplugged(device)?;
        socket.set_faults(faults);
        socket.plug();
        Ok(socket)
    }

    /// A device that is not plugged in: its path does not exist yet.
    ///
    /// # Errors    As [`Socket::plugged`].
    pub fn unplugged(device: D) -> io::Result<Self> {
        let folder = TempDir::new()?;
        let path = folder.path().join("ttyUSB0");
        let shared = Arc::new(Mutex::new(Shared {
            device,
            faults: Faults::default(),
            is_plugged: false,
            cut_in_the_middle: false,
            has_ended: false,
            lost: Duration::ZERO,
        }));
        let (for_thread, path_of_thread) = (Arc::clone(&shared), path.clone());
        let body = move || live(&for_thread, &path_of_thread);
        Ok(Self {
            shared,
            path,
            _folder: folder,
            thread: Some(thread::Builder::new().spawn(body)?),
        })
    }

    /// The path of its port.
    #[must_use]
    pub fn path(&self) -> String {
        self.path.to_string_lossy().into_owned()
    }

    /// Plugs it in: it gets power.
    pub fn plug(&self) {
        self.lock().is_plugged = true;
        self.wait(true);
    }

    /// Unplugs it. What is on the line at that moment is lost.
    pub fn pull(&self) {
        self.lock().is_plugged = false;
        self.wait(false);
    }

    /// Waits until its thread has plugged it in or out: if the machine starves the thread, a device
    /// that is plugged in again at once would otherwise never have been out.
    fn wait(&self, is_there: bool) {
        let until = Instant::now() + Duration::from_secs(60);
        while self.path.exists() != is_there && Instant::now() < until {
            thread::sleep(BEAT);
        }
    }

    /// Unplugs it in the middle of its next message.
    pub fn pull_in_the_middle(&self) {
        self.lock().cut_in_the_middle = true;
    }

    /// Sets the faults of the line.
    pub fn set_faults(&self, faults: Faults) {
        self.lock().faults = faults;
    }

    /// Gives access to the device.
    pub fn with<T>(&self, change: impl FnOnce(&mut D) -> T) -> T {
        change(&mut self.lock().device)
    }

    /// The real time that the device has lost so far, because the machine made it wait for the
    /// processor. Half a second at once looks to the bridge like a device that fell silent.
    #[must_use]
    pub fn lost(&self) -> Duration {
        self.lock().lost
    }

    fn lock(&self) -> MutexGuard<'_, Shared<D>> {
        self.shared.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl<D> Drop for Socket<D> {
    fn drop(&mut self) {
        self.shared
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .has_ended = true;
        if let Some(thread) = self.thread.take() {
            // A device that panicked has already failed its test.
            let _ = thread.join();
        }
    }
}

fn live<D: Device>(shared: &Mutex<Shared<D>>, path: &Path) {
    let mut line = Line::new(11);
    let mut pty: Option<Pty> = None;
    let mut last = Instant::now();
    loop {
        thread::sleep(BEAT);
        let waited = last.elapsed();
        let elapsed = waited.as_secs_f64().min(MOST_AT_ONCE);
        last = Instant::now();
        let mut shared = shared.lock().unwrap_or_else(PoisonError::into_inner);
        shared.lost += waited.saturating_sub(Duration::from_secs_f64(MOST_AT_ONCE));
        if shared.has_ended {
            return;
        }
        match (&pty, shared.is_plugged) {
            (None, true) => {
                shared.device.power_on();
                pty = Pty::at(path)
                    .map_err(|error| eprintln!("no pseudo-terminal: {error}"))
                    .ok();
            }
            (Some(_), false) => {
                let _ = fs::remove_file(path);
                pty = None;
                shared.device.pulled();
                shared.device.unplugged(elapsed);
            }
            (Some(pty), true) => beat(&mut shared, pty, &mut line, elapsed),
            (None, false) => shared.device.unplugged(elapsed),
        }
    }
}

/// Lets the device read and write.
fn beat<D: Device>(shared: &mut Shared<D>, pty: &Pty, line: &mut Line, elapsed: f64) {
    let is_tuned = !shared.faults.is_garbled && pty.baud_rate() == Some(shared.device.baud_rate());
    let heard = pty.read();
    let heard = if is_tuned { heard } else { line.garble(&heard) };
    let on_the_way_in = Faults {
        flipped_bits: shared.faults.flipped_bits_heard,
        ..Faults::default()
    };
    let heard = line.carry(&heard, &on_the_way_in);
    shared.device.receive(&heard);
    let said = shared.device.advance(elapsed);
    let said = if is_tuned { said } else { line.garble(&said) };
    let mut said = line.carry(&said, &shared.faults);
    if shared.cut_in_the_middle && said.len() > 1 {
        said.truncate(said.len() / 2);
        shared.cut_in_the_middle = false;
        shared.is_plugged = false;
    }
    pty.write(&said);
}

/// Our end of a pseudo-terminal.
struct Pty {
    controller: OwnedFd,
    /// Held open, so that the line does not hang up while the bridge has it closed.
    _user: OwnedFd,
}

impl Pty {
    fn at(path: &Path) -> io::Result<Self> {
        let controller = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY)?;
        grantpt(&controller)?;
        unlockpt(&controller)?;
        let name = ptsname(&controller, Vec::new())?;
        let flags = OFlags::RDWR | OFlags::NOCTTY | OFlags::CLOEXEC;
        let user = rustix::fs::open(name.as_c_str(), flags, Mode::empty())?;
        let mut termios = tcgetattr(&user)?;
        termios.make_raw();
        tcsetattr(&user, OptionalActions::Now, &termios)?;
        rustix::fs::fcntl_setfl(&controller, OFlags::RDWR | OFlags::NONBLOCK)?;
        let target = PathBuf::from(name.to_string_lossy().into_owned());
        let _ = fs::remove_file(path);
        symlink(target, path)?;
        Ok(Self {
            controller,
            _user: user,
        })
    }

    /// The baud rate that the bridge has set.
    fn baud_rate(&self) -> Option<u32> {
        tcgetattr(self.controller.as_fd())
            .ok()
            .map(|termios| termios.output_speed())
    }

    fn read(&self) -> Vec<u8> {
        let mut buffer = [0; 4096];
        // Nothing there or nobody connected: the device cannot tell the difference.
        let count = rustix::io::read(&self.controller, &mut buffer).unwrap_or(0);
        buffer.iter().take(count).copied().collect()
    }

    /// Bytes without room are lost, as on a line that nobody reads.
    fn write(&self, bytes: &[u8]) {
        let _ = rustix::io::write(&self.controller, bytes);
    }
}
