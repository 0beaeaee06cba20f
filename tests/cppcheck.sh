#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# cppcheck.sh FOLDER [FILE ...]: what cppcheck finds in the files (none named: all of src and exporters), less what
# tests/cppcheck.supp says is none; also what stands there and is not found any more. FOLDER keeps what it knows of files that
# do not change. Exit code 1: something was found.
set -u
cd "$(dirname "$0")/.."
kept=$1 looked=all
shift
mkdir -p "$kept"
if [ $# = 0 ]; then
    mapfile -t files < <(find src exporters -name '*.c' -o -name '*.cc' | sort)
else
    files=("$@") looked="$*"
fi
# --max-configs=1: no file of ours has several, but for what other libraries' headers leave undefined.
cppcheck -q -j"$(nproc)" --std=c11 --std=c++17 --enable=warning,performance,portability --max-configs=1 \
    --cppcheck-build-dir="$kept" --include=tests/cppcheck.h -Isrc -Iexporters -I. \
    --template='{file}:{line}:{column}: {severity}: {message} [{id}]' "${files[@]}" 2>"$kept/all" || exit 1
sort -u "$kept/all" >"$kept/findings"
awk -v looked="$looked" -f tests/known.awk tests/cppcheck.supp "$kept/findings" | tee "$kept/new" >&2
[ ! -s "$kept/new" ]
