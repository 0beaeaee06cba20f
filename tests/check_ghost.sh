#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# A head whose rest and whose skin have the same means two levels down: the message about the skin's ghost, which is not
# drawn. tests/test_ghost.c has the measure.
. "$(dirname "$0")/lib.sh"
python3 - <<'END' || exit 1
import struct
n = 64
def value(x, y, z):
    r = ((x + .5 - n / 2) ** 2 + (y + .5 - n / 2) ** 2 + (z + .5 - n / 2) ** 2) ** .5
    return 140 if 1 <= x < 3 or n - 3 <= x < n - 1 else 200 if r < 12 else 80 if r < 25 else 0
with open("head.nrrd", "wb") as f:
    f.write(b"NRRD0004\ntype: uchar\ndimension: 3\nsizes: %d %d %d\nspacings: 1 1 1\nencoding: raw\n\n" % (n, n, n))
    f.write(bytes(value(x, y, z) for z in range(n) for y in range(n) for x in range(n)))
import json
points = [[0, 0], [118, 0], [122, 0.6], [255, 0.6]]
json.dump({"schema": "isoshade.tf/1", "range": [0, 255], "unit_distance_mm": 1, "color_space": "linear", "table_size": 256,
           "points": [{"value": v, "r": .9, "g": .8, "b": .6, "opacity": a} for v, a in points]}, open("bone.tf.json", "w"))
END
"$ISOSHADE" build head.nrrd --no-labels -o head.iso --levels 3 -q >/dev/null || exit 1
render() { "$ISOSHADE" render head.iso --tf bone.tf.json --level 2 --size 32 --adapt --with reference --quadrature midpoint -q "$@"; }

expect adapted 0 render -o kept.exr
grep -q 'note: level 2: .* would draw a ghost, .* original transfer function; --extinction-scale' err && ok what_is_left_out_is_said || not_ok what_is_left_out_is_said "$(cat err)"
expect always 0 render --always -o ghost.exr
grep -q 'warning: level 2: .* draws a ghost' err && ok what_is_drawn_is_said || not_ok what_is_drawn_is_said "$(cat err)"
expect scaled 0 render --extinction-scale -o scaled.exr
grep -q ghost err && not_ok a_scale_draws_none "$(cat err)" || ok a_scale_draws_none
"$ISOSHADE" compare kept.exr ghost.exr --json >differ.json
python3 -c 'import json; assert json.load(open("differ.json"))["rmse"] > 0.01' && ok the_ghost_would_show || not_ok the_ghost_would_show "$(cat differ.json)"
expect exported 0 "$ISOSHADE" export head.iso --to povray --tf bone.tf.json --level 2 --size 16 --adapt -o pov -q
grep -q 'export: note: level 2: .* ghost' err && ok export_says_it || not_ok export_says_it "$(cat err)"
expect tables 0 "$ISOSHADE" tf adapt head.iso --tf bone.tf.json -o head -q
grep -A1 '^level 2' out | grep -q 'a ghost of .* is left out' && ok tf_adapt_says_it || not_ok tf_adapt_says_it "$(cat out)"

# Thin vessels break up at level 1: the message names the option that keeps them, with which they are nearer to level 0.
"$ISOSHADE" make vessels --size 48 -q -o vessels.nrrd && "$ISOSHADE" make shells --size 48 -q -o shells.nrrd || exit 1
thin() { "$ISOSHADE" render "$1.nrrd" --size 48 --with cpu -q "${@:2}"; }
expect thin_ones 0 thin vessels --level 1 --adapt -o broken.exr
check what_breaks_up_is_named grep -qE 'warning: level 1 lacks 1[0-9] % of .* --extinction-scale keeps them' err
expect with_a_scale 0 thin vessels --level 1 --adapt --extinction-scale -o kept.exr
notice a_scale_is_not_warned_of grep -q lacks err
expect and_level_0 0 thin vessels -o fine.exr
for name in broken kept; do "$ISOSHADE" compare fine.exr $name.exr --json >$name.json; done
holds with_it_they_are_nearer "$(json_number kept.json rmse) < 0.85 * $(json_number broken.json rmse)"
expect thick_ones 0 thin shells --level 1 --adapt -o shells.exr
notice are_not_warned_of grep -q lacks err
exit $failed
