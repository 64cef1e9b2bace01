#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""A KITTI odometry folder as bags by other writers than ours, for tests.

  write_bag.py FOLDER OUT.bag [none|bz2|lz4 [TIMES]]   by python3-rosbag
  write_bag.py FOLDER OUT.db3 [none|zstd [TIMES]]      by sqlite3, as rosbag2 lays its tables out
  write_bag.py FOLDER OUT.jsonl                        messages for write_mcap.mjs

TIMES: the folder so often, each time a second later.
"""
import base64
import json
import os
import sqlite3
import struct
import sys
from decimal import Decimal

import numpy as np
from PIL import Image as Picture

START_S = 1_700_000_000  # of folders whose times begin at 0
TOPICS = ("/stereo/{}/image_raw", "/stereo/{}/camera_info")


def read_folder(folder, times=1):
    """Projections, and (stamp in ns, left, right) of each pair."""
    with open(f"{folder}/calib.txt", encoding="ascii") as file:
        rows = dict(line.split(":", 1) for line in file if ":" in line)
    projections = [[float(v) for v in rows[name].split()] for name in ("P0", "P1")]
    with open(f"{folder}/times.txt", encoding="ascii") as file:
        seconds = [Decimal(line) for line in file if line.strip()]
    start = START_S if seconds[0] < 10**8 else 0
    stamps = [int((start + time) * 10**9) for time in seconds]
    names = sorted(os.listdir(f"{folder}/image_0"))
    pairs = [(stamp, *(np.array(Picture.open(f"{folder}/image_{camera}/{name}").convert("L")) for camera in (0, 1)))
             for stamp, name in zip(stamps, names)]
    return projections, [(stamp + later * 10**9, left, right) for later in range(times) for stamp, left, right in pairs]


def intrinsics(P):
    return [P[0], 0.0, P[2], 0.0, P[5], P[6], 0.0, 0.0, 1.0], [1.0, 0, 0, 0, 1.0, 0, 0, 0, 1.0]


def write_ros1(folder, out, compression, times):
    import rosbag
    import rospy
    from sensor_msgs.msg import CameraInfo, Image
    projections, pairs = read_folder(folder, times)
    with rosbag.Bag(out, "w", compression=compression, chunk_threshold=256 * 1024) as bag:
        for stamp_ns, *images in pairs:
            stamp = rospy.Time(stamp_ns // 10**9, stamp_ns % 10**9)
            for side, P, pixels in zip(("left", "right"), projections, images):
                image, info = Image(), CameraInfo()
                image.header.stamp = info.header.stamp = stamp
                image.header.frame_id = info.header.frame_id = "left_optical"
                image.height, image.width = info.height, info.width = pixels.shape
                image.encoding, image.step, image.data = "mono8", pixels.shape[1], pixels.tobytes()
                info.distortion_model, info.D, info.P = "plumb_bob", [0.0] * 5, P
                info.K, info.R = intrinsics(P)
                later = stamp + rospy.Duration(0, 7_000_000)  # receive times are not the exposures'
                bag.write(TOPICS[0].format(side), image, later)
                bag.write(TOPICS[1].format(side), info, later)


class Cdr:
    """Plain CDR, the lowest byte first: alignment counts from behind the four bytes of its head."""

    def __init__(self):
        self.data = bytearray()

    def put(self, kind, *values):
        size = struct.calcsize("<" + kind)
        for value in values:
            self.data += b"\0" * (-len(self.data) % size) + struct.pack("<" + kind, value)
        return self

    def block(self, raw):
        self.put("I", len(raw))
        self.data += raw
        return self

    def text(self, value):
        return self.block(value.encode() + b"\0")

    def header(self, stamp_ns):
        return self.put("i", stamp_ns // 10**9).put("I", stamp_ns % 10**9).text("left_optical")

    def done(self):
        return b"\0\1\0\0" + bytes(self.data)


def cdr_messages(stamp_ns, P, pixels):
    height, width = pixels.shape
    image = Cdr().header(stamp_ns).put("I", height, width).text("mono8").put("B", 0).put("I", width)
    info = Cdr().header(stamp_ns).put("I", height, width).text("plumb_bob").put("I", 5).put("d", *[0.0] * 5)
    K, R = intrinsics(P)
    info.put("d", *K, *R, *P).put("I", 0, 0, 0, 0, 0, 0).put("B", 0)
    return image.block(pixels.tobytes()).done(), info.done()


def write_ros2(folder, out, compression, times):
    pack = bytes
    if compression == "zstd":
        import zstandard
        pack = zstandard.ZstdCompressor(1).compress
    projections, pairs = read_folder(folder, times)
    db = sqlite3.connect(out)
    db.executescript("""
      CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT NOT NULL,
        serialization_format TEXT NOT NULL, offered_qos_profiles TEXT NOT NULL);
      CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL, timestamp INTEGER NOT NULL,
        data BLOB NOT NULL);
      CREATE INDEX timestamp_idx ON messages (timestamp ASC);""")
    for camera, side in enumerate(("left", "right")):
        for kind, (topic, name) in enumerate(zip(TOPICS, ("Image", "CameraInfo"))):
            db.execute("INSERT INTO topics VALUES (?, ?, ?, 'cdr', '')",
                       (1 + 2 * camera + kind, topic.format(side), f"sensor_msgs/msg/{name}"))
    for stamp_ns, *images in pairs:
        for camera, (P, pixels) in enumerate(zip(projections, images)):
            for kind, message in enumerate(cdr_messages(stamp_ns, P, pixels)):
                db.execute("INSERT INTO messages(topic_id, timestamp, data) VALUES (?, ?, ?)",
                           (1 + 2 * camera + kind, stamp_ns + 7_000_000, pack(message)))
    db.commit()
    db.close()


def write_lines(folder, out, _, times):
    projections, pairs = read_folder(folder, times)
    with open(out, "w", encoding="ascii") as file:
        for stamp_ns, *images in pairs:
            for side, P, pixels in zip(("left", "right"), projections, images):
                for topic, name, message in zip(TOPICS, ("Image", "CameraInfo"), cdr_messages(stamp_ns, P, pixels)):
                    file.write(json.dumps({"topic": topic.format(side), "type": f"sensor_msgs/msg/{name}",
                                           "stamp": str(stamp_ns + 7_000_000),
                                           "data": base64.b64encode(message).decode()}) + "\n")


if __name__ == "__main__":
    writer = {".bag": write_ros1, ".db3": write_ros2, ".jsonl": write_lines}[os.path.splitext(sys.argv[2])[1]]
    writer(sys.argv[1], sys.argv[2], sys.argv[3] if len(sys.argv) > 3 else "none",
           int(sys.argv[4]) if len(sys.argv) > 4 else 1)
