#!/usr/bin/env bash
# usage: completion.sh BIN SHARE TEMPLATES     What the tabulator offers behind words that were typed, in bash and, where they are
# installed, in zsh and fish. SHARE is the folder of plumbline.bash, plumbline.zsh and plumbline.fish.
set -euo pipefail
export PATH=$1:$PATH share=$2
source "$share/plumbline.bash"
in_bash() { COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1)); COMPREPLY=(); _plumbline || true; printf '%s\n' "${COMPREPLY[@]}"; }
# zsh's own part, which takes what fits, is left out: a function in place of compadd shows all that it is given.
in_zsh() {
  zsh -f -c 'source $1; shift; words=("$@") CURRENT=$#
             compadd() { [[ $1 == -S ]] && shift 2; shift; print -rl -- "$@" }; _files() { }; _plumbline' zsh "$share/plumbline.zsh" "$@"
}
in_fish() { fish --no-config -c 'source $argv[1]; complete -C (string join " " -- $argv[2..])' "$share/plumbline.fish" "$@" | cut -f1; }
must() {
  local wanted=$1; shift
  for shell in "${shells[@]}"; do
    "in_$shell" "$@" | grep -xF -- "$wanted" >/dev/null || { echo "$shell: '$*' does not offer $wanted, but: $("in_$shell" "$@" | tr '\n' ' ')" >&2; exit 1; }
  done
}
shells=(bash)
for shell in zsh fish; do
  if command -v $shell >/dev/null; then shells+=($shell); else echo "$shell is not installed (scripts/setup --tests): its completion was not tried"; fi
done
must campaign plumbline ca
must site_campaign plumbline run site_c
must folder= plumbline run site_campaign fol
must --overwrite plumbline run --over
must survey.adjust plumbline describe survey.a
must check plumbline campaign ''
must prune plumbline cache ''
must quick plumbline bench q
must serve plumbline help se
for template in "$3"/*/; do must "$(basename "$template")" plumbline new ''; done
