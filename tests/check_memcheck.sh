#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# valgrind's memcheck watches each reader on its seeds: no uninitialized value is used, and nothing is read beside
# what was allocated, in libraries of others either. Readers that are programs of their own are watched, too.
. "$(dirname "$0")/lib.sh"
fuzz=$(dirname "$(readlink -f "$ISOSHADE")")/isoshade-fuzz
[ -x "$fuzz" ] || { skip memcheck "isoshade-fuzz of the release is not built, as make check does"; exit 0; }
command -v valgrind >/dev/null || { skip memcheck "valgrind is not installed"; exit 0; }
mapfile -t names < <("$fuzz" --list | cut -d" " -f1 | grep -Ev "^(planted|hdf5|netcdf|zarr|dicom|slices|vdb)$")
# One process forks the others: valgrind starts once. What is lost at an exit is LeakSanitizer's to tell. ISOSHADE_SANDBOX
# lifts limits that are too narrow for valgrind.
memcheck() { # PROGRAM SEEDS NAME ...
    local program=$1
    shift
    ISOSHADE_SANDBOX=off OMP_NUM_THREADS=1 valgrind -q --error-exitcode=9 --leak-check=no "$program" --seeds "$@" >out 2>err
}
all_are_quiet() { # PROGRAM NAME ...
    local program=$1
    shift
    if memcheck "$program" "$top/tests/fuzz/seeds" "$@"; then
        for name; do check "$name" grep -q "^$name " out; done
    else
        not_ok readers_under_memcheck "$(grep -E 'fuzz:|==' err | head -n 20)"
    fi
}
all_are_quiet "$fuzz" "${names[@]}"
# Programs of their own, linked in: one start for all seeds.
for program in arrays:hdf5,netcdf,zarr itk:dicom,slices; do
    name=${program%:*} formats=${program#*:}
    [ -x "$fuzz-$name" ] || { skip "$name" "isoshade-fuzz-$name is not built"; continue; }
    all_are_quiet "$fuzz-$name" ${formats//,/ }
done
# OpenVDB's threads do not survive the fork: its reader runs as a program, with one log per process.
memcheck_programs() { # SEEDS NAME ...: true where nothing is found in any
    rm -f log.*
    ISOSHADE_SANDBOX=off OMP_NUM_THREADS=1 valgrind --trace-children=yes --vgdb=no --leak-check=no --log-file="$dir/log.%p" "$fuzz" \
        --seeds "$@" >out 2>err || return 1
    ! grep -h 'ERROR SUMMARY' log.* | grep -qv ' 0 errors'
}
watched() { grep -q "Command: .*/$1 " log.*; } # and it came to its end
if [ -x "$(dirname "$fuzz")/isoshade-vdb" ]; then
    check isoshade-vdb memcheck_programs "$top/tests/fuzz/seeds" vdb
    check isoshade-vdb_is_watched watched isoshade-vdb
else
    skip isoshade-vdb "it is not built"
fi
# Planted: a program that depends on an uninitialized value.
mkdir -p beside && cp "$fuzz" beside/ && cat >unset.c <<'END'
#include <stdlib.h>
int main(void) { int *volatile unset = malloc(sizeof *unset); return unset && *unset == 12; }
END
if cc -g -o beside/isoshade-vdb unset.c; then
    planted_program() { local fuzz=$dir/beside/isoshade-fuzz; memcheck_programs "$top/tests/fuzz/seeds" vdb; }
    notice what_a_planted_program_decides_by_is_found planted_program
    check and_nothing_else_failed test ! -s err
fi
# Planted: an uninitialized value; the same reader without it is quiet.
mkdir -p planted quiet/planted && echo '{"level": 12}' >planted/a.json && cp "$top/tests/fuzz/seeds/planted/"* quiet/planted/
notice a_planted_uninitialized_value_is_found memcheck "$fuzz" "$dir" planted
check and_it_is_what_was_found grep -q 'uninitialised' err
check what_is_set_is_not memcheck "$fuzz" "$dir/quiet" planted
exit $failed
