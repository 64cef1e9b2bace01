# SPDX-License-Identifier: BSD-3-Clause
"""Stereo visual odometry: stereo images in, 6-DOF poses with covariance and verdict out.

    import cliquevo
    source = cliquevo.open("/data/my_drive")
    odometry = cliquevo.Odometry(source)
    for pair in source:
        estimate = odometry.step(pair.left, pair.right, stamp_ns=pair.stamp_ns)

Camera frames: Z forward, X right, Y down. T_a_b takes points from b to a. Lengths in m, stamps in s or ns.
Bad input raises cliquevo.Error (a ValueError), or TypeError for an argument of the wrong kind.
"""
from typing import Any

from . import _lcm_types as lcm_types
from ._core import (
    DISPARITY_SCALE,
    UNKNOWN_DISPARITY,
    Camera,
    DenseStereo,
    Error,
    Estimate,
    Event,
    Log,
    Odometry,
    Pair,
    Rectifier,
    Source,
    Status,
    StereoCalibration,
    StereoModel,
    __version__,
    evaluate,
    open,
    read_calibration,
    read_trajectory,
    simulate,
    write_trajectory,
)
from ._lcm_types import *  # noqa: F403  generated modules look for their types here

__all__ = [
    "Camera", "DISPARITY_SCALE", "DenseStereo", "Error", "Estimate", "Event", "Log", "Odometry", "Pair", "Rectifier",
    "Source", "Status", "StereoCalibration", "StereoModel", "UNKNOWN_DISPARITY", "__version__", "decode", "evaluate",
    "lcm_types", "open", "read_calibration", "read_trajectory", "simulate", "write_trajectory",
]

_TYPES = {bytes(t._get_packed_fingerprint()): t for t in lcm_types.TYPES}


def decode(data: bytes) -> Any:
    """The message in these bytes, an object of lcm_types; the first eight of them identify its type."""
    kind = _TYPES.get(bytes(data[:8]))
    if kind is None:
        raise Error("cannot decode the message: unknown type: see that it is one of cliquevo's, of this version")
    try:
        return kind.decode(bytes(data))
    except Exception as error:
        raise Error(f"cannot decode the message: {kind.__name__}: it is torn ({error})") from None
