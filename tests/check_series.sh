#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# All frames of a series at once: render and export write a picture, a file or a folder a frame, with one range and one transfer
# function; Blender plays a series as what single exports show.
. "$(dirname "$0")/lib.sh"
scene=$top/refscenes/shells.scene.json
# Three frames of 8 x 8 x 8: a ball that moves along x and becomes brighter.
python3 - <<'END'
for t in range(3):
    with open(f"f_{t}.nrrd", "wb") as file:
        file.write(b"NRRD0004\ntype: uchar\ndimension: 3\nsizes: 8 8 8\nspacings: 1 1 1\nencoding: raw\n\n")
        file.write(bytes(max(0, (100 + 70 * t) - 20 * ((x - 2 - t) ** 2 + (y - 3) ** 2 + (z - 4) ** 2)) for z in range(8)
                         for y in range(8) for x in range(8)))
END
quiet() { "$@" -q >out 2>err || { not_ok "$1_$2" "$(cat err)"; return 1; }; }
quiet "$ISOSHADE" build 'f_%d.nrrd' --frames all --levels 1 -o all.iso

# ---- pictures ----
check pictures "$ISOSHADE" render 'f_%d.nrrd' --frames all --scene "$scene" --with reference --size 12 -o p.exr -q
for k in 0 2; do
    quiet "$ISOSHADE" render all_000$k.iso --scene "$scene" --with reference --size 12 -o one_$k.exr
    check picture_${k}_is_that_of_its_pyramid "$ISOSHADE" compare p_000$k.exr one_$k.exr
done
quiet "$ISOSHADE" render f_0.nrrd --scene "$scene" --with reference --size 12 -o alone.exr
notice and_not_that_of_a_range_of_its_own "$ISOSHADE" compare p_0000.exr alone.exr
# Without a scene: the transfer function that is suggested for the frame of the widest range, for all of them.
check first_pictures "$ISOSHADE" render 'f_%d.nrrd' --frames all --size 12 --with reference -o s.exr -q
quiet "$ISOSHADE" render f_2.nrrd --size 12 --with reference -o s_alone.exr
check the_widest_is_as_by_itself "$ISOSHADE" compare s_0002.exr s_alone.exr
quiet "$ISOSHADE" tf suggest f_2.nrrd -o widest.tf.json
quiet "$ISOSHADE" render f_0.nrrd --tf widest.tf.json --size 12 --with reference -o s_with.exr
check the_others_have_its_transfer_function "$ISOSHADE" compare s_0000.exr s_with.exr --max-rmse 1e-5 # decimals of the file

# ---- exports: those of a frame, as one at a time has them ----
check grids "$ISOSHADE" export 'f_%d.nrrd' --frames all --to vdb -o 'v_%04d.vdb' -q
quiet "$ISOSHADE" build v_0001.vdb --levels 1 -o v.iso
quiet "$ISOSHADE" build f_1.nrrd --levels 1 -o f.iso
holds the_second_has_its_values "$(json_number v.iso/pyramid.json max) == 170 && $(json_number f.iso/pyramid.json max) == 170"
check folders_for_povray "$ISOSHADE" export 'f_%d.nrrd' --frames all --to povray --scene "$scene" --size 12 -o pov -q
mkdir one && quiet "$ISOSHADE" export all_0001.iso --to povray --scene "$scene" --size 12 -o one/pov_0001
check a_folder_is_as_by_itself diff -r -I made -I isoshade pov_0001 one/pov_0001
notice and_not_as_another diff -r -I made -I isoshade pov_0001 pov_0002

check one_file_for_blender "$ISOSHADE" export 'f_%d.nrrd' --frames all --to blender --scene "$scene" --size 12 -o play.blend -q
has_cycles && has_files each_frame . play_0000.vdb play_0001.vdb play_0002.vdb
blender -b play.blend --python-text "isoshade agreement" -a >log 2>&1
# Of the same name: by the names of objects Cycles shifts where its steps begin.
mkdir single && quiet "$ISOSHADE" export all_0001.iso --to blender --scene "$scene" --size 12 -o single/play.blend
blender -b single/play.blend --python-text "isoshade agreement" -f 1 >>log 2>&1
if has_cycles; then
    check it_plays_the_second_second "$ISOSHADE" compare play_0002.exr single/play_0001.exr --max-rmse 1e-6
    for k in 1 3; do notice "and_${k}_is_another" "$ISOSHADE" compare "play_000$k.exr" single/play_0001.exr --max-rmse 1e-2; done
    # The first and the third against the reference: by much less than frames differ.
    for k in 1 3; do
        check "frame_${k}_is_that_of_the_reference" "$ISOSHADE" compare "play_000$k.exr" "p_000$((k - 1)).exr" --max-flip 0.02
    done
    notice and_no_other "$ISOSHADE" compare play_0001.exr p_0002.exr --max-flip 0.02
    check its_frames_are_those_of_the_series test -s play_0003.exr -a ! -e play_0000.exr -a ! -e play_0004.exr
    # Levels of all frames: the property chooses one, in each frame.
    mkdir coarse
    check levels_of_a_series "$ISOSHADE" export 'f_%d.nrrd' --frames all --levels 2 --to blender --scene "$scene" --size 12 \
        -o levels.blend -q
    has_files each_level . levels_level_0_0000.vdb levels_level_1_0000.vdb levels_level_1_0002.vdb
    check a_series_of_the_second "$ISOSHADE" export 'f_%d.nrrd' --frames all --level 1 --to blender --scene "$scene" \
        --size 12 -o coarse/levels.blend -q
    for level in 0 1; do
        blender -b levels.blend --python-text "isoshade agreement" --python-expr "import bpy
bpy.data.objects['levels']['level'] = $level
bpy.data.objects['levels'].update_tag()" -o "//at_${level}_" -f 3 >>log 2>&1
    done
    blender -b coarse/levels.blend --python-text "isoshade agreement" -f 3 >>log 2>&1
    check the_second_level_of_the_third_frame "$ISOSHADE" compare at_1_0003.exr coarse/levels_0003.exr --max-flip 0.02
    check the_first_is_as_without_levels "$ISOSHADE" compare at_0_0003.exr play_0003.exr --max-flip 0.02
    notice and_is_another "$ISOSHADE" compare at_0_0003.exr coarse/levels_0003.exr --max-flip 0.02
else
    skip it_plays_them "$lack"
fi

# ---- what is refused ----
# ---- voxels without data in the second of three frames, whose own range is narrow and inside that of all ----
python3 - <<'END'
import struct
for t in range(3):
    with open(f"g_{t}.nrrd", "wb") as file:
        file.write(b"NRRD0004\ntype: float\ndimension: 3\nsizes: 8 8 8\nspacings: 1 1 1\n")
        file.write(b"endian: little\nencoding: raw\n\n")
        for i in range(512):
            gap = t == 1 and i % 8 > 4
            file.write(struct.pack("<f", float("nan") if gap else 50 + i % 64 / 64 if t == 1 else i % 64 * (t + 1)))
END
cat >opaque.tf.json <<'END'
{"schema": "isoshade.tf/1", "range": [0, 190], "unit_distance_mm": 4, "color_space": "srgb", "points": [
    {"value": 0, "r": 1, "g": 0, "b": 0, "opacity": 0.5}, {"value": 190, "r": 0, "g": 0, "b": 1, "opacity": 0.5}]}
END
for with in reference cpu; do
    quiet "$ISOSHADE" render 'g_%d.nrrd' --frames all --tf opaque.tf.json --size 24 --with $with -o g.$with.exr
done
# Steps of the ray caster at the edge of the data; voxels without data that show fill half of the picture.
check gaps_of_a_later_frame_show_nothing "$ISOSHADE" compare g.reference_0001.exr g.cpu_0001.exr --max-rmse 0.02 \
    --max-abs 1
quiet "$ISOSHADE" export 'g_%d.nrrd' --frames all --tf opaque.tf.json --to vdb -o 'g_%04d.vdb'
quiet "$ISOSHADE" build g_0001.vdb --levels 1 -o g.iso
holds its_gaps_are_below_the_range_of_all "$(json_number g.iso/pyramid.json min) < 0"
check a_material_with_the_share_of_its_data "$ISOSHADE" export 'g_%d.nrrd' --frames all --level 1 --to blender \
    --tf opaque.tf.json --size 12 -o gaps.blend -q
has_cycles && check reads_that_share sh -c \
    '{ zstd -dcq gaps.blend || cat gaps.blend; } 2>/dev/null | grep -aq log2_extinction_scale'
cp g_1.nrrd g_3.nrrd && python3 - <<'END'
with open("g_3.nrrd", "r+b") as file:
    file.seek(-2048, 2)
    file.write(b"\0\0\xc0\x7f" * 512)
END
refuse a_frame_without_data 5 'frame 3 has no voxel with data' "$ISOSHADE" render 'g_%d.nrrd' --frames all -o x.png

refuse one_adapted_table 2 '--frames all excludes --adapt' "$ISOSHADE" export 'f_%d.nrrd' --frames all --adapt --to povray -o x
refuse all_or_nothing 2 '--frames is "2", must be all' "$ISOSHADE" render 'f_%d.nrrd' --frames 2 -o x.png
refuse a_pyramid_has_one 2 'is a pyramid, which has one frame' "$ISOSHADE" render all_0000.iso --frames all -o x.png
sed 's/sizes: 8 8 8/sizes: 8 4 16/' f_2.nrrd >f_3.nrrd
refuse one_grid_for_all 5 'frame 3 has another grid than frame 0' "$ISOSHADE" export 'f_%d.nrrd' --frames all --to povray -o x
exit $failed
