#!/usr/bin/env bash
# The whole path by commands: a volume in, four renderers, one report; and bad input on the way.
set -u
top=$(cd "$(dirname "$0")/.." && pwd)
program=${ISOSHADE:-$top/isoshade}
scenes=$top/refscenes
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work" || exit 1
bad=0
ok() { echo "ok $1"; }
not_ok() { echo "not ok $1: $2"; bad=1; }
# name, wanted exit code, words of the message, command ... : one line on stderr, nothing left behind
refuses() {
    local name=$1 code=$2 words=$3 got message before after
    shift 3
    before=$(find . | sort)
    message=$("$@" 2>&1 >/dev/null)
    got=$?
    after=$(find . | sort)
    if [ $got != "$code" ]; then not_ok "$name" "exit code $got, wanted $code: $message"
    elif [ "$(wc -l <<<"$message")" != 1 ]; then not_ok "$name" "not one line: $message"
    elif ! grep -qF -- "$words" <<<"$message"; then not_ok "$name" "\"$message\" does not say \"$words\""
    elif [ "$before" != "$after" ]; then not_ok "$name" "files were left: $(diff <(echo "$before") <(echo "$after"))"
    else ok "$name"; fi
}
works() { # name, command ...
    local name=$1 output
    shift
    if output=$("$@" 2>&1); then ok "$name"; else not_ok "$name" "exit code $?: $(tail -n 3 <<<"$output")"; fi
}
render() { "$program" render -q "$@"; }

works "a volume is made" "$program" make shells --size 12x14x11 --spacing 1x1.2x0.9 -o v.nrrd
works "a pyramid is built" "$program" build v.nrrd -o v.iso --levels 2 -q
for with in reference gl povray cycles; do
    works "$with renders level 1 of the pyramid" render v.iso --scene "$scenes/shells.scene.json" --with $with --level 1 --size 24 -o $with.exr
done
works "the reference renders POV-Ray's samples" render v.iso --scene "$scenes/shells.scene.json" --with reference --quadrature povray --intervals 60 --size 24 -o a.exr
works "POV-Ray renders in lock-step" render v.iso --scene "$scenes/shells.scene.json" --with povray --intervals 60 --size 24 -o b.exr
works "lock-step images agree" "$program" compare a.exr b.exr --max-abs 2e-5
"$program" compare gl.exr a.exr --max-abs 2e-5 >/dev/null 2>&1
[ $? = 1 ] && ok "different levels differ, with exit code 1" || not_ok "different levels differ, with exit code 1" "exit code $?"
works "a picture for people is written beside the image" render v.nrrd --scene "$scenes/shells.scene.json" --size 24 -o p.exr --png p.png
[ "$(head -c 4 p.png | tail -c 3)" = PNG ] && ok "it is a PNG" || not_ok "it is a PNG" "wrong magic"

works "a small volume is validated" "$program" validate v.nrrd --scene "$scenes/shells.scene.json" --quick --levels 1 --size 20 -q -o report
for key in agreement consistency calibration versions machine; do
    grep -q "\"$key\"" report/report.json && ok "report.json has $key" || not_ok "report.json has $key" "it has not"
done
[ -s report/index.html ] && ! grep -qE '(src|href)="https?:' report/index.html && ok "index.html needs no network" || not_ok "index.html needs no network" "it names addresses"
ISOSHADE_BLENDER=/nonexistent/blender "$program" validate v.nrrd --scene "$scenes/shells.scene.json" --quick --levels 1 --size 16 --with gl,cycles -q -o without >out.txt 2>err.txt
[ $? = 7 ] && grep -q '"refused"' without/report.json && grep -q blender err.txt && ok "without Blender the rest is reported, with exit code 7" ||
    not_ok "without Blender the rest is reported, with exit code 7" "$(cat err.txt)"

scene() { # name, sed expression on the shells scene
    sed "s|\"shells.tf.json\"|\"$scenes/shells.tf.json\"|; $2" "$scenes/shells.scene.json" >"$1"
}
scene dark.scene.json 's/"lights": .*/"lights": [],/'
scene bright.scene.json 's/"ambient": 0.2/"ambient": 0.9/'
scene lost.scene.json 's/shells.tf.json/none.tf.json/'
sed 's/"points": \[.*//; /"value"/d; s/^  \]/  "points": []/' "$scenes/shells.tf.json" >empty.tf.json
scene empty.scene.json "s|$scenes/shells.tf.json|empty.tf.json|"
echo '{"schema": "isoshade.scene/1",' >broken.scene.json
refuses "a scene without a light" 5 "dark.scene.json: the scene has 0 lights" "$program" render v.nrrd --scene dark.scene.json -q -o x.exr
refuses "shading above 1" 5 "at most 1" "$program" render v.nrrd --scene bright.scene.json -q -o x.exr
refuses "a missing transfer function" 3 "none.tf.json" "$program" render v.nrrd --scene lost.scene.json -q -o x.exr
refuses "a transfer function without points" 5 "empty.tf.json" "$program" render v.nrrd --scene empty.scene.json -q -o x.exr
refuses "a scene that is not JSON" 4 "broken.scene.json" "$program" render v.nrrd --scene broken.scene.json -q -o x.exr
refuses "a scene that is not there" 3 "no.scene.json" "$program" render v.nrrd --scene no.scene.json -q -o x.exr
refuses "no scene at all" 2 "--scene" "$program" render v.nrrd -q -o x.exr
refuses "a level that the pyramid lacks" 5 "levels 0 to 1" "$program" render v.iso --scene "$scenes/shells.scene.json" --level 5 -q -o x.exr
refuses "an unknown renderer" 2 "mitsuba" "$program" render v.nrrd --scene "$scenes/shells.scene.json" --with mitsuba -q -o x.exr
refuses "a step that is not a number" 2 "--step" "$program" render v.nrrd --scene "$scenes/shells.scene.json" --step fast -q -o x.exr
refuses "a step of NaN" 2 "--step" "$program" render v.nrrd --scene "$scenes/shells.scene.json" --step nan -q -o x.exr
refuses "an image size of 0" 2 "--size" "$program" render v.nrrd --scene "$scenes/shells.scene.json" --size 0 -q -o x.exr
refuses "an output folder that is not there" 3 "nowhere" "$program" render v.nrrd --scene "$scenes/shells.scene.json" --size 8 -q -o nowhere/x.exr
refuses "a report over a folder of others" 3 "report.json" "$program" validate v.nrrd --scene "$scenes/shells.scene.json" --quick --with gl -q -o v.iso
refuses "a missing POV-Ray" 7 "povray" env ISOSHADE_POVRAY=/nonexistent/povray "$program" render v.nrrd --scene "$scenes/shells.scene.json" --with povray --size 8 -q -o x.exr
refuses "a missing Blender" 7 "blender" env ISOSHADE_BLENDER=/nonexistent/blender "$program" render v.nrrd --scene "$scenes/shells.scene.json" --with cycles --size 8 -q -o x.exr
refuses "a POV-Ray that fails" 8 "exit code 1" env ISOSHADE_POVRAY=/bin/false "$program" render v.nrrd --scene "$scenes/shells.scene.json" --with povray --size 8 -q -o x.exr
refuses "an export to nothing" 2 "--to" "$program" export v.nrrd --to maya -q -o x
refuses "an unknown command" 2 "unknown command" "$program" shade v.nrrd
exit $bad
