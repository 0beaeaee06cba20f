#!/bin/bash
# SPDX-License-Identifier: MIT
# Histograms with axes: of info in letters and drawn, of tf show behind the curves.
. "$(dirname "$0")/lib.sh"
"$ISOSHADE" make sphere --size 16 --type uint8 -q -o v.nrrd
tf="$top/refscenes/shells.tf.json"

expect info_prints_one 0 "$ISOSHADE" info v.nrrd
check counts_stand_before_the_rows grep -Eq '^ +[0-9.e+]+ \|[#:. ]{57}$' out
check the_axis_has_ticks grep -Eq '^ +voxels \+[-+]{57}$' out
check and_values grep -Eq '^ +value +0 +50 +100 +150 +200 *$' out
printf 'NRRD0004\ntype: float\ndimension: 3\nsizes: 2 2 2\nspacings: 1 1 1\nencoding: ascii\n\n3.5 3.5 3.5 3.5 3.5 3.5 3.5 3.5\n' >one.nrrd
expect a_volume_of_one_value 0 "$ISOSHADE" info one.nrrd
check has_one_bin grep -Eq '^ +voxels \+[-+]$' out

for ending in png svg pdf; do
    check "info_draws_$ending" "$ISOSHADE" info v.nrrd --histogram "h.$ending"
    check "show_draws_$ending" "$ISOSHADE" tf show "$tf" --volume v.nrrd -o "tf.$ending"
    has_files drawn . "h.$ending" "tf.$ending"
done
check the_volume_is_named grep -q 'v.nrrd: 16 x 16 x 16 voxels, 0 to 227' h.svg
check voxels_have_an_axis grep -q 'voxels' tf.svg
"$ISOSHADE" tf show "$tf" -q -o alone.svg
notice without_a_volume_they_have_none grep -q 'voxels' alone.svg
# White is seen on a gray panel.
check panels_are_gray grep -qi 'rgb(220, 220, 220)\|#dcdcdc' tf.svg
cp "$tf" "bone's.tf.json"
check a_quote_in_a_name_is_drawn "$ISOSHADE" tf show "bone's.tf.json" -o quote.svg
check as_it_is grep -q "bone's.tf.json\|bone&apos;s\|bone&#39;s" quote.svg

refuse another_ending 2 'must end with .png or .svg or .pdf' "$ISOSHADE" info v.nrrd --histogram h.jpg
"$ISOSHADE" build v.nrrd --levels 1 -q -o v.iso
refuse a_pyramid 2 '--histogram needs a volume' "$ISOSHADE" info v.iso --histogram h2.png
ISOSHADE_GNUPLOT=/nowhere refuse without_gnuplot 7 'ISOSHADE_GNUPLOT' "$ISOSHADE" info v.nrrd --histogram h2.png
exit $failed
