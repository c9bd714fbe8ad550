#!/bin/bash
# tidy.sh [-j N] [--all]: clang-tidy on the sources changed since the last release tag, or on all
# of src/ and apps/ where there is none yet. --all: everything, tests, benchmarks and fuzzers too.
set -euo pipefail
cd "$(dirname "$0")/.."
jobs=$(nproc)
all=no
while [ $# -gt 0 ]; do
  case $1 in
    -j) jobs=$2; shift 2 ;;
    --all) all=yes; shift ;;
    *) echo "tidy.sh: what is $1?" >&2; exit 2 ;;
  esac
done

[ -n "${CMAKE_CXX_COMPILER_LAUNCHER:-}" ] || unset CMAKE_CXX_COMPILER_LAUNCHER
# compile_commands.json comes from configuring alone.
mkdir -p build
cmake --preset release >build/release.configure.log 2>&1 || {
  cat build/release.configure.log >&2
  exit 1
}

listed() { git ls-files --cached --others --exclude-standard -- "$@"; }
if [ "$all" = yes ]; then
  mapfile -t files < <(listed 'src/*.cpp' 'apps/*.cpp' 'tests/*.cpp' 'bench/*.cpp')
elif tag=$(git describe --tags --abbrev=0 --match 'v[0-9]*' 2>/dev/null); then
  mapfile -t files < <(git diff --name-only --diff-filter=d "$tag" -- 'src/*.cpp' 'apps/*.cpp')
else
  mapfile -t files < <(listed 'src/*.cpp' 'apps/*.cpp')
fi
# Only what the build compiles has a command line to be read with.
mapfile -t files < <(for file in "${files[@]}"; do
  [ -f "$file" ] && grep -qF "\"$PWD/$file\"" build/release/compile_commands.json && echo "$file"
done)
[ ${#files[@]} -gt 0 ] || { echo "tidy: nothing to look at"; exit 0; }

log=build/tidy.log
patterns=()
for file in "${files[@]}"; do patterns+=("^$PWD/$file\$"); done
start=$SECONDS
if ! run-clang-tidy -quiet -j "$jobs" -p build/release "${patterns[@]}" >"$log" 2>&1; then
  sed 's/\x1b\[[0-9;]*m//g' "$log" |
    grep -vE '^clang-tidy|^[0-9]+ warnings|^Suppressed|^$' | awk '!seen[$0]++' >&2 || true
  echo "tidy: see above (the whole of it: $log)" >&2
  exit 1
fi
echo "tidy: ${#files[@]} files are clean ($((SECONDS - start)) s)"
