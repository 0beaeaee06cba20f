#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# export --to pbrt: the files as a reader of the format has them: grids equal to those of --to vdb --bake, and
# cameras, axes and units by pictures that are as far from the exact one as was printed.
. "$(dirname "$0")/lib.sh"
python_with numpy
scene() { # of this camera, lights and shading; the TF of the shells, over their range
    cat <<END_OF_SCENE
{"schema": "isoshade.scene/1", "image": {"width": 24, "height": 16}, "camera": {$1}, "lights": [$2], "shading": {$3},
 "background": [$4], "step_voxels": 0.25, "tf": "$top/refscenes/shells.tf.json"}
END_OF_SCENE
}
light='{"direction": [1, -2, 2], "space": "world", "intensity": 1}'
scene '"projection": "perspective", "position": [30, -60, 35], "look_at": [0, 0, 0], "up": [0, 0, 1], "fov_y_deg": 28' "$light" \
    '"ambient": 0.2, "diffuse": 0.5, "specular": 0.3, "power": 12' '0.1, 0.2, 0.3' >lit.scene.json
scene '"projection": "orthographic", "position": [-50, -60, 20], "look_at": [0, 0, 0], "up": [0, 0, 1], "height_mm": 28' "$light" \
    '"ambient": 1, "diffuse": 0, "specular": 0, "power": 1' '0, 0, 0' >flat.scene.json
scene '"projection": "perspective", "position": [1, 2, 0], "look_at": [0, 9, 0], "up": [0, 0, 1], "fov_y_deg": 60' "$light" \
    '"ambient": 0.2, "diffuse": 0.5, "specular": 0.3, "power": 12' '0.1, 0.2, 0.3' >inside.scene.json
# Its name holds what ends a string, a comment or an element; its axes are turned and left-handed.
name='a" ] --> <b \ #.nrrd'
"$ISOSHADE" make shells --size 20x24x16 --spacing 1.2x1x1.4 -q -o v.nrrd && cp v.nrrd "$name" || exit 1
"$ISOSHADE" make shells --size 18x14x16 --spacing 1x1.5x1.2 --rotate 0,1,0,1,0,0,0,0,1 -q -o turned.nrrd || exit 1
one() { "$ISOSHADE" export "$@" -q; }

expect pbrt 0 one "$name" --to pbrt --scene lit.scene.json --supersample 1 --json -o lit
cp out lit.json
has_keys the_report lit.json medium size visible_points max_extinction_per_mm camera_is_inside picture error_shaded
has_files pbrt_writes lit scene.pbrt medium.pbrt
expect a_turned_volume 0 one turned.nrrd --to pbrt --scene flat.scene.json -o turned
check it_says_what_baking_changes grep -q '^interpolating shaded colors instead of values: RMSE' out
turned=$(sed -n 's/^interpolating shaded colors.*RMSE \([0-9.e-]*\),.*/\1/p' out)
expect from_inside 0 one v.nrrd --to pbrt --scene inside.scene.json --json -o inside
check the_camera_stands_in_the_medium bash -c 'grep -q "camera_is_inside\": true" out && grep -B1 "^Transform" inside/scene.pbrt | head -1 | grep -q "^MediumInterface \"\" \"volume\""'
inside=$(sed -n '/"error_shaded"/,/}/p' out | sed -n 's/.*"rmse": \([-0-9.e]*\).*/\1/p')

if ! "$python" -c 'import numpy' 2>/dev/null; then
    skip the_grids_are_those_that_are_baked "python3-numpy is not installed"
    exit $failed
fi
read_scene() { "$python" "$top/tests/pbrt_scene.py" "$@"; }
if "$python" -c 'import pyopenvdb' 2>/dev/null || "$python" -c 'import openvdb' 2>/dev/null; then
    one v.nrrd --to vdb --dense -o directions.vdb >log && one v.nrrd --to vdb --scene lit.scene.json --bake density,Cd --supersample 1 --size 8 -o baked.vdb >>log
    check the_grids_are_those_that_are_baked read_scene same lit baked.vdb directions.vdb
    notice colors_that_are_not_shaded read_scene same lit baked.vdb
else
    skip the_grids_are_those_that_are_baked "python3-openvdb is not installed"
fi

# The printed error is of a picture twice as many times sampled; the rest is the step here.
picture() { # NAME VOLUME SCENE FOLDER PRINTED
    "$ISOSHADE" render "$2" --scene "$3" --with reference --step 0.125 -q -o exact.exr >log && read_scene draw "$4" drawn.exr &&
        "$ISOSHADE" compare drawn.exr exact.exr --json >compare.json 2>err
    rmse=$(json_number compare.json rmse)
    echo "# $1: printed $5, drawn $rmse"
    holds "$1" "$rmse <= $5 + 0.0015 && $rmse >= $5 - 0.0015"
}
picture as_far_as_printed v.nrrd lit.scene.json lit "$(sed -n '/"error_shaded"/,/}/p' lit.json | sed -n 's/.*"rmse": \([-0-9.e]*\).*/\1/p')"
picture a_turned_volume_as_well turned.nrrd flat.scene.json turned "$turned"
picture from_inside_as_well v.nrrd inside.scene.json inside "$inside"
# Faults: a mirrored camera, a turned medium, rows in place of columns, a file that ends early, a quote.
planted() { # NAME SED-EXPRESSION FILE
    rm -rf bad && cp -r lit bad && sed -i "$2" "bad/$3"
    if cmp -s "bad/$3" "lit/$3"; then not_ok "$1" "nothing was planted"; fi
    if read_scene draw bad bad.exr 2>/dev/null && "$ISOSHADE" compare bad.exr exact.exr --json >compare.json 2>/dev/null; then
        holds "$1" "$(json_number compare.json rmse) > 0.03"
    else
        ok "$1"
    fi
}
"$ISOSHADE" render v.nrrd --scene lit.scene.json --with reference --step 0.125 -q -o exact.exr >log
planted a_mirrored_camera 's/screenwindow" \[ \(\S*\) \(\S*\)/screenwindow" [ \2 \1/' scene.pbrt
planted another_unit 's/^Transform \[ 1.2 /Transform [ 0.12 /' scene.pbrt
planted a_value_too_few '0,/ 0 0 0/s/ 0 0 0/ 0 0/' medium.pbrt
planted an_open_quote 's/"rgbgrid"/"rgbgrid/' medium.pbrt

refuse a_plan 2 "--plan cannot be used with --to pbrt" one v.nrrd --to pbrt --scene lit.scene.json --plan none.json -o x
refuse grids_that_are_named 2 "--bake and --for cannot be used with --to pbrt" one v.nrrd --to pbrt --bake density -o x
refuse levels 2 "--levels cannot be used with --to pbrt" one v.nrrd --to pbrt --levels 2 -o x
refuse points_of_what_is_not_baked 2 "--points needs --bake or --for" one v.nrrd --to vdb --points 2 -o x.vdb
refuse no_points 2 "--points is 9" one v.nrrd --to pbrt --points 9 -o x
mkdir mine && echo mine >mine/scene.pbrt
refuse a_folder_of_someone_else 3 "mine" one v.nrrd --to pbrt -o mine
exit $failed
