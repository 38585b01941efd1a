//! The command line.

use std::net::{IpAddr, Ipv4Addr, SocketAddr};
use std::path::PathBuf;

use clap::{Args, Parser, Subcommand};
use slamlab_bridge::settings::{Settings, SettingsError, SourceSettings};
use slamlab_bridge::source::{self, SourceName};
use slamlab_core::slam::Method;
use slamlab_core::wire::pilch;

/// Serves slamlab's page, and relays robot and sensors to it.
#[derive(Parser)]
#[command(version, args_conflicts_with_subcommands = true)]
pub(crate) struct Flags {
    #[command(subcommand)]
    pub(crate) command: Option<Command>,
    #[command(flatten)]
    pub(crate) serve: ServeFlags,
}

#[derive(Subcommand)]
pub(crate) enum Command {
    /// Serve the page, with robot and sensors behind it (the default)
    Serve(ServeFlags),
    /// Record robot and sensors to an MCAP file, without serving anything
    Record(RecordFlags),
    /// Serve the page with a recording behind it
    Replay {
        /// MCAP file made by `record` or `--record`
        file: PathBuf,
        #[command(flatten)]
        serve: ServeFlags,
    },
    /// Map a recording, and write it anew with /map, /pose and the transform from map to odom, for Foxglove, Rerun and ROS 2
    Export {
        /// MCAP file made by `record` or `--record`
        file: PathBuf,
        /// New MCAP file
        to: PathBuf,
        /// odometry, line-ekf or scan-matching
        #[arg(long, default_value = "scan-matching")]
        method: Method,
    },
    /// Print the settings that `serve` would use, from file, flags and defaults
    Config(ServeFlags),
    /// Show the address with which one may drive; makes a token if there is none
    Token(TokenFlags),
    /// Serve an RPLIDAR by the UDP protocol of Pilch's server; anyone who reaches the address may use it
    Udp {
        /// Ports that a client may have opened
        #[arg(value_name = "PORT", required = true)]
        paths: Vec<String>,
        /// Address to listen on
        #[arg(long, value_name = "IP:PORT", default_value_t = UDP)]
        listen: SocketAddr,
        /// Port at which the client listens
        #[arg(long, default_value_t = pilch::CLIENT_PORT)]
        client_port: u16,
    },
    /// Look at serial ports: say what answers, how well it works, and what to do where it does not
    Doctor {
        /// Ports to look at; all of the machine where none is named
        #[arg(value_name = "PORT")]
        ports: Vec<String>,
    },
}

#[derive(Args)]
pub(crate) struct ServeFlags {
    #[command(flatten)]
    pub(crate) place: PlaceFlags,
    /// Folder of the built page [default: the page inside the program, else www/dist]
    #[arg(long, value_name = "DIR")]
    pub(crate) page: Option<PathBuf>,
    /// Show the page in the default browser
    #[arg(long, num_args = 0..=1, require_equals = true, default_missing_value = "true", value_name = "BOOL")]
    pub(crate) open: Option<bool>,
    #[arg(long, value_name = "KIND:WHICH", help = source_help())]
    pub(crate) source: Vec<SourceName>,
    /// Record to this new MCAP file, or to one named by the time of day in this folder
    #[arg(long, value_name = "FILE or DIR/")]
    pub(crate) record: Option<PathBuf>,
    /// Let nobody watch without the token
    #[arg(long, num_args = 0..=1, require_equals = true, default_missing_value = "true", value_name = "BOOL")]
    pub(crate) private: Option<bool>,
    /// Origin of another page that may connect, as a browser writes it; may stand more than once
    #[arg(long, value_name = "ORIGIN")]
    pub(crate) allow_origin: Vec<String>,
    /// Let Foxglove and Lichtblick watch, at ws://HOST:PORT/foxglove; their web pages need an --allow-origin too
    #[arg(long, num_args = 0..=1, require_equals = true, default_missing_value = "true", value_name = "BOOL")]
    pub(crate) foxglove: Option<bool>,
    /// Speak rosbridge, at ws://HOST:PORT/rosbridge
    #[arg(long, num_args = 0..=1, require_equals = true, default_missing_value = "true", value_name = "BOOL")]
    pub(crate) rosbridge: Option<bool>,
    /// Announce the bridge in the local network [default: unless it listens on this machine only]
    #[arg(long, num_args = 0..=1, require_equals = true, default_missing_value = "true", value_name = "BOOL")]
    pub(crate) mdns: Option<bool>,
}

/// Where the bridge is, for `serve`, `config` and `token` alike.
#[derive(Args)]
pub(crate) struct PlaceFlags {
    /// File with all that stands here; flags win over it
    #[arg(long, value_name = "FILE")]
    pub(crate) config: Option<PathBuf>,
    /// Address to listen on; 0.0.0.0 opens the page to the whole network [default: 127.0.0.1:8080]
    #[arg(long, value_name = "IP:PORT")]
    pub(crate) listen: Option<SocketAddr>,
    /// Port to listen on, in place of the one in --listen; 0 takes any free one
    #[arg(long)]
    pub(crate) port: Option<u16>,
    /// File of the token [default: slamlab/token in the user's configuration]
    #[arg(long, value_name = "FILE")]
    pub(crate) token_file: Option<PathBuf>,
    /// Speak TLS; with a certificate of its own, beside the token, where none is named
    #[arg(long, num_args = 0..=1, require_equals = true, default_missing_value = "true", value_name = "BOOL")]
    pub(crate) tls: Option<bool>,
    /// Certificate chain to speak TLS with, PEM
    #[arg(long, value_name = "FILE")]
    pub(crate) tls_cert: Option<PathBuf>,
    /// Its private key, PEM
    #[arg(long, value_name = "FILE")]
    pub(crate) tls_key: Option<PathBuf>,
}

#[derive(Args)]
pub(crate) struct RecordFlags {
    /// New MCAP file, or folder that takes one named by the time of day
    pub(crate) file: PathBuf,
    #[arg(long, value_name = "KIND:WHICH", required = true, help = source_help())]
    pub(crate) source: Vec<SourceName>,
}

#[derive(Args)]
pub(crate) struct TokenFlags {
    /// Make a new token; the old one is worth nothing from the bridge's next start on
    #[arg(long)]
    pub(crate) new: bool,
    /// Show the address as a picture too, for a phone's camera
    #[arg(long)]
    pub(crate) qr: bool,
    #[command(flatten)]
    pub(crate) place: PlaceFlags,
}

impl ServeFlags {
    /// What the flags say, and the file below them.
    pub(crate) fn settings(self) -> Result<Settings, SettingsError> {
        let some = |list: Vec<String>| (!list.is_empty()).then_some(list);
        let source: Vec<_> = self.source.into_iter().map(SourceSettings::of).collect();
        let rest = Settings {
            page: self.page,
            open: self.open,
            private: self.private,
            foxglove: self.foxglove,
            rosbridge: self.rosbridge,
            allow_origin: some(self.allow_origin),
            record: self.record,
            mdns: self.mdns,
            source: (!source.is_empty()).then_some(source),
            ..Settings::default()
        };
        Ok(rest.over(self.place.settings()?))
    }
}

impl PlaceFlags {
    /// What the flags say, and the file below them.
    pub(crate) fn settings(self) -> Result<Settings, SettingsError> {
        let flags = Settings {
            listen: self.listen,
            port: self.port,
            token_file: self.token_file,
            tls: self.tls,
            tls_cert: self.tls_cert,
            tls_key: self.tls_key,
            ..Settings::default()
        };
        match self.config {
            Some(path) => Ok(flags.over(Settings::read(&path)?)),
            None => Ok(flags),
        }
    }
}

fn source_help() -> String {
    let forms = source::forms();
    format!("Robot or sensor: {forms}; may stand more than once; hides those of the file")
}

const UDP: SocketAddr = SocketAddr::new(IpAddr::V4(Ipv4Addr::LOCALHOST), pilch::SERVER_PORT);

#[cfg(test)]
mod tests {
    use clap::CommandFactory;

    #[test]
    fn the_command_line_is_consistent() {
        super::Flags::command().debug_assert();
    }
}
