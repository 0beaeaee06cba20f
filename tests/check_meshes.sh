#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# The add-on's meshes: the surface of a sphere, and label maps, in closed form (meshes.py).
. "$(dirname "$0")/lib.sh"
"$ISOSHADE" make sphere --size 20x24x9 --spacing 1x1x2.5 --type float --rotate 1,2,0.5,40 -q -o sphere.nrrd || exit 1
python3 - <<'PY'
nx, ny, nz = 12, 9, 8
def label(x, y, z):
    if 5 <= x < 7 and 2 <= y < 5 and 1 <= z < 5: return 7
    if x >= 8 and y < 4 and z >= 4: return 9
    if x < 4 and y >= 8 and z < 2: return 11
    return 3 if (x - 3) ** 2 + (y - 5) ** 2 + (z - 4) ** 2 < 5 else 0
with open("labels.seg.nrrd", "wb") as file:
    file.write(f"""NRRD0004
type: uchar
dimension: 3
sizes: {nx} {ny} {nz}
space: right-anterior-superior
space directions: (1,0,0) (0,1,0) (0.5,0,2.5)
space origin: (10,20,30)
encoding: raw
Segment0_ID:=a
Segment0_Name:=bone
Segment0_LabelValue:=3
Segment0_Color:=0.9 0.8 0.6
Segment1_ID:=b
Segment1_Name:=liver
Segment1_LabelValue:=7
Segment1_Color:=0.6 0.1 0.1
Segment2_ID:=c
Segment2_Name:=nail
Segment2_LabelValue:=9
Segment2_Color:=0.2 0.7 0.9
Segment3_ID:=d
Segment3_Name:=edge
Segment3_LabelValue:=11
Segment3_Color:=0.9 0.9 0.1

""".encode())
    file.write(bytes(label(x, y, z) for z in range(nz) for y in range(ny) for x in range(nx)))
PY
run_on() { # BLEND, sphere or labels
    "${ISOSHADE_BLENDER:-blender}" -b -noaudio --python-exit-code 9 "$1" -P "$top/tests/meshes.py" -- \
        "$top/exporters/blender" "$2" >log 2>&1 || not_ok "blender_came_to_the_end_of_$1" "$(tail -n 3 log)"
    grep -aE '^(not )?ok ' log
    grep -aq '^not ok ' log && failed=1
}
export PYTHONDONTWRITEBYTECODE=1
check a_sphere_is_written "$ISOSHADE" export sphere.nrrd --to blender --levels 2 --dense -q -o sphere.blend
run_on sphere.blend sphere
check and_labels "$ISOSHADE" export labels.seg.nrrd --to blender --levels 2 -q -o labels.blend
run_on labels.blend labels
exit $failed
