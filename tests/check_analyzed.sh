#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# clang's analyzer finds nothing in code that reads untrusted files or starts programs, and each planted fault.
# `make analyze` looks at all files.
. "$(dirname "$0")/lib.sh"
# Findings differ between versions; this one is Debian 12's.
version=$(clang --version 2>/dev/null | sed -n 's/.*clang version \([0-9]*\).*/\1/p')
if [ "$version" != 14 ]; then
    skip what_clang_finds "clang 14 is not the clang of this system${version:+, which is $version}"
    exit 0
fi
check the_analyzer_finds_nothing make -C "$top" --no-print-directory -s -j"$(nproc)" config=release analyze-readers

# Planted in copies of files of ours: each has to be found, where the file itself is clean.
plant() { # NAME FILE OLD NEW CHECKER
    python3 - "$top/$2" "$1.c" "$3" "$4" <<'END' || { not_ok "$1" "cannot be planted in $2"; return; }
import sys
text = open(sys.argv[1]).read()
if sys.argv[3] not in text:
    sys.exit(1)
open(sys.argv[2], "w").write(text.replace(sys.argv[3], sys.argv[4], 1))
END
    if bash "$top/tests/analyze.sh" "$1.c" "$1.txt" -std=c11 -I"$top/src" -I"$top/exporters" -I"$top" -include "$top/tests/analyzed.h" >/dev/null 2>found; then not_ok "$1" "it is not found"
    elif grep -q "\[$5\]" found; then ok "$1"
    else not_ok "$1" "found: $(grep warning: found | head -n 1)"; fi
}
plant a_null_pointer_is_found src/volume/child.c 'if (r && r->process.output >= 0)' 'if (!r && r->process.output >= 0)' core.NullDereference
plant memory_that_is_freed_twice_is_found src/base/file.c 'free(*data);' 'free(*data), free(*data);' unix.Malloc
plant memory_that_nothing_owns_is_found src/volume/unpack.c 'FREED ' '' unix.Malloc
plant an_uninitialized_value_is_found src/base/bigfile.c 'fstat(f->fd, &st) != 0' 'st.st_size == 4' core.UndefinedBinaryOperatorResult
exit $failed
