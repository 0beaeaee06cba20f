#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Time steps, channels and numbered files: those of other programs' files, each by itself (frames_in.py).
. "$(dirname "$0")/lib.sh"
python_with numpy,vtk
"$python" "$top/tests/frames_in.py" "$ISOSHADE" || failed=1

# All frames: one range, so that a fitted transfer function gives a value one color in all of them. The second frame has
# a larger value than the first.
frame() { printf 'NRRD0004\ntype: uchar\ndimension: 3\nsizes: 4 4 4\nspacings: 1 1 1\nencoding: raw\n\n'; for i in {0..62}; do printf "\\x$(printf %x $((i + 1)))"; done; printf "$1"; }
frame '\x40' >f_1.nrrd
frame '\xc8' >f_2.nrrd
"$ISOSHADE" build 'f_%d.nrrd' --frames all --levels 1 -q -o all.iso >out || not_ok all_frames_are_built "$(cat out)"
check a_pyramid_a_frame test -s all_0000.iso/pyramid.json -a -s all_0001.iso/pyramid.json
check the_range_is_that_of_all grep -q '2 frames, values 1 to 200' out
"$ISOSHADE" build f_1.nrrd --levels 1 -q -o f_1.iso >out
"$ISOSHADE" build f_2.nrrd --levels 1 -q -o f_2.iso >out
for p in all_0000 all_0001 f_1 f_2; do
    "$ISOSHADE" render $p.iso --scene "$top/refscenes/marschner-lobb.scene.json" --with reference --size 12 -q -o $p.exr >out 2>err || not_ok render "$(cat err)"
done
check the_frame_of_the_widest_range_is_as_by_itself "$ISOSHADE" compare all_0001.exr f_2.exr
notice and_the_other_is_not "$ISOSHADE" compare all_0000.exr f_1.exr
check verify_knows_it "$ISOSHADE" info all_0000.iso --verify
refuse one_frame_only 2 'has one frame' "$ISOSHADE" build f_1.nrrd --frames all -o x.iso
refuse frames_is_all 2 '--frames is "3", must be all' "$ISOSHADE" build f_1.nrrd --frames 3 -o x.iso
refuse all_or_one 2 '--frames all and --frame' "$ISOSHADE" build 'f_%d.nrrd' --frames all --frame 1 -o x.iso
refuse no_frame_is_named 2 'f_%d.nrrd: has 2 frames; --frame K chooses one, from 0 to 1' "$ISOSHADE" render 'f_%d.nrrd' -o x.png

# Labels are looked for in all frames: an intensity among them decides nothing in silence.
planes() { for v in "$@"; do head -c 64 /dev/zero | tr '\0' "\\$v"; done; }
volume() { printf 'NRRD0004\ntype: uchar\ndimension: 3\nsizes: 8 8 8\nspacings: 1 1 1\nencoding: raw\n\n'; cat; }
planes 001 001 001 007 007 003 003 003 | volume >s_0.nrrd
planes 001 001 007 007 007 003 003 003 | volume >s_1.nrrd
check labels_in_all_frames "$ISOSHADE" build 's_%d.nrrd' --frames all --levels 2 -o s.iso
check by_majority grep -q majority s_0001.iso/pyramid.json
planes 001 002 003 004 005 006 007 010 | volume >s_2.nrrd
refuse frames_of_two_kinds 2 'frame 1 looks like a label map, frame 2 does not; use --labels or --no-labels' \
    "$ISOSHADE" build 's_%d.nrrd' --frames all --levels 2 -o t.iso
check or_it_is_said "$ISOSHADE" build 's_%d.nrrd' --frames all --levels 2 --no-labels -o t.iso
exit $failed
