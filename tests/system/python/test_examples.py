# SPDX-License-Identifier: BSD-3-Clause
"""The examples run as their README has it."""
import os
import subprocess
import sys
import unittest

import numpy as np
from support import SMALL, SOURCE, Case, replay

EXAMPLES = SOURCE / "examples" / "04_python"


class Examples(Case):
    def run_example(self, name, *arguments):
        done = subprocess.run([sys.executable, str(EXAMPLES / name), *map(str, arguments)], capture_output=True,
                              text=True, timeout=300, env={**os.environ, "MPLCONFIGDIR": str(self.folder)})
        self.assertEqual(done.returncode, 0, done.stderr)
        return done.stdout

    def test_ten_lines_give_the_trajectory_of_replay(self):
        written = self.folder / "python.txt"
        printed = self.run_example("odometry.py", SMALL, written)
        self.assertEqual(written.read_bytes(), replay(SMALL, self.folder / "replay.txt"))
        self.assertEqual(printed.count("valid"), 11)

    def test_the_ten_lines_are_ten(self):
        text = (EXAMPLES / "odometry.py").read_text()
        lines = text.split("# [ten lines]\n")[1].split("# [end]")[0].splitlines()
        self.assertLessEqual(len([line for line in lines if line]), 10)

    def test_the_picture_of_a_run_shows_something(self):
        from matplotlib import image

        picture = self.folder / "run.png"
        self.run_example("plot_run.py", SMALL, picture)
        pixels = image.imread(str(picture))
        self.assertGreater(pixels.shape[0], 500)
        grey = pixels[..., :3].mean(axis=2)
        for part in (grey[: len(grey) // 2], grey[len(grey) // 2 :]):
            self.assertGreater(part.std(), 0.05)
            self.assertGreater(len(np.unique(part.round(3))), 50)


if __name__ == "__main__":
    unittest.main()
