#!/usr/bin/env bash
# Runs the tests of each build folder that is named, then the scripts once against the first, and ends with one
# line "N passed, N failed". Test programs are cmocka's; scripts print "ok NAME" or "not ok NAME: why" a case.
set -u
cd "$(dirname "$0")/.."
passed=0 failed=0
count() { # the output of one test
    local p f
    p=$(grep -cE '^(\[       OK \]|ok )' <<<"$1")
    f=$(grep -E '^(\[  FAILED  \] [A-Za-z_0-9]+$|not ok )' <<<"$1" | sort -u | grep -c .)
    passed=$((passed + p)) failed=$((failed + f))
    [ "$2" = 0 ] || [ "$f" -gt 0 ] || failed=$((failed + 1))
    [ "$2" = 0 ] && [ $((p + f)) = 0 ] && { echo "$3 ran no test"; failed=$((failed + 1)); }
    return 0
}
run() { # name, command ...
    local name=$1 output code start=$SECONDS
    shift
    output=$(timeout 900 "$@" 2>&1 </dev/null)
    code=$?
    count "$output" $code "$name"
    if [ $code = 0 ]; then
        printf 'pass  %-48s %3d s\n' "$name" $((SECONDS - start))
    else
        printf 'FAIL  %-48s exit code %d\n' "$name" $code
        grep -vE '^\[ RUN|^\[       OK|^ok ' <<<"$output" | tail -n 60
    fi
}
# Mesa and Blender's libraries keep memory until the end: not ours to report.
export LSAN_OPTIONS=suppressions=$PWD/tests/leaks.supp:print_suppressions=0
export ASAN_OPTIONS=detect_odr_violation=0
for build in "$@"; do
    for test in "$build"/tests/test_*; do
        [ -x "$test" ] && [ "${test%.o}" = "$test" ] && run "$build/$(basename "$test")" "$test"
    done
done
export ISOSHADE=$PWD/$1/isoshade
for script in tests/check_*.sh; do
    [ -e "$script" ] && run "$(basename "$script")" bash "$script"
done
printf '%d passed, %d failed\n' $passed $failed
[ $failed = 0 ] && [ $passed -gt 0 ]
