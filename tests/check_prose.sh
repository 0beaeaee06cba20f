#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Comments, messages and pages are written plainly: tests/prose.py measures them and has the budgets.
. "$(dirname "$0")/lib.sh"
measures() { python3 "$top/tests/prose.py" "$1" | tee "$dir/measured"; }
within() { measures "$1" | { ! grep exceeded; } && [ "$(wc -l <"$dir/measured")" -gt 30 ]; }
check comments_messages_and_pages_are_plain within "$top"

# Planted: for each measure a comment, a message or a page that exceeds it, and nothing else does.
is_found() { # MEASURE: it is exceeded in the folder "bad", alone
    measures bad | grep exceeded | cut -c1-22 | sort -u | sed 's/ *$//' | diff - <(echo "$1")
}
plant() { # NAME, MEASURE, comment
    rm -rf bad && mkdir -p bad/src bad/doc
    printf '%s\n' "$3" >bad/src/a.c
    check "${1}_is_found" is_found "$2"
}
plant what_for_a_noun "what for a noun" '/* Returns what is stored there. */'
plant a_label "label with What" '/* What nobody reads */'
plant a_fragment "fragment" '/* Of all levels together. */'
plant where_for_if "where for if" '/* Writes a row where there are some. */'
plant said_for_named "said or told" '/* Fails if its name is said twice. */'
plant behind_for_after "behind, beside" '/* Puts a row behind the others. */'
plant no_for_not "is no" '/* Fails if it is no file. */'
plant so_many "so many" '/* Reads so many bytes. */'
plant an_old_word "old word" '/* Sorts the rows anew. */'
plant a_for_per "a for per" '/* Writes three bytes a voxel. */'
plant a_question "question" '/* Is the file there? */'
plant a_private_word "private word" '/* Data of the keeper only. */'
plant comma_else "comma, else" '/* Returns the row, else NULL. */'
plant three_clauses "three clauses" '/* Returns the row that a file has which was read by a program that wrote it. */'
plant a_long_sentence "long sentence" "/* Returns $(printf 'the row and %.0s' {1..12}) the end. */"
long="int a$(printf ' %.0s' {1..120});"
plant a_long_line "long line of C" "$(for _ in {1..200}; do echo "$long"; done)"
plant a_detached_comment "detached comment" $'\n\n\n/* Returns the row of a file. */\n\nint row(void);'
rm -rf bad && mkdir -p bad/src && printf 'const char *m = "%%s: is what is written there, and has no end";\n' >bad/src/a.c
check a_message_is_read_too is_found "what for a noun"
rm -rf bad && mkdir bad && echo 'The rows behind the table are of the first file.' >bad/a.md
check a_page_is_read_too is_found "behind, beside"
exit $failed
