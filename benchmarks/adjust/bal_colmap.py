#!/usr/bin/env python3
"""usage: bal_colmap.py PROBLEM [WORK]

A BAL problem by COLMAP's bundle_adjuster: the same images, points and start as a model of text with RADIAL cameras, whose principal point is
held at 0. BAL looks along -z with y up, so both are turned by half a turn about x; every image has a camera of its own, as in BAL. Printed are
the costs (sum of squares, px²) at the start and of COLMAP's answer, counted here over all observations, and its processor time as a program."""
import os
import pathlib
import resource
import subprocess
import sys
import tempfile

import numpy as np

values = pathlib.Path(sys.argv[1]).read_text().split()
work = pathlib.Path(sys.argv[2] if len(sys.argv) > 2 else tempfile.mkdtemp())
images, points, count = map(int, values[:3])
observed = np.array(values[3:3 + 4 * count], float).reshape(-1, 4)
of_image, of_point, xy = observed[:, 0].astype(int), observed[:, 1].astype(int), observed[:, 2:] * [1, -1]
cameras = np.array(values[3 + 4 * count:3 + 4 * count + 9 * images], float).reshape(-1, 9)
places = np.array(values[3 + 4 * count + 9 * images:], float).reshape(-1, 3)


def rotation(vector):
    angle = np.linalg.norm(vector)
    if angle == 0:
        return np.eye(3)
    x, y, z = vector / angle
    K = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * K + (1 - np.cos(angle)) * K @ K


def quaternion(R):
    """w, x, y, z; the largest component is not divided by."""
    K = np.array([[R[0, 0] - R[1, 1] - R[2, 2], 0, 0, 0], [R[0, 1] + R[1, 0], R[1, 1] - R[0, 0] - R[2, 2], 0, 0],
                  [R[0, 2] + R[2, 0], R[1, 2] + R[2, 1], R[2, 2] - R[0, 0] - R[1, 1], 0],
                  [R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1], np.trace(R)]]) / 3
    x, y, z, w = np.linalg.eigh(K)[1][:, -1]
    return np.array([w, x, y, z])


def matrix(q):
    w, x, y, z = q / np.linalg.norm(q)
    return np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)], [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                     [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])


def cost(R, t, interior, X):
    """R, t, interior (f, k1, k2) by image, X by point."""
    p = np.einsum("nij,nj->ni", R[of_image], X[of_point]) + t[of_image]
    u = p[:, :2] / p[:, 2:]
    r2 = np.sum(u * u, 1)
    f, k1, k2 = interior[of_image].T
    return float(np.sum(((f * (1 + k1 * r2 + k2 * r2 * r2))[:, None] * u - xy) ** 2))


half_turn = np.diag([1.0, -1, -1])
R = np.array([half_turn @ rotation(c[:3]) for c in cameras])
t = cameras[:, 3:6] @ half_turn
print(f"start {cost(R, t, cameras[:, 6:], places):.6f}")
for folder in ("start", "end"):
    (work / folder).mkdir(parents=True, exist_ok=True)
with open(work / "start/cameras.txt", "w") as file:
    for i, c in enumerate(cameras):
        file.write(f"{i + 1} RADIAL 10000 10000 {c[6]:.17g} 0 0 {c[7]:.17g} {c[8]:.17g}\n")
by_image, tracks = [[] for _ in range(images)], [[] for _ in range(points)]
for n in range(count):
    tracks[of_point[n]].append((of_image[n] + 1, len(by_image[of_image[n]])))
    by_image[of_image[n]].append(f"{xy[n, 0]:.17g} {xy[n, 1]:.17g} {of_point[n] + 1}")
with open(work / "start/images.txt", "w") as file:
    for i in range(images):
        q = quaternion(R[i])
        file.write(f"{i + 1} {' '.join(f'{v:.17g}' for v in [*q, *t[i]])} {i + 1} {i:05}.jpg\n{' '.join(by_image[i])}\n")
with open(work / "start/points3D.txt", "w") as file:
    for j in range(points):
        file.write(f"{j + 1} {' '.join(f'{v:.17g}' for v in places[j])} 0 0 0 1 {' '.join(f'{i} {k}' for i, k in tracks[j])}\n")
quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL, "env": {**os.environ, "QT_QPA_PLATFORM": "offscreen"}}
subprocess.run(["colmap", "bundle_adjuster", "--input_path", work / "start", "--output_path", work / "end", "--BundleAdjustment.max_num_iterations", "200",
                "--BundleAdjustment.function_tolerance", "1e-10", "--BundleAdjustment.gradient_tolerance", "0", "--BundleAdjustment.parameter_tolerance", "0",
                "--BundleAdjustment.refine_principal_point", "0"], check=True, **quiet)
used = resource.getrusage(resource.RUSAGE_CHILDREN)
seconds = used.ru_utime + used.ru_stime
subprocess.run(["colmap", "model_converter", "--input_path", work / "end", "--output_path", work / "end", "--output_type", "TXT"], check=True, **quiet)
lines = {name: [l.split() for l in (work / "end" / name).read_text().splitlines() if l and not l.startswith("#")] for name in ("cameras.txt", "points3D.txt")}
interior, X = np.zeros((images, 3)), np.full((points, 3), np.nan)
for words in lines["cameras.txt"]:
    interior[int(words[0]) - 1] = float(words[4]), float(words[7]), float(words[8])
for words in lines["points3D.txt"]:
    X[int(words[0]) - 1] = [float(w) for w in words[1:4]]
heads = [l for l in (work / "end/images.txt").read_text().splitlines() if not l.startswith("#")][::2]
for head in heads:
    words = head.split()
    R[int(words[0]) - 1], t[int(words[0]) - 1] = matrix(np.array(words[1:5], float)), np.array(words[5:8], float)
lost = int(np.isnan(X[:, 0]).sum())
print(f"COLMAP {cost(R, t, interior, np.nan_to_num(X)):.6f}, {seconds:.2f} s of processor time" + (f"; {lost} points were taken out by it" if lost else ""))
