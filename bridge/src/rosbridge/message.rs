//! What is sent to a client of rosbridge: ROS 2 messages as JSON.

use std::time::Duration;

use serde::Serialize;
use serde_json::{Value, json};
use slamlab_core::format::map_server::OccupancyMap;
use slamlab_core::geom::Pose2;
use slamlab_core::robot::EvenBeams;
use slamlab_core::wire::message::{FromBridge, ScanBody};

use crate::record::ros::{Moved, Odom, drawn, in_space, intensities, placed};

/// What is sent to a client.
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

/// Converts the bridge's messages to those of topics.
#[derive(Default)]
pub(super) struct Topics {
    odom: Odom,
}

impl Topics {
    const NAMES: [&'static str; 5] = ["/scan", "/odom", "/tf", "/pose", "/map"];
    /// The number of topics without a map.
    const WITHOUT_MAP: usize = 3;

    /// The topics of a bridge that maps, or does not.
    pub(super) fn names(maps: bool) -> &'static [&'static str] {
        match maps {
            true => &Self::NAMES,
            false => Self::NAMES.split_at(Self::WITHOUT_MAP).0,
        }
    }

    pub(super) fn messages(
        &mut self,
        message: &FromBridge,
        now: Duration,
    ) -> Vec<(&'static str, Value)> {
        match message {
            FromBridge::Odometry(body) => match body.odometry() {
                Ok(step) => {
                    let mut all = moved(&self.odom.moved(&step), now);
                    all.extend(self.localised(now));
                    all
                }
                Err(_) => vec![],
            },
            FromBridge::Pose(body) => {
                self.odom.tell(body);
                self.localised(now)
            }
            FromBridge::Map(body) => {
                drawn(body).map_or(vec![], |cells| vec![("/map", map(&cells, now))])
            }
            FromBridge::Scan(body) => {
                let [x, y, heading] = body.mount;
                let mount = transform(&Pose2::new(x, y, heading), ["base_link", "laser"], now);
                vec![("/tf", mount), ("/scan", scan(body, now))]
            }
            _ => vec![],
        }
    }

    /// The last pose from the mapper, once the odometry has reached its time.
    fn localised(&mut self, now: Duration) -> Vec<(&'static str, Value)> {
        let Some((estimate, odom_from_robot)) = self.odom.localised() else {
            return vec![];
        };
        let map_from_odom = estimate.pose * odom_from_robot.inverse();
        let told = json!({
            "header": header("map", now),
            "pose": {
                "pose": pose(&estimate.pose),
                "covariance": &in_space(&estimate.cov)[..],
            },
        });
        let tf = transform(&map_from_odom, ["map", "odom"], now);
        vec![("/pose", told), ("/tf", tf)]
    }
}

fn map(cells: &OccupancyMap, now: Duration) -> Value {
    let header = header("map", now);
    json!({
        "info": {
            "map_load_time": &header["stamp"],
            "resolution": cells.resolution,
            "width": cells.width,
            "height": cells.height,
            "origin": pose(&cells.origin),
        },
        "data": &cells.cells,
        "header": header,
    })
}

/// Why a topic is not available.
pub(super) fn no_topic(topic: &str, maps: bool) -> String {
    let others = format!("there are {}", Topics::names(maps).join(", "));
    match topic {
        "/map" | "/pose" => format!(
            "there is no {topic}: this bridge does not map, its --map is off; `slamlab-bridge export` draws it from a recording; {others}"
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

/// Values that are not finite become `null`, as in rosbridge.
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
        let why = no_topic("/map", false);
        assert!(why.contains("export") && why.ends_with("there are /scan, /odom, /tf"));
        assert_eq!(
            no_topic("/camera", true),
            "there is no /camera; there are /scan, /odom, /tf, /pose, /map"
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
