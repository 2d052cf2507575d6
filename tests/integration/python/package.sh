#!/usr/bin/env bash
# usage: package.sh PYTHON WORK     installs the module from the tree, as docs/writing_a_plugin.md says
set -euo pipefail
python=$1 work=$2
/usr/bin/python3 -c 'import setuptools, wheel, pip, numpy, flatbuffers' ||
  { echo 'skipped: /usr/bin/python3 lacks pip, setuptools, wheel, numpy or flatbuffers'; exit 77; }
rm -rf "$work"
mkdir -p "$work"
cp -r "$python" "$work/source"  # pip leaves its files beside the sources
/usr/bin/python3 -m pip install --quiet --no-build-isolation --no-deps --no-index --target "$work/site" "$work/source"
cd "$work/site"
/usr/bin/python3 -c 'import plumbline_artifacts as p; assert p.__file__.startswith("'"$work"'/site"); p.Schema, p.Call'
/usr/bin/python3 -c 'import plumbline as p; assert p.__file__.startswith("'"$work"'/site"); p.run, p.Run'
