#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# The command export: what it writes, what it says, and that a refusal leaves nothing behind.
. "$(dirname "$0")/lib.sh"
scene=$top/refscenes/shells.scene.json
size() { stat -c %s "$1"; }

"$ISOSHADE" make shells --size 21x30x17 --spacing 1x1x2 -q -o v.nrrd || exit 1
check vdb_of_three_levels "$ISOSHADE" export v.nrrd --to vdb --levels 3 -q -o v.vdb
check vdb_of_halves "$ISOSHADE" export v.nrrd --to vdb --levels 3 --half -q -o half.vdb
[ "$(size half.vdb)" -lt "$(size v.vdb)" ] && ok halves_are_smaller || not_ok halves_are_smaller "$(size half.vdb) bytes"

"$ISOSHADE" export v.nrrd --to blender --scene "$scene" --levels 2 --adapt --json -q -o two.blend >two.json 2>err &&
    grep -q '"max_color_difference"' two.json && [ -e two_level_0.vdb ] && [ -e two_level_1.vdb ] && [ ! -e two_level_2.vdb ] &&
    ok blend_of_two_levels_tells_the_loss_of_its_ramp || not_ok blend_of_two_levels_tells_the_loss_of_its_ramp "$(cat err)"
check blend_of_one_level "$ISOSHADE" export v.nrrd --to blender --scene "$scene" --level 1 -q -o one.blend
has_cycles && { [ -e one.vdb ] && ok the_grid_has_the_name_of_the_blend || not_ok the_grid_has_the_name_of_the_blend "$(ls)"; }

refuse no_blend_ending 2 ".blend" "$ISOSHADE" export v.nrrd --to blender --scene "$scene" -q -o scene.bld
refuse a_name_that_is_not_utf8 2 "UTF-8" "$ISOSHADE" export v.nrrd --to blender --scene "$scene" -q -o "$(printf 'a\351b.blend')"
check no_scene_is_a_first_one "$ISOSHADE" export v.nrrd --to blender -q -o first.blend
has_cycles && { [ -s first.blend ] && ok it_is_there || not_ok it_is_there "$(ls)"; }
refuse no_folder 3 "nowhere" "$ISOSHADE" export v.nrrd --to blender --scene "$scene" -q -o nowhere/x.blend
refuse no_such_level 5 "levels 0 to" "$ISOSHADE" export v.nrrd --to vdb --level 9 -q -o x.vdb
refuse no_blender 7 "blender" env ISOSHADE_BLENDER=/nonexistent/blender "$ISOSHADE" export v.nrrd --to blender --scene "$scene" -q -o x.blend
refuse a_blender_that_fails 8 "exit code 1" env ISOSHADE_BLENDER=/bin/false "$ISOSHADE" export v.nrrd --to blender --scene "$scene" -q -o x.blend
# A Blender that shows no volumes says so from inside; this one only says it.
cat >blender-5.2 <<'END'
#!/bin/sh
echo "Blender 5.2.2 LTS"
[ "$1" = --version ] && exit
echo "isoshade: shows no volumes: Blender 5.2 of this system is built without NanoVDB: Cycles shows no volumes"
exit 8
END
chmod +x blender-5.2
without=(env ISOSHADE_BLENDER="$dir/blender-5.2" "$ISOSHADE")
refuse a_blender_without_nanovdb_exports_nothing 7 "Blender 5.2 of this system is built without NanoVDB: Cycles shows no volumes" \
    "${without[@]}" export v.nrrd --to blender --scene "$scene" -q -o x.blend
refuse nor_does_it_render 7 "Blender 5.2 of this system is built without NanoVDB" "${without[@]}" render v.nrrd --scene "$scene" --with cycles --size 8 -q -o x.exr
expect the_chart_leaves_it_out 0 env ISOSHADE_POVRAY=/nowhere "${without[@]}" chart v.nrrd --scene "$scene" --size 8 --levels 1 --steps 1 --budget 0 -q -o "$dir/charted"
check by_name grep -q 'left out: cycles: Blender 5.2 of this system is built without NanoVDB' out
expect the_report_calls_it_missing 7 "${without[@]}" validate v.nrrd --scene "$scene" --quick --levels 1 --size 8 --with gl,cycles -q -o "$dir/validated"
check with_that_reason grep -q 'missing: Blender 5.2 of this system is built without NanoVDB' validated/report.json
check sparse_vdb "$ISOSHADE" export v.nrrd --to vdb --scene "$scene" -q -o sparse.vdb
check all_voxels_of_it "$ISOSHADE" export v.nrrd --to vdb --scene "$scene" --dense -q -o dense.vdb
[ $((3 * $(size sparse.vdb))) -lt $((2 * $(size dense.vdb))) ] && ok what_is_not_shown_is_left_out || not_ok what_is_not_shown_is_left_out "$(size sparse.vdb) of $(size dense.vdb) bytes"
check plain_voxels_left_out "$ISOSHADE" export v.nrrd --to vdb --background 0 -q -o plain.vdb
check the_command_is_in_it grep -aq 'isoshade export v.nrrd --to vdb --background 0 -q -o plain.vdb' plain.vdb
refuse a_background_of_all_voxels 2 "--dense and --background exclude each other" "$ISOSHADE" export v.nrrd --to vdb --dense --background 0 -q -o x.vdb
# A folder that a person gave another name is isoshade's still; its files follow the name.
for to in povray paraview; do
    written() { "$ISOSHADE" export v.nrrd --to $to --scene "$scene" --level 2 -q -o "$1"; }
    written first-$to >/dev/null && mv first-$to other-$to
    check a_renamed_folder_of_${to}_is_replaced written other-$to
    check whose_files_have_the_name_${to} test -z "$(find other-$to -name 'first-*')" -a -n "$(find other-$to -name 'other-*')"
    mkdir folder-of-a-person && echo thesis >folder-of-a-person/thesis.txt
    refuse one_without_such_files_is_not_${to} 3 'so it is not replaced' written folder-of-a-person
    rm -r folder-of-a-person
done
refuse all_voxels_for_povray 2 "--dense" "$ISOSHADE" export v.nrrd --to povray --scene "$scene" --dense -q -o x
refuse a_step_for_vdb 2 "--step" "$ISOSHADE" export v.nrrd --to vdb --step 0.5 -q -o x.vdb
refuse grids_for_blender 2 "--grids" "$ISOSHADE" export v.nrrd --to blender --scene "$scene" --grids levels -q -o x.blend
refuse an_unknown_target 2 "must be one of: vdb, nanovdb, blender, povray, pbrt, paraview" "$ISOSHADE" export v.nrrd --to maya -q -o x
refuse adapted_vdb 2 "--adapt" "$ISOSHADE" export v.nrrd --to vdb --adapt -q -o x.vdb
# A folder of temporary files that is too small for a .blend file, of which Blender says "No such file".
mkdir small
in_small_folder() { unshare --map-root-user --mount sh -c 'mount -t tmpfs -o size=256k tmpfs small && exec "$@"' sh "$@"; }
if in_small_folder true 2>/dev/null; then
    refuse no_room_for_temporary_files 8 'temporary folder ($TMPDIR), which has 0.' in_small_folder \
        env TMPDIR="$PWD/small" "$ISOSHADE" export v.nrrd --to blender --scene "$scene" --no-sandbox -q -o small.blend
    check nothing_is_left_of_it test ! -e small.blend
else
    skip no_room_for_temporary_files "no file system may be mounted here"
fi
# A level of two voxels along each axis, of which Cycles once drew a part: the rest of the picture was background, an RMSE of
# .38. The step and the noise of one sample are .004.
if has_cycles; then
    printf '%s' '{"schema": "isoshade.tf/1", "range": "fit", "unit_distance_voxels": 1, "color_space": "srgb", "table_size": 2,
        "points": [{"value": 0, "r": 1, "g": 0.5, "b": 0.2, "opacity": 0.3}, {"value": 1, "r": 1, "g": 1, "b": 1, "opacity": 0.3}]}' >all.tf.json
    "$ISOSHADE" make shells --size 16 -q -o few.nrrd && "$ISOSHADE" build few.nrrd --levels 4 -q -o few.iso >log &&
        for renderer in gl cycles; do
            "$ISOSHADE" render few.iso --level 3 --tf all.tf.json --view iso --size 32 --with $renderer -q -o $renderer.exr >log 2>&1
        done
    check cycles_draws_all_of_a_level_of_few_voxels "$ISOSHADE" compare cycles.exr gl.exr --max-rmse 0.02
fi
exit $failed
