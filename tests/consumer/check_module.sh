#!/bin/sh
# check_module.sh PREFIX: the program installed in PREFIX, moved to another folder, still finds its module for pictures;
# with the module gone, what needs none of it still works, and a picture ends in one line that names it, with status 3.
set -eu
prefix=$1
unset LD_LIBRARY_PATH

rm -rf moved
cp -r "$prefix" moved
printf 'P3 2 1 255\n255 0 0 0 0 255\n' > picture.ppm
moved/bin/volcaustic convert picture.ppm picture.png
moved/bin/volcaustic compare picture.ppm picture.png

find moved -name volcaustic_imageio.so -exec rm {} +
moved/bin/volcaustic scene new > scene.json
status=0
moved/bin/volcaustic convert picture.ppm other.png 2> words || status=$?
test "$status" -eq 3
test "$(wc -l < words)" -eq 1
grep -q '^picture.ppm: .*volcaustic_imageio.so' words
test ! -e other.png
