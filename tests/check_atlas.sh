#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# The failure atlas as its reader uses it: a page in a browser, and commands that give its figures when they are typed.
. "$(dirname "$0")/lib.sh"
ids=thin-vessels,opposite-normals,sharp-tf,code-folds,lambda
expect some_cases_are_made 0 "$ISOSHADE" atlas --case $ids -o "an atlas"
check the_page_is_there test -s "an atlas/index.html"
one_line() { python3 -c 'import json; assert all("\n" not in c["command"] for c in json.load(open("an atlas/atlas.json"))["cases"])'; }
check the_command_of_a_case_is_one_line one_line
check only_they_are_made test "$(ls "an atlas"/*.scene.json | wc -l)" = 4

# Each command, as it is printed, in a folder of its own; `isoshade` is what the check runs.
mkdir bin run && ln -s "$ISOSHADE" bin/isoshade
(cd run && ln -s "../an atlas" .)
commands() { # id, failure or fallback
    python3 - "an atlas/atlas.json" "$1" "$2_commands" <<'END'
import json, sys
print(next(c for c in json.load(open(sys.argv[1]))["cases"] if c["id"] == sys.argv[2]).get(sys.argv[3], ""), end="")
END
}
figure() { # id, failure or fallback: the figure of the page
    python3 -c 'import json, sys; print(next(c for c in json.load(open("an atlas/atlas.json"))["cases"] if c["id"] == sys.argv[1])[sys.argv[2] + "_value"])' "$1" "$2"
}
for id in thin-vessels opposite-normals sharp-tf; do
    for way in failure fallback; do
        commands $id $way >lines
        (cd run && PATH="$dir/bin:$PATH" bash -e ../lines) >out 2>err
        code=$?
        # The last line compares with the fallback's limit: the failure is beyond it.
        check "${id}_${way}_as_printed" test "$code" = $([ $way = failure ] && echo 1 || echo 0)
        # The volume and the scene went through files: the same figure but for their last digits.
        check "${id}_${way}_has_its_figure" python3 -c "
import re, sys
typed = float(re.search(r'rmse +([0-9.e+-]+)', open('out').read().lower()).group(1))
sys.exit(abs(typed - float(sys.argv[1])) > 1e-3 * float(sys.argv[1]))" "$(figure $id $way)"
    done
done
check a_drawing_has_no_volume test ! -e "an atlas/lambda.nrrd"
check a_planted_failure_has_no_options test -z "$(commands code-folds failure)"

# The fallbacks name options that the commands have.
python3 -c '
import json, re
for c in json.load(open("an atlas/atlas.json"))["cases"]:
    for command, rest in re.findall(r"isoshade (\w+)([^;]*)", c["advice"]):
        for option in re.findall(r"--[a-z0-9-]+", rest): print(command, option)' >advice
check there_is_advice test -s advice
while read -r command option; do
    check "isoshade_${command}_has_$option" grep -qE -- "$option\b" <("$ISOSHADE" "$command" --help=all)
done <advice

refuse an_unknown_case_is_named 2 'unknown case "vessels", must be one of' "$ISOSHADE" atlas --case vessels -o two
refuse a_folder_is_needed 2 '-o is missing' "$ISOSHADE" atlas
mkdir mine && touch mine/thesis.txt
refuse a_folder_of_somebody_else_is_kept 3 mine "$ISOSHADE" atlas --case code-folds --quiet -o mine

patiently chromium --headless --no-sandbox --disable-gpu --no-first-run --disable-background-networking --disable-component-update \
    --user-data-dir="$dir/browser" --window-size=1200,1600 --virtual-time-budget=5000 --screenshot="$dir/atlas.png" \
    "file://$dir/an atlas/index.html" >/dev/null 2>&1
# A blank page of this size packs into a few kilobytes.
check a_screenshot_is_no_blank_page test "$(stat -c %s atlas.png)" -gt 60000
cat >probe.html <<'END'
<script>const say = () => document.title = [...document.images].length + ' pictures, ' +
[...document.images].filter(i => !(i.complete && i.naturalWidth > 0)).length + ' broken, ' +
performance.getEntriesByType('resource').filter(r => !r.name.startsWith('file:')).length + ' fetched, ' +
[...document.querySelectorAll('section')].filter(s => s.scrollWidth > s.clientWidth + 1).length + ' too wide';
addEventListener('load', say);</script>
END
{ sed 's|</body></html>||' "an atlas/index.html"; cat probe.html; echo '</body></html>'; } >"an atlas/driven.html"
patiently chromium --headless --no-sandbox --disable-gpu --no-first-run --disable-background-networking --disable-component-update \
    --user-data-dir="$dir/browser" --window-size=1200,1600 --virtual-time-budget=5000 --dump-dom "file://$dir/an atlas/driven.html" 2>/dev/null >dom
check every_picture_is_seen grep -q '<title>50 pictures, 0 broken, 0 fetched, 0 too wide' dom
exit $failed
