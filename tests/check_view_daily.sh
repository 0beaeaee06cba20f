#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# The viewer's page as a daily tool: slices against the values of the file, lengths.
. "$(dirname "$0")/lib.sh"
python_with nibabel
"$python" - <<'END'
import gzip, nibabel, numpy
z, y, x = numpy.mgrid[0:17, 0:21, 0:19]
far = (x - 9) ** 2 + (y - 12) ** 2 + (z - 8) ** 2
values = (1000 * numpy.exp(-far / 40) + 7 * x + 3 * y - 5 * z).transpose(2, 1, 0)
turn = numpy.array([[0.3, -1.2, 0, 10], [1.5, 0.2, 0.1, -20], [-0.1, 0, 2, 5], [0, 0, 0, 1]])
nibabel.save(nibabel.Nifti1Image(values.astype("int16"), turn), "patient.nii")
series = numpy.stack([values, 2 * values, numpy.roll(values, 3, 0)], 3).astype("int16")
nibabel.save(nibabel.Nifti1Image(series, turn), "steps.nii")
label = numpy.zeros((14, 9, 8), "uint8")
label[2:9, 3:7, 1:7], label[9:12, 2:8, 2:6] = 1, 2
placed = numpy.array([[-1.7, 0, 0, 8], [0, 2.5, 0.2, -16], [0, 0, 4, 5], [0, 0, 0, 1]])
nibabel.save(nibabel.Nifti1Image(label, placed), "over.nii")
moved = numpy.array([[1.1, 0, 0.2, 0], [0, 1.3, 0, -9], [0, 0.1, 2.1, 16], [0, 0, 0, 1]])
nibabel.save(nibabel.Nifti1Image(values[2:, 1:, 3:].astype("int16"), moved), "moved.nii")
plain = nibabel.Nifti1Image(values.astype("float32"), None)
plain.header.set_zooms((1, 1.5, 2))
plain.header["qform_code"] = plain.header["sform_code"] = 0
nibabel.save(plain, "plain.nii")
keys = "".join(f"Segment{i}_{key}\n" for i, (label, name) in enumerate([(2, "left kidney"), (7, "Läsion")])
               for key in (f"ID:=s{i}", f"LabelValue:={label}", "Layer:=0", f"Name:={name}", "Color:=1 0 0"))
head = "NRRD0004\ntype: unsigned char\ndimension: 3\nspace: left-posterior-superior\nsizes: 12 10 8\n" \
       "space directions: (1,0,0) (0,1,0) (0,0,1.4)\nspace origin: (0,0,0)\nencoding: gzip\n"
with open("named.seg.nrrd", "wb") as f:
    row = bytes([0, 2, 2, 2, 2, 7, 7, 7, 7, 11, 11, 0])
    f.write((head + keys + "\n").encode() + gzip.compress(80 * row))
END
daily() { PYTHONPATH="$top/tests:$top/tests/peers" "$python" "$top/tests/view_daily.py" "$@"; }
# The grid of plain.nii is centered at the origin; nibabel's own default for such files is another one.
"$python" -c 'import nibabel, numpy
i = nibabel.load("plain.nii"); a = numpy.diag([1, 1.5, 2, 1]); a[:3, 3] = -(numpy.array(i.shape) - 1) / 2 * [1, 1.5, 2]
nibabel.save(nibabel.Nifti1Image(numpy.asarray(i.dataobj), a), "placed.nii")'
# all_true NAME LINES: the findings in out, of which there are at least as many
all_true() {
    while read -r finding value; do check "$1_$finding" test "$value" = true; done <out
    check "$1_none_is_left_out" test "$(wc -l <out)" -ge "$2"
}
for name in patient plain; do
    "$ISOSHADE" view $name.nii -q -o $name.html || failed=1
    file=$name.nii
    [ $name = patient ] || file=placed.nii
    expect "the_slices_of_the_${name}_are_used" 0 daily slices $name.html $file
    all_true $name 14
done
"$ISOSHADE" view named.seg.nrrd -q -o named.html || failed=1
expect labels_are_shown 0 daily labels named.html
check they_have_their_names grep -qx 'labels 2 left kidney; 7 Läsion; 11; 0' out
expect files_are_opened 0 daily opened patient.html steps.nii over.nii
all_true opened 12
sed 's/new Worker(/new Forbidden(/' patient.html >alone.html
expect files_are_opened_without_workers 0 daily opened alone.html steps.nii over.nii
check and_that_is_noticed grep -qx 'files_are_read_beside_the_page false' out

# Lengths in the picture, and units.
"$ISOSHADE" make constant --size 10x10x10 -q -o constant.nrrd
white='"r": 1, "g": 1, "b": 1, "opacity": 0.3'
printf '{"schema": "isoshade.tf/1", "range": [0, 1], "unit_distance_mm": 2, "color_space": "linear", "points": [%s]}' \
    "{\"value\": 0, $white}, {\"value\": 1, $white}" >constant.tf.json
"$ISOSHADE" view constant.nrrd --tf constant.tf.json -q -o constant.html || failed=1
expect points_of_the_picture_are_picked 0 daily picked constant.html
all_true picked 7
"$ISOSHADE" make noise --size 12x11x10 --type int16 --range -300,900 -q -o noise.nrrd
for at in near:4 far:9000; do # along y, which the picture is against
    "$python" - "${at%:*}.nrrd" "${at#*:}" <<'END'
import sys
head = "NRRD0004\ntype: float\ndimension: 3\nspace dimension: 3\nsizes: 10 10 10\n" \
       f"space directions: (1,0,0) (0,1,0) (0,0,1)\nspace origin: (-4.5,{float(sys.argv[2]) - 4.5},-4.5)\n" \
       "endian: little\nencoding: raw\n\n"
with open(sys.argv[1], "wb") as f:
    f.write(head.encode() + bytes([0, 0, 128, 63]) * 1000)
END
done
expect a_second_volume_is_in_the_picture 0 daily overlaid constant.html near.nrrd far.nrrd
all_true overlaid 8
# A second volume on the command line, at its place.
"$ISOSHADE" view patient.nii --overlay moved.nii -q -o pair.html || failed=1
expect a_page_has_two_volumes 0 daily placed pair.html .
all_true placed 1
place() { "$ISOSHADE" render "$1.nii" --scene placed.scene.json --shading-from on-the-fly --with gl -q -o "$1.exr" >/dev/null; }
place moved
check the_second_is_at_its_place "$ISOSHADE" compare moved.exr placed.page.exr --max-rmse 5e-6 --max-abs 1e-4
place patient
notice the_first_in_its_stead_is_noticed "$ISOSHADE" compare patient.exr placed.page.exr --max-rmse 5e-6 --max-abs 1e-4
pair() { "$ISOSHADE" view patient.nii "$@" -o x.html; }
refuse a_second_volume_that_is_missing_is_refused 3 "--overlay: none.nii" pair --overlay none.nii
refuse a_second_volume_that_is_too_large_is_refused 5 "raise --most-voxels" pair --overlay moved.nii --most-voxels 4000
sed '0,/^encoding/s//sample units: "HU"\n&/' noise.nrrd >hu.nrrd
"$ISOSHADE" view hu.nrrd -q -o hu.html || failed=1
expect the_unit_of_values_is_shown 0 daily unit hu.html hu.nrrd HU
all_true unit 6
sed 's/"value_unit":"HU"/"value_unit":"XU"/' hu.html >xu.html
daily unit xu.html hu.nrrd HU >out
check another_unit_is_noticed grep -qx 'the_page_has_it_under_the_cursor false' out
for kind in tf levels; do
    "$ISOSHADE" figure hu.nrrd --kind $kind --size 24 -q -o $kind >/dev/null 2>&1
    check figures_of_${kind}_have_the_unit grep -q '>value in HU' $kind/figure.svg
done
"$ISOSHADE" figure noise.nrrd --kind tf -q -o none >/dev/null 2>&1
check a_figure_without_a_unit_has_none grep -q '>value<' none/figure.svg
expect a_context_is_lost 0 daily lost patient.html noise.nrrd patient.nii
all_true lost 8
"$ISOSHADE" view patient.nii --compact -q -o compact.html || failed=1
expect a_page_in_a_frame_is_used 0 daily framed compact.html outer.html
all_true framed 5
expect the_whole_page_is_no_compact_one 0 daily framed patient.html outer.html
check and_that_is_noticed grep -qx 'the_picture_is_first false' out
[ -z "${KEEP-}" ] || cp -- *.png "$KEEP"
exit $failed
