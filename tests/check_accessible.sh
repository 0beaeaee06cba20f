#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# All pages by keyboard, and under axe-core if `sh tests/peers/web/fetch.sh` fetched it.
. "$(dirname "$0")/lib.sh"
accessible() { python3 "$top/tests/accessible.py" "$@"; }
"$ISOSHADE" make shells --size 34x33x32 -q -o v.nrrd
shells=$top/refscenes/shells.scene.json
"$ISOSHADE" view v.nrrd --scene "$shells" --levels 2 -q -o v.html
mkdir strict
sed 's/"tf": "sharp"/"tf": "smooth"/; s/"opacity": 0.7/"opacity": 0.9999/' "$top/refscenes/suite/step.scene.json" >strict/strict.scene.json
"$ISOSHADE" validate --suite strict --quick --size 12 --with gl,cpu -q -o failed >/dev/null 2>&1
"$ISOSHADE" validate v.nrrd --scene "$shells" --quick --levels 2 --size 16 --with gl -q -o good >/dev/null 2>&1
"$ISOSHADE" report diff failed good -o diff >/dev/null 2>&1
"$ISOSHADE" certificate failed good -o site >/dev/null 2>&1
"$ISOSHADE" chart v.nrrd --scene "$shells" --size 16 -q --budget 0 --with gl --levels 1 --steps 1,0.5 --tfs original \
    --plans none --estimators central --filters moments --codes snorm -o chart >/dev/null
"$ISOSHADE" bench all --quick --repeat 1 --only build-memory --page bench.html -q >/dev/null
pages=(v.html v.html#compact v.html#slices)
for page in failed good diff site chart; do pages+=($page/index.html); done
"$ISOSHADE" atlas --case noise -q -o atlas >/dev/null
pages+=(bench.html atlas/index.html)
has_files there . "${pages[@]%#*}"

# ---- the keyboard ----
expect pages_are_used_by_keyboard 0 accessible keyboard "${pages[@]}"
cp out findings
check none_of_the_pages_is_left_out test "$(wc -l <findings)" = $((7 * ${#pages[@]}))
for finding in missed order sequence unmarked unseen back nameless; do
    check "keyboard_$finding" bash -c '! grep " $1 " findings | grep -vE " (none|right)$"' - $finding
done
# The planted faults.
fault() { # NAME FINDING SED: the finding that must show it
    sed "$3" v.html >fault.html
    if cmp -s v.html fault.html; then not_ok "$1" "the fault could not be planted"; return; fi
    accessible keyboard fault.html >out 2>&1
    notice "$1" bash -c 'grep " $1 " out | grep -qE " (none|right)$"' - "$2"
}
fault a_trap_is_noticed missed "s/^const start = async/addEventListener('keydown', e => e.target.id === 'slices' \&\& e.preventDefault()); &/"
fault a_wrong_order_is_noticed sequence 's/id="copy"/& tabindex="3"/'
fault a_row_that_is_turned_is_noticed order 's/^\.buttons {/& flex-direction: row-reverse;/'
fault a_focus_without_mark_is_noticed unmarked 's/^:focus-visible {.*/* { outline: none !important; }/'
fault a_control_without_name_is_noticed nameless 's/<label><span>opacity<.span>/<label><span><\/span>/'
expect escape_is_pressed 0 accessible escape v.html
for finding in closes_a_message_first closes_the_panel ends_the_large_slice ends_measuring; do
    check "escape_$finding" grep -qx "$finding True" out
done

# ---- axe-core ----
axe=$top/build/web/node_modules/axe-core/axe.min.js
[ -s "$axe" ] || { skip axe "axe-core was not fetched: sh tests/peers/web/fetch.sh"; exit $failed; }
expect axe_looks_at_the_pages 0 accessible axe "$axe" "${pages[@]}"
check axe_finds_nothing_serious bash -c '! grep -v " none$" out'
check at_none_of_the_pages test "$(wc -l <out)" = $((2 * ${#pages[@]}))
sed 's/--quiet: #5f5f5f/--quiet: #b0b0b0/' v.html >fault.html
accessible axe "$axe" fault.html >out
check pale_text_is_noticed grep -q "fault.html light color-contrast (serious)" out
exit $failed
