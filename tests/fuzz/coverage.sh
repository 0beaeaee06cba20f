#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# coverage.sh [READER ...]: which part of each reader's lines is reached by its seeds, what `make fuzz` left in build/fuzzed,
# and 20000 mutations (ISOSHADE_FUZZ_COUNT) in at most 20 s (ISOSHADE_FUZZ_SECONDS), by gcov.
set -u
cd "$(dirname "$0")/../.."
top=$PWD all=$PWD/build/coverage/isoshade-fuzz
export OMP_NUM_THREADS=1
. tests/fuzz/programs.sh
# notes_of SOURCE: the object next to which gcov's notes lie; those of readers (.cc) are in a folder of their own
notes_of() { if [[ $1 == *.cc ]]; then echo "build/coverage/readers/${1%.cc}.o"; else echo "build/coverage/${1%.c}.o"; fi; }
"$all" --list | while read -r name sources; do
    [ "$name" != planted ] && { [ $# = 0 ] || [[ " $* " == *" $name "* ]]; } || continue
    program=$(driver_of "$name") fuzz=$all$(driver_of "$name")
    [ -x "$fuzz" ] || continue # built without its library
    find build/coverage -name '*.gcda' -delete
    mkdir -p build/fuzzed # where an input stays at which a reader was ended
    (cd build/fuzzed && "$fuzz" "$name" "$top/tests/fuzz/seeds/$name" "${ISOSHADE_FUZZ_COUNT:-20000}" "${ISOSHADE_FUZZ_SECONDS:-20}") >/dev/null 2>&1
    [ ! -d "build/fuzzed/$name" ] || "$fuzz" "$name" "build/fuzzed/$name" >/dev/null 2>&1
    for source in $sources; do
        notes=$(notes_of "$source" "$program")
        [ -f "$notes" ] || continue
        gcov -n -o "$notes" "$source" 2>/dev/null | awk -v file="$source" -v name="$name" '
            $1 == "File" { here = ($2 == "\047" file "\047") }
            here && /^Lines executed/ { split($0, p, /[:% ]+/); printf "%-16s %-36s %6.1f %% of %d lines\n", name, file, p[3], p[5]; here = 0 }'
    done
done
