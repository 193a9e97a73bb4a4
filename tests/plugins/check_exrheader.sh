#!/bin/sh
# OpenEXR's own tool sees the layers, and 32-bit depth and step counts.
set -eu
. "$(dirname "$0")/skip.sh"
need exrheader
header=$(exrheader "$1/picture.exr")
for channel in 'R, 16-bit' 'G, 16-bit' 'B, 16-bit' 'A, 16-bit' 'caustic.R, 16-bit' 'direct.R, 16-bit' 'background.R, 16-bit' \
  'transmittance.R, 16-bit' 'depth.Z, 32-bit' 'steps.Y, 32-bit' 'chromaticities'; do
  case $header in
    *"$channel"*) ;;
    *) echo "exrheader does not say: $channel"; echo "$header"; exit 1 ;;
  esac
done
echo "exrheader sees all layers"
