"""A detector: dark squares on a light ground, turned by up to 18 degrees, each corner to a fraction of a pixel. It reads no codes: the
squares are numbered from top left to bottom right. As a node of the role `detector` it can stand where detect.apriltag stands."""
import numpy as np
from PIL import Image
from plumbline_artifacts import Call


def regions(dark):
    """Rows and columns of each 4-connected region: every pixel takes the least label of its neighbours until none changes."""
    labels = np.where(dark, np.arange(dark.size).reshape(dark.shape), dark.size)
    while True:
        padded = np.pad(labels, 1, constant_values=dark.size)
        least = np.minimum.reduce([labels, padded[:-2, 1:-1], padded[2:, 1:-1], padded[1:-1, :-2], padded[1:-1, 2:]])
        least = np.append(least, dark.size)[np.where(dark, least, dark.size)]  # the label of its label: fewer rounds
        if np.array_equal(least, labels):
            break
        labels = least
    rows, columns = np.nonzero(dark)
    order = np.argsort(labels[dark], kind="stable")
    ends = np.flatnonzero(np.diff(labels[dark][order])) + 1
    return zip(np.split(rows[order], ends), np.split(columns[order], ends))


def line(points):
    """Centroid and direction of the line that fits best."""
    return points.mean(0), np.linalg.svd(points - points.mean(0), full_matrices=False)[2][0]


def corners_of(rows, columns):
    """Where the four sides meet, from bottom left on. A side is the line through the outermost pixels, half a pixel out; only the middle
    half of it takes part, because near its ends the outermost pixel of a turned square is that of another side."""
    def side(along, across, outermost, out):
        values = np.unique(along)
        middle = values[len(values) // 4 + 1:len(values) - len(values) // 4 - 1]
        return np.array([(value, outermost(across[along == value]) + out) for value in middle], float)
    left, right = (side(rows, columns, *how)[:, ::-1] for how in ((np.min, -0.5), (np.max, 0.5)))
    top, bottom = (side(columns, rows, *how) for how in ((np.min, -0.5), (np.max, 0.5)))
    lines = [line(points) for points in (left, bottom, right, top)]
    return np.array([a + u * np.linalg.solve(np.column_stack([u, -v]), b - a)[0] for (a, u), (b, v) in zip(lines, lines[1:] + lines[:1])])


call = Call()
image, variance, tags = call.inputs("images", "plumbline.Image/1")[0], call.parameters["sigma"] ** 2, []
found = {"path": image.path, "sha256": image.sha256, "camera": image.camera, "width": image.width, "height": image.height, "tags": tags}
try:
    grey = np.asarray(Image.open(call.path(image.uri)).convert("L"), float)
    found["height"], found["width"] = grey.shape
    for rows, columns in regions(grey < call.parameters["threshold"] * grey.max()):
        if not rows.size or min(np.ptp(rows), np.ptp(columns)) + 1 < call.parameters["min_side"]:
            continue
        try:
            x, y = (corners := corners_of(rows, columns)).T
        except np.linalg.LinAlgError:  # two sides are parallel that should meet
            continue
        sides, area = np.hypot(x - np.roll(x, 1), y - np.roll(y, 1)), abs(np.dot(x, np.roll(y, 1)) - np.dot(y, np.roll(x, 1))) / 2
        if sides.min() > sides.max() / 2 and abs(area / len(rows) - 1) < 0.03:
            tags.append({"family": "square", "id": len(tags), "corners": corners, "corner_covariances": [variance, 0, variance] * 4})
except OSError as error:
    found["problem"] = f"the photograph could not be searched: {error}"
call.commit("observations", "plumbline.ImageTags/1", found)
