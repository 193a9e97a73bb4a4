#!/bin/sh
# OpenImageIO's programs open scenes through our plugin.
# Usage: check_openimageio.sh FILES PROGRAM PLUGIN
set -eu
here=$(dirname "$0")
. "$here/skip.sh"
need oiiotool
python=/usr/bin/python3 # Debian's modules are for Debian's Python
need "$python"
"$python" -c "import numpy, OpenImageIO, pyopenvdb" 2>/dev/null ||
  { echo "skipped: python3-openimageio, python3-openvdb or python3-numpy is not installed"; exit 77; }
out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT
"$python" "$here/check_openimageio.py" "$2" "$3" "$out"
