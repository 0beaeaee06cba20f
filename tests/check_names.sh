#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# What the program can read, write and choose from stands in tables; --help and the documents say the same. The pages of
# doc/reference that are made from the program are current.
. "$(dirname "$0")/lib.sh"

mkdir -p other/src pages others
check pages_are_made python3 "$top/tests/reference_pages.py" "$ISOSHADE" "$top" pages
cp pages/names.md names.md

same_as_table() { # file: the tables' rows, no more and no fewer
    diff <(grep -E '^## |^- `' "$1") <(grep -E '^## |^- `' names.md) >difference
}
for page in names commands library; do check "${page}_is_current" diff "$top/doc/reference/$page.md" "pages/$page.md"; done

# Planted: a program with another option, and a header with one more function.
printf '#!/bin/sh\n"%s" "$@" | sed "s/--quick/--hasty/"\n' "$ISOSHADE" >hasty && chmod +x hasty
sed 's/^const char \*iso_version(void);/&\nint iso_other(void);/' "$top/src/isoshade.h" >other/src/isoshade.h
python3 "$top/tests/reference_pages.py" ./hasty other others
notice another_option_is_found diff pages/commands.md others/commands.md
notice another_function_is_found diff pages/library.md others/library.md

# Planted faults: a row missing in the document, one too many, and a summary that says something else.
grep -v '^- `shell`' names.md >less.md
sed 's/^- `shell`.*/&\n- `pinch`: not a code/' names.md >more.md
sed 's/^- `shell`: the best/- `shell`: the worst/' names.md >other.md
for fault in less more other; do
    if same_as_table $fault.md; then not_ok "a_document_with_${fault}_is_found" "taken for the table"; else ok "a_document_with_${fault}_is_found"; fi
done

# Each name has its line in the help of the command that takes it.
"$ISOSHADE" list --json | python3 -c '
import json, sys
for table in json.load(sys.stdin)["lists"]:
    for row in table["rows"]: print(table["what"], row["name"], sep="\t")' >rows.txt
rows() { awk -F'\t' -v what="$1" '$1 == what {print $2}' rows.txt; } # WHAT: the names of that table
has_rows() { # WHAT, help: each row has a line in the section of the help, and there are no other lines
    local names section
    section=$(sed -n "/^$1s:\$/,/^\$/p" "$2") names=$(rows "$1")
    [ -n "$names" ] && [ "$(sed -n 's/^  \([^ ]*\) .*/\1/p' <<<"$section" | sort)" = "$(sort <<<"$names")" ] &&
        [ "$(grep -c '^  ' <<<"$section")" = "$(wc -l <<<"$names")" ]
}
while read -r command what; do
    "$ISOSHADE" "$command" --help=all >help.txt
    check "help_of_${command}_lists_${what// /_}s" has_rows "$what" help.txt
    sed "/^  $(rows "$what" | sed -n 1p) /d" help.txt >less.txt
    if has_rows "$what" less.txt; then not_ok "a_missing_${what// /_}_is_found" "taken for whole"; else ok "a_missing_${what// /_}_is_found"; fi
done <<'END'
info volume format
tf transfer-function format
build gradient estimator
build direction code
build direction filter
build scalar filter
render direction code
render direction source
palette palette method
chart direction code
chart gradient estimator
export export target
export material
END

# Help is read in a terminal: its sentences wrap at 120 columns, and examples are indented. Usages, tables and examples
# cannot be wrapped.
long_lines() { awk 'length($0) > 120 && !/^usage:/ && !/^ /' "$1"; }
unindented() { awk 'on && NF && !/^  / {print} /^examples:/ {on = 1}' "$1"; }
{ "$ISOSHADE" --help; "$ISOSHADE" bench --help; } >commands.txt
while read -r command; do
    "$ISOSHADE" $command --help=all >help.txt
    [ -z "$(long_lines help.txt | sed 1d)$(unindented help.txt)" ] || bad="${bad-} $command"
done < <(sed -n '/^commands:/,/^$/s/^  \([a-z]*\) .*/\1/p; /^benchmarks:/,/^$/s/^  \([a-z-]*\) .*/bench \1/p' commands.txt)
check help_wraps_and_indents_its_examples test -z "${bad-}"
printf 'isoshade x - y\n%0121d\nexamples:\nisoshade x\n' 0 >help.txt
check a_long_line_of_help_is_found test "$(long_lines help.txt | wc -l)" = 1
check an_example_at_the_margin_is_found test "$(unindented help.txt)" = "isoshade x"
taking_part() { "$ISOSHADE" "$1" --help | grep -A3 -- --with= | grep -o 'gl,[a-z,]*'; }
check validate_says_who_takes_part test "$(taking_part validate)" = "$(taking_part chart)"

# Each table has its section in doc/extending.md, which says where a row goes.
for heading in "A renderer" "A direction code" "An estimator" "A volume format" "An export target" "A transfer-function format"; do
    check "extending_has_${heading// /_}" grep -qx "## $heading" "$top/doc/extending.md"
done
while read -r name; do check "the_readme_names_$name" grep -qi "$name" "$top/README.md"; done < <(rows "volume format")

check only_the_renderers_name_a_certain_one bash -c "! grep -rnE 'iso_renderer_(gl|cycles|povray)\\b' '$top/src' '$top/exporters' | grep -v '^$top/src/renderers/'"

# Messages list the rows, too.
expect an_unknown_code_is_refused 2 "$ISOSHADE" build none.nrrd --code pinch -o x.iso
check the_refusal_lists_all_codes grep -qF "$(rows "direction code" | paste -sd, | sed 's/,/, /g')" "$dir/err"
exit $failed
