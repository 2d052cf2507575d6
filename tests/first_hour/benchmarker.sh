#!/usr/bin/env bash
# usage: benchmarker.sh PREFIX WORK     A shipped bench by its name with few seeds, how far it is, an archive, the archive checked
source "$(dirname "$0")/steps.sh"
cd "$work"
edit "bench.yaml"
cat > bench.yaml <<'YAML'
bench: 1
title: Free or constrained
pipeline: observations
measure: {error: errors.rmse_z}
rope: 0.05 mm
seeds: 1-6
scenarios: {one floor: {floors: 1, images_per_floor: 6}}
alternatives:
  method:
    constrained: {}
    registered: {pipeline: observations_free}
YAML
step plumbline bench bench.yaml --out result --archive supplement
says "result/bench.html"
step plumbline bench bench.yaml --status
says "12 of 12"
step plumbline bench verify supplement --cells 3
fails plumbline bench bench.yml
says "bench"
fails plumbline bench quik
says "did you mean 'quick'"
took 5 1
