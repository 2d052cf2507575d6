#!/usr/bin/env python3
"""usage: stpierre.py PLUMBLINE FOLDER WORK

The facade of St-Pierre from a drone (28 images, 2003 points): FOLDER is data/hamburg2017/stpierre of niclasborlin/dbat, with pmexports/C5_reduced-pmexport.txt
and ctrl_StPierre_weighted.txt. Of its control five points are measured in the images and are what the list says they are. Each in turn is withheld, the other four are control:
`image_block` with the camera estimated; a similarity of the block adjusted without control; COLMAP's model_aligner of that block on all published centres, which
know the withheld point, because PhotoModeler adjusted them with it. The photographs are not public."""
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
MEASURED = ["1", "44", "191", "232", "251"]
FREE = "block.with.free=[c, xp, yp, K1, K2, P1, P2]"


def adjust(name, control):
    out = WORK / name
    done = subprocess.run([PLUMBLINE, "run", "image_block", f"folder={WORK}/block", *([f"control={control}"] if control else []), "files.with.image_size=[7152,5368]", FREE,
                           "--out", out, "--overwrite", "-q"], capture_output=True, text=True)
    if not (out / "block.json").exists():
        sys.exit(done.stderr)
    return json.load(open(out / "block.json")), done


def points_of(block):
    return {p["id"]: np.array(p["position"]) for p in block["targets"]["points"]}


shutil.rmtree(WORK, ignore_errors=True)
(WORK / "block").mkdir(parents=True)
shutil.copy(FOLDER / "pmexports/C5_reduced-pmexport.txt", WORK / "block")
given = {}
for line in (FOLDER / "ctrl_StPierre_weighted.txt").read_text().splitlines():
    words = [w.strip() for w in line.split(",")]
    if words[0] in MEASURED:
        given[words[0]] = (np.array(words[2:5], float), float(words[5]))
free, _ = adjust("free", None)
model, centres = points_of(free), {i["id"]: np.array(i["centre"]) for i in free["targets"]["images"]}
# What PhotoModeler has: image lines are "N centre angles" behind the line with the photograph's name.
published, lines = {}, (FOLDER / "pmexports/C5_reduced-pmexport.txt").read_text().splitlines()
for k, line in enumerate(lines):
    if line.strip().lower().endswith(".jpg"):
        words = lines[k + 1].split()
        published[int(words[0])] = np.array(words[1:4], float)
start = WORK / "start"
start.mkdir(), (WORK / "aligned").mkdir()
(start / "cameras.txt").write_text("1 PINHOLE 7152 5368 5600 5600 3576 2684\n")
with open(start / "images.txt", "w") as file, open(WORK / "centres.txt", "w") as wanted:
    for i, c in centres.items():
        file.write(f"{i + 1} 1 0 0 0 {-c[0]} {-c[1]} {-c[2]} 1 {i}.jpg\n\n")
        if i in published:
            wanted.write(f"{i}.jpg {published[i][0]} {published[i][1]} {published[i][2]}\n")
with open(start / "points3D.txt", "w") as file:
    for n, name in enumerate(MEASURED):
        file.write(f"{n + 1} {' '.join(map(str, model[name]))} 0 0 0 1\n")
quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL, "env": {**os.environ, "QT_QPA_PLATFORM": "offscreen"}}
subprocess.run(["colmap", "model_aligner", "--input_path", start, "--output_path", WORK / "aligned", "--ref_images_path", WORK / "centres.txt", "--ref_is_gps", "0",
                "--robust_alignment", "1", "--robust_alignment_max_error", "0.1"], check=True, **quiet)
subprocess.run(["colmap", "model_converter", "--input_path", WORK / "aligned", "--output_path", WORK / "aligned", "--output_type", "TXT"], check=True, **quiet)
aligned = {MEASURED[int(w[0]) - 1]: np.array(w[1:4], float) for w in (l.split() for l in (WORK / "aligned/points3D.txt").read_text().splitlines() if not l.startswith("#"))}
errors = {"image_block": [], "similarity": [], "model_aligner": []}
for name in MEASURED:
    with open(WORK / "control.csv", "w") as file:
        file.write("name,x,y,z,sigma,role\n")
        for other, (place, sigma) in given.items():
            file.write(f"{other},{place[0]},{place[1]},{place[2]},{sigma},{'check' if other == name else 'control'}\n")
    block, done = adjust("control", WORK / "control.csv")
    at = given[name][0]
    rest = [o for o in MEASURED if o != name]
    scale, R, t = similarity(np.array([model[o] for o in rest]), np.array([given[o][0] for o in rest]))
    errors["image_block"].append(points_of(block)[name] - at)
    errors["similarity"].append(scale * R @ model[name] + t - at)
    errors["model_aligner"].append(aligned[name] - at)
    check = next(c for c in block["targets"]["control"] if c["id"] == name)
    print(name, "exit code", done.returncode, "w", [None if v is None else round(v, 1) for v in check["w"]],
          *(f"{k} {1e3 * np.linalg.norm(v[-1]):.1f} mm" for k, v in errors.items()), flush=True)
for kind, found in errors.items():
    rms = 1e3 * np.sqrt(np.mean(np.square(found), 0))
    print(f"{kind:<14} {rms[0]:6.1f} {rms[1]:6.1f} {rms[2]:6.1f}   {np.hypot.reduce(rms):6.1f} mm in space")
