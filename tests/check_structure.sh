#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Something reaches each function, and files of a folder include each other in no circle but those listed here.
. "$(dirname "$0")/lib.sh"
cd "$top" || exit 1
# A type of the first file is used by a part of it; each list may only shrink.
cat >"$dir/circles" <<'END_OF_LIST'
exporters/blender: blender blender_scene
exporters/povray: povray povray_files scene_parts scene_text
exporters/vdb: vdb vdb_file vdb_sparse
exporters/vdb: vdb_guarded vdb_leaves vdb_nanovdb vdb_openvdb vdb_tree
src/brick: bricks made_bricks node_box
src/brick: lattice lattice_build
src/encode: code code_kernel
src/gradient: gradient gradient_kernel
src/image: exr_codec image picture_bytes primaries
src/lab: level_methods level_scene
src/pyramid: agreement cascade cascade_kernel filter_kernel narrow pyramid pyramid_layout
src/pyramid: pyramid_stream stream_build
src/render: cell_pieces cell_ray cell_ray_kernel reference reference_ray
src/render/cpu: cast_scene caster
src/render/gl: gl_context gl_directions gl_uniforms gl_variant raycaster
src/render: image_bound image_bound_points
src/renderers: picture_store renderers
src/report: levels report report_files
src/view: contents viewer
src/volume: frames stream_kernel unpack
src/volume/itk: dicom_series pictures
src/volume: stream volume
END_OF_LIST
structure() { python3 "$top/tests/structure.py" "$@"; }
mapfile -t files < <(find src exporters tests -name '*.c' -o -name '*.h' -o -name '*.cc')
check each_function_is_reached cmp /dev/null <(structure unreached "${files[@]}")
check circles_are_those_listed diff "$dir/circles" <(structure circles "${files[@]}")

# Planted: a function that calls itself alone, one that only that one calls, and three files in a circle.
cd "$dir" && mkdir -p src/a
printf '#include "a/one.h"\nint main(void)\n{\n    return used();\n}\n' >src/main.c
printf 'int used(void);\nint lost(int);\n#include "a/two.h"\n' >src/a/one.h
cat >src/a/one.c <<'END'
#include "a/one.h"
static int helper(int n)
{
    return n;
}

int used(void)
{
    return 0; /* lost(1) */
}

int lost(int n)
{
    return n ? lost(helper(n)) : 0;
}
END
touch src/a/two.h src/a/three.h
check what_is_reached_is_not_found test -z "$(structure unreached src/main.c src/a/one.h | grep used)"
lost=$(structure unreached src/main.c src/a/one.[ch] | tr '\n' ' ')
check what_nothing_reaches_is_found test "$lost" = "src/a/one.c: helper src/a/one.c: lost "
check no_circle_is_no_finding test -z "$(structure circles src/a/*.[ch])"
echo '#include "a/three.h"' >src/a/two.c && echo '#include "a/one.h"' >src/a/three.h && touch src/a/three.h
check a_circle_is_found test "$(structure circles src/a/*.[ch])" = "src/a: one three two"
exit $failed
