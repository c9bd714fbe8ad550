#!/bin/bash
# setup.sh GROUP...: install what is missing for build, tidy, validate, python, fuzz.
# Does nothing, and says nothing, when all is there. Debian's apt, and npm for the glTF validator.
set -euo pipefail
cd "$(dirname "$0")/.."

has_package() { [ "$(dpkg-query -W -f='${db:Status-Status}' "$1" 2>/dev/null)" = installed ]; }

missing=()
need_package() {
  local package
  for package in "$@"; do has_package "$package" || missing+=("$package"); done
}
# A tool may come from anywhere: only its absence calls for Debian's package.
need_tool() { command -v "$1" >/dev/null 2>&1 || missing+=("${2:-$1}"); }

for group in "$@"; do
  case $group in
    build)
      need_tool g++
      need_tool cmake
      need_tool ninja ninja-build
      need_package libembree-dev libtbb-dev libeigen3-dev libsuitesparse-dev \
        nlohmann-json3-dev libcli11-dev libfmt-dev libpng-dev zlib1g-dev libnanoflann-dev \
        libpugixml-dev libgtest-dev libbenchmark-dev libtet1.5-dev libcgal-dev libgmp-dev \
        libmpfr-dev libmetis-dev
      ;;
    tidy)
      need_tool clang-format
      need_tool clang-tidy
      need_tool run-clang-tidy clang-tidy
      ;;
    fuzz)
      need_tool clang++ clang
      ;;
    validate)
      need_tool node nodejs
      need_tool npm
      ;;
    python)
      tools/with_python.sh -c 'import numpy, scipy, matplotlib' 2>/dev/null ||
        missing+=(python3 python3-numpy python3-scipy python3-matplotlib)
      ;;
    *)
      echo "setup.sh: no group named $group" >&2
      exit 2
      ;;
  esac
done

if [ ${#missing[@]} -gt 0 ]; then
  if ! command -v apt-get >/dev/null 2>&1; then
    echo "setup: this is no Debian; please install what these packages hold: ${missing[*]}" >&2
    exit 1
  fi
  as_root=()
  if [ "$(id -u)" -ne 0 ]; then
    as_root=(sudo)
    command -v sudo >/dev/null 2>&1 || {
      echo "setup: missing ${missing[*]}; run as root: apt-get install ${missing[*]}" >&2
      exit 1
    }
  fi
  echo "setup: installing with apt: ${missing[*]}"
  apt=(env DEBIAN_FRONTEND=noninteractive apt-get -o DPkg::Lock::Timeout=300 -q -y)
  for try in 1 2 3; do
    if "${as_root[@]}" "${apt[@]}" update >/dev/null &&
      "${as_root[@]}" "${apt[@]}" install --no-install-recommends "${missing[@]}" >/dev/null; then
      break
    fi
    [ "$try" -lt 3 ] || {
      echo "setup: apt could not install ${missing[*]}" >&2
      exit 1
    }
    echo "setup: apt failed; another try in $((10 * try)) s" >&2
    sleep $((10 * try))
  done
fi

case " $* " in
  *" validate "*)
    # npm leaves a copy of the lock file behind: older than ours means that ours has changed.
    if [ ! -f node_modules/.package-lock.json ] ||
      [ package-lock.json -nt node_modules/.package-lock.json ]; then
      echo "setup: installing the glTF validator with npm into node_modules/"
      # npm tries again by itself. The build and every other test do without the validator; tests
      # that need it say so and skip.
      npm ci --no-audit --no-fund --loglevel=error ||
        echo "setup: npm could not install the glTF validator: its checks will be skipped" >&2
    fi
    ;;
esac
