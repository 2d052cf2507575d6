#!/bin/sh
# express.sh MAKE SOURCE WORK DATA : writes as-built files with MAKE, two campaigns each, and holds them against the official
# EXPRESS text of their schemas with a checker that shares nothing with ours. Exit code 77: skipped.
set -eu
make=$1 source=$2 work=$3 data=${PLUMBLINE_TEST_DATA:-$4}
schemas=$data/ifc/express
[ -d "$schemas" ] || { echo "skipped: no EXPRESS schemas in $schemas"; exit 77; }
rm -rf "$work"
mkdir -p "$work"
export PYTHONDONTWRITEBYTECODE=1
set --
for file in "$data"/ifc/*.ifc; do [ -f "$file" ] && set -- "$@" "$file"; done
"$make" "$work" "$@"
/usr/bin/python3 "$source/express/test_check.py" "$schemas" "$work/small_IFC4.two_epochs.ifc"
set --
for design in "$work"/*.design.ifc; do set -- "$@" "$design" "${design%.design.ifc}.two_epochs.ifc"; done
exec /usr/bin/python3 "$source/express/check.py" "$schemas" --added "$@"
