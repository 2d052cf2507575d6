#!/bin/sh
# usage: headers_alone.sh FOLDER COMPILER [OPTION ...]
# Compiles each header below the folder by itself; without PLUMBLINE_LONG every fortieth of them.
folder=$1
shift
every=40
[ -n "$PLUMBLINE_LONG" ] && every=1
failed=0 count=0
for header in $(cd "$folder" && find . -name '*.hpp' | sort); do
  count=$((count + 1))
  [ $((count % every)) -eq 0 ] || continue
  if ! printf '#include "%s"\n' "${header#./}" | "$@" -fsyntax-only -x c++ -; then
    echo "$header does not compile by itself: it lacks an include"
    failed=1
  fi
done
[ "$count" -gt 100 ] || { echo "found $count headers only"; exit 1; }
exit $failed
