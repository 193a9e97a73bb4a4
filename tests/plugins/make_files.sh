#!/bin/sh
# make_files.sh VOLCAUSTIC DATA OUT: small files of every kind that the program writes.
set -eu
program=$1 data=$2 out=$3
rm -rf "$out"
mkdir -p "$out"
"$program" mesh2vdb "$data/meshes/glass_ball.ply" -o "$out/medium.vdb" --resolution 32 --attenuation 0.2 0.3 0.4 --scattering 0.1 0.1 0.1 --quiet
small="--set volume.resolution=48 --set photons.grid=[96,96] --quiet"
# shellcheck disable=SC2086
"$program" trace "$data/scenes/quickstart.json" $small --parts -o "$out/light.vdb"
# shellcheck disable=SC2086
"$program" trace "$data/scenes/quickstart.json" $small --half -o "$out/half.vdb"
"$program" convert "$out/light.vdb" "$out/light.nvdb" --quiet
# shellcheck disable=SC2086
"$program" render "$data/scenes/quickstart.json" $small --set camera.resolution=[64,48] -o "$out/picture.exr"
