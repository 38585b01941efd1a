//! A real S3-compatible server on loopback, whose buckets are folders.

use std::net::SocketAddr;
use std::path::Path;

use anyhow::{Result, anyhow};
use hyper_util::rt::{TokioExecutor, TokioIo};
use hyper_util::server::conn::auto::Builder;
use s3s::auth::SimpleAuth;
use s3s::service::S3ServiceBuilder;
use s3s_fs::FileSystem;
use tokio::net::TcpListener;

/// Who may.
pub(crate) const KEY: (&str, &str) = ("slamlab", "a-secret-of-the-report");

/// Begins to serve the buckets in `root`, at this port or, for 0, at a free one; its address.
pub(crate) async fn start(root: &Path, port: u16) -> Result<SocketAddr> {
    let files = FileSystem::new(root).map_err(|error| anyhow!("{error:?}"))?;
    let mut service = S3ServiceBuilder::new(files);
    service.set_auth(SimpleAuth::from_single(KEY.0, KEY.1));
    let service = service.build();
    let listener = TcpListener::bind(("127.0.0.1", port)).await?;
    let address = listener.local_addr()?;
    tokio::spawn(async move {
        while let Ok((socket, _)) = listener.accept().await {
            let service = service.clone();
            tokio::spawn(async move {
                let http = Builder::new(TokioExecutor::new());
                // A connection that the link cut is none of its faults.
                let _ = http.serve_connection(TokioIo::new(socket), service).await;
            });
        }
    });
    Ok(address)
}
