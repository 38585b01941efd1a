"""The node of ROS 2 that the bridge is behind a Zenoh router, read by others' code: rmw_zenoh.py BRIDGE.

BRIDGE is a slamlab-bridge that was built with `--features zenoh`. The router and the other end are Zenoh's
own Python library; messages are read, and type hashes computed, by rosbags. Ends with 0 if all holds, and
with 77 where a package is absent.
"""

import math
import os
import pathlib
import socket
import struct
import subprocess
import sys
import tempfile
import time

try:
    import zenoh
    import zenoh.ext
    from rosbags.typesys import Stores, get_typestore
except ImportError:
    sys.exit(77)

DOMAIN = 7
ROS = get_typestore(Stores.ROS2_JAZZY)
TRIGGER = "std_srvs::srv::dds_::Trigger_"
PUBLISHED = {
    "/scan": "sensor_msgs/msg/LaserScan",
    "/points": "sensor_msgs/msg/PointCloud2",
    "/odom": "nav_msgs/msg/Odometry",
    "/tf": "tf2_msgs/msg/TFMessage",
    "/tf_static": "tf2_msgs/msg/TFMessage",
    "/map": "nav_msgs/msg/OccupancyGrid",
    "/pose": "geometry_msgs/msg/PoseWithCovarianceStamped",
}


def wait(what, found, seconds=60):
    end = time.time() + seconds
    while time.time() < end:
        result = found()
        if result:
            return result
        time.sleep(0.02)
    raise AssertionError(f"no {what}")


def session(mode, endpoint):
    config = zenoh.Config()
    config.insert_json5("mode", f'"{mode}"')
    place = "listen" if mode == "router" else "connect"
    config.insert_json5(f"{place}/endpoints", f'["{endpoint}"]')
    config.insert_json5("scouting/multicast/enabled", "false")
    return zenoh.open(config)


def attachment(sequence, nanos=None):
    return struct.pack("<qqB", sequence, nanos or time.time_ns(), 16) + b"\x07" * 16


class Graph:
    """What `ros2 topic list` would be made of: the tokens in the domain."""

    def __init__(self, session):
        self.session = session

    def tokens(self):
        replies = self.session.liveliness().get(f"@ros2_lv/{DOMAIN}/**")
        return [str(reply.ok.key_expr).split("/") for reply in replies if reply.ok]

    def endpoints(self, kind):
        """Name, type as in keys, hash and QoS of each endpoint."""
        of_kind = [token for token in self.tokens() if token[5] == kind]
        return {(token[9].replace("%", "/"), token[10]): (token[11], token[12]) for token in of_kind}


def in_key(name):
    package, kind, message = name.split("/")
    return f"{package}::{kind}::dds_::{message}_"


class Topic:
    """A subscription that keeps what came, with how it was attached."""

    def __init__(self, session, name, late=False):
        kind = PUBLISHED[name]
        self.kind, self.came = kind, []
        key = f"{DOMAIN}{name}/{in_key(kind)}/{ROS.hash_rihs01(kind)}"
        if late:
            history = zenoh.ext.HistoryConfig(detect_late_publishers=True)
            self.inner = zenoh.ext.declare_advanced_subscriber(session, key, self.take, history=history)
        else:
            self.inner = session.declare_subscriber(key, self.take)

    def take(self, sample):
        sequence, nanos, length = struct.unpack("<qqB", sample.attachment.to_bytes()[:17])
        assert length == 16 and len(sample.attachment.to_bytes()) == 33
        assert abs(nanos * 1e-9 - time.time()) < 60
        self.came.append((sequence, ROS.deserialize_cdr(sample.payload.to_bytes(), self.kind)))

    def newest(self):
        return self.came[-1][1] if self.came else None


def call(session, hashes, name):
    key = f"{DOMAIN}/slamlab/{name}/{TRIGGER}/{hashes}"
    request = b"\x00\x01\x00\x00\x00"
    sent = attachment(1)
    for reply in session.get(key, payload=request, attachment=sent, timeout=10.0):
        payload = reply.ok.payload.to_bytes()
        assert payload[:4] == b"\x00\x01\x00\x00" and reply.ok.attachment.to_bytes() == sent
        length = struct.unpack_from("<I", payload, 8)[0]
        return payload[4] == 1, payload[12 : 12 + length - 1].decode()
    raise AssertionError(f"no answer of {name}")


def velocity(session, forward, turn, sequence, nanos=None):
    twist = ROS.types["geometry_msgs/msg/Twist"]
    vector = ROS.types["geometry_msgs/msg/Vector3"]
    message = twist(linear=vector(x=forward, y=0.0, z=0.0), angular=vector(x=0.0, y=0.0, z=turn))
    kind = "geometry_msgs/msg/Twist"
    payload = bytes(ROS.serialize_cdr(message, kind))
    key = f"{DOMAIN}/cmd_vel/{in_key(kind)}/{ROS.hash_rihs01(kind)}"
    session.put(key, payload, attachment=attachment(sequence, nanos))


def check_graph(graph):
    published = wait("publishers", lambda: graph.endpoints("MP"))
    wait("all publishers", lambda: len(graph.endpoints("MP")) == len(PUBLISHED))
    published = graph.endpoints("MP")
    for name, kind in PUBLISHED.items():
        hashed, qos = published[name, in_key(kind)]
        assert hashed == ROS.hash_rihs01(kind), (name, hashed)
        kept = name in ("/map", "/tf_static")
        depth = 100 if name == "/tf" else 1
        assert qos == f":{1 if kept else ''}:,{depth}:,:,:,,", (name, qos)
    subscribed = wait("subscriptions", lambda: graph.endpoints("MS"))
    for kind in ("geometry_msgs/msg/Twist", "geometry_msgs/msg/TwistStamped"):
        assert subscribed["/cmd_vel", in_key(kind)][0] == ROS.hash_rihs01(kind)
    services = wait("services", lambda: len(graph.endpoints("SS")) == 5 and graph.endpoints("SS"))
    nodes = [token for token in graph.tokens() if token[5] == "NN"]
    assert [token[-1] for token in nodes] == ["slamlab_interop"], nodes
    return services["/slamlab/arm", TRIGGER][0]


def check_readings(session):
    scan, odom, moving = (Topic(session, name) for name in ("/scan", "/odom", "/tf"))
    wait("scans", lambda: len(scan.came) > 3)
    wait("transforms", lambda: len(moving.came) > 20)
    message = scan.newest()
    beams = round((message.angle_max - message.angle_min) / message.angle_increment) + 1
    assert beams == len(message.ranges) > 100 and message.header.frame_id == "laser"
    assert any(math.isfinite(one) and 0 < one < message.range_max for one in message.ranges)
    assert odom.newest().child_frame_id == "base_link"
    pairs = {(one.header.frame_id, one.child_frame_id) for _, all in moving.came for one in all.transforms}
    assert ("odom", "base_link") in pairs and ("base_link", "laser") not in pairs, pairs
    numbers = [sequence for sequence, _ in odom.came]
    assert numbers == sorted(set(numbers))
    # Who comes late gets what is kept.
    where = Topic(session, "/tf_static", late=True)
    drawn = Topic(session, "/map", late=True)
    mount = wait("the lidar's place", where.newest).transforms[0]
    assert (mount.header.frame_id, mount.child_frame_id) == ("base_link", "laser")
    grid = wait("a map", drawn.newest)
    assert len(grid.data) == grid.info.width * grid.info.height and set(grid.data) <= {-1, 0, 100}
    assert 100 in grid.data and grid.header.frame_id == "map"
    return odom


def check_driving(session, hashes, odom):
    sequence = iter(range(1, 10**9))
    speed = lambda: odom.newest().twist.twist.linear.x

    def drive(until, seconds=10, late=0):
        end = time.time() + seconds
        while time.time() < end:
            number = next(sequence)
            velocity(session, 0.1, 0.0, number, time.time_ns() - late)
            time.sleep(0.05)
            if until():
                return True
        return False

    assert not drive(lambda: speed() > 0.03, seconds=1.5), "it drove without being armed"
    armed = lambda: call(session, hashes, "arm")
    wait("arming", lambda: armed()[0])
    assert drive(lambda: speed() > 0.05), "it did not drive"
    # What comes a second later than all before is old, and drives no longer.
    assert drive(lambda: abs(speed()) < 1e-3, late=10**9), "it obeyed what was old"
    wait("arming", lambda: armed()[0])
    assert drive(lambda: speed() > 0.05), "it did not drive again"
    assert call(session, hashes, "stop") == (True, "")
    assert drive(lambda: abs(speed()) < 1e-3), "it was driven on after a stop"
    assert call(session, hashes, "emergency_stop") == (True, "")
    done, why = call(session, hashes, "arm")
    assert not done and why, "an emergency stop is not armed away"
    assert call(session, hashes, "reset_emergency_stop") == (True, "")


def main(bridge):
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        endpoint = f"tcp/127.0.0.1:{free.getsockname()[1]}"
    folder = tempfile.mkdtemp(prefix="slamlab-interop-")
    token = os.path.join(folder, "token")
    made = [bridge, "token", "add", "ros", "--role", "driver", "--token-file", token]
    subprocess.run(made, check=True, stdout=subprocess.DEVNULL)
    page = pathlib.Path(__file__).resolve().parents[2] / "bridge/tests/page"
    flags = ["--port", "0", "--page", str(page), "--source", "sim:arena,lidar", "--token-file", token, "--map"]
    flags += ["--zenoh", endpoint, "--zenoh-name", "interop", "--ros-domain", str(DOMAIN), "--ros-right", "ros"]
    router = session("router", endpoint)
    process = subprocess.Popen([bridge, *flags], stdout=subprocess.DEVNULL)
    try:
        other = session("client", endpoint)
        hashes = check_graph(Graph(other))
        odom = check_readings(other)
        check_driving(other, hashes, odom)
        other.close()
    finally:
        process.terminate()
        process.wait(20)
        router.close()
    print("eclipse-zenoh and rosbags see the node, read it, drive it and stop it: all holds")


if __name__ == "__main__":
    main(*sys.argv[1:2])
