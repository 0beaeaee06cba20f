#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# valgrind's memcheck watches each reader on its seeds: nothing is decided by a value that nobody set, and nothing read beside
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
# A value that nobody set decides; the same reader without it is quiet.
mkdir -p planted quiet/planted && echo '{"level": 12}' >planted/a.json && cp "$top/tests/fuzz/seeds/planted/"* quiet/planted/
notice a_planted_value_that_nobody_set_is_found memcheck "$dir" planted
check and_it_is_what_was_found grep -q 'uninitialised' err
check what_is_set_is_not memcheck "$dir/quiet" planted
exit $failed
