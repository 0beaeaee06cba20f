#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# A sample of `make faults`: calls that fail, kills, disturbed pipelines, from fixed seeds.
. "$(dirname "$0")/lib.sh"
cd "$top" || exit 1
if [ "$(uname -m)" != x86_64 ] || ! gcc --version >/dev/null 2>&1; then
    skip calls_that_fail "tests/faults/shim.c is for gcc on x86-64"
    exit 0
fi
sampled() { python3 tests/faults/faults.py --sample 3 --only "make gzip,info pyramid,build again,render reference,compare,tf adapt" "$@"; }
# Two runs that took as long to three digits are no reason to ask the same of all others.
said() { (cd tests/faults && python3 -c 'import sys, world; sys.exit(world.without_durations(sys.argv[1]) != world.without_durations(sys.argv[2]))' "$@"); }
check how_long_it_took_is_not_compared said "o.exr: 8 x 8 pixels, 0.9 s" "o.exr: 8 x 8 pixels, 1.2e+02 s"
expect all_else_is 1 said "o.exr: 8 x 8 pixels, 0.9 s" "o.exr: 9 x 8 pixels, 0.9 s"
check calls_that_fail_once_end_well sampled
read_once() { python3 tests/faults/faults.py --kinds read "$@"; }
check reads_that_fail_are_no_damage read_once --only "info angstrom,info imagej,info phantom.mrc,info text.vtk"
check programs_that_read_cannot_be_started python3 tests/faults/faults.py --kinds open,start --only "info v.vdb"
check a_folder_that_cannot_be_made_is_no_want_of_memory python3 tests/faults/faults.py --kinds make --only scenes
if command -v povray >/dev/null; then
    check a_picture_that_cannot_be_read_is_not_povrays_fault read_once --only "render povray"
fi
if command -v gnuplot >/dev/null; then
    check a_script_with_a_hole_is_not_drawn python3 tests/faults/faults.py --kinds write --only "tf show"
fi
check what_a_build_goes_on_from_stays python3 tests/faults/faults.py --only "build --resume" --kinds memory,read --sample 12
check so_do_large_allocations python3 tests/faults/faults.py --large --sample 3 --only "build,render reference,export vdb"
check kills_leave_nothing_broken python3 tests/faults/kills.py --count 6 --only "build again,render reference"
check pipelines_lose_nothing python3 tests/pipelines.py --count 5 --seed 7
exit $failed
