#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# coverage.sh [READER ...]: which part of each reader's lines is reached by its seeds, what `make fuzz` left in build/fuzzed,
# and 20000 mutations (ISOSHADE_FUZZ_COUNT) in at most 20 s (ISOSHADE_FUZZ_SECONDS), by gcov.
set -u
cd "$(dirname "$0")/../.."
fuzz=$PWD/build/coverage/isoshade-fuzz
export OMP_NUM_THREADS=1
"$fuzz" --list | while read -r name sources; do
    [ "$name" != planted ] && { [ $# = 0 ] || [[ " $* " == *" $name "* ]]; } || continue
    find build/coverage -name '*.gcda' -delete
    "$fuzz" "$name" "tests/fuzz/seeds/$name" "${ISOSHADE_FUZZ_COUNT:-20000}" "${ISOSHADE_FUZZ_SECONDS:-20}" >/dev/null 2>&1
    [ ! -d "build/fuzzed/$name" ] || "$fuzz" "$name" "build/fuzzed/$name" >/dev/null 2>&1
    for source in $sources; do
        object=build/coverage/${source%.c}.o
        [ -f "$object" ] || continue # of a program of its own
        gcov -n -o "$object" "$source" 2>/dev/null | awk -v file="$source" -v name="$name" '
            $1 == "File" { here = ($2 == "\047" file "\047") }
            here && /^Lines executed/ { split($0, p, /[:% ]+/); printf "%-16s %-36s %6.1f %% of %d lines\n", name, file, p[3], p[5]; here = 0 }'
    done
done
