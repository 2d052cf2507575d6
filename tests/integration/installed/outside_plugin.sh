#!/usr/bin/env bash
# usage: outside_plugin.sh BUILD WORK GUIDE     the plugin is the C++ block of the guide, so the guide cannot go stale
set -euo pipefail
build=$1 work=$2 guide=$3
rm -rf "$work"
mkdir -p "$work/plugin"
exec 3>&1 >"$work/log" 2>&1
trap 'status=$?; ((status == 0)) || cat "$work/log" >&3' EXIT

cmake --install "$build" --prefix "$work/prefix"
awk '/^```cpp/ {inside = 1; next} /^```/ {if (inside) exit} inside' "$guide" >"$work/plugin/lift.cpp"
cat >"$work/plugin/CMakeLists.txt" <<'CMAKE'
cmake_minimum_required(VERSION 3.25)
project(lift VERSION 0.1.0 LANGUAGES CXX)
find_package(Plumbline REQUIRED)
plumbline_add_plugin(demo SOURCES lift.cpp)
CMAKE
cmake -S "$work/plugin" -B "$work/plugin/build" -G Ninja -DCMAKE_PREFIX_PATH="$work/prefix"
cmake --build "$work/plugin/build"

cd "$work"
export PLUMBLINE_PLUGIN_PATH="$work/plugin/build/lib/plumbline"
prefix/bin/plumbline describe demo.lift | grep 'how far up'
# The installed program finds its own pipelines and plugins, not those of the tree it was built from.
prefix/bin/plumbline validate single_floor | grep "$work/prefix/share/plumbline/pipelines/single_floor.yaml"
