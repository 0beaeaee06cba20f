#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# isoshade-lab convergence and isosurfaces: two renderers down to one limit; charts; messages; nothing half-written.
. "$(dirname "$0")/../lib.sh"
scene=$top/refscenes/marschner-lobb.scene.json
"$ISOSHADE" make marschner-lobb --size 20x28x17 --spacing 1x1x2.5 --rotate 1,2,3,40 -o v.nrrd -q || exit 1

expect gl_and_povray_converge 0 "$LAB" convergence v.nrrd --scene "$scene" --size 24 --steps 3 --json -o conv
check both_agree_with_the_reference test "$(grep -c '"agrees": true' out)" = 2
has_files the_chart_has conv convergence.csv convergence.gp convergence.svg style.gp
expect an_unknown_renderer_is_refused 2 "$LAB" convergence v.nrrd --scene "$scene" --with gl,radiance
expect one_step_is_refused 2 "$LAB" convergence v.nrrd --scene "$scene" --steps 1
expect a_scene_that_is_not_there_is_refused 3 "$LAB" convergence v.nrrd --scene none.json
mkdir mine && touch mine/file
expect a_foreign_folder_is_not_replaced 3 "$LAB" convergence v.nrrd --scene "$scene" --with gl --size 8 --steps 2 -o mine
check and_keeps_its_files test -e mine/file

# 16-bit values: the middle of the range
for with in reference gl povray; do
    expect "an_isosurface_by_$with" 0 "$ISOSHADE" render v.nrrd --scene "$scene" --with $with --size 32 --isosurface 32768 -o $with.exr
done
expect agrees 0 "$ISOSHADE" compare reference.exr povray.exr --max-abs 2e-5
# Floats: where the surface is glancing the place of the hit keeps fewer digits.
expect agrees_in_gl 0 "$ISOSHADE" compare reference.exr gl.exr --max-abs 1e-3 --max-rmse 1e-5
expect a_value_that_is_not_a_number_is_refused 2 "$ISOSHADE" render v.nrrd --scene "$scene" --with povray --isosurface x -o no.exr
expect flipped_directions_render 0 "$ISOSHADE" render v.nrrd --scene "$scene" --size 16 --with gl --shading-from flipped -o flipped.exr -q
expect a_renderer_that_cannot_flip_directions_says_so 2 "$ISOSHADE" render v.nrrd --scene "$scene" --with povray --shading-from flipped -o no.exr
expect a_renderer_without_isosurfaces_says_so 2 "$ISOSHADE" render v.nrrd --scene "$scene" --with cycles --isosurface 3 -o no.exr
expect an_exported_isosurface 0 "$ISOSHADE" export v.nrrd --to povray --scene "$scene" --isosurface 32768 -o surface
check has_its_object grep -q 'isosurface {' surface/surface.inc
check nothing_half_written_is_left test -z "$(find . -mindepth 1 -name '.*' ! -name .isoshade-files; ls no.exr 2>/dev/null)"
exit $failed
