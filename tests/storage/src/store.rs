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
pub const KEY: (&str, &str) = ("slamlab", "a-secret-of-the-report");

/// Begins to serve the buckets in `root`; its address.
pub async fn start(root: &Path) -> Result<SocketAddr> {
    let files = FileSystem::new(root).map_err(|error| anyhow!("{error:?}"))?;
    let mut service = S3ServiceBuilder::new(files);
    service.set_auth(SimpleAuth::from_single(KEY.0, KEY.1));
    let service = service.build();
    let listener = TcpListener::bind(("127.0.0.1", 0)).await?;
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
