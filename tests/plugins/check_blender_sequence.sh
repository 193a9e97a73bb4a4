#!/bin/sh
# Blender plays the sequence that example 05 writes: every frame loads, and none is the one before.
# Usage: check_blender_sequence.sh EXAMPLE RESULTS
set -eu
here=$(dirname "$0")
. "$here/skip.sh"
need blender
home=$(mktemp -d) # no preferences of the person who runs this
trap 'rm -rf "$home"' EXIT
HOME=$home blender --background --factory-startup --python-exit-code 1 --python "$1/play_in_blender.py" -- "$2" "$home/relit.blend"
[ -s "$home/relit.blend" ]
