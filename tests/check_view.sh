#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# The viewer's page in a browser: its pictures against those of the ray caster whose shaders it has, a scene that it saves
# against the reference, and every control as a hand or a keyboard uses it.
. "$(dirname "$0")/lib.sh"
suite=$top/refscenes/suite

# page NAME SCENE SIZE STATE OPTIONS -- RENDER OPTIONS: a volume of the suite, its page, and the ray caster's picture. The sizes
# are no multiples of 8, some are not square.
mkdir pages
page() {
    local name=$1 scene=$2 size=$3 state=$4 view=()
    shift 4
    while [ "$1" != -- ]; do view+=("$1"); shift; done
    shift
    [ -s "$scene.nrrd" ] || eval "\"$ISOSHADE\" make $(sed -n 's/.*"make": "\([^"]*\)".*/\1/p' "$suite/$scene.scene.json") -q -o $scene.nrrd"
    "$ISOSHADE" view "$scene.nrrd" --scene "$suite/$scene.scene.json" --size "$size" "${view[@]}" -q -o "pages/$name.html" || failed=1
    echo "${size%x*} ${size#*x} $state" >"pages/$name.size"
    "$ISOSHADE" render "$scene.nrrd" --scene "$suite/$scene.scene.json" --size "$size" --with gl "$@" -q -o "pages/$name.gl.exr" >/dev/null || failed=1
}
page lights eight-lights 61x61 '{}' -- # eight lights with highlights, a TF narrower than the change in a voxel
page mirrored left-handed 70x50 '{}' --code region48 -- --code region48 # 16 bits, a reflected grid, oblique samples, a decoder
page second left-handed 70x50 '{"code": "region48"}' --code fit,region48 -- --code region48 # of two codes the one that does not show first
page inside inside-noise 51x67 '{}' -- # the camera is in the volume, which is turned
page signed negative-noise 61x61 '{"code": null}' --code none -- --shading-from on-the-fly # negative values, gradients on the fly
page float marschner-lobb 61x61 '{}' --float --code free -- --code free
page entries thousand-entries 61x61 '{}' -- # a table of a thousand entries
page coarse border 61x61 '{"level": 1}' --float -- --level 1
page gap marschner-lobb 61x61 '{"level": 1}' --float --no-data 26000,33000 -- --level 1 --no-data 26000,33000
page adapted eight-lights 61x61 '{"level": 1, "adapted": true}' --float -- --level 1 --adapt --always
middle='{"level": 0, "box": [[0.25, 0.25, 0.25], [0.75, 0.75, 0.75]], "band": 2}'
page region eight-lights 61x61 "{\"level\": 1, \"roi\": $middle}" --float -- --level 1 \
    --roi 10.25,9.25,10.75,30.75,27.75,32.25 # a finer level inside a box
page gap_region marschner-lobb 61x61 "{\"level\": 1, \"roi\": $middle}" \
    --float --no-data 26000,33000 -- --level 1 --no-data 26000,33000 --roi 9.25,10.25,4.25,27.75,30.75,12.75
page rounded ramp-rotated 61x61 '{}' -- # floats in 16 bits

# Level 0 in the bricks of a plan: as plan draws it, which has directions of 16 bits where the page has codes.
"$ISOSHADE" make shells --size 41x38x36 -q -o planned.nrrd
shells="$top/refscenes/shells.scene.json"
"$ISOSHADE" plan planned.nrrd --scene "$shells" --size 61x61 --brick 8 --levels 3 --error 0.01 --image plan.exr --full-image full.exr -q -o a.plan.json >/dev/null
"$ISOSHADE" view planned.nrrd --scene "$shells" --size 61x61 --plan a.plan.json -o pages/planned.html >planned.out
echo '61 61 {}' >pages/planned.size

expect the_pages_are_drawn 0 python3 "$top/tests/view_page.py" pictures pages
check none_is_left_out test "$(grep -c ^drawn out)" = 14
# A ray is set up in floats, which are 1e-5 voxels off after a few hundred of them; that times the TF's slope is seen.
near() { check "$1_is_as_the_ray_caster_draws_it" "$ISOSHADE" compare "pages/$1.gl.exr" "pages/$1.page.exr" --max-rmse "$2" --max-abs "$3"; }
for name in lights mirrored second inside signed float entries coarse gap adapted region gap_region; do
    near $name 5e-6 1e-4
done
near rounded 1e-5 1e-4 # half a step of 1/65535 of the range, times the TF's slope
"$ISOSHADE" render left-handed.nrrd --scene "$suite/left-handed.scene.json" --size 70x50 --with gl --code fit -q -o fit.exr >/dev/null
notice the_first_code_is_noticed "$ISOSHADE" compare fit.exr pages/second.page.exr --max-rmse 5e-6 --max-abs 1e-4
check planned_bricks_are_as_plan_draws_them "$ISOSHADE" compare plan.exr pages/planned.page.exr --max-rmse 1e-4 --max-abs 2e-3
notice bricks_of_level_0_are_noticed "$ISOSHADE" compare full.exr pages/planned.page.exr --max-rmse 1e-4 --max-abs 2e-3
check the_error_of_the_plan_is_said grep -qE "RMSE 0\.[0-9]+ predicted, 0\.[0-9]+ measured" planned.out
check and_stands_in_the_page grep -qE '"predicted_rmse":0\.[0-9]+,"measured_rmse":0\.[0-9]+' pages/planned.html
refuse a_plan_of_another_volume_is_refused 5 "bricks of 8 voxels, the volume has" "$ISOSHADE" view eight-lights.nrrd --scene "$shells" --plan a.plan.json -o x.html
refuse a_plan_stands_for_level_0 2 "--plan and --level 0" "$ISOSHADE" view planned.nrrd --plan a.plan.json --level 0 -o x.html
[ -z "${VERBOSE-}" ] || for name in pages/*.page.exr; do [ -s "${name%.page.exr}.gl.exr" ] || continue; echo "$name"; "$ISOSHADE" compare "${name%.page.exr}.gl.exr" "$name"; done

# The planted fault: half a pixel, which the limits have to notice.
"$ISOSHADE" render eight-lights.nrrd --scene "$suite/eight-lights.scene.json" --size 61x61 --zoom 1.016 --with gl -q -o half.exr >/dev/null
notice half_a_pixel_is_noticed "$ISOSHADE" compare half.exr pages/lights.page.exr --max-rmse 5e-6 --max-abs 1e-4

check the_page_is_below_200_kB test "$("$ISOSHADE" view eight-lights.nrrd --json -o small.html | awk -F'[:,]' '/"page_bytes"/ {p = $2} /"data_bytes"/ {d = $2} END {print p - d}')" -lt 200000

# ---- hands ----
"$ISOSHADE" make shells --size 34x33x32 -q -o v.nrrd
as="--spacing 1x1x1.1" # the file is read so, and the command that the page shows has to say it
"$ISOSHADE" view v.nrrd $as --scene "$top/refscenes/shells.scene.json" --levels 2 -q -o v.html
"$ISOSHADE" make noise --size 20x24x18 --type int16 --range -300,900 --spacing 1x1.5x2 --rotate 1,2,3,40 --seed 5 -q -o other.nrrd
python_with nibabel
"$python" - <<'END'
import nibabel, numpy
z, y, x = numpy.mgrid[0:17, 0:21, 0:19]
values = (1000 * numpy.exp(-((x - 9) ** 2 + (y - 12) ** 2 + (z - 8) ** 2) / 40)).astype("int16").transpose(2, 1, 0)
turn = numpy.array([[-1.2, 0.3, 0, 10], [0.2, 1.5, 0.1, -20], [0, -0.1, 2, 5], [0, 0, 0, 1]])
nibabel.save(nibabel.Nifti1Image(values, turn), "other.nii.gz")
far = (x - 9) ** 2 + (y - 12) ** 2 + (z - 8) ** 2
gaps = numpy.where((x > 5) & (y > 8) & (z < 9), numpy.nan, far).astype("float32")
head = b"NRRD0004\ntype: float\ndimension: 3\nsizes: 19 21 17\nspacings: 1 1.2 1\nendian: little\nencoding: raw\n\n"
for name, values in (("gaps.nrrd", gaps), ("zeros.nrrd", numpy.nan_to_num(gaps))):
    with open(name, "wb") as f:
        f.write(head + values.tobytes())
END
python3 -c 'import sys; sys.path.insert(0, sys.argv[1]); import view_files; view_files.make_files(".")' "$top/tests"
expect the_page_was_used 0 python3 "$top/tests/view_page.py" hands v.html "$dir"
cp out findings
found() { grep -qxE "$1" findings; }
for name in a_drag_orbits the_right_button_pans the_wheel_zooms arrows_orbit a_point_is_dragged keys_move_what_was_dragged points_come_and_go a_color_is_chosen \
    a_level_differs_and_the_same_does_not the_joint_histogram_is_drawn what_was_edited_comes_back an_empty_field_changes_nothing \
    the_projection_follows_the_scene the_keyboard_stays_where_it_was a_narrow_window_shows_the_scenes_sides the_scale_of_a_difference_is_told a_region_is_outlined_and_goes a_complaint_is_closed a_file_may_miss_the_picture; do
    check "$name" found "$name true"
done
check every_control_has_a_name found 'controls_without_a_name 0'
check nothing_is_fetched found 'fetched 0'
check it_fits_a_telephone found 'wider_than_a_telephone false'
check no_script_threw found 'exceptions 0'
check files_of_strangers_are_placed_or_refused_as_by_info bash -c 'sed -n "s/^files_go_wrong //p" findings; grep -qx "files_go_wrong none" findings'
check the_command_that_is_shown_runs bash -c "$(sed 's/^isoshade/"$ISOSHADE"/; s/picture.png/shown.exr/' command) -q"
check and_draws_what_the_page_shows "$ISOSHADE" compare shown.exr saved.page.exr --max-rmse 5e-6 --max-abs 1e-4
"$ISOSHADE" render v.nrrd $as --scene scene.json --with reference --quadrature midpoint -q -o saved.exr >/dev/null
check a_saved_scene_renders_the_same "$ISOSHADE" compare saved.exr saved.page.exr --max-rmse 2e-5 --max-abs 5e-4
"$ISOSHADE" render v.nrrd $as --scene scene.json --tf tf.json --with reference --quadrature midpoint -q -o tf.exr >/dev/null
check a_saved_transfer_function_is_that_of_the_scene "$ISOSHADE" compare saved.exr tf.exr
"$ISOSHADE" render v.nrrd $as --scene "$top/refscenes/shells.scene.json" --size "$(python3 -c "import json; i = json.load(open(\"scene.json\"))[\"image\"]; print(i[\"width\"], i[\"height\"], sep=\"x\")")" --with reference --quadrature midpoint -q -o unmoved.exr >/dev/null
notice and_it_is_not_the_scene_it_began_with "$ISOSHADE" compare unmoved.exr saved.page.exr --max-rmse 1e-3

for file in nrrd nii.gz; do # the camera is in millimeters: the page and the program agree where the volume is
    kind=${file%.gz}
    "$ISOSHADE" render "other.$file" --scene "opened-$kind.json" --shading-from on-the-fly --with reference --quadrature midpoint -q \
        -o "opened-$kind.exr" >/dev/null
    check "a_${kind}_file_is_opened" "$ISOSHADE" compare "opened-$kind.exr" "opened-$kind.page.exr" --max-rmse 5e-5 --max-abs 1e-3
done

# The reference takes other differences next to gaps.
gaps_drawn() { "$ISOSHADE" render "$1.nrrd" --scene opened-gaps.json --shading-from on-the-fly --with gl -q -o "$1.exr" >/dev/null; }
gaps_drawn gaps
check gaps_are_no_data "$ISOSHADE" compare gaps.exr opened-gaps.page.exr --max-rmse 5e-5 --max-abs 1e-3
gaps_drawn zeros
notice gaps_drawn_as_values_are_noticed "$ISOSHADE" compare zeros.exr opened-gaps.page.exr --max-rmse 5e-5 --max-abs 1e-3

# ---- what is saved: pictures as the program draws them, also in bands; the page; links; steps of editing ----
"$ISOSHADE" make shells --size 34x33x32 -q -o v.nrrd
mkdir -p saved
expect the_page_was_edited_and_saved 0 python3 "$top/tests/view_page.py" saved v.html saved
for name in nothing_to_undo undo_goes_back redo_comes_again nothing_to_redo the_saved_page_is_as_it_was_left \
    saved_again_it_is_the_same the_link_shows_the_same refused_no_text refused_empty refused_no_camera refused_nine_lights; do
    check "$name" grep -qx "$name true" out
done
check nothing_threw test "$(grep -c '^exceptions.* 0$' out)" = 3
check the_saved_page_draws_the_same "$ISOSHADE" compare saved/edited.page.exr saved/again.page.exr
python_with numpy,png
# Floats in another order round to the next byte in a few pixels.
same_picture() { # PNG PNG
    "$python" -c 'import sys, numpy, png
a, b = (numpy.vstack([numpy.frombuffer(r, "u1") for r in png.Reader(p).asRGBA8()[2]]).astype(int) for p in sys.argv[1:])
off = abs(a - b)
sys.exit(int(a.shape != b.shape or off.max() > 1 or (off > 0).mean() > 1e-3))' "$@"
}
for name in screen print; do
    size=$(file saved/$name.png | sed -E 's/.* ([0-9]+) x ([0-9]+),.*/\1x\2/')
    drawn=(--size "$size" --with gl --code fit -q)
    "$ISOSHADE" render v.nrrd $as --scene saved/edited.scene.json "${drawn[@]}" -o saved/$name.gl.png >/dev/null
    check "the_picture_of_the_${name}_is_as_the_program_draws_it" same_picture saved/$name.png saved/$name.gl.png
done
"$ISOSHADE" render v.nrrd $as --scene "$top/refscenes/shells.scene.json" "${drawn[@]}" -o saved/unedited.png >/dev/null
notice an_edit_that_is_lost_is_noticed same_picture saved/print.png saved/unedited.png

# ---- as a renderer: directions as vectors, a clip plane, a turned grid; and a fault that its limits have to notice ----
sed 's/"image"/"clip_planes": [{"normal": [1, 1, 0], "at": 0.4}], &/' "$suite/left-handed.scene.json" >clipped.scene.json
"$ISOSHADE" render left-handed.nrrd --scene clipped.scene.json --size 45x33 --with webgl --renderers "$top/tests/peers/viewer.json" -q -o webgl.exr >/dev/null
"$ISOSHADE" render left-handed.nrrd --scene clipped.scene.json --size 45x33 --with reference --shading-from decoded --quadrature midpoint -q -o reference.exr >/dev/null
check a_renderer_of_the_same_code_takes_the_same_samples "$ISOSHADE" compare reference.exr webgl.exr --max-rmse 4e-6 --max-abs 8e-5
"$ISOSHADE" render left-handed.nrrd --scene "$suite/left-handed.scene.json" --size 45x33 --with reference --shading-from decoded --quadrature midpoint -q -o whole.exr >/dev/null
notice a_clip_plane_that_is_missing_is_noticed "$ISOSHADE" compare whole.exr webgl.exr --max-rmse 4e-6 --max-abs 8e-5
refuse what_it_lacks_is_refused 2 "webgl" "$ISOSHADE" render left-handed.nrrd --scene clipped.scene.json --size 9 --with webgl --renderers "$top/tests/peers/viewer.json" --isosurface 30000 -o x.exr

# ---- beside a report: the link of a row leads to the level that the row is of ----
"$ISOSHADE" validate v.nrrd --scene "$top/refscenes/shells.scene.json" --quick --levels 2 --size 16 --with gl --viewer -q -o report >/dev/null 2>&1
check the_report_has_a_page test -s report/viewer-shells.html
check a_row_links_to_it_at_its_level python3 "$top/tests/view_page.py" link report viewer-shells.html

# ---- a volume that is too large goes in by a coarser level, with what that costs ----
"$ISOSHADE" view v.nrrd --most-voxels 10000 -o coarse.html >coarse.out
check the_level_that_goes_in_is_said grep -q ": level 1, the finest" coarse.out
check the_page_says_what_it_costs grep -qE '"seen":\{"rmse":0\.[0-9]+,"ssim_dissimilarity":0\.[0-9]+,"rmse_adapted":' coarse.html

# ---- what is refused ----
refuse a_page_needs_a_name 2 "-o is missing" "$ISOSHADE" view v.nrrd
refuse a_code_for_nearest_fetches_is_refused 2 "a page needs a code that textures can filter" "$ISOSHADE" view v.nrrd --code oct24 -o x.html
refuse a_level_that_is_not_there_is_refused 5 "has levels 0 to" "$ISOSHADE" view v.nrrd --level 9 -o x.html
refuse a_level_that_is_too_large_is_refused 5 "--most-voxels" "$ISOSHADE" view v.nrrd --level 0 --most-voxels 100 -o x.html
exit $failed
