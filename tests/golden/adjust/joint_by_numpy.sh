#!/bin/sh
# joint_by_numpy.sh PROGRAM FOLDER: runs joint_inputs.yaml, then the second derivation on what it left.
set -eu
here=$(dirname "$0")
rm -rf "$2"
"$1" run "$here/joint_inputs.yaml" --store "$2/store" --out "$2/out" > "$2.log" 2>&1 || { cat "$2.log"; exit 1; }
exec /usr/bin/python3 "$here/joint_by_numpy.py" "$2/out"
