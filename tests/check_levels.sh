#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# A pyramid whose levels were put in from another volume, checksums and all, is found out; one that is whole is not.
. "$(dirname "$0")/lib.sh"
python_with numpy
scene=$top/refscenes/marschner-lobb.scene.json
swap() { # FROM.iso KEY:LEVEL ...: a.iso with these, as bad.iso
    local from=$1
    shift
    rm -rf bad.iso && cp -r a.iso bad.iso && "$python" "$top/tests/swap_levels.py" "$from" bad.iso "$@"
}
# A mismatch: exit code 1, and the message.
found() { # NAME WORDS COMMAND
    local name=$1 words=$2
    shift 2
    expect "$name" 1 "$@"
    check "${name}_by_name" grep -q -- "$words" err
}
validate() { "$ISOSHADE" validate "$1" --scene "$scene" --quick --with gl --size 16 -q -o "report-$1"; }

"$ISOSHADE" make marschner-lobb --size 23x18x29 --spacing 1x1x2.5 -q -o a.nrrd
"$ISOSHADE" make noise --size 23x18x29 --spacing 1x1x2.5 -q -o b.nrrd
for v in a b; do
    "$ISOSHADE" build $v.nrrd -q --keep-magnitude --keep-float -o $v.iso >/dev/null
done

expect a_pyramid_is_described 0 "$ISOSHADE" info a.iso
check with_what_built_it grep -q 'built by   isoshade [0-9]' out
# The verdict for levels by as many views as one asks for; the report keeps how many they were.
expect more_views_of_the_levels 0 "$ISOSHADE" validate a.nrrd --scene "$scene" --with gl --levels 2 --size 16 --level-views 8 --level-size 20 -q -o report-views
cat >views.py <<'PY'
import json
r = json.load(open("report-views/report.json"))
assert r["options"]["level_views"] == 8 and r["options"]["level_size"] == 20, r["options"]
assert r["levels"][0]["views"] == 8 and len(set(r["consistency"][0]["by_view"]["rmse"])) == 8, r["consistency"][0]
PY
check as_many_as_were_asked_for python3 views.py
refuse too_many_views 2 "must be 2 to 20" "$ISOSHADE" validate a.nrrd --scene "$scene" --with gl --level-views 21 -q -o no
expect levels_of_their_own_level_0_pass 0 "$ISOSHADE" info a.iso --verify
check each_of_them test "$(grep -c 'voxels are made from level 0' out)" = 4
refuse a_volume_has_no_levels_to_verify 2 "a.nrrd: a volume; --verify needs a pyramid" "$ISOSHADE" info a.nrrd --verify

swap b.iso codes:1 codes:2 scalar:2
found levels_of_another_volume_are_found "level 1: .* voxels are not made from level 0" "$ISOSHADE" info bad.iso --verify
expect as_data 1 "$ISOSHADE" info bad.iso --verify --json
cat >found.py <<'PY'
import json
levels = json.load(open("out"))["levels"]
assert [l["what_differs"] for l in levels] == [None, "directions", "values", None], levels
assert levels[1]["differing_voxels"] > 500 and levels[1]["first_voxel"] == [0, 0, 0], levels[1]
PY
check with_level_voxel_and_count python3 found.py
for file in codes:0 directions:0 magnitude:0 scalar:1 directions:1 magnitude:3; do
    swap b.iso $file
    found "another_volume's_${file}_is_found" "level ${file#*:}" "$ISOSHADE" info bad.iso --verify
done
swap b.iso scalar:0
found another_level_0_is_found "level 0" "$ISOSHADE" info bad.iso --verify

# Joint histograms that adapting left beside the levels: counted again. Those of other levels of the same volume have the
# same bins and the same sum.
cp -r a.iso joint-a.iso
"$ISOSHADE" build a.nrrd -q --scalar-filter gauss -o joint-b.iso >/dev/null
for v in a b; do
    "$ISOSHADE" tf adapt joint-$v.iso --tf "$top/refscenes/marschner-lobb.tf.json" -q -o adapted-$v >/dev/null
done
expect histograms_that_belong_pass 0 "$ISOSHADE" info joint-a.iso --verify
check each_histogram_is_counted_again test "$(grep -c 'counts all 12006 voxels as its levels do' out)" = 3
name=$(basename "$(ls joint-a.iso/level_2_joint*)")
cp "joint-b.iso/$name" joint-a.iso
found the_histogram_of_other_levels_is_found "level 2: its joint histogram .* counts [0-9]* of 12006 voxels in other bins" \
    "$ISOSHADE" info joint-a.iso --verify
expect and_is_data 1 "$ISOSHADE" info joint-a.iso --verify --json
cat >joints.py <<'PY'
import json
joints = json.load(open("out"))["joint_histograms"]
assert [j["level"] for j in joints] == [1, 2, 3], joints
assert [j["differing_voxels"] > 0 for j in joints] == [False, True, False], joints
PY
check with_its_level python3 joints.py
found validation_counts_again_too "level 2: its joint histogram" validate joint-a.iso
echo cut >"joint-a.iso/$name"
found a_cut_histogram_is_found "level 2: its joint histogram .* does not belong to this pyramid" "$ISOSHADE" info joint-a.iso --verify

# One bit of one voxel, with its checksum; a range and a box that are not level 0's.
swap a.iso codes:1
cat >plant.py <<'PY'
import json
import os
import re
import subprocess
import sys

sys.path.insert(0, os.environ["TESTS"])
from read_iso import write_description

path = "bad.iso/pyramid.json"
about = json.load(open(path))
level = about["levels"][1]
what = sys.argv[1]
if what == "bit":
    name = "bad.iso/" + level["files"]["codes"]["name"]
    data = bytearray(open(name, "rb").read())
    data[-1] ^= 1
    open(name, "wb").write(data)
    said = subprocess.run([os.environ["ISOSHADE"], "info", "bad.iso", "--verify"], capture_output=True, text=True).stderr
    level["files"]["codes"]["xxh3_64"] = re.search("checksum ([0-9a-f]*)", said)[1]
elif what == "range":
    about["levels"][0]["max"] *= 2
else:
    level["geometry"]["box_index"][0] -= 0.25
write_description(path, about)
PY
export TESTS=$top/tests
"$python" plant.py bit
found a_single_bit_is_found "level 1: 1 of 1620 voxels .* (11, 8, 14), by its directions" "$ISOSHADE" info bad.iso --verify
swap a.iso codes:1 && "$python" plant.py range
found a_range_is_found "level 0: its range" "$ISOSHADE" info bad.iso --verify
swap a.iso codes:1 && "$python" plant.py box
found a_box_is_found "level 1: its geometry" "$ISOSHADE" info bad.iso --verify

# All renderers are given the same wrong levels, so that they agree: validation has to see it by itself.
swap b.iso codes:1 codes:2 scalar:2
found validation_says_so "level 1: .* voxels are not made from level 0" validate bad.iso
cat >rows.py <<'PY'
import json
rows = [r for r in json.load(open("report-bad.iso/report.json"))["calibration"] if r["renderer"] == "pyramid"]
assert [r["verdict"] for r in rows] == ["pass", "fail", "fail", "pass"], rows
levels = json.load(open("report-bad.iso/report.json"))["levels"]  # what is drawn beside them is not these levels again
assert [r["stored"]["held"] for r in levels] == [False, False, True], levels
PY
check a_row_a_level python3 rows.py
expect a_pyramid_that_is_whole_is_validated 0 validate a.iso
check and_said_to_be_verified grep -q '"levels_verified": "yes' report-a.iso/report.json
expect a_volume_needs_none_of_it 0 validate a.nrrd
check and_says_so grep -q '"levels_verified": "no: built for this validation"' report-a.nrrd/report.json

# Every estimator, filter, code and type of samples, without a false alarm.
alarms=0
clean() { # TYPE, options of build
    "$ISOSHADE" make noise --size 13x10x11 --type "$1" -q -o t.nrrd
    shift
    "$ISOSHADE" build t.nrrd -q --levels 5 --keep-float --keep-magnitude "$@" -o t.iso >/dev/null
    "$ISOSHADE" info t.iso --verify -q >out 2>&1 || { echo "false alarm: $*" && cat out && alarms=$((alarms + 1)); }
}
types=(uint8 int8 uint16 int16 uint32 int32 float double)
i=0
for code in fit snorm shell free cube region48; do
    for filter in moments eq1 naive tensor; do
        estimators=(central intermediate sobel corners fourth smooth bspline)
        clean "${types[i % 8]}" --code $code --direction-filter $filter --estimator "${estimators[i % 7]}" \
            --scalar-filter "$( ((i / 4 % 2)) && echo gauss || echo mean)"
        i=$((i + 1))
    done
done
check no_code_and_no_filter_gives_a_false_alarm test $alarms = 0
# A thin plate in a narrow TF, by steps of a whole voxel: the error of the steps alone puts a picture above its bound, so both
# are drawn again with finer steps.
"$ISOSHADE" make plate --size 35x18x11 --spacing 1.701x2.987x1.852 --type int16 --seed 93054 -q -o plate.nrrd
"$ISOSHADE" validate plate.nrrd --scene "$top/tests/narrow.scene.json" --quick --levels 2 --with gl,cpu --level-size 25 -q -o narrow >/dev/null 2>&1
cat >steps.py <<'PY'
import json
r = json.load(open("narrow/report.json"))
row = r["levels"][0]
own = next(c for c in r["consistency"] if c["level"] == 1 and c["method"] == row["method"] and c["tf"] == row["tf"])
assert row["bound"]["held"] and row["bound"]["rmse"] < own["rmse_mean"] - 1e-3, (row["bound"], own["rmse_mean"])
PY
check the_error_of_steps_fails_no_level "$python" steps.py
exit $failed
