#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Pictures from elsewhere: what `scenes --write` writes is drawn by doc/guide/numpy_renderer.py, which knows isoshade's
# request alone; `validate --images` calibrates and compares the pictures, and names what is missing, damaged or wrong.
. "$(dirname "$0")/lib.sh"
python_with numpy
cp "$top/doc/guide/numpy_renderer.py" .
"$ISOSHADE" make marschner-lobb --size 20x22x21 -q -o v.nrrd
cp "$top"/refscenes/marschner-lobb.{tf,scene}.json .
asked=(v.nrrd --scene marschner-lobb.scene.json --size 10 --levels 2)
write=("$ISOSHADE" scenes "${asked[@]}" --steps 3)
validate=("$ISOSHADE" validate "${asked[@]}" --quick --with reference)
expect requests_are_written 0 "${write[@]}" --write els
has_files a_request els/marschner-lobb-level-1 request.json volume.nrrd directions.nrrd
check calibrations_are_among_them test "$(find els -name 'calibration-*' | wc -l)" = 7
check the_list_has_sizes_and_steps grep -q 'marschner-lobb-level-0/picture.exr  10 x 10 pixels, step 0.5 mm (0.5 voxels)' els/README.txt
check and_the_finer_steps grep -q 'marschner-lobb-level-0/step-0.125.exr ' els/README.txt
check and_the_line_that_compares grep -q 'isoshade validate v.nrrd --scene marschner-lobb.scene.json --levels 2 --size 10 --images NAME=els' els/README.txt
has_keys the_index els/pictures.json schema command tier steps pictures
refuse a_sheet_is_no_request 2 '-o and --write exclude each other' "${write[@]}" --write two -o sheet.png
refuse another_tier_is_refused 2 'must be samples, limit or "8 bits"' "${write[@]}" --write two --tier exact
refuse a_limit_needs_two_steps 2 'a limit needs at least 2' "${write[@]}" --steps 1 --tier limit --write two
refuse levels_are_of_requests 2 'need --write' "$ISOSHADE" scenes v.nrrd --levels 1 -o sheet.png

# One start of Python for all requests, each in its own folder.
check an_outside_program_draws_them "$python" -c '
import glob, os, runpy, sys
top = os.getcwd()
for request in sorted(glob.glob(top + "/els/*/request.json")):
    os.chdir(os.path.dirname(request))
    sys.argv = ["numpy_renderer.py", request]
    runpy.run_path(top + "/numpy_renderer.py", run_name="__main__")'
expect its_pictures_agree 0 "${validate[@]}" --images outside=els -o report
# Verdicts of its rows of agreement and calibration: verdict, level, comparison or check, why.
rows() { python3 -c "
import json
d = json.load(open('report/report.json'))
for r in d['agreement'] + d['calibration']:
    if r['renderer'] == 'outside': print(r['verdict'], r.get('level', '-'), r.get('comparison', r.get('check')), r.get('why') or r.get('detail'), sep='/')" >rows; }
rows
check by_the_same_samples test "$(grep -cE '^agree/[01]/lock-step/' rows)" = 2
check by_the_limit_where_it_shows_enough test "$(grep -cE '^(agree|not compared)/[01]/limit/' rows)" = 2
check and_not_by_nothing_alone grep -q '^agree/0/limit/' rows
check all_calibrations_pass test "$(grep -c '^pass/' rows)" = 7
check it_is_named_with_its_folder grep -q '"outside": "pictures in els"' report/report.json

# Faults, several at a time, since each row stands for itself.
last_value() { printf "$2" | dd of="$1" bs=1 seek=$(($(stat -c %s "$1") - 4)) conv=notrunc status=none; }
half='\000\000\000\077' nan='\000\000\300\177'
cp -r els bad && cd bad || exit 1
last_value marschner-lobb-level-0/picture.npy "$half"
last_value marschner-lobb-level-1/picture.npy "$nan"
rm marschner-lobb-level-1/step-0.5.npy
cd ..
expect faults_are_found 9 "${validate[@]}" --images outside=bad -o report
rows
check a_wrong_pixel_is_a_difference_of_its_picture grep -q '^differ/0/lock-step/' rows
check and_of_no_other grep -q '^agree/0/limit/' rows
check a_value_that_is_no_number_is_named grep -q '^refused/1/lock-step/.*bad/marschner-lobb-level-1/picture.npy has 1 values that are not finite' rows
check a_missing_picture_is_named grep -q '^refused/1/limit/.*there is no picture bad/marschner-lobb-level-1/step-0.5.exr' rows

rm -rf bad && cp -r els bad && cd bad || exit 1
sed -i 's/"half_height": 1/"half_height": 2/' marschner-lobb-level-0/request.json
last_value marschner-lobb-level-1/volume.nrrd "$half"
last_value calibration-light-level-0/picture.npy "$half"
cd ..
expect a_calibration_that_is_wrong 9 "${validate[@]}" --images outside=bad -o report
check refuses_the_pictures grep -q 'failed its calibration: light' err
cp els/calibration-light-level-0/picture.npy bad/calibration-light-level-0
expect pictures_of_something_else 9 "${validate[@]}" --images outside=bad -o report
rows
check another_camera_is_named grep -q '^refused/0/lock-step/.*level-0 are for another request: its "camera" differs' rows
check another_volume_is_named grep -q '^refused/1/lock-step/.*level-1 are for another request: its volume.nrrd differs' rows

# A volume that was left out to save room is known by its checksum.
rm bad/*/volume.nrrd && cp els/marschner-lobb-level-0/request.json bad/marschner-lobb-level-0 &&
    sed -i 's/"xxh3_64": "[0-9a-f]*"/"xxh3_64": "0123456789abcdef"/' bad/marschner-lobb-level-1/request.json
expect pictures_of_a_volume_that_was_left_out 9 "${validate[@]}" --images outside=bad -o report
rows
check the_other_volume_is_named grep -q '^refused/1/lock-step/.*level-1 are for another request: its "volume" differs' rows
notice the_same_volume_is_not_refused grep -q '^refused/0/' rows

# Pictures alone, by their names, without requests and calibrations; their index says what they are held to.
mkdir alone
cp els/marschner-lobb-level-0/step-0.125.npy alone/marschner-lobb-level-0.npy
cp els/calibration-slab-level-0/picture.npy alone/marschner-lobb-level-1.npy
echo '{"schema": "isoshade.pictures/1", "tier": "8 bits"}' >alone/pictures.json
expect pictures_alone_are_compared 9 "${validate[@]}" --images outside=alone -o report
rows
check within_what_integers_leave grep -q '^agree/0/stated limits/' rows
check another_size_is_named grep -q '^refused/1/stated limits/.*alone/marschner-lobb-level-1.npy has the shape (32, 32, 4), needs (10, 10, 4)' rows
check that_nothing_was_calibrated_is_said test "$(grep -c '^not calibrated: outside: .* stays open: ' out)" = 7
echo '{"schema": "isoshade.pictures/1", "tier": "limit"}' >alone/pictures.json
refuse a_limit_without_steps_is_refused 4 'pictures at two or more steps' "${validate[@]}" --images outside=alone -o no
refuse a_name_that_is_taken 2 'is taken' "${validate[@]}" --images gl=els -o no
refuse a_folder_that_is_not_there 3 'there is no folder nowhere' "${validate[@]}" --images outside=nowhere -o no
refuse words_without_a_folder 2 'must be NAME=DIR' "${validate[@]}" --images outside -o no

# A suite: scenes for which a request has no words are left out by name.
expect a_suite_is_written 0 "$ISOSHADE" scenes --suite "$top/refscenes/suite" --size 8 --steps 0 --write suite
check with_a_folder_a_scene test "$(find suite -name '*-level-0' | grep -vc calibration)" -ge 15
check what_is_left_out_is_told grep -q '^left out: .*first hits' out
exit $failed
