#!/usr/bin/env bash
# usage: new_nodes.sh PREFIX WORK     `plumbline new` for every template: all in one build against the installation, all their tests,
#                                     and of each the run that its `check` ends with
set -euo pipefail
prefix=$1 work=$2
rm -rf "$work"
mkdir -p "$work"
cd "$work"
exec 3>&1 >log 2>&1
trap 'status=$?; ((status == 0)) || cat log >&3' EXIT
export PLUMBLINE_STORE=$work/store XDG_CACHE_HOME=$work/cache
plumbline() { "$prefix/bin/plumbline" "$@"; }
refused() { local text; if text=$(plumbline "${@:2}" 2>&1); then echo "this had to be refused: ${*:2}"; exit 1; fi; echo "$text"; grep -qF -- "$1" <<<"$text"; }

refused "did you mean 'detector'" new detektor mine
refused "cannot be the name of a node" new detector Mine-2
refused "there is a node detect.apriltag already" new detector apriltag
mkdir taken && touch taken/file
refused "is there already" new metric taken

templates=$(ls "$prefix/share/plumbline/templates")
[[ $(wc -w <<<"$templates") -eq 10 ]]
# An asserting build of the kits, not an optimised one: it takes a third of the compiler's time.
{
  echo 'cmake_minimum_required(VERSION 3.25)'
  echo 'project(all LANGUAGES CXX)'
  echo 'enable_testing()'
} >CMakeLists.txt
for template in $templates; do
  plumbline new "${template//_/-}" "own_$template"
  [[ -f own_$template/CMakeLists.txt ]] && echo "add_subdirectory(own_$template)" >>CMakeLists.txt
done
if command -v ccache; then export CMAKE_CXX_COMPILER_LAUNCHER=ccache; fi
export CMAKE_PREFIX_PATH=$prefix
cmake -S . -B build -G Ninja -DCMAKE_BUILD_TYPE=None -DCMAKE_CXX_FLAGS="-O1 --param=ggc-min-heapsize=500000"
cmake --build build -j2
ctest --test-dir build --output-on-failure -j2 | tee kit.log
# Each kit ran over its node, and no other.
for node in detect_own_detector pose_own_pose_solver adjust_own_adjuster register_own_registrar read_own_survey_reader write_own_writer plan_own_planner simulate_own_robot; do
  grep -q "$node" kit.log || { echo "no test ran $node"; exit 1; }
done
for template in $templates; do
  [[ $template == python_node ]] && continue
  sed -n 's/^.*"${PLUMBLINE:-[^}]*}" run \(.*\)$/\1/p' "own_$template/check" | sed 's/ "$@"$//' >runs
  [[ -s runs ]]
  while read -ra words; do
    (cd "own_$template" && PLUMBLINE_PLUGIN_PATH=$work/build/lib/plumbline plumbline run "${words[@]}")
  done <runs
  test -s "own_$template/out/run.jsonl"
done
grep -q median_z own_metric/out/run.jsonl
grep -q 'S1,' own_writer/out/written.csv
# A reader is found by its role, too: the campaign has what the pipeline that names it has.
cmp own_survey_reader/out/coordinates.csv own_survey_reader/out_campaign/coordinates.csv
# The one command: of a node in Python, and of one in C++ (its build is configured anew, so only the smallest).
if /usr/bin/python3 -c 'import numpy, flatbuffers'; then
  own_python_node/check
  grep -q 'B,2.75' own_python_node/out/heights.csv
  for module in json random numpy; do  # names that are modules, too
    plumbline new python_node $module
    $module/check
  done
fi
own_metric/check
