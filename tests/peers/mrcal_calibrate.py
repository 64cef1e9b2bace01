#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""Stereo calibrations by mrcal, for tests: mrcal_calibrate.py IN.json OUT.json

IN: {"size": [w, h], "board": [columns, rows, size_m], "focal_px": guess,
     "views": [{"left": [[x, y] or null, ...], "right": ...}, ...], "sets": [[index of a view, ...], ...]}
OUT: a list, an entry a set: {"left": {"values": [fx, fy, cx, cy, k1, k2, p1, p2], "sigmas": ...}, "right": ...,
     "t": {"values": ..., "sigmas": ...}, "R": 9 numbers row by row (points of the left camera to the right one),
     "sigma_px": of a coordinate}
"""
import json
import sys

import mrcal
import numpy as np

MODEL = "LENSMODEL_OPENCV4"
SIDES = ("left", "right")


def observations(views, columns, rows):
    """Corners as mrcal has them, and (view, camera) of each."""
    seen, indices = [], []
    for number, view in enumerate(views):
        for camera, side in enumerate(SIDES):
            corners = [[*corner, 1.0] if corner else [-1.0, -1.0, -1.0] for corner in view[side]]
            seen.append(np.array(corners).reshape(rows, columns, 3))
            indices.append((number, camera))
    return np.array(seen), np.array(indices, dtype=np.int32)


def solved(given, views):
    columns, rows, size_m = given["board"]
    seen, indices = observations(views, columns, rows)
    sizes = np.array([given["size"]] * 2, dtype=np.int32)
    core, extrinsics, frames = mrcal.seed_stereographic(
        imagersizes=sizes, focal_estimate=given["focal_px"], indices_frame_camera=indices, observations=seen,
        object_spacing=size_m)
    problem = {
        "intrinsics": np.hstack((core, np.zeros((2, 4)))),
        "extrinsics_rt_fromref": extrinsics,
        "frames_rt_toref": frames,
        "points": None,
        "observations_board": seen,
        "indices_frame_camintrinsics_camextrinsics": np.array([(v, c, c - 1) for v, c in indices], dtype=np.int32),
        "observations_point": None,
        "indices_point_camintrinsics_camextrinsics": None,
        "lensmodel": MODEL,
        "imagersizes": sizes,
        "calobject_warp": np.zeros(2),
        "calibration_object_spacing": size_m,
        "do_apply_regularization": False,
        "do_apply_outlier_rejection": False,
        "do_optimize_calobject_warp": False,
        "verbose": False,
    }
    # As mrcal-calibrate-cameras does: poses first, then focal lengths and centres, then all.
    for core_too, lens_too, warp_too in ((False, False, False), (True, False, False), (True, True, False), (True, True, True)):
        problem.update(do_optimize_intrinsics_core=core_too, do_optimize_intrinsics_distortions=lens_too,
                       do_optimize_calobject_warp=warp_too)
        mrcal.optimize(**problem)
    return problem


def result(problem):
    _, x, _, factorization = mrcal.optimizer_callback(**problem)
    used = int(2 * np.sum(problem["observations_board"][..., 2] > 0))
    state = mrcal.num_states(**problem)
    sigma_px = float(np.sqrt(np.sum(x[:2 * problem["observations_board"][..., 0].size] ** 2) / (used - state)))
    # Rows of the inverse normal matrix, in the units of the packed state.
    unit = np.zeros(state)
    sigmas = np.zeros(state)
    for i in range(state):
        unit[:] = 0.0
        unit[i] = 1.0
        sigmas[i] = sigma_px * np.sqrt(factorization.solve_xt_JtJ_bt(unit)[i])
    mrcal.unpack_state(sigmas, **problem)
    out = {"sigma_px": sigma_px}
    for camera, side in enumerate(SIDES):
        first = mrcal.state_index_intrinsics(camera, **problem)
        values = problem["intrinsics"][camera]
        out[side] = {"values": values.tolist(), "sigmas": sigmas[first:first + values.size].tolist()}
    first = mrcal.state_index_extrinsics(0, **problem)
    pose = problem["extrinsics_rt_fromref"][0]
    out["R"] = mrcal.R_from_r(pose[:3]).ravel().tolist()
    out["t"] = {"values": pose[3:].tolist(), "sigmas": sigmas[first + 3:first + 6].tolist()}
    return out


def main():
    with open(sys.argv[1], encoding="utf-8") as file:
        given = json.load(file)
    results = [result(solved(given, [given["views"][i] for i in chosen])) for chosen in given["sets"]]
    with open(sys.argv[2], "w", encoding="utf-8") as file:
        json.dump(results, file)


main()
