//! `slamlab-bridge`: flags, log, signals. The work is in the library.

use std::io::Write;
use std::net::{SocketAddr, UdpSocket};
use std::path::Path;
use std::process::ExitCode;

use anyhow::Context;
use clap::Parser;
use slamlab_bridge::announce::{self, Announced, Announcement};
use slamlab_bridge::record;
use slamlab_bridge::rights::{Files, Keys};
use slamlab_bridge::settings::{Settings, SourceSettings, Tls};
use slamlab_bridge::source::{Source, SourceName};
use slamlab_bridge::tls::{Identity, UNNAMED};
use slamlab_bridge::udp;
use slamlab_bridge::{Config, Page, address, doctor, trust};

mod answer;
mod flags;
mod log;
mod open;
mod token_command;

use answer::answer;
use flags::{Command, Flags, RecordFlags, ServeFlags};
use slamlab_core::slam::Method;
use slamlab_core::wire::message::Watching;

#[tokio::main]
async fn main() -> ExitCode {
    match obey(Flags::parse()).await {
        Ok(()) => ExitCode::SUCCESS,
        // One sentence, even if RUST_BACKTRACE is set.
        Err(error) => {
            // If even that cannot be written, the exit code tells.
            let _ = writeln!(std::io::stderr(), "slamlab-bridge: {}", sentence(&error));
            ExitCode::FAILURE
        }
    }
}

/// The error and its causes, without repeating a cause that is already in the text.
fn sentence(error: &anyhow::Error) -> String {
    error.chain().fold(String::new(), |said, cause| {
        let cause = cause.to_string();
        match () {
            () if said.is_empty() => cause,
            () if said.contains(&cause) => said,
            () => format!("{said}: {cause}"),
        }
    })
}

async fn obey(flags: Flags) -> anyhow::Result<()> {
    let _log = log::begin();
    match flags.command {
        None => serve(flags.serve).await,
        Some(Command::Serve(flags)) => serve(flags).await,
        Some(Command::Record(flags)) => record(flags).await,
        Some(Command::Replay {
            file,
            serve: mut flags,
        }) => {
            let name = format!("replay:{}", file.display());
            let sources = flags.settings.source.get_or_insert_default();
            sources.push(name.parse()?);
            serve(flags).await
        }
        Some(Command::Export { file, to, method }) => export(&file, &to, method),
        Some(Command::Config(flags)) => show_config(flags),
        Some(Command::Token(flags)) => token_command::run(*flags),
        Some(Command::Doctor { ports }) => look_at(ports).await,
        Some(Command::Udp {
            paths,
            listen,
            client_port,
        }) => serve_udp(paths, listen, client_port).await,
    }
}

async fn serve(flags: ServeFlags) -> anyhow::Result<()> {
    let settings = flags.complete()?;
    let page = Page::choose(settings.page.clone());
    page.check()?;
    let sources = sources_of(&settings)?;
    let token = match sources.is_empty() {
        true => None,
        false => Some(token_command::owner(&settings)?),
    };
    let tls = match settings.tls()? {
        Tls::Off => None,
        Tls::Own => Some(Identity::load_or_make(&token_command::folder(&settings)?)?),
        Tls::Files { cert, key } => Some(Identity::load(&cert, &key)?),
    };
    let listener = slamlab_bridge::bind(settings.address()).await?;
    let stop = stop_signal();
    let listening = listener.local_addr()?;
    let urls = address::urls(listening, tls.is_some());
    let urls = match &tls {
        Some(identity) => identity.named(urls),
        None => urls,
    };
    let is_private = settings.private == Some(true);
    let mut lines = lines_for(&urls, tls.as_ref(), token.is_some());
    if token.is_some() {
        let exposure = address::exposure(listening, tls.is_some(), is_private);
        lines.extend(exposure.map(|exposure| format!("{exposure}\n")));
        let router = settings.zenoh()?.map(|zenoh| zenoh.router);
        lines.extend(router.map(|router| {
            let exposure = address::exposure_at_router(router.is_tls);
            format!("{exposure}\n")
        }));
    }
    let whole = urls.first().map(|url| {
        let secret = token.as_ref().map(|token| token.reveal());
        secret.map_or(url.clone(), |secret| format!("{url}#token={secret}"))
    });
    let keys = match &token {
        None => Keys::None,
        Some(_) => Keys::Files(Files {
            token: token_command::path(&settings)?,
            rights: token_command::rights(&settings)?,
        }),
    };
    let hosts = settings.allow_host.clone().unwrap_or_default();
    let lacking = tls.as_ref().map(|identity| identity.lacking(&hosts));
    let lacking = lacking.unwrap_or_default();
    if !lacking.is_empty() {
        tracing::warn!(
            "the bridge's own certificate does not name {}, so that browsers refuse what --allow-host lets in: --tls-cert \
             and --tls-key take one that does",
            lacking.join(", ")
        );
    }
    let (is_tls, keep, audit) = (tls.is_some(), settings.keep(), settings.audit());
    let map = settings.map()?;
    let (storage, zenoh) = (settings.storage()?, settings.zenoh()?);
    let config = Config {
        page: Some(page),
        sources,
        keys,
        watching: is_private.then_some(Watching::Token),
        origins: settings.allow_origin.unwrap_or_default(),
        hosts,
        foxglove: settings.foxglove == Some(true),
        rosbridge: settings.rosbridge == Some(true),
        tls,
        keep,
        audit,
        storage,
        record: settings.record,
        map,
        zenoh,
        ..Config::default()
    };
    // Print the address only now: before this, nobody answered there.
    let bridge = slamlab_bridge::start(listener, config)?;
    say(&lines);
    if let (Some(true), Some(whole), Some(url)) = (settings.open, whole, urls.first()) {
        open::in_browser(&whole, url);
    }
    let _announced = match settings.mdns {
        Some(true) => in_the_network(listening, is_tls),
        _ => None,
    };
    Ok(bridge.until(stop).await?)
}

fn sources_of(settings: &Settings) -> anyhow::Result<Vec<Box<dyn Source>>> {
    let sources = settings.source.iter().flatten();
    Ok(sources
        .map(SourceSettings::open)
        .collect::<Result<_, _>>()?)
}

/// The first line is for programs as well as people; the others are for people.
fn lines_for(urls: &[String], tls: Option<&Identity>, has_token: bool) -> Vec<String> {
    let mut lines = vec![];
    for (at, url) in urls.iter().enumerate() {
        lines.push(match at {
            0 => format!("slamlab is at {url} (Ctrl+C stops it)\n"),
            _ => format!("  from elsewhere: {url}\n"),
        });
    }
    if urls.is_empty() {
        lines.push(format!("slamlab serves, but {UNNAMED} (Ctrl+C stops it)\n"));
    }
    lines.extend(tls.map(|tls| {
        let fingerprint = tls.fingerprint();
        match (tls.authority(), address::for_a_phone(urls)) {
            (Some(_), Some(url)) => format!(
                "{} explains how a phone comes to trust it; the SHA-256 fingerprint there must be {fingerprint}\n",
                trust::address(url, "").trim_end_matches("#sha256=")
            ),
            _ => format!("its certificate's SHA-256 fingerprint is {fingerprint}\n"),
        }
    }));
    if has_token {
        lines.push(
            "`slamlab-bridge token` shows the address with which one may drive; `token add` makes one for somebody else\n".into(),
        );
    }
    lines
}

fn say(lines: &[String]) {
    let mut out = std::io::stdout().lock();
    // Whoever started the bridge may close the pipe after the first line: the bridge goes on
    // serving.
    let _ = out
        .write_all(lines.concat().as_bytes())
        .and_then(|()| out.flush());
}

fn in_the_network(listening: SocketAddr, is_tls: bool) -> Option<Announced> {
    let announced = announce::announce(&Announcement {
        listening,
        is_tls,
        mdns_port: Announcement::MDNS_PORT,
    });
    announced.map_err(|error| tracing::warn!("{error}")).ok()
}

fn show_config(flags: ServeFlags) -> anyhow::Result<()> {
    let settings = flags.complete()?;
    if let Tls::Files { cert, key } = settings.tls()? {
        Identity::load(&cert, &key)?;
    }
    slamlab_bridge::check(&Config {
        sources: sources_of(&settings)?,
        record: settings.record.clone(),
        storage: settings.storage()?,
        map: settings.map()?,
        zenoh: settings.zenoh()?,
        ..Config::default()
    })?;
    answer!(
        "{}",
        toml::to_string(&settings.without_secrets())?.trim_end()
    )
}

/// Records without serving anybody: the listener takes any free port, on this machine only.
async fn record(flags: RecordFlags) -> anyhow::Result<()> {
    let sources = open_all(&flags.source)?;
    let listener = slamlab_bridge::bind(SocketAddr::from(([127, 0, 0, 1], 0))).await?;
    let stop = stop_signal();
    let said = format!("recording to {} (Ctrl+C ends it)\n", flags.file.display());
    let config = Config {
        sources,
        watching: Some(Watching::Token),
        record: Some(flags.file),
        ..Config::default()
    };
    // Say so only once it is recording.
    let recording = slamlab_bridge::start(listener, config)?;
    say(&[said]);
    Ok(recording.until(stop).await?)
}

/// Maps a recording, and writes a copy with the map.
fn export(file: &Path, to: &Path, method: Method) -> anyhow::Result<()> {
    let done = record::export(file, to, method)?;
    for note in &done.notes {
        let _ = writeln!(std::io::stderr(), "{}: {note}", file.display());
    }
    let (messages, poses, maps) = (done.messages, done.poses, done.maps);
    answer!(
        "{}: {messages} messages, {poses} poses, {maps} maps",
        to.display()
    )?;
    Ok(())
}

/// Examines ports in parallel, and prints the findings in the order of the ports.
async fn look_at(mut ports: Vec<String>) -> anyhow::Result<()> {
    if ports.is_empty() {
        ports = doctor::ports().context("cannot list the serial ports")?;
    }
    anyhow::ensure!(
        !ports.is_empty(),
        "there is no serial port: plug the device in; on a Raspberry Pi's own pins, switch the serial port on and its \
         console off (raspi-config)"
    );
    answer!(
        "looking at {}; this takes up to a quarter of a minute",
        ports.join(", ")
    )?;
    let looks: Vec<_> = ports
        .into_iter()
        .map(|port| tokio::task::spawn_blocking(move || doctor::examine(&port)))
        .collect();
    let mut are_well = true;
    for look in looks {
        let finding = look.await.context("the doctor broke down")?;
        answer!("{finding}")?;
        are_well &= finding.is_well();
    }
    anyhow::ensure!(are_well, "not all is well");
    Ok(())
}

/// Serves a lidar by UDP until the program must stop.
async fn serve_udp(paths: Vec<String>, listen: SocketAddr, client_port: u16) -> anyhow::Result<()> {
    let socket =
        UdpSocket::bind(listen).with_context(|| format!("cannot listen on UDP {listen}"))?;
    answer!(
        "a lidar is at UDP {} (Ctrl+C stops it)",
        socket.local_addr()?
    )?;
    let stop = stop_signal();
    let _server = udp::start(socket, paths, client_port)?;
    stop.await;
    Ok(())
}

fn open_all(names: &[SourceName]) -> anyhow::Result<Vec<Box<dyn Source>>> {
    names.iter().map(|name| Ok(name.open(None)?)).collect()
}

/// Ends at Ctrl+C, and on Unix at SIGTERM. Signals count from this call on, not from the first
/// poll, because the bridge may be stopped as soon as its address is printed.
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_cause_is_said_twice() {
        let refused = || std::io::Error::from(std::io::ErrorKind::PermissionDenied);
        let inner = anyhow::Error::from(refused());
        let said = inner.to_string();
        let doubled = anyhow::Error::from(refused()).context(format!("token file x: {said}"));
        assert_eq!(sentence(&doubled), format!("token file x: {said}"));
        let plain = anyhow::Error::from(refused()).context("where is the token?");
        assert_eq!(sentence(&plain), format!("where is the token?: {said}"));
    }
}
