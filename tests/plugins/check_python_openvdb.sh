#!/bin/sh
# python3-openvdb reads every grid that its bindings have types for, and sees the names, types and metadata of docs/formats.md.
set -eu
here=$(dirname "$0")
. "$here/skip.sh"
python=/usr/bin/python3 # the one that Debian's python3-openvdb belongs to
[ -x "$python" ] && "$python" -c 'import pyopenvdb' 2>/dev/null || { echo "skipped: python3-openvdb is not installed"; exit 77; }
exec "$python" "$here/check_python_openvdb.py" "$1"
