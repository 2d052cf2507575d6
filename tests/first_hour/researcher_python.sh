#!/usr/bin/env bash
# usage: researcher_python.sh PREFIX WORK     From a look around to numbers in numpy, with the package of the installation
source "$(dirname "$0")/steps.sh"
export PYTHONPATH=$prefix/share/plumbline/python
cd "$work"
needs_numpy
step plumbline list pipelines
says "single_floor"
step plumbline describe observations
says "images_per_floor"
edit "study.py"
cat > study.py <<'PYTHON'
import plumbline

opengv = plumbline.run("observations", out="opengv", floors=1, images_per_floor=6)
opencv = plumbline.run("observations", out="opencv", floors=1, images_per_floor=6, set={"poses.use": "pose.opencv"})
assert opengv.usable and opengv.nodes["poses"].kind == "pose.opengv" and opencv.nodes["poses"].kind == "pose.opencv"
points = opengv.artifact("block.points")
n = len(points["points"])
assert points["covariance"].shape == (3 * n * (3 * n + 1) // 2,), points["covariance"].shape
table = opengv.table("block.points", "points")
assert len(table["id"]) == n and abs(table["position_z"]).max() < 100
print("RMSE of heights:", opengv.nodes["errors"].metrics["rmse_z"], "m")
try:
    plumbline.run("observations", flors=2)
except plumbline.UsageError as error:
    assert "did you mean 'floors'" in str(error), error
try:
    plumbline.run("read_survey", file="study.py")
except plumbline.RunFailed as error:
    assert error.failures[0].node == "survey" and "study.py" in str(error), error
assert any(p["name"] == "site_campaign" for p in plumbline.pipelines())
assert plumbline.describe("pose.opengv")["role"] == "pose_initialiser"
PYTHON
step /usr/bin/python3 study.py
took 3 1
