#!/bin/bash
# tidy.sh [-j N] [--all] [--time-limit S]: clang-tidy on the sources changed since the last release
# tag, or on all of src/ and apps/ where there is none yet, those changed last first. --all:
# everything, tests and benchmarks too. Fails on any finding; files for which the time did not last
# are counted, not judged.
set -euo pipefail
cd "$(dirname "$0")/.."
jobs=$(nproc)
all=no
limit=0
while [ $# -gt 0 ]; do
  case $1 in
    -j) jobs=$2; shift 2 ;;
    --all) all=yes; shift ;;
    --time-limit) limit=$2; shift 2 ;;
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
  [ -f "$file" ] && grep -qF "\"$PWD/$file\"" build/release/compile_commands.json &&
    echo "$(git log -1 --format=%ct -- "$file") $file"
done | sort -k1,1nr -k2 | cut -d' ' -f2)
[ ${#files[@]} -gt 0 ] || { echo "tidy: nothing to look at"; exit 0; }

logs=build/tidy
rm -rf "$logs"
mkdir -p "$logs"
start=$SECONDS
tidy_one() {
  local log="$1/${2//\//_}.log"
  local status=0
  clang-tidy --quiet -p build/release "$2" >"$log.part" 2>/dev/null || status=$?
  [ "$status" -lt 128 ] || return "$status"  # killed: the time is over
  [ "$status" = 0 ] || echo "$2" >>"$1/failed"
  mv "$log.part" "$log"
}
export -f tidy_one
command=(xargs -0 -P "$jobs" -n 1 bash -c 'tidy_one "$0" "$1"' "$logs")
[ "$limit" = 0 ] || command=(timeout --kill-after=10 "$limit" "${command[@]}")
status=0
printf '%s\0' "${files[@]}" | "${command[@]}" || status=$?
done_files=$(find "$logs" -name '*.log' | wc -l)
if [ -s "$logs/failed" ]; then
  cat "$logs"/*.log | awk '!seen[$0]++' >&2
  echo "tidy: findings in $(tr '\n' ' ' <"$logs/failed")" >&2
  exit 1
fi
[ "$status" = 0 ] || [ "$limit" != 0 ] || exit "$status"
echo "tidy: $done_files of ${#files[@]} files looked at, clean ($((SECONDS - start)) s)"
