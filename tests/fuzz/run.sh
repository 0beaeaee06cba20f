#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# run.sh SECONDS [READER ...]: each reader for so long, from its seeds and what earlier runs found in build/fuzzed/READER; a
# line each with the number of runs. By clang's libFuzzer, which is led by what code an input reaches; where clang is not
# installed by the driver of `make check`. Those that are programs of their own are called within a driver of theirs.
# Readers run as many at a time as there are cores. Exit code 1: something was found; the input lies in build/fuzzed, and
# goes to tests/fuzz/seeds/READER when it is corrected.
set -u
cd "$(dirname "$0")/../.."
seconds=$1
shift
export LSAN_OPTIONS=suppressions=$PWD/tests/leaks.supp:print_suppressions=0 OMP_NUM_THREADS=1
# What libraries of tests/fuzz/third_party.sh do wrong stops it too.
export UBSAN_OPTIONS=halt_on_error=1:print_stacktrace=1:suppressions=$PWD/tests/fuzz/third_party.supp
# With libFuzzer and with OpenMP's header and library, which are packages of their own.
has_clang() { printf '#include <omp.h>\nint LLVMFuzzerTestOneInput(const char *d, unsigned long n) { return !d && n > (unsigned long)omp_get_max_threads(); }\n' |
    "${FUZZ_CC:-clang}" -x c -fsanitize=fuzzer,address -fopenmp - -o build/has-clang 2>/dev/null; }
make="${MAKE:-make} --no-print-directory -j$(nproc) SETUP=no"
mkdir -p build
if has_clang; then
    $make config=fuzz CC="${FUZZ_CC:-clang}" CXX="${FUZZ_CXX:-clang++}" READER_CXX=g++ FUZZ_LIBS="${FUZZ_LIBS:-}" build/fuzz/isoshade-libfuzzer || exit 1
else
    $make config=sanitize all build/sanitize/isoshade-fuzz || exit 1
fi
$make config=sanitize fuzz-programs || exit 1
. tests/fuzz/programs.sh
names=${*:-$(grep -oE '^    \{"[a-z0-9_]+", "[^"]' tests/fuzz/targets.c | cut -d'"' -f2 | grep -v planted)}
out=$PWD/build/fuzzed
mkdir -p "$out"

words_of() { # of the reader and of its family
    local file
    for file in "tests/fuzz/words/$1" "tests/fuzz/words/${1%%_*}"; do [ -f "$file" ] && { echo "$file"; return; }; done
}
# Within the driver: what libraries do wrong ends a process, and the run goes on.
run_in_process() { # NAME LOG
    (cd "$out" && ASAN_OPTIONS=symbolize=0:max_allocation_size_mb=64:allocator_may_return_null=1:detect_odr_violation=0:abort_on_error=1:handle_abort=0 \
        "../sanitize/isoshade-fuzz$(driver_of "$1")" "$1" "../../tests/fuzz/seeds/$1" 1000000000000 "$seconds" "$RANDOM") >"$2" 2>&1 || return 1
    ! is_ours "$2"
}
run_one() {
    local name=$1 log=$out/$1.log words
    words=$(words_of "$name")
    mkdir -p "$out/$name"
    if [ -n "$(driver_of "$name")" ] && [ -x "build/sanitize/isoshade-fuzz$(driver_of "$name")" ]; then
        run_in_process "$name" "$log"
    elif [ -x build/fuzz/isoshade-libfuzzer ]; then
        ISO_FUZZ=$name ISO_FUZZ_WORDS=$words build/fuzz/isoshade-libfuzzer "$out/$name" "tests/fuzz/seeds/$name" \
            ${words:+-dict="$words"} -max_total_time="$seconds" -max_len=16384 -timeout=20 -rss_limit_mb=4096 -malloc_limit_mb=384 \
            -reload=0 -print_final_stats=1 -artifact_prefix="$out/$name-" >"$log" 2>&1
    else
        (cd "$out" && ../sanitize/isoshade-fuzz "$name" "../../tests/fuzz/seeds/$name" 1000000000000 "$seconds" "$RANDOM") >"$log" 2>&1
    fi
    local code=$? runs
    runs=$(sed -n 's/^stat::number_of_executed_units: //p; s/.* \([0-9]*\) mutations, .*/\1/p' "$log" | tail -n 1)
    [ -n "$runs" ] || runs=$(grep -oE '^#[0-9]+' "$log" | tail -n 1 | tr -d '#')
    echo "$name sanitizers - ${runs:-0} $seconds" >>"$out/counts"
    [ $code = 0 ] || echo "$name sanitizers - found" >>"$out/counts"
    printf '%-16s %10s runs%s\n' "$name" "${runs:-0}" "$([ $code = 0 ] || echo "  FOUND: $(grep -m 1 -E 'ERROR|runtime error|a contract' "$log" | cut -c1-100) ($log)")"
    return $code
}
failed=0
for name in $names; do
    while [ "$(jobs -rp | wc -l)" -ge "${FUZZ_JOBS:-$(nproc)}" ]; do wait -n || failed=1; done
    run_one "$name" &
done
while [ -n "$(jobs -rp)" ]; do wait -n || failed=1; done
exit $failed
