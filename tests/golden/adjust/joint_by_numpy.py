"""A second derivation of the joint adjustment: readings and photographs in one dense system, by numpy.

    joint_by_numpy.py FOLDER      with what `plumbline run tests/golden/adjust/joint_inputs.yaml --out FOLDER` leaves there

Nothing is shared with the program but the observations and their standard deviations: observation equations are written
down again, their derivatives are numerical, all unknowns stand in one normal matrix. Exit code 1 and the figures if
anchors, stations or their standard deviations differ.
"""
import json
import pathlib
import sys

import numpy as np

EARTH, REFRACTION = 6371000.0, 0.13
folder = pathlib.Path(sys.argv[1])


def read(name):
    return json.loads((folder / name).read_text())


def rotation(v):
    angle = np.linalg.norm(v)
    k = np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])
    if angle < 1e-12:
        return np.eye(3) + k
    return np.eye(3) + np.sin(angle) / angle * k + (1 - np.cos(angle)) / angle**2 * k @ k


def matrix(q):
    w, x, y, z = q
    return np.array([
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]])


def triangle(values, n):
    full = np.zeros((n, n))
    full[np.tril_indices(n)] = values
    return full + np.tril(full, -1).T


class Unknowns:
    """Names to numbers; rotations are small turns about their start."""

    def __init__(self):
        self.start, self.place = [], {}

    def add(self, name, values):
        self.place[name] = slice(len(self.start), len(self.start) + len(values))
        self.start.extend(values)


class Joint:
    def __init__(self):
        self.u = Unknowns()
        self.camera, self.plates = read("camera.json"), read("plates.json")["plates"]
        self.poses = {p["path"]: p["cam_from_world"] for p in read("start_poses.json")["poses"]}
        self.images = [i for i in read("images.json") if i["path"] in self.poses]
        surveyed = {p["id"]: np.array(p["position"]) for p in read("survey_points.json")["points"]}
        survey = read("survey.json")
        self.set_ups = {s["id"]: s for s in survey["set_ups"]}
        self.height_of_target = {(o["from"], o["to"]): o.get("target_height") or 0.0 for o in survey["observations"]}
        self.rows = [r for r in read("network.json")["observations"] if not r["removed"]]
        for name, position in surveyed.items():
            self.u.add("point " + name, np.round(position, 2))  # some millimetres from what is to be found
        for s in self.set_ups:
            first = next(r for r in self.rows if r["kind"] == "direction" and r["set_up"] == s)
            d = surveyed[first["to"]] - surveyed[first["from"]]
            self.u.add("orientation " + s, [np.arctan2(d[0], d[1]) - first["value"]])
        seen = {(t["family"], t["id"]) for i in self.images for t in i["tags"]}
        self.plates = [p for p in self.plates if (p["tag_family"], p["tag_id"]) in seen]
        for p in self.plates:
            if "point " + p["anchor"] not in self.u.place or p["role"] == "check":
                # What does not hold the block is a point of the photographs alone.
                self.u.add("anchor " + p["anchor"], np.round(surveyed[p["anchor"]], 2))
            self.u.add("turn " + p["anchor"], np.zeros(3))
        for i in self.images:
            self.u.add("centre " + i["path"], -matrix(self.poses[i["path"]][0]).T @ np.array(self.poses[i["path"]][1]))
            self.u.add("attitude " + i["path"], np.zeros(3))
        self.u.add("camera", self.camera["parameters"])
        self.u.add("scale", [1.0])
        self.start = np.array(self.u.start)
        self.turned = {}  # rotations so far
        for p in self.plates:
            self.turned["turn " + p["anchor"]] = matrix(p["nominal_rotation"])
        for i in self.images:
            self.turned["attitude " + i["path"]] = matrix(self.poses[i["path"]][0])
        covariance = triangle(self.camera["covariance"], 9)
        self.free_camera = [k for k in range(9) if covariance[k, k] > 0 and k != 6]
        self.prior = np.linalg.inv(np.linalg.cholesky(covariance[np.ix_(self.free_camera, self.free_camera)]))

    def value(self, x, name):
        return x[self.u.place[name]]

    def anchor(self, x, plate):
        own = "anchor " + plate["anchor"]
        return self.value(x, own if own in self.u.place else "point " + plate["anchor"])

    def tags(self, x):
        """Rows of all corners, image by image: x of every corner, then y."""
        fx, fy, cx, cy, k1, k2, k3, p1, p2 = self.value(x, "camera")
        scale = self.value(x, "scale")[0]
        corners = {}
        for plate in self.plates:
            name = "turn " + plate["anchor"]
            square = 0.5 * plate["tag_size"] * scale * np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]])
            corners[(plate["tag_family"], plate["tag_id"])] = self.anchor(x, plate) + (
                np.array(plate["tag_centre_in_plate"]) + square) @ (rotation(self.value(x, name)) @ self.turned[name]).T
        rows = []
        for image in self.images:
            name = "attitude " + image["path"]
            turn = rotation(self.value(x, name)) @ self.turned[name]
            points = np.vstack([corners[(t["family"], t["id"])] for t in image["tags"]])
            v = (points - self.value(x, "centre " + image["path"])) @ turn.T
            a, b = v[:, 0] / v[:, 2], v[:, 1] / v[:, 2]
            r = a * a + b * b
            radial = 1 + k1 * r + k2 * r**2 + k3 * r**3
            seen = np.array([c for t in image["tags"] for c in t["corners"]])
            variances = np.array([t["corner_covariances"] for t in image["tags"]]).reshape(-1, 3)
            rows.append((fx * (a * radial + 2 * p1 * a * b + p2 * (r + 2 * a * a)) + cx - seen[:, 0])
                        / np.sqrt(variances[:, 0]))
            rows.append((fy * (b * radial + p1 * (r + 2 * b * b) + 2 * p2 * a * b) + cy - seen[:, 1])
                        / np.sqrt(variances[:, 2]))
        return np.concatenate(rows)

    def readings(self, x):
        for r in self.rows:
            if r["kind"] in ("coordinate", "prior"):
                yield (self.value(x, "point " + r["to"])["ENH".index(r["detail"])] - r["value"]) / r["sigma"]
                continue
            d = self.value(x, "point " + r["to"]) - self.value(x, "point " + r["from"])
            d = d + np.array([0, 0, self.height_of_target[(r["from"], r["to"])]
                              - self.set_ups[r["set_up"]]["instrument_height"]])
            horizontal = np.hypot(d[0], d[1])
            if r["kind"] == "direction":
                off = np.arctan2(d[0], d[1]) - self.value(x, "orientation " + r["set_up"])[0] - r["value"]
                off = (off + np.pi) % (2 * np.pi) - np.pi
            elif r["kind"] == "zenith_angle":
                off = np.arctan2(horizontal, d[2] - (1 - REFRACTION) * horizontal**2 / (2 * EARTH)) - r["value"]
            else:
                off = np.linalg.norm(d) - r["value"]
            yield off / r["sigma"]

    def residuals(self, x, readings=None):
        if readings is None:
            readings = np.fromiter(self.readings(x), float)
        camera = (self.value(x, "camera") - np.array(self.camera["parameters"]))[self.free_camera]
        return np.concatenate([self.tags(x), readings,
                               self.prior @ camera, [(self.value(x, "scale")[0] - 1) / 1e-3]])

    def solve(self):
        held = {self.u.place["camera"].start + k for k in range(9) if k not in self.free_camera}
        unknown = [k for k in range(len(self.start)) if k not in held]
        surveyed = {k for name, place in self.u.place.items() if name.startswith(("point ", "orientation "))
                    for k in range(place.start, place.stop)}
        x = self.start.copy()
        for _ in range(20):
            r = self.residuals(x)
            readings = np.fromiter(self.readings(x), float)
            jacobian = np.empty((len(r), len(unknown)))
            for c, k in enumerate(unknown):
                step = 1e-6 * max(1, abs(x[k]) * 1e-2)
                ahead, behind = x.copy(), x.copy()
                ahead[k] += step
                behind[k] -= step
                same = None if k in surveyed else readings
                jacobian[:, c] = (self.residuals(ahead, same) - self.residuals(behind, same)) / (2 * step)
            size = 1 / np.linalg.norm(jacobian, axis=0)
            scaled = jacobian * size
            normal = scaled.T @ scaled
            dx = -size * np.linalg.solve(normal, scaled.T @ r)
            x[unknown] += dx
            for name, turned in self.turned.items():  # turns start from nothing again
                self.turned[name] = rotation(self.value(x, name)) @ turned
                x[self.u.place[name]] = 0
            if np.max(np.abs(dx) * np.sqrt(np.diag(normal)) / size) < 1e-6:
                break
        sigma = np.zeros(len(x))
        sigma[unknown] = size * np.sqrt(np.diag(np.linalg.inv(normal)))
        return x, sigma


def main():
    joint = Joint()
    x, sigma = joint.solve()
    largest, relative, count = 0.0, 0.0, 0
    for file, prefix in (("model.json", None), ("survey_points.json", "point ")):
        for point in read(file)["points"]:
            name = (prefix or "anchor ") + point["id"]
            if name not in joint.u.place:
                name = "point " + point["id"]
            place = joint.u.place[name]
            largest = max(largest, np.max(np.abs(np.array(point["position"]) - x[place])))
            relative = max(relative, np.max(np.abs(np.array(point["sigma"]) / sigma[place] - 1)))
            count += 1
    print(f"{count} points: coordinates agree to {largest:.2g} m, standard deviations to {relative:.2g} of themselves")
    return 0 if count > 10 and largest < 1e-6 and relative < 1e-3 else 1


if __name__ == "__main__":
    sys.exit(main())
