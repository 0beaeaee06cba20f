#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# The command palette: inputs, every output, JSON, messages, exit codes, and no half-written files.
. "$(dirname "$0")/lib.sh"
"$ISOSHADE" make marschner-lobb --size 40x28x33 --spacing 1x1x2.5 -o v.nrrd -q || exit 1
"$ISOSHADE" make constant --size 8x9x10 -o flat.nrrd -q || exit 1
"$ISOSHADE" build v.nrrd -o v.iso --levels 3 -q >/dev/null || exit 1

expect a_volume_gives_every_output 0 "$ISOSHADE" palette v.nrrd -q -o p.csv -o p.inc -o p.py -o p.exr -o p.png -o p.nrrd
check csv_has_an_entry_a_line test "$(wc -l <p.csv)" = 256
check csv_starts_with_the_zero_vector grep -q '^0,0,0,0$' p.csv
check povray_table_is_declared grep -q '^#declare Palette = array\[Palette_Count\]' p.inc
check python_table_parses python3 -c 'import runpy; t = runpy.run_path("p.py")["palette"]; assert len(t) == 255 and t[0] == (0, 0, 0)'
cat >t.pov <<'POV'
#version 3.7;
#include "p.inc"
#if (dimension_size(Palette, 1) != Palette_Count | Palette_Count != 255 | abs(vlength(Palette[254]) - 1) > 1e-6) #error "wrong" #end
camera { location <0, 0, -1> look_at 0 }
POV
expect povray_reads_its_table 0 povray -D +W2 +H2 +It.pov +Ot.png
cat >t.py <<'PY'
import runpy
module = runpy.run_path("p.py")
image, palette = module["make_image"](), module["palette"]
assert tuple(image.size) == (255, 1) and image.is_float
pixels = list(image.pixels)
assert all(abs(a - b) < 1e-6 for k, n in enumerate(palette) for a, b in zip(pixels[4 * k:], n))
PY
expect blender_makes_its_image 0 blender -b --factory-startup --python-exit-code 3 --python t.py
check index_volume_is_bytes sh -c '"$ISOSHADE" info p.nrrd | grep -q uint8'
check index_volume_has_the_size sh -c '"$ISOSHADE" info p.nrrd --json | tr -d " \n" | grep -q "\[40,28,33\]"'
expect more_entries_take_two_bytes 0 "$ISOSHADE" palette v.nrrd -q --entries 1022 -o wide.nrrd
check index_volume_is_words sh -c '"$ISOSHADE" info wide.nrrd | grep -q uint16'
expect threads_do_not_show 0 "$ISOSHADE" palette v.nrrd -q --threads 3 -o p3.csv
check threads_give_the_same_bytes cmp p.csv p3.csv

expect the_result_is_json 0 "$ISOSHADE" palette v.nrrd --json -q
check json_names_the_schema grep -q '"isoshade.palette/1"' out
has_keys json_has out method entries index_bits weight undefined_weight norm1 norm2 norm2_as_printed rms_deg max_deg fit_seconds
fitted=$(json_number out norm1)
expect the_lattice_is_a_method 0 "$ISOSHADE" palette v.nrrd --json -q --method fibonacci
holds and_a_fit_is_nearer "$(json_number out norm1) > 1.2 * $fitted"

expect a_pyramid_gives_one_palette 0 "$ISOSHADE" palette v.iso -q -o all.csv -o all.nrrd
check with_indices_of_each_level test -e all_level_0.nrrd -a -e all_level_2.nrrd
expect or_one_a_level 0 "$ISOSHADE" palette v.iso -q --per-level -o each.csv
check palettes_of_levels_differ sh -c '! cmp -s each_level_0.csv each_level_2.csv'
expect weights_by_magnitude 0 "$ISOSHADE" palette v.nrrd -q --by-magnitude -o heavy.csv
check weights_change_the_palette sh -c '! cmp -s heavy.csv p.csv'
cat >tf.json <<'TF'
{"schema": "isoshade.tf/1", "range": "fit", "unit_distance_voxels": 1, "color_space": "linear", "table_size": 64,
 "points": [{"value": 0, "r": 1, "g": 1, "b": 1, "opacity": 0}, {"value": 0.8, "r": 1, "g": 1, "b": 1, "opacity": 0},
            {"value": 1, "r": 1, "g": 1, "b": 1, "opacity": 0.5}]}
TF
expect weights_by_opacity 0 "$ISOSHADE" palette v.nrrd -q --tf tf.json -o seen.csv
check opacity_changes_the_palette sh -c '! cmp -s seen.csv p.csv'
expect a_constant_volume_has_the_zero_vector_alone 0 "$ISOSHADE" palette flat.nrrd -q -o flat.csv
check one_entry test "$(wc -l <flat.csv)" = 2

scene=$top/refscenes/marschner-lobb.scene.json
expect a_render_from_the_palette 0 "$ISOSHADE" render v.iso --scene "$scene" --size 24 --with reference --shading-from palette --palette p.csv -o palette.exr -q
expect and_one_from_the_codes 0 "$ISOSHADE" render v.iso --scene "$scene" --size 24 --with reference -o codes.exr -q
expect they_are_close 0 "$ISOSHADE" compare palette.exr codes.exr --max-rmse 0.02
expect but_not_equal 1 "$ISOSHADE" compare palette.exr codes.exr --max-abs 0.0001
expect nearest_entries_render 0 "$ISOSHADE" render v.iso --scene "$scene" --size 24 --with gl --shading-from palette-nearest --palette p.csv -o nearest.exr -q
expect a_shade_table_renders 0 "$ISOSHADE" render v.iso --scene "$scene" --size 24 --with gl --shading-from palette-nearest --palette p.csv --shade-table -o table.exr -q
# The scene is orthographic, so the table is exact but for float sums; another palette's table would be off by 0.1.
expect and_is_close_to_shading_each_sample 0 "$ISOSHADE" compare table.exr nearest.exr --max-abs 1e-4
expect a_shade_table_without_a_palette_is_refused 2 "$ISOSHADE" render v.iso --scene "$scene" --shade-table -o x.exr -q
expect a_palette_without_its_source_is_refused 2 "$ISOSHADE" render v.iso --scene "$scene" --palette p.csv -o x.exr -q
expect a_source_without_its_palette_is_refused 2 "$ISOSHADE" render v.iso --scene "$scene" --shading-from palette -o x.exr -q
expect a_palette_that_is_none_is_refused 4 "$ISOSHADE" render v.iso --scene "$scene" --shading-from palette --palette p.inc -o x.exr -q
expect nothing_to_fit_to_is_refused 2 "$ISOSHADE" palette -q
expect an_unknown_method_is_refused 2 "$ISOSHADE" palette v.nrrd -q --method median
check and_the_methods_are_listed grep -q 'kmeans, ' err
expect too_many_entries_are_refused 2 "$ISOSHADE" palette v.nrrd -q --entries 99999
expect an_unknown_ending_is_refused 2 "$ISOSHADE" palette v.nrrd -q -o p.doc
expect a_level_of_a_volume_is_refused 2 "$ISOSHADE" palette v.nrrd -q --level 0
expect a_level_that_is_not_there_is_refused 2 "$ISOSHADE" palette v.iso -q --level 7
expect a_missing_folder_is_an_io_error 3 "$ISOSHADE" palette v.nrrd -q -o nowhere/p.csv
expect a_missing_volume_is_an_io_error 3 "$ISOSHADE" palette none.nrrd -q
check nothing_is_left_half_written sh -c 'test -z "$(find . -name ".*-*" ! -name .isoshade-files)"'
exit $failed
