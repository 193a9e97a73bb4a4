#!/bin/sh
# build_with_pkg_config.sh PREFIX COMPILER SOURCES MESH: builds the README's example (main.cpp) and picture.cpp of the
# folder SOURCES against the volcaustic installed in PREFIX through pkg-config alone, runs them in the current folder,
# the first one on MESH, and checks that it wrote caustic.vdb. Flags: CXXFLAGS.
set -eu
prefix=$1 compiler=$2 sources=$3 mesh=$4

folder=$(dirname "$(find "$prefix" -name volcaustic.pc)")
export PKG_CONFIG_PATH="$folder"

build() {
  # shellcheck disable=SC2046,SC2086 # words are meant to split
  "$compiler" -std=c++20 ${CXXFLAGS:-} "$sources/$1.cpp" $(pkg-config --cflags --libs volcaustic) -o "$2"
}

rm -f caustic.vdb
build main caustic_from_mesh
./caustic_from_mesh "$mesh"
test -s caustic.vdb
build picture picture
./picture
