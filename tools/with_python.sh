#!/bin/bash
# with_python.sh ARGS...: run a Python that has numpy, Debian's first.
set -euo pipefail
for python in /usr/bin/python3 python3; do
  if command -v "$python" >/dev/null 2>&1 && "$python" -c 'import numpy' 2>/dev/null; then
    exec "$python" "$@"
  fi
done
echo "with_python: no python3 with numpy; run make setup" >&2
exit 1
