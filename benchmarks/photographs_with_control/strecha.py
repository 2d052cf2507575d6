#!/usr/bin/env python3
"""usage: strecha.py PLUMBLINE FOLDER WORK [MAX_IMAGE_SIZE]

Photographs, control points and check points end to end, on a set of the benchmark of Strecha et al. (CVPR 2008): FOLDER has images/*.jpg and
the published cameras, gt_dense_cameras/*.jpg.camera, which come from a laser scan. `colmap.sfm` makes a model of the photographs alone; 14 of
its points, well spread, are intersected from the published cameras and moved to map coordinates: 7 are control, 7 withheld. Root mean square
of the withheld ones: `colmap_control`, the similarity on the same control points (Umeyama 1991), COLMAP's model_aligner on all published camera centres.
The points are measured at the features that the model has of them, so their errors in the photographs are those of the model's own."""
import csv
import json
import os
import pathlib
import shutil
import subprocess
import sys

import numpy as np

from similarity import similarity

PLUMBLINE, FOLDER, WORK = os.path.abspath(sys.argv[1]), pathlib.Path(sys.argv[2]).resolve(), pathlib.Path(sys.argv[3]).resolve()
SIZE = int(sys.argv[4]) if len(sys.argv) > 4 else 1536
SIGMA, POINTS = 0.003, 14
MAP = np.array([512000.0, 5403000.0, 230.0])


def published(file):
    """K, R = cam_from_world, centre."""
    v = np.array(file.read_text().split(), float)
    return v[:9].reshape(3, 3), v[12:21].reshape(3, 3).T, v[21:24]


def read_model(folder):
    """Keypoints by image name, and points: id -> (position, [(image name, index of keypoint)])."""
    images, lines = {}, [l for l in (folder / "images.txt").read_text().splitlines() if not l.startswith("#")]
    for head, features in zip(lines[::2], lines[1::2]):
        words = head.split(maxsplit=9)
        q = np.array(words[1:5], float)
        images[int(words[0])] = (words[9], np.array(features.split(), float).reshape(-1, 3)[:, :2], q, np.array(words[5:8], float))
    points = {}
    for line in (folder / "points3D.txt").read_text().splitlines():
        if line.startswith("#"):
            continue
        words = line.split()
        points[int(words[0])] = (np.array(words[1:4], float), [(int(i), int(k)) for i, k in zip(words[8::2], words[9::2])])
    return images, points


def intersect(rays):
    """The point with least squares of reprojection, and their root mean square [px]. rays: (K, R, C, pixel)."""
    normal, right = np.zeros((3, 3)), np.zeros(3)
    for K, R, C, pixel in rays:
        d = R.T @ np.linalg.solve(K, [*pixel, 1])
        P = np.eye(3) - np.outer(d, d) / (d @ d)
        normal += P
        right += P @ C
    X = np.linalg.solve(normal, right)
    for _ in range(10):
        J, r = [], []
        for K, R, C, pixel in rays:
            p = R @ (X - C)
            f = np.array([K[0, 0], K[1, 1]])
            r += list(pixel - (f * p[:2] / p[2] + [K[0, 2], K[1, 2]]))
            J += list((f[:, None] * np.array([[1 / p[2], 0, -p[0] / p[2] ** 2], [0, 1 / p[2], -p[1] / p[2] ** 2]])) @ R)
        step = np.linalg.lstsq(np.array(J), np.array(r), rcond=None)[0]
        X = X + step
    return X, float(np.sqrt(np.mean(np.square(r))))


def told(name, errors):
    rms = 1e3 * np.sqrt(np.mean(np.square(errors), 0))
    print(f"{name:<50} {rms[0]:6.1f} {rms[1]:6.1f} {rms[2]:6.1f}   {np.hypot.reduce(rms):6.1f} mm in space")


shutil.rmtree(WORK, ignore_errors=True)
WORK.mkdir(parents=True)
(WORK / "sfm.yaml").write_text(f"plumbline: 1\nnodes:\n  sfm: {{use: colmap.sfm, with: {{photographs: {FOLDER}/images, max_image_size: {SIZE}}}}}\noutputs: {{sparse: sfm.model}}\n")
subprocess.run([PLUMBLINE, "run", WORK / "sfm.yaml", "--out", WORK / "sfm", "-q"], check=True)
images, points = read_model(WORK / "sfm/sparse")
cameras = {name: published(FOLDER / "gt_dense_cameras" / (pathlib.Path(name).name + ".camera")) for name, *_ in images.values()}
found = []
for number, (position, track) in points.items():
    if len({i for i, _ in track}) < 4 or len({i for i, _ in track}) != len(track):
        continue
    # COLMAP counts from the corner of the first pixel, the published cameras from its centre.
    X, rms = intersect([(*cameras[images[i][0]], images[i][1][k] - 0.5) for i, k in track])
    if rms < 0.5:
        found.append((number, X, rms, len(track)))
chosen = [max(range(len(found)), key=lambda k: found[k][3])]
while len(chosen) < POINTS:
    far = [min(np.linalg.norm(f[1] - found[c][1]) for c in chosen) for f in found]
    chosen.append(int(np.argmax(far)))
print(f"{len(images)} photographs, {len(points)} points, {len(found)} seen in four or more and intersected to 0.5 px")
control, check = chosen[::2], chosen[1::2]
with open(WORK / "control.csv", "w") as file:
    file.write("name,x,y,z,sigma,role\n")
    for role, some in (("control", control), ("check", check)):
        for k in some:
            file.write(f"P{found[k][0]},{','.join(f'{v:.6f}' for v in found[k][1] + MAP)},{SIGMA},{role}\n")
with open(WORK / "measured.csv", "w") as file:
    file.write("image,point,x,y\n")
    for k in chosen:
        for i, feature in points[found[k][0]][1]:
            file.write(f"{images[i][0]},P{found[k][0]},{images[i][1][feature][0]:.4f},{images[i][1][feature][1]:.4f}\n")
done = subprocess.run([PLUMBLINE, "run", "colmap_control", f"model={WORK}/sfm/sparse", f"control={WORK}/control.csv", f"observations={WORK}/measured.csv",
                       "block.with.pixel_origin=corner", "--out", WORK / "control", "-q"], capture_output=True, text=True)
print(f"colmap_control: exit code {done.returncode}")
rows = {row["name"] if "name" in row else row["point"]: row for row in csv.DictReader(open(WORK / "control/points.csv"))}
print("withheld points, root mean square                       x      y      z")
names = list(next(iter(rows.values())))
difference = [n for n in names if n.startswith("d") and n[1] in "xyz"][:3]
told("colmap_control", [[float(rows[f"P{found[k][0]}"][n]) * (1e-3 if "mm" in n else 1) for n in difference] for k in check])
truth = {k: found[k][1] for k in chosen}
scale, R, t = similarity(np.array([points[found[k][0]][0] for k in control]), np.array([truth[k] for k in control]))
told("similarity on the same control", [scale * R @ points[found[k][0]][0] + t - truth[k] for k in check])
with open(WORK / "centres.txt", "w") as file:
    for name, (K, rotation, centre) in cameras.items():
        file.write(f"{name} {centre[0]} {centre[1]} {centre[2]}\n")
(WORK / "aligned").mkdir()
quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL, "env": {**os.environ, "QT_QPA_PLATFORM": "offscreen"}}
subprocess.run(["colmap", "model_aligner", "--input_path", WORK / "sfm/sparse", "--output_path", WORK / "aligned", "--ref_images_path", WORK / "centres.txt",
                "--ref_is_gps", "0", "--robust_alignment", "1", "--robust_alignment_max_error", "0.1"], check=True, **quiet)
subprocess.run(["colmap", "model_converter", "--input_path", WORK / "aligned", "--output_path", WORK / "aligned", "--output_type", "TXT"], check=True, **quiet)
_, aligned = read_model(WORK / "aligned")
told("model_aligner on all published centres", [aligned[found[k][0]][0] - truth[k] for k in check])
block = json.load(open(WORK / "control/block.json"))
print("check points:", json.dumps(block.get("check_points", {}))[:400])
