#!/bin/sh
# The Blender add-on in newer Blenders than Debian's, which are Python modules here (tools/dev/python_tools --blender).
# Usage: check_blender_versions.sh FILES PROGRAM BLENDERS
set -eu
here=$(cd "$(dirname "$0")" && pwd)
found=""
for python in "$3"/*/bin/python; do
  [ -e "$(dirname "$python")/../ready" ] || continue
  found=yes
  home=$(mktemp -d)
  trap 'rm -rf "$home"' EXIT
  mkdir -p "$home/scripts/addons"
  ln -s "$here/../../tools/plugins/blender/volcaustic_blender" "$home/scripts/addons/volcaustic_blender"
  HOME=$home BLENDER_USER_SCRIPTS=$home/scripts VOLCAUSTIC=$2 PYTHONDONTWRITEBYTECODE=1 \
    "$python" "$here/check_blender_addon.py" -- "$home"
  rm -rf "$home"
done
[ -n "$found" ] || { echo "skipped: no newer Blender is installed (tools/dev/python_tools --blender)"; exit 77; }
