#!/usr/bin/env bash
# usage: tutorial.sh BIN WORK PAGE     types the commands of the tutorial, one block after the other, into one shell in an empty folder
set -uo pipefail
bin=$1 work=$2 page=$3
rm -rf "$work"
mkdir -p "$work"
cd "$work"
export PATH=$bin:$PATH PLUMBLINE_STORE=$work/.store XDG_CACHE_HOME=$work/.cache
awk '/^```/ {inside = !inside; next} inside' "$page" > typed
bash typed > said 2>&1
missing=0
says() { grep -qF -- "$1" said || { echo "the tutorial did not come to '$1'"; missing=1; }; }
says "check against survey             6     6         0     0     0.03      0.11"   # photographs that somebody took
says "left out: the control of B07, which contradicts the photographs and the other control by 10.0"
says "Recognised:"
says "The folder is whole."
says "Took part:"
says "1 survey file (survey/tuesday.gsi) that nothing names"
says "Set aside by 'unused': survey/tuesday.gsi"
says "poses (pose.opencv)"
says "nodes differ; the results"
[[ -s paper/report.html && -s paper/image_block.html && -s tower/out/site_campaign/report.html && -s opencv/report.html ]] || { echo "a report is missing"; missing=1; }
((missing)) && cat said
exit $missing
