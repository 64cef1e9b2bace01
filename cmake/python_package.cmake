# SPDX-License-Identifier: BSD-3-Clause
# The Debian package of the component `python`.
math(EXPR next_minor "${CLIQUEVO_PYTHON_MINOR} + 1")
set(CPACK_DEBIAN_PYTHON_PACKAGE_NAME python3-cliquevo)
set(CPACK_DEBIAN_PYTHON_PACKAGE_SECTION python)
# A compiled module is for one minor version of Python.
set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS
  "python3 (>= 3.${CLIQUEVO_PYTHON_MINOR}), python3 (<< 3.${next_minor}), python3-numpy")
set(CPACK_DEBIAN_PYTHON_PACKAGE_RECOMMENDS "")
set(CPACK_DEBIAN_PYTHON_PACKAGE_SUGGESTS "python3-matplotlib")
set(CPACK_DEBIAN_PYTHON_PACKAGE_SHLIBDEPS ON)
set(CPACK_COMPONENT_PYTHON_DESCRIPTION "real-time stereo visual odometry for Python
Stereo images as numpy arrays go in; 6-DOF poses with covariance and verdict
come out. Recordings, logs, simulator and evaluation are those of the
command cliquevo.")
