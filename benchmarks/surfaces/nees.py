#!/usr/bin/env python3
"""Errors of every quantity over what is stated of it, on simulated facades of many seeds.

    nees.py PLUMBLINE [SEEDS] [VARIABLE=VALUE ...]

runs the pipeline facade_surfaces for seeds 1 to SEEDS (default 20) and prints, for each quantity, the rms error, and the
squared error over the stated variance: its mean over seeds. The band is that of as many degrees of freedom as there are
seeds, because panels of one seed share their orientations' errors; of what they do not share it is too wide. Flatness is here only; everything else with the
joint covariance of all panels is what evaluate.surfaces says (surface_errors.csv, depth_kinds.yaml).
"""
import csv
import json
import math
import pathlib
import statistics
import subprocess
import sys
import tempfile

plumbline = sys.argv[1]
seeds = int(sys.argv[2]) if len(sys.argv) > 2 else 20
overrides = sys.argv[3:]
ORIGIN, AZIMUTH = (105.25, 212.5, 31.75), 3.6  # of the facade that simulate.facade builds


def band(freedom):
    """95 % of chi-square over its degrees of freedom (Wilson and Hilferty 1931)."""
    part = 2 / (9 * freedom)
    return [(1 - part + z * math.sqrt(part)) ** 3 for z in (-1.96, 1.96)]



def height(panel, x, y):
    """Height of a panel as built at a place from its middle as built, in m."""
    a, b = 2 * x / float(panel["width_m"]), 2 * y / float(panel["height_m"])
    mm = (float(panel["offset_mm"]) + float(panel["tilt_right_mm_per_m"]) * x + float(panel["tilt_up_mm_per_m"]) * y
          + float(panel["bow_across_mm"]) * (1 / 3 - a * a) + float(panel["bow_up_mm"]) * (1 / 3 - b * b))
    return mm / 1000


def largest_gap(panel, length, cell=0.05, border=0.02):
    """Under a straightedge on the panel as built, laid like surface.panels lays it: over means of cells, four ways."""
    across, up = float(panel["width_m"]) - 2 * border, float(panel["height_m"]) - 2 * border
    columns, rows = int(across / cell), int(up / cell)
    at = lambda c, r: height(panel, ((c + 0.5) / columns - 0.5) * across, ((r + 0.5) / rows - 0.5) * up)
    worst = math.nan
    for dc, dr in ((1, 0), (0, 1), (1, 1), (1, -1)):
        step = math.hypot(dc * across / columns, dr * up / rows)
        count = int(length / step + 1e-9) + 1
        for c in range(columns):
            for r in range(rows):
                if not (0 <= c + dc * (count - 1) < columns and 0 <= r + dr * (count - 1) < rows):
                    continue
                line = [at(c + dc * i, r + dr * i) for i in range(count)]
                for i in range(1, count - 1):  # the chord over a place is at least that of the ends and of any pair
                    chord = max(line[j] + (line[k] - line[j]) * (i - j) / (k - j) for j in range(i) for k in range(i + 1, count))
                    worst = max(0.0 if math.isnan(worst) else worst, chord - line[i])
    return worst


def errors_of(folder, store):
    """(quantity, error, sigma) of one run."""
    show = subprocess.run([plumbline, "show", f"{folder}/run.jsonl:joints.surfaces", "--store", store],
                          capture_output=True, text=True, check=True).stdout
    surfaces = json.loads(show)
    truth = {row["panel"]: row for row in csv.DictReader(open(folder / "truth.csv"))}
    found = []
    for panel in surfaces["panels"]:
        if panel.get("not_measured"):
            continue
        built, c = truth[panel["face"]["id"]], panel["covariance"]
        for name, value, true, variance in (
                ("offset [mm]", panel["offset"], built["offset_mm"], c[0]),
                ("tilt right [mm/m]", panel["tilt"][0], built["tilt_right_mm_per_m"], c[2]),
                ("tilt up [mm/m]", panel["tilt"][1], built["tilt_up_mm_per_m"], c[5]),
                ("bow across [mm]", panel["form"][0], built["bow_across_mm"], panel["form_sigma"][0] ** 2),
                ("bow up [mm]", panel["form"][1], built["bow_up_mm"], panel["form_sigma"][1] ** 2),
                ("twist [mm]", panel["form"][2], 0, panel["form_sigma"][2] ** 2)):
            found.append((name, 1000 * value - float(true), 1000 * math.sqrt(variance)))
        for gap in panel["flatness"]:
            true = largest_gap(built, gap["length"])
            if not math.isnan(true) and gap["positions"] > 0:
                gaps.append((gap["length"], 1000 * (gap["gap"] - true), 1000 * gap["noise_mean"], 1000 * gap["noise_sigma"]))
    for joint in surfaces["joints"]:
        a, b = truth[joint["first"]], truth[joint["second"]]
        across, along, size = ("u_m", "v_m", "width_m") if joint["upright"] else ("v_m", "u_m", "height_m")
        edges = [float(a[across]) + float(a[size]) / 2, float(b[across]) - float(b[size]) / 2]
        middle = None
        for place in joint["places"]:
            found.append(("joint width [mm]", 1000 * (place["width"] - edges[1] + edges[0]), 1000 * place["width_sigma"]))
            if place.get("step") is None or not math.isfinite(place["step"]):
                continue
            axis = (0, 0, 1) if joint["upright"] else (-math.cos(AZIMUTH), math.sin(AZIMUTH), 0)
            on_facade = sum((o + place["along"] * w - t) * a for o, w, t, a in zip(joint["origin"], joint["along"], ORIGIN, axis))
            heights = []
            for panel, edge in ((a, edges[0]), (b, edges[1])):
                aside, ahead = edge - float(panel[across]), on_facade - float(panel[along])
                heights.append(height(panel, aside, ahead) if joint["upright"] else height(panel, ahead, aside))
            found.append(("step [mm]", 1000 * (place["step"] - heights[1] + heights[0]), 1000 * place["step_sigma"]))
    return found


by_quantity, gaps = {}, []
for seed in range(1, seeds + 1):
    with tempfile.TemporaryDirectory() as folder:
        out, store = pathlib.Path(folder) / "out", f"{folder}/store"
        run = subprocess.run([plumbline, "run", "facade_surfaces", f"seed={seed}", "--out", str(out), "--store", store, "-q",
                              *overrides], capture_output=True, text=True)
        if run.returncode not in (0, 3):
            sys.exit(run.stderr)
        of_seed = {}
        for name, error, sigma in errors_of(out, store):
            of_seed.setdefault(name, []).append((error, sigma))
        for name, pairs in of_seed.items():
            by_quantity.setdefault(name, []).append(pairs)

print(f"{'quantity':20} {'values':>6} {'rms error':>10} {'rms sigma':>10} {'NEES':>6} {'95 % band':>12} {'in it':>6} {'beyond 3 sigma':>14}")
for name, of_seeds in by_quantity.items():
    pairs = [pair for pairs in of_seeds for pair in pairs]
    nees = [statistics.mean((e / s) ** 2 for e, s in pairs) for pairs in of_seeds]
    rms, stated = (math.sqrt(statistics.mean(pair[i] ** 2 for pair in pairs)) for i in (0, 1))
    low, high = band(len(nees))
    mean = statistics.mean(nees)
    far = sum(abs(e) > 3 * s for e, s in pairs) / len(pairs)
    print(f"{name:20} {len(pairs):6} {rms:10.3f} {stated:10.3f} {mean:6.2f} {low:5.2f} {high:6.2f} {'yes' if low <= mean <= high else 'NO':>6} {100 * far:13.1f}%")
for length in sorted({gap[0] for gap in gaps}):
    here = [gap for gap in gaps if gap[0] == length]
    inside = sum(-2 * s <= e <= m + 2 * s for _, e, m, s in here)
    print(f"flatness {length} m: {len(here)} values, gap over the true one {statistics.mean(g[1] for g in here):+.3f} mm in the mean, "
          f"of noise {statistics.mean(g[2] for g in here):.3f} mm; {100 * inside / len(here):.0f} % within -2 sigma and noise + 2 sigma")
