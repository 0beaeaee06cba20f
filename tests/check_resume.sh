#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# A table, input x command: work that was stored is taken up with the same inputs alone. With another input it is refused, or
# the result is that of a fresh run.
. "$(dirname "$0")/lib.sh"
export POVINI= LIBGL_DEBUG=
program=$(realpath "$ISOSHADE")
# detach FILE.nrrd NAME: NAME.nhdr and its samples in NAME.raw
cat >detach.py <<'PY'
import sys
data = open(sys.argv[1], "rb").read()
at = data.index(b"\n\n")
open(sys.argv[2] + ".nhdr", "wb").write(data[:at] + f"\ndata file: {sys.argv[2]}.raw\n\n".encode())
open(sys.argv[2] + ".raw", "wb").write(data[at + 2:])
PY
detach() { python3 detach.py "$@"; }
# rewrite FROM TO: the bytes of FROM into the file TO, whose size, inode and time in whole seconds stay
rewrite() { touch -r "$2" stamp && cat "$1" >"$2" && touch -r stamp "$2"; }
# A copy of the program with one more byte, next to the files that it loads. Its version and build id are the same.
mkdir other_program && cp -r "$(dirname "$program")"/isoshade{,-itk,-arrays,-vdb,_openvdb.so} other_program 2>/dev/null
printf x >>other_program/isoshade
other=$dir/other_program/isoshade

# ---- build: killed in the middle, as by a crash ----
tracing() { strace -f -qq -o /dev/null -e trace=/^rename true 2>/dev/null; }
# killed NAME ARGUMENT...: leaves .NAME.iso.partial, as it is before its fourth progress note; the case fails if it does not
killed() {
    local name=$1
    shift
    strace -f -qq -o /dev/null -e trace=/^rename -e inject=/^rename:signal=SIGKILL:when=4 \
        "$ISOSHADE" build "$@" -o "$name.iso" --memory 9 --save-every 0 -q >/dev/null
    if grep -qs '"planes"' ".$name.iso.partial/progress.json"; then ok "${name}_is_killed"; else not_ok "${name}_is_killed" "build $*"; fi
} 2>/dev/null
# goes_on NAME ARGUMENT...: a copy of the killed build is resumed
goes_on() {
    local name=$1
    shift
    rm -rf on.iso .on.iso.partial && cp -rp ".$name.iso.partial" .on.iso.partial
    "${isoshade:-$ISOSHADE}" build "$@" -o on.iso --memory 9 --resume --json -q >out 2>err
}
plane() { json_number out resumed_at_plane; }
is_that_of_one_go() { rm -rf one.iso && "$ISOSHADE" build "$@" -o one.iso -q >/dev/null && diff -r on.iso one.iso >/dev/null; }
# anew ROW NAME ARGUMENT...: begun anew with the result of a fresh run, or refused as that is
anew() {
    local row=$1 name=$2
    shift 2
    if ! goes_on "$name" "$@"; then notice "build_$row" is_that_of_one_go "$@"; return; fi
    check "build_$row" test "$(plane)" = 0
    check "build_${row}_is_right" is_that_of_one_go "$@"
}
if tracing; then
    for seed in 1 2; do "$ISOSHADE" make noise --size 40x48x200 --seed $seed -q -o n.nrrd && detach n.nrrd d$seed; done
    cp d1.raw v.raw && sed 's/d1.raw/v.raw/' d1.nhdr >v.nhdr
    killed v v.nhdr
    check it_goes_on goes_on v v.nhdr --threads 1 --save-every 7
    holds in_the_middle "$(plane) > 0"
    check to_the_same_result is_that_of_one_go v.nhdr
    touch v.raw
    check a_touched_file_is_the_same goes_on v v.nhdr
    holds and_gone_on_with "$(plane) > 0"
    # The same with each option changed that --help lists, but for those that change no byte or are of other modes.
    no_byte="output resume save-every memory threads json quiet timeout no-sandbox full-paths no-provenance help budget"
    other_mode="for effort frames auto tf name unit-distance opacity range series raw-size raw-type raw-spacing raw-big-endian raw-skip frame channel resample force-spacing"
    while read -r option value; do
        anew "with_another_$option" v v.nhdr "--$option" $value
        tried="${tried-} $option"
    done <<'END'
levels 3
estimator sobel
scalar-filter gauss
direction-filter mean
code cube
gauss-radius 3
gauss-sigma 2
eq1-exponent 3
keep-float
keep-magnitude
spacing 1x1x2
unit um
stored
labels
no-labels
no-data 5
END
    for option in $("$ISOSHADE" build --help=all | sed -n '/^options:/,/^$/s/^  \(-., \|    \)--\([a-z0-9-]*\).*/\2/p'); do
        [[ " $no_byte $other_mode $tried " == *" $option "* ]] || not_ok "$option" "is in no row of this table"
    done
    isoshade=$other anew of_another_program v v.nhdr
    LIBGL_DEBUG=verbose anew with_another_environment v v.nhdr
    killed w d2.nhdr; cp v.raw kept.raw; rewrite d2.raw v.raw
    anew of_a_file_that_was_rewritten v v.nhdr
    goes_on v v.nhdr -q
    rm -rf .on.iso.partial && cp -rp .v.iso.partial .on.iso.partial && "$ISOSHADE" build v.nhdr -o on.iso --memory 9 --resume >/dev/null 2>err
    check its_message_names_the_file grep -q 'v.raw changed since; the build starts from the beginning' err
    # planted fault: notes that vouch for the new file, as a key without it would
    killed k v.nhdr && cp -rp .v.iso.partial saved && cp .k.iso.partial/progress.json .v.iso.partial
    goes_on v v.nhdr
    notice a_key_without_the_file is_that_of_one_go v.nhdr
    # ---- input options, each after a build with another value ----
    raw="--raw-size 40x48x200 --raw-type uint16"
    killed t v.raw $raw
    check a_raw_file_goes_on goes_on t v.raw $raw
    holds in_its_middle "$(plane) > 0"
    truncate -s +8 v.raw
    killed r v.raw $raw
    anew with_another_raw_skip r v.raw $raw --raw-skip 4
    anew with_another_raw_type r v.raw --raw-size 40x48x200 --raw-type int16
    anew with_another_raw_size r v.raw --raw-size 48x40x200 --raw-type uint16
    anew with_another_raw_spacing r v.raw $raw --raw-spacing 1x2x1
    anew with_another_raw_big_endian r v.raw $raw --raw-big-endian
    { sed '/^$/,$d' v.nhdr | sed -e 's/dimension: 3/dimension: 4/' -e 's/^sizes:.*/sizes: 2 40 48 200/' -e '/^space\|^kinds\|^centerings\|^spacings\|^data/d'; echo "kinds: vector space space space"; echo "data file: c.raw"; echo; } >c.nhdr
    cat d1.raw d2.raw >c.raw
    killed c c.nhdr --spacing 1x1x1 --channel 0
    anew with_another_channel c c.nhdr --spacing 1x1x1 --channel 1
    sed -e 's/^sizes:.*/sizes: 40 48 200 2/' -e 's/^kinds:.*/kinds: space space space time/' c.nhdr >f.nhdr
    killed f f.nhdr --spacing 1x1x1 --frame 0
    anew with_another_frame f f.nhdr --spacing 1x1x1 --frame 1
    # ---- slices: one of them is written again in its place ----
    split -b $((40 * 48 * 2)) -d -a 3 d1.raw s
    sed 's/^data file:.*/data file: s%03d 0 199 1 2/' d1.nhdr >s.nhdr
    killed s s.nhdr
    check slices_go_on goes_on s s.nhdr
    holds in_the_middle_of_them "$(plane) > 0"
    rewrite s000 s017
    anew of_a_slice_that_was_rewritten s s.nhdr
else
    skip builds "strace is missing, or may not trace here"
fi

# ---- chart: its settings are in a folder that goes on; one is marked, as what is measured anew is not ----
"$ISOSHADE" make shells --size 12x11x10 -q -o n.nrrd && detach n.nrrd v
cp "$top"/refscenes/shells.{scene,tf}.json . && mv shells.scene.json s.scene.json
chart() { "${isoshade:-$ISOSHADE}" chart --size 12 --budget 0 --levels 1 --steps 1 --quadratures midpoint --plans none --estimators central --codes snorm -q "$@"; }
marked() { grep -qs ',0.777,' on/pareto.csv; }
# mark ARGUMENT...: a chart whose last line is marked is left in .base.partial
mark() {
    rm -rf base .base.partial && chart "$@" -o base >/dev/null 2>&1 && mkdir .base.partial && cp base/reference.exr .base.partial &&
        sed 's/"rmse":[0-9.e-]*/"rmse":0.777/' base/settings.jsonl >.base.partial/settings.jsonl
}
chart_goes_on() { rm -rf on .on.partial && cp -rp .base.partial .on.partial && chart "$@" --resume -o on >out 2>err; }
chart_anew() { # ROW WORDS ARGUMENT...: refused with these words, or nothing that is marked is in it
    local row=$1 words=$2
    shift 2
    if chart_goes_on "$@"; then notice "chart_$row" marked; else check "chart_$row" grep -qe "$words" err; fi
}
base=(v.nhdr --scene s.scene.json --with cpu)
check a_chart_is_made mark "${base[@]}"
check it_goes_on_with_what_it_has chart_goes_on "${base[@]}"
check and_measures_nothing_again marked
check more_on_its_axes_is_no_other_input chart_goes_on "${base[@]}" --steps 1,0.5
check and_keeps_what_it_has marked
chart_anew with_another_spacing '--spacing is not the same' "${base[@]}" --spacing 1x1x2
chart_anew with_another_size '--size is not the same' "${base[@]}" --size 14
chart_anew with_another_tf '--tf is not the same' "${base[@]}" --tf auto
chart_anew with_other_threads '--threads is not the same' "${base[@]}" --threads 1
LIBGL_DEBUG=verbose chart_anew with_another_environment 'LIBGL_DEBUG is not the same' "${base[@]}"
isoshade=$other chart_anew of_another_program 'the program is not the same' "${base[@]}"
cp s.scene.json kept.json && sed -i 's/"schema"/ "schema"/' s.scene.json
chart_anew of_a_scene_that_was_changed 's.scene.json changed since' "${base[@]}"
mv kept.json s.scene.json
cp shells.tf.json kept.json && sed -i 's/^{/{ /' shells.tf.json
chart_anew of_a_tf_that_was_changed 'shells.tf.json changed since' "${base[@]}"
mv kept.json shells.tf.json
cp v.raw kept.raw && head -c 2000 /dev/zero | dd of=v.raw conv=notrunc status=none
chart_anew of_a_file_that_was_rewritten 'v.raw changed since' "${base[@]}"
rewrite kept.raw v.raw
check what_is_as_it_was_goes_on chart_goes_on "${base[@]}"
check and_is_kept marked
# A program that draws: found by the PATH or named, a script or not; its version stays.
if command -v povray >/dev/null; then
    printf '#!/bin/sh\nexec %s "$@"\n' "$(command -v povray)" >pov && chmod +x pov
    export ISOSHADE_POVRAY=$dir/pov ISOSHADE_SANDBOX=off
    base=(v.nhdr --scene s.scene.json --with povray)
    check a_chart_of_another_program mark "${base[@]}"
    check goes_on_too chart_goes_on "${base[@]}"
    check and_draws_nothing_again marked
    echo "# edited" >>pov
    chart_anew of_a_renderer_that_was_edited 'nothing' "${base[@]}"
    mkdir -p "$HOME/.povray/3.7" && mark "${base[@]}" && echo "Antialias=Off" >"$HOME/.povray/3.7/povray.ini"
    chart_anew of_a_renderer_with_other_settings 'nothing' "${base[@]}"
    unset ISOSHADE_POVRAY ISOSHADE_SANDBOX
else
    skip renderers "povray is missing"
fi

# ---- validate: killed before its report stands; pictures are taken from what it left, or drawn again ----
validate() { "${isoshade:-$ISOSHADE}" validate "$@" --with cpu --quick --level-views 2 --level-size 16 --limit-size 10 --levels 1 -q; }
taken() { sed -n 's/.*"pictures_taken": *\([0-9]*\).*/\1/p' "$1/report.json" 2>/dev/null; }
mkdir bin && printf '#!/bin/sh\nkill -KILL $PPID\n' >bin/gnuplot && chmod +x bin/gnuplot # which the report needs
base=(v.nhdr --scene s.scene.json --size 20x16)
PATH=$dir/bin:$PATH validate "${base[@]}" -o killed >/dev/null 2>&1
mv killed.work saved_pictures
check pictures_are_left test "$(ls saved_pictures/*.picture | wc -l)" -ge 10 -a ! -e killed
pictures_go_on() { # ARGUMENT...: $got were taken
    rm -rf on on.work && cp -rp saved_pictures on.work
    validate "$@" --resume -o on >out 2>err
    code=$?
    got=$(taken on)
}
pictures_go_on "${base[@]}" --threads 1 --junit j.xml
whole=$got
rm -rf saved_before && validate "${base[@]}" --resume -o fresh >/dev/null
own=$(taken fresh) # the same picture is asked for more than once
holds a_validation_goes_on "$whole > $own + 5"
pictures_anew() { # ROW ARGUMENT...: refused, or none of the old pictures is taken
    local row=$1
    shift
    pictures_go_on "$@"
    if [ -z "$got" ]; then ok "validate_$row"; else holds "validate_$row" "$got <= $own + 1"; fi
}
pictures_anew with_another_spacing "${base[@]}" --spacing 1x1x2
pictures_anew with_another_size v.nhdr --scene s.scene.json --size 16x20
pictures_anew with_another_tf "${base[@]}" --tf auto
pictures_anew with_another_code "${base[@]}" --code cube
LIBGL_DEBUG=verbose pictures_anew with_another_environment "${base[@]}"
isoshade=$other pictures_anew of_another_program "${base[@]}"
sed -i 's/"schema"/ "schema"/' s.scene.json
pictures_anew of_a_scene_that_was_changed "${base[@]}"
sed -i 's/ "schema"/"schema"/' s.scene.json
head -c 2000 /dev/zero | dd of=v.raw conv=notrunc status=none
pictures_anew of_a_file_that_was_rewritten "${base[@]}"
rewrite kept.raw v.raw
pictures_go_on "${base[@]}"
holds what_is_as_it_was_is_taken "$got == $whole"
exit $failed
