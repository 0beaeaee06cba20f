#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# cppcheck finds nothing in any file of src and exporters but what tests/cppcheck.supp explains, and planted faults.
. "$(dirname "$0")/lib.sh"
# Findings differ between versions; this one is Debian 12's.
version=$(cppcheck --version 2>/dev/null | sed -n 's/^Cppcheck \([0-9.]*\).*/\1/p')
if [ "$version" != 2.10 ]; then
    skip what_cppcheck_finds "cppcheck 2.10 is not the cppcheck of this system${version:+, which is $version}"
    exit 0
fi
check cppcheck_finds_nothing bash "$top/tests/cppcheck.sh" "$top/build/cppchecked"

# Planted in copies of files of ours: each has to be found.
plant() { # NAME FILE OLD NEW CHECKER
    python3 - "$top/$2" "$1.${2##*.}" "$3" "$4" <<'END' || { not_ok "$1" "cannot be planted in $2"; return; }
import sys
text = open(sys.argv[1]).read()
if sys.argv[3] not in text:
    sys.exit(1)
open(sys.argv[2], "w").write(text.replace(sys.argv[3], sys.argv[4], 1))
END
    if bash "$top/tests/cppcheck.sh" "$dir/kept" "$dir/$1.${2##*.}" 2>found; then not_ok "$1" "it is not found"
    elif grep -q "\[$5\]" found; then ok "$1"
    else not_ok "$1" "found: $(head -n 1 found)"; fi
}
plant memory_that_is_lost_is_found src/figure/charted.c 'return (x > y) - (x < y);' 'int *lost = malloc(4); if (!lost) return 1; lost[0] = x > y; return lost[0] - (x < y);' memleak
plant an_index_beyond_its_array_is_found src/base/base64.c 'text[used++] = digits[n >> 18];' 'text[sizeof text] = 0; text[used++] = digits[n >> 18];' arrayIndexOutOfBounds
plant a_format_without_its_number_is_found src/cli/cmd_compare.c '"verdict   %s\n", agree ? "agree" : "differ"' '"verdict   %s\n"' wrongPrintfScanfArgNum
plant an_element_that_is_not_there_is_found src/volume/itk/dicom.cc 'return value[0];' 'std::vector<double> empty; return empty[0];' containerOutOfBounds

# A suppression that matches no finding, or has no reason, is refused.
mkdir -p copy/tests copy/src/base copy/exporters && cp "$top"/tests/{cppcheck.sh,cppcheck.h,known.awk} copy/tests/ && cp "$top/src/base/"base64.[ch] copy/src/base/
echo 'src/base/base64.c uninitvar text # as it is' >copy/tests/cppcheck.supp
check what_is_explained_is_no_finding bash copy/tests/cppcheck.sh "$dir/other"
echo 'src/base/base64.c memleak text # there is none' >>copy/tests/cppcheck.supp
notice an_explanation_of_nothing_is_seen bash copy/tests/cppcheck.sh "$dir/other"
echo 'src/base/base64.c uninitvar text' >copy/tests/cppcheck.supp
notice an_explanation_without_a_reason_is_seen bash copy/tests/cppcheck.sh "$dir/other"
exit $failed
