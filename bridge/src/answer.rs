//! What a command answers, on stdout. A reader that has gone, as `head` does, wants no more of it;
//! whatever else keeps it from being written is an error.

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

/// As `println!`, which would panic.
macro_rules! answer {
    ($($words:tt)*) => { crate::answer::line(format_args!($($words)*)) };
}
pub(crate) use answer;
