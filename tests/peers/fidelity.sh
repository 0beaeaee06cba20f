#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# fidelity.sh [DIR]: a site of certificates (build/fidelity/site) of all renderers of this machine, over scenes of the
# suite and, if DIR has them, real volumes. The scenes have no light, since most peers shade by rules of their own; one
# lit scene shows the renderers that compute it. What is missing gets cards that say so.
set -u
top=$(cd "$(dirname "$0")/../.." && pwd) data=${1:-$(cd "$(dirname "$0")/../../../shared/data" 2>/dev/null && pwd)}
isoshade=$top/isoshade out=$top/build/fidelity peers=$top/tests/peers size=${FIDELITY_SIZE:-192}
rm -rf "$out" && mkdir -p "$out/suite" && cd "$out" || exit 3
command -v npm >/dev/null && sh "$peers/web/fetch.sh" || echo "fidelity: no vtk.js, no NiiVue: npm fetches them"
blenders=blender
command -v blender-4.3 >/dev/null && blenders=blender,blender-4.3
export ISOSHADE_RENDERERS=$peers/viewer.json,$peers/vtk.json,$peers/web/renderers.json
with=reference,gl,cpu,cycles,povray,webgl,vtk,vtk-gpu,vtkjs,niivue
screen=
[ -n "${DISPLAY:-}" ] || ! command -v xvfb-run >/dev/null || screen='xvfb-run -a'
# report NAME WORDS...: a renderer that differs, fails or is missing is a card, not a failure
report() {
    local name=$1
    shift
    $screen "$isoshade" validate "$@" --quick --levels 1 --size "$size" --seeds 2 --blender $blenders -o "$name" \
        >"$name.log" 2>&1
    if [ -s "$name/report.json" ]; then reports="$reports $name"; else
        echo "fidelity: $name: $(tail -n 1 "$name.log")"
    fi
}
reports=
sh "$peers/web/unlit.sh" all
for scene in constant marschner-lobb sphere step; do cp "all/$scene.scene.json" suite; done
cp "$top/refscenes/suite/highlights.scene.json" suite
report generated --suite suite --with $with
[ -d "$data" ] || echo "fidelity: no folder of real volumes: only generated ones"
for volume in inia19_t1_float mr_seg3d cranium_ct_hu; do
    [ -s "$data/$volume.nrrd" ] || continue
    "$isoshade" tf suggest "$data/$volume.nrrd" -q -o "$volume.tf.json" >/dev/null 2>&1
    # Without the limits that brain-unlit asks of its own soft transfer function.
    sed '/"agreement"/d; s/"brain.tf.json",/"'$volume'.tf.json"/' "$top/refscenes/brain-unlit.scene.json" \
        >"$volume.scene.json"
    report "$volume" "$data/$volume.nrrd" --scene "$volume.scene.json" --with $with
done
"$isoshade" certificate $reports -o site
