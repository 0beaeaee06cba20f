#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Which Blender, and which device: what is not there, is no Blender or is too old is refused by name. Two Blenders are
# compared with each other, and a fault of one of them is found.
. "$(dirname "$0")/lib.sh"
scene=$top/refscenes/marschner-lobb.scene.json
"$ISOSHADE" make shells --size 9 -q -o s.nrrd || exit 1
mkdir suite && cp "$top/refscenes/suite/constant.scene.json" suite
says() { printf '%s\n' '#!/bin/sh' "$2" >"$1" && chmod +x "$1"; }
says old 'echo "Blender 2.93.4"'
says other 'echo "Some other program 5.1"'
says dead 'exit 3'
with() { "$ISOSHADE" render s.nrrd --scene "$scene" --with cycles --size 8 -q -o o.exr "$@"; }
refuse one_that_is_not_there 7 "Blender: ./nowhere is no executable file" with --blender ./nowhere
refuse nor_on_path 7 "Blender: no-such-blender is not found on PATH" with --blender no-such-blender
refuse one_that_is_too_old 7 "old: Blender 2.93.4 is too old; needs 3.4 or newer" with --blender ./old
refuse another_program 8 "other: --version names no version of Blender" with --blender ./other
refuse one_that_fails 8 "dead: exit code 3" with --blender ./dead
refuse the_second_of_two 7 "old: Blender 2.93.4 is too old" "$ISOSHADE" validate s.nrrd --scene "$scene" --blender "blender,./old" -q -o r
refuse an_empty_name 2 "a name is empty" with --blender ,
refuse without_cycles 2 "leaves out" "$ISOSHADE" validate s.nrrd --scene "$scene" --with gl --blender blender -q -o r
refuse no_such_device 2 "must be one of: cpu, gpu, optix" with --cycles-device fast
refuse nor_by_the_environment 2 "must be one of: cpu, gpu, optix" env ISOSHADE_CYCLES_DEVICE=fast "$ISOSHADE" render s.nrrd --scene "$scene" --with cycles --size 8 -q -o o.exr
refuse a_device_that_is_not_here 7 "has no metal device here; available: cpu" with --cycles-device metal
has_cycles || { skip two_blenders "$lack"; exit $failed; }

# The same Blender, whose exposure is wrong in pictures of 13 columns: no picture of the calibration has as many.
says faulty 'for a; do case $a in */build_scene.py) sed -i "s/^    set_device(cycles, about)\$/&; cycles.film_exposure = 1.05 if about[\"image\"][0] == 13 else 1/" "$a" ;; esac; done
exec blender "$@"'
expect a_fault_of_one_of_two 1 "$ISOSHADE" validate --suite suite --size 13x12 --seeds 2 --threads 1 --with cycles --blender blender,./faulty -q -o two
verdict() { python3 -c "
import json, re, sys
print(next(row['verdict'] for row in json.load(open('two/report.json'))['agreement'] if re.fullmatch(sys.argv[1], row['b'])))" "$1"; }
check the_first_agrees test "$(verdict 'cycles, limit')" = agree
check the_other_differs test "$(verdict 'cycles-[0-9.]*, limit')" = differ
check and_so_do_both_from_each_other test "$(verdict 'cycles-[0-9.]*, beside the first')" = differ
check the_pixel_is_named grep -q 'against cycles: largest change' out
check the_device_is_in_the_report grep -q '"Blender Cycles": "Blender [0-9.]* on CPU"' two/report.json
exit $failed
