# SPDX-License-Identifier: BSD-3-Clause
"""Recordings: the trajectory, byte for byte, that `cliquevo replay` writes."""
import unittest

from support import DATA, Case, poses_of, replay

import cliquevo


class Recordings(Case):
    def same_as_replay(self, name, every):
        folder = DATA / name
        if not folder.is_dir():
            self.skipTest(f"recording {name} not found below {DATA} (set CLIQUEVO_DATA)")
        expected = replay(folder, self.folder / "replay.txt", "--every", every)
        path = self.folder / "python.txt"
        cliquevo.write_trajectory(path, poses_of(cliquevo.open(folder, every=every)))
        self.assertEqual(path.read_bytes(), expected)
        self.assertGreater(len(expected.splitlines()), 10)

    def test_of_rectified_images(self):
        self.same_as_replay("kitti_odometry_06", 3)

    def test_of_images_as_grabbed_with_a_prescribed_rectification(self):
        self.same_as_replay("kitti_raw", 10)

    def test_of_images_as_grabbed_rectified_by_ourselves(self):
        self.same_as_replay("euroc_shaken", 2)

    def test_of_a_rough_camera(self):
        self.same_as_replay("walk_backyard", 4)


if __name__ == "__main__":
    unittest.main()
