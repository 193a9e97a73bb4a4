#!/bin/sh
# nanovdb_convert turns our .vdb into .nvdb and our .nvdb into .vdb.
set -eu
. "$(dirname "$0")/skip.sh"
need nanovdb_convert
out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT
nanovdb_convert -f "$1/light.vdb" "$out/theirs.nvdb"
nanovdb_convert -f "$1/medium.vdb" "$out/medium.nvdb"
nanovdb_convert -f "$1/light.nvdb" "$out/ours.vdb"
if command -v vdb_print >/dev/null 2>&1; then
  count=$(vdb_print "$out/ours.vdb" | grep -c 'vec3s\|float')
  [ "$count" -ge 6 ] || { echo "only $count grids came back"; exit 1; }
fi
echo "nanovdb_convert takes our files"
