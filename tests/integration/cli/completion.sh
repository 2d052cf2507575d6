#!/usr/bin/env bash
# usage: completion.sh BIN SHARE TEMPLATES     What the tabulator offers behind words that were typed
set -euo pipefail
export PATH=$1:$PATH
source "$2"
offers() { COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1)); COMPREPLY=(); _plumbline || true; printf '%s\n' "${COMPREPLY[@]}"; }
must() { local wanted=$1; shift; offers "$@" | grep -xF -- "$wanted" >/dev/null || { echo "'$*' does not offer $wanted, but: $(offers "$@" | tr '\n' ' ')" >&2; exit 1; }; }
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
