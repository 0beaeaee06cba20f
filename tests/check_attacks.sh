#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Untrusted files, outputs that are not files, programs that hang: a clear error, and nothing lost.
. "$(dirname "$0")/lib.sh"
isoshade() { "$ISOSHADE" "$@"; }
isoshade-lab() { "$LAB" "$@"; }
shells=$top/refscenes/shells.scene.json
isoshade make shells --size 12x10x11 -o s.nrrd -q
isoshade build s.nrrd -o s.iso --levels 2 -q >/dev/null
ends() { # exit code, words of the message, command ...
    local wanted=$1 words=$2
    shift 2
    "$@" >said.txt 2>&1 </dev/null
    [ $? = "$wanted" ] && grep -q -- "$words" said.txt
}

# ---- outputs ----
mkfifo pipe
check an_output_that_is_a_pipe_is_refused ends 3 'is a device, a pipe or a socket' isoshade make sphere --size 4 -o pipe
check so_is_a_device ends 3 'is a device' isoshade make sphere --size 4 -o /dev/null
check and_both_are_still_there test -p pipe -a -c /dev/null
touch target && ln -s target link && ln -s nowhere loose
check a_link_is_followed isoshade make sphere --size 4 -o link -q
check and_stays test -L link -a -s target
check a_link_to_nothing_is_refused ends 3 'is a link whose target cannot be reached' isoshade make sphere --size 4 -o loose
long=$(printf 'x%.0s' $(seq 250)).nrrd
check the_longest_name_fits isoshade make sphere --size 4 -o "$long" -q

# A folder is replaced where all of it is ours, and as we left it.
check what_is_counted_later_is_ours isoshade tf adapt s.iso --tf "$top/refscenes/shells.tf.json" --level 1 -o adapted.tf.json -q
check and_is_in_the_folder ls s.iso/level_1_joint*.nrrd
check a_folder_of_ours_is_replaced isoshade build s.nrrd -o s.iso --levels 2 -q
echo thesis >s.iso/paper.tex
check a_file_of_a_person_in_it_is_kept ends 3 'paper.tex in it is not isoshade' isoshade build s.nrrd -o s.iso -q
check and_is_still_there grep -q thesis s.iso/paper.tex
rm s.iso/paper.tex
isoshade atlas --case code-poles -o atlas -q >/dev/null
check so_is_one_that_a_person_changed isoshade atlas --case code-poles -o atlas -q
echo '{}' >atlas/atlas.json
check and_changes_are_not_lost ends 3 'atlas.json in it was changed since' isoshade atlas --case code-poles -o atlas -q
# Files that are too large for a checksum are known by their time, also when a histogram was counted into the folder since.
isoshade make noise --size 90 -o middle.nrrd -q && isoshade build middle.nrrd -o middle.iso --levels 2 -q >/dev/null
check a_large_file_has_no_checksum grep -q '^f [0-9]* - level_0.nrrd' middle.iso/.isoshade-files
check a_folder_with_large_files_is_replaced isoshade build middle.nrrd -o middle.iso --levels 2 -q
count() { isoshade tf adapt middle.iso --tf "$top/refscenes/shells.tf.json" --level 1 -o adapted.tf.json -q; }
check a_histogram_of_it count
check is_replaced_with_it isoshade build middle.nrrd -o middle.iso --levels 2 -q
printf 'abc' | dd of=middle.iso/level_0_dir.nrrd bs=1 seek=1000000 conv=notrunc status=none
check a_histogram_that_comes_after_an_edit count
check is_listed grep -q joint middle.iso/.isoshade-files
refuse and_does_not_hide_it 3 'level_0_dir.nrrd in it was changed since' isoshade build middle.nrrd -o middle.iso --levels 2 -q
rm -r middle.iso
rm s.iso/.isoshade-files
check a_folder_without_a_list_is_kept ends 3 'has no list' isoshade build s.nrrd -o s.iso -q
rm -r s.iso
isoshade build s.nrrd -o s.iso --levels 2 -q >/dev/null

# Work that can be resumed has a name that others know: nothing that they put there is followed, emptied or taken over.
mkdir victim && echo thesis >victim/paper.tex && ln -s victim .known.iso.partial
for options in -q --resume; do
    refuse "a_link_at_the_name_of_unfinished_work_is_no_folder_$options" 3 '.known.iso.partial cannot be opened as a folder' \
        isoshade build s.nrrd -o known.iso --levels 1 -q $options
done
check and_what_it_names_stays grep -q thesis victim/paper.tex
rm .known.iso.partial && mv victim .known.iso.partial
for options in -q --resume; do
    refuse "what_a_person_has_there_is_not_taken_over_$options" 3 'paper.tex in ./.known.iso.partial is not isoshade' \
        isoshade build s.nrrd -o known.iso --levels 1 -q $options
done
check nor_removed grep -q thesis .known.iso.partial/paper.tex
rm .known.iso.partial/paper.tex && ln -s ../s.nrrd .known.iso.partial/level_0.nrrd && cp s.nrrd before.nrrd
refuse a_link_in_it_is_no_level 3 'level_0.nrrd in ./.known.iso.partial' isoshade build s.nrrd -o known.iso -q --resume
check and_what_it_names_is_not_written_to cmp s.nrrd before.nrrd
rm .known.iso.partial/level_0.nrrd
if [ "$(id -u)" = 0 ]; then
    chown 12345 .known.iso.partial
    refuse the_folder_of_another_user_is_not_worked_in 3 "is another user's" isoshade build s.nrrd -o known.iso -q
    chown 0 .known.iso.partial
fi
check an_empty_folder_is_taken isoshade build s.nrrd -o known.iso -q
charted() { isoshade chart s.nrrd --scene "$shells" --size 8 --levels 1 --with cpu --codes fit --filters moments --estimators central --steps 1 --budget 0 --want 1 -o charted -q; }
mkdir .charted.partial && echo thesis >.charted.partial/paper.tex
refuse so_it_is_of_a_chart 3 'paper.tex in ./.charted.partial is not isoshade' charted
rm -r .charted.partial
check a_chart charted
check is_replaced_as_all_of_it_is_its_own charted

# What is measured in a folder of a person is in one of its own there.
mkdir measured && for name in iso copy; do mkdir measured/isoshade-bench.$name && echo thesis >measured/isoshade-bench.$name/paper.tex; done
echo thesis >measured/isoshade-bench.nrrd
cp -r measured measured.before
check a_measurement_of_files isoshade bench build --size 16 --levels 2 --runs 1 --files measured -q
check leaves_what_a_person_has_there diff -r measured measured.before
refuse where_nothing_can_be_made_it_says_so 3 'nowhere: cannot create a folder in it' isoshade bench build --size 16 --levels 2 --runs 1 --files nowhere -q

# ---- closed streams, limits and ends ----
isoshade make sphere --size 20 --gzip -o closed.nrrd <&- >&- 2>&-
check closed_streams_do_no_harm isoshade info closed.nrrd
isoshade build s.nrrd -o closed.iso -q <&- >&- 2>&-
check nor_in_a_pyramid isoshade info closed.iso --verify
isoshade export s.iso --to vdb -o closed.vdb -q <&- >&- 2>&-
check nor_in_a_file_of_grids isoshade info closed.vdb
check help_that_cannot_be_written_is_an_error ends 3 'cannot be written' bash -c '"$ISOSHADE" render --help >/dev/full'
check completions_that_cannot_be_written_are_an_error ends 3 'cannot be written' bash -c '"$ISOSHADE" completion bash >/dev/full'
# A page's title is content and, in the viewer, an attribute.
handler='x" autofocus onfocus="alert(1)" y'
cp s.nrrd "$handler.nrrd"
isoshade view "$handler.nrrd" --scene "$top/refscenes/shells.scene.json" -o handler.html -q
check a_name_of_a_volume_ends_no_attribute_of_a_page grep -q 'aria-label="x&quot; autofocus onfocus=&quot;alert(1)&quot; y.nrrd' handler.html
too_large() { (ulimit -f 4; exec "$ISOSHADE" make noise --size 40 -o large.nrrd -q); }
check a_limit_of_sizes_is_an_error_of_writing ends 3 'large.nrrd' too_large
temporaries() { find . -maxdepth 1 -name '.isoshade-*' | grep -c .; }
limited() { (ulimit -f 2; exec "$ISOSHADE" "$@" -q); }
check so_it_is_where_openvdb_writes ends 3 'writing failed' limited export s.iso --to vdb -o large.vdb
check and_where_openexr_does ends 3 'too large' limited render s.iso --scene "$shells" --with reference --step 1 --size 40 -o large.exr
check nothing_is_left_of_it test "$(temporaries)" = 0 -a "$(find . -name 'large.*' | grep -c .)" = 0
# A killed run leaves its temporary; those of live processes stay.
"$ISOSHADE" make noise --size 300 -o killed.nrrd -q &
for _ in $(seq 3000); do [ "$(temporaries)" -gt 0 ] && break; sleep 0.01; done
isoshade make sphere --size 4 -o other.nrrd -q
check the_work_of_one_that_lives_stays test "$(temporaries)" = 1 -o -e killed.nrrd
kill -9 $! && wait $! 2>/dev/null
rm -f killed.nrrd
isoshade make sphere --size 4 -o other.nrrd -q
check what_a_killed_run_left_is_removed test "$(temporaries)" = 0
# One that is interrupted leaves nothing, also outside of runs of other programs; nothing that it did not make goes with it.
interrupted() { # signal, exit code
    mkdir interrupted && touch interrupted/.isoshade-notes
    (cd interrupted && exec env --default-signal=INT "$ISOSHADE" make noise --size 300 -o volume.nrrd -q) &
    for _ in $(seq 3000); do ls interrupted/.isoshade-*-volume.nrrd >/dev/null 2>&1 && break; sleep 0.01; done
    kill -"$1" $! && wait $! 2>/dev/null
    local code=$? left
    left=$(ls -A interrupted)
    rm -r interrupted
    [ $code = "$2" ] && [ "$left" = .isoshade-notes ]
}
check ctrl_c_leaves_nothing interrupted INT 130
check nor_does_an_order_to_end interrupted TERM 143
check nor_does_a_terminal_that_closes interrupted HUP 129
# A build can go on: what it has done stays under the name that --resume looks for.
isoshade make noise --size 100 -o large.nrrd -q
"$ISOSHADE" build large.nrrd -o large.iso -q >/dev/null &
for _ in $(seq 3000); do ls .large.iso.partial/* >/dev/null 2>&1 && break; sleep 0.01; done
kill -TERM $! && wait $! 2>/dev/null
check what_can_be_resumed_stays test -d .large.iso.partial -o -d large.iso
check and_nothing_else_is_left test "$(find . -name '.isoshade-*' -not -name .isoshade-files | grep -c .)" = 0
check and_is_resumed isoshade build large.nrrd -o large.iso --resume -q

# ---- untrusted words and files ----
check a_name_with_a_line_feed_is_refused ends 2 'control character' isoshade info $'a\nb.nrrd'
check so_is_one_with_a_control_character_of_two_bytes ends 2 'control character' isoshade info $'a\xc2\x9b31mb.nrrd'
check a_letter_of_two_bytes_is_none ends 3 'a.*b.nrrd' isoshade info $'a\xc2\xb5\xc3\x9bb.nrrd'
odd=$'\xff.nrrd'
for words in "info $odd --json" "compare $odd s.nrrd --json" "build $odd -o odd.iso" "make sphere --size 4 -o $odd" \
    "validate s.nrrd --scene $shells --with gl -o $odd" "chart $odd -o c" "view $odd -o v.html" "tf suggest $odd -o t.tf.json"; do
    check "a_name_that_is_not_utf8_is_refused_by_${words%% *}" ends 2 'not UTF-8' isoshade $words
done
# What gnuplot is given is quoted: a name is no command.
quoted="a'; system('touch PWNED'); print 'x"
mkdir "$quoted"
check a_picture_of_any_name isoshade tf show "${shells%.scene.json}.tf.json" -o "$quoted.png" -q
check so_by_any_command isoshade figure s.iso --kind tf --tf "${shells%.scene.json}.tf.json" -o "$quoted.svg" -q
check so_one_of_two_quotes isoshade tf show "${shells%.scene.json}.tf.json" -o "a''z.png" --no-sandbox -q
cp "${shells%.scene.json}.tf.json" "a''z.tf.json"
check and_a_title_of_two isoshade tf show "a''z.tf.json" -o titled.png -q
check which_is_written_itself test -s "a''z.png" -a ! -e "a'z.png"
check and_nothing_else test -z "$(find . -name '.isoshade-*z.png')"
check in_any_folder_of_temporaries env TMPDIR="$PWD/$quoted" "$ISOSHADE" tf show "${shells%.scene.json}.tf.json" -o plain.png -q
check has_that_name test -s "$quoted.png" -a -s "$quoted.svg" -a ! -e PWNED -a ! -e "$quoted/PWNED"
python_with numpy
"$python" - "$top/tests" <<'PY'
import json, shutil, sys
sys.path.insert(0, sys.argv[1])
from read_iso import write_description
for name in ("pov", "range", "forged", "boxed", "lower", "named"):
    shutil.copytree("s.iso", f"{name}.iso")
    about = json.load(open(f"{name}.iso/pyramid.json"))
    if name == "pov":
        about["source"] = "a\n#fopen F \"PWNED\" write\n#write (F,1)\n#fclose F\n#local"
        write_description("pov.iso/pyramid.json", about)
    elif name == "forged":
        about["levels"][0].update(min=2, max=-2)
        write_description("forged.iso/pyramid.json", about)
    elif name == "named":
        about["segments"] = [{"label": 1, "name": "a\n#fopen F \"PWNED\" write\n//"}]
        write_description("named.iso/pyramid.json", about)
    elif name == "lower":
        about["levels"][0]["min"] = -1
        write_description("lower.iso/pyramid.json", about)
    elif name == "boxed":
        about["levels"][0]["geometry"]["box_index"] = [1, 1, 1]
        write_description("boxed.iso/pyramid.json", about)
    else:
        about["levels"][0]["min"] = 4096
        json.dump(about, open("range.iso/pyramid.json", "w"), indent=2)
# What OME-Zarr calls its channels.
import os
os.makedirs("named.zarr/0")
json.dump({"omero": {"channels": [{"label": "\x1b[2J\n"}, {"label": "GFP"}]}, "multiscales": [{
    "axes": [{"name": "c", "type": "channel"}] + [{"name": n, "type": "space", "unit": "millimeter"} for n in "zyx"],
    "datasets": [{"path": "0", "coordinateTransformations": [{"type": "scale", "scale": [1, 1, 1, 1]}]}]}]},
    open("named.zarr/.zattrs", "w"))
json.dump({"zarr_format": 2, "shape": [2] * 4, "chunks": [2] * 4, "dtype": "|u1", "order": "C", "fill_value": 0,
           "compressor": None, "filters": None}, open("named.zarr/0/.zarray", "w"))
open("named.zarr/.zgroup", "w").write('{"zarr_format": 2}')
open("named.zarr/0/0.0.0.0", "wb").write(bytes(range(16)))
import bz2
open("b.nrrd", "wb").write(b"NRRD0004\ntype: uint8\ndimension: 3\nsizes: 1024 1024 1024\nspacings: 1 1 1\nencoding: bzip2\n\n" + bz2.compress(b"\0" * 100))
PY
check statements_in_a_source_are_refused ends 4 'control character' isoshade export pov.iso --to povray -o pov
check so_they_are_in_a_label_s_name ends 4 '"name": holds a control character' \
    isoshade export named.iso --to povray -o named
isoshade info named.zarr --channel 0 >said.txt
check a_channel_s_name_is_shown grep -q 'channels   2, this is 0 (from 0):  \[2J ' said.txt
notice but_not_its_control_characters grep -q $'\x1b' said.txt
check a_changed_description_is_refused ends 4 'was changed since it was written' isoshade info range.iso
check so_it_is_by_what_reads_the_outline_alone ends 4 'was changed since it was written' isoshade tf adapt range.iso \
    --tf "${shells%.scene.json}.tf.json" --level 1 -o adapted.tf.json
check so_it_is_where_pov_ray_draws ends 4 'control character' isoshade render pov.iso --scene "$shells" --with povray --size 8 -o a.exr
check and_by_the_main_job ends 4 'control character' isoshade validate pov.iso --scene "$shells" --with povray --size 8 -o report
check a_forged_range_is_refused ends 4 'more than "max"' isoshade info forged.iso
check so_is_a_forged_box ends 4 'must be in the last' isoshade info boxed.iso
notice a_range_that_is_only_wrong_is_found_by_a_look_at_all isoshade info lower.iso --verify
cp -r s.iso waiting.iso && rm waiting.iso/level_0.nrrd && mkfifo waiting.iso/level_0.nrrd
check a_pipe_is_no_level ends 3 'not a regular file' timeout 60 "$ISOSHADE" info waiting.iso --verify
check memory_is_not_taken_for_what_cannot_be_there ends 4 'bytes of bzip2 cannot hold' isoshade info b.nrrd
printf 'NRRD0004\ntype: uint8\ndimension: 3\nsizes: 4 4 999999999\nspacings: 1 1 1\nencoding: raw\ndata file: %%d.raw 0 999999998 1\n' >many.nhdr
check a_thousand_million_names_are_not_made ends 5 'names 999999999 data files' bash -c 'ulimit -t 1; exec "$ISOSHADE" info many.nhdr'
{
    echo '<VTKFile type="Collection"><Collection>'
    printf '<DataSet file="%d.vti"/>\n' {1..60000}
    echo '</Collection></VTKFile>'
} >many.pvd
check a_list_of_many_files_is_read_once ends 2 'has 60000 frames' bash -c 'ulimit -t 1; exec "$ISOSHADE" build many.pvd -o many.iso'
mkdir only_a_pipe && mkfifo only_a_pipe/slice.png
check a_folder_of_a_pipe_has_no_slice ends 4 'holds no regular file' isoshade info only_a_pipe
printf 'NRRD0004\ntype: uint8\ndimension: 3\nsizes: 4 4 4\nspacings: 1 1 1\nencoding: raw\ndata file: fifo.scene.json\n' >fifo.nhdr
printf 'NRRD0004\ntype: uint8\ndimension: 3\nsizes: 4 4 2\nspacings: 1 1 1\nencoding: raw\ndata file: LIST\nfifo.scene.json\nnone\n' >list.nhdr
printf 'NRRD0004\ntype: uint8\ndimension: 3\nsizes: 4 4 2\nspacings: 1 1 1\nencoding: raw\ndata file: fifo%%d.raw 1 2 1\n' >numbers.nhdr
printf 'ObjectType = Image\nNDims = 3\nDimSize = 4 4 4\nElementType = MET_UCHAR\nElementSpacing = 1 1 1\nElementDataFile = fifo.scene.json\n' >fifo.mhd
mkfifo fifo.scene.json fifo2.raw
for header in fifo.nhdr list.nhdr numbers.nhdr fifo.mhd; do
    check "a_pipe_is_not_waited_for_by_$header" ends 3 'not a regular file' timeout 60 "$ISOSHADE" info $header
done
printf 'index,x,y,z\n0,0,0,0\n1,1,0,0\0\n2,0,1,0\n' >nul.csv
check a_palette_with_a_byte_of_0_is_refused ends 4 'a byte of 0' isoshade render s.nrrd --scene "$shells" --with reference \
    --shading-from palette --palette nul.csv --size 4 -o a.exr
"$python" - <<'PY'
import struct
head = bytearray(352)
struct.pack_into("<i", head, 0, 348)
struct.pack_into("<8h", head, 40, 3, 10, 10, 10, 1, 1, 1, 1)
struct.pack_into("<hh", head, 70, 2, 8)
struct.pack_into("<8f", head, 76, 1, 1, 1, 1, 0, 0, 0, 0)
struct.pack_into("<f", head, 108, 1e9)
head[344:348] = b"n+1\0"
open("far.nii", "wb").write(head + bytes(1000))
PY
check samples_behind_the_end_are_told_so ends 4 'start 999998648 bytes after its end' isoshade info far.nii
check a_step_of_nothing_is_refused ends 2 'step is 0' isoshade render s.nrrd --scene "$shells" --with reference --step 0 --size 4 -o a.exr
check a_pipe_is_no_scene ends 3 'not a regular file' isoshade render s.nrrd --scene fifo.scene.json --with reference --size 4 -o a.exr

# ---- an output that is the input ----
cp s.nrrd own.nrrd && ln own.nrrd linked.nrrd && cp "${shells%.scene.json}.tf.json" own.tf.json
check a_volume_is_no_output ends 2 'would overwrite the input' isoshade palette own.nrrd --entries 4 -o ./own.nrrd -q
check of_several_outputs_none_is ends 2 'would overwrite the input' isoshade palette own.nrrd --entries 4 -o a.csv -o own.nrrd -q
check by_another_name_it_is_not_either ends 2 'would overwrite the input' isoshade render linked.nrrd --scene "$shells" --with reference --size 4 -o a.exr --png own.nrrd -q
check a_converted_file_is_not_itself ends 2 'would overwrite the input' isoshade tf convert own.tf.json ./own.tf.json
check the_input_is_whole cmp own.nrrd s.nrrd

# ---- nor one that gets a name of its own, or is read by another name: by a header, a scene, a number, a folder ----
mkdir inputs && cd inputs
stays() { # name, file, command ...: the file is an input that the command would replace
    local name=$1 file=$2 program=isoshade
    shift 2
    [ "$1" != isoshade-lab ] || { program=$1; shift; }
    cp -r "$file" ../copy
    refuse "$name" 2 "would overwrite the input" $program "$@" -q
    check "${name}_and_stays" diff -r "$file" ../copy
    rm -rf ../copy
}
# A chunk of a Zarr store; a file that is not there could be taken for one.
cp -r ../named.zarr .
stays chunk_of_a_store named.zarr tf suggest named.zarr --channel 0 -o named.zarr/0/0.0.0.0
stays new_file_in_a_store named.zarr build named.zarr --channel 0 -o named.zarr/new.iso
cp ../s.nrrd . && cp "$shells" rep.scene.json && cp "$shells" one.json
for tf in sheet.json t_level_1.tf.json shells.tf.json; do cp "${shells%.scene.json}.tf.json" $tf; done
isoshade export s.nrrd --to vdb -o grids.vdb -q >/dev/null
cp grids.vdb frames_0000.vdb && cp grids.vdb frames_0001.vdb
stays grids_beside_a_blend grids.vdb export grids.vdb --to blender -o grids.blend
# Of another program, or isoshade's: the latter is made again.
echo 'of another program' >beside.vdb && cp beside.vdb before.vdb
refuse grids_of_another_program 3 'beside.vdb: was saved or changed' isoshade export s.nrrd --to blender -o beside.blend -q
check stay_as_they_are cmp beside.vdb before.vdb
refuse so_do_those_of_a_level 3 'more_level_1.vdb: was saved or changed' \
    sh -c 'cp before.vdb more_level_1.vdb && trap "rm more_level_1.vdb" EXIT && "$ISOSHADE" export s.nrrd --to blender --levels 2 -o more.blend -q'
beside() { # a name that -o leads to, command ...: a file of another program is refused before work, and stays
    cp before.vdb "$1"
    refuse "at_the_name_$1" 3 "$1: w" isoshade "${@:2}" -q
    check "$1_stays" cmp "$1" before.vdb
    rm -f "$1"
}
beside play_0001.vdb export 'frames_%04d.vdb' --frames all --to blender -o play.blend
beside both_s_2.vdb export s.nrrd --add s.nrrd --to blender -o both.blend
beside shown.json scenes s.nrrd --view front --size 32 -o shown.png
beside named_level_1.tf.json tf adapt s.nrrd --scene one.json --levels 2 -o named
stays grids_of_frames frames_0000.vdb export 'frames_%04d.vdb' --frames all --to blender -o frames.blend
stays a_grid_of_a_file grids.vdb export grids.vdb:density --to vdb -o grids.vdb
stays a_scene_beside_a_report rep.scene.json validate s.nrrd --scene rep.scene.json --view left --quick --levels 1 --with gl --size 16 -o rep
stays what_is_written_beside_a_sheet sheet.json scenes s.nrrd --tf sheet.json --view front --size 32 -o sheet.png
stays be_it_a_scene one.json scenes s.nrrd --scene one.json --view front --size 32 -o one.png
stays a_transfer_function_of_a_level t_level_1.tf.json tf adapt s.nrrd --tf t_level_1.tf.json --levels 2 -o t
stays one_that_a_scene_names shells.tf.json tf adapt s.nrrd --scene one.json --level 1 -o shells.tf.json
refuse no_suggestion_follows_a_scene 2 'suggestions depend only on the volume' isoshade tf suggest s.nrrd --scene one.json -o shells.tf.json -q
isoshade build s.nrrd -o own.iso --levels 2 -q >/dev/null
stays a_pyramid_by_its_level own.iso build own.iso/level_1.nrrd -o own.iso --levels 1
ln own.iso/level_0.nrrd p_level_0.nrrd
stays a_level_by_another_name p_level_0.nrrd palette own.iso --per-level --entries 4 -o p.nrrd
stays a_volume_for_a_table s.nrrd isoshade-lab levels s.nrrd --quick --levels 2 --methods default,original --csv s.nrrd
printf 'NRRD0004\ntype: uint8\ndimension: 3\nsizes: 4 4 4\nspacings: 1 1 1\nencoding: raw\ndata file: data.nrrd\n' >d.nhdr
seq 100 | head -c 64 >data.nrrd
stays samples_that_a_header_names data.nrrd palette d.nhdr --entries 4 -o data.nrrd
cp s.nrrd n_0.nrrd && cp s.nrrd n_1.nrrd
stays another_frame n_1.nrrd palette 'n_%d.nrrd' --frame 0 --entries 4 -o n_1.nrrd
if [ -x "$(dirname "$(realpath "$ISOSHADE")")/isoshade-itk" ]; then
    mkdir slices && "$python" - <<'PY'
import struct, zlib
chunk = lambda kind, data: struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
for k in range(3): # gray, 8 x 8
    rows = b"".join(b"\0" + bytes(31 * x ^ 7 * y ^ k for x in range(8)) for y in range(8))
    open(f"slices/s{k}.png", "wb").write(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", 8, 8, 8, 0, 0, 0, 0)) +
                                         chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b""))
PY
    stays a_slice_of_a_folder slices render slices --spacing 1x1x1 --tf mri-brain --size 16 -o slices/s0.png
fi
# A second run replaces what the first has written, beside the report, too; a table goes on with itself.
again() { isoshade validate s.nrrd --quick --levels 1 --with cpu --size 16 --limit-size 8 -q -o again; }
check a_report_with_a_scene_of_its_own again
check is_made_again again
table() { isoshade-lab levels s.nrrd --quick --levels 2 --size 16 --methods default,original --csv table.csv -q "$@"; }
check a_table table
check goes_on_with_itself table --have table.csv
# A cache that is damaged is no input that has to stay.
isoshade tf adapt own.iso --tf sheet.json --level 1 -o adapted.tf.json -q >/dev/null
cache=$(ls own.iso/level_1_joint*.nrrd) && echo damaged >"$cache"
check a_cache_that_is_damaged isoshade tf adapt own.iso --tf sheet.json --level 1 -o adapted.tf.json -q
notice is_made_again_too grep -q damaged "$cache"
cd ..

# ---- two outputs of one name: one would be lost ----
refuse two_outputs_of_one_name 2 'are the same file' isoshade render s.nrrd -o same.png --png ./same.png -q
refuse of_a_plan_too 2 'are the same file' isoshade plan s.nrrd --scene "$shells" -o same.json --image same.json -q
refuse and_beside_a_report 2 'are the same file' isoshade validate s.nrrd --scene "$shells" --quick --levels 1 --with cpu --size 16 --junit y --summary-md y -o report -q
touch same.exr && ln -s same.exr other.exr
refuse by_a_link_they_are_one_too 2 'are the same file' isoshade render s.nrrd -o same.exr --png other.exr -q
rm same.exr other.exr

# ---- what is too large, and threads that cannot be had ----
"$python" - <<'PY'
open("large.tf.json", "w").write('{"schema": "isoshade.tf/1", "points": [' + "0," * (17 << 20) + "0]}")
PY
check a_transfer_function_of_many_megabytes_is_refused_unparsed ends 4 'a transfer function has at most' isoshade tf show large.tf.json -o a.png
few_threads() { (ulimit -v 600000 && isoshade render s.nrrd --scene "$shells" --with reference --size 8 --threads 1000 -o a.exr); }
check no_memory_for_threads_is_no_difference ends 6 'cannot start more threads' few_threads

# ---- a library that a damaged file keeps busy ----
# In the place of the program that reads OpenVDB files, one that never ends what a file says, with limits of a second. What it
# read before is not taken for the whole.
cat >busy.cc <<'END'
#include "volume/child_writer.h"
namespace {
[[noreturn]] void keep_busy()
{
    for (volatile unsigned i = 0;; i = i + 1)
        ;
}
struct Busy : PlaneReader {
    bool at_plane;
    int next = 0;
    explicit Busy(bool planes) : at_plane(planes)
    {
        for (int a = 0; a < 3; ++a)
            header.size[a] = 3, header.step[a][a] = 1;
        header.type = ISO_U8;
    }
    void read_plane(char *out, size_t bytes) override
    {
        if (at_plane && next == 1)
            keep_busy();
        memset(out, ++next, bytes);
    }
};
std::unique_ptr<PlaneReader> open_busy(const std::string &path, const Wanted &)
{
    if (path.find("open") != std::string::npos)
        keep_busy();
    return std::make_unique<Busy>(path.find("plane") != std::string::npos);
}
std::string cause_of(const std::exception &e) { return e.what(); }
} // namespace
const ChildProgram child_program = {open_busy, cause_of};
END
mkdir busy && cp "$ISOSHADE" busy/isoshade
if g++ -std=c++17 -DISO_OPEN_SECONDS=0 -DISO_PLANE_SECONDS=0 -I"$top/src" -o busy/isoshade-vdb busy.cc "$top/src/volume/child_main.cc"; then
    for name in whole open plane; do printf ' BDV\0\0\0\0' >"$name.vdb"; done
    check a_reader_that_ends_is_read busy/isoshade info whole.vdb
    check one_that_never_opens_a_file_is_ended ends 4 'damaged? not opened after 0 s' busy/isoshade info open.vdb
    check one_that_never_ends_a_plane_is_too ends 4 'damaged? not read after 0 s' busy/isoshade build plane.vdb -o plane.iso
    check and_leaves_nothing test ! -e plane.iso
else
    not_ok a_reader_that_ends_is_read "busy.cc is not compiled"
fi

# ---- a reader that a damaged file has taken over: it may say anything ----
cat >false.c <<'END'
#include <math.h>
#include <stdio.h>
#include <string.h>
#include "volume/child_stream.h"
static iso_child_header h = {.version = ISO_VERSION, .size = {3, 3, 3}, .step = {{1}, {0, 1}, {0, 0, 1}}, .slope = 1};
static iso_child_answer plane;
int main(int argc, char **argv)
{
    const char *is = argc > 1 ? strrchr(argv[1], '/') + 1 : "";
    const double what = strstr(is, "inf") ? INFINITY : strstr(is, "large") ? 3.5 : NAN;
    if (strstr(is, "type")) h.type = 0x7fffffff;
    if (strstr(is, "world")) h.world = -1;
    if (strstr(is, "slope")) h.slope = what;
    if (strstr(is, "intercept")) h.intercept = what;
    if (strstr(is, "box")) h.box[2] = what;
    if (strstr(is, "many")) h.frames = h.channels = (size_t)1 << 32;
    if (strstr(is, "size")) h.size[0] = h.size[1] = (size_t)1 << 40;
    if (strstr(is, "step")) h.step[1][1] = NAN;
    if (strstr(is, "unit")) memset(h.unit, 'x', sizeof h.unit);
    if (strstr(is, "unspaced")) memset(h.unspaced, 'x', sizeof h.unspaced);
    if (strstr(is, "version")) memset(h.version, '9', sizeof h.version);
    if (strstr(is, "status")) h.answer.status = 256, strcpy(h.answer.error.text, "a text");
    if (strstr(is, "differs")) h.answer.status = ISO_E_DIFFERS, strcpy(h.answer.error.text, "a text");
    if (strstr(is, "silent")) h.answer.status = ISO_E_RANGE;
    if (strstr(is, "plane")) plane.status = -1;
    fwrite(&h, sizeof h, 1, stdout);
    for (int z = 0; z < 3; ++z) {
        fwrite(&plane, sizeof plane, 1, stdout);
        fwrite("012345678", 9, 1, stdout);
    }
    return 0;
}
END
mkdir false && cp "$ISOSHADE" false/isoshade
lies() { # what of its answer is false, exit code, words
    printf ' BDV\0\0\0\0' >"$1.vdb"
    refuse "a_reader_with_a_false_$1" "$2" "$3" false/isoshade info "$PWD/$1.vdb"
}
x() { printf "%${1}s" '' | tr ' ' x; }
if cc -I"$top/src" -o false/isoshade-vdb false.c; then
    printf ' BDV\0\0\0\0' >true.vdb
    check a_reader_that_says_the_truth_is_read false/isoshade info "$PWD/true.vdb"
    lies type 4 'samples of type 2147483647, which there is not'
    lies world 4 'axes of kind -1, which there is not'
    lies slope 4 'slope nan and intercept 0, which have to be finite'
    lies intercept-inf 4 'slope 1 and intercept inf, which have to be finite'
    lies box 4 'a box of 0 x 0 x nan voxels in a grid of 3 x 3 x 3'
    lies box-large 4 'a box of 0 x 0 x 3.5 voxels in a grid of 3 x 3 x 3'
    lies many 4 '4294967296 frames of 4294967296 channels cannot be counted'
    lies size 5 'voxels can be addressed'
    lies step 4 'does not state the spacing'
    lies unit 4 "unknown unit \"$(x 31)\"; override it"
    lies unspaced 4 "does not state the spacing $(x 159);"
    lies version 7 'is of version 999999999999999, isoshade of'
    lies status 4 'OpenVDB fails with status 256 and reports "a text"'
    lies differs 4 'OpenVDB fails with status 1 and reports "a text"'
    lies silent 4 'OpenVDB fails with status 5 and reports ""'
    lies plane 4 'OpenVDB fails with status -1 and reports ""'
else
    not_ok a_reader_that_says_the_truth_is_read "false.c is not compiled"
fi

# ---- pictures ----
isoshade render s.iso --scene "$shells" --with reference --step 1 --size 4 -o whole.exr -q >/dev/null
mkfifo pipe.exr
refuse a_pipe_is_no_picture 3 'pipe.exr: is not a regular file' timeout 120 "$ISOSHADE" compare pipe.exr whole.exr -q
isoshade validate s.nrrd --scene "$shells" --quick --levels 1 --size 8 --with gl -o pictures -q >/dev/null
picture=$(find pictures/images -name '*.exr' | sort | head -n 1)
cp -r pictures before && rm "$picture" && mkfifo "$picture"
refuse nor_in_a_report 3 'is not a regular file' timeout 120 "$ISOSHADE" report diff before pictures -o changes -q

# ---- a reader that hangs ----
mkdir waits.zarr
printf '%s' '{"zarr_format": 2, "shape": [2, 2, 2], "chunks": [2, 2, 2], "dtype": "|u1", "compressor": null,' \
    ' "fill_value": 0, "order": "C", "filters": null}' >waits.zarr/.zarray
info_of_arrays() { patience=120 patiently "$ISOSHADE" info waits.zarr --spacing 1x1x1; }
printf '01234567' >waits.zarr/0.0.0
check a_chunk_is_read info_of_arrays
rm waits.zarr/0.0.0 && mkfifo waits.zarr/0.0.0
refuse a_pipe_is_no_chunk 3 '0.0.0: is not a regular file' info_of_arrays
rm waits.zarr/.zarray && mkfifo waits.zarr/.zarray
refuse nor_what_describes_them 3 '.zarray: is not a regular file' info_of_arrays
mkdir stuck && cp "$ISOSHADE" stuck/isoshade
reader() { printf '%s\n' '#!/bin/bash' "$1" >stuck/isoshade-vdb && chmod +x stuck/isoshade-vdb; }
none_is_left() { for _ in $(seq 3000); do pgrep -f "$1" >/dev/null || return 0; sleep 0.01; done; return 1; }
stuck() { patience=120 patiently stuck/isoshade info whole.vdb --timeout 1; }
reader "trap '' TERM; exec sleep 4322"
refuse a_reader_that_says_nothing_has_a_limit 8 'isoshade-vdb: stopped after 1 s, the time limit' stuck
check it_is_ended_by_then none_is_left 'sleep 4322'
reader "exec >&-; exec sleep 4322"
refuse one_that_has_closed_its_output_is_not_waited_for 4 'OpenVDB ends before the samples do' stuck
check it_is_ended_too none_is_left 'sleep 4322'
reader "exec sleep 4323"
stuck/isoshade info whole.vdb >/dev/null 2>&1 &
for _ in $(seq 3000); do pgrep -f 'sleep 4323' >/dev/null && break; sleep 0.01; done
kill -9 $! && wait $! 2>/dev/null
check one_ends_with_isoshade_that_is_killed none_is_left 'sleep 4323'

# ---- a renderer that hangs ----
mkdir bin
printf '%s\n' '#!/bin/bash' 'case "$*" in *-version*) exec /usr/bin/povray "$@";; esac' 'exec >&- 2>&-' 'setsid sleep 4321 &' 'sleep 4321' >bin/povray
chmod +x bin/povray
hang() { PATH=$PWD/bin:$PATH isoshade render s.nrrd --scene "$shells" --with povray --size 8 -o o.exr -q --timeout "$1"; }
check a_renderer_that_hangs_has_a_limit ends 8 'the time limit' hang 0.5
hang 0 2>hang.txt &
hanging=$!
for _ in $(seq 3000); do pgrep -f 'sleep 4321' >/dev/null && break; sleep 0.01; done
pkill -TERM -P $hanging -x isoshade || kill -TERM $hanging
wait $hanging
check and_can_be_interrupted grep -q 'stopped by signal 15' hang.txt
check it_leaves_nothing_running test -z "$(pgrep -f 'sleep 4321')"
exit $failed
