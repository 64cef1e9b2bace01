# SPDX-License-Identifier: BSD-3-Clause
"""What the tests of the Python package share."""
import os
import subprocess
import tempfile
import unittest
from pathlib import Path

import numpy as np

import cliquevo

BIN = Path(os.environ["CLIQUEVO_BIN_DIR"])
SOURCE = Path(os.environ["CLIQUEVO_SOURCE_DIR"])
DATA = Path(os.environ.get("CLIQUEVO_DATA", SOURCE.parent / "shared" / "data"))
SMALL = "sim:width=320,height=240,focal_px=350,frames=12,cache_dir=none"


def command(*arguments):
    """The finished `cliquevo ARGUMENTS`."""
    return subprocess.run([str(BIN / "cliquevo"), *map(str, arguments)], capture_output=True, text=True, timeout=300)


def replay(source, trajectory, *options):
    done = command("replay", source, "--trajectory", trajectory, *options)
    if done.returncode != 0:
        raise AssertionError(done.stderr)
    return Path(trajectory).read_bytes()


def poses_of(source, **settings):
    odometry = cliquevo.Odometry(source, **settings)
    return [odometry.step(pair.left, pair.right, stamp_ns=pair.stamp_ns).T_world_camera for pair in source]


def wall(model, frames=4):
    """Pairs that show a slanted, textured wall, which comes nearer by 10 cm a frame."""
    v, u = np.mgrid[0 : model.height, 0 : model.width]
    rx, ry = (u - model.cx_px) / model.fx_px, (v - model.cy_px) / model.fy_px

    def see(frame, camera_x):
        z = (3.0 + 0.3 * camera_x - 0.1 * frame) / (1.0 - 0.3 * rx)
        x, y = camera_x + rx * z, ry * z
        grey = 128 + 40 * np.sin(23 * x + 5 * np.sin(7.1 * y)) + 40 * np.sin(19 * y + 5 * np.sin(9.7 * x))
        return (grey + 30 * np.sin(61 * x + 47 * y)).astype(np.uint8)

    return [(see(frame, 0.0), see(frame, model.baseline_m)) for frame in range(frames)]


def small_model():
    return cliquevo.StereoModel(
        width=320, height=240, fx_px=300.0, cx_px=159.5, cy_px=119.5, baseline_m=0.12)


class Case(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="cliquevo-python-")
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def refused(self, kind, sentence, work, *arguments, **named):
        """work(...) raises `kind` with one line that has `sentence` in it."""
        with self.assertRaises(kind) as caught:
            work(*arguments, **named)
        line = str(caught.exception)
        self.assertIn(sentence, line)
        self.assertNotIn("\n", line)
        return caught.exception
