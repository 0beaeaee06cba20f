#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Programs that say all is well and leave no picture, an old one or one of no numbers: exit code 8, and no image.
. "$(dirname "$0")/lib.sh"
scene=$top/refscenes/shells.scene.json
povray=$(command -v povray)
"$ISOSHADE" make shells --size 9 -q -o s.nrrd || exit 1

# fake NAME: a POV-Ray in front of the real one; its body is read from stdin
fake() {
    { echo '#!/usr/bin/env bash'; echo "case \"\$*\" in *-version*) exec $povray \"\$@\" ;; esac"; cat; } >"$1"
    chmod +x "$1"
}
with_povray() { env ISOSHADE_POVRAY="$dir/$1" "$ISOSHADE" render s.nrrd --scene "$scene" --with povray --size 8 --intervals 10 -q -o o.exr; }

fake honest <<<"exec $povray \"\$@\""
check a_picture_of_each_pass with_povray honest
printf '%s\n' '#!/bin/sh' 'case "$*" in *-version*) echo "POV-Ray 3.8.0-alpha.10013324.unofficial" ;; *)' "exec $povray \"\$@\" ;; esac" >later && chmod +x later
expect a_later_povray 0 with_povray later
check is_named_as_it_says grep -q 'POV-Ray 3.8.0-alpha.10013324, ' out
rm -f o.exr
fake no_second_pass <<<"$povray \"\$@\" && rm pass2.ppm"
refuse a_pass_that_writes_nothing 8 "wrote no picture" with_povray no_second_pass
fake no_pass <<<"exit 0"
refuse a_program_that_writes_nothing 8 "wrote no picture" with_povray no_pass
fake half_a_picture <<<"printf 'P6\n8 8\n65535\nabc' >pass1.ppm"
refuse half_a_picture 8 "pass1.ppm" with_povray half_a_picture
fake another_size <<<"{ printf 'P6\n4 8\n65535\n'; head -c 192 /dev/zero; } >pass1.ppm"
refuse a_picture_of_another_size 8 "instead of 8 x 8" with_povray another_size

# A machine with much other work: POV-Ray's threads do not start in time, once.
fake late <<<"[ -e tried ] || { touch tried; echo 'Timed out waiting for worker thread startup'; exit 1; }; exec $povray \"\$@\""
check one_that_starts_late_is_started_again with_povray late
rm -f o.exr
fake never <<<"echo 'Timed out waiting for worker thread startup'; exit 1"
refuse one_that_never_starts 8 "Timed out" with_povray never

# Programs that never end, where isoshade has a limit of its own for them: --timeout holds where it is less. What ends
# them otherwise is $patience, which no result hangs on.
hangs() { printf '%s\n' '#!/usr/bin/env bash' "trap '' TERM INT HUP" 'while :; do sleep 1; done' >"$1" && chmod +x "$1"; }
for name in povray blender gnuplot; do hangs hanging-$name; done
short() { patience=120 patiently env "$1=$dir/$2" "$ISOSHADE" "${@:3}" --timeout 1 -q; }
a_picture() { short "$1" "$2" render s.nrrd --scene "$scene" --with "$3" --size 8 -o o.exr; }
limit='stopped after 1 s, the time limit'
refuse a_version_that_is_never_told_has_the_limit_of_all 8 "$limit" a_picture ISOSHADE_POVRAY hanging-povray povray
refuse so_has_that_of_blender 8 "$limit" a_picture ISOSHADE_BLENDER hanging-blender cycles
refuse and_a_plot_that_is_never_drawn 8 "$limit" short ISOSHADE_GNUPLOT hanging-gnuplot info s.nrrd --histogram h.png

# Plots that gnuplot does not draw, by each command that has some.
plotter() { printf '%s\n' '#!/bin/bash' 'for last; do :; done' "$2" >"$1" && chmod +x "$1"; }
plotter plots_nothing 'exit 0'
plotter plots_words 'to=$(sed -n "s/^set output .\(.*\).$/\1/p" "$last"); echo no picture >"$to"'
plotter plots_half 'to=$(sed -n "s/^set output .\(.*\).$/\1/p" "$last"); printf "\x89PNG and no more" >"$to"'
plots() { # program, code, words
    local by=(env "ISOSHADE_GNUPLOT=$dir/$1" "$ISOSHADE")
    refuse "$1_of_a_transfer_function" "$2" "$3" "${by[@]}" tf show "${scene%.scene.json}.tf.json" -o t.png -q
    refuse "$1_of_a_histogram" "$2" "$3" "${by[@]}" info s.nrrd --histogram h.png -q
    refuse "$1_of_scenes" "$2" "$3" "${by[@]}" scenes s.nrrd --size 32 -o scenes.png -q
}
plots plots_nothing 8 'gnuplot wrote no picture'
plots plots_words 8 'gnuplot wrote a file that is not png'
plots plots_half 3 'gnuplot wrote an incomplete picture'

# nan_exr: the smallest OpenEXR file of 8 x 8 pixels of four floats without compression, all NaN
nan_exr() {
    text() { printf '%s\0' "$@"; }
    le32() { printf "\\x$(printf '%02x' $(($1 & 255)))\\x$(printf '%02x' $(($1 >> 8 & 255)))\0\0"; }
    attribute() { text "$1" "$2" && le32 "$3"; }
    printf '\x76\x2f\x31\x01\x02\0\0\0'
    attribute channels chlist 73
    for c in A B G R; do text $c && le32 2 && le32 0 && le32 1 && le32 1; done
    printf '\0'
    attribute compression compression 1 && printf '\0'
    for window in dataWindow displayWindow; do attribute $window box2i 16 && le32 0 && le32 0 && le32 7 && le32 7; done
    attribute lineOrder lineOrder 1 && printf '\0'
    attribute pixelAspectRatio float 4 && printf '\0\0\x80\x3f'
    attribute screenWindowCenter v2f 8 && le32 0 && le32 0
    attribute screenWindowWidth float 4 && printf '\0\0\x80\x3f\0'
    for y in 0 1 2 3 4 5 6 7; do le32 $((header + 64 + 136 * y)) && le32 0; done
    for y in 0 1 2 3 4 5 6 7; do le32 $y && le32 128 && for i in $(seq 32); do printf '\0\0\xc0\x7f'; done; done
}
header=0
header=$(($(nan_exr | wc -c) - 64 - 8 * 136))
nan_exr >nan.exr
expect the_picture_of_nans_is_an_image 1 "$ISOSHADE" compare nan.exr nan.exr
# Blenders that start none: a picture is what they leave in the folder where they run.
blender() {
    printf '%s\n' '#!/usr/bin/env bash' '[ "$1" = --version ] && { echo "Blender 4.0.0"; exit; }' "$2" >"$1" && chmod +x "$1"
    refuse "$3" 8 "$4" env ISOSHADE_BLENDER="$dir/$1" "$ISOSHADE" render s.nrrd --scene "$scene" --with cycles --size 8 -q -o o.exr
}
blender silent "exit 0" a_blender_that_writes_nothing "wrote no picture"
blender broken "echo no picture >picture-0.exr" a_broken_picture "picture-0.exr"
blender nan "cp '$dir/nan.exr' picture-0.exr" a_picture_of_nans "not finite"
# It looks for Python beside itself, whatever PATH names first; and why its script failed stands before that it did.
blender looking 'echo "Error: first is ${PATH%%:*}"; exit 9' a_blender_looks_beside_itself_first "first is $dir"
# So it does without a sandbox, and in neither case with the modules of another Python.
export PYTHONPATH=$dir/other PYTHONHOME=$dir/another
blender python 'echo "Error: python is $PYTHONHOME$PYTHONPATH."; exit 9' a_blender_has_no_settings_of_another_python "python is ."
export ISOSHADE_SANDBOX=off
blender unboxed 'echo "Error: is ${PATH%%:*}$PYTHONHOME$PYTHONPATH"; exit 9' nor_without_a_sandbox "is $dir"
unset PYTHONPATH PYTHONHOME ISOSHADE_SANDBOX
# Its input is read in its own folder, although TMPDIR is relative to the folder of isoshade.
mkdir here
export TMPDIR=here
blender told 'test -s "${!#}" && echo "Error: it is there"; exit 9' a_tmpdir_that_is_no_whole_path "it is there"
export TMPDIR=nowhere
refuse a_tmpdir_that_is_not_there 3 'nowhere: no temporary folder can be made there' "$ISOSHADE" info s.nrrd --histogram h.png -q
unset TMPDIR
# gnuplot opens the terminal that GNUTERM names before it reads its script.
printf '%s\n' '#!/bin/bash' '[ -z "${GNUTERM+set}" ] && exec gnuplot "$@"' 'echo "error: a terminal"; exit 1' >without_terminal && chmod +x without_terminal
drawn() { env GNUTERM=qt ISOSHADE_GNUPLOT="$dir/without_terminal" "$ISOSHADE" "$@" -q; }
check a_terminal_of_the_user_is_none_of_a_histogram drawn info s.nrrd --histogram h.png
check nor_of_a_figure drawn figure s.nrrd --scene "$scene" --levels 1 --width 40 --dpi 50 -o figure
blender failing "echo \"ModuleNotFoundError: No module named 'numpy'\"; echo 'Error: script failed, exiting'; exit 9" why_a_script_failed "No module named 'numpy'"
exit $failed
