#!/bin/sh
# vdb_print lists the grids with their types, without a warning.
set -eu
. "$(dirname "$0")/skip.sh"
need vdb_print
listing=$(vdb_print -l "$1/medium.vdb" "$1/light.vdb" "$1/half.vdb" 2>&1)
for words in 'Name: index' 'Name: coverage' 'Name: radiance' 'Name: direction' 'Name: emission' 'Name: density' \
  'Type: Tree_vec3s_5_4_3' 'Type: Tree_float_5_4_3' 'vector_type: contravariant relative' 'class: fog volume' 'software: volcaustic'; do
  case $listing in
    *"$words"*) ;;
    *) echo "vdb_print does not say: $words"; echo "$listing"; exit 1 ;;
  esac
done
case $listing in
  *[Ww]arning* | *[Ee]rror*) echo "$listing"; exit 1 ;;
esac
echo "vdb_print lists all grids"
