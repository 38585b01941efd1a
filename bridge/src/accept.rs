//! Accepts connections, with limits on their number and speed, and timeouts.
//!
//! In: the listening socket. Out: HTTP connections that are served, each on a task of its own.
//!
//! 1. Each has a place (`places`), and keeps it as a WebSocket. Where no place is left, it gets 503
//!    and is closed. What it sends is read no faster than clients speak (`throttle`).
//! 2. A request whose header is not there in time ends its connection (slowloris), and so does one
//!    that is open for too long without becoming a WebSocket.
//! 3. Where TLS is spoken, the first byte says whether the other side does too; who speaks HTTP in
//!    the clear is sent to the right address. The handshake must be over in the time that a header
//!    may take.
//! 4. At the end, connections may finish what they are at.

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
/// The system was out of handles: some are given back soon.
const OUT_OF_HANDLES: Duration = Duration::from_millis(50);

/// The first byte of a TLS handshake (RFC 8446 §5.1).
const HANDSHAKE: u8 = 22;

/// Takes connections until `stopped`, then waits for those that are open. Without `tls` they are in
/// the clear.
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

/// Ends when the bridge is to stop.
pub(crate) async fn until(mut stopped: watch::Receiver<bool>) {
    // An error means that whoever could stop it is gone: stop as well.
    let _ = stopped.wait_for(|stop| *stop).await;
}

/// One connection and what it may take.
struct Connection {
    router: Router,
    /// For who comes in the clear where TLS is spoken.
    redirector: Router,
    visitor: Visitor,
    limits: Limits,
    stopped: watch::Receiver<bool>,
}

impl Connection {
    /// Shakes hands where that is asked for, and serves the connection.
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

/// What the first bytes were.
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
