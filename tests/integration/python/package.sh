#!/usr/bin/env bash
# usage: package.sh PYTHON WORK PLUMBLINE     installs the module from the tree, as docs/python.md says, and from a wheel, and drives the
#                                             program with each from an empty folder
set -euo pipefail
python=$1 work=$2 program=$3
/usr/bin/python3 -c 'import setuptools, wheel, pip, numpy, flatbuffers' ||
  { echo 'skipped: /usr/bin/python3 lacks pip, setuptools, wheel, numpy or flatbuffers'; exit 77; }
rm -rf "$work"
mkdir -p "$work"
cp -r "$python" "$work/source"  # pip leaves its files beside the sources
pip() { /usr/bin/python3 -m pip "$@" --quiet --no-deps --no-index; }
pip install --no-build-isolation --target "$work/tree" "$work/source"
pip wheel --no-build-isolation --wheel-dir "$work/wheels" "$work/source"
pip install --target "$work/wheel" "$work"/wheels/plumbline-*.whl
cat > "$work/drive.py" <<'PYTHON'
import json, sys
import plumbline, plumbline_artifacts
for module in (plumbline, plumbline_artifacts):
    assert module.__file__.startswith(sys.argv[1]), module.__file__
assert plumbline_artifacts.Schema and plumbline_artifacts.Call

heard = []
run = plumbline.run("observations", out="run", floors=1, images_per_floor=6, progress=heard.append)
assert [node.name for node in heard] == list(run.nodes) and all(node.status in ("executed", "reused") for node in heard), heard
assert run.table("block.points", "points")["position_z"].ndim == 1
assert plumbline.Run("run").nodes["errors"].metrics == run.nodes["errors"].metrics

small = dict(floors=1, images_per_floor=4)
results = plumbline.bench("quick", out="bench", seeds=range(1, 3), scenarios="single floor", **small)
places = json.dumps(results["rows"])
assert "single floor" in places and "full height" not in places, places
assert results["cells"]["missing"] == 0 and results["cells"]["all"] % 2 == 0, results["cells"]
# What lies there from before is no answer to a bench that could not be run.
for wrong, kind in ((dict(scenarios="single flor"), plumbline.UsageError), (dict(store="/dev/null/store"), plumbline.PlumblineError)):
    try:
        plumbline.bench("quick", out="bench", seeds=1, **wrong, **small)
    except kind as error:
        assert str(error), wrong
    else:
        raise AssertionError(wrong)
PYTHON
export PLUMBLINE=$program PLUMBLINE_STORE=$work/store XDG_CACHE_HOME=$work/cache
mkdir "$work/empty"
cd "$work/empty"
for site in tree wheel; do
  PYTHONPATH=$work/$site /usr/bin/python3 "$work/drive.py" "$work/$site"
done
