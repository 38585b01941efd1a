//! `slamlab-bridge`: flags, log, signals. The work is in the library.

use std::net::{IpAddr, Ipv4Addr, SocketAddr};
use std::path::PathBuf;
use std::process::ExitCode;

use clap::Parser;

mod open;

/// Serves slamlab's page.
#[derive(Parser)]
#[command(version)]
struct Flags {
    /// Address to listen on; 0.0.0.0 opens the page to the whole network
    #[arg(long, value_name = "IP:PORT", default_value_t = SocketAddr::new(IpAddr::V4(Ipv4Addr::LOCALHOST), 8080))]
    listen: SocketAddr,
    /// Port to listen on, in place of the one in --listen; 0 takes any free one
    #[arg(long)]
    port: Option<u16>,
    /// Folder of the built page
    #[arg(long, value_name = "DIR", default_value = "www/dist")]
    page: PathBuf,
    /// Show the page in the default browser
    #[arg(long)]
    open: bool,
}

#[tokio::main]
async fn main() -> ExitCode {
    match serve(Flags::parse()).await {
        Ok(()) => ExitCode::SUCCESS,
        // One sentence, also where RUST_BACKTRACE is set.
        Err(error) => {
            eprintln!("slamlab-bridge: {error:#}");
            ExitCode::FAILURE
        }
    }
}

async fn serve(mut flags: Flags) -> anyhow::Result<()> {
    tracing_subscriber::fmt()
        .with_writer(std::io::stderr)
        .with_target(false)
        .init();
    if let Some(port) = flags.port {
        flags.listen.set_port(port);
    }
    slamlab_bridge::check_page(&flags.page)?;
    let listener = slamlab_bridge::bind(flags.listen).await?;
    let url = url(listener.local_addr()?);
    println!("slamlab is at {url} (Ctrl+C stops it)");
    if flags.open {
        open::in_browser(&url);
    }
    Ok(slamlab_bridge::run(listener, flags.page, stop_signal()).await?)
}

/// The address to type: a server that listens everywhere is reached here by `localhost`.
fn url(address: SocketAddr) -> String {
    if address.ip().is_unspecified() {
        format!("http://localhost:{}/", address.port())
    } else {
        format!("http://{address}/")
    }
}

/// Ends at Ctrl+C, and on Unix at SIGTERM.
async fn stop_signal() {
    let interrupt = async {
        if let Err(error) = tokio::signal::ctrl_c().await {
            tracing::warn!("Ctrl+C will not stop the bridge: {error}");
            std::future::pending::<()>().await;
        }
    };
    tokio::select! {
        () = interrupt => (),
        () = terminate() => (),
    }
}

#[cfg(unix)]
async fn terminate() {
    use tokio::signal::unix::{SignalKind, signal};
    match signal(SignalKind::terminate()) {
        Ok(mut signal) => {
            signal.recv().await;
        }
        Err(error) => {
            tracing::warn!("SIGTERM will not stop the bridge gracefully: {error}");
            std::future::pending().await
        }
    }
}

#[cfg(not(unix))]
async fn terminate() {
    std::future::pending().await
}
