#!/bin/bash
# package_test.sh BUILD SCRATCH: install BUILD under SCRATCH, then build and run tests/package
# against that tree alone.
set -euo pipefail
source=$(cd "$(dirname "$0")/.." && pwd)
build=$1
scratch=$2
rm -rf "$scratch"
mkdir -p "$scratch"
scratch=$(cd "$scratch" && pwd)
cmake --install "$build" --prefix "$scratch/installed" >"$scratch/install.log"
cmake -S "$source/tests/package" -B "$scratch/consumer" -DCMAKE_BUILD_TYPE=Release \
  -DCMAKE_PREFIX_PATH="$scratch/installed" >"$scratch/configure.log"
cmake --build "$scratch/consumer"
"$scratch/consumer/consumer"
