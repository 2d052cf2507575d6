#!/usr/bin/env python3
"""usage: blunders.py PLUMBLINE WORK

One wrong coordinate at a time in what strecha.py left in WORK: each control point and each check point is moved by 50 mm along x, -y and z. A check point must be named and the exit
code be 3; a control point must be named and set aside. Nobody else may be named."""
import csv
import os
import pathlib
import re
import subprocess
import sys
import tempfile

PLUMBLINE, WORK = os.path.abspath(sys.argv[1]), pathlib.Path(sys.argv[2]).resolve()
rows = list(csv.DictReader(open(WORK / "control.csv")))
counts = {"control": [0, 0], "check": [0, 0]}
with tempfile.TemporaryDirectory() as folder:
    for row in rows:
        for axis, by in (("x", 0.05), ("y", -0.05), ("z", 0.05)):
            wrong = [dict(r) for r in rows]
            moved = next(r for r in wrong if r["name"] == row["name"])
            moved[axis] = f"{float(moved[axis]) + by:.6f}"
            with open(f"{folder}/control.csv", "w", newline="") as file:
                writer = csv.DictWriter(file, rows[0].keys())
                writer.writeheader()
                writer.writerows(wrong)
            done = subprocess.run([PLUMBLINE, "run", "colmap_control", f"model={WORK}/sfm/sparse", f"control={folder}/control.csv", f"observations={WORK}/measured.csv",
                                   "block.with.pixel_origin=corner", "--out", f"{folder}/out", "--overwrite", "-q"], capture_output=True, text=True)
            said = done.stdout + done.stderr
            named = set(re.findall(r"\bP\d+\b", said))
            right = named == {row["name"]} and (done.returncode == 3 if row["role"] == "check" else "set aside" in said or "left out" in said)
            counts[row["role"]][0] += right
            counts[row["role"]][1] += 1
            if not right:
                print(row["role"], row["name"], axis, "exit code", done.returncode, "named:", sorted(named), said[:400])
for role, (right, all_of) in counts.items():
    print(f"{role}: {right} of {all_of} as they should be")
