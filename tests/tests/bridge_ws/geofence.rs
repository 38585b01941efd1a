//! A geofence over real sockets: the simulated robot, driven by hand at full speed, stays inside;
//! who may set it, and that it is restored after a restart.

use std::path::Path;
use std::time::Duration;

use slamlab_bridge::{Config, MapConfig, RunError};
use slamlab_core::robot::RobotModel;
use slamlab_core::wire::message::{
    FenceState, FromBridge, GeofenceBody, RefusalReason, Role, ToBridge, Watching, ZoneBody,
    ZoneUse,
};
use slamlab_tests::calm::async_on_a_calm_machine;
use tokio::time::Instant;

use super::client::{Bridge, Came, Client, until_there};
use super::rights_stand::Stand;
use super::streams::simulated;

fn config(file: Option<&Path>) -> Config {
    Config {
        map: Some(MapConfig {
            file: file.map(Path::to_owned),
            save_every: Duration::from_secs(1),
            ..MapConfig::default()
        }),
        ..simulated()
    }
}

/// A square around the place of the robot when its map begins, m.
fn square(half: f64) -> Vec<ZoneBody> {
    vec![ZoneBody {
        kind: ZoneUse::KeepIn,
        corners: vec![[-half, -half], [half, -half], [half, half], [-half, half]],
    }]
}

fn geofence(message: &FromBridge) -> Option<GeofenceBody> {
    match message {
        FromBridge::Geofence(body) => Some(body.clone()),
        _ => None,
    }
}

fn localised(message: &FromBridge) -> Option<()> {
    matches!(message, FromBridge::Pose(_)).then_some(())
}

/// What was received during a drive.
#[derive(Default)]
struct Seen {
    /// Distance of the robot from the origin of the map along either axis, maximum and last, m.
    farthest: f64,
    last: f64,
    states: Vec<FenceState>,
    said: Vec<String>,
}

async fn drive(driver: &mut Client, forward: f64, turn: f64, time: Duration) -> Seen {
    let (mut seen, until) = (Seen::default(), Instant::now() + time);
    let mut ticks = tokio::time::interval(Duration::from_millis(50));
    while Instant::now() < until {
        tokio::select! {
            _ = ticks.tick() => driver.drive(forward, turn).await,
            came = driver.next() => match came {
                Came::Message(FromBridge::Pose(body)) => {
                    seen.last = body.pose[0].abs().max(body.pose[1].abs());
                    seen.farthest = seen.farthest.max(seen.last);
                }
                Came::Message(FromBridge::Geofence(body)) => seen.states.push(body.state),
                Came::Message(FromBridge::Notice(notice)) => seen.said.push(notice.text),
                Came::Message(_) => (),
                other => panic!("{other:?}"),
            },
        }
    }
    seen
}

#[test]
fn the_robot_stops_within_its_fence_says_why_and_is_driven_back() {
    async_on_a_calm_machine(async || {
        let bridge = Bridge::start(config(None)).await;
        let mut driver = bridge.armed().await;
        driver.wait(localised).await;
        // The bridge's own token belongs to its owner.
        let half = 0.7;
        driver
            .say(ToBridge::SetGeofence {
                zones: square(half),
            })
            .await;
        let fence = driver
            .wait(|message| geofence(message).filter(|body| !body.zones.is_empty()))
            .await;
        assert_eq!(
            (fence.zones, fence.state),
            (square(half), FenceState::Within)
        );

        let seen = drive(&mut driver, 0.3, 0.0, Duration::from_secs(8)).await;
        let radius = RobotModel::rp6().radius();
        assert!(seen.farthest < half - 0.5 * radius, "{} m", seen.farthest);
        assert!(seen.farthest > 0.25, "{} m", seen.farthest);
        assert!(seen.states.contains(&FenceState::Held), "{:?}", seen.states);
        let why = |text: &String| text.contains("The geofence holds the robot back");
        assert!(seen.said.iter().any(why), "{:?}", seen.said);

        let back = drive(&mut driver, -0.2, 0.0, Duration::from_secs(2)).await;
        assert!(back.last < seen.farthest - 0.2, "{} m", back.last);
        // After the fence is removed, nothing holds the robot back.
        driver.say(ToBridge::SetGeofence { zones: vec![] }).await;
        let free = drive(&mut driver, 0.3, 0.0, Duration::from_secs(4)).await;
        assert!(free.farthest > seen.farthest + 0.1, "{} m", free.farthest);
        bridge.stop().await;
    });
}

/// A bridge does not start with a fence but without its map.
#[test]
fn a_fence_is_written_after_the_map_that_it_was_drawn_in() {
    async_on_a_calm_machine(async || {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("flat.slamlab");
        let kept = folder.path().join("flat.geofence.json");
        let mut config = config(Some(&file));
        config.map.as_mut().unwrap().save_every = Duration::from_secs(3600);
        let bridge = Bridge::start(config).await;
        let mut owner = bridge.armed().await;
        owner.wait(localised).await;
        assert!(!file.exists());
        owner
            .say(ToBridge::SetGeofence { zones: square(1.5) })
            .await;
        until_there(&kept, true, Duration::from_secs(6)).await;
        assert!(file.exists());
        bridge.stop().await;
    });
}

#[test]
fn a_fence_is_kept_with_its_map_and_goes_with_it() {
    async_on_a_calm_machine(async || {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("flat.slamlab");
        let kept = folder.path().join("flat.geofence.json");
        let bridge = Bridge::start(config(Some(&file))).await;
        let mut owner = bridge.armed().await;
        owner.wait(localised).await;
        owner
            .say(ToBridge::SetGeofence { zones: square(1.5) })
            .await;
        let set = |message: &FromBridge| geofence(message).filter(|body| !body.zones.is_empty());
        owner.wait(set).await;
        owner
            .wait(|message| match message {
                FromBridge::Mapping(body) if body.saved > 0 => Some(()),
                _ => None,
            })
            .await;
        drop(owner);
        bridge.stop().await;
        assert!(std::fs::read_to_string(&kept).unwrap().contains("keep-in"));

        let bridge = Bridge::start(config(Some(&file))).await;
        // Nobody can arm before the robot has localised itself in the map.
        let mut owner = bridge.driver().await;
        let again = owner.wait(set).await;
        assert_eq!(again.zones, square(1.5));
        owner.say(ToBridge::ResetMap).await;
        let gone = |message: &FromBridge| geofence(message).filter(|body| body.zones.is_empty());
        owner.wait(gone).await;
        until_there(&kept, false, Duration::from_secs(20)).await;
        bridge.stop().await;
        assert!(folder.path().join("flat.1.geofence.json").exists());

        // A fence that cannot be read, or has no map, keeps the bridge from starting.
        let fails = async || -> String {
            let listener = slamlab_bridge::bind(([127, 0, 0, 1], 0).into()).await;
            match slamlab_bridge::start(listener.unwrap(), config(Some(&file))) {
                Err(RunError::Map(error)) => error.to_string(),
                other => panic!("{other:?}"),
            }
        };
        std::fs::write(
            &kept,
            r#"{"zones":[{"kind":"keep-in","corners":[[0,0],[1,0]]}]}"#,
        )
        .unwrap();
        let error = fails().await;
        assert!(
            error.contains("flat.geofence.json") && error.contains("zone 1 has 2 corners"),
            "{error}"
        );
        std::fs::write(&kept, r#"{"zones":[]"#).unwrap();
        let error = fails().await;
        assert!(error.contains("line 1"), "{error}");
        // The new map may already have been written.
        if file.exists() {
            std::fs::remove_file(&file).unwrap();
        }
        let good = r#"{"zones":[{"kind":"keep-in","corners":[[0,0],[1,0],[0,1]]}]}"#;
        std::fs::write(&kept, good).unwrap();
        let error = fails().await;
        assert!(error.contains("a geofence beside it"), "{error}");
    });
}

#[test]
fn a_driver_sets_none_and_stays() {
    async_on_a_calm_machine(async || {
        let stand = Stand::start(Watching::Anyone).await;
        let token = stand.add("anna", Role::Driver);
        let mut driver = stand.enter(&token).await;
        driver.say(ToBridge::SetGeofence { zones: vec![] }).await;
        let refused = driver
            .wait(|message| match message {
                FromBridge::Refused(reason) => Some(*reason),
                _ => None,
            })
            .await;
        assert_eq!(refused, RefusalReason::NoRight);
        stand.stop().await;
    });
}
