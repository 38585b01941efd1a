//! Opens an address in the default browser, by the system's own command.

use std::process::{Command, Stdio};

/// Asks the system to open `url`; if it cannot, a warning names `plain`, which holds no token, and
/// the bridge goes on.
pub(crate) fn in_browser(url: &str, plain: &str) {
    let mut command = if cfg!(target_os = "macos") {
        Command::new("open")
    } else if cfg!(windows) {
        let mut command = Command::new("rundll32");
        command.arg("url.dll,FileProtocolHandler");
        command
    } else {
        Command::new("xdg-open")
    };
    let started = command
        .arg(url)
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn();
    if let Err(error) = started {
        tracing::warn!("cannot open a browser ({error}); open {plain} yourself");
    }
}
