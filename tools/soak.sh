#!/bin/bash
# soak.sh [-j N]: what is too long for every submission. Stops at the first failure.
set -euo pipefail
cd "$(dirname "$0")/.."
jobs=$(nproc)
[ "${1:-}" != "-j" ] || jobs=$2

step() { echo; echo "== soak: $*"; }

step "tidy of the whole tree"
tools/tidy.sh --all -j "$jobs"

for preset in permissive asan tsan; do
  step "$preset"
  tools/build.sh "$preset" -j "$jobs"
  tools/test.sh "$preset" -j "$jobs"
done

step "an installed tree, and a project that uses it"
tools/package_test.sh build/permissive build/package

step "every case of the shared data at normal quality"
tools/sweep.sh build/permissive/bin/skinfield normal

step "fuzzing, ${FUZZ_SECONDS:-60} s a parser"
tools/build.sh fuzz -j "$jobs"
mkdir -p build/fuzz/corpus
for fuzzer in build/fuzz/bin/fuzz_*; do
  [ -x "$fuzzer" ] || continue
  name=$(basename "$fuzzer")
  echo "-- $name"
  mkdir -p "build/fuzz/corpus/$name"
  "$fuzzer" -max_total_time="${FUZZ_SECONDS:-60}" -timeout=10 -rss_limit_mb=2048 \
    -artifact_prefix="build/fuzz/$name-" -print_final_stats=1 -verbosity=0 \
    "build/fuzz/corpus/$name"
done
echo "soak: all passed"
