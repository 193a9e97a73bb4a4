#!/bin/sh
# The Blender add-on from scene to picture: bakes, imports, renders with Cycles, compares with volcaustic's own view.
# Usage: check_blender_addon.sh FILES PROGRAM
set -eu
here=$(dirname "$0")
. "$here/skip.sh"
need blender
home=$(mktemp -d) # no preferences of the person who runs this
trap 'rm -rf "$home"' EXIT
addons=$home/scripts/addons
mkdir -p "$addons"
ln -s "$(cd "$here/../../tools/plugins/blender" && pwd)/volcaustic_blender" "$addons/volcaustic_blender"
HOME=$home BLENDER_USER_SCRIPTS=$home/scripts VOLCAUSTIC=$2 PYTHONDONTWRITEBYTECODE=1 \
  blender --background -t 2 --factory-startup --python-exit-code 1 --python "$here/check_blender_addon.py" -- "$home"
[ -z "${VOLCAUSTIC_KEEP:-}" ] || cp "$home"/*.png "$home"/*.exr "$VOLCAUSTIC_KEEP"
