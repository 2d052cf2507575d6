#!/usr/bin/env bash
# usage: late.sh COMMAND ...     runs a test of minutes, unless the time for tests is over ($PLUMBLINE_TESTS_UNTIL, seconds since 1970): then 77, skipped
if [[ -n "${PLUMBLINE_TESTS_UNTIL:-}" ]] && (($(date +%s) > PLUMBLINE_TESTS_UNTIL)); then
  echo "NOT RUN: the time that scripts/test was given (PLUMBLINE_TEST_MINUTES) was over before this test began"
  exit 77
fi
exec "$@"
