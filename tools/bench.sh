#!/bin/bash
# bench.sh BUILD: the whole program, then every benchmark; wall and CPU seconds side by side.
set -euo pipefail
cd "$(dirname "$0")/.."
tools/with_python.sh tools/bench_bind.py --program "$1/bin/skinfield"
for program in "$1"/bin/bench_*; do
  [ -x "$program" ] || continue
  echo "== $(basename "$program")"
  "$program" --benchmark_color=false
done
