#!/bin/bash
# sweep.sh PROGRAM [QUALITY]: bind every case of the shared data; each has to succeed with valid
# weights, and with nothing for the Khronos validator that the source did not have (where npm could
# install it). Case by case; all failures are listed before it fails.
set -euo pipefail
cd "$(dirname "$0")/.."
program=$1
quality=${2:-normal}
data=${SKINFIELD_DATA:-../shared/data}
if [ ! -d "$data" ]; then
  echo "sweep: shared data absent: skipped"
  exit 0
fi
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
failed=0

fail() { echo "FAILED $1: $2"; failed=$((failed + 1)); }

# check NAME INPUT SOURCE [OPTIONS...]: SOURCE is what the validator compares with, or empty.
check() {
  local name=$1 input=$2 source=$3 begin=$SECONDS issues
  shift 3
  rm -f "$work"/*
  if ! "$program" bind "$input" "$@" --quality "$quality" --quiet -o "$work/out.glb" \
    --report "$work/report.json" 2>"$work/messages"; then
    fail "$name" "$(tail -n 1 "$work/messages")"
    return
  fi
  if grep -E '"(negative|non_finite)": [^0]' "$work/report.json" ||
    grep -E '"row_sum_error": ([^0-9]|[0-9.]*e-0[0-5]|[0-9.]*[1-9][0-9.]*,?$)' "$work/report.json"; then
    fail "$name" "weights are not valid"
    return
  fi
  local code=0
  # shellcheck disable=SC2086  # an absent source is no argument
  issues=$(node tools/gltf_validate.js "$work/out.glb" $source 2>/dev/null) || code=$?
  # A source that is no glTF may have degenerate triangles of its own.
  [ "$code" != 1 ] || [ -z "$(grep -v TRIANGLE_DEGENERATE <<<"$issues")" ] || {
    fail "$name" "$issues"
    return
  }
  echo "ok     $name ($((SECONDS - begin)) s)"
}

for file in "$data"/rigged/*.gl*; do
  case $(basename "$file") in
    draco_* | meshopt_* | node_animated_*) continue ;;  # refused by name: tests/cli
  esac
  check "$(basename "$file")" "$file" "$file"
done
for skeleton in "$data"/{surface,wild,fem,planar}/*.tgf; do
  stem=${skeleton%.tgf}
  for mesh in "${stem%-points}".{obj,off,ply,stl,mesh}; do
    [ ! -e "$mesh" ] || check "$(basename "$mesh") $(basename "$skeleton")" "$mesh" "" \
      --skeleton "$skeleton"
  done
done
echo "sweep: $failed failed"
[ "$failed" = 0 ]
