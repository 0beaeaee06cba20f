#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# valgrind's memcheck watches each reader on its seeds: no uninitialized value is used, and nothing is read beside
# what was allocated, in libraries of others either. Readers that are programs of their own are not watched.
. "$(dirname "$0")/lib.sh"
fuzz=$(dirname "$(readlink -f "$ISOSHADE")")/isoshade-fuzz
[ -x "$fuzz" ] || { skip memcheck "isoshade-fuzz of the release is not built, as make check does"; exit 0; }
command -v valgrind >/dev/null || { skip memcheck "valgrind is not installed"; exit 0; }
mapfile -t names < <("$fuzz" --list | cut -d' ' -f1 | grep -v planted)
# One process forks the others: valgrind starts once. What is lost at an exit is LeakSanitizer's to tell.
memcheck() { # SEEDS NAME ...
    OMP_NUM_THREADS=1 valgrind -q --error-exitcode=9 --leak-check=no "$fuzz" --seeds "$@" >out 2>err
}
if memcheck "$top/tests/fuzz/seeds" "${names[@]}"; then
    for name in "${names[@]}"; do check "$name" grep -q "^$name " out; done
else
    not_ok readers_under_memcheck "$(grep -E 'fuzz:|==' err | head -n 20)"
fi
# One log a process. Programs that were left out of the build are not asked for.
memcheck_programs() { # SEEDS NAME ...: true where nothing is found in any
    rm -f log.*
    ISOSHADE_SANDBOX=off OMP_NUM_THREADS=1 valgrind --trace-children=yes --vgdb=no --leak-check=no --log-file="$dir/log.%p" "$fuzz" \
        --seeds "$@" >out 2>err || return 1
    ! grep -h 'ERROR SUMMARY' log.* | grep -qv ' 0 errors'
}
watched() { grep -q "Command: .*/$1 " log.*; } # and it came to its end
for program in isoshade-arrays:hdf5,netcdf,zarr isoshade-itk:dicom,slices isoshade-vdb:vdb; do
    name=${program%:*} formats=${program#*:}
    [ -x "$(dirname "$fuzz")/$name" ] || { skip "$name" "it is not built"; continue; }
    check "$name" memcheck_programs "$top/tests/fuzz/seeds" ${formats//,/ }
    check "${name}_is_watched" watched "$name"
done
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
notice a_planted_uninitialized_value_is_found memcheck "$dir" planted
check and_it_is_what_was_found grep -q 'uninitialised' err
check what_is_set_is_not memcheck "$dir/quiet" planted
exit $failed
