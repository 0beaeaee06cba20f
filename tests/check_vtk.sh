#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# VTK as a renderer: its fixed-point mapper is within a step of 8 bits of the reference; what it is by itself is not; and
# lights are refused by name.
. "$(dirname "$0")/lib.sh"
export ISOSHADE_RENDERERS=$top/tests/peers/vtk.json
python_with vtkmodules,numpy
"$python" -c "import vtkmodules, numpy" 2>/dev/null || { skip all "python3-vtk9 is not installed"; exit 0; }
"$ISOSHADE" make marschner-lobb --size 19x21x11 --spacing 1x1x2 --rotate 1,2,3,40 -o v.nrrd -q >/dev/null
tf='"tf": {"schema": "isoshade.tf/1", "range": "fit", "unit_distance_voxels": 2, "color_space": "linear", "table_size": 256,
 "points": [{"value": 0, "r": 0.05, "g": 0.15, "b": 0.6, "opacity": 0}, {"value": 0.3, "r": 0.05, "g": 0.3, "b": 0.8, "opacity": 0},
            {"value": 0.5, "r": 0.9, "g": 0.6, "b": 0.2, "opacity": 0.5}, {"value": 1, "r": 0.6, "g": 0.05, "b": 0.05, "opacity": 0.05}]}'
scene() { # CAMERA SHADING MORE
    echo "{\"schema\": \"isoshade.scene/1\", \"image\": {\"width\": 30, \"height\": 24}, \"camera\": {$1}, $3
     \"lights\": [{\"direction\": [-0.4, 0.6, 1], \"space\": \"camera\", \"intensity\": 1}], \"shading\": {$2},
     \"background\": [0.1, 0.2, 0.3], \"step_voxels\": 0.25, $tf}"
}
out='"projection": "perspective", "fit": true, "direction": [1, 2, -1.6], "up": [0, 0, 1], "margin": 0.8, "fov_y_deg": 30'
unlit='"ambient": 0.8, "diffuse": 0, "specular": 0, "power": 1'
scene "$out" "$unlit" '"clip_planes": [{"normal": [1, 0.3, 0], "at": 0.3}],' > clipped.scene.json
scene "$out" '"ambient": 0.3, "diffuse": 0.6, "specular": 0.2, "power": 10' "" > lit.scene.json
draw() { "$ISOSHADE" render v.nrrd --scene "$1.scene.json" --with "$2" -o "$1-$2.exr" -q >log 2>&1; } # SCENE RENDERER
for r in reference vtk; do draw clipped $r || not_ok "clipped_by_$r" "$(tail -n 1 log)"; done
# A step of 8 bits, though each of its own pictures is ten of them off: cut steps, products that are rounded up.
check within_a_step_of_8_bits_with_clip_planes "$ISOSHADE" compare clipped-reference.exr clipped-vtk.exr --max-abs 0.0039216 --max-rmse 0.001

# ---- VTK by itself: 8 bits, a box from center to center, one picture (validate refuses it by the slab: doc/guide/renderers.md) ----
cat > as-is.json <<END
{"schema": "isoshade.renderers/1", "renderers": [{"name": "vtk-as-is", "command": ["$python", "$top/tests/peers/render_vtk.py", "--as-is"],
 "tier": "8 bits", "can": ["orthographic", "clip planes"], "limits": {"rmse": 0.004, "max_abs": 0.004}, "why": "8 bits"}]}
END
"$ISOSHADE" render v.nrrd --scene clipped.scene.json --with vtk-as-is --renderers "$ISOSHADE_RENDERERS,as-is.json" -o as-is.exr -q >log 2>&1
check it_draws_by_itself test -s as-is.exr
notice by_itself_it_is_far_off "$ISOSHADE" compare clipped-reference.exr as-is.exr --max-abs 0.1

# ---- unsupported features are refused by name ----
printf 'NRRD0004\ntype: uchar\ndimension: 3\nsizes: 2 2 2\nspace: right-anterior-superior\nspace directions: (1,0,0) (0.5,1,0) (0,0,1)\nspace origin: (0,0,0)\nencoding: raw\n\nabcdefgh' > sheared.nrrd
"$ISOSHADE" render sheared.nrrd --scene clipped.scene.json --with vtk -o x.exr -q >log 2>&1
check a_sheared_grid grep -q "a sheared grid" log
lights_by() { refuse "lights_by_$1" "$2" "$3" "$ISOSHADE" render v.nrrd --scene lit.scene.json --with "$1" -o x.exr -q; }
lights_by vtk 2 "lights are rendered by"
refuse without_a_display_that_is_the_reason 7 "needs a display" env -u DISPLAY "$ISOSHADE" render v.nrrd --scene clipped.scene.json --with vtk-gpu -o x.exr -q
exit $failed
