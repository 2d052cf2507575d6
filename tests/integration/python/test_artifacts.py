"""The Python module against flatc: each reads what the other wrote.
usage: test_artifacts.py FLATC SCHEMAS BFBS PYTHON"""
import json
import os
import subprocess
import sys
import tempfile
import unittest

FLATC, SCHEMAS, BFBS, PYTHON = sys.argv[1:5]
sys.path.insert(0, PYTHON)

import numpy as np  # noqa: E402
from plumbline_artifacts import Schema  # noqa: E402

POINTS = {"frame": "building", "points": [
    {"id": "A1", "position": {"x": 1.5, "y": -2.25, "z": 1e-3}, "sigma": {"x": 0.001, "y": 0.002, "z": 0.003}},
    {"id": "Ä2", "position": {"x": 4, "y": 5, "z": 6}, "sigma": {"x": 0.1, "y": 0.2, "z": 0.3}}],
    "covariance": [1.0, 0.5, 2.0]}
TAGS = {"path": "a.jpg", "width": 100, "height": 50, "tags": [
    {"family": "tag36h11", "id": 7, "corners": [{"x": 1, "y": 2}, {"x": 3, "y": 2}, {"x": 3, "y": 0.5}, {"x": 1, "y": 0.5}],
     "decision_margin": 2.5}]}


def schema(name):
    with open(os.path.join(BFBS, name + ".bfbs"), "rb") as stream:
        return Schema(stream.read())


def flatc(*arguments):
    subprocess.run([FLATC, *arguments], check=True, capture_output=True)


class Artifacts(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)

    def path(self, name):
        return os.path.join(self.folder.name, name)

    def written_by_flatc(self, name, values):
        with open(self.path(name + ".json"), "w", encoding="utf-8") as stream:
            json.dump(values, stream)
        flatc("-b", "-I", SCHEMAS, "-o", self.folder.name, os.path.join(SCHEMAS, name + ".fbs"), self.path(name + ".json"))
        with open(self.path(name + ".bin"), "rb") as stream:
            return stream.read()

    def read_by_flatc(self, name, data):
        with open(self.path("out.bin"), "wb") as stream:
            stream.write(data)
        flatc("--json", "--strict-json", "--raw-binary", "-I", SCHEMAS, "-o", self.folder.name,
              os.path.join(SCHEMAS, name + ".fbs"), "--", self.path("out.bin"))
        with open(self.path("out.json"), encoding="utf-8") as stream:
            return json.load(stream)

    def test_reads_what_flatc_wrote(self):
        points = schema("points").read(self.written_by_flatc("points", {k: v for k, v in POINTS.items() if k == "points"}))
        self.assertEqual([p.id for p in points.points], ["A1", "Ä2"])
        self.assertEqual(points.points[0].position["y"], -2.25)
        self.assertEqual(tuple(points.points[1].sigma), (0.1, 0.2, 0.3))
        tags = schema("image_tags").read(self.written_by_flatc("image_tags", TAGS))
        corners = tags.tags[0].corners
        self.assertFalse(corners.flags.owndata, "a view, not a copy")
        np.testing.assert_array_equal(corners["x"], [1, 3, 3, 1])
        self.assertEqual(tags.tags[0].decision_margin, 2.5)
        self.assertEqual(tags.tags[0].hamming, 0)
        self.assertEqual(len(tags.tags[0].corner_covariances), 0)
        self.assertEqual((tags.sha256, tags.camera), ("", ""))

    def test_flatc_reads_what_it_wrote(self):
        values = {"path": "a.jpg", "width": 100, "height": 50, "tags": [
            {"family": "tag36h11", "id": 7, "corners": [(1, 2), (3, 2), (3, 0.5), (1, 0.5)], "corner_covariances": np.arange(12.0),
             "decision_margin": 2.5}, {"family": "tag36h11", "id": 8, "corners": np.array([[1.0, 2]] * 4)}]}
        found = self.read_by_flatc("image_tags", schema("image_tags").write(values))
        self.assertEqual(found["tags"][0]["corners"], TAGS["tags"][0]["corners"])
        self.assertEqual(found["tags"][0]["corner_covariances"], list(range(12)))
        self.assertEqual(found["tags"][1]["id"], 8)
        points = {"points": [{"id": p["id"], "position": tuple(p["position"].values()), "sigma": tuple(p["sigma"].values())}
                             for p in POINTS["points"]]}
        found = self.read_by_flatc("points", schema("points").write(points))
        self.assertEqual([p["position"] for p in found["points"]], [p["position"] for p in POINTS["points"]])

    def test_reads_what_it_wrote_whatever_the_alignment(self):
        poses = schema("transform")
        for name_length in range(9):  # strings of every length move what stands before them
            data = poses.write({"to_from_from": ((1, 0, 0, 0), (1, 2, 3)), "scale": 1.5, "covariance": np.arange(21.0),
                                "residuals": [{"id": "x" * name_length, "residual": (0.1, 0.2, 0.3), "weight": 1, "w": (1, 2, 3)}]})
            found = poses.read(data)
            self.assertEqual(found.to_from_from["translation"]["z"], 3)
            self.assertEqual(found.residuals[0].residual["y"], 0.2)
            self.assertEqual((found.scale, found.residuals[0].id), (1.5, "x" * name_length))

    def test_says_what_is_wrong(self):
        with self.assertRaisesRegex(KeyError, "has no hight; it has"):
            schema("image_tags").write({"path": "a", "tags": [], "hight": 3})
        with self.assertRaisesRegex(KeyError, "needs path"):
            schema("image_tags").write({"tags": []})
        with self.assertRaisesRegex(AttributeError, "has no 'pathh'"):
            schema("image_tags").read(schema("image_tags").write({"path": "a", "tags": []})).pathh


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
