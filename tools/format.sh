#!/bin/bash
# format.sh [--check]: clang-format over every C++ file that git knows or could know.
set -euo pipefail
cd "$(dirname "$0")/.."
mapfile -t files < <(git ls-files --cached --others --exclude-standard -- '*.h' '*.cpp' |
  while read -r file; do [ ! -f "$file" ] || echo "$file"; done)
[ ${#files[@]} -gt 0 ] || exit 0
if [ "${1:-}" = "--check" ]; then
  log=$(mktemp)
  trap 'rm -f "$log"' EXIT
  if ! printf '%s\0' "${files[@]}" | xargs -0 -n 16 -P "$(nproc)" \
    clang-format --dry-run -Werror 2>"$log"; then
    grep -E '^[^ ]+:[0-9]+:[0-9]+: ' "$log" | cut -d: -f1 | sort | uniq -c >&2
    echo "format: these files are not as .clang-format wants them; run make format" >&2
    exit 1
  fi
  echo "format: ${#files[@]} files are as .clang-format wants them"
else
  printf '%s\0' "${files[@]}" | xargs -0 -n 16 -P "$(nproc)" clang-format -i
fi
