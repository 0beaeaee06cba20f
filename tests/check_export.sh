#!/usr/bin/env bash
# The command export: what it writes, what it says, and that a refusal leaves nothing behind.
set -u
top=$(cd "$(dirname "$0")/.." && pwd)
program=${ISOSHADE:-$top/isoshade}
scene=$top/refscenes/shells.scene.json
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work" || exit 1
bad=0
ok() { echo "ok $1"; }
not_ok() { echo "not ok $1: $2"; bad=1; }
is() { # name, command: must succeed
    local name=$1 output
    shift
    if output=$("$@" 2>&1); then ok "$name"; else not_ok "$name" "$(tail -n 2 <<<"$output")"; fi
}
refuses() { # name, exit code, word of the message, command: one line on stderr, nothing new in the folder
    local name=$1 code=$2 word=$3 before after message got
    shift 3
    before=$(ls -A)
    message=$("$@" 2>&1 >/dev/null)
    got=$?
    after=$(ls -A)
    if [ "$got" != "$code" ]; then not_ok "$name" "exit code $got, wanted $code: $message"
    elif [ "$(wc -l <<<"$message")" != 1 ] || ! grep -q -- "$word" <<<"$message"; then not_ok "$name" "message: $message"
    elif [ "$before" != "$after" ]; then not_ok "$name" "left $after"
    else ok "$name"; fi
}
size() { stat -c %s "$1"; }

"$program" make shells --size 21x30x17 --spacing 1x1x2 -q -o v.nrrd || exit 1
is vdb_of_three_levels "$program" export v.nrrd --to vdb --levels 3 -q -o v.vdb
is vdb_of_halves "$program" export v.nrrd --to vdb --levels 3 --half -q -o half.vdb
[ "$(size half.vdb)" -lt "$(size v.vdb)" ] && ok halves_are_smaller || not_ok halves_are_smaller "$(size half.vdb) bytes"

"$program" export v.nrrd --to blender --scene "$scene" --levels 2 --adapt --json -q -o two.blend >two.json 2>err &&
    grep -q '"max_color_difference"' two.json && [ -e two_level_0.vdb ] && [ -e two_level_1.vdb ] && [ ! -e two_level_2.vdb ] &&
    ok blend_of_two_levels_tells_the_loss_of_its_ramp || not_ok blend_of_two_levels_tells_the_loss_of_its_ramp "$(cat err)"
is blend_of_one_level "$program" export v.nrrd --to blender --scene "$scene" --level 1 -q -o one.blend
[ -e one.vdb ] && ok the_grid_has_the_name_of_the_blend || not_ok the_grid_has_the_name_of_the_blend "$(ls)"

refuses no_blend_ending 2 ".blend" "$program" export v.nrrd --to blender --scene "$scene" -q -o scene.bld
refuses a_name_that_is_not_utf8 2 "UTF-8" "$program" export v.nrrd --to blender --scene "$scene" -q -o "$(printf 'a\351b.blend')"
refuses no_scene 2 "--scene" "$program" export v.nrrd --to blender -q -o x.blend
refuses no_folder 3 "nowhere" "$program" export v.nrrd --to blender --scene "$scene" -q -o nowhere/x.blend
refuses no_such_level 5 "levels 0 to" "$program" export v.nrrd --to vdb --level 9 -q -o x.vdb
refuses no_blender 7 "blender" env ISOSHADE_BLENDER=/nonexistent/blender "$program" export v.nrrd --to blender --scene "$scene" -q -o x.blend
refuses a_blender_that_fails 8 "exit code 1" env ISOSHADE_BLENDER=/bin/false "$program" export v.nrrd --to blender --scene "$scene" -q -o x.blend
refuses halves_for_blender 2 "--half" "$program" export v.nrrd --to blender --scene "$scene" --half -q -o x.blend
refuses a_step_for_vdb 2 "--step" "$program" export v.nrrd --to vdb --step 0.5 -q -o x.vdb
refuses adapted_vdb 2 "--adapt" "$program" export v.nrrd --to vdb --adapt -q -o x.vdb
exit $bad
