//! What is sent to a client of rosbridge: ROS 2 messages as JSON.

use std::time::Duration;

use serde::Serialize;
use serde_json::{Value, json};
use slamlab_core::geom::Pose2;
use slamlab_core::robot::EvenBeams;
use slamlab_core::wire::message::{FromBridge, ScanBody};

use crate::record::ros::{Moved, Odom, in_space, intensities, placed};

/// What is sent to it.
#[derive(Debug, PartialEq, Serialize)]
#[serde(tag = "op", rename_all = "snake_case")]
pub(super) enum Reply<'a> {
    Publish {
        topic: &'static str,
        msg: Value,
    },
    ServiceResponse {
        #[serde(skip_serializing_if = "Option::is_none")]
        id: Option<Value>,
        service: String,
        values: Value,
        result: bool,
    },
    Status {
        #[serde(skip_serializing_if = "Option::is_none")]
        id: Option<Value>,
        level: &'static str,
        msg: &'a str,
    },
}

/// From the bridge's messages to those of topics.
#[derive(Default)]
pub(super) struct Topics {
    odom: Odom,
}

impl Topics {
    pub(super) const NAMES: [&'static str; 3] = ["/scan", "/odom", "/tf"];

    pub(super) fn messages(
        &mut self,
        message: &FromBridge,
        now: Duration,
    ) -> Vec<(&'static str, Value)> {
        match message {
            FromBridge::Odometry(body) => match body.odometry() {
                Ok(step) => moved(&self.odom.moved(&step), now),
                Err(_) => vec![],
            },
            FromBridge::Scan(body) => {
                let [x, y, heading] = body.mount;
                let mount = transform(&Pose2::new(x, y, heading), ["base_link", "laser"], now);
                vec![("/tf", mount), ("/scan", scan(body, now))]
            }
            _ => vec![],
        }
    }
}

/// Why a topic cannot be had.
pub(super) fn no_topic(topic: &str) -> String {
    let others = format!("there are {}", Topics::NAMES.join(", "));
    match topic {
        "/map" => format!(
            "there is no /map: each page draws its own, and the bridge none; `slamlab-bridge export` draws it from a recording; {others}"
        ),
        _ => format!("there is no {topic}; {others}"),
    }
}

fn moved(moved: &Moved, now: Duration) -> Vec<(&'static str, Value)> {
    let (summed, [x, y, turn]) = (&moved.summed, moved.speeds);
    let twist = json!({ "linear": vector([x, y, 0.0]), "angular": vector([0.0, 0.0, turn]) });
    let odom = json!({
        "header": header("odom", now),
        "child_frame_id": "base_link",
        "pose": { "pose": pose(&summed.motion), "covariance": &in_space(&summed.cov)[..] },
        "twist": { "twist": twist, "covariance": &in_space(&moved.speeds_cov)[..] },
    });
    let tf = transform(&summed.motion, ["odom", "base_link"], now);
    vec![("/odom", odom), ("/tf", tf)]
}

fn header(frame: &str, now: Duration) -> Value {
    json!({ "stamp": { "sec": now.as_secs(), "nanosec": now.subsec_nanos() }, "frame_id": frame })
}

fn vector([x, y, z]: [f64; 3]) -> Value {
    json!({ "x": x, "y": y, "z": z })
}

fn pose(pose: &Pose2) -> Value {
    let [x, y, z, qx, qy, qz, qw] = placed(pose);
    json!({ "position": vector([x, y, z]), "orientation": { "x": qx, "y": qy, "z": qz, "w": qw } })
}

fn transform(from: &Pose2, [parent, child]: [&str; 2], now: Duration) -> Value {
    let [x, y, z, qx, qy, qz, qw] = placed(from);
    json!({ "transforms": [{
        "header": header(parent, now),
        "child_frame_id": child,
        "transform": {
            "translation": vector([x, y, z]),
            "rotation": { "x": qx, "y": qy, "z": qz, "w": qw },
        },
    }] })
}

/// What is no number becomes `null`, as rosbridge has it.
fn scan(body: &ScanBody, now: Duration) -> Value {
    let even = EvenBeams::of(&body.bearings, &body.ranges);
    let (first, step) = (even.first as f32, even.step as f32);
    let count = even.beams.len();
    let beams = count.max(2) as f64 - 1.0;
    json!({
        "header": header("laser", now),
        "angle_min": first,
        "angle_max": first + step * count.saturating_sub(1) as f32,
        "angle_increment": step,
        "time_increment": body.sweep / beams,
        "scan_time": body.sweep,
        "range_min": 0.0,
        "range_max": body.max_range,
        "ranges": even.pick(&body.ranges, f32::NAN),
        "intensities": intensities(&even, &body.qualities),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whoever_asks_for_the_map_learns_where_there_is_one() {
        let why = no_topic("/map");
        assert!(why.contains("export") && why.ends_with("there are /scan, /odom, /tf"));
        assert_eq!(
            no_topic("/camera"),
            "there is no /camera; there are /scan, /odom, /tf"
        );
    }

    #[test]
    fn no_return_is_null() {
        let body = ScanBody {
            source: 0,
            stamp: 0,
            mount: [0.0; 3],
            bearings: vec![0.0, 0.1, 0.2],
            ranges: vec![1.0, f32::INFINITY, f32::NAN],
            sigmas: vec![0.01; 3],
            bearing_sigma: 0.0,
            max_range: 6.0,
            sweep: 0.1,
            qualities: vec![],
        };
        let said = scan(&body, Duration::from_nanos(2_000_000_003));
        assert_eq!(said["ranges"], json!([1.0, null, null]));
        assert_eq!(said["header"]["stamp"], json!({ "sec": 2, "nanosec": 3 }));
    }
}
