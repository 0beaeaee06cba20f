#!/bin/sh
# SPDX-License-Identifier: MIT
# unlit.sh DIR: the scenes of refscenes/suite without their lights, for renderers that have none: those whose point is light,
# and surfaces, are left out.
set -eu
suite=$(dirname "$0")/../../../refscenes/suite
mkdir -p "$1"
for scene in "$suite"/*.scene.json; do
    case $scene in */eight-lights.* | */highlights.* | */surface-*) continue ;; esac
    sed 's/"shading": {[^}]*}/"shading": {"ambient": 1, "diffuse": 0, "specular": 0, "power": 1}/' "$scene" >"$1/$(basename "$scene")"
done
