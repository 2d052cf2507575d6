#!/usr/bin/env python3
"""Plants one mistake at a time in sound simulated campaigns and looks whether the program says what it is.

    benchmarks/site_mistakes/site_mistakes.py build/bin/plumbline --campaigns 20 --table table.md

A campaign is made at observation level (corners with noise in place of photographs, readings of a total station), spoilt in
its files as a person would spoil them, and run through pipelines/site_observations.yaml. With --rendered it has photographs,
goes through pipelines/site_campaign.yaml, and the mistakes are those that need them. Verdicts:

    named     the terminal or summary.txt holds the expected words
    alarmed   a warning or an error that the sound campaign does not have, but not the cause
    silent    nothing, and the result is as green as before
    harmless  nothing, and no check anchor is off by more than 3 of its standard deviations from the sound result

Python's standard library only.
"""
import argparse
import csv
import io
import json
import os
import random
import re
import shutil
import struct
import subprocess
import sys
import tempfile
import zlib
from pathlib import Path


class Campaign:
    """The files of a campaign folder, edited as tables."""

    def __init__(self, folder):
        self.folder = Path(folder)

    def text(self, name):
        return (self.folder / name).read_text()

    def write(self, name, text):
        (self.folder / name).write_text(text)

    def replace(self, name, pattern, value, count=0):
        text, done = re.subn(pattern, value, self.text(name), count=count, flags=re.M)
        assert done, f"{name}: nothing matches {pattern}"
        self.write(name, text)

    def rows(self, name):
        return list(csv.DictReader(io.StringIO(self.text(name))))

    def write_rows(self, name, rows):
        out = io.StringIO()
        writer = csv.DictWriter(out, rows[0].keys(), lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)
        self.write(name, out.getvalue())

    def edit(self, name, change):
        rows = self.rows(name)
        rows = change(rows) or rows
        self.write_rows(name, rows)

    def camera(self, **factors):
        for key, factor in factors.items():
            pattern = rf"^(parameters:(?:.|\n)*?\n  {key}: )(\S+)"
            match = re.search(pattern, self.text("camera.yaml"), re.M)
            value = factor(float(match.group(2))) if callable(factor) else factor * float(match.group(2))
            self.replace("camera.yaml", pattern, lambda m, v=value: f"{m.group(1)}{v!r}", 1)


def swap(rows, a, b, keys):
    for key in keys:
        rows[a][key], rows[b][key] = rows[b][key], rows[a][key]


def pick(rows, rng, role, same_row=True):
    """Two plates of a role, in the same row of anchors."""
    while True:
        a, b = rng.sample([i for i, r in enumerate(rows) if r["role"] == role], 2)
        if not same_row or (rows[a]["floor"], rows[a]["row"]) == (rows[b]["floor"], rows[b]["row"]):
            return a, b


IDS = ["tag_id"]


def plates(change):
    return lambda c, rng: c.edit("plates.csv", lambda rows: change(rows, rng))


def for_each(key, function, only=lambda row: True):
    def change(rows, rng):
        for row in rows:
            if only(row):
                row[key] = function(row[key])
    return change


def swap_plates(role_a, role_b=None):
    def change(rows, rng):
        if role_b is None:
            a, b = pick(rows, rng, role_a)
        else:
            a = rng.choice([i for i, r in enumerate(rows) if r["role"] == role_a])
            b = rng.choice([i for i, r in enumerate(rows) if r["role"] == role_b and r["floor"] == rows[a]["floor"]])
        swap(rows, a, b, IDS)
    return change


def swap_floors(rows, rng):
    tags = {(r["floor"], r["column"], r["row"]): r["tag_id"] for r in rows}
    for row in rows:
        other = {"1": "2", "2": "1"}.get(row["floor"], row["floor"])
        row["tag_id"] = tags[(other, row["column"], row["row"])]


def rotate_floor(rows, rng):
    chosen = [r for r in rows if r["floor"] == "2"]
    tags = [r["tag_id"] for r in chosen]
    for row, tag in zip(chosen, tags[1:] + tags[:1]):
        row["tag_id"] = tag


def one_offset(rows, rng):
    row = rng.choice([r for r in rows if r["role"] == "control"])
    row["tag_x_mm"] = str(float(row["tag_x_mm"]) + 40)


def control(change):
    return lambda c, rng: c.edit("control.csv", lambda rows: change(rows, rng))


def swap_control(rows, rng):
    a, b = rng.sample(range(len(rows)), 2)
    swap(rows, a, b, ["east_m", "north_m", "height_m"])


def swap_axes(rows, rng):
    for row in rows:
        row["east_m"], row["north_m"] = row["north_m"], row["east_m"]


def scale_control(factor):
    def change(rows, rng):
        for row in rows:
            for key in ("east_m", "north_m", "height_m"):
                row[key] = f"{factor * float(row[key]):.5f}"
    return change


def shift_control(dx, dy, dz):
    def change(rows, rng):
        for row in rows:
            for key, d in (("east_m", dx), ("north_m", dy), ("height_m", dz)):
                row[key] = f"{float(row[key]) + d:.5f}"
    return change


def one_control_point(rows, rng):
    row = rng.choice(rows)
    row["height_m"] = f"{float(row['height_m']) + 0.05:.5f}"


GSI = "survey/total_station.gsi"


def gsi(change):
    """`change(set_up number, point, line) -> line` over the lines of the survey."""
    def spoil(c, rng):
        lines, set_up, state = c.text(GSI).splitlines(True), -1, {"rng": rng}
        stations = [i for i, line in enumerate(lines) if line.startswith("*41")]
        state["chosen"] = rng.randrange(len(stations))
        for i, line in enumerate(lines):
            if line.startswith("*41"):
                set_up += 1
                lines[i] = change(state, set_up, None, line)
            else:
                point = re.match(r"\*11\d{4}[+-]0*(\S*)", line).group(1)
                lines[i] = change(state, set_up, point, line)
        c.write(GSI, "".join(lines))
    return spoil


def instrument_height(state, set_up, point, line):
    if point is None and set_up == state["chosen"]:
        return re.sub(r"(43\.\.\.\.\+)(\d{16})", lambda m: f"{m.group(1)}{int(m.group(2)) + 1000:016d}", line)
    return line


def swapped_names(state, set_up, point, line):
    if point and set_up == state["chosen"]:
        names = state.setdefault("names", [])
        if point.startswith("F") and point not in names and len(names) < 2:
            names.append(point)
        if len(names) == 2 and point in names:
            other = names[1 - names.index(point)]
            return line.replace(f"{point:0>16}", f"{other:0>16}", 1)
    return line


def in_feet(state, set_up, point, line):
    return re.sub(r"(31\.\.0)8(\+)(\d{16})",
                  lambda m: f"{m.group(1)}8{m.group(2)}{round(int(m.group(3)) / 0.3048):016d}", line)


def prism(state, set_up, point, line):
    return re.sub(r"(31\.\.08\+)(\d{16})", lambda m: f"{m.group(1)}{int(m.group(2)) + 3440:016d}", line)


def renamed(state, set_up, point, line):
    state.setdefault("old", "F02-C02-R1")
    return line.replace("F02-C02-R1", "F02-C02-RI") if point == state["old"] else line


def seen(change):
    return lambda c, rng: c.edit("observations.csv", lambda rows: change(rows, rng))


def corners(row, function):
    for k in range(4):
        row[f"x{k}_px"], row[f"y{k}_px"] = (f"{v:.4f}" for v in function(float(row[f"x{k}_px"]), float(row[f"y{k}_px"])))


def zoomed(rows, rng):
    images = sorted({r["image"] for r in rows})
    late = set(images[len(images) // 2:])
    for row in rows:
        if row["image"] in late:
            corners(row, lambda x, y: (3000 + 0.98 * (x - 3000), 2000 + 0.98 * (y - 2000)))


def halved(rows, rng):
    for row in rows:
        corners(row, lambda x, y: (x / 2, y / 2))


def order_of_corners(shift, mirrored=False):
    def change(rows, rng):
        for row in rows:
            old = [(row[f"x{k}_px"], row[f"y{k}_px"]) for k in range(4)]
            new = [old[(-k if mirrored else k) + shift & 3] for k in range(4)]
            for k in range(4):
                row[f"x{k}_px"], row[f"y{k}_px"] = new[k]
    return change


def twice(rows, rng):
    image = rng.choice(sorted({r["image"] for r in rows}))
    return rows + [dict(r, image=image.replace(".jpg", " (copy).jpg")) for r in rows if r["image"] == image]


def saved_again(rows, rng):
    """The copy of a photograph has other compression: corners move by hundredths of a pixel, a tag is lost."""
    copy = [dict(r) for r in twice(rows, rng)[len(rows):]][:-1]
    for row in copy:
        corners(row, lambda x, y: (x + rng.gauss(0, 0.03), y + rng.gauss(0, 0.03)))
    return rows + copy


def one_check_offset(rows, rng):
    row = rng.choice([r for r in rows if r["role"] == "check"])
    row["tag_x_mm"] = f"{float(row['tag_x_mm']) + 40:g}"


def exchange_floor_numbers(rows, rng):
    for row in rows:
        row["floor"] = {"1": "2", "2": "1"}.get(row["floor"], row["floor"])


def strange_tags(rows, rng):
    extra = [dict(r, tag_id=str(400 + int(r["tag_id"]))) for r in rows[:3]]
    for row in extra:
        corners(row, lambda x, y: (6000 - x, 4000 - y))
    return rows + extra


def focal(factor):
    return lambda c, rng: c.camera(fx=factor, fy=factor)


def without_sigmas(c):
    c.write("camera.yaml", c.text("camera.yaml").split("sigmas:")[0])


def both(*changes):
    def change(c, rng):
        for one in changes:
            one(c, rng)
    return change


# name, what spoils, the words that name it (any of them)
CALIBRATION = r"calibration|focal length"
MISTAKES = [
    ("focal length +1 %", focal(1.01), CALIBRATION),
    ("focal length +3 %", focal(1.03), CALIBRATION),
    ("focal length +5 %", focal(1.05), CALIBRATION),
    ("focal length +3 %, no sigmas", both(focal(1.03), lambda c, rng: without_sigmas(c)), CALIBRATION + "|camera model"),
    ("focal length in mm", lambda c, rng: c.camera(fx=3.9e-3, fy=3.9e-3), CALIBRATION + "|pixels"),
    ("cx and cy swapped", lambda c, rng: c.camera(cx=lambda v: 1988.6, cy=lambda v: 3017.1), CALIBRATION + "|principal point"),
    ("no distortion", lambda c, rng: c.camera(k1=0, k2=0, p1=0, p2=0), CALIBRATION + "|distortion"),
    ("sign of k1", lambda c, rng: c.camera(k1=-1), CALIBRATION + "|distortion"),
    ("zoom moved half way", seen(zoomed), CALIBRATION + "|zoom|camera model|camera was"),
    ("photographs at half size", seen(halved), CALIBRATION + "|scaled|half|size"),
    ("tags printed at 98 %", plates(for_each("tag_size_mm", lambda v: f"{float(v) / 0.98:.4f}")), r"tags? .*(printed|measure|size|scale)"),
    ("one floor printed at 98 %", plates(for_each("tag_size_mm", lambda v: f"{float(v) / 0.98:.4f}", lambda r: r["floor"] == "2")), r"tags? .*(printed|measure|size|scale)"),
    ("tag size ten times", plates(for_each("tag_size_mm", lambda v: f"{10 * float(v):g}")), r"tag.{0,4} (of|are|is|measure|size).*(size|m)|tag size"),
    ("tag size in metres", plates(for_each("tag_size_mm", lambda v: f"{float(v) / 1000:g}")), r"tag.{0,40}(size|mm)"),
    ("plate offsets in cm", plates(for_each("tag_y_mm", lambda v: f"{float(v) / 10:g}")), r"offset of the tag .* on all plates"),
    ("one plate's offset wrong by 40 mm", plates(one_offset), r"most at F.*offset of the tag|F\d\d-C\d\d-R\d: its tag contradicts|F\d\d-C\d\d-R\d, which contradicts .*offset of its tag"),
    ("a check plate's offset wrong by 40 mm", plates(one_check_offset), r"agree with the survey in height and not in place: F"),
    ("floor numbers exchanged", plates(exchange_floor_numbers), r"Floor 2 lies below floor 1"),
    ("two check plates swapped", plates(swap_plates("check")), r"exchanged|each other's place|hangs where"),
    ("two control plates swapped", plates(swap_plates("control")), r"exchanged|each other's place|hangs where"),
    ("control and check plate swapped", plates(swap_plates("control", "check")), r"exchanged|each other's place|hangs where"),
    ("two floors swapped", plates(swap_floors), r"floors 1 and 2 are exchanged"),
    ("ids of a floor moved by one", plates(rotate_floor), r"ids of floor 2 are moved|hangs where"),
    ("all ids + 1", plates(for_each("tag_id", lambda v: str(int(v) + 1))), r"ids of the plate table are moved"),
    ("wrong tag family", plates(for_each("tag_family", lambda v: "tag25h9")), r"family"),
    ("family written 36h11", plates(for_each("tag_family", lambda v: "36h11")), r"family"),
    ("corners from another start", seen(order_of_corners(1)), r"corner|upright|order|turned"),
    ("corners the other way round", seen(order_of_corners(3, True)), r"corner|mirrored|order"),
    ("a photograph twice", seen(twice), r"same photograph|twice|copy|identical"),
    ("a photograph saved again", seen(saved_again), r"saved twice"),
    ("tags that plates.csv lacks", seen(strange_tags), r"in no row of the plate table"),
    ("control points swapped", control(swap_control), r"swap|G\d"),
    ("control E and N swapped", control(swap_axes), r"exchanged"),
    ("control in feet", control(scale_control(1 / 0.3048)), r"feet|foot"),
    ("control in millimetres", control(scale_control(1000)), r"millimet|1000|unit"),
    ("control in map coordinates", control(shift_control(691000, 5335000, 520)), r"km from the design|frame"),
    ("one control point 5 cm high", control(one_control_point), r"G\d"),
    ("instrument height +0.1 m", gsi(instrument_height), r"instrument height|height of the instrument|set-up S\d|S\d\d-\d"),
    ("two points swapped in a set-up", gsi(swapped_names), r"swapped|F0\d-"),
    ("distances in feet", gsi(in_feet), r"feet|foot|scale"),
    ("prism constant 34.4 mm", gsi(prism), r"prism"),
    ("a point's name mistyped", gsi(renamed), r"F02-C02-RI"),
    ("unknown instrument", lambda c, rng: c.replace("campaign.yaml", r"^instrument: .*", "instrument: leica_ts99"), r"leica_ts99"),
    ("anchor names with #", plates(for_each("anchor", lambda v: "#" + v)), r"#"),
    ("design of another building", lambda c, rng: c.replace("design.ifc", r"'F0", "'G0"), r"no element|not in the design|match"),
]


def photographs(c):
    return sorted((c.folder / "images").iterdir())


def copied(c, rng):
    first = rng.choice(photographs(c))
    shutil.copy(first, first.with_name("copy_of_" + first.name))


def truncated(c, rng):
    path = rng.choice(photographs(c))
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])


def turned_by_exif(c, rng):
    """As after turning it in a file browser: the pixels stay, the EXIF header says orientation 6."""
    path = rng.choice(photographs(c))
    tiff = b"II*\0\x08\0\0\0" + struct.pack("<HHHIHHI", 1, 0x112, 3, 1, 6, 0, 0)
    body = b"Exif\0\0" + tiff
    path.write_bytes(b"\xff\xd8\xff\xe1" + struct.pack(">H", len(body) + 2) + body + path.read_bytes()[2:])


def foreign_photograph(c, rng):
    """A picture of another camera among the photographs (a PNG under the name of a JPEG)."""
    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    width, height = 1200, 900
    rows = b"".join(b"\0" + bytes([128]) * width for _ in range(height))
    header = struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0)
    (c.folder / "images" / "phone.jpg").write_bytes(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) +
                                                    chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b""))


# name, what the simulator renders differently, what spoils the files, the words that name it
RENDERED = [
    ("dense mist", {"haze": 0.93}, None, r"contrast"),
    ("wrong tag family", {}, plates(for_each("tag_family", lambda v: "tag25h9")), r"family"),
    ("focal length +3 %", {}, focal(1.03), CALIBRATION),
    ("tags printed at 98 %", {}, plates(for_each("tag_size_mm", lambda v: f"{float(v) / 0.98:.4f}")), r"tags? .*(printed|measure|size|scale)"),
    ("ids moved by one", {}, plates(for_each("tag_id", lambda v: str(int(v) + 1))), r"ids of the plate table are moved"),
    ("two control plates swapped", {}, plates(swap_plates("control")), r"exchanged|each other's place|hangs where"),
    ("a photograph twice", {}, copied, r"same photograph|twice|copy|identical"),
    ("a photograph cut short", {}, truncated, r"truncated|cut|ends|damaged|corrupt|incomplete"),
    ("a photograph turned by EXIF", {}, turned_by_exif, r"orientation|turned|rotated|EXIF"),
    ("a photograph of another camera", {}, foreign_photograph, r"1200"),
]


def run(program, pipeline, folder, out, store):
    done = subprocess.run([program, "run", pipeline, f"folder={folder}", "--out", str(out), "--store", str(store)],
                          capture_output=True, text=True, timeout=300)
    text = done.stdout + done.stderr
    summary = out / "summary.txt"
    if summary.exists():
        text += summary.read_text()
    return done.returncode, text.replace(str(folder), "FOLDER").replace(str(out), "OUT")


def alarms(text):
    found = []
    for line in text.splitlines():
        if "warning:" in line or "error" in line.lower() or "failed:" in line or "not to be trusted" in line.lower():
            found.append(re.sub(r"^.*?(warning|failed|node)", r"\1", line))
    return found


def positions(out):
    path = out / "metrics.csv"
    if not path.exists():
        return {}
    with open(path, newline="") as file:
        return {r["anchor"]: [float(r[k] or "nan") for k in ("x_m", "y_m", "z_m")] for r in csv.DictReader(file)}


def moved(sound, spoilt):
    worst = 0.0
    for anchor, p in sound.items():
        q = spoilt.get(anchor)
        if q:
            worst = max([worst] + [abs(a - b) for a, b in zip(p, q) if a == a and b == b])
    return worst


def make(program, work, store, seed, options, changes):
    """The campaign folder of a seed."""
    values = {"floors": options.floors} | ({"camera": "quick_6mp", "images_per_floor": 6} if options.rendered else
                                           {"photographs": "observed"}) | changes
    pipeline = work / "make.yaml"
    pipeline.write_text("plumbline: 1\nvars: {seed: 1}\nnodes:\n  site: {use: simulate.campaign, with: {" +
                        ", ".join(f"{k}: {v}" for k, v in values.items()) + "}}\noutputs: {campaign: site.folder}\n")
    out = work / f"campaign-{seed}"
    shutil.rmtree(out, ignore_errors=True)
    subprocess.run([program, "run", str(pipeline), f"seed={seed}", "--out", str(out), "--store", str(store)], check=True,
                   capture_output=True)
    return out / "campaign"


def verdict_of(named, new, code, effect):
    return "named" if named else "alarmed" if new or code != 0 else "harmless" if effect < 0.001 else "silent"


def one(work, seed, options, kinds):
    program, store = os.path.abspath(options.program), work / "store"
    pipeline = "site_campaign" if options.rendered else "site_observations"
    base = work / "sound"
    shutil.rmtree(base, ignore_errors=True)
    shutil.copytree(make(program, work, store, seed, options, {}), base)
    code, sound_text = run(program, pipeline, base, work / f"sound-{seed}", store)
    sound_alarms, sound = set(alarms(sound_text)), positions(work / f"sound-{seed}")
    results = [("sound", "sound" if code == 0 and not sound_alarms else "false alarm", code, sorted(sound_alarms), 0.0)]
    for name, changes, spoil, words in kinds:
        folder, out = work / "spoilt", work / "out"
        for path in (folder, out):
            shutil.rmtree(path, ignore_errors=True)
        shutil.copytree(make(program, work, store, seed, options, changes) if changes else base, folder)
        if spoil:
            spoil(Campaign(folder), random.Random(seed))
        code, text = run(program, pipeline, folder, out, store)
        new = [a for a in alarms(text) if a not in sound_alarms]
        effect = moved(sound, positions(out))
        verdict = verdict_of(re.search(words, "\n".join(new), re.I) is not None, new, code, effect)
        results.append((name, verdict, code, new, effect))
        if options.show:
            print(f"{name:36} {verdict:9} exit {code}  moved {1000 * effect:8.2f} mm")
            for line in new[: 4 if verdict == "named" else 8]:
                print("      " + line[:400])
    return results


def table(counts, campaigns):
    columns = ["named", "alarmed", "harmless", "silent"]
    lines = ["| mistake | " + " | ".join(columns) + " |", "|---|" + "---|" * len(columns)]
    for name, found in counts.items():
        if name != "sound":
            lines.append(f"| {name} | " + " | ".join(str(found.get(c, "")) for c in columns) + " |")
    total = {c: sum(f.get(c, 0) for n, f in counts.items() if n != "sound") for c in columns}
    lines.append("| all | " + " | ".join(str(total[c]) for c in columns) + " |")
    lines.append("")
    lines.append(f"Sound campaigns with a warning: {counts['sound'].get('false alarm', 0)} of {campaigns}.")
    return "\n".join(lines) + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("--campaigns", type=int, default=1)
    parser.add_argument("--first-seed", type=int, default=1)
    parser.add_argument("--floors", type=int, default=3)
    parser.add_argument("--rendered", action="store_true", help="mistakes that need photographs, on rendered ones")
    parser.add_argument("--only", default="", help="regular expression over the names of mistakes")
    parser.add_argument("--part", default="0/1", help="K/N: the K-th of N parts of the mistakes")
    parser.add_argument("--table", help="file for the table in Markdown")
    parser.add_argument("--show", action="store_true", help="print what the program said")
    parser.add_argument("--require", action="store_true", help="exit code 1 unless every mistake is named or harmless")
    options = parser.parse_args()
    part, parts = map(int, options.part.split("/"))
    kinds = RENDERED if options.rendered else [(name, {}, spoil, words) for name, spoil, words in MISTAKES]
    kinds = [k for k in kinds if re.search(options.only, k[0])][part::parts]
    counts = {}
    bad = 0
    with tempfile.TemporaryDirectory(prefix="site_mistakes.") as work:
        for seed in range(options.first_seed, options.first_seed + options.campaigns):
            for name, verdict, code, new, effect in one(Path(work), seed, options, kinds):
                counts.setdefault(name, {}).setdefault(verdict, 0)
                counts[name][verdict] += 1
                bad += verdict in ("silent", "alarmed")
                if verdict in ("silent", "false alarm", "alarmed"):
                    print(f"seed {seed}: {name}: {verdict}\n      " + "\n      ".join(new[:6]), flush=True)
            if options.table:  # after each campaign: a long run that is ended keeps what it found
                Path(options.table).write_text(table(counts, seed - options.first_seed + 1))
    print(table(counts, options.campaigns), end="")
    return 1 if options.require and bad else 0


if __name__ == "__main__":
    sys.exit(main())
