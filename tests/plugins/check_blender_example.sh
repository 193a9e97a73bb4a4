#!/bin/sh
# The example of Blender's add-on, small. Usage: check_blender_example.sh FILES PROGRAM EXAMPLE
set -eu
. "$(dirname "$0")/skip.sh"
need blender
home=$(mktemp -d)
trap 'rm -rf "$home"' EXIT
HOME=$home VOLCAUSTIC=$2 PYTHONDONTWRITEBYTECODE=1 \
  blender --background -t 2 --factory-startup --python-exit-code 1 --python "$3/main.py" -- "$home/picture.png" 96 4
