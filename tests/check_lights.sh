#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# The two materials of an exported .blend: the physical one conserves light (white furnace) and takes as much of it away as
# the exact one (a slab's shadow); lamps and world light it; colors of suns light the exact one. By one Blender, lights.py.
. "$(dirname "$0")/lib.sh"

# A box that is the same everywhere: 30 % of the light ends in 4 mm, so that a way of 8 mm leaves .49 of it.
cat >slab.scene.json <<'JSON'
{"schema": "isoshade.scene/1", "image": {"width": 8, "height": 8},
 "camera": {"projection": "orthographic", "fit": true, "direction": [0, 0, -1], "up": [0, 1, 0], "margin": 0.95},
 "lights": [{"direction": [0, 0, 1], "space": "world", "intensity": 0.5}],
 "shading": {"ambient": 0.2, "diffuse": 0.8, "specular": 0, "power": 30}, "background": [0, 0.1, 0], "step_voxels": 0.25,
 "tf": {"schema": "isoshade.tf/1", "range": "fit", "unit_distance_mm": 4, "color_space": "linear", "table_size": 2,
  "points": [{"value": 0, "r": 1, "g": 1, "b": 1, "opacity": 0.3}, {"value": 1, "r": 1, "g": 1, "b": 1, "opacity": 0.3}]}}
JSON
"$ISOSHADE" make shells --size 8 -q -o v.nrrd
check it_may_open_with_the_physical_material "$ISOSHADE" export v.nrrd --to blender --scene slab.scene.json --material physical -q -o slab.blend
refuse an_unknown_material 2 'unknown material "glass", must be one of: exact, physical' "$ISOSHADE" export v.nrrd --to blender --scene slab.scene.json --material glass -q -o x.blend
refuse a_material_for_vdb 2 '--material cannot be used with --to vdb' "$ISOSHADE" export v.nrrd --to vdb --material exact -q -o x.vdb
if has_cycles; then
    "${ISOSHADE_BLENDER:-blender}" -b --factory-startup -noaudio --python-exit-code 9 slab.blend -P "$top/tests/lights.py" >log 2>&1 ||
        not_ok blender_came_to_the_end "$(tail -n 3 log)"
    grep -aE '^(not )?ok ' log
    grep -aq '^not ok ' log && failed=1
else
    skip it_is_lit "$lack"
fi
exit $failed
