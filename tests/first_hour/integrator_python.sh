#!/usr/bin/env bash
# usage: integrator_python.sh PREFIX WORK     A node in Python behind the shipped job, with what it says when it is misused
source "$(dirname "$0")/steps.sh"
needs_numpy
make_site
cd "$work"
step plumbline new python_node heights
step heights/check
says "range_z"
edit "site.yaml"
cat > site.yaml <<'YAML'
plumbline: 1
include: [site_campaign.yaml]
nodes:
  heights: {use: own.heights, in: {points: block.points}, with: {unit: mm}}
outputs:
  heights.csv: heights.table
YAML
export PLUMBLINE_PLUGIN_PATH=$work/heights
step plumbline run site.yaml folder=made/site --out result
grep -q '^F01-C01-R1,' result/heights.csv
# Its own line is what an error tells.
edit "own_heights.py"
sed -i 's/"media_type": "text\/csv"/"mediatype": "text\/csv"/' heights/own_heights.py
fails plumbline run site.yaml folder=made/site --out result
says "has no mediatype"
took 4 2
