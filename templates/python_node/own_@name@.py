"""own.@name@: a node in Python. Lists of numbers are numpy arrays; what is written is a dict with the schema's fields."""
from plumbline_artifacts import Call  # first, so that it sees what is imported

import numpy as np

call = Call()
points = call.inputs("points", "plumbline.Points/1")[0]
if not len(points.points):
    raise SystemExit("'points' holds no point: nothing to give heights of")
heights = np.array([p.position[2] for p in points.points])
heights -= np.nanmin(heights)
scale = {"m": 1, "mm": 1000}[call.parameters["unit"]]
lines = [f"id,height_{call.parameters['unit']},sigma_{call.parameters['unit']}"]
lines += [f"{p.id},{scale * h:.6f},{scale * p.sigma[2]:.6f}" for p, h in zip(points.points, heights)]
call.metric("range_z", float(np.nanmax(heights)), "m")
call.commit("table", "plumbline.File/1",
            {"name": "heights.csv", "media_type": "text/csv", "content": ("\n".join(lines) + "\n").encode()})
