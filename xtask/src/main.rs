//! `cargo xtask`: reads the command line and calls the library.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Args, Parser, Subcommand};
use xtask::wasm::Profile;
use xtask::{check, dist, measure, npm, page, results, serve, suites};

/// slamlab's commands.
#[derive(Parser)]
#[command(name = "cargo xtask", bin_name = "cargo xtask")]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Build everything, serve the page and print its address
    Run {
        #[command(flatten)]
        speed: Speed,
        /// Port to serve on; 0 takes any free one
        #[arg(long, default_value_t = 8080)]
        port: u16,
        /// Show the page in the default browser
        #[arg(long)]
        open: bool,
    },
    /// Build the page into www/dist without serving it
    Build {
        #[command(flatten)]
        speed: Speed,
    },
    /// Build page and bridge into a Debian package, and try it out
    #[cfg(unix)]
    Package {
        /// Computer that it is for; this one where none is named
        #[arg(long, value_enum, default_value_t = xtask::package::Target::this_machine())]
        target: xtask::package::Target,
        /// What else the program can, each of which makes it larger
        #[arg(long, value_enum, value_delimiter = ',')]
        features: Vec<xtask::package::Feature>,
    },
    /// Fill a folder with the page, for any web server, under any path and without special headers
    Dist {
        /// Folder to fill; target/dist if none is named
        #[arg(long, value_name = "DIR")]
        out: Option<PathBuf>,
    },
    /// Pack the core's WebAssembly modules, with types and README, into a file that npm installs
    Npm {
        /// Folder to put it into; target/npm if none is named
        #[arg(long, value_name = "DIR")]
        out: Option<PathBuf>,
    },
    /// House rules, formatting, lints for native and wasm32, documentation, TypeScript types, age
    /// of RESULTS.md
    Check,
    /// Native tests, tests in headless Chromium, and the page as a user uses it; sets up what they
    /// lack
    Test {
        /// Only these suites; all but `quick`, which is part of them, if none is named
        #[arg(value_enum)]
        suites: Vec<suites::Suite>,
    },
    /// Measures what is promised: JSON, and success only if it holds
    Report(measure::Measurement),
    /// Measures figures again and writes them into RESULTS.md, with command, date, machine and
    /// commit
    Results(results::Choice),
}

#[derive(Args)]
struct Speed {
    /// Compile the module optimised (the default)
    #[arg(long, conflicts_with = "dev")]
    release: bool,
    /// Compile the module quickly, and slow to run
    #[arg(long)]
    dev: bool,
}

impl Speed {
    fn profile(&self) -> Profile {
        if self.dev && !self.release {
            Profile::Dev
        } else {
            Profile::Release
        }
    }
}

fn main() -> ExitCode {
    match obey(Cli::parse().command) {
        Ok(()) => ExitCode::SUCCESS,
        // One sentence, even if RUST_BACKTRACE is set.
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::FAILURE
        }
    }
}

fn obey(command: Command) -> anyhow::Result<()> {
    match command {
        Command::Run { speed, port, open } => {
            let bridge =
                page::build_with_bridge(speed.profile(), "build --package slamlab-bridge")?;
            serve::serve(&bridge, port, open)
        }
        Command::Build { speed } => page::build(speed.profile()),
        #[cfg(unix)]
        Command::Package { target, features } => xtask::package::package(target, &features),
        Command::Dist { out } => {
            println!("{}", dist::fill(out)?.display());
            Ok(())
        }
        Command::Npm { out } => {
            println!("{}", npm::pack(out)?.display());
            Ok(())
        }
        Command::Check => check::all(),
        Command::Report(what) => measure::measure(&what),
        Command::Results(choice) => results::run(&choice),
        Command::Test { suites } => suites::run(&suites),
    }
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory;

    #[test]
    fn the_command_line_is_consistent() {
        super::Cli::command().debug_assert();
    }
}
