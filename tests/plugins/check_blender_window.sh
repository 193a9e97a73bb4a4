#!/bin/sh
# The Blender add-on in a window: bakes while Blender goes on, says how far it is, and can be cancelled.
# Usage: check_blender_window.sh FILES PROGRAM
set -eu
here=$(dirname "$0")
. "$here/skip.sh"
. "$here/display.sh"
need blender
need Xvfb
home=$(mktemp -d) # no preferences of the person who runs this
server=
trap '[ -z "$server" ] || kill "$server"; rm -rf "$home"' EXIT
mkdir -p "$home/scripts/addons"
ln -s "$(cd "$here/../../tools/plugins/blender" && pwd)/volcaustic_blender" "$home/scripts/addons/volcaustic_blender"
start_display "$home"
HOME=$home BLENDER_USER_SCRIPTS=$home/scripts VOLCAUSTIC=$2 PYTHONDONTWRITEBYTECODE=1 \
  timeout 200 blender -t 2 --factory-startup --python-exit-code 1 --python "$here/check_blender_window.py" | tee "$home/said"
grep -q "^the window bakes" "$home/said" # an exception in a timer ends nothing
