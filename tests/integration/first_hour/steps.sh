# What the scripts of this folder share: `step COMMAND…` is a command that somebody types, `edit WHAT` a change by hand.
# Each script gets the program and an empty folder, and says at its end how much it took.
set -euo pipefail
PLUMBLINE=$1 work=$2
rm -rf "$work"
mkdir -p "$work"
export PLUMBLINE PLUMBLINE_STORE=$work/.store XDG_CACHE_HOME=$work/.cache
plumbline() { "$PLUMBLINE" "$@"; }
commands=0 edits=0
step() { commands=$((commands + 1)); echo "\$ $*"; "$@"; }
edit() { edits=$((edits + 1)); echo "# edit: $*"; }
fails() { commands=$((commands + 1)); echo "\$ $*"; if "$@" >"$work/.said" 2>&1; then cat "$work/.said"; echo "this had to fail" >&2; exit 1; fi; cat "$work/.said"; }
says() { grep -qF -- "$1" "${2:-$work/.said}" || { echo "'$1' is not in ${2:-what was said}" >&2; exit 1; }; }
took() { echo "$commands commands, $edits edits"; [[ $commands -le $1 && $edits -le $2 ]] || { echo "more than $1 commands and $2 edits" >&2; exit 1; }; }
