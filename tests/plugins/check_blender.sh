#!/bin/sh
# Blender imports our .vdb as volume objects and loads the grids.
set -eu
here=$(dirname "$0")
. "$here/skip.sh"
need blender
home=$(mktemp -d) # no preferences of the person who runs this
trap 'rm -rf "$home"' EXIT
HOME=$home blender --background --factory-startup --python-exit-code 1 --python "$here/check_blender.py" -- "$1"
