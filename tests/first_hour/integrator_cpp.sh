#!/usr/bin/env bash
# usage: integrator_cpp.sh PREFIX WORK     A second sensor with a file format of its own: one plugin and a file dropped into the site's
# folder, which every pipeline then reads; and by hand, joined with the site's survey in one network
source "$(dirname "$0")/steps.sh"
make_site
cd "$work"
step plumbline new survey_reader tracker
if command -v ccache > /dev/null; then export CMAKE_CXX_COMPILER_LAUNCHER=ccache; fi
sed -i '/plumbline_test_role/d' tracker/CMakeLists.txt   # its kit is built with all others in InstalledPlumbline.NewNodes…
step tracker/check
# What the tracker saw, from a set-up of its own: three readings of each point.
awk -F, 'NR == 1 {print "AT T1 1.500"; next}
  {dx = $2 - 3; dy = $3 + 12; dz = $4 - 1.5; g = 200 / 3.14159265358979; h = sqrt(dx * dx + dy * dy)
   a = g * atan2(dx, dy); if (a < 0) a += 400
   printf "%s %.5f %.5f %.5f 0.000\n", $1, a, g * atan2(h, dz), sqrt(h * h + dz * dz); ++n}
  END {print 3 * n > "readings"}' made/site/control.csv > tracker.txt
step plumbline run site_campaign folder=made/site --out alone
part() { sed -n 's/^Took part: .* \([0-9]*\) readings.*/\1/p' "$work/.said"; }
alone=$(part)

# The file in the folder: the reader is found by its role.
cp tracker.txt made/site/survey/day2.tracker
export PLUMBLINE_PLUGIN_PATH=$work/tracker/build/lib/plumbline
fails plumbline run site_campaign folder=made/site --out forgotten
says "1 survey file (survey/day2.tracker) that nothing names"
edit "campaign.yaml: survey: survey/*"
sed -i 's|^survey: .*|survey: survey/*|' made/site/campaign.yaml
step plumbline run site_campaign folder=made/site --out both
[[ $(part) -eq $((alone + $(cat readings))) ]] || { echo "$(part) readings took part, $alone of them without the tracker" >&2; exit 1; }
grep -q 'survey/day2.tracker' both/report.html
plumbline show both/run.jsonl:network.points > .said
says '"T1"'
step plumbline campaign check made/site
says "survey: 2 files"
cp -r made/site proposed && rm proposed/campaign.yaml
step plumbline campaign init proposed
says "survey: [survey/day2.tracker, survey/total_station.gsi]"
step plumbline run survey_campaign folder=made/site --out network
says "T1" network/coordinates.csv
cp tracker.txt job.tracker
step plumbline run survey_network file=job.tracker --out one
says "5 points, 1 set-up, 12 readings"
step plumbline run read_survey file=job.tracker --out read
says '"T1"' read/observations.json
# Without the plugin the file is no survey file of any format, and nobody takes it for one.
fails env -u PLUMBLINE_PLUGIN_PATH plumbline run site_campaign folder=made/site --out without
says "survey/day2.tracker"

# By hand, from a place of its own.
rm made/site/survey/day2.tracker
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
step plumbline run site.yaml folder=made/site --out result
says "Took part: 6 photographs"
plumbline show result/run.jsonl:network.points > .said
says '"T1"'
took 12 2
