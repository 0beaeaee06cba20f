#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# export --to vdb --bake and --for: what OpenVDB's own tools, Python's module and Cycles read of the files; the .usda; refusals.
. "$(dirname "$0")/lib.sh"
python=$(command -v /usr/bin/python3 || command -v python3)
# Colors as they are: ambient 1. A camera along +y, 30 mm high: tests/baked_volume.py has the same.
cat >flat.scene.json <<END
{"schema": "isoshade.scene/1", "image": {"width": 48, "height": 48},
 "camera": {"projection": "orthographic", "position": [0, -100, 0], "look_at": [0, 0, 0], "up": [0, 0, 1], "height_mm": 30},
 "lights": [{"direction": [0, -1, 0], "space": "world", "intensity": 1}], "shading": {"ambient": 1, "diffuse": 0, "specular": 0, "power": 1}, "background": [0, 0, 0], "step_voxels": 0.25,
 "tf": "$top/refscenes/shells.tf.json"}
END
"$ISOSHADE" make shells --size 20x24x16 --spacing 1.2x1x1.4 -q -o v.nrrd || exit 1
bake=("$ISOSHADE" export v.nrrd --to vdb --scene flat.scene.json -q)

expect a_row_for_blender 0 "${bake[@]}" --for blender --size 48 --json -o b.vdb
cp out b.json
has_keys the_report b.json scene_unit up points_per_voxel visible_points error_lit error_emission tested
check it_is_in_meters grep -q '"scene_unit_mm": 1000' b.json
expect a_row_for_karma 0 "${bake[@]}" --for karma --size 16 -o k.vdb
check an_option_stands_instead_of_the_row "${bake[@]}" --for karma --scene-unit cm --up z --size 16 -o c.vdb
check what_was_not_run_says_so grep -q 'for karma (not run)' out
check both_errors_are_printed grep -q '^unlit, with the emission grid: RMSE' out
# A .usda is edited by people: it is overwritten as it was written, else by --force alone.
usd() { "${bake[@]}" --for karma --size 16 -o k.vdb "$@"; }
check a_usda_as_it_was_is_written_again usd
echo '# mine' >>k.usda && cp k.usda mine.usda
refuse one_that_was_changed_is_kept 3 'k.usda: was saved or changed since' usd
check and_its_grids_too cmp k.usda mine.usda
check force_overwrites_it usd --force
check and_keeps_what_was_there cmp k.usda1 mine.usda

if [ -n "$python" ] && "$python" "$top/tests/usda.py" k.usda >usda.txt 2>err; then
    ok the_usda_is_read
    check its_unit_and_axis grep -q '^unit 1 up Y' usda.txt
    check its_colors grep -q '^Cd Cd float3 ./k.vdb' usda.txt
    sed 's/rel field:Cd = <.*>/rel field:Cd = <\/k\/cd>/' k.usda >lost.usda
    notice a_lost_field "$python" "$top/tests/usda.py" lost.usda
    sed 's/float3"/vec3s"/' k.usda >type.usda
    notice a_type_that_is_none "$python" "$top/tests/usda.py" type.usda
    mkdir moved && cp k.usda moved
    notice a_file_that_is_not_beside_it "$python" "$top/tests/usda.py" moved/k.usda
    "$python" "$top/tests/usda.py" c.usda >usda.txt 2>&1
    check another_unit grep -q '^unit 0.01 up Z' usda.txt
else
    not_ok the_usda_is_read "$(cat err)"
fi

# OpenVDB's own tools, where they are.
if command -v vdb_print >/dev/null; then
    vdb_print -l b.vdb >b.txt 2>&1
    check three_grids test "$(grep -c '^Name: ' b.txt)" = 3
    check of_these_names test "$(sed -n 's/^Name: //p' b.txt | tr '\n' ' ')" = "color density emission "
    check all_fog_volumes test "$(grep -c 'class: fog volume' b.txt)" = 3
    check without_active_tiles test "$(grep -c 'active tiles:  *0$' b.txt)" = 3
    check no_folder_is_named test "$(grep -c "$dir\|$HOME\|/tmp" b.txt)" = 0
    check right_handed_with_y_up bash -c "vdb_print -l k.vdb | grep -A2 'index to world' | head -n 3 | tr -d '[],' | grep -q '0 0 -0.0005* 0\|0 0 -0.0010* 0\|0 0 -'"
    if vdb_lod -name density -keep -range 0-1 b.vdb lod.vdb >err 2>&1; then
        check levels_by_openvdb bash -c "vdb_print lod.vdb | grep -q density_level_1"
    else
        not_ok levels_by_openvdb "$(cat err)"
    fi
else
    skip three_grids "libopenvdb-tools is not installed"
fi

cat >read.py <<'END'
import sys
try:
    import pyopenvdb as vdb
except ImportError:
    import openvdb as vdb
density, color, emission = (vdb.read(sys.argv[1], name) for name in ("density", "color", "emission"))
assert density.gridClass == vdb.GridClass.FOG_VOLUME and density.background == 0
values = [(i["min"] if isinstance(i, dict) else i.min, i["value"] if isinstance(i, dict) else i.value) for i in density.iterOnValues()]
assert len(values) == density.activeVoxelCount() and min(v for _, v in values) == 0 # the rim
assert sum(v > 0 for _, v in values) > 500
c, e = color.getAccessor(), emission.getAccessor()
for at, v in values[::7]:
    assert all(abs(v * x - y) <= 1e-5 * v for x, y in zip(c.getValue(at), e.getValue(at))), (at, v)
size = density.transform.voxelSize()
assert all(abs(a - b) < 1e-9 for a, b in zip(size, (0.0012, 0.001, 0.0014))), size
assert color.activeVoxelCount() == emission.activeVoxelCount() < density.activeVoxelCount()
END
if "$python" -c 'import pyopenvdb' 2>/dev/null || "$python" -c 'import openvdb' 2>/dev/null; then
    check pythons_module_reads_it "$python" read.py b.vdb
else
    skip pythons_module_reads_it "python3-openvdb is not installed"
fi

# Principled Volume on the baked grids is as far from the exact picture as was printed: it shows the grids, no more and no
# less than what baking changes. The rest is Cycles' step and noise.
if has_cycles; then
    "$ISOSHADE" render v.nrrd --scene flat.scene.json --with reference --size 48 -q -o exact.exr >log 2>&1
    ${ISOSHADE_BLENDER:-blender} -b -P "$top/tests/baked_volume.py" -- b.vdb 48 >blender.log 2>&1
    check blender_finds_the_grids grep -q 'grids: color,density,emission' blender.log
    "$ISOSHADE" compare right.exr exact.exr --json >right.json 2>err
    "$ISOSHADE" compare planted.exr exact.exr --json >planted.json 2>err
    printed=$(sed -n '/"error_emission"/,/}/p' b.json | sed -n 's/.*"rmse": \([-0-9.e]*\).*/\1/p')
    right=$(json_number right.json rmse) planted=$(json_number planted.json rmse)
    echo "# printed $printed, Cycles $right, with ten times the density $planted"
    holds principled_volume_is_as_near_as_printed "$right <= $printed + 0.004 && $right >= $printed - 0.004"
    holds a_wrong_unit_is_not "$planted > $printed + 0.02"
else
    skip principled_volume_is_as_near_as_printed "$lack"
fi

refuse no_density 2 "must include density" "${bake[@]}" --bake Cd -o x.vdb
refuse an_unknown_grid 2 "grids: density, Cd, emission or temperature" "${bake[@]}" --bake density,albedo -o x.vdb
refuse an_unknown_program 2 "must be one of: blender, houdini" "${bake[@]}" --for maya -o x.vdb
refuse an_unknown_unit 2 "--scene-unit" "${bake[@]}" --bake density --scene-unit parsec -o x.vdb
refuse a_program_for_blend_files 2 "--bake and --for cannot be used with --to blender" "$ISOSHADE" export v.nrrd --to blender --for blender -q -o x.blend
refuse levels_of_what_is_baked 2 "--levels cannot be used with baked grids" "${bake[@]}" --bake density --levels 2 -o x.vdb
refuse usd_of_another_name 2 "must end in .vdb" "${bake[@]}" --bake density --usd --size 8 -o x.dat
exit $failed
