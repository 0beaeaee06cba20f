#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# causes.sh DIR SIZE STEP SCENE...: how far vtk.js is from the reference's limit, and from its samples of that step in voxels,
# as one thing after another that it does by itself is taken away: a table in Markdown, of 1/255. DIR is that of unlit.sh.
set -eu
here=$(cd "$(dirname "$0")" && pwd) scenes=$(realpath "$1") size=$2 step=$3
isoshade=$(realpath -s "${ISOSHADE:-$here/../../../isoshade}")
shift 3
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
rows=$(sed -n 's/.*"name": "\([^"]*\)".*/\1/p' "$here/causes.json")
draw() { "$isoshade" render v.nrrd --scene "$scene" --size "$size" -o "$@" >/dev/null; }
differ() { "$isoshade" compare "$1" "$2" | awk '/^rmse/ { r = $2 } /^max_abs/ { m = $2 } END { printf " %.3g | %.3g |", 255 * r, 255 * m }'; }
echo "| scene | vtk.js, step 1/$(awk "BEGIN { print 1 / $step }") voxel | RMSE to the limit | largest | RMSE to the samples | largest |"
echo "|---|---|---|---|---|---|"
for name in "$@"; do
    scene=$scenes/$name.scene.json
    "$isoshade" make $(sed -n 's/.*"make": "\([^"]*\)".*/\1/p' "$scene") -o v.nrrd >/dev/null
    draw limit.exr --with reference
    draw samples.exr --with reference --quadrature midpoint --step "$step"
    for row in $rows; do
        draw picture.exr --with "$row" --renderers "$here/causes.json" --step "$step"
        echo "| $name | $row |$(differ limit.exr picture.exr)$(differ samples.exr picture.exr)"
    done
done
