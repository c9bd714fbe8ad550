#!/bin/bash
# demo.sh PROGRAM FOLDER: a sample character, bound, pictured, posed; then what to look at.
set -euo pipefail
cd "$(dirname "$0")/.."
program=$1
out=$2
mkdir -p "$out"

say() { echo "  \$ skinfield $*"; "$program" "$@"; }
say sample gecko -o "$out/gecko.glb"
say bind "$out/gecko.glb" -o "$out/gecko-bound.glb" --report "$out/report.json"
say render "$out/gecko-bound.glb" --yaw 30 --pitch 65 --width 1600 --height 1100 -o "$out/sheet.png"
say render "$out/gecko-bound.glb" --pose demo --kind dominant --bones --yaw 40 --pitch 50 \
  -o "$out/posed.png"

# The validator is for checks only: without it the demo goes on.
if [ -d node_modules/gltf-validator ] && command -v node >/dev/null 2>&1; then
  node tools/gltf_validate.js "$out/gecko-bound.glb" "$out/gecko.glb"
  echo "  the Khronos glTF validator finds nothing in $out/gecko-bound.glb that its source has not"
fi

cat <<TEXT

Look at
  $out/sheet.png        every bone's weights on the gecko; each fades smoothly, no toe lights up
                        with another toe's bone
  $out/posed.png        the gecko posed with these weights, coloured by bone
  $out/gecko-bound.glb  the rigged character; opens in any glTF viewer, its animation plays
  $out/report.json      how good the weights are: gap, row sums, vertices filled, timings
TEXT
