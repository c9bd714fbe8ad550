#!/bin/bash
# bench.sh BUILD: run every benchmark program; wall and CPU seconds side by side.
set -euo pipefail
cd "$(dirname "$0")/.."
shopt -s nullglob
programs=("$1"/bin/bench_*)
[ ${#programs[@]} -gt 0 ] || { echo "bench: no benchmark was built" >&2; exit 1; }
for program in "${programs[@]}"; do
  echo "== $(basename "$program")"
  "$program" --benchmark_color=false
done
