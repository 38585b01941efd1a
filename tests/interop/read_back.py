"""Reads a recording back with the tools of others, and checks every message against what the bridge promises.

    python3 tests/interop/read_back.py FILE.mcap [--map]

Needs `mcap` and `mcap-ros2-support` (PyPI); `rerun-sdk` is tried where it is there. Apart from the main tests: without Python or a
package it says so and ends with 77, which test harnesses take for "skipped". Ends with 0 only if all that was checked holds.
"""

import math
import sys
from collections import Counter

SKIPPED = 77

try:
    from mcap.reader import make_reader
    from mcap_ros2.decoder import DecoderFactory
except ImportError as missing:
    print(f"skipped: {missing}; pip install mcap mcap-ros2-support")
    sys.exit(SKIPPED)

TYPES = {
    "/scan": "sensor_msgs/msg/LaserScan",
    "/points": "sensor_msgs/msg/PointCloud2",
    "/odom": "nav_msgs/msg/Odometry",
    "/tf": "tf2_msgs/msg/TFMessage",
    "/cmd_vel": "geometry_msgs/msg/Twist",
    "/pose": "geometry_msgs/msg/PoseWithCovarianceStamped",
    "/map": "nav_msgs/msg/OccupancyGrid",
}


def main(path, with_map):
    counts, frames, last = Counter(), set(), {}
    with open(path, "rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        summary = reader.get_summary()
        for schema, channel, message in reader.iter_messages(topics=["slamlab"]):
            counts[channel.topic] += 1
        for schema, channel, message, ros in reader.iter_decoded_messages(topics=list(TYPES)):
            topic = channel.topic
            expect(schema.name == TYPES[topic], f"{topic} is a {schema.name}")
            counts[topic] += 1
            CHECKS.get(topic, lambda ros: None)(ros)
            if topic == "/tf":
                frames |= {(t.header.frame_id, t.child_frame_id) for t in ros.transforms}
            if hasattr(ros, "header"):
                expect(stamp(ros.header) == message.log_time, f"{topic}: stamp and log time differ")
            last[topic] = ros
    expect(summary is not None, "there is a summary")
    expect(summary.statistics.message_count == sum(counts.values()), "the summary counts as many messages as there are")
    wanted = {"slamlab", "/scan", "/points", "/odom", "/tf"} | ({"/pose", "/map"} if with_map else set())
    expect(wanted <= set(counts), f"topics {sorted(wanted - set(counts))} are missing")
    expect(("odom", "base_link") in frames and ("base_link", "laser") in frames, f"frames {frames}")
    expect(counts["/scan"] == counts["/points"], "a cloud for each scan")
    expect(points_of(last["/scan"]) == last["/points"].width, "a point for each return of the last scan")
    if with_map:
        expect(("map", "odom") in frames, f"frames {frames}")
        cells = Counter(last["/map"].data)
        print(f"last map: {last['/map'].info.width} x {last['/map'].info.height} cells, {dict(cells)}")
    for topic, count in sorted(counts.items()):
        print(f"{count:7} {topic}")


def stamp(header):
    return header.stamp.sec * 10**9 + header.stamp.nanosec


def points_of(scan):
    return sum(math.isfinite(r) for r in scan.ranges)


def scan(ros):
    steps = (ros.angle_max - ros.angle_min) / ros.angle_increment
    expect(abs(steps - (len(ros.ranges) - 1)) < 1e-2, f"{len(ros.ranges)} ranges, {steps} steps")
    expect(all(r <= ros.range_max * 1.01 for r in ros.ranges if math.isfinite(r)), "a range beyond range_max")
    expect(ros.header.frame_id == "laser", ros.header.frame_id)


def points(ros):
    import struct

    expect(len(ros.data) == ros.row_step == ros.width * ros.point_step, "the data is as long as it says")
    expect([f.name for f in ros.fields] == ["x", "y", "z"], "fields x, y, z")
    numbers = struct.unpack(f"<{3 * ros.width}f", bytes(ros.data))
    expect(all(math.isfinite(n) for n in numbers), "every point is finite")


def pose(covariance, orientation):
    norm = math.hypot(orientation.x, orientation.y, orientation.z, orientation.w)
    expect(abs(norm - 1) < 1e-9, f"quaternion of length {norm}")
    expect(len(covariance) == 36, "36 covariances")
    for row in range(6):
        expect(covariance[7 * row] >= 0, "a variance below 0")
        for col in range(6):
            a, b = covariance[6 * row + col], covariance[6 * col + row]
            expect(abs(a - b) <= 1e-9 * (1 + abs(a)), "the covariance is symmetric")


def odometry(ros):
    expect((ros.header.frame_id, ros.child_frame_id) == ("odom", "base_link"), "frames of /odom")
    pose(ros.pose.covariance, ros.pose.pose.orientation)


def estimate(ros):
    expect(ros.header.frame_id == "map", "frame of /pose")
    pose(ros.pose.covariance, ros.pose.pose.orientation)
    expect(all(math.isfinite(c) for c in ros.pose.covariance), "finite covariance")


def grid(ros):
    expect(len(ros.data) == ros.info.width * ros.info.height, "as many cells as it says")
    expect(set(ros.data) <= {-1, 0, 100}, f"cells {set(ros.data)}")
    expect(ros.info.resolution > 0, "resolution")


CHECKS = {"/scan": scan, "/points": points, "/odom": odometry, "/pose": estimate, "/map": grid}


def expect(holds, what):
    if not holds:
        print(f"FAILED: {what}")
        sys.exit(1)


if __name__ == "__main__":
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    main(sys.argv[1], "--map" in sys.argv)
