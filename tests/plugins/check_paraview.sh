#!/bin/sh
# ParaView opens our volumes and series of them through the reader in tools/plugins/paraview.
# Usage: check_paraview.sh FILES PROGRAM
set -eu
here=$(dirname "$0")
. "$here/skip.sh"
. "$here/display.sh"
need pvpython
need Xvfb # Debian's build draws on displays only
pvpython -c "import pyopenvdb" 2>/dev/null || { echo "skipped: pvpython finds no pyopenvdb (python3-openvdb)"; exit 77; }
out=$(mktemp -d) # and no settings of the person who runs this
server=
trap '[ -z "$server" ] || kill "$server"; rm -rf "$out"' EXIT

start_display "$out"
HOME=$out pvpython "$here/check_paraview.py" "$2" "$1" "$out" 2>&1 | tee "$out/said"
[ -z "${VOLCAUSTIC_KEEP:-}" ] || cp "$out/paraview.png" "$VOLCAUSTIC_KEEP"
grep -q "^ParaView opens" "$out/said" # pvpython may end with 0 after an exception
