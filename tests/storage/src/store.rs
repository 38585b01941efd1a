//! A real S3-compatible server on loopback, whose buckets are folders, and which takes nothing more
//! when it is told so.

use std::net::SocketAddr;
use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};

use anyhow::{Result, anyhow};
use hyper::body::Incoming;
use hyper::service::service_fn;
use hyper::{Method, Request, Response, StatusCode};
use hyper_util::rt::{TokioExecutor, TokioIo};
use hyper_util::server::conn::auto::Builder;
use s3s::auth::SimpleAuth;
use s3s::service::S3ServiceBuilder;
use s3s::{Body, HttpError};
use s3s_fs::FileSystem;
use tokio::net::TcpListener;

/// Who may.
pub(crate) const KEY: (&str, &str) = ("slamlab", "a-secret-of-the-report");

/// Why a store takes nothing: the status and code of its answer.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Refusal(StatusCode, &'static str);

impl Refusal {
    /// As MinIO answers where its disk has no room.
    pub(crate) const FULL: Self = Self(StatusCode::INSUFFICIENT_STORAGE, "XMinioStorageFull");
    /// As Amazon's S3 answers a key that may read and not write.
    pub(crate) const DENIED: Self = Self(StatusCode::FORBIDDEN, "AccessDenied");

    fn answer(self) -> Response<Body> {
        let Self(status, code) = self;
        let text = format!(
            r#"<?xml version="1.0" encoding="UTF-8"?><Error><Code>{code}</Code><Message>Refused.</Message></Error>"#
        );
        let mut answer = Response::new(Body::from(text));
        *answer.status_mut() = status;
        answer
    }
}

/// A store that is served, until the program ends.
#[derive(Clone, Debug)]
pub(crate) struct Store {
    pub(crate) address: SocketAddr,
    refusal: Arc<Mutex<Option<Refusal>>>,
}

impl Store {
    /// Begins to serve the buckets in `root`, at this port or, for 0, at a free one.
    pub(crate) async fn start(root: &Path, port: u16) -> Result<Self> {
        let files = FileSystem::new(root).map_err(|error| anyhow!("{error:?}"))?;
        let mut service = S3ServiceBuilder::new(files);
        service.set_auth(SimpleAuth::from_single(KEY.0, KEY.1));
        let service = service.build();
        let listener = TcpListener::bind(("127.0.0.1", port)).await?;
        let store = Self {
            address: listener.local_addr()?,
            refusal: Arc::default(),
        };
        let shared = store.clone();
        tokio::spawn(async move {
            while let Ok((socket, _)) = listener.accept().await {
                let (service, store) = (service.clone(), shared.clone());
                let answer = service_fn(move |request: Request<Incoming>| {
                    let refusal = store.refusal_of(request.method());
                    let served = service.clone();
                    async move {
                        match refusal {
                            Some(refusal) => Ok::<_, HttpError>(refusal.answer()),
                            None => served.call(request.map(Body::from)).await,
                        }
                    }
                });
                tokio::spawn(async move {
                    let http = Builder::new(TokioExecutor::new());
                    // A connection that the link cut is none of its faults.
                    let _ = http.serve_connection(TokioIo::new(socket), answer).await;
                });
            }
        });
        Ok(store)
    }

    /// What is written is refused from now on, or taken again.
    pub(crate) fn refuse(&self, refusal: Option<Refusal>) {
        *self.refusal.lock().unwrap_or_else(PoisonError::into_inner) = refusal;
    }

    fn refusal_of(&self, method: &Method) -> Option<Refusal> {
        let refusal = *self.refusal.lock().unwrap_or_else(PoisonError::into_inner);
        refusal.filter(|_| matches!(*method, Method::PUT | Method::POST))
    }
}
