#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# run.sh PROGRAM: what works with several threads (threads.c), each part under clang's sanitizer of threads, and a race that is
# planted. OpenMP's locks and barriers are seen through libarcher of clang's OpenMP library. `make threads`.
set -u
cd "$(dirname "$0")/../.."
program=$1 failed=0
archer=$(ls /usr/lib/llvm-*/lib/libarcher.so 2>/dev/null | sort -V | tail -n 1)
if [ -z "$archer" ]; then
    echo "libarcher.so of clang's OpenMP library is not installed (libomp-dev): what it waits for would look like races" >&2
    exit 1
fi
export OMP_TOOL_LIBRARIES=$archer
# Code of libraries that were not compiled for it is left out.
export TSAN_OPTIONS="ignore_noninstrumented_modules=1 exitcode=66"
races() { # PART: prints its races, in ./build; true if one is found
    "$program" "$1" >build/threads/said 2>&1
    [ $? = 66 ]
}
for part in build stream reference cast bricks progress programs signal; do
    if races $part; then echo "not ok $part: it races"; failed=1; grep -A12 WARNING build/threads/said
    elif ! grep -q '  PASSED  ' build/threads/said; then echo "not ok $part: $(tail -n 3 build/threads/said)"; failed=1
    else echo "ok $part"; fi
done
if races race; then echo "ok a_planted_race_is_found"; else echo "not ok a_planted_race_is_found"; failed=1; fi
exit $failed
