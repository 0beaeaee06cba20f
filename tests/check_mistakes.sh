#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Mistakes of doc/guide/numpy_renderer.py are named: each planted fault of test_external.c alone and in a pair, and none
# of the right program (planted.py).
. "$(dirname "$0")/lib.sh"
python_with numpy
cp "$top"/refscenes/marschner-lobb.{tf,scene}.json .
"$ISOSHADE" make marschner-lobb --size 20x22x21 -q -o v.nrrd
asked=(v.nrrd --scene marschner-lobb.scene.json --size 8 --levels 1 -q)
check requests_are_written "$ISOSHADE" scenes "${asked[@]}" --steps 1 --write requests
planted() { "$python" "$top/tests/planted.py" "$@"; }
planted draw requests >names
holds each_fault_is_planted_alone_and_in_a_pair "$(wc -l <names) == 34"
split -l 17 names part. # validate takes 32 renderers
for part in part.*; do
    expect "${part}_has_failed_calibrations" 9 "$ISOSHADE" validate "${asked[@]}" --quick --with reference -o "report-$part" \
        $(sed 's/.*/--images &=&/' "$part")
    check "${part}_has_the_names_of_its_mistakes" planted judge "report-$part/report.json"
done
# Planted: the names of two renderers, exchanged.
jq '.mistakes["fault-0"] as $name | .mistakes["fault-0"] = .mistakes["fault-1"] | .mistakes["fault-1"] = $name' \
    report-part.aa/report.json >exchanged.json
notice names_of_others_are_noticed planted judge exchanged.json
jq '.mistakes["right"] = .mistakes["fault-1"]' report-part.aa/report.json >accused.json
notice a_right_renderer_with_a_mistake_is_noticed planted judge accused.json
exit $failed
