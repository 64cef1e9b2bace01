#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""A run, its uncertainty and its depth as a picture: plot_run.py SOURCE PICTURE.png

Cell by cell as in a notebook: every editor that knows the marks "# %%" runs them one by one.
"""
import sys

import matplotlib
import numpy as np

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402  after the choice of the backend
from matplotlib.colors import LogNorm  # noqa: E402

import cliquevo  # noqa: E402

source_name, picture = sys.argv[1:3]

# %% Every pair through the odometry.
source = cliquevo.open(source_name)
odometry = cliquevo.Odometry(source)
estimates, truth, last = [], [], None
for pair in source:
    estimates.append(odometry.step(pair.left, pair.right, stamp_ns=pair.stamp_ns))
    if pair.T_world_camera is not None:
        truth.append(pair.T_world_camera)
    last = pair
if last is None:
    sys.exit(f"no pairs: {source_name}: give a source that has some")
poses = np.array([estimate.T_world_camera for estimate in estimates])
valid = np.array([estimate.valid for estimate in estimates])
step_sigma_mm = 1e3 * np.array([np.sqrt(np.trace(e.covariance[:3, :3])) for e in estimates])

# %% How far it is from the truth, where that is known.
title = source.description
if len(truth) > 1:
    true_poses = np.linalg.inv(truth[0]) @ np.array(truth)
    report = cliquevo.evaluate(true_poses, poses, lengths_m=[1.0, 2.0, 5.0])
    title += f"\n{report['path_m']:.2f} m, {report['end_m'] * 1e3:.1f} mm off at the end"

# %% The picture: from above, uncertainty of each step, the last frame and its depth.
figure, ((way, sigma), (image, depth)) = plt.subplots(2, 2, figsize=(11, 8), constrained_layout=True)
figure.suptitle(title, fontsize=9)
if len(truth) > 1:
    way.plot(true_poses[:, 0, 3], true_poses[:, 2, 3], color="0.6", linewidth=4, label="truth")
way.plot(poses[:, 0, 3], poses[:, 2, 3], color="tab:blue", label="odometry")
failed = poses[1:][~valid[1:]]
if len(failed):
    way.plot(failed[:, 0, 3], failed[:, 2, 3], "x", color="tab:red", label="failed")
way.set(xlabel="X, m (right)", ylabel="Z, m (forward)", title="from above")
way.axis("equal")
way.legend()

sigma.plot(np.arange(len(poses))[valid], step_sigma_mm[valid], ".", color="tab:blue")
sigma.set(xlabel="frame", ylabel="mm", ylim=(0, None), title="standard deviation of each step")

image.imshow(last.left, cmap="gray", vmin=0, vmax=255)
image.set(title="last left image")
metres = odometry.model.depth_m(odometry.disparity)
known = metres[np.isfinite(metres)]
near, far = np.percentile(known, [1, 95]) if known.size else (1.0, 10.0)
shown = depth.imshow(metres, cmap="turbo_r", norm=LogNorm(near, max(far, 1.01 * near)))
depth.set(title="its depth (white: unknown)")
figure.colorbar(shown, ax=depth, label="m", ticks=[1, 2, 5, 10, 20, 50, 100], format="%g", shrink=0.8)
figure.savefig(picture, dpi=100)
