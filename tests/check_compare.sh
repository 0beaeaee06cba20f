#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# The command compare: verdicts, exit codes, JSON, messages, and no half-written files.
. "$(dirname "$0")/lib.sh"
# picture FILE WIDTH HEIGHT HIGH-BYTE: 16-bit PPM, every channel HIGH-BYTE * 256.
picture() {
    printf 'P6\n%d %d\n65535\n' "$2" "$3" >"$1"
    for ((i = 0; i < 3 * $2 * $3; ++i)); do printf "\\x$4\\x00"; done >>"$1"
}
picture "$dir/a.ppm" 12 11 80
picture "$dir/b.ppm" 12 11 81
picture "$dir/small.ppm" 11 12 80
printf 'P6\n12 11\n65535\nshort' >"$dir/short.ppm"
head -c 64 /dev/zero >"$dir/zeros.exr"

expect equal_images_agree 0 "$ISOSHADE" compare "$dir/a.ppm" "$dir/a.ppm"
check verdict_is_printed grep -q '^verdict   agree' "$dir/out"
expect different_images_differ_without_limits 1 "$ISOSHADE" compare "$dir/a.ppm" "$dir/b.ppm"
# 256 / 65535 = 0.0039: one limit above, one below
expect a_wide_limit_lets_them_agree 0 "$ISOSHADE" compare "$dir/a.ppm" "$dir/b.ppm" --max-abs 0.004
expect a_tight_limit_does_not 1 "$ISOSHADE" compare "$dir/a.ppm" "$dir/b.ppm" --max-abs 0.0038 --max-rmse 1
expect json_is_printed 1 "$ISOSHADE" compare "$dir/a.ppm" "$dir/b.ppm" --max-abs 0.0038 --json
has_keys json_has "$dir/out" schema command options rmse max_abs p99_abs psnr_db ssim flip_mean nonfinite_count verdict
check json_names_the_schema grep -q '"isoshade.compare/1"' "$dir/out"
expect the_difference_is_drawn 0 "$ISOSHADE" compare "$dir/a.ppm" "$dir/b.ppm" --max-abs 1 --difference "$dir/d.png"
check the_picture_is_a_png grep -q PNG "$dir/d.png"
expect hdr_flip_is_measured_on_request 0 "$ISOSHADE" compare "$dir/a.ppm" "$dir/a.ppm" --hdr --json --flip-map "$dir/f.png"
check its_exposures_are_told grep -q '"hdr_flip_exposures": {' "$dir/out"
check its_value_is_printed grep -q '"hdr_flip_mean": 0.0' "$dir/out"
check the_map_is_a_png grep -q PNG "$dir/f.png"
refuse no_map_is_a_jpeg 2 'must end with .exr or .png' "$ISOSHADE" compare "$dir/a.ppm" "$dir/b.ppm" --flip-map "$dir/f.jpg"
expect a_map_keeps_its_values_as_exr 0 "$ISOSHADE" compare "$dir/a.ppm" "$dir/b.ppm" --max-abs 1 --flip-map "$dir/f.exr" --json
mean=$(json_number "$dir/out" flip_mean)
# Uniform images: the map is its mean everywhere, and so is its difference to black.
picture "$dir/black.ppm" 12 11 00
expect the_map_can_be_compared 0 "$ISOSHADE" compare "$dir/f.exr" "$dir/black.ppm" --max-abs 1 --json
check its_values_are_the_metric_s test "$(sed -n 's/.*"max_abs": \([0-9.]\{6\}\).*/\1/p' "$dir/out")" = "${mean:0:6}"
expect a_png_is_read 0 "$ISOSHADE" compare "$dir/d.png" "$dir/d.png"
expect different_sizes_are_refused 5 "$ISOSHADE" compare "$dir/a.ppm" "$dir/small.ppm" --difference "$dir/no.png"
check both_sizes_are_named grep -q '12x11.*11x12' "$dir/err"
check and_both_files_once grep -q "compare: $dir/a.ppm and $dir/small.ppm: the images have" "$dir/err"
check nothing_is_left test ! -e "$dir/no.png"
expect a_missing_file_is_named 3 "$ISOSHADE" compare "$dir/none.exr" "$dir/a.ppm"
check the_message_names_the_file grep -q none.exr "$dir/err"
expect a_short_file_is_refused 4 "$ISOSHADE" compare "$dir/short.ppm" "$dir/a.ppm"
expect a_file_that_is_no_image_is_refused 4 "$ISOSHADE" compare "$dir/zeros.exr" "$dir/zeros.exr"
expect a_limit_of_zero_is_refused 2 "$ISOSHADE" compare "$dir/a.ppm" "$dir/a.ppm" --max-abs 0
expect a_limit_that_is_nan_is_refused 2 "$ISOSHADE" compare "$dir/a.ppm" "$dir/a.ppm" --max-flip nan
expect one_image_is_too_few 2 "$ISOSHADE" compare "$dir/a.ppm"
expect an_unwritable_picture_is_an_error 3 "$ISOSHADE" compare "$dir/a.ppm" "$dir/a.ppm" --difference "$dir/no/d.png"
# A picture with its background beside one that is transparent where nothing is: alpha tells them apart, and little else.
"$ISOSHADE" make shells --size 20 -q -o v.nrrd
"$ISOSHADE" render v.nrrd --scene "$top/refscenes/shells.scene.json" --with cpu --size 12x11 -q -o clear.exr >/dev/null
expect an_opaque_picture_differs 1 "$ISOSHADE" compare clear.exr "$dir/a.ppm"
colors=$(sed -n 's/^note      B is opaque throughout, A is not; rmse of the colors: \([0-9.]*\)$/\1/p' out)
rmse=$(sed -n 's/^rmse *//p' out)
check which_is_said test -n "$colors"
expect in_the_answer_too 1 "$ISOSHADE" compare "$dir/a.ppm" clear.exr --json
check as_data grep -q '"opaque": "A"' out
holds with_the_same_figure "($(json_number out rmse_of_colors) - $colors) ^ 2 < 1e-8 && $colors != $rmse"
expect two_opaque_ones_have_no_note 0 "$ISOSHADE" compare "$dir/a.ppm" "$dir/a.ppm"
notice no_note grep -q note out
expect help_is_not_an_error 0 "$ISOSHADE" compare --help
check help_ends_with_examples grep -q '^  isoshade compare a.exr b.exr --max-rmse' "$dir/out"
exit $failed
