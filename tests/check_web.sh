#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# vtk.js in headless Chromium behind the contract for renderers (doc/results/web.md). What needs the library runs only where
# `sh tests/peers/web/fetch.sh` has fetched it; nothing else of isoshade needs npm.
. "$(dirname "$0")/lib.sh"
web=$top/tests/peers/web TMPDIR=$dir
export TMPDIR
check versions_are_pinned sh -c '! grep -E "\"(@kitware|@niivue|axe-core|esbuild)[^:]*: \"[^0-9]" "$1"' - "$web/package.json"
check the_lock_file_names_no_registry sh -c '! grep -q "\"resolved\"" "$1"' - "$web/package-lock.json"
check the_lock_file_has_checksums grep -q '"integrity": "sha512-' "$web/package-lock.json"
"$ISOSHADE" list --renderers "$web/renderers.json" >"$dir/list" 2>&1
check its_rows_are_listed grep -q vtkjs-midpoints "$dir/list"
command -v node >/dev/null || { skip vtkjs "there is no node"; exit $failed; }

# Without the library: the reason is the command that fetches it.
mkdir bare && cp "$web"/*.mjs "$web/renderers.json" bare
"$ISOSHADE" make constant --size 9x7x8 -o v.nrrd
cat >clear.scene.json <<'END'
{"schema": "isoshade.scene/1", "image": {"width": 24, "height": 24},
 "camera": {"projection": "perspective", "fit": true, "direction": [1, 2, -0.7], "up": [0, 0, 1], "margin": 0.9, "fov_y_deg": 20},
 "lights": [{"direction": [0, 0, 1], "space": "camera", "intensity": 1}], "shading": {"ambient": 1, "diffuse": 0, "specular": 0, "power": 1}, "background": [0.2, 0.4, 0.6],
 "step_voxels": 0.25, "agreement": {"tier": "convergence", "tf": "smooth", "why": "one value"},
 "tf": {"schema": "isoshade.tf/1", "range": [0, 1], "unit_distance_voxels": 2, "color_space": "linear", "table_size": 16,
        "points": [{"value": 0, "r": 0.9, "g": 0.5, "b": 0.2, "opacity": 0.3}, {"value": 1, "r": 0.9, "g": 0.5, "b": 0.2, "opacity": 0.3}]}}
END
"$ISOSHADE" validate v.nrrd --scene clear.scene.json --quick --with vtkjs --renderers bare/renderers.json --quiet -o none >out 2>&1
check without_the_library_fetching_it_is_named grep -rq "fetch.sh fetches it" out none
fetched=$top/build/web
[ -s "$fetched/vtkjs.js" ] || { skip vtkjs "not fetched: sh tests/peers/web/fetch.sh"; exit $failed; }
command -v chromium >/dev/null || { skip vtkjs "there is no chromium"; exit $failed; }

# picture RENDERER JSON: its picture of the scene, and how far it is from the reference's
picture() {
    "$ISOSHADE" render v.nrrd --scene clear.scene.json --with "$1" --renderers "$2" --step "$3" -o "$1.exr" >/dev/null 2>"$dir/err" &&
        "$ISOSHADE" compare reference.exr "$1.exr" | awk '/^max_abs/ { print $2 }'
}
"$ISOSHADE" render v.nrrd --scene clear.scene.json --with reference -o reference.exr >/dev/null
is=$(picture vtkjs "$web/renderers.json" 0.25)
holds a_constant_is_right_within_eight_bits "length(\"$is\") && ${is:-1} < 0.008"
# One thing after another is taken away, and only what pow() of software GL rounds is left: 2e-4 was seen.
is=$(picture and-canvas "$web/causes.json" 0.25)
holds in_floats_it_is_the_reference "length(\"$is\") && ${is:-1} < 5e-4"
# Planted: an extinction 2 % too strong, by a wrong unit distance.
mkdir -p wrong/tests/peers/web wrong/build/web/node_modules
cp "$web"/*.mjs "$web/renderers.json" wrong/tests/peers/web
cp "$fetched/vtkjs.html" wrong/build/web
ln -s "$fetched/node_modules/@kitware" wrong/build/web/node_modules
sed 's/setScalarOpacityUnitDistance(0,\([a-zA-Z_$]*\))/setScalarOpacityUnitDistance(0,0.95*\1)/' "$fetched/vtkjs.js" >wrong/build/web/vtkjs.js
if cmp -s wrong/build/web/vtkjs.js "$fetched/vtkjs.js"; then
    not_ok a_wrong_unit_distance_is_seen "the fault could not be planted"
else
    is=$(picture vtkjs-midpoints wrong/tests/peers/web/renderers.json 0.25)
    holds a_wrong_unit_distance_is_seen "length(\"$is\") && ${is:-0} > 0.008"
fi
check no_browser_is_left_alive sh -c '! ls -d "$TMPDIR"/isoshade-web-* 2>/dev/null | grep -q .'
exit $failed
