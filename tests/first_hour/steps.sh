# What the scripts of this folder share: `step COMMAND…` is a command that somebody types, `edit WHAT` a change by hand.
# Each script gets the folder of an installation and an empty one, and says at its end how much it took.
set -euo pipefail
prefix=$1 work=$2
rm -rf "$work"
mkdir -p "$work"
export PATH=$prefix/bin:$PATH PLUMBLINE_STORE=$work/.store XDG_CACHE_HOME=$work/.cache LC_ALL=C.UTF-8
unset PLUMBLINE PLUMBLINE_PLUGIN_PATH
commands=0 edits=0
# What it says is kept in .said for says(); counted in this shell, so nothing of it stands behind a pipe.
step() { commands=$((commands + 1)); echo "\$ $*"; "$@" 2>&1 | tee "$work/.said"; }
edit() { edits=$((edits + 1)); echo "# edit: $*"; }
fails() { commands=$((commands + 1)); echo "\$ $*"; if "$@" >"$work/.said" 2>&1; then cat "$work/.said"; echo "this had to fail" >&2; exit 1; fi; cat "$work/.said"; }
says() { grep -qF -- "$1" "${2:-$work/.said}" || { echo "'$1' is not in ${2:-what was said}" >&2; exit 1; }; }
took() { echo "$commands commands, $edits edits"; [[ $commands -le $1 && $edits -le $2 ]] || { echo "more than $1 commands and $2 edits" >&2; exit 1; }; }
needs_numpy() { /usr/bin/python3 -c 'import numpy, flatbuffers' 2>/dev/null || { echo 'skipped: /usr/bin/python3 has no numpy or flatbuffers'; exit 77; }; }
# A simulated site in $work/made/site: what a site hands over, and no part of what is counted. Further parameters as in YAML.
make_site() {
  printf 'plumbline: 1\nvars: {seed: 2}\nnodes:\n  site: {use: simulate.campaign, with: {floors: 1, columns: 3, camera: quick_6mp, images_per_floor: 6%s}}\noutputs: {site: site.folder}\n' "${1:-}" > "$work/make.yaml"
  plumbline run "$work/make.yaml" --out "$work/made" -q
  chmod -R u+w "$work/made/site"
}
