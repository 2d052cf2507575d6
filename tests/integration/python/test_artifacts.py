"""The Python module against flatc: each reads what the other wrote, and the node in Python against squares of known corners.
usage: test_artifacts.py FLATC SCHEMAS BFBS PYTHON"""
import json
import os
import subprocess
import sys
import tempfile
import unittest

FLATC, SCHEMAS, BFBS, PYTHON = sys.argv[1:5]
sys.path.insert(0, PYTHON)

try:
    import numpy as np
    from PIL import Image, ImageDraw
    from plumbline_artifacts import Schema
except ImportError as missing:
    print(f"skipped: {sys.executable} has no {missing.name}; scripts/setup --tests installs python3-numpy, python3-flatbuffers and python3-pil")
    sys.exit(77)

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

    def test_numbers_that_a_field_cannot_hold_are_refused(self):
        tags = {"path": "a.jpg", "width": 100, "height": 50, "tags": [{"family": "tag36h11", "id": 7, "corners": [(1, 2)] * 4}]}
        for change in ({"width": 6000.9}, {"width": 2 ** 40}, {"width": 2 ** 80}, {"width": float("nan")}, {"width": "100"},
                       {"tags": [dict(tags["tags"][0], id=12.9)]}, {"tags": [dict(tags["tags"][0], decision_margin="high")]}):
            with self.assertRaisesRegex(ValueError, "takes numbers of the form", msg=str(change)):
                schema("image_tags").write(dict(tags, **change))
        for content in ([300], [-1], [65.9], np.array([1.5]), ["1"]):
            with self.assertRaisesRegex(ValueError, "'content' takes numbers of the form uint8", msg=str(content)):
                schema("file").write({"name": "x", "media_type": "t", "content": content})
        with self.assertRaisesRegex(ValueError, "'refined' takes numbers of the form bool; found 'False'"):
            schema("image_tags").write(dict(tags, tags=[dict(tags["tags"][0], refined="False")]))
        # What they can hold is kept as it is, whatever its own form.
        kept = schema("file").write({"name": "x", "media_type": "t", "content": np.array([255.0, 0])})
        self.assertEqual(list(schema("file").read(kept).content), [255, 0])
        kept = schema("image_tags").read(schema("image_tags").write(dict(tags, width=np.float32(6000), height=True)))
        self.assertEqual((kept.width, kept.height), (6000, 1))
        unknown = {"points": [{"id": "a", "position": (1, 2, float("nan")), "sigma": (0, 0, 0)}], "covariance": [float("nan")]}
        self.assertTrue(np.isnan(schema("points").read(schema("points").write(unknown)).covariance[0]))

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

    def test_a_struct_in_a_struct_is_given_flat_or_nested_and_a_files_content_as_bytes(self):
        poses, file = schema("poses"), schema("file")
        flat = poses.write({"poses": [{"path": "a", "cam_from_world": [1, 0, 0, 0, 4, 5, 6]}]})
        self.assertEqual(flat, poses.write({"poses": [{"path": "a", "cam_from_world": ((1, 0, 0, 0), np.array([4, 5, 6]))}]}))
        self.assertEqual(poses.read(flat).poses[0].cam_from_world["translation"].tolist(), (4, 5, 6))
        for wrong in ([1, 0, 0, 0], [1, 0, 0, 0, 4, 5, 6, 7]):
            with self.assertRaisesRegex(ValueError, f"rotation, translation was given {len(wrong)} numbers"):
                poses.write({"poses": [{"path": "a", "cam_from_world": wrong}]})
        data = file.write({"name": "a.csv", "media_type": "text/csv", "content": "Süd".encode()})
        self.assertEqual(file.read(data).content.tobytes().decode(), "Süd")

    def test_enums_are_names(self):
        empty = {name: [] for name in ("files", "points", "set_ups", "covariances", "coordinates", "vectors", "local_coordinates", "skipped", "warnings")}
        survey = schema("survey_observations")
        data = survey.write({**empty, "info": {}, "observations": [
            {"kind": kind, "from": "A", "to": "B"} for kind in ("zenith_angle", 2, "direction")]})
        self.assertEqual([o.kind for o in survey.read(data).observations], ["zenith_angle", "slope_distance", "direction"])
        with self.assertRaisesRegex(KeyError, "SurveyObservation.kind is one of .*zenith_angle.*; found 'zenith'"):
            survey.write({**empty, "info": {}, "observations": [{"kind": "zenith", "from": "A", "to": "B"}]})

    def test_says_what_is_wrong(self):
        with self.assertRaisesRegex(KeyError, "has no hight; it has"):
            schema("image_tags").write({"path": "a", "tags": [], "hight": 3})
        with self.assertRaisesRegex(KeyError, "needs path"):
            schema("image_tags").write({"tags": []})
        with self.assertRaisesRegex(AttributeError, "has no 'pathh'"):
            schema("image_tags").read(schema("image_tags").write({"path": "a", "tags": []})).pathh


class DetectSquares(unittest.TestCase):
    """What every detector must do, with squares in place of tags."""
    UPRIGHT = [(20, 10), (49, 10), (49, 39), (20, 39)]

    def detect(self, picture, **parameters):
        """`picture`: an image, or the bytes of a file."""
        with tempfile.TemporaryDirectory() as folder:
            file = os.path.join(folder, "squares.png")
            if isinstance(picture, bytes):
                with open(file, "wb") as stream:
                    stream.write(picture)
            else:
                picture.save(file)
            for sub in ("inputs/images", "schemas", "outputs/observations"):
                os.makedirs(os.path.join(folder, sub))
            for name, base in (("plumbline.Image-1", "image"), ("plumbline.ImageTags-1", "image_tags")):
                with open(os.path.join(BFBS, base + ".bfbs"), "rb") as source, \
                        open(os.path.join(folder, "schemas", name + ".bfbs"), "wb") as target:
                    target.write(source.read())
            with open(os.path.join(folder, "inputs/images/000000"), "wb") as stream:
                stream.write(schema("image").write({"path": "squares.png", "uri": "here", "sha256": "0" * 64}))
            with open(os.path.join(folder, "call.json"), "w", encoding="utf-8") as stream:
                json.dump({"kind": "detect.squares", "parameters": {"threshold": 0.5, "min_side": 8, "sigma": 0.1, **parameters},
                           "references": {"here": file}}, stream)
            subprocess.run([sys.executable, os.path.join(PYTHON, "examples/detect_squares.py"), folder], check=True,
                           env={**os.environ, "PYTHONPATH": PYTHON})
            with open(os.path.join(folder, "outputs/observations/000000"), "rb") as stream:
                self.bytes = stream.read()
        return schema("image_tags").read(self.bytes)

    @staticmethod
    def picture(*polygons, light=255, dark=0):
        picture = Image.new("L", (120, 80), light)
        for polygon in polygons:
            ImageDraw.Draw(picture).polygon(polygon, fill=dark)
        return picture

    @staticmethod
    def corners(tag):
        return np.column_stack([tag.corners["x"], tag.corners["y"]])

    def test_finds_corners_in_the_order_of_the_role(self):
        found = self.detect(self.picture(self.UPRIGHT, [(70, 20), (100, 23), (97, 53), (67, 50)]))
        self.assertEqual((found.width, found.height, [tag.id for tag in found.tags]), (120, 80, [0, 1]))
        upright, turned = map(self.corners, found.tags)
        self.assertLess(np.abs(upright - [(19.5, 39.5), (49.5, 39.5), (49.5, 9.5), (19.5, 9.5)]).max(), 1e-9)
        self.assertLess(np.abs(turned - [(67, 50), (97, 53), (100, 23), (70, 20)]).max(), 0.75)

    def test_moves_with_the_picture_and_is_the_same_twice(self):
        turned = [(30, 20), (60, 25), (55, 55), (25, 50)]
        here = self.corners(self.detect(self.picture(turned)).tags[0])
        first = self.bytes
        self.detect(self.picture(turned))
        self.assertEqual(self.bytes, first)
        there = self.corners(self.detect(self.picture([(x + 31, y + 17) for x, y in turned])).tags[0])
        self.assertLess(np.abs(there - here - (31, 17)).max(), 1e-9)

    def test_brightness_plays_no_part(self):
        bright = self.corners(self.detect(self.picture(self.UPRIGHT)).tags[0])
        dim = self.corners(self.detect(self.picture(self.UPRIGHT, light=90, dark=10)).tags[0])
        self.assertTrue(np.array_equal(bright, dim))

    def test_parameters_have_their_effect(self):
        picture = self.picture(self.UPRIGHT, dark=100)
        self.assertEqual(len(self.detect(picture, threshold=0.3).tags), 0)
        self.assertEqual(len(self.detect(picture, min_side=31).tags), 0)
        self.assertAlmostEqual(self.detect(picture, sigma=0.5).tags[0].corner_covariances[0], 0.25)

    def test_nothing_is_found_where_nothing_is(self):
        disc = Image.new("L", (120, 80), 255)
        ImageDraw.Draw(disc).ellipse((20, 10, 60, 50), fill=0)
        for picture in (self.picture(), self.picture([(30, 60), (50, 20), (70, 60)]), disc, self.picture(light=0)):
            self.assertEqual(len(self.detect(picture).tags), 0)

    def test_a_broken_photograph_is_a_finding_and_no_crash(self):
        found = self.detect(b"\x89PNG\r\n no picture")
        self.assertEqual(len(found.tags), 0)
        self.assertIn("could not be searched", found.problem)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
