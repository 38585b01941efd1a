//! The command line.

use std::net::{IpAddr, Ipv4Addr, SocketAddr};
use std::path::PathBuf;

use clap::{Args, Parser, Subcommand};
use slamlab_bridge::source::SourceName;
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
    /// Address to listen on; 0.0.0.0 opens the page to the whole network
    #[arg(long, value_name = "IP:PORT", default_value_t = LOCAL)]
    pub(crate) listen: SocketAddr,
    /// Port to listen on, in place of the one in --listen; 0 takes any free one
    #[arg(long)]
    pub(crate) port: Option<u16>,
    /// Folder of the built page
    #[arg(long, value_name = "DIR", default_value = "www/dist")]
    pub(crate) page: PathBuf,
    /// Show the page in the default browser
    #[arg(long)]
    pub(crate) open: bool,
    /// Robot or sensor behind the page: sim:WORLD[,SENSOR], replay:FILE, rp6:PORT, rplidar:PORT, ld06:PORT; may stand more than once
    #[arg(long, value_name = "KIND:WHICH")]
    pub(crate) source: Vec<SourceName>,
    /// Record to this new MCAP file
    #[arg(long, value_name = "FILE")]
    pub(crate) record: Option<PathBuf>,
    /// Let nobody watch without the token
    #[arg(long)]
    pub(crate) private: bool,
    /// Origin of another page that may connect, as a browser writes it; may stand more than once
    #[arg(long, value_name = "ORIGIN")]
    pub(crate) allow_origin: Vec<String>,
    /// Let Foxglove and Lichtblick watch, at ws://HOST:PORT/foxglove
    #[arg(long, conflicts_with = "private")]
    pub(crate) foxglove: bool,
    #[command(flatten)]
    pub(crate) token: TokenFile,
}

#[derive(Args)]
pub(crate) struct RecordFlags {
    /// New MCAP file
    pub(crate) file: PathBuf,
    /// Robot or sensor: sim:WORLD[,SENSOR], rp6:PORT, rplidar:PORT, ld06:PORT; may stand more than once
    #[arg(long, value_name = "KIND:WHICH", required = true)]
    pub(crate) source: Vec<SourceName>,
}

#[derive(Args)]
pub(crate) struct TokenFlags {
    /// Make a new token; the old one is worth nothing from the bridge's next start on
    #[arg(long)]
    pub(crate) new: bool,
    /// Address that the bridge listens on
    #[arg(long, value_name = "IP:PORT", default_value_t = LOCAL)]
    pub(crate) listen: SocketAddr,
    #[command(flatten)]
    pub(crate) token: TokenFile,
}

#[derive(Args)]
pub(crate) struct TokenFile {
    /// File of the token [default: slamlab/token in the user's configuration]
    #[arg(long, value_name = "FILE")]
    pub(crate) token_file: Option<PathBuf>,
}

const LOCAL: SocketAddr = SocketAddr::new(IpAddr::V4(Ipv4Addr::LOCALHOST), 8080);

const UDP: SocketAddr = SocketAddr::new(IpAddr::V4(Ipv4Addr::LOCALHOST), pilch::SERVER_PORT);

#[cfg(test)]
mod tests {
    use clap::CommandFactory;

    #[test]
    fn the_command_line_is_consistent() {
        super::Flags::command().debug_assert();
    }
}
