#!/usr/bin/env python3
"""How often does an anchor pass that is truly out of tolerance? Campaigns through the whole program against the truth.

    benchmarks/accuracy/false_passes.py build/bin/plumbline --campaigns 1000 --table table.md

Every campaign is false_passes.yaml with a seed of its own: readings of a total station, corners of tags with noise, the
adjustments, the verdicts by conformance probability; the true positions are the simulator's. A risk of 5 % promises that
of anchors just out of tolerance at most 5 % pass, and fewer of those further out. The interval of a share comes from the
scatter between campaigns, because anchors of one campaign share its datum. Python's standard library only.
"""
import argparse
import csv
import math
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

AXES = ("horizontal", "vertical", "in_plane", "out_of_plane", "space", "all axes")


def true_lengths(row):
    """The facade of the simulator lies in x and z."""
    dx, dy, dz = (float(row[f"{c}_m"]) - float(row[f"design_{c}_m"]) for c in "xyz")
    lengths = {"horizontal": math.hypot(dx, dy), "vertical": abs(dz), "in_plane": math.hypot(dx, dz),
               "out_of_plane": abs(dy), "space": math.sqrt(dx * dx + dy * dy + dz * dz)}
    lengths["all axes"] = max(lengths.values())
    return lengths


def share(pairs):
    """Sum of hits over sum of cases of campaigns, and half the width of its 95 % interval (ratio estimator)."""
    cases, hits = sum(n for n, _ in pairs), sum(h for _, h in pairs)
    if cases == 0:
        return cases, hits, math.nan, math.nan
    rate = hits / cases
    scatter = sum((h - rate * n) ** 2 for n, h in pairs)
    return cases, hits, rate, 1.96 * math.sqrt(scatter) / cases


def one_campaign(program, pipeline, seed, folder, tolerance):
    """By axis: (truly out, of these passed, just out, of these passed, passed, of these out, undecided, all)."""
    out = folder / "out"
    shutil.rmtree(out, ignore_errors=True)
    run = subprocess.run([program, "run", str(pipeline), f"seed={seed}", f"tolerance={1000 * tolerance:g}mm", "--out", str(out),
                          "--store", str(folder / "store")], capture_output=True, text=True)
    if run.returncode not in (0, 3):  # 3: a survey that fails a test by chance; nothing is decided then
        sys.exit(f"seed {seed}: {run.stderr}")
    with open(out / "truth" / "anchors.csv", newline="") as file:
        truth = {row["anchor"]: true_lengths(row) for row in csv.DictReader(file)}
    counts = {axis: [0] * 8 for axis in AXES}
    with open(out / "metrics.csv", newline="") as file:
        for row in csv.DictReader(file):
            for axis in AXES:
                verdict = row["design_verdict" if axis == "all axes" else f"design_{axis}_verdict"]
                length, c = truth[row["anchor"]][axis], counts[axis]
                out_of, passed = length > tolerance, verdict == "pass"
                just = out_of and length < 1.1 * tolerance
                for k, hit in enumerate((out_of, out_of and passed, just, just and passed, passed, passed and out_of,
                                         verdict == "undecided", True)):
                    c[k] += hit
    shutil.rmtree(folder / "store", ignore_errors=True)
    return counts


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("program")
    parser.add_argument("--campaigns", type=int, default=1000)
    parser.add_argument("--first-seed", type=int, default=1)
    parser.add_argument("--tolerance", type=float, default=0.005, help="of every axis [m]")
    parser.add_argument("--pipeline", default=str(Path(__file__).with_suffix(".yaml")))
    parser.add_argument("--table", help="file for the table; else it is printed")
    arguments = parser.parse_args()
    all_counts = []
    with tempfile.TemporaryDirectory(prefix="false_passes.") as folder:
        for k in range(arguments.campaigns):
            all_counts.append(one_campaign(arguments.program, arguments.pipeline, arguments.first_seed + k, Path(folder),
                                           arguments.tolerance))
    lines = ["| axis | truly out | of these pass | up to 10 % out | of these pass | pass | of these truly out | undecided |",
             "|---|---|---|---|---|---|---|---|"]
    for axis in AXES:
        def of(cases, hits):
            n, h, rate, half = share([(c[axis][cases], c[axis][hits]) for c in all_counts])
            return n, f"{h} ({100 * rate:.2f} ± {100 * half:.2f} %)"
        (out_of, false), (near, near_false), (passed, wrong) = of(0, 1), of(2, 3), of(4, 5)
        _, undecided = of(7, 6)
        lines.append(f"| {axis} | {out_of} | {false} | {near} | {near_false} | {passed} | {wrong} | {undecided} |")
    text = "\n".join(lines) + "\n"
    if arguments.table:
        Path(arguments.table).write_text(text)
    else:
        print(text, end="")


main()
