#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Scenes that break renderers, by the ray caster at few pixels; scenes that are wrong; methods and adapted TFs at every
# level.
. "$(dirname "$0")/lib.sh"
suite=$top/refscenes/suite
validate() { "$ISOSHADE" validate --with gl --quick --full-paths -q "$@"; }

# One of each tier and each kind of trouble; the whole folder is for people.
mkdir few
for name in ramp-rotated inside-constant opaque-constant empty one-voxel-thick negative-ramp step surface-noise; do cp "$suite/$name.scene.json" few; done
check a_suite_agrees validate --suite few --size 16 -o report --junit report.xml
for tier in 'closed form' lock-step convergence 'first hit'; do check "the_report_has_rows_of_tier_$tier" grep -q "\"tier\": \"$tier\"" report/report.json; done
has_keys the_report_has report/report.json order step_bar gates rmse_at_twice_the_step
check each_scene_says_how_to_repeat_it grep -q 'isoshade make ramp --size 29x31x17 .* && isoshade render ramp-rotated.nrrd' report/report.json
check junit_counts_every_row test "$(grep -c '<testcase classname="agreement' report.xml)" = "$(grep -c '"verdict": "agree"' <(python3 -m json.tool report/report.json | sed -n '/"agreement"/,/"consistency"/p'))"
# The form that the schemas of Ant and of Jenkins both ask for.
cat >junit.py <<'END'
import re, sys, xml.etree.ElementTree as tree
for path in sys.argv[1:]:
    root = tree.parse(path).getroot()
    assert root.tag == "testsuites" and not root.attrib and len(root) > 0, path
    for i, suite in enumerate(root):
        children = [c.tag for c in suite]
        cases = [c for c in suite if c.tag == "testcase"]
        assert children == ["properties"] + ["testcase"] * len(cases) + ["system-out", "system-err"], children
        assert suite.get("id") == str(i) and suite.get("package") and suite.get("name") and suite.get("hostname"), suite.attrib
        assert re.fullmatch(r"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d", suite.get("timestamp")), suite.get("timestamp")
        for name, tag in (("failures", "failure"), ("errors", "error"), ("skipped", "skipped")):
            assert int(suite.get(name)) == sum(c.find(tag) is not None for c in cases), name
        assert int(suite.get("tests")) == len(cases) and re.fullmatch(r"\d+\.\d+", suite.get("time"))
        for case in cases:
            assert case.get("name") and case.get("classname") and re.fullmatch(r"\d+\.\d+", case.get("time")) and len(case) <= 1, case.attrib
            for child in case:
                assert child.tag in ("failure", "error", "skipped") and child.get("message"), child.tag
                assert child.tag == "skipped" or child.get("type"), child.attrib
END
check junit_has_the_common_form python3 junit.py report.xml
sed 's/ failures="0"/ failures="1"/' report.xml >planted.xml
expect a_wrong_count_in_it_is_noticed 1 python3 junit.py planted.xml
check a_baseline_is_taken "$ISOSHADE" report diff accepted.json report --accept
check and_holds "$ISOSHADE" report diff accepted.json report --worse
check all_scenes_of_the_folder_name_tier_and_reason test "$(grep -l '"tier": .*"why": "..' "$suite"/*.scene.json | wc -l)" = "$(ls "$suite" | wc -l)"

# Scenes at a time are a matter of speed alone.
facts() { python3 -c 'import json, sys
report = json.load(open(sys.argv[1]))
for row in report["agreement"]: del row["seconds"]; row["command"] = row["command"].replace(sys.argv[1].split("/")[0], "report")
print(json.dumps([report["agreement"], report["images"]], sort_keys=True, indent=1))' "$1/report.json" >"$1.facts"; }
for threads in 1 7; do "$ISOSHADE" validate --with gl --quick -q --full-paths --suite few --size 8 --threads $threads -o threads-$threads >/dev/null && facts threads-$threads; done
check scenes_at_a_time_change_nothing cmp threads-1.facts threads-7.facts
check rows_say_their_seconds python3 -c 'import json; assert all(r["seconds"] > 0 for r in json.load(open("report/report.json"))["agreement"])'

# The reproduce command of a row makes image b of the row again, bit by bit, and finds it within the row's limits.
# commands REPORT PATTERN...: of the first row of each pattern of b, its command, then the comparison without limits.
commands() {
    python3 - "$@" <<'END'
import json, re, shlex, sys
rows = json.load(open(sys.argv[1] + "/report.json"))["agreement"]
for pattern in sys.argv[2:]:
    row = next(r for r in rows if re.fullmatch(pattern, r["b"]) and r["command"])
    made = re.search(r" -o (\S+\.exr) && isoshade compare", row["command"]).group(1)
    print(f'{row["command"]} -q && isoshade compare {shlex.quote(sys.argv[1])}/images/{row["image_b"]}.exr {made} -q')
END
}
isoshade() { "$ISOSHADE" "$@"; }
run_commands() { local line; while read -r line; do eval "$line" </dev/null || return 1; done; }
check reproduce_commands_give_the_images_of_the_report run_commands < <(commands report gl 'gl, limit' reference)
commands report 'gl, limit' | sed 's/ --limit//' >planted
expect a_command_that_gives_another_image_is_noticed 1 run_commands <planted

# The formula of a ramp does not hold for its coarse levels, which the report lists; all else is compared.
mkdir coarse && cp "$suite/negative-ramp.scene.json" coarse
expect a_level_without_a_formula_does_not_end_a_suite 0 validate --suite coarse --levels 2 --size 8 -o coarse-report
check it_is_said_of_the_level grep -q 'not compared: negative-ramp, level 1, gl, limit: the scene.s formula does not hold for this level: ' "$dir/out"
check the_sentence_counts_it grep -q 'not compared: 1 case of a level that no formula holds for' coarse-report/report.json
check and_the_level_is_compared_by_the_same_samples python3 -c 'import json
rows = [r for r in json.load(open("coarse-report/report.json"))["agreement"] if r["level"] == 1]
assert any(r["verdict"] == "agree" for r in rows) and any(r.get("not_compared") == "formula" for r in rows)'

mkdir false bare
sed 's/"constant --size/"noise --size/' "$suite/constant.scene.json" >false/false.scene.json
refuse a_closed_form_that_is_none_is_refused 5 "off a linear field" validate --suite false -o no
cp "$top/refscenes/shells.scene.json" "$top/refscenes/shells.tf.json" bare
refuse scales_of_no_levels_are_refused 2 "with --suite, which does not judge levels" validate --suite false --extinction-scale -o no
refuse a_scene_without_a_volume_is_refused 4 "nothing says what volume" validate --suite bare -o no
# The words of a scene say what volume is made: not where, and nothing of the whole run.
mkdir bold
bold() { # words: validate and scenes with a suite whose scene has them
    sed "s|\"constant |\"constant $1 |" "$suite/constant.scene.json" >bold/bold.scene.json
    local said="bold.scene.json: \"make\" is \"constant $1"
    refuse "a_scene_cannot_say_${1%% *}" 4 "$said" validate --suite bold --size 8 -o no
    refuse "nor_where_requests_are_written_${1%% *}" 4 "$said" "$ISOSHADE" scenes --write no --suite bold --size 8 -q
}
for words in --no-sandbox '--timeout 0' --full-paths --json --help --quiet '-o e.nrrd' --output=e.nrrd '--range 9'; do
    bold "$words"
done
refuse an_empty_folder_is_refused 2 "holds no .scene.json" validate --suite few/.. -o no
refuse a_suite_takes_no_volume 2 "remove \"x.nrrd\"" validate x.nrrd --suite few -o no
refuse a_junit_file_without_a_folder_is_told_before_the_work 3 "the folder nowhere does not exist" validate --suite few -o no --junit nowhere/no.xml
render() { "$ISOSHADE" render few/no.nrrd --scene "$suite/step.scene.json" -q -o no.exr "$@"; }
refuse seeds_are_of_limits 2 "--seeds needs --limit" render --with cycles --seeds 3
refuse the_reference_has_no_limit 2 "--limit needs --with gl, cpu, cycles or povray" render --with reference --limit
refuse a_limit_halves_intervals 2 "must be even" render --with povray --limit --intervals 7
refuse one_seed_has_no_scatter 2 "--seeds" validate --suite few --seeds 1 -o no
refuse a_suite_takes_no_scene 2 "exclude each other" validate --suite few --scene x.scene.json -o no
# A step of opacity 0.9999 in a scene declared smooth: a float sample falls on its other side, which is an error then.
mkdir sharp
sed 's/"tf": "sharp"/"tf": "smooth"/; s/"opacity": 0.7/"opacity": 0.9999/' "$suite/step.scene.json" >sharp/sharp.scene.json
expect a_row_outside_its_limits_is_exit_1 1 "$ISOSHADE" validate --with gl --quick -q --suite sharp --size 12 -o wide --junit wide.xml
check the_failure_has_the_common_form python3 junit.py wide.xml
check and_a_failure_with_its_command grep -q 'failure type="differ".*isoshade make noise .*sharp.nrrd' wide.xml

# Said to be sharp, it is also looked up exactly, within limits that the texture unit does not meet.
mkdir steep
sed 's/"opacity": 0.7/"opacity": 0.9999/' "$suite/step.scene.json" >steep/steep.scene.json
check a_steep_table_agrees "$ISOSHADE" validate --with gl --quick --full-paths -q --suite steep --size 24 -o steeply
check and_within_narrower_limits_when_it_is_looked_up_exactly python3 - <<'END'
import json
rows = {r["b"]: r for r in json.load(open("steeply/report.json"))["agreement"] if r["tier"] == "lock-step"}
exact, filtered = rows["gl, exact lookups"], rows["gl"]
assert exact["verdict"] == "agree", exact
assert filtered["max_abs"] > exact["limits"]["max_abs"] >= 2 * exact["max_abs"], (filtered["max_abs"], exact["max_abs"])
END
check reproduce_commands_know_exact_lookups run_commands < <(commands steeply 'gl, exact lookups')

# Noise, whose adapted TFs are used: where small views show them worse than the original, there are no rows of them.
"$ISOSHADE" make noise --size 21x22x25 --seed 7 -o v.nrrd -q
check every_method_agrees_at_every_level validate v.nrrd --scene "$top/refscenes/marschner-lobb.scene.json" --size 16 --levels 3 -o methods
for row in 'on-the-fly' naive eq1 'moments, adapted TF' 'naive, adapted TF'; do check "there_are_rows_of_$row" grep -q "\"b\": \"gl, $row\"" methods/report.json; done
check reproduce_commands_know_methods_and_2d_tfs run_commands < <(commands methods 'gl, on-the-fly' 'gl, naive' 'gl, eq1, adapted TF' 'gl, moments, 2D TF .*')
check another_code_agrees validate v.nrrd --scene "$top/refscenes/marschner-lobb.scene.json" --size 16 --levels 2 --code cube -o 'coded report'
check reproduce_commands_know_codes_and_quote_paths run_commands < <(commands 'coded report' gl 'gl, eq1' 'gl, limit')

# A volume too faint to be seen: a renderer that draws nothing is within all limits, and nothing is shown to agree.
faint() { # opacity a voxel
    cat <<END
{"schema": "isoshade.scene/1", "image": {"width": 24, "height": 24},
 "camera": {"projection": "orthographic", "fit": true, "direction": [1, 2, -1], "up": [0, 0, 1], "margin": 1.0},
 "lights": [{"direction": [0, 0, 1], "space": "camera", "intensity": 1}],
 "shading": {"ambient": 0.3, "diffuse": 0.7, "specular": 0.0, "power": 1},
 "background": [0, 0, 0], "step_voxels": 0.5,
 "agreement": {"tier": "convergence", "tf": "smooth", "why": "faint"},
 "tf": {"schema": "isoshade.tf/1", "range": "fit", "unit_distance_voxels": 1, "color_space": "linear", "table_size": 64,
  "points": [{"value": 0, "r": 1, "g": 0.2, "b": 0.1, "opacity": 0}, {"value": 1, "r": 0.1, "g": 0.5, "b": 1, "opacity": $1}]}}
END
}
faint 1e-8 >faint.scene.json
faint 1e-3 >pale.scene.json
refuse what_is_too_faint_is_refused 5 "shows no values" "$ISOSHADE" validate v.nrrd --scene faint.scene.json --quick --with gl --levels 2 --size 16 -q -o faint
expect and_not_compared_where_asked_for_anyway 1 "$ISOSHADE" validate v.nrrd --scene faint.scene.json --anyway --quick --with gl --levels 2 --size 16 -q -o faint --junit faint.xml
check nothing_is_said_to_agree grep -q '^Nothing was compared, .*not compared: [0-9]* cases that show too little for their limits' "$dir/out"
check with_both_numbers grep -Eq '^not compared: faint, level [01], gl.*: the reference shows only [0-9.e-]+ above its background .* asks for at least 0.0001' "$dir/out"
check in_junit_it_is_a_failure grep -q '<failure type="not compared"' faint.xml
check what_is_pale_is_compared validate v.nrrd --scene pale.scene.json --levels 1 --size 16 -o pale
check every_row_says_its_signal python3 -c 'import json
rows = json.load(open("pale/report.json"))["agreement"]
assert rows and all(min(r["signal"]["color"], r["signal"]["alpha"]) >= r["signal"]["least"] > 0 for r in rows), rows'
check the_empty_scene_is_held_to_the_background_exactly python3 -c 'import json
rows = [r for r in json.load(open("report/report.json"))["agreement"] if r["scene"] == "empty"]
assert rows and all(r["limits"] == {"max_abs": 0} and r["gates"] == [] and r["verdict"] == "agree" for r in rows), rows'

# A check whose renderers nobody asked for is no case.
expect a_run_without_the_ray_caster 0 "$ISOSHADE" validate v.nrrd --scene "$top/refscenes/marschner-lobb.scene.json" --with cpu --quick --levels 2 --size 8 -q -o alone
check compares_all_that_was_asked_for grep -q 'all 17 comparisons are within their limits[.]' "$dir/out"
check and_lists_nothing_else test -z "$(grep '^not compared' "$dir/out")"

# A scene that does not say whether its TF is smooth is asked what its volume and TF tell. Those that say it are right.
mkdir unsaid
for scene in "$suite"/*.scene.json; do
    grep -q '"isosurface"' "$scene" || python3 -c 'import json, sys
scene = json.load(open(sys.argv[1])); del scene["agreement"]; json.dump(scene, open(sys.argv[2], "w"))' "$scene" "unsaid/$(basename "$scene")"
done
cp "$suite"/*.tf.json unsaid 2>/dev/null
"$ISOSHADE" validate --with gl --quick -q --suite unsaid --size 4 -o unsaid-report >unsaid.out 2>/dev/null
cat >unsaid.py <<'END'
import glob, json, sys
asked = json.load(open("unsaid-report/report.json"))["asked"]
stated = {path.split("/")[-1][:-len(".scene.json")]: json.load(open(path))["agreement"]["tf"] for path in glob.glob(sys.argv[1] + "/*.scene.json")}
assert len(asked) >= 18 and all(a["assumed"] and a["tier"] == "convergence" for a in asked.values()), asked
wrong = {name: a["why"] for name, a in asked.items() if a["tf"] != stated[name]}
assert not wrong, wrong
END
check what_is_assumed_is_what_scenes_say python3 unsaid.py "$suite"
check and_it_is_said grep -q '^assumed: step: the scene states no agreement: .* is taken for sharp' unsaid.out
check on_the_page_as_well grep -q 'the scene states no agreement' unsaid-report/index.html
check what_is_stated_is_not_assumed python3 -c 'import json
asked = json.load(open("report/report.json"))["asked"]
assert len(asked) == 8 and not any(a["assumed"] for a in asked.values()), asked'
exit $failed
