#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# The renderer that doc/extending.md shows is the one that the tests compile and validate, to the letter but for its license.
. "$(dirname "$0")/lib.sh"

example() { # document: the block of C of its section "A renderer"
    awk '/^## / {in_section = ($0 == "## A renderer")} in_section && /^```c$/ {on = 1; next} /^```/ {on = 0} on' "$1"
}
is_the_tests() { diff <(example "$1") <(tail -n +2 "$top/tests/fifth_renderer.c"); }

check the_renderer_of_the_document_is_the_tests is_the_tests "$top/doc/extending.md"
# Planted: a document that has another one, and one that has none.
sed 's/\.name = "shifted"/.name = "shafted"/' "$top/doc/extending.md" >other.md
sed 's/^## A renderer$/## Renderers/' "$top/doc/extending.md" >none.md
for document in other none; do
    if is_the_tests $document.md >/dev/null; then not_ok "$document is found" "taken for the tests'"; else ok "$document is found"; fi
done
check no_room_but_the_renderers_asks_for_a_certain_one bash -c "! grep -rnE 'iso_renderer_(gl|cycles|povray)\b' '$top/src' '$top/exporters' | grep -v '^$top/src/renderers/'"
exit $failed
