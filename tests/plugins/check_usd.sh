#!/bin/sh
# OpenUSD's own Python opens the stages that `trace --usd` and `convert` write.
# Usage: check_usd.sh FILES PROGRAM PYTHON     PYTHON: of tools/dev/python_tools; the one on the path where it is absent
set -eu
here=$(dirname "$0")
. "$here/skip.sh"
python=$3
[ -x "$python" ] || python=python3
need "$python"
"$python" -c "from pxr import Usd" 2>/dev/null || { echo "skipped: OpenUSD's Python package (usd-core) is not installed"; exit 77; }
out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT
"$python" "$here/check_usd.py" "$2" "$1" "$out"
