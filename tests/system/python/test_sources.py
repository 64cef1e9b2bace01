# SPDX-License-Identifier: BSD-3-Clause
"""Recordings, logs and the simulator as iterators; the simulator as a recording; messages of a log."""
import gc
import threading
import unittest

import numpy as np
from support import SMALL, Case, command, replay

import cliquevo

COURSE = {"width": 160, "height": 120, "focal_px": 180, "frames": 6, "cache_dir": "none"}


class Sources(Case):
    def test_a_source_describes_itself(self):
        source = cliquevo.open(SMALL)
        self.assertEqual((source.width, source.height, source.frame_count, source.rate_hz), (320, 240, 12, 30.0))
        self.assertTrue(source.calibration.rectified)
        self.assertIn("320x240", source.description)
        self.assertIsNone(source.left_mask)
        pair = next(source)
        self.assertEqual((pair.index, pair.left.shape, pair.left.dtype), (0, (240, 320), np.uint8))
        np.testing.assert_array_equal(pair.T_world_camera, np.identity(4))
        self.assertAlmostEqual(next(source).stamp - pair.stamp, 1 / 30, places=6)

    def test_images_outlive_their_source_and_share_its_memory(self):
        source = cliquevo.open(SMALL)
        pair = next(source)
        left, copy = pair.left, pair.left.copy()
        self.assertTrue(np.shares_memory(left, pair.left))
        for _ in source:
            pass
        del pair, source
        gc.collect()
        np.testing.assert_array_equal(left, copy)

    def test_simulate_makes_the_recording_that_the_command_makes(self):
        for extra in ({}, {"raw": True, "misalign_right_deg": (0.1, 0, 0.2), "camera": "webcam"}):
            ours, theirs = self.folder / f"ours{len(extra)}", self.folder / f"theirs{len(extra)}"
            self.assertEqual(cliquevo.simulate(ours, **COURSE, **extra), 6)
            options = []
            for key, value in {**COURSE, **extra}.items():
                text = "on" if value is True else ":".join(map(str, value)) if isinstance(value, tuple) else str(value)
                options += ["--" + key.replace("_", "-"), text]
            done = command("simulate", "--out", theirs, *options)
            self.assertEqual(done.returncode, 0, done.stderr)
            files = sorted(p.relative_to(theirs) for p in theirs.rglob("*") if p.is_file())
            self.assertGreater(len(files), 18)
            self.assertEqual(files, sorted(p.relative_to(ours) for p in ours.rglob("*") if p.is_file()))
            for file in files:
                self.assertEqual((ours / file).read_bytes(), (theirs / file).read_bytes(), file)
        self.refused(cliquevo.Error, "", cliquevo.simulate, ours, **COURSE)
        self.refused(cliquevo.Error, "warp", cliquevo.simulate, self.folder / "new", warp=9)
        self.refused(cliquevo.Error, "", cliquevo.simulate, "/proc/none/of/this", **COURSE)

    def test_pairs_are_chosen_as_on_the_command_line(self):
        cliquevo.simulate(self.folder / "run", **COURSE)
        chosen = cliquevo.open(self.folder / "run", first=1, last=5, every=2)
        self.assertEqual([pair.index for pair in chosen], [1, 3, 5])
        self.assertEqual(cliquevo.open(self.folder / "run", rate_hz=10).rate_hz, 10)
        for wrong in ({"first": 3, "last": 1}, {"rate_hz": float("nan")}, {"every": 0}, {"bayer": "blue"},
                      {"pair_tolerance_s": -1.0}, {"calibration": "/no/such.yaml"}, {"readout_ms": -1.0}):
            self.refused(cliquevo.Error, "", cliquevo.open, self.folder / "run", **wrong)
        self.refused(cliquevo.Error, "", cliquevo.open, SMALL, first=1)

    def test_a_torn_image_is_an_error_of_its_pair_alone(self):
        cliquevo.simulate(self.folder / "run", **COURSE)
        torn = self.folder / "run" / "image_0" / "000002.png"
        torn.write_bytes(torn.read_bytes()[:200])
        source, seen, errors = cliquevo.open(self.folder / "run"), [], []
        while True:
            try:
                seen.append(next(source).index)
            except StopIteration:
                break
            except cliquevo.Error as error:
                errors.append(str(error))
        self.assertEqual(seen, [0, 1, 3, 4, 5])
        self.assertEqual(len(errors), 1)
        self.assertIn("000002.png", errors[0])

    def test_what_was_assumed_of_a_calibration_is_a_warning(self):
        cliquevo.simulate(self.folder / "run", **COURSE, raw=True)
        notes = cliquevo.open(self.folder / "run").calibration.notes
        with self.assertWarnsRegex(UserWarning, "calibration: ") if notes else self.subTest("nothing assumed"):
            cliquevo.open(self.folder / "run")

    def test_threads_that_share_a_source_get_each_pair_once(self):
        source, seen = cliquevo.open(SMALL), []
        threads = [threading.Thread(target=lambda: seen.extend(p.index for p in source)) for _ in range(3)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual(sorted(seen), list(range(12)))

    def test_a_closed_source_has_no_further_pairs(self):
        with cliquevo.open(SMALL) as source:
            next(source)
        self.assertEqual(list(source), [])


class Logs(Case):
    def setUp(self):
        super().setUp()
        self.log = self.folder / "run.lcm"
        self.trajectory = self.folder / "replay.txt"
        replay(SMALL, self.trajectory, "--lcm", f"file://{self.log}?mode=w")

    def test_messages_of_a_log_are_decoded(self):
        log = cliquevo.Log(self.log)
        self.assertEqual((log.torn_bytes, log.broken_places), (0, 0))
        for channel in ("POSE_BODY", "VO_DELTA_CAMERA", "VO_STATUS"):
            self.assertEqual(log.channels[channel], 12)
        self.assertEqual(len(log), sum(log.channels.values()))
        poses = [cliquevo.decode(event.data) for event in log if event.channel == "POSE_BODY"]
        _, expected = cliquevo.read_trajectory(self.trajectory)
        self.assertEqual(len(poses), 12)
        for pose, T in zip(poses, expected):
            self.assertIsInstance(pose, cliquevo.lcm_types.pose_t)
            # Body axes: X forward, Y left, Z up.
            np.testing.assert_allclose(pose.pos, [T[2, 3], -T[0, 3], -T[1, 3]], atol=1e-9)
        statuses = [cliquevo.decode(event.data).status for event in log if event.channel == "VO_STATUS"]
        self.assertEqual(statuses, [0] + 11 * [1])

    def test_a_log_of_pairs_plays_like_its_recording(self):
        log = self.folder / "pairs.lcm"
        done = command("convert", SMALL, log)
        self.assertEqual(done.returncode, 0, done.stderr)
        for one, other in zip(cliquevo.open(SMALL), cliquevo.open(log)):
            self.assertEqual(one.left.tobytes(), other.left.tobytes())
            self.assertEqual(one.right.tobytes(), other.right.tobytes())
        self.assertEqual(cliquevo.Log(log).channels["VO_STEREO"], 12)

    def test_torn_logs_and_messages_are_reported(self):
        whole = self.log.read_bytes()
        torn = self.folder / "torn.lcm"
        torn.write_bytes(whole[:-5])
        log = cliquevo.Log(torn)
        self.assertEqual(len(log), len(cliquevo.Log(self.log)) - 1)
        self.assertGreater(log.torn_bytes, 0)
        with self.assertRaises(IndexError):
            log[len(log)]
        for bad in (b"", b"12345678", log[0].data[:9], log[0].data[:-1]):
            self.refused(cliquevo.Error, "cannot decode the message", cliquevo.decode, bad)
        for path, content in (("empty", b""), ("text", b"hello"), ("zeros", bytes(1000))):
            (self.folder / path).write_bytes(content)
            self.refused(cliquevo.Error, "", cliquevo.Log, self.folder / path)
        self.refused(cliquevo.Error, "", cliquevo.Log, self.folder / "none")
        self.refused(cliquevo.Error, "", cliquevo.Log, self.folder)


if __name__ == "__main__":
    unittest.main()
