# SPDX-License-Identifier: BSD-3-Clause
"""The component `python` as it is installed, and as the package python3-cliquevo."""
import os
import subprocess
import sys
import unittest
from pathlib import Path

from support import Case

BUILD = Path(os.environ["CLIQUEVO_BUILD_DIR"])
PROGRAM = """import cliquevo, numpy
odometry = cliquevo.Odometry(cliquevo.StereoModel(width=320, height=240, fx_px=300, cx_px=160, cy_px=120, baseline_m=.1))
image = numpy.zeros((240, 320), numpy.uint8)
print(cliquevo.__file__, cliquevo.__version__, odometry.step(image, image, 0.0).status_name)
"""


def run(*command, **options):
    done = subprocess.run([str(part) for part in command], capture_output=True, text=True, timeout=300, **options)
    if done.returncode != 0:
        raise AssertionError(done.stdout + done.stderr)
    return done.stdout


class Package(Case):
    def import_from(self, folder):
        printed = run(sys.executable, "-c", PROGRAM, env={**os.environ, "PYTHONPATH": str(folder)}, cwd=self.folder)
        self.assertTrue(printed.startswith(str(folder)), printed)
        self.assertIn("no data", printed)

    def test_the_component_is_complete_by_itself(self):
        run("cmake", "--install", BUILD, "--component", "python", "--prefix", self.folder / "usr")
        self.import_from(self.folder / "usr" / "lib" / "python3" / "dist-packages")
        self.assertEqual(sorted(p.name for p in (self.folder / "usr").iterdir()), ["lib", "share"])

    def test_the_debian_package_holds_it_and_names_what_it_needs(self):
        run("cpack", "-G", "DEB", "-D", "CPACK_DEB_COMPONENT_INSTALL=ON", "-D", "CPACK_COMPONENTS_ALL=python",
            "-D", "CPACK_DEBIAN_PACKAGE_CONTROL_EXTRA=", "-B", self.folder, cwd=BUILD)
        packages = list(self.folder.glob("python3-cliquevo_*.deb"))
        self.assertEqual(len(packages), 1)
        depends = run("dpkg-deb", "-f", packages[0], "Depends")
        for needed in ("python3 (>= 3.", "python3-numpy", "libstdc++6"):
            self.assertIn(needed, depends)
        for not_needed in ("libcairo", "libopencv", "liblcm", "libaravis", "libcamera", "libsystemd"):
            self.assertNotIn(not_needed, depends)
        run("dpkg-deb", "-x", packages[0], self.folder / "root")
        self.import_from(self.folder / "root" / "usr" / "lib" / "python3" / "dist-packages")


if __name__ == "__main__":
    unittest.main()
