#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Runs the test programs of each build folder that is named, then the scripts once against the first folder, one more
# at a time than there are cores, and ends with one line "N passed, N failed"; with ", N skipped" where this system cannot run
# some, and before it a line for each reason. Test programs are cmocka's; scripts print "ok NAME", "not ok NAME: why" or
# "ok NAME # SKIP why" a case.
set -u
cd "$(dirname "$0")/.."
. tests/environment.sh
logs=$(mktemp -d) HOME=$(mktemp -d)
export HOME
trap 'rm -rf "$logs" "$HOME"' EXIT
# Libraries and popt keep memory until the end (a command runs once): not ours to report.
export LSAN_OPTIONS=suppressions=$PWD/tests/leaks.supp:print_suppressions=0
export ASAN_OPTIONS=detect_odr_violation=0
export ISOSHADE=$PWD/$1/isoshade

run_one() { # name, command ...: output and exit code into the logs; one line for people, with processor time and clock
    local name=$1 log=$logs/${1//\//_} start=$SECONDS verdict=pass busy TIMEFORMAT='%U %S'
    shift
    { time patiently "$@" >"$log.out" 2>&1 </dev/null; echo $? >"$log.code"; } 2>"$log.time"
    [ "$(cat "$log.code")" = 0 ] || verdict=FAIL
    busy=$(awk '{print $1 + $2}' "$log.time")
    printf '%s  %-48s %6.1f s of processor time, %3d s\n' $verdict "$name" "$busy" $((SECONDS - start))
    if [ $verdict = FAIL ]; then
        # The cause is at the beginning, and a sanitizer's findings may follow by the hundred.
        grep -vE '^\[ RUN|^\[       OK|^ok ' "$log.out" | awk '{line[NR] = $0}
            END {for (i = 1; i <= NR; ++i) if (i <= 30 || i > NR - 30) print line[i]; else if (i == 31) print "..."}'
    fi
}
# One more than cores: some wait for a disk, a limit of time or another program.
slots=$(($(nproc) + 1))
start() {
    while [ "$(jobs -rp | wc -l)" -ge "$slots" ]; do wait -n; done
    run_one "$@" &
}
# The slow ones first, so that none is left alone at the end.
for script in tests/check_*.sh tests/lab/check_*.sh; do start "${script#tests/}" bash "$script"; done
for build in "$@"; do
    for test in "$build"/tests/test_*; do
        [ -x "$test" ] && [ "${test%.o}" = "$test" ] && start "$build/$(basename "$test")" "$test"
    done
done
wait

passed=0 failed=0 skipped=0
for code in "$logs"/*.code; do
    out=${code%.code}.out
    s=$(grep -E '^(\[  SKIPPED \] [A-Za-z_0-9]+$|ok .* # SKIP )' "$out" | sort -u | grep -c .)
    p=$(grep -E '^(\[       OK \]|ok )' "$out" | grep -cv ' # SKIP ')
    f=$(grep -E '^(\[  FAILED  \] [A-Za-z_0-9]+$|not ok )' "$out" | sort -u | grep -c .)
    # A program that ends badly without a failed case, or that ran no case at all, is a failure.
    [ "$f" = 0 ] && { [ "$(cat "$code")" != 0 ] || [ $((p + s)) = 0 ]; } && f=1
    passed=$((passed + p)) failed=$((failed + f)) skipped=$((skipped + s))
done
[ $skipped = 0 ] || cat "$logs"/*.out | sed -n 's/^ok .* # SKIP //p; s/^\(Blender .* built without .*\)/\1/p' | sort | uniq -c | sed 's/^ *\([0-9]*\) /skipped (\1): /'
printf '%d passed, %d failed%s\n' $passed $failed "$([ $skipped = 0 ] || echo ", $skipped skipped")"
[ $failed = 0 ] && [ $passed -gt 0 ]
