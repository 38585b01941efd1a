//! Prints a command's answer on stdout. A reader that closes the pipe early, such as `head`, is no
//! error; any other failure to write is one.

use std::fmt::Arguments;
use std::io::{ErrorKind, Write, stdout};

use anyhow::Context;

pub(crate) fn line(line: Arguments<'_>) -> anyhow::Result<()> {
    let mut out = stdout().lock();
    match writeln!(out, "{line}").and_then(|()| out.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            Err(error).context("cannot write to stdout")
        }
        _ => Ok(()),
    }
}

/// Like `println!`, but without its panic.
macro_rules! answer {
    ($($words:tt)*) => { crate::answer::line(format_args!($($words)*)) };
}
pub(crate) use answer;
