#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# A site of certificates: two renderers that agree, one with a mistake in its picture, one that is missing; its data,
# badges and page; and reports that are damaged, which leave nothing.
. "$(dirname "$0")/lib.sh"
python_with numpy
scene=$top/refscenes/marschner-lobb.scene.json
"$ISOSHADE" make marschner-lobb --size 14x12x11 -q -o v.nrrd
cp "$top/doc/guide/numpy_renderer.py" right.py
# The planted fault: a picture in sRGB.
sed 's/picture.astype/display(picture).astype/' right.py >gamma.py
sed -i '/^import numpy/r /dev/stdin' gamma.py <<'END'

def display(rgba):
    c = np.maximum(rgba[..., :3], 0)
    return np.concatenate((np.where(c <= 0.0031308, 12.92 * c, 1.055 * c ** (1 / 2.4) - 0.055), rgba[..., 3:]), -1)
END
row() { # NAME TITLE PROGRAM SCRIPT
    printf '{"name": "%s", "title": "%s", "command": ["%s", "%s.py"], "tier": "samples",' "$@"
    printf ' "can": ["lights", "orthographic", "clip planes"]}'
}
{ echo '{"schema": "isoshade.renderers/1", "renderers": ['
    row gamma "a <b> & \\\"c\\\"" "$python" gamma
    echo ','
    row gone Gone no-such-program gone
    echo ']}'; } >r.json
validated() { "$ISOSHADE" validate v.nrrd --scene "$scene" --quick --levels 2 --size 24 -q "$@" >/dev/null 2>&1; }
validated --with gl,cpu -o good
validated --with gamma,gone --renderers r.json -o bad
check a_refused_renderer_has_no_rows_but_reasons test -s good/report.json -a -s bad/report.json

expect a_site_of_two_reports 0 "$ISOSHADE" certificate good bad -o site
counted='2 of 4 renderers agree with the reference in all scenes. gamma: refused. gone: not available.'
check the_sentence_counts_renderers grep -qxF "$counted" out
of() { jq -r "$1" site/certificates.json; }
check four_certificates test "$(of '.certificates | length')" = 4
check the_renderers_keep_their_order test "$(of '[.renderers[].renderer] | join(" ")')" = "gl cpu gamma gone"
check the_mistake_is_named test "$(of '.certificates[2].mistake' | grep -c 'in sRGB')" = 1
check its_picture_is_shown_all_the_same test "$(of '.certificates[2] | .image_b != null and .rmse > 0.01')" = true
check features_are_listed test "$(of '.certificates[2].lacks | index("label maps") != null')" = true
check what_is_missing_is_so test "$(of '.certificates[3].missing')" = true
badge() { python3 -c '
import sys, xml.etree.ElementTree as tree
root = tree.parse(sys.argv[1]).getroot()
texts = root.findall(".//{*}text")
wide = sum(float(t.get("textLength")) for t in texts) + 24 <= float(root.get("width")) + 1
print(" ".join(t.text for t in texts) if wide else "too wide")' "site/badges/$1.svg"; }
check its_badge_says_which_levels test "$(badge gl)" = "isoshade agrees, level 0-1"
check also_of_another test "$(badge cpu)" = "isoshade agrees, level 0-1"
check a_refused_one test "$(badge gamma)" = "isoshade refused"
check a_missing_one test "$(badge gone)" = "isoshade not available"
check badges_escape_titles grep -q 'a &lt;b&gt; &amp; &quot;c&quot;' site/badges/gamma.svg
"$ISOSHADE" certificate good bad --json -o site | jq .certificates >printed
check json_has_the_same cmp printed <(of .certificates)

python3 "$top/tests/peers/fidelity_table.py" site/certificates.json >table
check a_table_has_a_row_for_each test "$(grep -c '^| OpenGL ray caster \|^| CPU ray caster \|^| Gone ' table)" = 6
check it_names_the_mistake grep -q '| refused | .*draws as if the picture were in sRGB' table

# The planted fault of the data: one row that differs, one level that is not there.
cp -r good differs
jq '(.agreement[] | select(.renderer == "gl" and .level == 1) | .verdict) = "differ"' good/report.json \
    >differs/report.json
expect it_is_no_failure_of_the_command 0 "$ISOSHADE" certificate differs -o differing
words_of() { jq -r ".renderers[$2].words" "$1/certificates.json"; }
check the_badge_shows_it test "$(words_of differing 0)" = "differs in 1 of 1 scene"
check but_not_that_of_the_other test "$(words_of differing 1)" = "agrees, level 0-1"

# Two reports of one renderer and scene: the newest counts, in either order.
cp -r differs older
jq '.made = "2001-02-03T04:05:06Z"' differs/report.json >older/report.json
for order in "older good" "good older"; do
    "$ISOSHADE" certificate $order -q -o newest >/dev/null
    check "the_newest_counts_of_${order/ /_}" test "$(words_of newest 0)" = "agrees, level 0-1"
    old=$(jq -r '.certificates[0].superseded[0] | .report + " " + .made' newest/certificates.json)
    check "the_older_is_listed_of_${order/ /_}" test "$old" = "older 2001-02-03T04:05:06Z"
done

# A report alone has no pictures.
mkdir alone && cp good/report.json alone
expect only_report_json 0 "$ISOSHADE" certificate alone/report.json -o without
check has_no_pictures test "$(grep -c 'data:image/png' without/index.html)" = 0

# ---- bad input ----
made() { "$ISOSHADE" certificate "$@"; }
refuse without_a_report 2 'usage: isoshade certificate REPORT' made -o x
refuse without_an_output 2 '-o is missing' made good
mkdir mine && touch mine/note
refuse a_folder_without_a_report 3 'mine: holds no report.json' made good mine -o x
refuse one_that_is_not_there 3 'nowhere' made good nowhere -o x
damaged() { # NAME CODE WORDS FILTER
    rm -rf "$1" && cp -r good "$1" && jq "$4" good/report.json >"$1/report.json"
    refuse "$1" "$2" "$3" made good "$1" -o x
}
mkdir cut && head -c 999 good/report.json >cut/report.json
refuse a_cut_one 4 'cut/report.json' made good cut -o x
damaged of_another_version 4 'another version of isoshade wrote it' '.schema = "isoshade.validate/2"'
damaged of_another_program 4 'not a report.json of isoshade validate' '.schema = "isoshade.chart/1"'
damaged without_rows 4 'no comparison of a renderer' '.agreement = []'
damaged a_row_without_a_scene 4 'agreement, row 2: scene is no text' 'del(.agreement[1].scene)'
damaged a_row_without_a_level 4 'agreement, row 2: level is no number' '.agreement[1].level = "1"'
damaged a_level_below_0 4 'agreement, row 2: level is no number' '.agreement[1].level = -3'
damaged a_row_without_limits 4 'limits no object' '.agreement[1].limits = null'
damaged a_renderer_that_is_a_path 4 'invalid renderer "../gl"' '.agreement[0].renderer = "../gl"'
damaged a_picture_that_is_a_path 4 'invalid name of a picture' '.agreement[].image_b = "../x"'
damaged an_unknown_verdict 4 'unknown verdict "fine"' '.agreement[0].verdict = "fine"'
rm -rf lost && cp -r good lost && rm lost/images/*.exr
refuse lost_pictures 3 'lost/images/' made lost -o x
refuse a_folder_of_the_user_stays 3 'holds no certificates.json' made good -o mine
refuse nor_is_a_report_replaced 3 'good' made good -o good
check the_site_is_replaced made bad good -o site

# ---- the page ----
command -v chromium >/dev/null || { skip the_page "there is no chromium"; exit $failed; }
findings() { PYTHONPATH=$top/tests:$top/tests/peers python3 "$top/tests/certificate_page.py" "$1"; }
expect the_page_is_used 0 findings site/index.html
for name in a_card_for_each each_cell_leads_to_its_card badges_are_shown a_bad_card_names_the_mistake a_bad_card_shows_the_mistake \
    cards_have_command_and_version the_verdict_filters the_renderer_filters rmse_sorts all_comes_back \
    differences_are_painted two_pictures_and_their_difference_are_inspected dark_is_dark every_control_has_a_name; do
    check "$name" grep -qx "$name true" out
done
check a_cell_for_each_certificate grep -qx 'cells 4' out
check it_fits_a_telephone grep -qx 'wider_than_a_telephone false' out
check no_picture_is_broken grep -qx 'pictures_broken 0' out
check nothing_is_fetched grep -qx 'fetched 0' out
check no_script_failed grep -qx 'exceptions 0' out
# Pages each of which has lost one thing.
lost() { # name, what is lost (sed), the finding that must show it
    sed "$2" site/index.html >site/lost.html
    if cmp -s site/index.html site/lost.html; then not_ok "$1" "the fault could not be planted"; return; fi
    findings site/lost.html >out 2>err
    check "$1" grep -qx "$3" out
}
lost a_dead_filter_is_noticed 's/order.filter\[name\] = e.target.value;//' 'the_verdict_filters false'
lost a_mistake_that_is_not_shown_is_noticed "s/row.mistake ? mistake/false ? mistake/" 'a_bad_card_names_the_mistake false'
lost pictures_of_a_mistake_that_are_not_shown_are_noticed "s/\['wanted', 'got'\]/['wanted']/" \
    'a_bad_card_shows_the_mistake false'
lost a_difference_without_colors_is_noticed 's/else if (log > threshold) {/else if (false) {/' \
    'differences_are_painted false'
exit $failed
