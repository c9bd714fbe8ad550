#!/bin/bash
# build.sh PRESET [-j N] [TARGET...]: configure once, then build into build/PRESET.
set -euo pipefail
cd "$(dirname "$0")/.."
preset=$1
shift
jobs=(-j "$(nproc)")
if [ "${1:-}" = "-j" ]; then
  jobs=(-j "$2")
  shift 2
fi
# An empty launcher in the environment would be taken for a program of no name.
[ -n "${CMAKE_CXX_COMPILER_LAUNCHER:-}" ] || unset CMAKE_CXX_COMPILER_LAUNCHER
if [ ! -f "build/$preset/build.ninja" ]; then
  mkdir -p build
  cmake --preset "$preset" >"build/$preset.configure.log" 2>&1 || {
    cat "build/$preset.configure.log" >&2
    exit 1
  }
fi
targets=()
[ $# -eq 0 ] || targets=(--target "$@")
cmake --build --preset "$preset" "${jobs[@]}" "${targets[@]}"
