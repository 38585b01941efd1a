//! The command line.

use std::net::{IpAddr, Ipv4Addr, SocketAddr};
use std::path::{Path, PathBuf};

use clap::{Args, Parser, Subcommand};
use slamlab_bridge::rights::Name;
use slamlab_bridge::settings::{Failsafe, MapSettings, Settings, SettingsError, source_help};
use slamlab_bridge::source::SourceName;
use slamlab_core::slam::{Method, UnknownMethod};
use slamlab_core::wire::message::Role;
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
    /// Map a recording, and write it again with /map, /pose and the transform from map to odom, for
    /// Foxglove, Rerun and ROS 2
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
    /// Show the owner's address, by the settings of `serve`; makes a token if there is none. Below
    /// it: rights for others, which a running bridge takes at once
    #[command(args_conflicts_with_subcommands = true)]
    Token(Box<TokenFlags>),
    /// Serve an RPLIDAR by the UDP protocol of Pilch's server; anyone who reaches the address may
    /// use it
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
    /// File with all that stands here; flags win over it
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) settings: Settings,
    #[command(flatten)]
    map: MapFlags,
}

/// Mapping without a page; each of these switches it on.
#[derive(Args)]
struct MapFlags {
    /// Map what the robot sees, without a page too; with a file (.slamlab) the map is kept in it,
    /// and a later start goes on in it
    #[arg(long, num_args = 0..=1, value_name = "FILE")]
    map: Option<Option<PathBuf>>,
    /// How it maps [default: scan-matching, the only method whose map can be kept]
    #[arg(long, value_name = "NAME", value_parser = method)]
    method: Option<Method>,
    /// A setting of mapping other than its default, as the page names it; may stand more than once
    #[arg(long, value_name = "KEY=NUMBER", value_parser = setting)]
    set: Vec<(String, f64)>,
    /// Write the map so often, seconds [default: 30]
    #[arg(long, value_name = "SECONDS")]
    map_save_seconds: Option<u64>,
    /// What the robot does when the link to its driver is lost [default: hold]
    #[arg(long, value_name = "WHAT")]
    on_link_loss: Option<Failsafe>,
    /// What it does when its battery gets low [default: hold]
    #[arg(long, value_name = "WHAT")]
    on_low_battery: Option<Failsafe>,
    /// Below so many volts the battery is low [default: 6.6]
    #[arg(long, value_name = "VOLTS")]
    low_volts: Option<f32>,
    /// The driver's right by which it goes home, made for that with `token add`
    #[arg(long, value_name = "NAME")]
    failsafe_right: Option<Name>,
}

impl MapFlags {
    fn settings(self) -> Option<MapSettings> {
        let is_on = self.map.is_some();
        let settings = MapSettings {
            file: self.map.flatten(),
            method: self.method.map(|method| method.name().to_owned()),
            save_seconds: self.map_save_seconds,
            on_link_loss: self.on_link_loss,
            on_low_battery: self.on_low_battery,
            low_volts: self.low_volts,
            failsafe_right: self.failsafe_right,
            set: self.set.into_iter().collect(),
        };
        (is_on || settings != MapSettings::default()).then_some(settings)
    }
}

fn method(name: &str) -> Result<Method, String> {
    name.parse()
        .map_err(|error: UnknownMethod| error.to_string())
}

fn setting(text: &str) -> Result<(String, f64), String> {
    let (key, number) = text.split_once('=').ok_or("expected KEY=NUMBER")?;
    let number = number
        .parse()
        .map_err(|error| format!("{number:?}: {error}"))?;
    Ok((key.to_owned(), number))
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
    #[command(subcommand)]
    pub(crate) command: Option<TokenCommand>,
    /// Make a new token of the owner; the old one is worth nothing from now on
    #[arg(long)]
    pub(crate) new: bool,
    /// Show the address as a picture too, for a phone's camera
    #[arg(long)]
    pub(crate) qr: bool,
    #[command(flatten)]
    pub(crate) serve: ServeFlags,
}

#[derive(Subcommand)]
pub(crate) enum TokenCommand {
    /// Make a right for somebody, and show its address, once
    Add(AddFlags),
    /// List the rights that there are
    List {
        #[command(flatten)]
        serve: ServeFlags,
    },
    /// Take a right away: who drives by it stops, and is shown out
    Revoke {
        /// Whose
        name: Name,
        #[command(flatten)]
        serve: ServeFlags,
    },
}

#[derive(Args)]
pub(crate) struct AddFlags {
    /// Whose: letters, digits, `.`, `-` and `_`
    pub(crate) name: Name,
    /// What it is good for: watcher, driver or owner
    #[arg(long, value_parser = role)]
    pub(crate) role: Role,
    /// Show the address as a picture too, for a phone's camera
    #[arg(long)]
    pub(crate) qr: bool,
    #[command(flatten)]
    pub(crate) serve: ServeFlags,
}

fn role(text: &str) -> Result<Role, String> {
    let found = Role::ALL.iter().find(|role| role.name() == text);
    let expected = || format!("expected one of {}", Role::NAMES.join(", "));
    found.copied().ok_or_else(expected)
}

impl ServeFlags {
    /// The complete settings: flags override the file, which overrides the defaults.
    pub(crate) fn complete(self) -> anyhow::Result<Settings> {
        let file = self.config.as_deref().map(Settings::read).transpose()?;
        let flags = Settings {
            map: self.map.settings(),
            ..self.settings
        };
        let file = file.unwrap_or_default();
        flags.over(file.clone()).complete().map_err(|error| {
            let is_of_file = (file.complete().err())
                .is_some_and(|of_file| of_file.to_string() == error.to_string());
            match self.config.filter(|_| is_of_file) {
                Some(path) => {
                    let place = place_in(&path, &error);
                    anyhow::Error::from(error).context(place)
                }
                None => error.into(),
            }
        })
    }
}

/// The file, and the line with the key that the error names.
fn place_in(path: &Path, error: &SettingsError) -> String {
    let said = error.to_string();
    let is_named = |key: &str| said.split([' ', ':', ';', ',']).any(|word| word == key);
    let text = std::fs::read_to_string(path).unwrap_or_default();
    let line = text.lines().position(|line| {
        let key = line.split_once('=').map(|(key, _)| key.trim());
        key.is_some_and(is_named)
    });
    match line {
        Some(line) => format!("settings {}, line {}", path.display(), line + 1),
        None => format!("settings {}", path.display()),
    }
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
