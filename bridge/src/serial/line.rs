//! An open serial port, read and written on two threads.
//!
//! In: bytes to write. Out: bytes as received, each piece with the instant at which it came.

use std::io::{ErrorKind, Read, Write};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, TrySendError, sync_channel};
use std::sync::{Arc, OnceLock};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use serialport::SerialPort;

use super::open::{OpenError, PortSettings};

/// Most pieces that may wait to be taken: at 230400 baud, whatever their size, at least a quarter
/// of a second.
const MOST_PIECES: usize = 256;
/// Most writes that may wait: more means that the port takes no bytes any more.
const MOST_WRITES: usize = 32;
/// Largest piece, bytes.
const PIECE: usize = 1024;

/// An open serial port. Dropping it closes it, once pending writes are done.
#[derive(Debug)]
pub struct Line {
    pieces: Receiver<Piece>,
    writes: Option<SyncSender<Vec<u8>>>,
    shared: Arc<Shared>,
    control: Box<dyn SerialPort>,
    threads: Vec<JoinHandle<()>>,
}

#[derive(Debug, Default)]
struct Shared {
    is_closed: AtomicBool,
    broken: OnceLock<LineError>,
}

/// Bytes, and when they came.
type Piece = (Vec<u8>, Instant);

/// Why a line broke.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum LineError {
    /// The other end is gone.
    #[error("the port is gone: the cable was pulled, or the device lost power; put it back")]
    Gone,
    /// The system reported an error.
    #[error("the port does not work any more: {0}; pull the cable and put it back")]
    Failed(String),
    /// Written bytes are not sent.
    #[error("the port takes no bytes: the device holds the line up; reset it")]
    Stuck,
}

/// The result of waiting for bytes.
#[derive(Debug)]
pub enum Received {
    /// Bytes, and when they came.
    Bytes(Vec<u8>, Instant),
    /// No bytes in time.
    Nothing,
    /// No more bytes will come.
    Broken(LineError),
}

/// What carries bytes to a device and back.
pub(crate) trait Channel {
    /// Waits for bytes, up to `timeout`.
    fn receive(&mut self, timeout: Duration) -> Received;

    /// Hands bytes over to be written.
    ///
    /// # Errors    Why nothing can be written any more.
    fn send(&mut self, bytes: Vec<u8>) -> Result<(), LineError>;

    /// Sets or clears DTR, if there is one.
    fn set_dtr(&mut self, is_set: bool);
}

impl Channel for Line {
    fn receive(&mut self, timeout: Duration) -> Received {
        if let Some(error) = self.shared.broken.get() {
            return Received::Broken(error.clone());
        }
        match self.pieces.recv_timeout(timeout) {
            Ok((bytes, came)) => Received::Bytes(bytes, came),
            Err(RecvTimeoutError::Timeout) => Received::Nothing,
            Err(RecvTimeoutError::Disconnected) => Received::Broken(self.shared.why()),
        }
    }

    fn send(&mut self, bytes: Vec<u8>) -> Result<(), LineError> {
        let Some(writes) = &self.writes else {
            return Err(LineError::Gone);
        };
        writes.try_send(bytes).map_err(|error| match error {
            TrySendError::Full(_) => LineError::Stuck,
            TrySendError::Disconnected(_) => self.shared.why(),
        })
    }

    fn set_dtr(&mut self, is_set: bool) {
        if let Err(error) = self.control.write_data_terminal_ready(is_set) {
            tracing::debug!("no DTR, the motor must be switched otherwise: {error}");
        }
    }
}

impl Line {
    /// Opens a port and starts its threads.
    ///
    /// # Errors    [`OpenError`]: cause and cure.
    pub fn open(settings: &PortSettings) -> Result<Self, OpenError> {
        let other = |detail: String| OpenError::Other {
            path: settings.path.clone(),
            detail,
        };
        let control = settings.open()?;
        let clone = || {
            control
                .try_clone()
                .map_err(|error| other(error.to_string()))
        };
        let (reader, writer) = (clone()?, clone()?);
        let shared = Arc::new(Shared::default());
        let (piece_sender, pieces) = sync_channel(MOST_PIECES);
        let (writes, write_receiver) = sync_channel(MOST_WRITES);
        let (for_reader, for_writer) = (Arc::clone(&shared), Arc::clone(&shared));
        let spawn = |name: &str, body: Box<dyn FnOnce() + Send>| {
            let builder = thread::Builder::new().name(name.into());
            builder
                .spawn(body)
                .map_err(|error| other(error.to_string()))
        };
        let reading = spawn(
            "serial read",
            Box::new(move || for_reader.ended(read(reader, &piece_sender, &for_reader.is_closed))),
        )?;
        let writing = spawn(
            "serial write",
            Box::new(move || for_writer.ended(write(writer, &write_receiver))),
        );
        let mut line = Self {
            pieces,
            writes: Some(writes),
            shared,
            control,
            threads: vec![reading],
        };
        // If this fails, dropping the line ends the reader.
        line.threads.push(writing?);
        Ok(line)
    }
}

impl Drop for Line {
    fn drop(&mut self) {
        // The writer ends once it has written what waits; the reader sees `is_closed` at its next
        // timeout.
        self.writes = None;
        self.shared.is_closed.store(true, Ordering::Relaxed);
        for thread in self.threads.drain(..) {
            if thread.join().is_err() {
                tracing::error!("a thread of a serial line panicked");
            }
        }
    }
}

impl Shared {
    /// Keeps why a thread has ended. It is set before the thread's channel closes, so that whoever
    /// sees the closed channel finds the reason.
    fn ended(&self, ended: Result<(), LineError>) {
        if let Err(error) = ended {
            // If the other thread has failed before, its reason is kept.
            let _ = self.broken.set(error);
        }
    }

    fn why(&self) -> LineError {
        self.broken.get().cloned().unwrap_or(LineError::Gone)
    }
}

fn read(
    mut port: Box<dyn SerialPort>,
    pieces: &SyncSender<Piece>,
    is_closed: &AtomicBool,
) -> Result<(), LineError> {
    let mut buffer = [0; PIECE];
    while !is_closed.load(Ordering::Relaxed) {
        let bytes = match port.read(&mut buffer) {
            Ok(0) => return Err(LineError::Gone),
            Ok(count) => buffer.iter().take(count).copied().collect(),
            Err(error) if is_pause(&error) => continue,
            Err(error) => return Err(broken_by(&error)),
        };
        // Do not wait for a late receiver: the kernel's own buffer would overflow.
        if pieces.try_send((bytes, Instant::now())).is_err() {
            tracing::debug!("bytes of a serial port found no room");
        }
    }
    Ok(())
}

fn write(mut port: Box<dyn SerialPort>, writes: &Receiver<Vec<u8>>) -> Result<(), LineError> {
    for bytes in writes {
        port.write_all(&bytes).map_err(|error| match error.kind() {
            ErrorKind::TimedOut => LineError::Stuck,
            _ => broken_by(&error),
        })?;
    }
    Ok(())
}

fn is_pause(error: &std::io::Error) -> bool {
    matches!(
        error.kind(),
        ErrorKind::TimedOut | ErrorKind::WouldBlock | ErrorKind::Interrupted
    )
}

fn broken_by(error: &std::io::Error) -> LineError {
    match error.kind() {
        ErrorKind::BrokenPipe | ErrorKind::UnexpectedEof | ErrorKind::NotFound => LineError::Gone,
        _ => LineError::Failed(error.to_string()),
    }
}
