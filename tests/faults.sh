#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# What happens when the machine runs out, or somebody ends the program: all calls of all commands fail once, commands are
# killed at random instants, and random chains of commands are disturbed. Prints three tables; options go to the first.
set -u
cd "$(dirname "$0")/.." || exit 1
. tests/environment.sh
failed=0
echo "Calls that fail once (tests/faults/faults.py)"
python3 tests/faults/faults.py "$@" || failed=1
echo
echo "The same for allocations of a mebibyte and more, which the program goes on from (FAULTS_LEAST)"
python3 tests/faults/faults.py --large || failed=1
echo
echo "Kills at 200 random instants, and the run after each (tests/faults/kills.py)"
python3 tests/faults/kills.py || failed=1
echo
echo "200 random pipelines with faults (tests/pipelines.py)"
python3 tests/pipelines.py || failed=1
exit $failed
