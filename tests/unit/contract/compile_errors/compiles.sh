#!/usr/bin/env bash
# usage: compiles.sh COMPILER INCLUDES... -- FILE.cpp     compiles FILE; its first line says what the compiler must answer:
#   // ok                what must compile does
#   // error: SENTENCE   the sentence stands in what the compiler says
set -uo pipefail
command=() && while [[ $1 != -- ]]; do command+=("$1"); shift; done
file=$2
answer=$("${command[@]}" -std=c++20 -fsyntax-only "$file" 2>&1)
status=$?
expected=$(head -n 1 "$file")
if [[ $expected == "// ok" ]]; then
  ((status == 0)) && exit 0
elif ((status != 0)) && [[ $answer == *"${expected#// error: }"* ]]; then
  exit 0
fi
printf 'expected: %s\nfound (exit code %d):\n%s\n' "${expected#// }" "$status" "$answer" | head -n 30
exit 1
