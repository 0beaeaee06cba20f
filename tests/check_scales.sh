#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# What one command writes, the others read, whatever the size of the volume and of its values; and pictures do not depend on
# the unit of length. ISOSHADE_ALL_SCALES=1 also has all of refscenes/suite at 1e-7 times its size by all renderers, which
# takes an hour.
. "$(dirname "$0")/lib.sh"
q() { "$ISOSHADE" "$@" -q >printed.txt; }
scenes=$top/refscenes
lit=$scenes/suite/highlights.scene.json

# Pictures of a volume are those of the same one in mm. Rays are set up in double precision, and depths are products of two
# floats with half a unit of their last digits each, 6e-8; some of them meet an edge of a cell.
same() { "$ISOSHADE" compare "$1" "$2" --max-rmse 2e-7 --max-abs 4e-6; }

# chain NAME: what the commands write of NAME.nrrd is given to those that read it
chain() {
    local v=$1
    q tf suggest $v.nrrd -o $v.tf.json && q render $v.nrrd --tf $v.tf.json --with cpu --size 16 -o $v-tf.exr || return
    q tf convert $v.tf.json $v.csv && q tf convert $v.csv $v-csv.tf.json &&
        q render $v.nrrd --tf $v-csv.tf.json --with cpu --size 16 -o $v-csv.exr || return
    q build $v.nrrd --levels 3 -o $v.iso && q info $v.iso >info.txt &&
        q tf adapt $v.iso --tf $v.tf.json -o $v-adapted || return
    for adapted in $v-adapted*.tf.json; do
        [ ! -e "$adapted" ] || q render $v.iso --tf "$adapted" --with cpu --size 16 -o $v-1.exr || return
    done
    q view $v.iso -o $v.html || return
    q scenes $v.nrrd --write $v-scenes --size 16 --levels 1 --steps 0 || return
    local scene=$v-scenes/scene.scene.json volume
    volume=$(find $v-scenes -name volume.nrrd | head -n 1)
    q render $v.nrrd --scene "$scene" --with cpu --size 16 -o $v-scene.exr &&
        q render "$volume" --scene "$scene" --with cpu --size 16 -o $v-request.exr && same $v-request.exr $v-scene.exr || return
    q export $v.iso --to vdb -o $v.vdb && q info $v.vdb >info.txt &&
        q render $v.vdb --tf $v.tf.json --with cpu --size 16 -o $v-vdb.exr || return
    [[ $v =~ ^(h1e-9|h1e9|voxel|steep)$ ]] || return 0 # sizes and values are the exporters' own; one of each is enough
    q export $v.iso --to vdb --for karma --tf $v.tf.json --size 16 -o $v-baked.vdb && q info $v-baked.vdb:density >info.txt || return
    q export $v.iso --to paraview --tf $v.tf.json -o $v-paraview && q info $v-paraview/*.vti >info.txt &&
        q render $v-paraview/*.vti --tf $v.tf.json --with cpu --size 16 -o $v-vti.exr || return
    same $v-vti.exr $v-tf.exr || return
    for target in pbrt povray; do
        q export $v.iso --to $target --tf $v.tf.json --size 16 -o $v-$target || return
    done
    q plan $v.nrrd --tf $v.tf.json --size 16 -o $v.plan.json
}

# ---- lengths: the smallest and the largest, an atom, what is usual, the sky
for h in 1 1e-9 1e-3 1e3 1e9; do
    q make marschner-lobb --size 9x8x7 --spacing ${h}x${h}x$h --rotate 1,2,3,40 -o h$h.nrrd
    check every_command_reads_what_others_write_at_$h chain h$h
    for renderer in reference gl cpu; do
        q render h$h.nrrd --scene "$lit" --with $renderer --size 24 -o h$h-$renderer.exr
        check ${renderer}_draws_the_same_at_$h same h$h-$renderer.exr h1-$renderer.exr
    done
    check a_suggestion_shows_the_same_at_$h same h$h-tf.exr h1-tf.exr
done

# ---- forms and values
q make ramp --size 1 --type float -o voxel.nrrd
q make ramp --size 9x8x1 --type float -o slice.nrrd
q make ramp --size 9x8x7 --range -3,2 --type float -o signed.nrrd
q make ramp --size 9x8x7 --range 0,1 --type float -o unit.nrrd
q make ramp --size 9x8x7 --range 0,1e30 --type float -o huge.nrrd
q make ramp --size 9x8x7 --range 0,1e-30 --type float -o tiny.nrrd
q make ramp --size 9x8x7 --range 0,1e36 --type float -o largest.nrrd
q make ramp --size 9x8x7 --range 0,1e30 --spacing 1e-9x1e-9x1e-9 --type float -o steep.nrrd
for v in voxel slice signed unit huge tiny largest steep; do
    check every_command_reads_what_others_write_of_$v chain $v
done
for renderer in reference gl cpu; do
    q render unit.nrrd --scene "$lit" --with $renderer --size 24 -o unit-$renderer.exr
    for v in huge tiny largest steep; do
        q render $v.nrrd --scene "$lit" --with $renderer --size 24 -o $v-$renderer.exr
        # Samples are rounded to 6e-8 of another range than 0 to 1, and each opacity changes by as much times its slope.
        check ${renderer}_draws_${v}_values_as_others "$ISOSHADE" compare $v-$renderer.exr unit-$renderer.exr --max-rmse 2e-6 --max-abs 1e-4
    done
done

# ---- the suite, a scene of each kind: closed form, a camera inside, first hits, highlights
verdicts() { # NAME, options of validate
    local name=$1
    shift
    "$ISOSHADE" validate --quick -q --size 16 --suite "$name" -o "$name-report" "$@"
}
python3 "$top/tests/scaled_suite.py" 1e-7 "$scenes/suite" few ramp-rotated inside-constant surface-sphere highlights
check scenes_of_each_kind_agree_at_1e-7 verdicts few --with gl,cpu
if [ "${ISOSHADE_ALL_SCALES:-}" ]; then
    python3 "$top/tests/scaled_suite.py" 1e-7 "$scenes/suite" all
    check the_whole_suite_agrees_at_1e-7 verdicts all --with gl,cpu,cycles,povray
fi

# ---- planted: limits hold for readers and writers alike, and none is that of a size
refuse a_length_beyond_the_formats_is_refused_by_options 2 "1e-30 to 1e+33" "$ISOSHADE" tf convert h1.csv x.tf.json --unit-distance 1e-31
sed 's/"unit_distance_mm": [^,]*/"unit_distance_mm": 1e-31/' h1.tf.json >thin.tf.json
refuse and_by_readers 5 "1e-30 to 1e+33" "$ISOSHADE" render h1.nrrd --tf thin.tf.json -o x.exr
refuse and_so_is_a_voxel 2 "1e-30 to 1e+30" "$ISOSHADE" make ramp --size 4 --spacing 1e-31x1x1 -o x.nrrd
exit $failed
