#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Label maps through the commands: recognized, by majority, drawn alike, refused where they would be interpolated.
. "$(dirname "$0")/lib.sh"
scene=$top/refscenes/marschner-lobb.scene.json
python3 - <<'PY'
def write(name, value, more="", kind="uchar"):
    data = bytes(value(i % 20, i // 20 % 18, i // 360) for i in range(20 * 18 * 16))
    with open(name, "wb") as file:
        file.write(f"NRRD0004\ntype: {kind}\ndimension: 3\nsizes: 20 18 16\nspacings: 1 1 1\nencoding: raw\n{more}\n".encode() + data)
points = [(4, 5, 6, 9), (15, 4, 4, 2), (6, 13, 5, 5), (14, 12, 11, 30), (5, 5, 12, 7)]
def cell(x, y, z):
    if (x - 10) ** 2 + (y - 9) ** 2 + (z - 8) ** 2 > 64:
        return 0
    return min(points, key=lambda p: (x - p[0]) ** 2 + (y - p[1]) ** 2 + (z - p[2]) ** 2)[3]
write("labels.nrrd", cell)
write("mask.nrrd", lambda x, y, z: cell(x, y, z) > 0)
write("mask.seg.nrrd", lambda x, y, z: cell(x, y, z) > 0, "Segment0_ID:=liver\n")
write("field.nrrd", lambda x, y, z: min(255, (x - 10) ** 2 + (y - 9) ** 2 + (z - 8) ** 2))
PY
says() { "$ISOSHADE" info "${@:2}" | grep -q "$1"; }
check labels_are_recognized says 'label map, 6 labels' labels.nrrd
check intensities_are_not test -z "$("$ISOSHADE" info field.nrrd | grep 'label map')"
check nor_two_values test -z "$("$ISOSHADE" info mask.nrrd | grep 'label map')"
check but_a_segmentation_is_by_its_header says 'label map, 2 labels' mask.seg.nrrd
check and_what_is_said_to_be_one says 'label map, 2 labels' mask.nrrd --labels
check unless_it_is_denied test -z "$("$ISOSHADE" info labels.nrrd --no-labels | grep 'label map')"
refuse both_are_said 2 '--labels and --no-labels' "$ISOSHADE" info labels.nrrd --labels --no-labels
"$ISOSHADE" make sphere --size 8 --type float -o float.nrrd -q
refuse floats_are_no_labels 2 'labels are integers' "$ISOSHADE" info float.nrrd --labels
expect they_are_built 0 "$ISOSHADE" build labels.nrrd --levels 3 --memory 8 -o labels.iso
check which_is_said grep -q 'label map, 6 labels: levels by majority' out
check by_majority grep -q '"scalar_filter": "majority"' labels.iso/pyramid.json
check as_verify_makes_them_again "$ISOSHADE" info labels.iso --verify
refuse no_mean_of_labels 2 'a label map of 6 labels, which --scalar-filter cannot interpolate' "$ISOSHADE" build labels.nrrd --scalar-filter mean -o x.iso
refuse nor_levels_for_a_scene 2 'which --for cannot interpolate' "$ISOSHADE" build labels.nrrd --for "$scene" -o x.iso
for level in 0 1; do
    for with in reference gl; do
        "$ISOSHADE" render labels.iso --scene "$scene" --with $with --level $level --size 24 --step 0.05 -q -o $with.exr >out 2>err || not_ok render "$(cat err)"
    done
    # A step of a twentieth of a voxel misses a face by half of it at most.
    check "both_draw_level_${level}_alike" "$ISOSHADE" compare reference.exr gl.exr --max-rmse 4e-3
done
"$ISOSHADE" render labels.nrrd --no-labels --scene "$scene" --with gl --size 24 --step 0.05 -q -o between.exr >out 2>err
"$ISOSHADE" render labels.nrrd --scene "$scene" --with gl --size 24 --step 0.05 -q -o labels.exr >out 2>err
notice interpolated_they_look_different "$ISOSHADE" compare labels.exr between.exr --max-rmse 4e-3
for with in povray cycles; do
    if [ $with = cycles ] && ! has_cycles; then skip cycles_draws_them_too "$lack"; continue; fi
    "$ISOSHADE" render labels.iso --scene "$scene" --with $with --level 1 --size 24 --step 0.05 -q -o $with.exr >out 2>err || not_ok render "$(cat err)"
    check "${with}_draws_them_too" "$ISOSHADE" compare reference.exr $with.exr --max-rmse 4e-3
done
expect they_go_to_blender 0 "$ISOSHADE" export labels.iso --to blender --scene "$scene" --levels 2 -o x.blend
expect and_to_povray 0 "$ISOSHADE" export labels.iso --to povray --scene "$scene" -o pov
check as_they_are grep -q 'pov_scalar.df3" interpolate 0' pov/pov.inc
check but_directions_are_interpolated grep -q 'pov_dx.df3" interpolate 1' pov/pov.inc
refuse no_finer_box_in_them 2 'is a label map, which --roi would interpolate' "$ISOSHADE" export labels.iso --to blender --scene "$scene" --level 1 --roi 4,4,4,12,12,12 -o y.blend
refuse nor_a_surface 2 'is a label map, which --isosurface would interpolate' "$ISOSHADE" export labels.iso --to povray --scene "$scene" --isosurface 5 -o y
exit $failed
