#!/usr/bin/env bash
# usage: reader_by_role.sh BIN WORK     A reader that nobody had when the pipelines were written (in Python, so that nothing is compiled) serves a
# site's folder and single files, found by its role and its parameter `files`
set -euo pipefail
bin=$1 work=$2
/usr/bin/python3 -c 'import numpy, flatbuffers' 2>/dev/null || { echo 'skipped: /usr/bin/python3 has no numpy or flatbuffers'; exit 77; }
rm -rf "$work"
mkdir -p "$work/plugins"
cd "$work"
export PATH=$bin:$PATH PLUMBLINE_STORE=$work/.store XDG_CACHE_HOME=$work/.cache
says() { grep -qF -- "$1" "${2:-said}" || { cat said; echo "'$1' is not in ${2:-what was said}"; exit 1; }; }
run() { plumbline "$@" > said 2>&1 || { cat said; echo "failed: plumbline $*"; exit 1; }; }
fails() { if plumbline "$@" > said 2>&1; then cat said; echo "this had to fail: plumbline $*"; exit 1; fi; }

printf 'plumbline: 1\nvars: {seed: 2}\nnodes: {site: {use: simulate.campaign, with: {floors: 1, columns: 3, camera: quick_6mp, images_per_floor: 6, photographs: observed}}}\noutputs: {site: site.folder}\n' > make.yaml
run run make.yaml --out made
cp -r made/site site && chmod -R u+w site
run run survey_campaign folder=site --out alone
alone=$(sed -n 's/^Took part: \([0-9]*\) readings.*/\1/p' said)

reader() {  # KIND NAMES
  cat > "plugins/$1.node.yaml" <<YAML
plumbline_node: 1
kind: read.$1
role: survey_reader
version: 1
summary: Reads files of a tracker
licence: MIT
run: [/usr/bin/python3, tracker.py]
inputs: {file: {type: plumbline.File/1, cardinality: one, doc: the file}}
outputs: {observations: {type: plumbline.SurveyObservations/1, frames: "frame=building", doc: what it holds}}
parameters:
  files: {kind: text, default: "$2", doc: names of the files that it reads}
YAML
}
cat > plugins/tracker.py <<'PYTHON'
from plumbline_artifacts import Call

import math

call = Call()
file = call.inputs("file", "plumbline.File/1")[0]
gon, set_ups, observations, points = math.pi / 200, [], [], []
for number, line in enumerate(file.content.tobytes().decode().splitlines(), 1):
    words = line.split()
    if words[0] == "AT":
        set_ups.append({"id": words[1], "station": words[1], "instrument_height": float(words[2]), "file": file.name, "line": number})
        continue
    points.append({"id": words[0], "position": (math.nan,) * 3, "roles": "fff"})
    for kind, value in zip(("direction", "zenith_angle", "slope_distance"), (float(words[1]) * gon, float(words[2]) * gon, float(words[3]))):
        observations.append({"kind": kind, "set_up": len(set_ups) - 1, "pointing": len(points) - 1, "from": set_ups[-1]["station"], "to": words[0],
                             "value": value, "target_height": 0.0, "file": file.name, "line": number})
call.commit("observations", "plumbline.SurveyObservations/1", {
    "info": {"format": "tracker"}, "files": [file.name], "points": points, "set_ups": set_ups, "observations": observations, "covariances": [],
    "coordinates": [], "vectors": [], "local_coordinates": [], "skipped": [], "warnings": []})
PYTHON
reader tracker "*.trk"
# What the tracker saw of the known points, from a set-up of its own.
awk -F, 'NR == 1 {print "AT T1 1.500"; next}
  {dx = $2 - 3; dy = $3 + 12; dz = $4 - 1.5; g = 200 / 3.14159265358979; h = sqrt(dx * dx + dy * dy)
   a = g * atan2(dx, dy); if (a < 0) a += 400
   printf "%s %.5f %.5f %.5f\n", $1, a, g * atan2(h, dz), sqrt(h * h + dz * dz)}' made/site/control.csv > tracker.txt
readings=$((3 * ($(wc -l < tracker.txt) - 1)))
cp tracker.txt site/survey/DAY2.TRK   # an instrument's capitals

run run survey_campaign folder=site --out without   # no such plugin: a file of no known kind, which is told and takes no part
grep "In the folder and not read" said | grep -F survey/DAY2.TRK > /dev/null
export PLUMBLINE_PLUGIN_PATH=$work/plugins
fails run site_observations folder=site --out forgotten
says "1 survey file (survey/DAY2.TRK) that nothing names"
fails run survey_campaign folder=site --out forgotten
says "1 survey file (survey/DAY2.TRK) that nothing names"
sed -i 's|^survey: .*|survey: survey/*|' site/campaign.yaml
for pipeline in survey_campaign site_observations; do
  run run $pipeline folder=site --out "both_$pipeline"
  says "$((alone + readings)) readings"
done
says 'survey/DAY2.TRK' both_site_observations/report.html
plumbline show both_survey_campaign/run.jsonl:network.points > said
says '"T1"'
run campaign check site
says "survey: 2 files"
sed -i 's|^survey: .*|survey: survey/*.gsi|' site/campaign.yaml && echo 'unused: survey/DAY2.TRK' >> site/campaign.yaml
run run survey_campaign folder=site --out aside
says "$alone readings"
says "Set aside by 'unused': survey/DAY2.TRK"
cp -r site found && rm found/campaign.yaml
run campaign init found
says "survey: [survey/DAY2.TRK, survey/total_station.gsi]"

cp tracker.txt a.trk && cp tracker.txt b.trk
run run survey_network file=a.trk --out one
says "5 points, 1 set-up, $readings readings"
run run read_survey file=a.trk --out read
says '"kind": "zenith_angle"' read/observations.json
# The reader exchanged while another plugin's is there: what it does not take is named with how to leave it out, and nothing is left unread in silence.
fails run survey_network file=made/site/survey/total_station.gsi survey.use=read.gsi --out forced
says "survey.in.readings=[] leaves it out"
run run survey_network file=made/site/survey/total_station.gsi survey.use=read.gsi 'survey.in.readings=[]' survey.with.angle_unit=~ --out forced
fails run survey_network file=a.trk 'survey.in.readings=[]' --out forced
says "a plugin that reads *.trk: one whose parameter \`files\` names it"
mkdir epochs && cp a.trk b.trk epochs && cp tracker.txt epochs/c.trk
printf 'plumbline_campaign: 1\nsurvey: "*.trk"\n' > epochs/campaign.yaml
plumbline plan epoch_series folder=epochs > said
says "added_readers_read_tracker"

# Another plugin's file of the same name is a question that somebody must answer.
reader rival "*.trk"
fails run survey_network file=a.trk --out rivals
says "a.trk is read by read.rival and by read.tracker"
# Two readers beside rounds: their lists are joined there, too.
printf 'plumbline: 1\ninclude: %s\nrounds: {carry: {x: {first: known.points, next: fit.points}}, until: fit.left_out = 0, most: 3}\nnodes:\n  site: {use: read.folder, with: {folder: site}}\n  campaign: {use: read.survey_campaign, in: {folder: site.folder, readings: added_readings.readings}}\n  known: {use: read.points, with: {file: made/site/control.csv}}\n  same: {use: register.rigid, in: {source: known.points, target: rounds.x}}\n  fit: {use: register.without_worst, in: {points: rounds.x, transform: same.transform}}\noutputs: {readings.json: campaign.survey}\n' \
  "$(plumbline describe survey_campaign --json | /usr/bin/python3 -c 'import json, os, sys; print(os.path.dirname(json.load(sys.stdin)["file"]))')/parts/readers.yaml" > rounds.yaml
run run rounds.yaml --out in_rounds
run run survey_network file=a.trk --out told 'added_files_read_rival.with.files=[*.rival]'
