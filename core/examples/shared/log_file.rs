//! Reads a recorded log from a file, in chunks, so the text is never in memory as a whole.

use std::io::BufRead as _;
use std::path::Path;

use anyhow::Context;
use slamlab_core::format::ros::RosReader;
use slamlab_core::replay::{Log, LogError, LogReader, RosChoice, import_ros};

/// Bytes read at once.
const CHUNK: usize = 1 << 16;

/// Which topics of a recording of ROS are mapped.
#[derive(clap::Args, Clone, Default)]
pub(crate) struct Topics {
    /// Of a bag or an MCAP file of ROS: the topic with the scans. Needed where there are several.
    #[arg(long, value_name = "TOPIC")]
    scan_topic: Option<String>,
    /// Of the same: the topic with the odometry, `tf:PARENT:CHILD` for the transform between two
    /// frames, or `none`.
    #[arg(long, value_name = "TOPIC|tf:PARENT:CHILD|none")]
    odometry_topic: Option<String>,
}

impl Topics {
    fn are_given(&self) -> bool {
        self.scan_topic.is_some() || self.odometry_topic.is_some()
    }
}

/// A log of any kind; choices made for a recording of ROS are printed.
pub(crate) fn read(path: &Path, topics: &Topics) -> anyhow::Result<Log> {
    let name = || format!("log {}", path.display());
    let mut reader = LogReader::default();
    let mut pushed: Result<(), LogError> = Ok(());
    chunks(path, |chunk| {
        pushed = reader.push(chunk);
        Ok(pushed.is_ok())
    })
    .with_context(name)?;
    match pushed.and_then(|()| reader.finish()) {
        Err(error) if error.is_of_ros() => import(path, topics).with_context(name),
        Ok(_) if topics.are_given() => Err(anyhow::anyhow!(
            "it is no recording of ROS: --scan-topic and --odometry-topic have no effect"
        ))
        .with_context(name),
        read => read.with_context(name),
    }
}

fn import(path: &Path, topics: &Topics) -> anyhow::Result<Log> {
    let mut reader = RosReader::default();
    chunks(path, |chunk| {
        reader.push(chunk)?;
        Ok(true)
    })?;
    let choice = RosChoice {
        scans: topics.scan_topic.clone(),
        odometry: topics.odometry_topic.clone(),
    };
    let imported = import_ros(&reader.finish()?, &choice)
        .context("--scan-topic and --odometry-topic say what is meant")?;
    for note in imported.notes {
        eprintln!("{}: {note}", path.display());
    }
    Ok(imported.recording.into())
}

/// Passes each chunk of a file to `take`, until that wants no more.
fn chunks(path: &Path, mut take: impl FnMut(&[u8]) -> anyhow::Result<bool>) -> anyhow::Result<()> {
    let file = std::fs::File::open(path)?;
    let mut file = std::io::BufReader::with_capacity(CHUNK, file);
    loop {
        let chunk = file.fill_buf()?;
        if chunk.is_empty() || !take(chunk)? {
            return Ok(());
        }
        let count = chunk.len();
        file.consume(count);
    }
}
