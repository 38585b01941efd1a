//! A file that is complete up to the last acknowledged record, whatever fails.
//!
//! In: bytes of one or more records. Out: after [`Journal::commit`], either all of these bytes are
//! in the file, or none.

use std::cell::RefCell;
use std::fs::File;
use std::io::{self, Seek, SeekFrom, Write};
use std::rc::Rc;

/// Buffer kept from one commit to the next, bytes: enough for a hundred scans with all their
/// messages.
const MOST_KEPT: usize = 1 << 21;

/// What a journal needs of a file; tests have an implementation that fails.
pub(crate) trait Storage: Write {
    /// Truncates the file to `length`, and writes there next.
    fn cut(&mut self, length: u64) -> io::Result<()>;
    /// Forces written bytes to the disk.
    fn force(&mut self) -> io::Result<()>;
}

impl Storage for File {
    fn cut(&mut self, length: u64) -> io::Result<()> {
        self.set_len(length)?;
        self.seek(SeekFrom::Start(length)).map(|_| ())
    }

    fn force(&mut self) -> io::Result<()> {
        self.sync_data()
    }
}

/// Collects what the MCAP writer writes, and passes it to the file as a whole. Clones share the
/// same file: the MCAP writer has one, its owner another.
#[derive(Debug)]
pub(super) struct Journal<S>(Rc<RefCell<State<S>>>);

#[derive(Debug)]
struct State<S> {
    storage: S,
    waiting: Vec<u8>,
    length: u64,
    has_failed: bool,
}

impl<S> Clone for Journal<S> {
    fn clone(&self) -> Self {
        Self(Rc::clone(&self.0))
    }
}

impl<S: Storage> Journal<S> {
    pub(super) fn new(storage: S) -> Self {
        Self(Rc::new(RefCell::new(State {
            storage,
            waiting: Vec::new(),
            length: 0,
            has_failed: false,
        })))
    }

    /// Writes the collected bytes to the file.
    ///
    /// # Errors    What the system said; then the file ends where it did before, and accepts no
    /// more.
    pub(super) fn commit(&self) -> io::Result<()> {
        let state = &mut *self.0.borrow_mut();
        let result = state.storage.write_all(&state.waiting);
        let length = state.waiting.len() as u64;
        state.waiting.clear();
        state.waiting.shrink_to(MOST_KEPT);
        let Err(error) = result else {
            state.length += length;
            return Ok(());
        };
        state.has_failed = true;
        state.storage.cut(state.length)?;
        Err(error)
    }

    /// Bytes in the file.
    pub(super) fn length(&self) -> u64 {
        self.0.borrow().length
    }

    /// Forces committed bytes to the disk.
    pub(super) fn force(&self) -> io::Result<()> {
        self.0.borrow_mut().storage.force()
    }
}

impl<S: Storage> Write for Journal<S> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let mut state = self.0.borrow_mut();
        if state.has_failed {
            return Err(io::Error::other("the recording has ended"));
        }
        state.waiting.extend_from_slice(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// The MCAP writer only asks for its position; it never seeks elsewhere.
impl<S: Storage> Seek for Journal<S> {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        let state = self.0.borrow();
        let here = state.length + state.waiting.len() as u64;
        match to {
            SeekFrom::Current(0) | SeekFrom::End(0) => Ok(here),
            SeekFrom::Start(at) if at == here => Ok(here),
            _ => Err(io::Error::from(io::ErrorKind::Unsupported)),
        }
    }
}
