#!/bin/sh
# readback.sh MAKE SOURCE WORK DATA : writes as-built files with MAKE and has web-ifc and ifc-lite read them. Exit code 77: skipped.
set -eu
make=$1 source=$2 work=$3 data=${PLUMBLINE_TEST_DATA:-$4}
skip() { echo "skipped: $1"; exit 77; }
command -v node > /dev/null || skip "node is not installed"
command -v npm > /dev/null || skip "npm is not installed"
mkdir -p "$work"
if ! cmp -s "$source/package-lock.json" "$work/installed.json"; then
  cp "$source/package.json" "$source/package-lock.json" "$work"
  (cd "$work" && npm ci --no-audit --no-fund --ignore-scripts > npm.log 2>&1) || skip "npm cannot install its readers; see $work/npm.log"
  cp "$source/package-lock.json" "$work/installed.json"
fi
rm -rf "$work/files"
set --
for file in "$data"/ifc/*.ifc; do [ -f "$file" ] && set -- "$@" "$file"; done
"$make" "$work/files" "$@"
cd "$work" && exec node "$source/readback.mjs" "$work/files"
