# SPDX-License-Identifier: BSD-3-Clause
"""Whatever is handed over: an exception with a clear sentence, never a crash and never a guess."""
import math
import random
import unittest

import numpy as np
from support import Case, command, small_model, wall

import cliquevo


class BadInput(Case):
    def setUp(self):
        super().setUp()
        self.model = small_model()
        (self.left, self.right), *_ = wall(self.model, 1)
        self.odometry = cliquevo.Odometry(self.model)

    def test_images_that_cannot_be_used_are_refused_with_what_to_give(self):
        left, right = self.left, self.right
        for kind, bad, sentence in [
            (TypeError, None, "left is None"),
            (TypeError, 7, "left is of type int"),
            (TypeError, [[1, 2], [3, 4]], "left is of type list"),
            (TypeError, left.tolist(), "numpy.asarray(left)"),
            (TypeError, bytes(left), "left is of type bytes"),
            (TypeError, left.astype(np.float32), "left has dtype float32: give uint8"),
            (TypeError, left.astype(np.int8), "left has dtype int8"),
            (TypeError, left.astype(np.uint16), "left has dtype uint16"),
            (TypeError, left.astype(bool), "left has dtype bool"),
            (TypeError, left.astype(object), "left has dtype object"),
            (cliquevo.Error, left.ravel(), "has shape (76800,)"),
            (cliquevo.Error, np.dstack([left] * 3), "has shape (240, 320, 3): give one grey image"),
            (cliquevo.Error, np.array(3, np.uint8), "has shape ()"),
            (cliquevo.Error, left[:0], "has shape (0, 320)"),
            (cliquevo.Error, left[:, :0], "has shape (240, 0)"),
            (cliquevo.Error, np.broadcast_to(np.uint8(1), (1, 100000)), "16384 pixels each way"),
            (cliquevo.Error, left[:100], "the left image has 320x100 px: give images of 320x240 px"),
            (cliquevo.Error, left.T, "numpy.ascontiguousarray(left)"),
            (cliquevo.Error, np.asfortranarray(left), "has strides (1, 240)"),
            (cliquevo.Error, np.repeat(left, 2, axis=1)[:, ::2], "has strides (640, 2)"),
            (cliquevo.Error, left[::-1], "has strides (-320, 1)"),
            (cliquevo.Error, left[:, ::-1], "has strides (320, -1)"),
            (cliquevo.Error, np.broadcast_to(left[0], left.shape), "has strides (0, 1)"),
            (cliquevo.Error, np.lib.stride_tricks.as_strided(left, left.shape, (5, 1)), "has strides (5, 1)"),
        ]:
            with self.subTest(sentence):
                self.refused(kind, sentence, self.odometry.step, bad, right, 0.0)
                self.refused(kind, sentence.replace("left", "right"), self.odometry.step, left, bad, 0.0)
                stereo = cliquevo.DenseStereo(320, 240)
                self.refused(kind, "", stereo.compute, bad, right)
        # Nothing of that has been taken for a frame.
        self.assertEqual(self.odometry.step(left, right, 0.0).status, cliquevo.Status.NO_DATA)

    def test_stamps_that_are_none_are_refused(self):
        step, pair = self.odometry.step, (self.left, self.right)
        for stamp in (math.nan, math.inf, -math.inf, np.float32("nan")):
            self.refused(cliquevo.Error, "give the exposure's time in seconds", step, *pair, stamp)
        self.refused(cliquevo.Error, "nanoseconds as stamp_ns=", step, *pair, 1_700_000_000_000_000_000)
        for stamp in ("0.1", [1.0], 1j, object()):
            self.refused(TypeError, "give the exposure's time in seconds", step, *pair, stamp)
        for stamp in (0.5, "1", math.nan):
            self.refused(TypeError, "give a whole number of nanoseconds", step, *pair, stamp_ns=stamp)
        for stamp in (2**62 + 1, -(2**62) - 1, 2**80):
            self.refused(cliquevo.Error, "at most 2**62", step, *pair, stamp_ns=stamp)
        self.refused(TypeError, "neither stamp nor stamp_ns", step, *pair)
        self.refused(TypeError, "both stamp and stamp_ns", step, *pair, 1.0, stamp_ns=1)
        step(*pair, stamp_ns=np.int64(5))
        self.refused(cliquevo.Error, "time stamp does not advance", step, *pair, stamp_ns=5)
        self.refused(cliquevo.Error, "time stamp does not advance", step, *pair, stamp_ns=4)

    def test_models_that_cannot_be_are_refused(self):
        good = {"width": 320, "height": 240, "fx_px": 300.0, "cx_px": 159.5, "cy_px": 119.5, "baseline_m": 0.12}
        for key in good:
            for value in (0, -1) if key in ("width", "height") else (math.nan, math.inf):
                self.refused(cliquevo.Error, "", cliquevo.StereoModel, **{**good, key: value})
        for model in (None, 3, "model", cliquevo.StereoModel):
            self.refused(TypeError, "give a StereoModel, a StereoCalibration or a source", cliquevo.Odometry, model)
        self.refused_any(cliquevo.Odometry, cliquevo.StereoModel(**{**good, "width": 16, "height": 16, "cx_px": 8, "cy_px": 8}))

    def refused_any(self, work, *arguments, **named):
        with self.assertRaises((cliquevo.Error, TypeError)):
            work(*arguments, **named)

    def test_calibrations_that_cannot_be_are_refused(self):
        camera = cliquevo.Camera(width=320, height=240, fx_px=300, fy_px=300, cx_px=159.5, cy_px=119.5)
        T = np.identity(4)
        T[0, 3] = -0.12
        cliquevo.Rectifier(cliquevo.StereoCalibration(camera, camera, T))
        self.refused(cliquevo.Error, "rotation matrix", cliquevo.StereoCalibration, camera, camera, 2 * T)
        self.refused(cliquevo.Error, "rotation matrix", cliquevo.StereoCalibration, camera, camera, T * math.nan)
        self.refused(cliquevo.Error, "shape (2, 2)", cliquevo.StereoCalibration, camera, camera, np.identity(2))
        self.refused(TypeError, "None", cliquevo.StereoCalibration, camera, camera, None)
        self.refused(cliquevo.Error, "", cliquevo.Rectifier, cliquevo.StereoCalibration(camera, camera, np.identity(4)))
        self.refused(cliquevo.Error, "unknown distortion: fish", cliquevo.Camera, width=1, height=1, fx_px=1, fy_px=1,
                     cx_px=0, cy_px=0, distortion="fish")
        nan = cliquevo.Camera(width=320, height=240, fx_px=math.nan, fy_px=300, cx_px=1, cy_px=1)
        self.refused(cliquevo.Error, "", cliquevo.Odometry, cliquevo.StereoCalibration(nan, camera, T))
        huge = cliquevo.Camera(width=2**31 - 1, height=2**31 - 1, fx_px=300, fy_px=300, cx_px=1, cy_px=1)
        self.refused(cliquevo.Error, "", cliquevo.Odometry, cliquevo.StereoCalibration(huge, huge, T))

    def test_settings_that_are_unknown_or_out_of_range_are_refused(self):
        for settings, sentence in [
            ({"stereo.windw": 9}, "windw"),
            ({"stereo.window": 8}, "stereo.window"),
            ({"stereo.window": math.nan}, "stereo.window"),
            ({"stereo.window": "wide"}, "stereo.window"),
            ({"stereo": 3, "stereo.window": 9}, "give one of them"),
            ({"a\nb": 3}, "a b"),
        ]:
            self.refused(cliquevo.Error, sentence, cliquevo.Odometry, self.model, settings=settings)
        self.refused(TypeError, "give keys like", cliquevo.Odometry, self.model, settings={3: 4})
        self.refused(TypeError, "give a dict", cliquevo.Odometry, self.model, settings=[1])
        self.refused(TypeError, "both settings and config", cliquevo.Odometry, self.model, settings={}, config="x")

    def test_errors_are_the_lines_that_the_command_prints(self):
        torn = self.folder / "torn.lcm"
        torn.write_bytes(b"\xed\xa1\xda\x01" + b"x" * 40)
        empty = self.folder / "empty"
        empty.mkdir()
        for source in ("/no/such/folder", "sim:course=flying", "sim:frames=0", str(empty), str(torn), "/dev/null"):
            printed = command("replay", source)
            self.assertNotEqual(printed.returncode, 0)
            error = self.refused(cliquevo.Error, "", cliquevo.open, source)
            self.assertEqual(str(error), printed.stderr.strip())
            self.assertEqual(f"{error.what}: {error.where}: {error.remedy}", str(error))
        self.assertIsInstance(error, ValueError)

    def test_random_arrays_never_crash(self):
        random.seed(1)
        dtypes = [np.uint8, np.int8, np.uint16, np.float64, bool, "S3", "U2", object, "datetime64[s]", [("a", "u1")]]
        stereo = cliquevo.DenseStereo(32, 24, settings={"stereo.num_disparities": 16})
        taken = 0
        for _ in range(400):
            shape = tuple(random.choice([0, 1, 2, 24, 32, 64]) for _ in range(random.choice([0, 1, 2, 2, 2, 3])))
            array = np.zeros(shape, random.choice(dtypes[:1] * 12 + dtypes))
            for axis in range(array.ndim):
                if random.random() < 0.3:
                    cut = [slice(None)] * array.ndim
                    cut[axis] = slice(None, None, random.choice([-1, 1, 2]))
                    array = array[tuple(cut)]
            if random.random() < 0.2:
                array = array.T
            for work in (lambda: stereo.compute(array, array), lambda: self.odometry.step(array, array, 1.0),
                         lambda: self.model.depth_m(array), lambda: cliquevo.evaluate(array, array)):
                try:
                    work()
                    taken += 1
                except (TypeError, cliquevo.Error) as error:
                    self.assertNotIn("\n", str(error))
        self.assertGreater(taken, 0)


class Paths(Case):
    def test_paths_may_be_anything_that_names_a_file(self):
        folder = self.folder / "cöurse"
        self.assertEqual(cliquevo.simulate(folder, frames=2, width=160, height=120, focal_px=180, cache_dir="none"), 2)
        for path in (folder, str(folder), bytes(folder)):
            self.assertEqual(len(list(cliquevo.open(path))), 2)
        for path in (None, 3, ["a"]):
            self.refused(TypeError, "give a str or an os.PathLike", cliquevo.open, path)
        self.refused(cliquevo.Error, "NUL", cliquevo.open, "a\0b")
        self.refused(cliquevo.Error, "", cliquevo.open, b"/no/\xff\xfe/such")


if __name__ == "__main__":
    unittest.main()
