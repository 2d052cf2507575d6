#!/usr/bin/env bash
# usage: researcher_pose_solver.sh PREFIX WORK     A pose solver of one's own in C++, held against the shipped ones in a bench
source "$(dirname "$0")/steps.sh"
cd "$work"
step plumbline new pose_solver mine
says "mine/check"
if command -v ccache > /dev/null; then export CMAKE_CXX_COMPILER_LAUNCHER=ccache; fi
# Its kit is built with all others in InstalledPlumbline.NewNodes…; here the node alone.
sed -i '/plumbline_test_role/d' mine/CMakeLists.txt
step mine/check
edit "bench.yaml"
cat > bench.yaml <<'YAML'
bench: 1
title: A solver of mine
pipeline: observations
measure: {error: errors.rmse_z}
rope: 0.05 mm
seeds: 1-4
scenarios: {one floor: {floors: 1, images_per_floor: 6}}
alternatives: {poses: [pose.opengv, pose.mine]}
YAML
export PLUMBLINE_PLUGIN_PATH=$work/mine/build/lib/plumbline
step plumbline bench bench.yaml --out result -q
says "pose.mine" result/bench.md
took 3 1
