#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# The add-on's cutters: boxes, planes, spheres and closed meshes against the reference and closed forms (cutter.py).
. "$(dirname "$0")/lib.sh"
has_cycles || { skip cutter "$lack"; exit $failed; }
cp "$top"/refscenes/marschner-lobb.tf.json .
"$ISOSHADE" make marschner-lobb --size 24x30x20 -q -o v.nrrd || exit 1
"$ISOSHADE" make constant --size 24x30x20 -q -o c.nrrd || exit 1
# Extinction 0.05 per mm everywhere, white light without directions.
python3 - "$top" <<'PY'
import json, math, sys
def product(a, b): return [[sum(a[i][k] * b[k][j] for k in range(3)) for j in range(3)] for i in range(3)]
def turn(angle, a, b):
    m = [[float(i == j) for j in range(3)] for i in range(3)]
    m[a][a] = m[b][b] = math.cos(angle)
    m[a][b], m[b][a] = -math.sin(angle), math.sin(angle)
    return m
center, half = (2, -1, 1), (7, 8, 5) # as in cutter.py
axes = list(zip(*product(product(turn(-0.4, 0, 1), turn(0.5, 2, 0)), turn(0.3, 1, 2))))
def plane(axis, side, far):
    normal = [side * v for v in axes[axis]]
    return {"normal": normal, "point_mm": [c - far * v for c, v in zip(center, normal)]}
scene = json.load(open(sys.argv[1] + "/refscenes/marschner-lobb.scene.json"))
scene["step_voxels"] = 0.25
json.dump(scene, open("whole.scene.json", "w"))
faces = [plane(axis, side, half[axis]) for axis in range(3) for side in (-1, 1)]
json.dump(dict(scene, clip_planes=faces), open("box.scene.json", "w"))
json.dump(dict(scene, clip_planes=[plane(2, 1, 0)]), open("plane.scene.json", "w"))
json.dump(dict(scene, clip_planes=[plane(2, 1, 0), plane(0, -1, half[0])]), open("two.scene.json", "w"))
opacity = 1 - math.exp(-0.05)
point = {"r": 1, "g": 1, "b": 1, "opacity": opacity}
flat = {"schema": "isoshade.tf/1", "range": [0, 65535], "unit_distance_mm": 1, "color_space": "linear", "table_size": 2,
        "points": [dict(point, value=0), dict(point, value=65535)]}
scene.update(tf=flat, shading={"ambient": 1, "diffuse": 0, "specular": 0, "power": 1})
json.dump(scene, open("constant.scene.json", "w"))
PY
for name in box plane two; do
    check "reference_$name" "$ISOSHADE" render v.nrrd --scene $name.scene.json --size 40 -q -o $name.exr
done
run_on() { # BLEND, arguments
    "${ISOSHADE_BLENDER:-blender}" -b -noaudio --python-exit-code 9 "$1" -P "$top/tests/cutter.py" -- \
        "$top/exporters/blender" "${@:2}" >log 2>&1 || not_ok "blender_came_to_the_end_of_$1" "$(tail -n 3 log)"
    grep -aE '^(not )?ok ' log
    grep -aq '^not ok ' log && failed=1
}
export PYTHONDONTWRITEBYTECODE=1
check it_is_written "$ISOSHADE" export v.nrrd --to blender --scene whole.scene.json --dense -q -o v.blend
run_on v.blend box.exr plane.exr two.exr
check and_a_constant_one "$ISOSHADE" export c.nrrd --to blender --scene constant.scene.json --dense -q -o c.blend
run_on c.blend 0.05
exit $failed
