#!/usr/bin/env bash
# usage: every_folder.sh BIN WORK DATA     `cd FOLDER && plumbline run PIPELINE folder=.` for every pipeline that takes a folder: what runs leave there is no
# content of it, so the second run, with outputs inside or beside, finds everything as it was. A pipeline that is in no list here fails.
set -uo pipefail
bin=$1 work=$2
rm -rf "$work"
mkdir -p "$work"
cd "$work"
export PATH=$bin:$PATH PLUMBLINE_STORE=$work/.store XDG_CACHE_HOME=$work/.cache
simulate() {  # FOLDER PARAMETERS
  printf 'plumbline: 1\nvars: {seed: 2}\nnodes: {site: {use: simulate.campaign, with: {floors: 1, columns: 3, camera: quick_6mp, images_per_floor: 6%s}}}\noutputs: {site: site.folder}\n' "$2" > make.yaml
  plumbline run make.yaml --out "made_$1" -q && cp -r "made_$1/site" "$1" && chmod -R u+w "$1"
}
simulate site "" && simulate observed ", photographs: observed"
cp -r site found && rm found/campaign.yaml
cp -r site alone && rm -r alone/survey alone/control.csv && sed -i -E '/^(survey|control):/d' alone/campaign.yaml
mkdir epochs  # measured again: distances off by less than 0.1 mm
for day in 1 2 3; do sed -E "s/(31\.\.08\+[0-9]{15})[0-9] /\1$day /" site/survey/total_station.gsi > "epochs/day$day.gsi"; done
printf 'plumbline_campaign: 1\nsurvey: [day1.gsi, day2.gsi, day3.gsi]\n' > epochs/campaign.yaml
plumbline example board > /dev/null
printf 'type: tags\ncolumns: 4\nrows: 5\nmarker: 0.0375\ngap: 0.005\ndictionary: DICT_6X6_1000\n' > board.yaml
tags="detector=aruco family=DICT_6X6_1000"
plumbline run marker_board folder=board $tags tag_size=0.0375 --out known -q > /dev/null
plumbline run calibrate_camera folder=board board=board.yaml --out known_camera -q > /dev/null
# What somebody pointed at: the first corner of each tag, which is no crosshair but a place to look at.
/usr/bin/python3 - <<'POINT'
import json
rows = [f"{image['path']},T{tag['id']},{tag['corners'][0][0]:.1f},{tag['corners'][0][1]:.1f}\n"
        for image in json.load(open("known/observations.json"))["images"] for tag in image["tags"]]
open("clicked.csv", "w").write("image,point,x,y\n" + "".join(rows))
POINT
others=${PLUMBLINE_TEST_DATA:-$3}/blocks/aicon
[[ -d $others ]] && cp -r "$others" aicon && chmod -R u+w aicon

where() {  # the folder and the variables of a pipeline; nothing: it is not tried, because what it takes is not at hand
  case $1 in
    site_campaign | site_campaign_free | site_campaign_joint | site_surfaces | site_crossval | site_survey | check_campaign | survey_campaign) echo site ;;
    site_observations | plan_installation) echo observed ;;
    site_photographs) echo "alone frames.with.datum_sigma=0.005" ;;
    site_loop | site_loop_photographs) echo "site first=true now=2026-05-05T08:00:00Z measured=2026-05-04T08:00:00Z" ;;
    init_campaign) echo found ;;
    epoch_series) echo "epochs movements.with.days=[0,30,61]" ;;
    detect_images | photo_campaign) echo "board $tags" ;;
    photo_surfaces) echo "board $tags" ;;
    marker_board) echo "board $tags tag_size=0.0375" ;;
    calibrate_camera) echo "board board=../board.yaml" ;;
    marker_field) echo "board $tags layout=../known/tags.json camera=../known_camera/camera.yaml tag_size=0.0375" ;;
    measure_targets) echo "board places=../clicked.csv" ;;
    site_survey_scan | site_campaign_scan) ;;  # want a scan of the panels: Building.PanelsScannedLater… has one
    image_block) [[ -d aicon ]] && echo aicon "block.with.free=[]" ;;
    *) echo unknown ;;
  esac
}
missing=0 tried=0
says_what_took_part() {  # THE_RUN, whose words are in `said`
  grep -qE '(^|  )(Took part|Read|read): ' said || { echo "$1 does not say what took part:"; tail -12 said; missing=1; }
}
# A folder of the other kind is refused before anything is searched, with the pipeline that takes it.
refused() {  # PIPELINE FOLDER THE_OTHER
  plumbline run "$1" folder="$2" --out refused < /dev/null > said 2>&1
  grep -q "plumbline run $3 folder=FOLDER" said && ! grep -q "(detect.apriltag)  *[0-9]" said || { echo "$1 folder=$2:"; tail -5 said; missing=1; }
}
refused site_observations site site_campaign
refused site_campaign observed site_observations
for pipeline in $(plumbline list pipelines --json | /usr/bin/python3 -c 'import json, sys; print(*[p["name"] for p in json.load(sys.stdin)])'); do
  # no pipe: with pipefail a grep that ends early would make this pass a pipeline over
  described=$(plumbline describe "$pipeline" --json) || { echo "$pipeline cannot be described"; missing=1; continue; }
  [[ $described == *'"folder"'* ]] || continue
  read -r folder words <<< "$(where "$pipeline")"
  [[ -z $folder ]] && continue
  [[ $folder == unknown ]] && { echo "$pipeline takes a folder and is not tried: add it to this test"; missing=1; continue; }
  codes="" tried=$((tried + 1))
  for out in "" "" "--out ../beside_$pipeline" "--out ."; do
    # shellcheck disable=SC2086
    (cd "$folder" && plumbline run "$pipeline" folder=. $words $out < /dev/null) > said 2>&1
    status=$?
    # An output of the name of one of the folder's own files (site_loop's control.csv) is refused before anything runs.
    [[ -z $codes ]] && says_what_took_part "$pipeline folder=. $words"
    [[ $out == "--out ." ]] && grep -q "outputs would replace what this program did not write" said && continue
    codes+=" $status"
    executed=$(sed -n 's/.*: \([0-9]*\) executed, .*/\1/p' said | tail -1)
    if [[ -n ${codes// /} && $codes == *" "*" "* && ${executed:-99} -gt 1 ]] || grep -q "changed under" said; then  # one: read.tag_family looks at its file each time
      echo "$pipeline folder=. $words $out: $executed executed, exit codes$codes"; tail -5 said; missing=1
    fi
  done
  [[ $(tr ' ' '\n' <<< "$codes" | sed '/^$/d' | sort -u | wc -l) -eq 1 && $codes != *" 1"* && $codes != *" 2"* ]] || { echo "$pipeline folder=. $words: exit codes$codes"; tail -5 said; missing=1; }
done
# Pipelines that take files: each says what it read, too. What wants files that are not at hand (a scan, a COLMAP model, a layout) is passed over by name.
epochs=$work/epochs
files_of() {
  case $1 in
    compare_epochs) echo "before=$epochs/day1.gsi after=$epochs/day2.gsi" ;;
    read_survey | survey_network) echo "file=$epochs/day1.gsi" ;;
    read_design) echo "file=$work/site/design.ifc" ;;
    scan_planes | scan_surfaces | colmap_control | colmap_targets | sfm_control | outlier_search | plan_survey) ;;
    *) echo unknown ;;
  esac
}
for pipeline in $(plumbline list pipelines --json | /usr/bin/python3 -c 'import json, sys; print(*[p["name"] for p in json.load(sys.stdin)])'); do
  described=$(plumbline describe "$pipeline" --json)
  [[ $described == *'"folder"'* || $described != *'"default": null'* ]] && continue
  words=$(files_of "$pipeline")
  [[ -z $words ]] && continue
  [[ $words == unknown ]] && { echo "$pipeline takes files and is not tried: add it to this test"; missing=1; continue; }
  # shellcheck disable=SC2086
  plumbline run "$pipeline" $words --out "files_$pipeline" < /dev/null > said 2>&1
  says_what_took_part "$pipeline $words"
done
((tried >= 15)) || { echo "only $tried pipelines were tried"; missing=1; }
exit $missing
