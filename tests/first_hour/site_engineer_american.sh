#!/usr/bin/env bash
# usage: site_engineer_american.sh PREFIX WORK     An American folder: control in US survey feet, tags in inches (which are asked for in
#                                                  mm), American dates, the crew's file as STAR*NET data
source "$(dirname "$0")/steps.sh"
make_site
cd "$work"
# The crew's file, as STAR*NET has it.
printf 'plumbline: 1\nnodes:\n  source: {use: read.file, with: {file: made/site/survey/total_station.gsi}}\n  survey: {use: read.survey, in: {file: source.file}}\n  written: {use: write.starnet, in: {observations: survey.observations}}\noutputs: {crew.dat: written.file}\n' > crew.yaml
plumbline run crew.yaml --out crew -q
site="$work/Tower East"
mkdir -p "$site/Photos"
cp made/site/images/*.jpg "$site/Photos/"
cp crew/crew.dat "$site/Monday 11-23-2026.dat"
cp made/site/design.ifc made/site/camera.yaml "$site/"
awk -F, 'NR == 1 {print "point,north_usft,east_usft,elev_usft,sigma_mm"; next} {f = 3937 / 1200; printf "%s,%.6f,%.6f,%.6f,0.5\n", $1, f * $3, f * $2, f * $4}' made/site/control.csv > "$site/Control.csv"
sed '1s/tag_size_mm/tag_size_in/; 1!s/,200,0,200,0,/,7.874016,0,200,0,/' made/site/plates.csv > "$site/Plates.csv"

step plumbline campaign init "$site"
says "Recognised:"
fails plumbline campaign check "$site"
says "expected its name to end in _m or _mm"
edit "tag_size in millimetres"
cp made/site/plates.csv "$site/Plates.csv"
step plumbline campaign check "$site"
says "The folder is whole."
step plumbline run site_campaign folder="$site" --out result
says "Took part: 6 photographs"
# The same site in metres and from the instrument's own file gives the same deviations in height, to half a millimetre (a STAR*NET
# file does not tell the faces apart, so the weights differ a little).
plumbline run site_campaign folder=made/site --out metric -q
awk -F';' 'NR == FNR {dz[$1] = $7; next} {n++; d = $7 - dz[$1]; if (!($1 in dz) || d * d > 0.0005 ^ 2) bad++} END {exit bad > 0 || n < 9}' \
  metric/stake_out.csv result/stake_out.csv
took 4 1
