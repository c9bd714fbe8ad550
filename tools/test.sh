#!/bin/bash
# test.sh PRESET [-j N]: run every test of a preset; how many were skipped, then the summary last.
set -uo pipefail
cd "$(dirname "$0")/.."
preset=$1
shift
log="build/$preset/ctest.log"
ctest --preset "$preset" "$@" 2>&1 | tee "$log"
status=${PIPESTATUS[0]}
skipped=$(grep -c '\*\*\*Skipped' "$log")
echo
echo "skipped: $skipped tests (shared data absent, or a tool that the test needs)"
# The failures and the summary once more, so that the count closes the output.
grep -E '^[[:space:]]+[0-9]+ - .*\(' "$log" | grep -v '(Skipped)'
grep -E '^Total Test time' "$log"
grep -E '^[0-9]+% tests passed|^No tests were found' "$log"
exit "$status"
