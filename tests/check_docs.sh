#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# The documentation holds together: lines wrap at 120 columns, links and pictures exist, each file of doc/ can be reached from
# README.md, each picture has the command that draws it, the list of rooms is that of check_layering.sh, and comments of the
# source name pages that are there, as pages name files of the source.
. "$(dirname "$0")/lib.sh"

pages() { (cd "$1" && find . -name '*.md' \( ! -path './*/*' -o -path './doc/*' \) | sed 's|^\./||' | sort); }

# folder: a line for each one that is too long. Tables, code and links cannot be wrapped.
long_lines() {
    local page
    for page in $(pages "$1"); do
        LC_ALL=C awk -v page="$page" '
            /^ *```/ { code = !code; next }
            code || /^ *\|/ || /^    / || /\]\([^)]*\)/ || /https?:/ { next }
            { gsub(/[\200-\277]/, "") } # all but the first byte of a character beyond ASCII
            length($0) > 120 { printf "%s:%d has %d columns\n", page, FNR, length($0) }' "$1/$page"
    done
}

# folder, page: what it links to inside the project, as paths from the folder
links() {
    local base target
    base=$(dirname "$2")
    awk '/^ *```/ { code = !code } !code && !/^    /' "$1/$2" | grep -oE '\]\([^)]+\)' | sed 's/^](//; s/)$//; s/#.*//' |
        while read -r target; do
            case $target in '' | *://* | mailto:*) continue ;; esac
            (cd "$1" && realpath -m --relative-to=. "$base/$target")
        done
}

# folder: a line for each link that leads nowhere
broken_links() {
    local page target
    for page in $(pages "$1"); do
        for target in $(links "$1" "$page"); do [ -e "$1/$target" ] || echo "$page links to $target, which is not there"; done
    done
}

# folder: a line for each file of doc/ to which no way leads from README.md
unlinked() {
    local known=" README.md " todo=README.md page target
    while [ -n "$todo" ]; do
        page=${todo%% *}
        case $todo in *' '*) todo=${todo#* } ;; *) todo= ;; esac
        for target in $(links "$1" "$page"); do
            case $known in *" $target "*) continue ;; esac
            known="$known$target "
            case $target in *.md) [ -f "$1/$target" ] && todo="${todo:+$todo }$target" ;; esac
        done
    done
    (cd "$1" && find doc -type f) | sort | while read -r page; do
        case $known in *" $page "*) ;; *) echo "$page is not linked" ;; esac
    done
}

# folder: a line for each picture that no function of refscenes/figures.sh draws which `make figures` calls: one whose name
# stands in its lists; architecture.svg is written by hand
undrawn() {
    local picture script=$1/refscenes/figures.sh called function
    called=$(sed -n 's/^\(quick\|longer\)="\(.*\)"/\2/p' "$script" | tr '\n-' ' _')
    (cd "$1" && find doc/figures -type f) | sort | while read -r picture; do
        case $picture in */architecture.svg) continue ;; esac
        function=$(awk -v name="$(basename "$picture")" '/^[a-z_]+\(\) \{/ {split($0, word, "("); function_name = word[1]}
            !/^ *#/ && index($0, name) {print function_name; exit}' "$script")
        case " $called " in
            *" ${function:-none} "*) ;;
            *) echo "$picture is drawn by no command${function:+ that is called: $function}" ;;
        esac
    done
}

# folder: a line for each page of doc/ that source, tests or scripts name and that is not there
lost_pages() {
    (cd "$1" && grep -rohE '\bdoc/[A-Za-z0-9_/.-]+\.(md|png|svg|jpg)' --exclude=check_docs.sh src exporters tests refscenes Makefile) |
        sort -u | while read -r page; do [ -e "$1/$page" ] || echo "$page is named by a comment and is not there"; done
}

# folder: a line for each source file that a page names and that is not there
lost_files() {
    local page file
    for page in $(pages "$1"); do
        grep -oE '`(src|exporters|tests|refscenes)/[A-Za-z0-9_./-]+\.[a-z]+`' "$1/$page" | tr -d '`' | sort -u |
            while read -r file; do [ -e "$1/$file" ] || echo "$page names $file, which is not there"; done
    done
}

table_rooms() { sed -n '/^table="/,/^"/ s/^\([a-z]*\):.*/\1/p' "$1/tests/check_layering.sh"; }
listed_rooms() { sed -n 's/^| `\(src\|exporters\)\/\([a-z]*\)` .*/\2/p' "$1/doc/ARCHITECTURE.md"; }

nothing() { # name, what was found
    check "$1" test -z "$2"
    [ -z "$2" ] || head -n 20 <<<"$2"
}
nothing lines_wrap_at_120_columns "$(long_lines "$top")"
# Texts are in American spelling; units are read in both (src/volume/unit.c).
british() {
    local verbs='normal|quant|vector|summar|recogn|minim|maxim|initial|discret'
    grep -rnoiE --include='*.md' --include='*.[ch]' --include='*.cc' --include='*.py' --include='*.html' --include='*.js' \
        "\\w*(colour|neighbour|behaviour|licence|[a-z]metre|centre)\\w*|\\bgreys?\\b|\\w*($verbs)is(e|es|ed|ing|ation)\\b" "$@" |
        grep -v 'src/volume/unit\.c'
}
mkdir -p spelled && echo 'The color of each centre.' >spelled/a.md && echo 'Normalized colors, and their center.' >spelled/b.md
check a_british_spelling_would_be_seen test "$(british spelled | wc -l)" = 1
nothing spelling_is_american "$(british "$top/README.md" "$top/CONTRIBUTING.md" "$top/doc" "$top/src" "$top/exporters")"
nothing links_and_pictures_are_there "$(broken_links "$top")"
nothing parts_that_links_name_are_headings "$(python3 "$top/tests/anchors.py" "$top")"
nothing no_file_of_doc_is_left_unlinked "$(unlinked "$top")"
nothing each_picture_has_a_command "$(undrawn "$top")"
nothing pages_that_comments_name_are_there "$(lost_pages "$top")"
nothing files_that_pages_name_are_there "$(lost_files "$top")"
nothing pictures_are_below_a_mebibyte "$(find "$top/doc" -type f -size +1023k)"
nothing rooms_are_those_of_check_layering "$(diff <(table_rooms "$top") <(listed_rooms "$top"))"
check there_are_rooms test "$(table_rooms "$top" | wc -l)" -gt 10

# Planted faults: one of each kind in a small project of its own.
mkdir -p planted/doc/figures planted/src planted/exporters planted/tests planted/refscenes && touch planted/Makefile
printf '# a page\n\n%0121d\n\n| %0121d |\n\n    %0121d\n\n[a](doc/a.md) ![p](doc/figures/p.png) [gone](doc/gone.md)\n' 0 0 0 >planted/README.md
printf '# A page\n\n`src/x.c` `src/y.c` [up](../README.md) [here](#a-page) [nowhere](../README.md#part)\n' >planted/doc/a.md
printf 'nobody links here\n' >planted/doc/lonely.md
touch planted/doc/figures/p.png
printf '/* doc/old.md, doc/a.md */\n' >planted/src/x.c
printf '# p.png\n' >planted/refscenes/figures.sh
check a_long_line_is_found test "$(long_lines planted)" = "README.md:3 has 121 columns"
check a_broken_link_is_found test "$(broken_links planted)" = "README.md links to doc/gone.md, which is not there"
check a_part_that_is_no_heading_is_found test "$(python3 "$top/tests/anchors.py" planted)" = \
    "doc/a.md:3 links to README.md#part, which is no heading there"
printf '%0121d\n\n[gone](gone.md)\n' 0 >planted/doc/lonely.md
check a_long_line_of_doc_is_found test "$(long_lines planted | sed 1d)" = "doc/lonely.md:1 has 121 columns"
check a_broken_link_of_doc_is_found test "$(broken_links planted | sed 1d)" = "doc/lonely.md links to doc/gone.md, which is not there"
check a_lonely_page_is_found test "$(unlinked planted)" = "doc/lonely.md is not linked"
check a_picture_without_a_command_is_found test "$(undrawn planted)" = "doc/figures/p.png is drawn by no command"
printf 'draw_p() {\n    echo >p.png\n}\nquick="other"\n' >planted/refscenes/figures.sh
check a_picture_that_no_list_has_is_found test "$(undrawn planted)" = "doc/figures/p.png is drawn by no command that is called: draw_p"
sed -i 's/other/draw-p/' planted/refscenes/figures.sh
check a_picture_of_a_list_is_not test -z "$(undrawn planted)"
check a_file_that_is_gone_is_found test "$(lost_files planted)" = "doc/a.md names src/y.c, which is not there"
check a_page_that_is_gone_is_found test "$(lost_pages planted)" = "doc/old.md is named by a comment and is not there"
exit $failed
