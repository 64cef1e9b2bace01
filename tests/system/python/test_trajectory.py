# SPDX-License-Identifier: BSD-3-Clause
"""Trajectory files, and figures that are those of `cliquevo eval`."""
import json
import math
import unittest

import numpy as np
from support import SMALL, Case, command, replay

import cliquevo


class Trajectories(Case):
    def setUp(self):
        super().setUp()
        source = cliquevo.open(SMALL)
        pairs = list(source)
        odometry = cliquevo.Odometry(source)
        self.estimates = [odometry.step(p.left, p.right, stamp_ns=p.stamp_ns) for p in pairs]
        self.poses = np.array([e.T_world_camera for e in self.estimates])
        self.truth = np.array([p.T_world_camera for p in pairs])
        self.stamps = [p.stamp_ns for p in pairs]

    def test_files_read_back_to_their_thirteen_digits(self):
        path = self.folder / "poses.txt"
        cliquevo.write_trajectory(path, self.poses[:, :3])
        stamps, poses = cliquevo.read_trajectory(path)
        self.assertIsNone(stamps)
        np.testing.assert_allclose(poses, self.poses, atol=1e-12)
        cliquevo.write_trajectory(path, self.poses, self.stamps, format="tum")
        expected = self.folder / "replay.tum"
        self.assertEqual(path.read_bytes(), replay(SMALL, expected, "--format", "tum"))
        stamps, poses = cliquevo.read_trajectory(path)
        np.testing.assert_allclose(stamps, self.stamps, atol=1000)
        np.testing.assert_allclose(poses, self.poses, atol=1e-9)

    def test_evaluate_gives_the_figures_of_the_command(self):
        reference, estimate = self.folder / "truth.txt", self.folder / "poses.txt"
        cliquevo.write_trajectory(reference, self.truth)
        cliquevo.write_trajectory(estimate, self.poses)
        done = command("eval", "--reference", reference, "--estimate", estimate, "--lengths", "0.3,0.5,80", "--json")
        self.assertEqual(done.returncode, 0, done.stderr)
        ours = cliquevo.evaluate(reference, estimate, lengths_m=[0.3, 0.5, 80])
        self.assertEqual(ours, json.loads(done.stdout))
        self.assertGreater(ours["segments"], 0)
        self.assertIsNone(ours["by_length"][2]["t_err_pct"])
        of_arrays = cliquevo.evaluate(self.truth, self.poses, lengths_m=[0.3, 0.5, 80])
        self.assertAlmostEqual(of_arrays["ate_m"], ours["ate_m"], places=9)
        self.assertAlmostEqual(of_arrays["path_m"], 1.1, delta=0.05)

    def test_trajectories_that_cannot_be_are_refused(self):
        path, good = self.folder / "poses.txt", self.poses
        broken = good.copy()
        broken[3, 0, 0] = math.nan
        for poses, sentence in [(broken, "poses[3]"), (good[0], "shape (4, 4)"), (good[:, :2], "shape (12, 2, 4)"),
                                (2 * good, "rotation matrix"), (good * [-1, 1, 1, 1], "rotation matrix")]:
            self.refused(cliquevo.Error, sentence, cliquevo.write_trajectory, path, poses)
            self.refused(cliquevo.Error, "", cliquevo.evaluate, poses, good)
        for poses in (None, "abc", object(), [["x"]]):
            self.refused(TypeError, "", cliquevo.write_trajectory, path, poses)
        self.refused(TypeError, "TUM files carry stamps", cliquevo.write_trajectory, path, good, format="tum")
        self.refused(cliquevo.Error, "give one stamp a pose", cliquevo.write_trajectory, path, good, [1], format="tum")
        self.refused(cliquevo.Error, "choose from kitti, tum", cliquevo.write_trajectory, path, good, format="csv")
        self.refused(cliquevo.Error, "", cliquevo.write_trajectory, "/no/such/folder/x.txt", good)
        for wrong in ({"lengths_m": [0.0]}, {"lengths_m": [math.nan]}, {"tolerance_s": math.nan},
                      {"sample_period_s": -1.0}, {"reference_frame": "moon"}):
            self.refused(cliquevo.Error, "", cliquevo.evaluate, good, good, **wrong)
        printed = command("eval", "--reference", "/no/such", "--estimate", "/no/such")
        error = self.refused(cliquevo.Error, "", cliquevo.evaluate, "/no/such", "/no/such")
        self.assertEqual(str(error), printed.stderr.strip())
        self.refused(cliquevo.Error, "", cliquevo.evaluate, good[:1], good)


if __name__ == "__main__":
    unittest.main()
