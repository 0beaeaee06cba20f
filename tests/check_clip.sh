#!/bin/bash
# SPDX-License-Identifier: MIT
# Clip planes of a scene in every renderer; what is wrong in a scene file is named.
. "$(dirname "$0")/lib.sh"
cp "$top"/refscenes/marschner-lobb.tf.json .
with() { sed "s|\"lights\"|\"clip_planes\": [$1], \"lights\"|" "$top/refscenes/marschner-lobb.scene.json"; }
with '{"normal": [0, 1, 0.3], "at": 0.4}, {"normal": [-1, 0.2, 0], "point_mm": [5, 0, 0]}' >cut.scene.json
"$ISOSHADE" make marschner-lobb --size 20x28x17 --spacing 2x2x2.4 -o v.nrrd >/dev/null 2>&1

image() { "$ISOSHADE" render v.nrrd --scene cut.scene.json --size 40 "$@" >/dev/null; }
check gl image --with gl -o gl.exr
check reference image --with reference --quadrature midpoint -o midpoint.exr
check gl_agrees "$ISOSHADE" compare gl.exr midpoint.exr --max-abs 2e-5 --max-rmse 1e-6
check povray image --with povray --intervals 60 -o povray.exr
check reference_as_povray image --with reference --quadrature povray --intervals 60 -o as-povray.exr
check povray_agrees "$ISOSHADE" compare povray.exr as-povray.exr --max-abs 2e-5
check povray_surface image --with povray --isosurface 32768 -o povray-surface.exr
check reference_surface image --with reference --isosurface 32768 -o surface.exr
# All intersections are asked for: with the first alone, what the planes uncover is missing.
check povray_surface_agrees "$ISOSHADE" compare povray-surface.exr surface.exr --max-abs 2e-5
check converged image --with reference -o converged.exr
check cycles image --with cycles --step 0.0625 -o cycles.exr
has_cycles && check cycles_agrees "$ISOSHADE" compare cycles.exr converged.exr --max-rmse 1e-4
"$ISOSHADE" render v.nrrd --scene "$top/refscenes/marschner-lobb.scene.json" --size 40 -o whole.exr >/dev/null 2>&1
expect it_is_not_the_whole_volume 1 "$ISOSHADE" compare gl.exr whole.exr --max-rmse 1e-2

with '{"normal": [0, 0, 0], "at": 0.4}' >wrong.scene.json
expect a_plane_without_normal_is_refused 5 "$ISOSHADE" render v.nrrd --scene wrong.scene.json -o no.exr
check and_named grep -q '"normal" is \[0, 0, 0\]' err
with '{"normal": [0, 1, 0], "at": 0.4, "point_mm": [0, 0, 0]}' >wrong.scene.json
expect a_plane_with_two_places_is_refused 5 "$ISOSHADE" render v.nrrd --scene wrong.scene.json -o no.exr
check and_both_are_named grep -q '"at" and "point_mm"' err
exit $failed
