#!/usr/bin/env bash
# usage: integrator_cpp.sh PREFIX WORK     A second sensor with a file format of its own, joined with the site's survey in one network
source "$(dirname "$0")/steps.sh"
make_site
cd "$work"
step plumbline new survey_reader tracker
if command -v ccache > /dev/null; then export CMAKE_CXX_COMPILER_LAUNCHER=ccache; fi
sed -i '/plumbline_test_role/d' tracker/CMakeLists.txt   # its kit is built with all others in InstalledPlumbline.NewNodes…
step tracker/check
# What the tracker saw, from a set-up of its own.
awk -F, 'NR == 1 {print "AT T1 1.500"; next}
  {dx = $2 - 3; dy = $3 + 12; dz = $4 - 1.5; g = 200 / 3.14159265358979; h = sqrt(dx * dx + dy * dy)
   a = g * atan2(dx, dy); if (a < 0) a += 400
   printf "%s %.5f %.5f %.5f 0.000\n", $1, a, g * atan2(h, dz), sqrt(h * h + dz * dz)}' made/site/control.csv > tracker.txt
edit "site.yaml"
cat > site.yaml <<'YAML'
plumbline: 1
include: [site_campaign.yaml]
vars: {tracker_file: tracker.txt}
nodes:
  tracker_source: {use: read.file, with: {file: "${tracker_file}"}}
  tracker: {use: read.tracker, in: {file: tracker_source.file}}
  network: {in: {observations: [campaign.survey, tracker.observations]}}
YAML
export PLUMBLINE_PLUGIN_PATH=$work/tracker/build/lib/plumbline
step plumbline run site.yaml folder=made/site --out result
says "Took part: 6 photographs"
plumbline show result/run.jsonl:network.points > .said
says '"T1"'
took 3 1
