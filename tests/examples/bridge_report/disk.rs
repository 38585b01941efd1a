//! A disk that fills up while a robot is driven: the driver is told in words, with the path, and
//! can drive on.

use std::time::Duration;

use serde_json::{Value, json};
use slamlab_core::wire::message::FromBridge;
use tokio::time::{Instant, interval, sleep, timeout};

use crate::bridge_process::BridgeProcess;
use crate::client::{Came, Client};

/// Maximum time from the full disk to the message: recent writes are flushed to the disk each
/// second.
const SOON: Duration = Duration::from_secs(5);
const NEVER: Duration = Duration::from_secs(30);

/// What the driver was told, and whether it can still drive then.
pub(crate) async fn report() -> (bool, Value) {
    let Ok(program) = std::env::var("SLAMLAB_BRIDGE") else {
        return (false, json!("SLAMLAB_BRIDGE names no program"));
    };
    let folder = tempfile::tempdir().unwrap();
    let recording = folder.path().join("drive.mcap");
    let source = "sim:arena,lidar";
    let path = recording.clone();
    let bridge = BridgeProcess::start(&program, source, folder.path(), path, None).await;
    let token = std::fs::read_to_string(folder.path().join("token")).unwrap();
    let mut driver = Client::connect(bridge.address, "").await;
    assert!(driver.enter(Some(token.trim())).await);
    driver.take(false).await;
    driver.arm().await;
    bridge.fill_disk().await;
    let filled = Instant::now();
    let mut beats = interval(Duration::from_millis(50));
    let told = timeout(NEVER, async {
        loop {
            tokio::select! {
                _ = beats.tick() => driver.drive(0.0, 0.5).await,
                came = driver.next() => match came {
                    Came::Message(FromBridge::Recording(body)) if body.fault.is_some() => return body.fault,
                    Came::Message(_) => (),
                    Came::Closed(_) | Came::Lost => return None,
                },
            }
        }
    })
    .await;
    let after = filled.elapsed();
    let words = told.ok().flatten().unwrap_or_default();
    let is_told =
        words.contains("the disk is full") && words.contains(&*recording.to_string_lossy());
    let turned = async {
        loop {
            driver.drive(0.0, 0.5).await;
            sleep(Duration::from_millis(20)).await;
            while let Ok(came) = timeout(Duration::from_millis(20), driver.next()).await {
                if let Came::Message(FromBridge::Odometry(body)) = came
                    && body
                        .odometry()
                        .is_ok_and(|step| step.motion.heading() > 1e-4)
                {
                    return;
                }
            }
        }
    };
    let drives = timeout(SOON, turned).await.is_ok();
    bridge.kill().await;
    (
        is_told && after < SOON && drives,
        json!({ "told": words, "after_s": after.as_secs_f64(), "drives_on": drives }),
    )
}
