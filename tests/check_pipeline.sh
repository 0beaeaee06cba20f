#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# The whole path by commands: a volume in, four renderers, one report; and bad input on the way.
. "$(dirname "$0")/lib.sh"
scenes=$top/refscenes
render() { "$ISOSHADE" render -q "$@"; }

check "a volume is made" "$ISOSHADE" make shells --size 12x14x11 --spacing 1x1.2x0.9 -o v.nrrd
check "a pyramid is built" "$ISOSHADE" build v.nrrd -o v.iso --levels 2 -q
for with in reference gl povray cycles; do
    check "$with renders level 1 of the pyramid" render v.iso --scene "$scenes/shells.scene.json" --with $with --level 1 --size 24 -o $with.exr
done
check "the reference renders POV-Ray's samples" render v.iso --scene "$scenes/shells.scene.json" --with reference --quadrature povray --intervals 60 --size 24 -o a.exr
check "POV-Ray renders in lock-step" render v.iso --scene "$scenes/shells.scene.json" --with povray --intervals 60 --size 24 -o b.exr
check "lock-step images agree" "$ISOSHADE" compare a.exr b.exr --max-abs 2e-5
"$ISOSHADE" compare gl.exr a.exr --max-abs 2e-5 >/dev/null 2>&1
[ $? = 1 ] && ok "different levels differ, with exit code 1" || not_ok "different levels differ, with exit code 1" "exit code $?"
check "a picture for people is written beside the image" render v.nrrd --scene "$scenes/shells.scene.json" --size 24 -o p.exr --png p.png
[ "$(head -c 4 p.png | tail -c 3)" = PNG ] && ok "it is a PNG" || not_ok "it is a PNG" "wrong magic"

check "a small volume is validated" "$ISOSHADE" validate v.nrrd --scene "$scenes/shells.scene.json" --quick --levels 1 --size 20 --with gl,povray -q -o report
has_keys "report.json has" report/report.json agreement consistency calibration versions machine
[ -s report/index.html ] && ! grep -qE '(src|href)="https?:' report/index.html && ok "index.html needs no network" || not_ok "index.html needs no network" "it names addresses"
ISOSHADE_BLENDER=/nonexistent/blender "$ISOSHADE" validate v.nrrd --scene "$scenes/shells.scene.json" --quick --levels 1 --size 16 --with gl,cycles -q -o without >out.txt 2>err.txt
[ $? = 7 ] && grep -q '"refused"' without/report.json && grep -q blender err.txt && ok "without Blender the rest is reported, with exit code 7" ||
    not_ok "without Blender the rest is reported, with exit code 7" "$(cat err.txt)"

# Programs that are not installed and that nobody named are left out by name, with their packages; the verdict is of the others.
mkdir nothing && ln -s "$(command -v gnuplot)" nothing/
bare() { timeout 100 env PATH="$dir/nothing" "$ISOSHADE" "$@" 2>err.txt; }
small=(v.nrrd --scene "$scenes/shells.scene.json" --size 12 -q)
expect "a validation of all that are installed" 0 bare validate "${small[@]}" --quick --levels 1 -o bare
cp out bare.txt
check "is of these" grep -q '^The renderers agree: all [0-9]* comparisons are within their limits[.]$' bare.txt
for row in cycles:blender:blender povray:povray:povray; do
    IFS=: read -r name program package <<<"$row"
    words="$name: $program: not found on PATH; install the Debian package $package"
    check "$name is left out by its package" grep -q "^left out: $words" bare.txt
    check "in the report too" python3 -c 'import json, sys
assert f"{sys.argv[1]}: " + json.load(open("bare/report.json"))["left_out"][sys.argv[1]] in sys.argv[2], sys.argv' "$name" "$words, or set \$ISOSHADE_${program^^}"
    check "and on its page" grep -q "\"$name\":\"$program: not found on PATH" bare/index.html
    expect "$name is an error if it is named" 7 bare validate "${small[@]}" --quick --levels 1 --with gl,$name -o named
    check "with its package" grep -q "install the Debian package $package" err.txt
    refuse "and in a figure" 7 "install the Debian package $package" env PATH="$dir/nothing" "$ISOSHADE" figure v.nrrd --kind renderers --with $name -q -o named-figure
done
check "no stage is a gap because of it" python3 -c 'import json
rows = json.load(open("bare/report.json"))["agreement"]
found = {(r["verdict"], r["renderer"]) for r in rows}; assert found == {("agree", "gl")}, found'
ISOSHADE_GL_DEVICE=none expect "without OpenGL the CPU ray caster takes its place" 0 bare validate "${small[@]}" --quick --levels 1 -o without-gl
check "and OpenGL is left out by name" grep -q '^left out: gl: gl: no device "none"' out
ISOSHADE_GL_DEVICE=none expect "in charts too" 0 bare chart "${small[@]}" --levels 1 --steps 1 --budget 2 -o charted
check "whose settings are its" python3 -c 'import json
chart = json.load(open("charted/chart.json"))
assert set(chart["left_out"]) == {"gl", "cycles", "povray"} and {s["renderer"] for s in chart["cases"]} == {"cpu"}, chart["left_out"]'
scene() { # name, sed expression on the shells scene
    sed "s|\"shells.tf.json\"|\"$scenes/shells.tf.json\"|; $2" "$scenes/shells.scene.json" >"$1"
}
scene dark.scene.json 's/"lights": .*/"lights": [],/'
scene bright.scene.json 's/"ambient": 0.2/"ambient": 0.9/'
scene lost.scene.json 's/shells.tf.json/none.tf.json/'
sed 's/"points": \[.*//; /"value"/d; s/^  \]/  "points": []/' "$scenes/shells.tf.json" >empty.tf.json
scene empty.scene.json "s|$scenes/shells.tf.json|empty.tf.json|"
echo '{"schema": "isoshade.scene/1",' >broken.scene.json
refuse "a scene without a light" 5 "dark.scene.json: the scene has 0 lights" "$ISOSHADE" render v.nrrd --scene dark.scene.json -q -o x.exr
refuse "shading above 1" 5 "at most 1" "$ISOSHADE" render v.nrrd --scene bright.scene.json -q -o x.exr
refuse "a missing transfer function" 3 "none.tf.json" "$ISOSHADE" render v.nrrd --scene lost.scene.json -q -o x.exr
refuse "a transfer function without points" 5 "empty.tf.json" "$ISOSHADE" render v.nrrd --scene empty.scene.json -q -o x.exr
refuse "a scene that is not JSON" 4 "broken.scene.json" "$ISOSHADE" render v.nrrd --scene broken.scene.json -q -o x.exr
refuse "a scene that is not there" 3 "no.scene.json" "$ISOSHADE" render v.nrrd --scene no.scene.json -q -o x.exr
check "no scene at all is a first one" render v.nrrd --size 16 -o first.exr
refuse "a level that the pyramid lacks" 5 "levels 0 to 1" "$ISOSHADE" render v.iso --scene "$scenes/shells.scene.json" --level 5 -q -o x.exr
refuse "an unknown renderer" 2 "mitsuba" "$ISOSHADE" render v.nrrd --scene "$scenes/shells.scene.json" --with mitsuba -q -o x.exr
refuse "a step that is not a number" 2 "--step" "$ISOSHADE" render v.nrrd --scene "$scenes/shells.scene.json" --step fast -q -o x.exr
refuse "a step of NaN" 2 "--step" "$ISOSHADE" render v.nrrd --scene "$scenes/shells.scene.json" --step nan -q -o x.exr
refuse "an option of another renderer" 2 "--intervals needs --with reference or povray" "$ISOSHADE" render v.nrrd --scene "$scenes/shells.scene.json" --with gl --intervals 9 -q -o x.exr
refuse "an image size of 0" 2 "--size" "$ISOSHADE" render v.nrrd --scene "$scenes/shells.scene.json" --size 0 -q -o x.exr
refuse "an output folder that is not there" 3 "nowhere" "$ISOSHADE" render v.nrrd --scene "$scenes/shells.scene.json" --size 8 -q -o nowhere/x.exr
refuse "a report over a folder of others" 3 "report.json" "$ISOSHADE" validate v.nrrd --scene "$scenes/shells.scene.json" --quick --with gl -q -o v.iso
# Where no step is asked for, programs have one of their own, and the converged reference has none: the answer and the header
# of the picture say which.
step_of() { # words: "" where there is none
    "$ISOSHADE" render v.nrrd --scene "$scenes/shells.scene.json" --size 8 -q -o step.exr --json "$@" >step.json &&
        python3 -c 'import json; step = json.load(open("step.json"))["step_voxels"]; print("" if step is None else "%g" % step)'
}
check "the reference has no step" test -z "$(step_of --with reference)"
check "its header says so" grep -aq 'stepVoxels.\{0,20\}none' step.exr
check "the ray caster takes the scene's" test "$(step_of --with cpu)" = 0.25
check "or that of --step" test "$(step_of --with cpu --step 0.5)" = 0.5
check "a limit begins with a quarter" test "$(step_of --with cpu --limit)" = 0.25
if has_cycles; then check "Cycles takes a sixteenth" test "$(step_of --with cycles)" = 0.0625; else skip "Cycles takes a sixteenth" "$lack"; fi
check "POV-Ray takes its most intervals" python3 -c 'import sys; sys.exit(not 0 < float(sys.argv[1]) < 0.1)' "$(step_of --with povray)"
refuse "a missing POV-Ray" 7 "povray" env ISOSHADE_POVRAY=/nonexistent/povray "$ISOSHADE" render v.nrrd --scene "$scenes/shells.scene.json" --with povray --size 8 -q -o x.exr
refuse "a missing Blender" 7 "blender" env ISOSHADE_BLENDER=/nonexistent/blender "$ISOSHADE" render v.nrrd --scene "$scenes/shells.scene.json" --with cycles --size 8 -q -o x.exr
refuse "a POV-Ray that fails" 8 "exit code 1" env ISOSHADE_POVRAY=/bin/false "$ISOSHADE" render v.nrrd --scene "$scenes/shells.scene.json" --with povray --size 8 -q -o x.exr
refuse "an export to nothing" 2 "--to" "$ISOSHADE" export v.nrrd --to maya -q -o x
refuse "an unknown command" 2 "unknown command" "$ISOSHADE" shade v.nrrd
exit $failed
