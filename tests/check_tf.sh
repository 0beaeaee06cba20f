#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# The command tf, and adapted transfer functions in render and export.
. "$(dirname "$0")/lib.sh"
tf=$top/refscenes/shells.tf.json scene=$top/refscenes/shells.scene.json
"$ISOSHADE" make shells --size 40x44x36 --type uint8 -o shells.nrrd -q || exit 1
"$ISOSHADE" build shells.nrrd -o shells.iso --levels 3 -q >/dev/null || exit 1
"$ISOSHADE" build shells.nrrd -o coded.iso --levels 2 --code region48 -q >/dev/null || exit 1

check adapt_writes_a_tf_a_level "$ISOSHADE" tf adapt shells.iso --tf "$tf" -o shells --always -q
[ -s shells_level_1.tf.json ] && [ -s shells_level_2.tf.json ] && ok adapted_files_are_there || not_ok adapted_files_are_there "$(ls)"
[ -s shells.iso/level_1_joint8.nrrd ] && ok histograms_are_kept_in_the_pyramid || not_ok histograms_are_kept_in_the_pyramid "$(ls shells.iso)"
check kept_histograms_give_the_same_tf bash -c '"$ISOSHADE" tf adapt shells.iso --tf "$0" --level 1 -o again.tf.json --always -q && cmp again.tf.json shells_level_1.tf.json' "$tf"
# With its histogram a pyramid is adapted to without its samples; without it they are needed.
cp -r shells.iso lame.iso && : >lame.iso/level_0.nrrd && rm lame.iso/level_2_joint8.nrrd
check kept_histograms_need_no_samples bash -c '"$ISOSHADE" tf adapt lame.iso --tf "$0" --level 1 -o lame.tf.json --always -q && cmp lame.tf.json shells_level_1.tf.json' "$tf"
refuse missing_histograms_need_samples 4 'level_0.nrrd' "$ISOSHADE" tf adapt lame.iso --tf "$tf" --level 2 -o y.tf.json -q
refuse no_name 2 '-o is ""' "$ISOSHADE" tf adapt shells.iso --tf "$tf" -o ''
refuse folder_for_a_name 2 'must be the name of a file' "$ISOSHADE" tf adapt shells.iso --tf "$tf" -o shells.iso/
check twelve_bits "$ISOSHADE" tf adapt shells.iso --tf "$tf" --bits 12 --level 1 -o twelve.tf.json -q
check json_names_the_errors bash -c '"$ISOSHADE" tf adapt shells.iso --tf "$0" --level 1 -o x.tf.json --json | grep -q "\"rms_adapted\""' "$tf"
# Optimized by rendering: never farther by the pictures that judge it, and a file as any other.
expect a_tf_is_optimized 0 "$ISOSHADE" tf adapt shells.iso --scene "$scene" --level 1 --optimize -o best.tf.json --json
check it_is_nearer_or_the_same python3 -c 'import json
level = json.load(open("out"))["levels"][0]
(before, after), rmse = level["optimized"]["ssim_dissimilarity"], level["optimized"]["rmse"]
assert 0 < after <= 0.98 * before and rmse[1] <= rmse[0], level'
expect it_is_drawn 0 "$ISOSHADE" render shells.iso --tf best.tf.json --level 1 --size 32 --with cpu -o best.exr -q
"$ISOSHADE" tf adapt coded.iso --scene "$scene" --level 1 -o coded.tf.json -q >/dev/null # keeps its histogram
refuse only_linear_codes_are_optimized 5 'build with --code fit' "$ISOSHADE" tf adapt coded.iso --scene "$scene" --level 1 --optimize -o no.tf.json -q
expect bound_is_printed_before_anything_is_drawn 0 "$ISOSHADE" tf bound shells.iso --scene "$scene" --level 1 --size 24 -q
grep -q '^level 1  RMSE at most 0\.[0-9]*, with --adapt 0\.[0-9]*$' out && ok bound_names_both_tfs || not_ok bound_names_both_tfs "$(cat out)"
refuse bound_needs_a_volume 2 'usage: isoshade tf bound' "$ISOSHADE" tf bound -q
# A scene that names the adapted file and --adapt are the same picture.
sed "s/\"shells.tf.json\"/\"shells_level_1.tf.json\"/" "$scene" >adapted.scene.json
cp "$tf" shells.tf.json
cp "$scene" own.scene.json
render() { "$ISOSHADE" render shells.iso --level 1 --size 64 --with reference --quadrature midpoint -q "$@" >/dev/null; }
if render --scene own.scene.json --adapt --always -o a.exr && render --scene adapted.scene.json -o b.exr && render --scene own.scene.json -o c.exr; then
    "$ISOSHADE" compare a.exr b.exr --json >ab.json; "$ISOSHADE" compare a.exr c.exr --json >ac.json
    # nine digits of opacity in the file; a table that was not adapted differs by tenths
    holds adapted_file_and_switch_agree "$(json_number ab.json max_abs) <= 1e-5 && $(json_number ac.json max_abs) > 0.01"
else
    not_ok adapted_file_and_switch_agree "render failed"
fi
check shown_as_json bash -c '"$ISOSHADE" tf show "$0" -o shown.svg --json | grep -q "\"output\": \"shown.svg\""' "$tf"
check show_png "$ISOSHADE" tf show "$tf" shells_level_1.tf.json --volume shells.nrrd -o tf.png
head -c 4 tf.png 2>/dev/null | grep -q PNG && ok picture_is_png || not_ok picture_is_png "$(head -c 20 tf.png)"
check show_svg "$ISOSHADE" tf show "$tf" -o tf.svg
check convert_csv "$ISOSHADE" tf convert "$tf" -o tf.csv
[ "$(wc -l <tf.csv)" = 257 ] && ok csv_has_a_line_an_entry || not_ok csv_has_a_line_an_entry "$(wc -l <tf.csv)"
expect or_by_two_names 0 "$ISOSHADE" tf convert "$tf" two.csv
check which_are_the_same cmp tf.csv two.csv
check and_named grep -q '^two.csv: ' out
refuse but_not_both 2 'usage: isoshade tf convert FILE|PRESET OUT' "$ISOSHADE" tf convert "$tf" two.csv -o three.csv
check convert_tf "$ISOSHADE" tf convert "$tf" --volume shells.nrrd -o plain.tf.json

# A .blend of three levels: a row of the color map a level, each the adapted table of its own level.
"$ISOSHADE" tf convert shells_level_2.tf.json -o level_2.csv -q
if "$ISOSHADE" export shells.iso --to blender --scene own.scene.json --levels 3 --adapt --always -o all.blend -q >/dev/null 2>err; then
    blender -b --factory-startup all.blend --python-expr 'import bpy
i = next(i for i in bpy.data.images if i.size[1] == 3)
p = list(i.pixels)
print("ROWS", i.size[0], *("%.6g" % p[4 * (i.size[0] * r + 90) + 3] for r in range(3)))' 2>/dev/null | grep ^ROWS >rows
    want=$(sed -n 92p level_2.csv | cut -d, -f5)
    awk -v want="$want" '{ d = $5 - want; exit !($2 == 256 && d < 1e-4 && d > -1e-4 && $3 != $4 && $4 != $5) }' rows && ok blend_has_a_tf_a_level ||
        not_ok blend_has_a_tf_a_level "$(cat rows), extinction of entry 90 at level 2 is $want"
else
    not_ok blend_has_a_tf_a_level "$(cat err)"
fi

check a_2d_tf_renders "$ISOSHADE" render shells.iso --level 1 --size 48 --scene own.scene.json --adapt --tf-2d deviation -o tf_2d.exr -q
refuse tf_2d_without_adapt 2 "go with --adapt" "$ISOSHADE" render shells.iso --level 1 --size 48 --scene own.scene.json --tf-2d deviation -o z.exr -q
refuse unknown_second_value 2 "must be deviation or gradient" "$ISOSHADE" render shells.iso --level 1 --size 48 --scene own.scene.json --adapt --tf-2d depth -o z.exr -q
refuse bits_without_adapt 2 'go with --adapt' "$ISOSHADE" render shells.iso --level 1 --size 8 --scene own.scene.json --bits 9 -o z.exr -q
# Two blocks, each with its cases; two figures. What is adapted has to be another table: the paper's is not the original.
few="--views 1 --size 32 --levels 2 --tfs soft -q"
expect consistency 0 "$LAB" consistency shells.nrrd --held shells.nrrd --methods paper,default $few --figures figures --json
if [ "$(grep -c '"case_count": 1' out)" = 2 ] && grep -q '"block": "held back"' out && [ -s figures/figure8.svg ] && [ -s figures/figure9.svg ]; then
    ok consistency_has_two_blocks_and_figures
else
    not_ok consistency_has_two_blocks_and_figures "$(tail -n 40 out) $(ls figures)"
fi
[ "$(sed -n 's/.*"rms_voxels_adapted": \(.*\),/\1/p' out | sort -u | wc -l)" = 3 ] && ok methods_differ || not_ok methods_differ "$(grep rms_voxels_adapted out)"
check consistency_with_povray "$LAB" consistency shells.nrrd --with povray --methods default --level 1 --views 1 --size 24 --tfs soft
refuse consistency_of_an_unknown_tf 2 '--tfs' "$LAB" consistency shells.nrrd --tfs hard
refuse consistency_with_an_unknown_renderer 2 '--with' "$LAB" consistency shells.nrrd --with mental
check an_extinction_scale_renders "$ISOSHADE" render shells.iso --level 1 --size 48 --scene own.scene.json --adapt --extinction-scale -o scaled.exr -q
check the_scene_without_it "$ISOSHADE" render shells.iso --level 1 --size 48 --scene own.scene.json --adapt -o unscaled.exr -q
"$ISOSHADE" compare scaled.exr unscaled.exr --json >scaled.json
holds a_scale_changes_the_picture "$(json_number scaled.json max_abs) > 0.01"
refuse a_scale_for_a_2d_tf 2 "needs a 1D transfer function" "$ISOSHADE" render shells.iso --level 1 --size 48 --scene own.scene.json --adapt --tf-2d deviation --extinction-scale -o z.exr -q
refuse a_scale_in_bricks 2 "extinction-scale" "$ISOSHADE" render shells.iso --size 48 --scene own.scene.json --extinction-scale --cache-bytes 1e6 -o z.exr -q
check a_scaled_grid_is_exported "$ISOSHADE" export shells.iso --to vdb --level 1 --scene own.scene.json --adapt --extinction-scale -o scaled.vdb -q
check a_scene_without_a_scale_for_vdb "$ISOSHADE" export shells.iso --to vdb --level 1 --scene own.scene.json -o z.vdb -q
check a_region_of_interest_renders "$ISOSHADE" render shells.iso --level 2 --size 48 --scene "$scene" --adapt --tf-2d gradient --roi 8,8,8,30,30,30 -o roi.exr -q
refuse roi_without_a_coarse_level 2 'needs a coarser level' "$ISOSHADE" render shells.iso --level 0 --size 48 --scene "$scene" --roi 8,8,8,30,30,30 -o z.exr -q
refuse roi_of_five_numbers 2 'must be six numbers' "$ISOSHADE" render shells.iso --level 1 --size 48 --scene "$scene" --roi 8,8,8,30,30 -o z.exr -q
refuse roi_outside 5 'must ascend within 0 to 44' "$ISOSHADE" render shells.iso --level 1 --size 48 --scene "$scene" --roi 8,8,8,30,45,30 -o z.exr -q
refuse roi_band_without_roi 2 'need --roi' "$ISOSHADE" render shells.iso --level 1 --size 48 --scene "$scene" --roi-band 3 -o z.exr -q
refuse roi_for_vdb 2 'cannot be used with --to vdb' "$ISOSHADE" export shells.iso --to vdb --level 1 --roi 8,8,8,30,30,30 -o z.vdb -q
check a_region_of_interest_is_exported "$ISOSHADE" export shells.iso --to povray --level 1 --size 48 --scene "$scene" --adapt --tf-2d deviation --roi 8,8,8,30,30,30 -o pov -q
[ -s pov/pov_roi_scalar.df3 ] && [ -s pov/pov_second.df3 ] && ok its_files_are_there || not_ok its_files_are_there "$(ls pov)"
refuse unknown_action 2 'must be one of: adapt, bound, convert, names, show, suggest' "$ISOSHADE" tf blend "$tf" -o x
refuse adapt_without_output 2 'usage: isoshade tf adapt' "$ISOSHADE" tf adapt shells.iso
# Presets are laid on the values of a stored pyramid, whose samples are read for them; a scene has its own.
expect adapt_of_a_preset 0 "$ISOSHADE" tf adapt shells.iso --tf simulation --level 1 -q -o preset.tf.json
expect adapt_of_what_is_suggested 0 "$ISOSHADE" tf adapt shells.nrrd --level 1 -q -o suggested.tf.json
expect adapt_of_a_scene 0 "$ISOSHADE" tf adapt shells.iso --scene "$scene" --level 1 --always -q -o scene.tf.json
check is_of_its_transfer_function cmp scene.tf.json shells_level_1.tf.json
refuse show_of_a_preset_needs_values 2 'give --volume FILE' "$ISOSHADE" tf show ct-bone -o x.png
check show_of_presets "$ISOSHADE" tf show auto simulation --volume shells.nrrd -o presets.svg
expect convert_of_a_preset 0 "$ISOSHADE" tf convert simulation simulation.csv --volume shells.nrrd -q
expect suggest_of_that_preset 0 "$ISOSHADE" tf suggest shells.nrrd --tf simulation -q -o six.tf.json
expect bound_without_a_scene 0 "$ISOSHADE" tf bound shells.iso --tf simulation --view top --size 16 --level 1 -q
refuse missing_tf 3 'absent.tf.json' "$ISOSHADE" tf adapt shells.iso --tf absent.tf.json -o x
refuse level_too_high 5 'level 7' "$ISOSHADE" tf adapt shells.iso --tf "$tf" --level 7 -o x.tf.json
refuse bits_too_many 2 '--bits is 17' "$ISOSHADE" tf adapt shells.iso --tf "$tf" --bits 17 -o x
refuse show_needs_an_ending 2 'must end with .png or .svg' "$ISOSHADE" tf show "$tf" -o x.jpg
refuse convert_needs_an_ending 2 'must end with .csv' "$ISOSHADE" tf convert "$tf" -o x.txt
ISOSHADE_GNUPLOT=/nowhere refuse gnuplot_missing 7 'ISOSHADE_GNUPLOT' "$ISOSHADE" tf show "$tf" -o y.png
[ ! -e y.png ] && [ ! -e x ] && ok nothing_half_written || not_ok nothing_half_written "$(ls)"
exit $failed
