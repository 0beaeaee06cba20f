#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# analyze.sh FILE.c LIST FLAG ...: what clang's analyzer finds in a file, less what tests/analyzed.supp says is none, into
# LIST and on the terminal. Exit code 1: something was found.
set -u
file=$1 list=$2
shift 2
mkdir -p "$(dirname "$list")"
clang --analyze --analyzer-output text "$@" -o /dev/null "$file" 2>"$list.all" || { cat "$list.all" >&2; exit 1; }
grep -E '^[^ ]+:[0-9]+:[0-9]+: warning: .*\]$' "$list.all" >"$list.warnings"
awk -v looked="$file" -f "$(dirname "$0")/known.awk" "$(dirname "$0")/analyzed.supp" "$list.warnings" >"$list.found"
if [ -s "$list.found" ]; then
    # The way to each, for who reads it.
    cat "$list.all" "$list.found" >&2
    exit 1
fi
mv "$list.found" "$list"
rm -f "$list.all" "$list.warnings"
