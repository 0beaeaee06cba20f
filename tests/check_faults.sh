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
check calls_that_fail_once_end_well sampled
check so_do_large_allocations python3 tests/faults/faults.py --large --sample 3 --only "build,render reference,export vdb"
check kills_leave_nothing_broken python3 tests/faults/kills.py --count 6 --only "build again,render reference"
check pipelines_lose_nothing python3 tests/pipelines.py --count 5 --seed 7
exit $failed
