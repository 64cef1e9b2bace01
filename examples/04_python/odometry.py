#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""Poses of a recording, a log or the simulator: odometry.py [SOURCE [TRAJECTORY]]"""
# [ten lines]
import sys

import cliquevo

source = cliquevo.open(sys.argv[1] if len(sys.argv) > 1 else "sim:frames=20")
odometry = cliquevo.Odometry(source)
poses = []
for pair in source:
    estimate = odometry.step(pair.left, pair.right, stamp_ns=pair.stamp_ns)
    poses.append(estimate.T_world_camera)
    print(estimate.status_name, estimate.T_world_camera[:3, 3], estimate.quality)
# [end]

if len(sys.argv) > 2:
    cliquevo.write_trajectory(sys.argv[2], poses)
