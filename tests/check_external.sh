#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Programs as renderers: doc/guide/numpy_renderer.py agrees; one that fails, hangs or cheats is refused by name within
# its time limit, and nothing that it began lives on; what a renderers.json says wrong is named.
. "$(dirname "$0")/lib.sh"
python_with numpy
scene=$top/refscenes/shells.scene.json
export CHECK_EXTERNAL_MARK=$dir # in the environment of whatever is started from here
"$ISOSHADE" make shells --size 12x11x10 -q -o v.nrrd

# ---- the example ----
cp "$top/doc/guide/numpy_renderer.py" .
sed "s|\"python3\", \"numpy|\"$python\", \"numpy|" "$top/doc/guide/renderers.json" >renderers.json
shown() { awk '/^```json$/ {on = 1; next} /^```/ {on = 0} on' "$top/doc/guide/judging-a-renderer.md"; }
check the_page_shows_the_file diff <(shown) "$top/doc/guide/renderers.json"
holds the_example_is_short "$(grep -c . numpy_renderer.py) <= 56"
flatten() { # report: REPORT.txt has a line "LIST NAME KEY VALUE" for each value of its rows and programs
    python3 -c '
import json, sys
report = json.load(open(sys.argv[1] + "/report.json"))
for of in "calibration", "agreement":
    for row in report[of]:
        for key in row: print(of, row["renderer"], key, row[key])
for name, program in report["programs"].items():
    for key in program: print("programs", name, key, program[key])' "$1" >"$1.txt"
}
row() { sed -n "s/^$2 $3 $4 //p" "$1.txt"; } # report, list, name, key of it: values of the rows of that renderer
mkdir suite
cp "$top"/refscenes/suite/{highlights,ramp-rotated,negative-noise}.scene.json suite/
python3 - <<'END'
import json
cut = json.load(open('suite/highlights.scene.json'))
cut['clip_planes'] = [{'normal': [0.3, 1, 0.2], 'at': 0.4}, {'normal': [-1, 0, 0], 'at': 0.3}]
json.dump(cut, open('suite/cut.scene.json', 'w'))
END
expect the_example_agrees_on_scenes_of_the_suite 0 "$ISOSHADE" validate --suite suite --with numpy --renderers renderers.json --size 12 -q -o suited
flatten suited
check all_seven_calibrations_pass test "$(row suited calibration numpy verdict | sort | uniq -c | tr -s ' ')" = " 7 pass"
check each_scene_has_rows_that_agree test "$(row suited agreement numpy verdict | sort -u)" = agree
check rows_name_the_file_of_the_renderer grep -q -- '--with numpy --renderers renderers.json' suited/report.json
# The step of its row, which the picture is drawn by; --step comes before it.
sed 's/"tier": "samples",/"tier": "samples", "step_voxels": 0.125,/' renderers.json >stepped.json
stepped() { "$ISOSHADE" render v.nrrd --scene "$scene" --size 8 --with numpy --renderers stepped.json -o stepped.exr --json -q "$@"; }
by_step() { # STEP: the picture has it
    "$ISOSHADE" render v.nrrd --scene "$scene" --size 8 --with reference --quadrature midpoint --step "$1" -o asked.exr -q >/dev/null &&
        "$ISOSHADE" compare stepped.exr asked.exr --max-abs 1e-6 >/dev/null
}
expect a_row_with_a_step_of_its_own 0 stepped
check says_that_step test "$(json_number out step_voxels)" = 0.125
check and_takes_it by_step 0.125
notice and_no_other by_step 0.25
expect a_step_that_is_asked_for 0 stepped --step 0.5
check is_said test "$(json_number out step_voxels)" = 0.5
check and_taken by_step 0.5
check the_list_has_it bash -c "ISOSHADE_RENDERERS=renderers.json '$ISOSHADE' list | grep -q '^  numpy  *numpy ray caster'"
check not_by_default bash -c "! '$ISOSHADE' list | grep -q '^  numpy '"

# ---- a program that was edited while its run was interrupted, which no version tells: nothing of before is taken ----
mkdir killing edited && printf '#!/bin/sh\nkill -KILL $PPID\n' >killing/gnuplot && chmod +x killing/gnuplot # which the report needs
cp v.nrrd numpy_renderer.py renderers.json edited
again() { (cd edited && "$ISOSHADE" validate v.nrrd --scene "$scene" --with numpy --renderers renderers.json --quick --levels 1 --size 8 -q -o r "$@"); }
(PATH=$dir/killing:$PATH && again) >/dev/null 2>&1
check a_run_by_the_example_is_interrupted test -e edited/r.work -a ! -e edited/r
sed -i 's/^        alpha = -np.expm1/        alpha = -0.5 * np.expm1/' edited/numpy_renderer.py
expect an_edited_program_is_drawn_with_again 9 again --resume

# ---- programs that fail ----
"$python" - "$top/tests/peers" <<'END'
import sys
sys.path.insert(0, sys.argv[1])
import numpy as np
from exr import write_exr

bad = np.zeros((32, 32, 4), np.float32)
write_exr('right.exr', 32, 32, bad.ravel())
write_exr('wide.exr', 33, 32, np.zeros(33 * 32 * 4, np.float32))
np.save('right.npy', bad)
np.save('three.npy', bad[..., :3])
np.save('turned.npy', np.zeros((32, 33, 4), np.float32))
np.save('integers.npy', np.zeros((32, 32, 4), np.int32))
open('cut.npy', 'wb').write(open('right.npy', 'rb').read()[:-1])
open('long.npy', 'wb').write(open('right.npy', 'rb').read() + b'!')
open('torn.npy', 'wb').write(open('right.npy', 'rb').read()[:40])
def pfm(name, kind, size, count, scale=b'-1.0'):
    open(name, 'wb').write(b'%s\n%s\n%s\n' % (kind, size, scale) + bytes(4 * count))
pfm('color.pfm', b'PF', b'32 32', 3072), pfm('alpha.pfm', b'Pf', b'32 32', 1024)
pfm('gray.pfm', b'Pf', b'32 32', 1024), pfm('narrow.pfm', b'PF', b'31 32', 31 * 96)
pfm('scaled.pfm', b'PF', b'32 32', 3072, b'2.5'), pfm('short.pfm', b'PF', b'32 32', 3071)
open('nothing.pfm', 'wb').write(b'P6 no picture')
bad[3, 5, 1] = np.nan
write_exr('nan.exr', 32, 32, bad.ravel())
np.save('infinite.npy', np.where(np.isnan(bad), np.inf, bad).astype('>f2'))
three = open('right.exr', 'rb').read().replace(b'A\0\2\0\0\0', b'0\0\2\0\0\0', 1)
open('three.exr', 'wb').write(three)
END
touch -d '1 hour ago' right.exr
cat >bad.sh <<'END'
#!/bin/bash
here=$(dirname "$0")
case $1 in
hang) sleep 1000 ;;
deaf) trap '' TERM INT HUP; while :; do sleep 1000; done ;;
crash) kill -SEGV $$ ;;
code) echo "no such luck" >&2; exit 3 ;;
nothing) echo "nothing to do" ;;
garbage) echo garbage >frame0.exr ;;
empty) : >frame0.exr ;;
pipe) mkfifo frame0.exr ;;
link) ln -s "$here/right.exr" frame0.exr ;;
stale) cp -p "$here/right.exr" frame0.exr ;;
wide | nan | three) cp "$here/$1.exr" frame0.exr ;;
np-*) cp "$here/${1#np-}.npy" frame0.npy ;;
pf-*) cp "$here/${1#pf-}.pfm" frame0.pfm; cp "$here/alpha.pfm" frame0-alpha.pfm ;;
opaque) cp "$here/color.pfm" frame0.pfm ;;
twice) cp "$here/right.npy" frame0.npy; cp "$here/right.exr" frame0.exr; touch frame0.exr ;;
npy-link) ln -s "$here/right.npy" frame0.npy ;;
black) cp "$here/right.exr" frame0.exr ;;
flood) exec yes ;;
closed) exec >&- 2>&-; sleep 1000 ;;
orphan) setsid sleep 1000 >/dev/null 2>&1 & cp "$here/right.exr" frame0.exr ;;
odd) printf 'tab\t \001\377\303 end\n' >&2; exit 1 ;;
esac
END
chmod +x bad.sh
names="hang deaf crash code nothing garbage empty pipe link stale wide nan three black flood closed orphan odd"
arrays="np-three np-turned np-integers np-cut np-long np-torn np-infinite
    pf-gray pf-narrow pf-scaled pf-short pf-nothing opaque twice npy-link"
rows_of() { python3 -c 'import json, sys
ends_never = ("hang", "deaf", "flood", "closed")
rows = [{"name": n, "command": ["./bad.sh", n], "tier": "samples", "can": ["lights", "orthographic"],
         "timeout_seconds": 0.4 if n in ends_never else 60} for n in sys.argv[1:]]
json.dump({"schema": "isoshade.renderers/1", "renderers": rows}, sys.stdout)' "$@"; }
rows_of $names >bad.json
rows_of $arrays >arrays.json
start=$(date +%s)
expect renderers_that_fail_make_a_report 9 "$ISOSHADE" validate v.nrrd --scene "$scene" --quick --levels 1 --size 8 --with "${names// /,}" --renderers bad.json --junit bad.xml -q -o bad
flatten bad
holds they_take_no_longer_than_their_limits "$(($(date +%s) - start)) <= 20"
check the_page_is_there test -s bad/index.html
check junit_has_their_failures test "$(grep -c "type=.calibration.*nothing was measured" bad.xml)" -ge 16
while read -r name words; do
    if row bad calibration "$name" detail | grep -qF -- "$words" && [ "$(row bad agreement "$name" verdict | sort -u)" = refused ]; then ok "${name}_is_refused_by_name"
    else not_ok "${name}_is_refused_by_name" "$(row bad calibration "$name" detail | tail -n 1)"; fi
done <<'END'
hang stopped after 0.4 s, the time limit
deaf stopped after 0.4 s, the time limit
crash ended by signal 11
code exit code 3: no such luck
nothing frame0.exr was not written; last output: nothing to do
garbage frame0.exr: is no picture of a known kind, must be OpenEXR
empty frame0.exr: is empty, must be OpenEXR
pipe frame0.exr is not a regular file
link frame0.exr is not a regular file
stale frame0.exr is older than the request for it
wide frame0.exr has 33 x 32 pixels, needs 32 x 32
nan frame0.exr has 1 values that are not finite, the first in column 5 of row 3
three frame0.exr has no full-resolution channel A
black half a voxel would be
flood stopped after 0.4 s, the time limit
closed stopped after 0.4 s, the time limit
orphan half a voxel would be
odd exit code 1: tab  ??? end
END
# Arrays and PFM in place of OpenEXR: each damage has one message.
while read -r name words; do
    refuse "${name}_is_refused" 8 "$words" "$ISOSHADE" render v.nrrd --scene "$scene" --size 32 --with $name --renderers arrays.json -q -o x.exr
done <<'END'
np-three frame0.npy has the shape (32, 32, 3), needs (32, 32, 4): rows, columns, RGBA
np-turned frame0.npy has the shape (32, 33, 4), needs (32, 32, 4)
np-integers frame0.npy has samples of type '<i4', needs floats of 16, 32 or 64 bits
np-cut frame0.npy is damaged: 16383 bytes of samples, needs 16384
np-long frame0.npy is damaged: 16513 bytes, at most 16512 belong to such a picture
np-torn frame0.npy: damaged: a NumPy header of 118 bytes, must be
np-infinite frame0.npy has 1 values that are not finite, the first in column 5 of row 3
pf-gray frame0.pfm begins with Pf, needs PF: three channels
pf-narrow frame0.pfm has 31 x 32 pixels, needs 32 x 32
pf-scaled frame0.pfm has the scale 2.5, must be 1 or -1
pf-short frame0.pfm is damaged: 12284 bytes of samples, needs 12288
pf-nothing frame0.pfm is damaged: it has no PFM header
opaque frame0-alpha.pfm was not written
twice frame0 is there as .exr and as .npy; leave one
npy-link frame0.npy is not a regular file
END
cat >forms.py <<'END'
import json, sys
import numpy as np
w, h = (json.load(open(sys.argv[2]))['image'][k] for k in ('width', 'height'))
picture = np.arange(4 * w * h).reshape(h, w, 4) / 1024
form = sys.argv[1]
def pfm(name, kind, order, a):
    open(name, 'wb').write(f'{kind}\n{w} {h}\n{"-1" if order == "<" else "1"}\n'.encode() + a[::-1].astype(order + 'f4').tobytes())
if form[:3] == 'pfm':
    pfm('frame0.pfm', 'PF', form[3], picture[..., :3]), pfm('frame0-alpha.pfm', 'Pf', form[3], picture[..., 3])
else:
    a = picture.astype(form[:3])
    np.save('frame0.npy', np.asfortranarray(a) if form[3:] else a)
END
forms=("<f2" ">f2" "<f4" ">f4" "<f8" ">f8" "<f4F" ">f2F" "pfm<" "pfm>")
"$python" - "$python" "${forms[@]}" >forms.json <<'END'
import json, sys
rows = [{"name": f"form{i}", "command": [sys.argv[1], "forms.py", form], "tier": "samples",
         "can": ["lights", "orthographic"]} for i, form in enumerate(sys.argv[2:])]
json.dump({"schema": "isoshade.renderers/1", "renderers": rows}, sys.stdout)
END
"$python" - "$top/tests/peers" <<'END'
import sys
sys.path.insert(0, sys.argv[1])
from exr import write_exr
write_exr('form.exr', 9, 7, [i / 1024 for i in range(4 * 9 * 7)])
END
for i in "${!forms[@]}"; do
    drawn() { "$ISOSHADE" render v.nrrd --scene "$scene" --size 9x7 --with form$i --renderers forms.json -q -o drawn.exr && "$ISOSHADE" compare form.exr drawn.exr; }
    check "the_form_${forms[i]}_is_read_exactly" drawn
done
# Half floats: the row declares them, and the limits grow by their rounding alone.
sed 's/"tier": "samples",/"tier": "samples", "half": true,/; s/numpy_renderer.py/half.py/' renderers.json >half.json
sed "s/astype('f4')/astype('f2')/" numpy_renderer.py >half.py
halved() { "$ISOSHADE" validate v.nrrd --scene "$scene" --with numpy --renderers half.json --quick --levels 1 --size 12 -q -o half; }
expect half_floats_that_are_declared_agree 0 halved
check by_a_limit_that_their_rounding_explains python3 -c 'import json
rows = [r for r in json.load(open("half/report.json"))["agreement"] if r["comparison"] == "lock-step"]
assert rows and all(0 < r["max_abs"] < r["limits"]["max_abs"] <= 2e-4 + 2 ** -11 * 1.0001 for r in rows), rows'
sed "s/astype('f2')/astype('f2') * np.array([1, 1, 1, .998])/; s/np.save(\(.*\))$/np.save(\1.astype('f2'))/" half.py >faulty.py
cmp -s half.py faulty.py && not_ok a_fault_is_planted "the text has none" || mv faulty.py half.py
expect an_opacity_that_is_off_by_two_thousandths_is_seen 9 halved
sed 's/ "half": true,//' half.json >undeclared.json && mv undeclared.json half.json && sed "s/astype('f4')/astype('f2')/" numpy_renderer.py >half.py
notice half_floats_that_are_not_declared_differ halved
left() { grep -laz "^CHECK_EXTERNAL_MARK=$dir\$" /proc/[0-9]*/environ 2>/dev/null | grep -oE '[0-9]+' | while read -r pid; do tr '\0' ' ' 2>/dev/null <"/proc/$pid/cmdline"; echo; done 2>/dev/null | grep -aE '[s]leep 1000|^[y]es|[b]ad\.sh'; }
check nothing_that_they_began_is_alive bash -c "! { $(declare -f left); dir=$dir; left; }"
sleep 1000 & # planted
for _ in {1..200}; do left >/dev/null && break; sleep 0.05; done # until it has its own command line
check a_process_that_is_left_is_found left
kill $!
wait $! 2>/dev/null
check the_report_has_the_exit_code test "$(row bad programs code exit_code) $(row bad programs code output)" = "3 ['no such luck']"
check the_report_has_the_signal test "$(row bad programs crash signal)" = 11
check the_report_has_the_time_limit test "$(row bad programs flood exit_code) $(row bad programs flood timed_out)" = "None True"
check the_report_has_the_command test "$(row bad programs code command)" = "['bad.sh', 'code']"
check the_report_has_the_last_lines_alone test "$(row bad programs flood output | grep -o "'y'" | wc -l)" = 8
for pair in "hang:time limit" "stale:older than the request" "nan:not finite"; do
    refuse "render_refuses_${pair%%:*}" 8 "${pair#*:}" "$ISOSHADE" render v.nrrd --scene "$scene" --size 32 --with "${pair%%:*}" --renderers bad.json -q -o x.exr
done
refuse timeout_of_the_command_line_is_less 8 "after 0.2 s" "$ISOSHADE" render v.nrrd --scene "$scene" --size 8 --with hang --renderers bad.json --timeout 0.2 -q -o x.exr

# ---- our own programs that fail in calibration: a report and exit code 9 ----
mkdir fake
cat >fake/povray <<'END'
#!/bin/bash
case "$*" in *-version*) echo "POV-Ray 3.7.0.10"; exit 0 ;; esac
[ -z "$FAKE_CRASHES" ] || kill -SEGV $$
for word; do case $word in Width=*) w=${word#*=} ;; Height=*) h=${word#*=} ;; esac; done
for pass in 1 2 3 4; do { printf 'P6\n%d %d\n65535\n' "$w" "$h"; head -c $((w * h * 6)) /dev/zero; } >pass$pass.ppm; done
END
chmod +x fake/povray
for crashes in "" 1; do
    expect "a_renderer_that_${crashes:+crashes}${crashes:-is_black}_alone_is_refused" 9 env FAKE_CRASHES=$crashes ISOSHADE_POVRAY="$dir/fake/povray" "$ISOSHADE" validate v.nrrd --scene "$scene" --quick --levels 1 --size 8 --with povray -q -o "own$crashes"
    check "its_report_is_there$crashes" test -s "own$crashes/index.html" -a -s "own$crashes/charts/agreement.svg"
done

# ---- programs that are not there, and what a scene asks for in vain ----
cat >other.json <<'END'
{"schema": "isoshade.renderers/1", "renderers": [
  {"name": "absent", "command": ["no-such-program"], "package": "such-a-package", "tier": "limit"},
  {"name": "lacking", "command": ["/bin/true"], "version": ["/bin/sh", "-c", "echo no module numpy >&2; exit 1"], "tier": "limit"},
  {"name": "unlit", "command": ["./bad.sh", "black"], "version": ["/usr/bin/seq", "-f", "version %.0f", "10"], "tier": "8 bits",
   "can": []}]}
END
expect a_program_that_is_missing 7 "$ISOSHADE" validate v.nrrd --scene "$scene" --quick --levels 1 --size 8 --with absent,lacking,unlit --renderers other.json -q -o other
flatten other
check its_package_is_named grep -q '^calibration absent detail missing: .*no-such-program.*such-a-package' other.txt
check a_version_is_the_first_line_of_ten grep -q '"unlit": "version 1"' <(python3 -c 'import json
print(json.dumps(json.load(open("other/report.json"))))')
check what_a_version_lacks_is_named grep -q '^calibration lacking detail missing: .*no module numpy' other.txt
check checks_that_need_lights_are_not_asked test "$(row other calibration unlit detail | grep -c 'unlit does not render lights')" = 3
check slab_is_asked_within_8_bits grep -q '^calibration unlit detail 8 bits a channel: half a step' other.txt
exit $failed
