#!/bin/sh
# readback.sh MAKE SOURCE WORK FIXTURES : writes clouds with MAKE, and has laz-perf and web-e57 read them and those in FIXTURES. Exit code 77: skipped.
set -eu
make=$1 source=$2 work=$3 fixtures=$4
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
mkdir "$work/files"
"$make" "$work/files" "$work/listing.json" "$fixtures"
cd "$work" && exec node --no-warnings --experimental-wasm-modules "$source/readback.mjs" listing.json files "$fixtures"
