# SPDX-License-Identifier: BSD-3-Clause
"""Images in, poses out: the same as the command's, without copies, from any thread."""
import sys
import threading
import tracemalloc
import unittest

import numpy as np
from support import SMALL, Case, poses_of, replay, small_model, wall

import cliquevo


class Odometry(Case):
    def written(self, poses):
        path = self.folder / "python.txt"
        cliquevo.write_trajectory(path, poses)
        return path.read_bytes()

    def test_the_trajectory_of_the_simulator_is_the_one_that_replay_writes(self):
        expected = replay(SMALL, self.folder / "replay.txt")
        self.assertEqual(len(expected.splitlines()), 12)
        self.assertEqual(self.written(poses_of(cliquevo.open(SMALL))), expected)

    def test_the_trajectory_of_images_as_grabbed_is_the_one_that_replay_writes(self):
        raw = SMALL + ",raw=on"
        self.assertEqual(self.written(poses_of(cliquevo.open(raw))), replay(raw, self.folder / "replay.txt"))

    def test_settings_are_the_keys_of_the_configuration(self):
        config = self.folder / "config.yaml"
        config.write_text("stereo:\n  num_disparities: 48\nodometry:\n  max_features: 120\n")
        expected = replay(SMALL, self.folder / "replay.txt", "--config", config)
        settings = {"stereo.num_disparities": 48, "odometry.max_features": 120}
        self.assertEqual(self.written(poses_of(cliquevo.open(SMALL), settings=settings)), expected)
        self.assertEqual(self.written(poses_of(cliquevo.open(SMALL), config=config)), expected)
        self.assertNotEqual(expected, replay(SMALL, self.folder / "default.txt"))

    def test_poses_covariances_and_verdicts_are_those_of_the_motion(self):
        model = small_model()
        odometry = cliquevo.Odometry(model)
        for frame, (left, right) in enumerate(wall(model)):
            estimate = odometry.step(left, right, 0.1 * frame)
            self.assertEqual(estimate.status, cliquevo.Status.VALID if frame else cliquevo.Status.NO_DATA)
            np.testing.assert_allclose(estimate.T_world_camera[:3, 3], [0, 0, 0.1 * frame], atol=0.01)
        self.assertTrue(estimate.valid)
        self.assertEqual(estimate.stamp_ns, 300_000_000)
        self.assertEqual(estimate.covariance.shape, (6, 6))
        self.assertTrue((np.linalg.eigvalsh(estimate.covariance) > 0).all())
        self.assertEqual(estimate.failed_checks, [])
        self.assertTrue(estimate.checks)
        self.assertLess(max(estimate.checks.values()), 1.0)
        depth = odometry.model.depth_m(odometry.disparity)
        self.assertEqual(depth.dtype, np.float32)
        self.assertAlmostEqual(float(np.nanmedian(depth)), 2.7, delta=0.15)

    def test_a_blank_frame_is_a_verdict_not_an_exception(self):
        model = small_model()
        odometry = cliquevo.Odometry(model)
        (left, right), *_ = wall(model, 1)
        odometry.step(left, right, 0.0)
        estimate = odometry.step(np.zeros_like(left), np.zeros_like(right), 0.1)
        self.assertFalse(estimate.valid)
        self.assertEqual(estimate.quality, 0)
        self.assertTrue(np.isfinite(estimate.covariance).all())

    def test_reset_starts_again_at_the_identity(self):
        model = small_model()
        odometry = cliquevo.Odometry(model)
        for frame, (left, right) in enumerate(wall(model, 3)):
            odometry.step(left, right, 0.1 * frame)
        odometry.reset()
        estimate = odometry.step(left, right, 0.0)
        np.testing.assert_array_equal(estimate.T_world_camera, np.identity(4))

    def test_a_mask_keeps_features_away(self):
        model = small_model()
        (left, right), *_ = wall(model, 1)
        mask = np.full_like(left, 255)
        mask[:, :290] = 0
        free = cliquevo.Odometry(model).step(left, right, 0.0)
        masked = cliquevo.Odometry(model, left_mask=mask).step(left, right, 0.0)
        self.assertLess(masked.features, free.features)
        self.refused(cliquevo.Error, "left mask", cliquevo.Odometry, model, left_mask=mask[:100])

    def test_views_with_a_stride_give_the_same_bytes_as_copies(self):
        model = small_model()
        odometry, strided = cliquevo.Odometry(model), cliquevo.Odometry(model)
        for frame, (left, right) in enumerate(wall(model)):
            both = np.zeros((model.height, 2 * model.width + 7), np.uint8)
            both[:, 3 : 3 + model.width], both[:, 3 + model.width : 3 + 2 * model.width] = left, right
            views = both[:, 3 : 3 + model.width], both[:, 3 + model.width : 3 + 2 * model.width]
            self.assertFalse(views[0].flags.c_contiguous)
            both.flags.writeable = False
            one = odometry.step(left, right, 0.1 * frame)
            other = strided.step(*views, 0.1 * frame)
            self.assertEqual(one.T_world_camera.tobytes(), other.T_world_camera.tobytes())
            self.assertEqual(one.covariance.tobytes(), other.covariance.tobytes())
        self.assertEqual(odometry.disparity.tobytes(), strided.disparity.tobytes())

    def test_a_step_copies_no_image(self):
        model = small_model()
        odometry = cliquevo.Odometry(model)
        pairs = wall(model)
        odometry.step(*pairs[0], 0.0)
        tracemalloc.start()
        self.addCleanup(tracemalloc.stop)
        before, _ = tracemalloc.get_traced_memory()
        tracemalloc.reset_peak()
        odometry.step(*pairs[1], 0.1)
        _, peak = tracemalloc.get_traced_memory()
        self.assertLess(peak - before, pairs[0][0].nbytes // 4)


class Threads(Case):
    def test_other_threads_run_while_a_frame_is_computed(self):
        model = small_model()
        pairs = wall(model)
        odometry = cliquevo.Odometry(model)
        counted, done = [0], threading.Event()

        def count():
            while not done.is_set():
                counted[0] += 1

        interval = sys.getswitchinterval()
        self.addCleanup(sys.setswitchinterval, interval)
        other = threading.Thread(target=count)
        other.start()
        try:
            # No switch is forced for so long: the other thread runs only where this one lets go.
            sys.setswitchinterval(1.0)
            before = counted[0]
            for frame, pair in enumerate(pairs):
                odometry.step(*pair, 0.1 * frame)
            after = counted[0]
        finally:
            sys.setswitchinterval(interval)
            done.set()
            other.join()
        self.assertGreater(after, before)

    def test_one_object_serves_threads_one_after_the_other(self):
        model = small_model()
        pairs = wall(model, 2)
        stereo = cliquevo.DenseStereo(model.width, model.height)
        expected = [stereo.compute(*pair).tobytes() for pair in pairs]
        self.assertNotEqual(*expected)
        wrong = []

        def work(which):
            for _ in range(8):
                if stereo.compute(*pairs[which]).tobytes() != expected[which]:
                    wrong.append(which)

        threads = [threading.Thread(target=work, args=(i % 2,)) for i in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual(wrong, [])

    def test_two_threads_that_race_with_one_odometry_get_poses_or_errors(self):
        model = small_model()
        pairs = wall(model, 2)
        odometry = cliquevo.Odometry(model)
        outcomes = []

        def work(offset):
            for i in range(12):
                try:
                    outcomes.append(odometry.step(*pairs[i % 2], stamp_ns=(2 * i + offset) * 10_000_000).status_name)
                    odometry.disparity.sum()
                except cliquevo.Error as error:
                    outcomes.append(str(error))

        threads = [threading.Thread(target=work, args=(offset,)) for offset in (0, 1)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual(len(outcomes), 24)
        for outcome in outcomes:
            self.assertTrue("time stamp does not advance" in outcome or ":" not in outcome, outcome)


if __name__ == "__main__":
    unittest.main()
