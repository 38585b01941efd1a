"""The rosbridge subset, with roslibpy as the independent client: rosbridge.py URL TOKEN.

URL is ws://HOST:PORT/rosbridge of a bridge with a simulated robot. Ends with 0 if all holds, and with
77 where the package is absent.
"""

import hashlib
import hmac
import sys
import threading
import time

try:
    import roslibpy
except ImportError:
    sys.exit(77)


def call(ros, name, **args):
    service = roslibpy.Service(ros, name, "")
    return service.call(roslibpy.ServiceRequest(args), timeout=20)


def first(ros, name, kind, holds=lambda _: True):
    found, came = [], threading.Event()
    topic = roslibpy.Topic(ros, name, kind, throttle_rate=20)

    def take(message):
        if not found and holds(message):
            found.append(message)
            came.set()

    topic.subscribe(take)
    assert came.wait(20), f"no fitting {name}"
    topic.unsubscribe()
    return found[0]


def main(url, token):
    ros = roslibpy.Ros(url)
    ros.run(timeout=20)
    assert "/odom" in ros.get_topics()
    assert ros.get_topic_type("/scan") == "sensor_msgs/msg/LaserScan"
    assert "/slamlab/stop" in ros.get_services()
    assert ros.get_nodes() == ["/slamlab_bridge"]
    assert "/slamlab/version" in ros.get_params()
    assert abs(ros.get_time()["secs"] - time.time()) < 60
    assert len(first(ros, "/scan", "sensor_msgs/LaserScan")["ranges"]) > 100

    challenge = bytes.fromhex(call(ros, "/slamlab/challenge")["challenge"])
    # SCRAM, RFC 5802 section 3.
    client = hmac.digest(token.encode(), b"slamlab bridge 2", "sha256")
    signature = hmac.digest(hashlib.sha256(client).digest(), challenge, "sha256")
    proof = bytes(a ^ b for a, b in zip(client, signature)).hex()
    assert call(ros, "/slamlab/enter", proof=proof) == {"role": "owner", "name": ""}
    assert call(ros, "/slamlab/take", force=True)["epoch"] > 0
    call(ros, "/slamlab/reset_emergency_stop")
    assert call(ros, "/slamlab/arm")["armed"]
    velocity = roslibpy.Topic(ros, "/cmd_vel", "geometry_msgs/TwistStamped")
    stop = threading.Event()

    def drive():
        while not stop.wait(0.05):
            twist = {"linear": {"x": 0.08, "y": 0.0, "z": 0.0}, "angular": {"x": 0.0, "y": 0.0, "z": 0.0}}
            velocity.publish(roslibpy.Message({"header": {"frame_id": "base_link"}, "twist": twist}))

    driver = threading.Thread(target=drive)
    driver.start()
    first(ros, "/odom", "nav_msgs/Odometry", lambda odom: odom["twist"]["twist"]["linear"]["x"] > 0.03)
    # While it is driven on.
    call(ros, "/slamlab/stop")
    first(ros, "/odom", "nav_msgs/Odometry", lambda odom: abs(odom["twist"]["twist"]["linear"]["x"]) < 1e-3)
    stop.set()
    driver.join()
    call(ros, "/slamlab/release")
    ros.terminate()
    print("roslibpy", roslibpy.__version__, "drives, stops and asks: all holds")


if __name__ == "__main__":
    main(*sys.argv[1:3])
