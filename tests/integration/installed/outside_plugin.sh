#!/usr/bin/env bash
# usage: outside_plugin.sh PREFIX WORK GUIDE     the plugin is what the C++ and CMake blocks of the guide hold, so the guide cannot go stale
set -euo pipefail
prefix=$1 work=$2 guide=$3
rm -rf "$work"
mkdir -p "$work"
exec 3>&1 >"$work/log" 2>&1
trap 'status=$?; ((status == 0)) || cat "$work/log" >&3' EXIT

# block LANGUAGE NUMBER: what stands in the guide's block of that number
block() { awk -v open="\`\`\`$1" -v wanted="$2" '$0 == open {inside = ++n == wanted; next} /^```/ {inside = 0} inside' "$guide"; }
number=0
for name in demo; do
  ((++number))
  mkdir -p "$work/$name"
  block cpp $number >"$work/$name/$name.cpp"
  block cmake $number >"$work/$name/CMakeLists.txt"
  lines=$(cat "$work/$name"/* | grep -c '[^[:space:]]')
  ((lines <= 60)) || { echo "$name takes its author $lines lines, 60 are promised"; exit 1; }
  cmake -S "$work/$name" -B "$work/$name/build" -G Ninja -DCMAKE_BUILD_TYPE=Release -DCMAKE_PREFIX_PATH="$prefix"
  cmake --build "$work/$name/build" -j2
done

cd "$work"
PLUMBLINE_PLUGIN_PATH="$work/demo/build/lib/plumbline" "$prefix/bin/plumbline" describe demo.lift | grep 'how far up'
# The installed program finds its own pipelines, not those of the tree it was built from.
"$prefix/bin/plumbline" validate single_floor | grep "$prefix/share/plumbline/pipelines/single_floor.yaml"

# The guide's node in Python, and a node of the installation in a process of its own.
mkdir lift
block yaml 1 >lift/lift.node.yaml
block python 1 >lift/lift.py
printf 'name,x,y,z,sigma\nA,1,2,3,0.001\nB,4,5,6,0.001\n' >points.csv
cat >lift.yaml <<'END'
plumbline: 1
nodes:
  points: {use: read.points, with: {file: points.csv}, isolate: process}
  lift: {use: outside.lift, in: {points: points.points}, with: {height: 2.5}}
outputs: {lifted.json: lift.points}
END
export PLUMBLINE_PLUGIN_PATH="$work/lift:$prefix/share/plumbline/python/examples"
"$prefix/bin/plumbline" describe detect.squares | grep 'Finds dark squares'
if /usr/bin/python3 -c 'import numpy, flatbuffers'; then
  "$prefix/bin/plumbline" run lift.yaml --store store --out out
  grep '5.5' out/lifted.json
else
  echo 'the node in Python is not run: python3-numpy or python3-flatbuffers is not there'
fi

# The detection as a library in a program of its own.
mkdir detection
cat >detection/CMakeLists.txt <<'END'
cmake_minimum_required(VERSION 3.25)
project(detection LANGUAGES CXX)
find_package(Plumbline REQUIRED)
add_executable(detection main.cpp)
target_compile_features(detection PRIVATE cxx_std_20)
target_link_libraries(detection PRIVATE Plumbline::detect)
END
cat >detection/main.cpp <<'END'
#include <cstdio>
#include "photo/detect/tag_detector.hpp"
#include "photo/images/grey_image.hpp"
int main() {
  plumbline::GreyImage image;
  image.width = image.height = 64;
  image.pixels.assign(64 * 64, 128);
  plumbline::detect::TagDetector detector({});
  std::printf("%zu tags\n", detector.detect(image).size());
}
END
cmake -S detection -B detection/build -G Ninja -DCMAKE_PREFIX_PATH="$prefix"
cmake --build detection/build -j2
detection/build/detection | grep '^0 tags$'
