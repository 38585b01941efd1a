//! Limits how fast bytes are read from a socket: a client that sends more must wait, and costs no
//! more than one at that rate. Counting bytes also limits data that never becomes a message, such
//! as endless fragments.

use std::io;
use std::pin::Pin;
use std::task::{Context, Poll, ready};
use std::time::Duration;

use tokio::io::{AsyncRead, AsyncWrite, ReadBuf};
use tokio::time::{Instant, Sleep, sleep};

/// Bytes per second on average: several times what a driver sends in text.
const RATE: f64 = 32.0 * 1024.0;
/// Bytes of a burst: one of the longest messages, and some more.
const BURST: f64 = 96.0 * 1024.0;
/// Bytes after which other connections get a turn, because small frames are many.
const TURN: usize = 8 * 1024;

/// A stream that is read no faster than this.
pub(crate) struct Throttled<S> {
    stream: S,
    /// Bytes that may be read now; below 0 if the last read took more.
    level: f64,
    filled: Instant,
    /// Bytes since other connections had a turn.
    run: usize,
    pause: Pin<Box<Sleep>>,
}

impl<S> Throttled<S> {
    pub(crate) fn new(stream: S) -> Self {
        Self {
            stream,
            level: BURST,
            filled: Instant::now(),
            run: 0,
            pause: Box::pin(sleep(Duration::ZERO)),
        }
    }

    /// How long to wait before the next read.
    fn wait(&mut self) -> Duration {
        let passed = self.filled.elapsed().as_secs_f64();
        self.filled += Duration::from_secs_f64(passed);
        self.level = (self.level + RATE * passed).min(BURST);
        Duration::from_secs_f64((1.0 - self.level).max(0.0) / RATE)
    }
}

impl<S: AsyncRead + Unpin> AsyncRead for Throttled<S> {
    fn poll_read(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        buffer: &mut ReadBuf<'_>,
    ) -> Poll<io::Result<()>> {
        if self.run >= TURN {
            self.run = 0;
            context.waker().wake_by_ref();
            return Poll::Pending;
        }
        let wait = self.wait();
        if !wait.is_zero() {
            let until = Instant::now() + wait;
            self.pause.as_mut().reset(until);
            ready!(self.pause.as_mut().poll(context));
        }
        let before = buffer.filled().len();
        let read = Pin::new(&mut self.stream).poll_read(context, buffer);
        let count = buffer.filled().len() - before;
        self.level -= count as f64;
        self.run += count;
        read
    }
}

impl<S: AsyncWrite + Unpin> AsyncWrite for Throttled<S> {
    fn poll_write(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        bytes: &[u8],
    ) -> Poll<io::Result<usize>> {
        Pin::new(&mut self.stream).poll_write(context, bytes)
    }

    fn poll_flush(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.stream).poll_flush(context)
    }

    fn poll_shutdown(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.stream).poll_shutdown(context)
    }

    fn poll_write_vectored(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        bytes: &[io::IoSlice<'_>],
    ) -> Poll<io::Result<usize>> {
        Pin::new(&mut self.stream).poll_write_vectored(context, bytes)
    }

    fn is_write_vectored(&self) -> bool {
        self.stream.is_write_vectored()
    }
}

#[cfg(test)]
mod tests {
    use tokio::io::{AsyncReadExt, AsyncWriteExt, duplex};

    use super::*;

    #[tokio::test(start_paused = true)]
    async fn a_burst_comes_at_once_and_the_rest_at_the_rate() {
        let (mut sender, receiver) = duplex(8 * 1024);
        let mut throttled = Throttled::new(receiver);
        let total = BURST as usize + 5 * RATE as usize;
        tokio::spawn(async move { sender.write_all(&vec![7; total]).await });
        let start = Instant::now();
        let mut bytes = vec![0; BURST as usize];
        throttled.read_exact(&mut bytes).await.unwrap();
        assert_eq!(start.elapsed(), Duration::ZERO);
        let rest = throttled.read_to_end(&mut bytes).await.unwrap();
        let took = start.elapsed().as_secs_f64();
        assert_eq!(rest, 5 * RATE as usize);
        // A read takes everything available, and the next one waits for that.
        assert!((4.7..5.1).contains(&took), "{took} s");
        assert!(bytes.iter().all(|byte| *byte == 7));
    }
}
