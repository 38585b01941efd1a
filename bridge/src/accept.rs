//! Accepts connections, with limits on their number and speed, and timeouts.
//!
//! In: the listening socket. Out: served HTTP connections, each on a task of its own.
//!
//! 1. Each connection takes a place (`places`), and keeps it when it becomes a WebSocket. If no
//!    place is left, it gets 503 and is closed. `throttle` limits how fast its bytes are read.
//! 2. A connection is closed if the header of a request does not arrive in time (slowloris), or if
//!    it stays open too long without becoming a WebSocket.
//! 3. With TLS on, the first byte shows whether the client speaks TLS too; plain HTTP is redirected
//!    to the right address. The handshake must finish within the time allowed for a header.
//! 4. At shutdown, connections may finish the request in progress.

use std::convert::Infallible;
use std::io;
use std::sync::Arc;
use std::time::Duration;

use axum::Router;
use axum::extract::Request;
use axum::response::Response;
use hyper::body::Incoming;
use hyper::server::conn::http1;
use hyper::service::service_fn;
use hyper_util::rt::{TokioIo, TokioTimer};
use tokio::io::{AsyncRead, AsyncWrite};
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::watch;
use tokio::task::JoinSet;
use tokio::time::timeout;
use tokio_rustls::TlsAcceptor;
use tokio_rustls::server::TlsStream;
use tower::ServiceExt;

use crate::access_log::{Kind, Peer};
use crate::http;
use crate::places::Places;
use crate::shared::{Limits, Shared, Visitor};
use crate::throttle::Throttled;
use crate::tls::Identity;
use crate::trust;

const FULL: &[u8] =
    b"HTTP/1.1 503 Service Unavailable\r\ncontent-type: text/plain\r\ncontent-length: 42\r\n\
    retry-after: 5\r\nconnection: close\r\n\r\nslamlab has as many guests as it can take.";
/// Room for the header of a request, bytes.
const HEADER_BYTES: usize = 16 * 1024;
/// Pause when the system is out of handles: some are freed soon.
const OUT_OF_HANDLES: Duration = Duration::from_millis(50);

/// The first byte of a TLS handshake (RFC 8446 §5.1).
const HANDSHAKE: u8 = 22;

/// Accepts connections until `stopped`, then waits for the open ones to end. Without `tls` they are
/// not encrypted.
pub(crate) async fn run(
    listener: TcpListener,
    tls: Option<Identity>,
    shared: Arc<Shared>,
    stopped: watch::Receiver<bool>,
) {
    let trust = trust::routes(tls.as_ref());
    let router = http::router(&shared, trust.clone());
    let redirector = http::redirector(&shared, trust);
    let tls = tls.as_ref().map(Identity::acceptor);
    let stop = until(stopped.clone());
    tokio::pin!(stop);
    let places = Places::new(shared.limits);
    let mut open = JoinSet::new();
    loop {
        let accepted = tokio::select! {
            accepted = listener.accept() => accepted,
            Some(_) = open.join_next() => continue,
            () = &mut stop => break,
        };
        let (stream, from) = match accepted {
            Ok(accepted) => accepted,
            Err(error) => {
                tracing::warn!("a connection could not be taken: {error}");
                tokio::time::sleep(OUT_OF_HANDLES).await;
                continue;
            }
        };
        let place = places.enter(from.ip());
        shared.metrics.sockets.set(places.taken() as u64);
        match place {
            Some(place) => {
                let connection = Connection {
                    router: router.clone(),
                    redirector: redirector.clone(),
                    visitor: Visitor {
                        place: Arc::new(place),
                        peer: Peer::At(from),
                    },
                    limits: shared.limits,
                    stopped: stopped.clone(),
                };
                open.spawn(connection.enter(stream, tls.clone()));
            }
            None => {
                shared.metrics.turned_away.add(1);
                let what = format_args!("no place was left for a connection from {from}");
                shared.log.note(shared.clock.now(), Kind::Full, what);
                // What does not fit into an empty socket buffer at once is not worth waiting for.
                let _ = stream.try_write(FULL);
            }
        }
    }
    drop(listener);
    while open.join_next().await.is_some() {}
}

/// Ends when the bridge must stop.
pub(crate) async fn until(mut stopped: watch::Receiver<bool>) {
    // An error means that the sender is gone and nobody can ask for a stop any more: stop as well.
    let _ = stopped.wait_for(|stop| *stop).await;
}

/// One connection and its limits.
struct Connection {
    router: Router,
    /// For clients that speak plain HTTP to a TLS port.
    redirector: Router,
    visitor: Visitor,
    limits: Limits,
    stopped: watch::Receiver<bool>,
}

impl Connection {
    /// Does the TLS handshake if TLS is on, then serves the connection.
    async fn enter(mut self, stream: TcpStream, tls: Option<TlsAcceptor>) {
        // Commands are small and must not wait for others to fill a packet.
        if let Err(error) = stream.set_nodelay(true) {
            tracing::debug!("TCP_NODELAY: {error}");
        }
        let Some(tls) = tls else {
            return self.serve(Throttled::new(stream)).await;
        };
        let stopped = self.stopped.clone();
        let greeting = tokio::select! {
            greeting = timeout(self.limits.header, greet(stream, tls)) => greeting,
            () = until(stopped) => return,
            () = self.visitor.place.pushed_out() => return,
        };
        match greeting {
            Ok(Ok(Greeting::Secure(stream))) => self.serve(*stream).await,
            Ok(Ok(Greeting::Plain(stream))) => {
                self.router = self.redirector.clone();
                self.serve(stream).await;
            }
            Ok(Err(error)) => tracing::debug!("no handshake: {error}"),
            Err(_) => tracing::debug!("a handshake took too long"),
        }
    }

    /// Serves the connection until it ends or becomes a WebSocket.
    async fn serve(self, stream: impl AsyncRead + AsyncWrite + Unpin + Send + 'static) {
        let (router, visitor) = (self.router, self.visitor);
        let place = Arc::clone(&visitor.place);
        let service = service_fn(move |mut request: Request<Incoming>| {
            request.extensions_mut().insert(visitor.clone());
            answer(router.clone(), request)
        });
        let connection = http1::Builder::new()
            .timer(TokioTimer::new())
            .header_read_timeout(self.limits.header)
            .max_buf_size(HEADER_BYTES)
            .serve_connection(TokioIo::new(stream), service)
            .with_upgrades();
        tokio::pin!(connection);
        let ended = tokio::select! {
            ended = &mut connection => ended,
            () = tokio::time::sleep(self.limits.request) => return,
            () = place.pushed_out() => return,
            () = until(self.stopped) => {
                connection.as_mut().graceful_shutdown();
                connection.await
            }
        };
        if let Err(error) = ended {
            tracing::debug!("a connection ended: {error}");
        }
    }
}

/// What the client speaks, by its first byte.
enum Greeting {
    Secure(Box<TlsStream<Throttled<TcpStream>>>),
    Plain(Throttled<TcpStream>),
}

async fn greet(stream: TcpStream, tls: TlsAcceptor) -> io::Result<Greeting> {
    let mut first = [0];
    stream.peek(&mut first).await?;
    if first != [HANDSHAKE] {
        return Ok(Greeting::Plain(Throttled::new(stream)));
    }
    let stream = tls.accept(Throttled::new(stream)).await?;
    Ok(Greeting::Secure(Box::new(stream)))
}

async fn answer(router: Router, request: Request<Incoming>) -> Result<Response, Infallible> {
    router.oneshot(request).await
}
