# SPDX-License-Identifier: BSD-3-Clause
"""The type stubs match the module, and the examples hold to them."""
import os
import subprocess
import sys
import unittest

from support import SOURCE, Case

import cliquevo


class Types(Case):
    def mypy(self, *arguments):
        environment = {**os.environ, "MYPYPATH": os.environ["PYTHONPATH"].split(":")[0]}
        return subprocess.run([sys.executable, "-m", *map(str, arguments)], capture_output=True, text=True, env=environment,
                              cwd=self.folder, timeout=300)

    def test_stubs_and_module_are_the_same(self):
        # pybind11's own metaclass, and classes that only the module makes.
        allowed = self.folder / "allowed.txt"
        allowed.write_text("cliquevo\\._core\\.[A-Z][A-Za-z]+\ncliquevo\\._core\\.(Estimate|Event|Pair|Source)\\.__init__\n")
        done = self.mypy("mypy.stubtest", "cliquevo._core", "--allowlist", allowed)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)

    def test_the_package_and_its_examples_are_well_typed(self):
        examples = SOURCE / "examples" / "04_python"
        for file in ("odometry.py", "plot_run.py"):
            done = self.mypy("mypy", "--ignore-missing-imports", "--follow-imports=silent", examples / file)
            self.assertEqual(done.returncode, 0, done.stdout + done.stderr)

    def test_wrong_use_is_found_before_it_runs(self):
        program = self.folder / "wrong.py"
        program.write_text("import cliquevo\n"
                           "odometry = cliquevo.Odometry(3)\n"
                           "for pair in cliquevo.open('sim'):\n"
                           "    cliquevo.Odometry(cliquevo.open('sim')).step(pair.left, 'right', 0.0)\n"
                           "    pair.middle\n")
        done = self.mypy("mypy", program)
        self.assertEqual(done.returncode, 1, done.stdout + done.stderr)
        for line in (2, 4, 5):
            self.assertIn(f"wrong.py:{line}: error", done.stdout)

    def test_every_public_name_is_there(self):
        for name in cliquevo.__all__:
            self.assertTrue(hasattr(cliquevo, name), name)
        for lcm_type in (SOURCE / "daemon" / "lcmtypes").glob("*.lcm"):
            self.assertTrue(hasattr(cliquevo, lcm_type.stem), lcm_type)


if __name__ == "__main__":
    unittest.main()
