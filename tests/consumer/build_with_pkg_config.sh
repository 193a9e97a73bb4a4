#!/bin/sh
# build_with_pkg_config.sh PREFIX COMPILER SOURCE MESH: builds SOURCE against the volcaustic installed in PREFIX through
# pkg-config alone, runs it on MESH in the current folder, and checks that it wrote caustic.vdb. Flags: CXXFLAGS.
set -eu
prefix=$1 compiler=$2 source=$3 mesh=$4

folder=$(dirname "$(find "$prefix" -name volcaustic.pc)")
export PKG_CONFIG_PATH="$folder"
rm -f caustic.vdb
# shellcheck disable=SC2046,SC2086 # words are meant to split
"$compiler" -std=c++20 ${CXXFLAGS:-} "$source" $(pkg-config --cflags --libs volcaustic) -o caustic_from_mesh
./caustic_from_mesh "$mesh"
test -s caustic.vdb
