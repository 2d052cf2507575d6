"""drawn.measured: what was built is off by 2 mm, the survey knows it to 1 mm, photographs each point to 0.4 mm beside what they have in common."""
from plumbline_artifacts import Call  # first, so that it sees what is imported

import numpy as np

import drawn_building

SET, SURVEYED, SEEN = 2e-3, 1e-3, 0.4e-3  # standard deviations of each coordinate [m]


def common_to_all(places):
    """Columns by which photographs may be off together: shifts, turns and bends of the whole, of the second order, 2 mm each at its ends."""
    scaled = (places - places.mean(0)) / (np.ptp(places, axis=0).max() / 2)
    x, y, z = scaled.T
    fields = np.stack([np.ones_like(x), x, y, z, x * y, x * z, y * z, z * z], axis=1)
    return 2e-3 * np.kron(fields, np.eye(3))


def adjusted(design, control, common, rng):
    """Surveyed places, those adjusted to the survey of the control, (5), the variances of these and, of errors that they have in `common`, the factors
    A, B of their covariance diag(variances) + A B A'."""
    n = design.size
    truth = design.ravel() + rng.normal(0, SET, n)
    survey = truth + rng.normal(0, SURVEYED, n)
    seen = truth + common @ rng.normal(size=common.shape[1]) + rng.normal(0, SEEN, n)
    held = np.repeat(control, 3)
    # seen - common x - truth has the variance SEEN², survey - truth SURVEYED² where it is control: x first, then each by itself.
    follows = np.where(held, SEEN**2 / (SEEN**2 + SURVEYED**2), 0.0)
    weighted = common[held] / (SEEN**2 + SURVEYED**2)
    of_common = np.linalg.inv(np.eye(common.shape[1]) + common[held].T @ weighted)
    x = of_common @ (weighted.T @ (seen - survey)[held])
    model = (1 - follows) * (seen - common @ x) + follows * survey
    own = np.where(held, SEEN**2 * SURVEYED**2 / (SEEN**2 + SURVEYED**2), SEEN**2)
    return survey, model, own, (1 - follows)[:, None] * common, of_common


call = Call()
asked = call.parameters
drawn = list(drawn_building.anchors(asked["floors"], asked["columns"], asked["facades"]))
design = np.array([at for *_, at in drawn])
control = np.arange(len(drawn)) % 3 != 0
common = common_to_all(design) if asked["joint"] else np.zeros((design.size, 0))
survey, model, own, moved, of_common = adjusted(design, control, common, np.random.default_rng(7))
covariance = moved @ of_common @ moved.T + np.diag(own) if asked["joint"] else None
sigma = np.sqrt(own + np.einsum("ij,jk,ik->i", moved, of_common, moved))
order = sorted(range(len(drawn)), key=lambda i: drawn[i][0])
role = ["control" if c else "check" for c in control]
turned = {"S": (1, 0, 0, 0), "E": (0.5**0.5, 0, 0, 0.5**0.5), "N": (0, 0, 0, 1), "W": (0.5**0.5, 0, 0, -(0.5**0.5))}


def points(coordinates, deviations, full=None):
    found = {"points": [{"id": drawn[i][0], "position": tuple(coordinates[3 * i:3 * i + 3]), "sigma": tuple(deviations[3 * i:3 * i + 3]), "role": role[i]}
                        for i in order]}
    if full is not None:
        at = (3 * np.array(order)[:, None] + np.arange(3)).ravel()
        found["covariance"] = np.concatenate([full[row, at[:k + 1]] for k, row in enumerate(at)])
    return found


call.commit("plates", "plumbline.Plates/1", {"plates": [
    {"anchor": name, "tag_family": "tag36h11", "tag_id": i % 587, "tag_size": 0.1, "tag_centre_in_plate": (0, 0, 0),
     "nominal_rotation": turned[facade], "batch": f"batch-{i % 3}", "role": role[i], "floor": floor, "column": column, "row": row,
     "mounting_sigma": []}
    for i in order for name, facade, floor, column, row, _ in [drawn[i]]]})
call.commit("model", "plumbline.Points/1", points(model, sigma, covariance))
call.commit("survey", "plumbline.Points/1", points(survey, np.full(design.size, SURVEYED)))
