#!/bin/sh
# SPDX-License-Identifier: MIT
# The main job on a real volume: the ch2 MRI of Debian's mricron-data, brain alone.
set -eu
volume=/usr/share/mricron/templates/ch2bet.nii.gz
[ -r "$volume" ] || { echo "demo: $volume is missing; it comes with the Debian package mricron-data" >&2; exit 3; }
./isoshade validate "$volume" --scene refscenes/brain.scene.json --quick --size 192 -o demo
echo "The report of the demo: $PWD/demo/index.html"
./isoshade figure "$volume" --scene refscenes/brain.scene.json --kind levels -q -o demo-figure >/dev/null
echo "Its levels as a figure for print: $PWD/demo-figure/figure.pdf, and .svg, .png and figure-latex.tex"
