"""Writes small recordings of ROS by programs of others: the files of core/src/format/ros/files.

A robot drives along an arc in a room of 6 m by 4 m. Each beam is cast from where the robot is when
it is taken, so that a reader that mistakes the mount, the order of beams, a stamp or the motion
between two poses sees walls that are not there. Usage: ros_files.py FOLDER
Needs `rosbags` (bags of ROS 1, types) and `mcap` (files of ROS 2).
"""

import math
import sys
from pathlib import Path

import numpy as np
from mcap.writer import CompressionType, Writer as McapWriter
from rosbags.rosbag1 import Writer as BagWriter
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

EPOCH = 1_700_000_000_000_000_000
SPEED, TURN_RATE = 0.4, 0.25
ROOM = (-1.0, -1.5, 5.0, 2.5)
BEAMS, SWEEP = 90, 0.12
ODOM_PERIOD, SCAN_PERIOD, SCANS = 20_000_000, 200_000_000, 25


def pose(t):
    """Along an arc from the origin."""
    heading = TURN_RATE * t
    radius = SPEED / TURN_RATE
    return radius * math.sin(heading), radius * (1 - math.cos(heading)), heading


def quaternion(roll, pitch, yaw):
    cr, sr, cp, sp = math.cos(roll / 2), math.sin(roll / 2), math.cos(pitch / 2), math.sin(pitch / 2)
    cy, sy = math.cos(yaw / 2), math.sin(yaw / 2)
    return (sr * cp * cy - cr * sp * sy, cr * sp * cy + sr * cp * sy, cr * cp * sy - sr * sp * cy, cr * cp * cy + sr * sp * sy)


def to_wall(x, y, angle):
    dx, dy = math.cos(angle), math.sin(angle)
    ways = []
    for at, d, low, high in ((x, dx, ROOM[0], ROOM[2]), (y, dy, ROOM[1], ROOM[3])):
        if abs(d) > 1e-12:
            ways.append(((high if d > 0 else low) - at) / d)
    return min(ways)


class Messages:
    """The same drive in the types of one distribution."""

    def __init__(self, store, ros1):
        self.types, self.ros1, self.store = store.types, ros1, store

    def header(self, nanos, frame):
        stamp = self.types["builtin_interfaces/msg/Time"](sec=nanos // 10**9, nanosec=nanos % 10**9)
        more = {"seq": 0} if self.ros1 else {}
        return self.types["std_msgs/msg/Header"](stamp=stamp, frame_id=frame, **more)

    def scan(self, nanos, frame, mount, first=-2.0, step=4.0 / BEAMS, spoil=True):
        x, y, yaw, upside_down = mount
        ranges = []
        for i in range(BEAMS):
            t = (nanos - EPOCH) / 1e9 + SWEEP * i / (BEAMS - 1)
            rx, ry, heading = pose(t)
            angle = first + step * i
            direction = heading + yaw + (-angle if upside_down else angle)
            sx = rx + x * math.cos(heading) - y * math.sin(heading)
            sy = ry + x * math.sin(heading) + y * math.cos(heading)
            ranges.append(to_wall(sx, sy, direction))
        if spoil:
            ranges[3], ranges[4], ranges[5], ranges[6], ranges[7] = math.inf, math.nan, 0.01, 0.0, -math.inf
        return self.types["sensor_msgs/msg/LaserScan"](
            header=self.header(nanos, frame), angle_min=first, angle_max=first + step * (BEAMS - 1), angle_increment=step,
            time_increment=SWEEP / (BEAMS - 1), scan_time=SCAN_PERIOD / 1e9, range_min=0.05, range_max=12.0,
            ranges=np.array(ranges, dtype=np.float32), intensities=np.array([], dtype=np.float32))

    def place(self, x, y, z, q):
        vector = self.types["geometry_msgs/msg/Vector3"](x=x, y=y, z=z)
        return vector, self.types["geometry_msgs/msg/Quaternion"](x=q[0], y=q[1], z=q[2], w=q[3])

    def odometry(self, nanos, parent, child):
        x, y, heading = pose((nanos - EPOCH) / 1e9)
        types = self.types
        _, q = self.place(0.0, 0.0, 0.0, quaternion(0, 0, heading))
        zero = types["geometry_msgs/msg/Vector3"](x=0.0, y=0.0, z=0.0)
        here = types["geometry_msgs/msg/Pose"](position=types["geometry_msgs/msg/Point"](x=x, y=y, z=0.0), orientation=q)
        return types["nav_msgs/msg/Odometry"](
            header=self.header(nanos, parent), child_frame_id=child,
            pose=types["geometry_msgs/msg/PoseWithCovariance"](pose=here, covariance=np.zeros(36)),
            twist=types["geometry_msgs/msg/TwistWithCovariance"](twist=types["geometry_msgs/msg/Twist"](linear=zero, angular=zero), covariance=np.zeros(36)))

    def transform(self, nanos, parent, child, xyz, q):
        v, r = self.place(*xyz, q)
        types = self.types
        body = types["geometry_msgs/msg/Transform"](translation=v, rotation=r)
        one = types["geometry_msgs/msg/TransformStamped"](header=self.header(nanos, parent), child_frame_id=child, transform=body)
        return types["tf2_msgs/msg/TFMessage"](transforms=[one])


def events(messages, slash="", tf_odometry=False, two=False):
    """(recorded, topic, message) in the order of recording."""
    flat = (0.2, 0.05, 0.5, True)
    out = [(EPOCH, "/tf_static", messages.transform(EPOCH, slash + "base_link", slash + "mast", (0.1, 0.0, 0.3), quaternion(0, 0, 0))),
           (EPOCH, "/tf_static", messages.transform(EPOCH, slash + "mast", slash + "laser", (0.1, 0.05, 0.0), quaternion(math.pi, 0, 0.5)))]
    if two:
        out.append((EPOCH, "/tf_static", messages.transform(EPOCH, "base_link", "rear", (-0.2, 0.0, 0.0), quaternion(0, 0, math.pi))))
    for k in range(int(SCANS * SCAN_PERIOD / ODOM_PERIOD) + 20):
        at = EPOCH + 7_000_000 + k * ODOM_PERIOD
        if tf_odometry:
            x, y, heading = pose((at - EPOCH) / 1e9)
            out.append((at + 1_000_000, "/tf", messages.transform(at, slash + "odom", slash + "base_link", (x, y, 0.0), quaternion(0, 0, heading))))
        else:
            out.append((at + 1_000_000, "/odom", messages.odometry(at, slash + "odom", slash + "base_link")))
    for k in range(SCANS):
        at = EPOCH + 50_000_000 + k * SCAN_PERIOD
        out.append((at + 130_000_000, "/scan", messages.scan(at, slash + "laser", flat)))
        if two:
            out.append((at + 131_000_000, "/rear/scan", messages.scan(at, "rear", (-0.2, 0.0, math.pi, False), spoil=False)))
    return sorted(out, key=lambda e: e[0])


def bag(path, compression, tf_odometry=False):
    store = get_typestore(Stores.ROS1_NOETIC)
    store.register(get_types_from_msg("geometry_msgs/TransformStamped[] transforms", "tf2_msgs/msg/TFMessage"))
    messages = Messages(store, True)
    path.unlink(missing_ok=True)
    writer = BagWriter(path)
    if compression:
        writer.set_compression(BagWriter.CompressionFormat[compression])
    with writer:
        connections = {}
        for at, topic, message in events(messages, slash="/", tf_odometry=tf_odometry):
            if topic not in connections:
                connections[topic] = writer.add_connection(topic, message.__msgtype__, typestore=store)
            writer.write(connections[topic], at, store.serialize_ros1(message, message.__msgtype__))


def mcap(path, compression, two=False, tf_odometry=False):
    store = get_typestore(Stores.ROS2_HUMBLE)
    messages = Messages(store, False)
    with open(path, "wb") as stream:
        writer = McapWriter(stream, compression=compression, chunk_size=16_000)
        writer.start(profile="ros2", library="tests/interop/ros_files.py")
        channels = {}
        for at, topic, message in events(messages, two=two, tf_odometry=tf_odometry):
            kind = message.__msgtype__
            if topic not in channels:
                schema = writer.register_schema(kind, "ros2msg", b"")
                channels[topic] = writer.register_channel(topic, "cdr", schema)
            writer.add_message(channels[topic], at, bytes(store.serialize_cdr(message, kind)), at)
        writer.finish()


def main():
    folder = Path(sys.argv[1])
    folder.mkdir(parents=True, exist_ok=True)
    bag(folder / "plain.bag", None)
    bag(folder / "bz2.bag", "BZ2", tf_odometry=True)
    bag(folder / "lz4.bag", "LZ4")
    mcap(folder / "zstd.mcap", CompressionType.ZSTD)
    mcap(folder / "lz4.mcap", CompressionType.LZ4, tf_odometry=True)
    mcap(folder / "two.mcap", CompressionType.ZSTD, two=True)


main()
