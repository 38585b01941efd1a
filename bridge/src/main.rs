//! `slamlab-bridge`: flags, log, signals. The work is in the library.

use std::net::{SocketAddr, UdpSocket};
use std::path::Path;
use std::process::ExitCode;

use anyhow::Context;
use clap::Parser;
use slamlab_bridge::doctor;
use slamlab_bridge::record;
use slamlab_bridge::source::Source;
use slamlab_bridge::token::{self, Token};
use slamlab_bridge::udp::{self, UdpConfig};
use slamlab_bridge::{Config, run};

mod flags;
mod open;

use flags::{Command, Flags, RecordFlags, ServeFlags, TokenFlags};
use slamlab_core::slam::Method;
use slamlab_core::wire::message::Watching;
use slamlab_core::wire::pilch::server::ServerConfig;

#[tokio::main]
async fn main() -> ExitCode {
    match obey(Flags::parse()).await {
        Ok(()) => ExitCode::SUCCESS,
        // One sentence, also where RUST_BACKTRACE is set.
        Err(error) => {
            eprintln!("slamlab-bridge: {error:#}");
            ExitCode::FAILURE
        }
    }
}

async fn obey(flags: Flags) -> anyhow::Result<()> {
    tracing_subscriber::fmt()
        .with_writer(std::io::stderr)
        .with_target(false)
        .init();
    match flags.command {
        None => serve(flags.serve).await,
        Some(Command::Serve(flags)) => serve(flags).await,
        Some(Command::Record(flags)) => record(flags).await,
        Some(Command::Replay {
            file,
            serve: mut flags,
        }) => {
            let name = format!("replay:{}", file.display());
            flags.source.push(name.parse()?);
            serve(flags).await
        }
        Some(Command::Export { file, to, method }) => export(&file, &to, method),
        Some(Command::Token(flags)) => show_token(&flags),
        Some(Command::Doctor { ports }) => look_at(ports).await,
        Some(Command::Udp {
            paths,
            listen,
            client_port,
        }) => serve_udp(paths, listen, client_port).await,
    }
}

async fn serve(mut flags: ServeFlags) -> anyhow::Result<()> {
    if let Some(port) = flags.port {
        flags.listen.set_port(port);
    }
    slamlab_bridge::check_page(&flags.page)?;
    let sources = open_all(&flags.source)?;
    let token = match sources.is_empty() {
        true => None,
        false => Some(token_of(&flags.token)?),
    };
    let listener = slamlab_bridge::bind(flags.listen).await?;
    let stop = stop_signal();
    let url = url(listener.local_addr()?);
    println!("slamlab is at {url} (Ctrl+C stops it)");
    if token.is_some() {
        println!("`slamlab-bridge token` shows the address with which one may drive");
    }
    if flags.open {
        let secret = token.as_ref().map(Token::reveal);
        open::in_browser(
            &secret.map_or(url.clone(), |secret| format!("{url}#token={secret}")),
            &url,
        );
    }
    let config = Config {
        page: Some(flags.page),
        sources,
        token,
        watching: flags.private.then_some(Watching::Token),
        origins: flags.allow_origin,
        foxglove: flags.foxglove,
        record: flags.record,
        ..Config::default()
    };
    Ok(run(listener, config, stop).await?)
}

/// Records without serving anything to anybody: the listener takes a port of this machine that nobody knows.
async fn record(flags: RecordFlags) -> anyhow::Result<()> {
    let sources = open_all(&flags.source)?;
    let listener = slamlab_bridge::bind(SocketAddr::from(([127, 0, 0, 1], 0))).await?;
    let stop = stop_signal();
    println!("recording to {} (Ctrl+C ends it)", flags.file.display());
    let config = Config {
        sources,
        watching: Some(Watching::Token),
        record: Some(flags.file),
        ..Config::default()
    };
    Ok(run(listener, config, stop).await?)
}

/// Maps a recording, and writes it with the map.
fn export(file: &Path, to: &Path, method: Method) -> anyhow::Result<()> {
    let done = record::export(file, to, method)?;
    for note in &done.notes {
        eprintln!("{}: {note}", file.display());
    }
    let (messages, poses, maps) = (done.messages, done.poses, done.maps);
    println!(
        "{}: {messages} messages, {poses} poses, {maps} maps",
        to.display()
    );
    Ok(())
}

/// Looks at ports side by side, and prints what it finds in their order.
async fn look_at(mut ports: Vec<String>) -> anyhow::Result<()> {
    if ports.is_empty() {
        ports = doctor::ports().context("cannot list the serial ports")?;
    }
    anyhow::ensure!(
        !ports.is_empty(),
        "there is no serial port: plug the device in; on a Raspberry Pi's own pins, switch the serial port on and its \
         console off (raspi-config)"
    );
    println!(
        "looking at {}; this takes up to a quarter of a minute",
        ports.join(", ")
    );
    let looks: Vec<_> = ports
        .into_iter()
        .map(|port| tokio::task::spawn_blocking(move || doctor::examine(&port)))
        .collect();
    let mut are_well = true;
    for look in looks {
        let finding = look.await.context("the doctor broke down")?;
        println!("{finding}");
        are_well &= finding.is_well();
    }
    anyhow::ensure!(are_well, "not all is well");
    Ok(())
}

/// Serves a lidar by UDP until the program should stop.
async fn serve_udp(paths: Vec<String>, listen: SocketAddr, client_port: u16) -> anyhow::Result<()> {
    let socket =
        UdpSocket::bind(listen).with_context(|| format!("cannot listen on UDP {listen}"))?;
    println!(
        "a lidar is at UDP {} (Ctrl+C stops it)",
        socket.local_addr()?
    );
    let server = ServerConfig {
        paths,
        ..ServerConfig::default()
    };
    let stop = stop_signal();
    let _server = udp::start(
        socket,
        UdpConfig {
            server,
            client_port,
        },
    )?;
    stop.await;
    Ok(())
}

fn show_token(flags: &TokenFlags) -> anyhow::Result<()> {
    let token = if flags.new {
        let path = flags.token.path()?;
        Token::create(&path)?
    } else {
        token_of(&flags.token)?
    };
    println!("{}#token={}", url(flags.listen), token.reveal());
    Ok(())
}

fn token_of(flags: &flags::TokenFile) -> anyhow::Result<Token> {
    Ok(Token::load_or_create(&flags.path()?)?)
}

fn open_all(names: &[slamlab_bridge::source::SourceName]) -> anyhow::Result<Vec<Box<dyn Source>>> {
    names.iter().map(|name| Ok(name.open()?)).collect()
}

impl flags::TokenFile {
    fn path(&self) -> anyhow::Result<std::path::PathBuf> {
        match &self.token_file {
            Some(path) => Ok(path.clone()),
            None => token::default_path().context("where is the token?"),
        }
    }
}

/// The address to type: a server that listens everywhere is reached here by `localhost`.
fn url(address: SocketAddr) -> String {
    if address.ip().is_unspecified() {
        format!("http://localhost:{}/", address.port())
    } else {
        format!("http://{address}/")
    }
}

/// Ends at Ctrl+C, and on Unix at SIGTERM. From this call on, not from the first wait: whoever reads the address may stop
/// the bridge at once.
#[cfg(unix)]
fn stop_signal() -> impl Future<Output = ()> + Send + 'static {
    use tokio::signal::unix::{SignalKind, signal};
    let signals = [SignalKind::interrupt(), SignalKind::terminate()].map(signal);
    async move {
        let [interrupt, terminate] = signals.map(async |signal| match signal {
            Ok(mut signal) => {
                signal.recv().await;
            }
            Err(error) => {
                tracing::warn!("a signal will not stop the bridge gracefully: {error}");
                std::future::pending().await
            }
        });
        tokio::select! {
            () = interrupt => (),
            () = terminate => (),
        }
    }
}

#[cfg(not(unix))]
fn stop_signal() -> impl Future<Output = ()> + Send + 'static {
    async {
        if let Err(error) = tokio::signal::ctrl_c().await {
            tracing::warn!("Ctrl+C will not stop the bridge: {error}");
            std::future::pending::<()>().await;
        }
    }
}
