#!/bin/sh
# ids.sh MAKE SOURCE WORK DATA : writes as-built files with MAKE and an IDS each, which they fulfil and the designs do not, by a checker
# that shares nothing with ours and agrees with buildingSMART's own cases where they lie in the test data. Exit code 77: skipped.
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
check() { /usr/bin/python3 "$source/ids/check_ids.py" "$schemas" "$@"; }
[ ! -d "$data/ids/testcases" ] || check --cases "$data/ids/testcases"
# The acceptance: accepted is what passes, and nothing of which a part was not judged.
mkdir "$work/acceptance"
mv "$work"/accepted.* "$work"/*not_judged.ifc "$work/acceptance"
check "$work/acceptance/accepted.ids" "$work/acceptance/accepted.ifc"
for file in "$work"/acceptance/*not_judged.ifc; do
  if check "$work/acceptance/accepted.ids" "$file" > "$work/refused.txt"; then
    echo "$file: accepted although something in it was not judged"
    exit 1
  fi
  grep -q "not fulfilled" "$work/refused.txt" || { cat "$work/refused.txt"; exit 1; }
done
for ids in "$work"/*.ids; do
  check "$ids" "${ids%.ids}.two_epochs.ifc"
  if check "$ids" "${ids%.ids}.design.ifc" > "$work/design.txt"; then
    echo "$ids: the design alone fulfils it, so it asks nothing"
    exit 1
  fi
done
