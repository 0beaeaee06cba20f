#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Whoever reads a report handles every section of it: a section that is added to the table alone does not compile in any of them,
# and is missing on the page.
. "$(dirname "$0")/lib.sh"
# compiles FILE [MORE]: with one more section, which no code handles
compiles() {
    "${CC:-gcc}" -std=c11 -fsyntax-only -D_GNU_SOURCE -I "$top/src" -I "$top/exporters" -I "$top" \
        "-DISO_SECTION_MORE(X)=${2-}" "$top/src/report/$1"
}
consumers="difference.c markdown.c report_junit.c"
for file in $consumers; do
    check "${file}_handles_all_sections" compiles $file
    notice "${file}_misses_one_more" compiles $file 'X(made_up, ISO_IS(AGREE))'
done
walks=$(cd "$top/src/report" && grep -l 'ISO_SECTION_LIST(ISO_' *.c | grep -v '^sections.c$' | sort | xargs)
check no_other_file_walks_the_table test "$walks" = "$(echo $consumers)"

# What the page shows, by the keys of its table, is what the table has.
sections() {
    printf '#include "report/sections.h"\n#define ROW(name, verdicts) name\nISO_SECTION_LIST(ROW)\n' |
        "${CC:-gcc}" -E -P -I "$top/src" "-DISO_SECTION_MORE(X)=${1-}" - | tail -n 1 | tr ' ' '\n' | sed '/^$/d' | sort
}
shown() { sed -n 's/^const shows = {\(.*\)};$/\1/p' "$top/src/report/report_page.js" | tr ',' '\n' | sed 's/^ *\([a-z_]*\):.*/\1/' | sort; }
the_page_shows() { diff <(shown) <(sections "${1-}"); }
check the_page_shows_all_sections the_page_shows
notice the_page_misses_one_more the_page_shows 'X(made_up, 0)'
exit $failed
