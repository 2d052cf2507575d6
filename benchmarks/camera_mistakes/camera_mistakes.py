#!/usr/bin/env python3
"""Makes one mistake with a camera at a time in public photographs and looks whether the program says what it is.

    benchmarks/camera_mistakes/camera_mistakes.py build/bin/plumbline SETS.json --table table.md

SETS.json lists sets: {"name", "folder", "pattern", and either "board" (a board file: calibrate_camera) or "family", "tag_size",
"detector" (marker_board)}. Every photograph is spoilt in its pixels as a zoom, a program or a person would spoil it, saved, and
the pipeline is run as a user runs it. Verdicts:

    named     the terminal holds the words that are listed with the mistake
    told      a warning that the sound set does not have, or an error, but not the cause
    harmless  no new word (but of a bend of the board), and the principal distance within 3 of its stated standard deviations of the sound set's
    silent    no new word, and it is not

Needs Debian's python3-opencv.
"""
import argparse
import json
import re
import shutil
import subprocess
import tempfile
from pathlib import Path

import cv2
import numpy as np

QUALITY = [cv2.IMWRITE_JPEG_QUALITY, 95]


def warp(image, matrix):
    height, width = image.shape[:2]
    return cv2.warpAffine(image, np.float64(matrix)[:2], (width, height), flags=cv2.INTER_CUBIC,
                          borderMode=cv2.BORDER_REPLICATE)


def zoom(factor):
    def spoil(image, c):
        height, width = image.shape[:2]
        f = factor(c["k"], c["n"])
        return warp(image, [[f, 0, (1 - f) * width / 2], [0, f, (1 - f) * height / 2]])
    return spoil


def late(value, other=1.0):
    return lambda k, n: value if 2 * k >= n else other


def undistorted(image, c):
    if 2 * c["k"] < c["n"]:
        return image
    return cv2.undistort(image, c["matrix"], c["distortion"])


def cropped(image, c):
    """A program cut a tenth off at the left and the top and brought it back to the old size."""
    if 2 * c["k"] < c["n"]:
        return image
    height, width = image.shape[:2]
    return cv2.resize(image[height // 10:, width // 10:], (width, height), interpolation=cv2.INTER_CUBIC)


def stretched(image, c):
    width = image.shape[1]
    return image if 2 * c["k"] < c["n"] else warp(image, [[1.03, 0, -0.015 * width], [0, 1, 0]])


def another(image, c):
    if c["random"][c["k"]] >= 0.25:
        return image
    height, width = image.shape[:2]
    return warp(image, [[1.25, 0, -0.125 * width + 9], [0, 1.25, -0.125 * height - 6]])


def wandering(image, c):
    x, y = 8 / 1280 * image.shape[1] * c["normal"][c["k"]]
    return warp(image, [[1, 0, x], [0, 1, y]])


def rolling(image, c):
    height, width = image.shape[:2]
    x, y = 6 / 1280 * width * c["normal"][c["k"]]
    return warp(image, [[1, x / height, -x / 2], [0, 1 + y / height, -y / 2]])


def flipped(when):
    return lambda image, c: cv2.flip(image, 1) if when(c["k"]) else image


def halved(image, c):
    return image if c["k"] % 2 else cv2.resize(image, None, fx=0.5, fy=0.5, interpolation=cv2.INTER_AREA)


def blurred(image, c):
    if c["k"] % 3:
        return image
    kernel = np.zeros((15, 15))
    kernel[7] = 1 / 15
    return cv2.filter2D(image, -1, kernel)


def recompressed(image, c):
    return cv2.imdecode(cv2.imencode(".jpg", image, [cv2.IMWRITE_JPEG_QUALITY, 20])[1], cv2.IMREAD_COLOR)


def changed(*what):
    """The camera is told to be another in one of these, alone or among the few that the photographs leave possible."""
    return "|".join(rf"camera is another \([^)]*{w}|do not tell \([^)]*{w}" for w in what)


# Only sentences that say what was done count. "The photographs do not tell whether focus or zoom changed" and "photographs
# from one side tell another camera" have the same words and say something else.
FOCUS = r": focus or zoom|principal distance that differs|" + changed("principal distance")
# name, what happens to the pixels, words that name it, changes of the set (board, family, size, copies)
MISTAKES = [
    ("10 % longer from the middle on", zoom(late(1.10)), FOCUS, {}),
    ("5 % longer from the middle on", zoom(late(1.05)), FOCUS, {}),
    ("2 % longer from the middle on", zoom(late(1.02)), FOCUS, {}),
    ("drift by 2 % either way", zoom(lambda k, n: 0.98 + 0.04 * k / (n - 1)), FOCUS, {}),
    ("every second 5 % longer", zoom(lambda k, n: 1.05 if k % 2 else 1), FOCUS, {}),
    ("every fourth 2 % longer", zoom(lambda k, n: 1 if k % 4 else 1.02), FOCUS, {}),
    ("freed of distortion from the middle on", undistorted, r"distortion is (gone|another)|" + changed("distortion"), {}),
    ("cropped from the middle on", cropped, r"principal point lies .*cropped|" + changed("principal point", "principal distance"), {}),
    ("stretched by 3 % from the middle on", stretched, r"against fy|" + changed("fx against fy"), {}),
    ("every second turned by 180 degrees", lambda image, c: cv2.rotate(image, cv2.ROTATE_180) if c["k"] % 2 else image,
     "turned by 180 degrees|" + changed("turned"), {}),
    ("a quarter of another camera", another, FOCUS + "|photographs of another camera|another body or lens|another lens or setting|taken with another camera", {}),
    ("principal point that moves by 8 px of 1280", wandering, "principal point that moves", {}),
    ("rolling shutter, 6 px of 1280", rolling, "rows (that are )?read", {}),
    ("all mirrored", flipped(lambda k: True), "mirror", {}),
    ("every second mirrored", flipped(lambda k: k % 2), "mirror", {}),
    ("every second at half size", halved, r"pixels where the others have|resized", {}),
    ("motion blur of 15 px in every third", blurred, r"blurred|moved while|motion", {}),
    ("all compressed to quality 20", recompressed, r"compress|JPEG", {}),
    ("a column too few in the board file, or another family", None, r"columns|family|inner corners, not", {"board": "columns"}),
    ("every photograph twice", None, r"same file|same photograph|saved twice", {"twice": True}),
]


def run(plumbline, one, folder, board, out, store, family):
    if "board" in one:
        arguments = ["calibrate_camera", f"folder={folder}", f"board={board}"]
    else:
        arguments = ["marker_board", f"folder={folder}", f"detector={one['detector']}", f"family={family}",
                     f"tag_size={one['tag_size']}"]
    done = subprocess.run([plumbline, "run", *arguments, "--out", out], capture_output=True, text=True,
                          env={"PATH": "/usr/bin:/bin", "HOME": str(store), "PLUMBLINE_STORE": str(store)})
    return done.returncode, done.stdout + done.stderr


def principal_distance(one, out):
    """fx and its standard deviation of the first camera; None if nothing was calibrated."""
    if "board" in one:
        file = Path(out) / "calibration.json"
        if not file.exists():
            return None
        camera = json.loads(file.read_text())
        camera = camera["cameras"][0] if "cameras" in camera else camera
        return camera["parameters"]["fx"], camera["sigmas"]["fx"]
    file = Path(out) / "block.json"
    if not file.exists():
        return None
    for parameter in json.loads(file.read_text())["cameras"][0]["interior_orientation"]:
        if parameter["name"] == "fx":
            return parameter["value"], parameter["sigma"]
    return None


def messages(text):
    """Warnings and errors, without numbers and names of photographs, for comparison."""
    lines = [line for line in text.splitlines()
             if re.search(r"warning|error|failed|left out", line) and "The board is bent" not in line]
    return [re.sub(r"\S+\.(jpe?g|png|JPE?G|PNG)", "PHOTO", line) for line in lines]


def without_numbers(line):
    return re.sub(r"[-+]?\d[\d.,]*", "N", line)


def sound_camera(one, out):
    camera = json.loads((Path(out) / "calibration.json").read_text())["parameters"] if "board" in one else {
        p["name"]: p["value"]
        for p in json.loads((Path(out) / "block.json").read_text())["cameras"][0]["interior_orientation"]}
    matrix = np.float64([[camera["fx"], 0, camera["cx"]], [0, camera["fy"], camera["cy"]], [0, 0, 1]])
    return matrix, np.float64([camera[name] for name in ("k1", "k2", "p1", "p2", "k3")])


def verdict_of(words, said, code, found, sound):
    # What photographs cannot tell is no word about a mistake.
    said = [line for line in said if "do not tell whether focus or zoom changed" not in line]
    if any(re.search(words, line) for line in said):
        return "named"
    if said or code != 0:
        return "told"
    off = abs(found[0] - sound[0]) / max(found[1], 1e-9)
    return "harmless" if off < 3 else f"silent ({off:.1f} σ)"


def judged_again(path):
    """The verdicts of a log of --log with the words as they are listed now; nothing is run."""
    words = {name: listed for name, _, listed, _ in MISTAKES}
    return {(one["set"], one["mistake"]): verdict_of(words[one["mistake"]], one["said"], one["code"], one["fx"], one["sound"])
            for one in map(json.loads, Path(path).read_text().splitlines())}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("plumbline")
    parser.add_argument("sets")
    parser.add_argument("--only", default="", help="mistakes whose name has this")
    parser.add_argument("--table", help="Markdown")
    parser.add_argument("--log", help="what the program said, a JSON object a line")
    parser.add_argument("--judge", metavar="LOG", help="nothing is run: the verdicts of that log with the words as they are now")
    arguments = parser.parse_args()
    sets = json.loads(Path(arguments.sets).read_text())
    verdicts = judged_again(arguments.judge) if arguments.judge else {}
    with tempfile.TemporaryDirectory() as temporary:
        for one in sets if not arguments.judge else []:
            try_set(arguments, one, Path(temporary), verdicts)
    names = [name for name, *_ in MISTAKES if arguments.only in name]
    lines = ["| mistake | " + " | ".join(one["name"] for one in sets) + " |", "|---" * (len(sets) + 1) + "|"]
    for name in ["(sound)"] + names:
        lines.append(f"| {name} | " + " | ".join(verdicts.get((one["name"], name), "") for one in sets) + " |")
    counts = {word: sum(v.startswith(word) for (_, name), v in verdicts.items() if name != "(sound)")
              for word in ("named", "told", "harmless", "silent")}
    lines += ["", ", ".join(f"{count} {word}" for word, count in counts.items())]
    print("\n".join(lines))
    if arguments.table:
        Path(arguments.table).write_text("\n".join(lines) + "\n")


def try_set(arguments, one, temporary, verdicts):
    files = sorted(Path(one["folder"]).glob(one.get("pattern", "*")),
                   key=lambda p: [int(t) if t.isdigit() else t for t in re.split(r"(\d+)", p.name)])
    images = [cv2.imread(str(file), cv2.IMREAD_COLOR) for file in files]
    generator = np.random.default_rng(7)
    context = {"n": len(files), "random": generator.uniform(size=len(files)),
               "normal": generator.normal(size=(len(files), 2))}
    folder, out, store = (temporary / part for part in ("photographs", "out", "store"))

    def attempt(spoil, changes):
        for path in (folder, out):
            shutil.rmtree(path, ignore_errors=True)
        folder.mkdir()
        for k, image in enumerate(images):
            context["k"] = k
            spoilt = image if spoil is None else spoil(image, context)
            names = [f"photo{k:03}.jpg"] + ([f"photo{k + 500:03}.jpg"] if changes.get("twice") else [])
            for name in names:
                cv2.imwrite(str(folder / name), spoilt, QUALITY)
        board, family = one.get("board"), one.get("family")
        if changes.get("board"):
            family = "DICT_5X5_1000"
            if board:
                text = re.sub(r"columns: (\d+)", lambda m: f"columns: {int(m.group(1)) - 1}", Path(board).read_text())
                board = temporary / "board.yaml"
                board.write_text(text)
        code, text = run(arguments.plumbline, one, folder, board, out, store, family)
        return code, text, principal_distance(one, out)

    code, text, sound = attempt(None, {})
    if sound is None:
        raise SystemExit(f"{one['name']}: the sound set does not run:\n{text}")
    context["matrix"], context["distortion"] = sound_camera(one, out)
    usual = {without_numbers(line) for line in messages(text)}
    told = re.search(r"not of one camera|camera is another|\S+ on the (principal|camera|distortion)|[Ii]n every \w+ photograph", text)
    verdicts[one["name"], "(sound)"] = "blamed" if told else f"fx {sound[0]:.1f} ± {sound[1]:.1f}"
    for name, spoil, words, changes in MISTAKES:
        if arguments.only not in name:
            continue
        code, text, found = attempt(spoil, changes)
        new = [line for line in messages(text) if without_numbers(line) not in usual]
        verdict = verdict_of(words, new, code, found, sound)
        verdicts[one["name"], name] = verdict
        print(f"{one['name']}: {name}: {verdict}", flush=True)
        if arguments.log:
            with open(arguments.log, "a") as log:
                log.write(json.dumps({"set": one["name"], "mistake": name, "verdict": verdict, "code": code,
                                      "fx": found, "sound": sound, "said": new}) + "\n")


main()
