//! A link between the bridge and the store that breaks: a proxy on loopback.

use std::net::SocketAddr;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::Duration;

use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::{TcpListener, TcpStream};

/// A link that broke is down for so long.
const DOWN: Duration = Duration::from_millis(300);

/// What passed, and how often it broke.
#[derive(Debug, Default)]
pub struct Link {
    /// Towards the store.
    pub bytes: AtomicU64,
    pub breaks: AtomicU64,
    is_down: AtomicBool,
    /// Breaks that are still to come, and bytes between two.
    left: AtomicU64,
    every: u64,
}

impl Link {
    /// To `store`, breaking so many times, each after so many bytes; with its address.
    pub async fn start(
        store: SocketAddr,
        breaks: u64,
        every: u64,
    ) -> std::io::Result<(Arc<Self>, SocketAddr)> {
        let listener = TcpListener::bind(("127.0.0.1", 0)).await?;
        let address = listener.local_addr()?;
        let link = Arc::new(Self {
            left: AtomicU64::new(breaks),
            every,
            ..Self::default()
        });
        let shared = Arc::clone(&link);
        tokio::spawn(async move {
            while let Ok((near, _)) = listener.accept().await {
                let link = Arc::clone(&shared);
                tokio::spawn(async move {
                    // Whatever ends a connection, the other end learns of it.
                    let _ = link.carry(near, store).await;
                });
            }
        });
        Ok((link, address))
    }

    async fn carry(&self, near: TcpStream, store: SocketAddr) -> std::io::Result<()> {
        if self.is_down.load(Ordering::Relaxed) {
            return Ok(());
        }
        let far = TcpStream::connect(store).await?;
        let (mut from_near, mut to_near) = near.into_split();
        let (mut from_far, mut to_far) = far.into_split();
        let back = async {
            tokio::io::copy(&mut from_far, &mut to_near)
                .await
                .map(|_| ())
        };
        let there = async {
            let mut buffer = vec![0; 1 << 14];
            loop {
                let count = from_near.read(&mut buffer).await?;
                if count == 0 {
                    return Ok(());
                }
                to_far
                    .write_all(buffer.get(..count).unwrap_or_default())
                    .await?;
                if self.breaks_after(count as u64) {
                    return Err(std::io::Error::from(std::io::ErrorKind::ConnectionReset));
                }
            }
        };
        let done = tokio::select! {
            done = there => done,
            done = back => done,
        };
        if let Err(error) = &done
            && error.kind() == std::io::ErrorKind::ConnectionReset
        {
            self.go_down().await;
        }
        done
    }

    /// Whether the link breaks behind these bytes.
    fn breaks_after(&self, count: u64) -> bool {
        let before = self.bytes.fetch_add(count, Ordering::Relaxed);
        let is_due = (before + count) / self.every > before / self.every;
        let takes = |left: u64| left.checked_sub(1);
        let breaks = is_due
            && self
                .left
                .fetch_update(Ordering::Relaxed, Ordering::Relaxed, takes)
                .is_ok();
        if breaks {
            self.breaks.fetch_add(1, Ordering::Relaxed);
        }
        breaks
    }

    /// Nothing passes for a while.
    async fn go_down(&self) {
        self.is_down.store(true, Ordering::Relaxed);
        tokio::time::sleep(DOWN).await;
        self.is_down.store(false, Ordering::Relaxed);
    }
}
