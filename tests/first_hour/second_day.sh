#!/usr/bin/env bash
# usage: second_day.sh PREFIX WORK     Photographs arrive while the program watches; a page shows it; only what is new is detected
source "$(dirname "$0")/steps.sh"
make_site
cd "$work"
mkdir site
cp -r made/site/* site/
mkdir later
mv site/images/F01-06.jpg later/
plumbline watch site_campaign folder=site --out out/site --quiet-for 0.3 --runs 2 > watched 2>&1 &
watch=$!
commands=$((commands + 1))
for i in $(seq 600); do [[ -s out/site/run.jsonl ]] && grep -q run_end out/site/run.jsonl && break; sleep 0.1; done
plumbline serve out > served 2>&1 &
serve=$!
commands=$((commands + 1))
for i in $(seq 100); do grep -q http served && break; sleep 0.1; done
address=$(head -1 served)
token=${address##*token=} base=${address%%/\?*}
ask() { curl -sf -H "Authorization: Bearer $token" "$base$1"; }
ask /api/runs > .said
says '"id":"site"'
cp later/F01-06.jpg site/images/
wait $watch || { cat watched; exit 1; }
says "changed: " watched
says "1 of 6 items" watched
ask '/api/run?id=site' > .said
says '"items_executed":1'
ask /files/site/report.html > .said
says '<html'
kill $serve
wait $serve || true
took 2 0
