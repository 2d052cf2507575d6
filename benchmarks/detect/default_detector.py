#!/usr/bin/env python3
"""The detectors as users call them, on whole folders of photographs: tags, photographs that have some, processor time.

    benchmarks/detect/default_detector.py build/bin/plumbline FAMILY FOLDER...

One line a detector: detect.apriltag (the default), detect.aruco, detect.tag_pyramid, each by `plumbline run detect_images`
with decoding and the fit of the edges, and OpenCV's aruco module where Debian's python3-opencv is there. Processor time is
that of the process less that of a run that only lists and decodes nothing; tags are compared with the union of what two of the
detectors agree on (same id, centre within a quarter of an edge): `of both`. What only one has is `alone`, to be looked at.
"""
import collections
import json
import math
import resource
import subprocess
import sys
import tempfile
from pathlib import Path


def timed(command):
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    done = subprocess.run(command, capture_output=True, text=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return done, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def tags_of(file):
    """By photograph: (id, centre, edge) of every tag."""
    found = collections.defaultdict(list)
    for image in json.loads(Path(file).read_text())["images"]:
        for tag in image["tags"]:
            corners = tag["corners"]
            centre = [sum(c[axis] for c in corners) / 4 for axis in (0, 1)]
            edge = min(math.dist(corners[k], corners[(k + 1) % 4]) for k in range(4))
            found[Path(image["path"]).name].append(
                (tag["id"], centre, edge, bool(tag.get("refined", False)), corners))
    return found


def same(a, b):
    return a[0] == b[0] and math.dist(a[1], b[1]) < 0.25 * a[2] + 1


def ours(plumbline, folder, detector, family, out):
    done, seconds = timed([plumbline, "run", "detect_images", f"folder={folder}", f"detector={detector}",
                           f"family={family}", "--out", out, "--threads", "1", "--store", out + ".store"])
    if done.returncode:
        print(f"{detector}: {done.stderr.strip().splitlines()[-1]}")
        return None
    return tags_of(Path(out) / "observations.json"), seconds


def opencv(folder, family):
    try:
        import cv2
    except ImportError:
        return None
    name = {"tag36h11": "DICT_APRILTAG_36h11", "tag16h5": "DICT_APRILTAG_16h5"}.get(family, family)
    if not hasattr(cv2.aruco, name):
        return None
    dictionary = cv2.aruco.Dictionary_get(getattr(cv2.aruco, name))
    found, before = collections.defaultdict(list), resource.getrusage(resource.RUSAGE_SELF)
    cv2.setNumThreads(1)
    for file in sorted(Path(folder).iterdir()):
        image = cv2.imread(str(file), cv2.IMREAD_GRAYSCALE | cv2.IMREAD_IGNORE_ORIENTATION)
        if image is None:
            continue  # no photograph
        corners, ids, _ = cv2.aruco.detectMarkers(image, dictionary)
        for c, number in zip(corners, [] if ids is None else ids.ravel()):
            c = c[0].tolist()
            centre = [sum(p[axis] for p in c) / 4 for axis in (0, 1)]
            found[file.name].append((int(number), centre, min(math.dist(c[k], c[(k + 1) % 4]) for k in range(4)), False, c))
    after = resource.getrusage(resource.RUSAGE_SELF)
    return found, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def apart(some, others):
    """Distances of the corners of tags that both have with fitted edges: median, root mean square, largest [px]."""
    distances = []
    for photograph, tags in some.items():
        for tag in tags:
            for other in others.get(photograph, []):
                if same(tag, other) and tag[3] and other[3]:
                    distances += [min(math.dist(c, d) for d in other[4]) for c in tag[4]]
    if not distances:
        return ""
    distances.sort()
    rms = math.sqrt(sum(d * d for d in distances) / len(distances))
    return f", corners off the first's by {distances[len(distances) // 2]:.4f} (median), {rms:.3f} (rms), {distances[-1]:.3f} px"


def main():
    plumbline, family, folders = sys.argv[1], sys.argv[2], sys.argv[3:]
    for folder in folders:
        results = {}
        with tempfile.TemporaryDirectory() as temporary:
            for detector in ("apriltag", "aruco", "tag_pyramid"):
                result = ours(plumbline, folder, detector, family, f"{temporary}/{detector}")
                if result:
                    results["detect." + detector] = result
        if theirs := opencv(folder, family):
            results["OpenCV aruco"] = theirs
        agreed = collections.defaultdict(list)
        for tags, _ in results.values():
            for photograph, list_of in tags.items():
                for tag in list_of:
                    votes = sum(any(same(tag, o) for o in other.get(photograph, [])) for other, _ in results.values())
                    if votes >= 2 and not any(same(tag, a) for a in agreed[photograph]):
                        agreed[photograph].append(tag)
        total = sum(map(len, agreed.values()))
        print(f"{folder}, {family}: {total} tags that two detectors or more have")
        first = next(iter(results.values()))[0]
        for p, some in agreed.items():
            for a in some:
                if lacking := [n for n, (tags, _) in results.items() if not any(same(a, t) for t in tags.get(p, []))]:
                    print(f"    {p}: tag {a[0]} of {a[2]:.0f} px is not in {', '.join(lacking)}")
        for name, (tags, seconds) in results.items():
            hit = sum(any(same(a, t) for t in tags.get(p, [])) for p, some in agreed.items() for a in some)
            every = sum(map(len, tags.values()))
            refined = sum(t[3] for some in tags.values() for t in some)
            alone = sum(not any(same(t, a) for a in agreed[p]) for p, some in tags.items() for t in some)
            print(f"  {name:20} {hit:4} of {total:4}, {alone:3} alone, {refined:4} of {every:4} with fitted edges, "
                  f"{seconds:6.2f} s of processor time"
                  + ("" if tags is first else apart(tags, first)), flush=True)


main()
