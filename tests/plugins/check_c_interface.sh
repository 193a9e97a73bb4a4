#!/bin/sh
# The C interface, loaded by Python's ctypes.
# Usage: check_c_interface.sh FILES PROGRAM LIBRARY
set -eu
here=$(dirname "$0")
. "$here/skip.sh"
python=/usr/bin/python3 # Debian's modules are for Debian's Python
need "$python"
"$python" -c "import numpy, pyopenvdb" 2>/dev/null ||
  { echo "skipped: python3-numpy or python3-openvdb is not installed"; exit 77; }
out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT
"$python" "$here/check_c_interface.py" "$2" "$3" "$out"
