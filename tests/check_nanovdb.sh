#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# export --to nanovdb: NanoVDB's own tools accept it, and what comes back through them is what --to vdb writes, bit for bit.
. "$(dirname "$0")/lib.sh"
python_with openvdb
"$python" -c 'import openvdb' 2>/dev/null || python_with pyopenvdb
"$ISOSHADE" make shells --size 20x24x16 --spacing 1.2x1x1.4 -q -o v.nrrd || exit 1
scene="$top/refscenes/shells.scene.json"
one() { "$ISOSHADE" export v.nrrd "$@" -q; }

if ! one --to nanovdb -o v.nvdb >out 2>err && grep -q 'built without NanoVDB' err; then
    skip nanovdb "$(cat err)"
    exit $failed
fi
expect all_voxels 0 one --to nanovdb -o v.nvdb
check the_message_says_the_format grep -q '^NanoVDB [0-9.]*, not compressed' out
expect levels_as_shown 0 one --to nanovdb --scene "$scene" --levels 2 --json -o s.nvdb
check the_report_has_the_format grep -q '"format": "[0-9]*\.[0-9]*\.[0-9]*"' out
expect baked 0 one --to nanovdb --scene "$scene" --bake density,Cd --scene-unit m --up y --size 8 -o b.nvdb
check it_says_what_baking_changes grep -q '^interpolating colors instead of values: RMSE' out
check nothing_is_left_beside_it test "$(find . -name '.isoshade*' -o -name '*.usda' | wc -l)" = 0
one --to vdb -o v.vdb >log && one --to vdb --scene "$scene" --levels 2 -o s.vdb >>log &&
    one --to vdb --scene "$scene" --bake density,Cd --scene-unit m --up y --size 8 -o b.vdb >>log

cat >same.py <<'END'
"""An OpenVDB file, and what came back of a NanoVDB file: the same grids, active voxels and values, to the last bit. Transforms
are read of the NanoVDB file itself: nanovdb_convert 10 transposes a matrix on its way back (NanoToOpenVDB.h drops what
Mat4::transpose returns), which is seen where axes are turned."""
import re
import struct
import sys
import numpy
try:
    import pyopenvdb as vdb
except ImportError:
    import openvdb as vdb

def names(path):
    return sorted(grid.name for grid in vdb.readAllGridMetadata(path))

def voxels(grid, box):
    low, high = box
    shape = [h - l + 1 for l, h in zip(low, high)]
    vector = isinstance(grid.background, tuple)
    values = numpy.zeros(shape + [3] if vector else shape, numpy.float32)
    grid.copyToArray(values, ijk=low)
    active = sorted(tuple(i["min"] if isinstance(i, dict) else i.min) for i in grid.iterOnValues())
    return values, active

def maps(path):
    """Of each grid its double 3 x 3 matrix, rows first, and its translation: NanoVDB.h, GridData and Map. Files and grids
    have marks of their own since OpenVDB 11, and each grid may be in a segment of its own."""
    data, found = open(path, "rb").read(), {}
    magic, _, count, codec = struct.unpack_from("<8sIHH", data)
    assert magic in (b"NanoVDB0", b"NanoVDB2") and codec == 0, (magic, codec)
    mark = b"NanoVDB0" if magic == b"NanoVDB0" else b"NanoVDB1"
    for at in [m.start() for m in re.finditer(mark, data) if m.start() > 0][:count if mark == magic else None]:
        name = data[at + 40:at + 296].split(b"\0")[0].decode()
        found[name] = struct.unpack_from("<9d", data, at + 384), struct.unpack_from("<3d", data, at + 528)
    return found

def place(matrix, shift, at):
    return [sum(matrix[3 * r + c] * at[c] for c in range(3)) + shift[r] for r in range(3)]

one, other, nano = sys.argv[1:]
transforms = maps(nano)
assert next(iter(transforms)).startswith("density"), list(transforms) # programs take the first grid
assert names(one) == names(other) and names(one), (names(one), names(other))
for name in names(one):
    a, b = vdb.read(one, name), vdb.read(other, name)
    box = a.evalActiveVoxelBoundingBox()
    assert box == b.evalActiveVoxelBoundingBox(), name
    (values, active), (others, actives) = voxels(a, box), voxels(b, box)
    assert active == actives, name
    scale = float(a["isoshade_direction_scale"]) if "isoshade_direction_scale" in a.metadata else 1.0
    assert (values.tobytes() == others.tobytes() if scale == 1 else
            # half floats, multiplied by 127/128 so that they are exact: divided they are the same again, but for one rounding
            numpy.allclose(values / numpy.float32(scale), others, rtol=2e-7, atol=0)), name
    assert values.any(), name
    assert a.background == b.background, name
    # NanoVDB has fog volumes of one channel.
    assert b.gridClass == (vdb.GridClass.UNKNOWN if isinstance(a.background, tuple) else a.gridClass), (name, b.gridClass)
    for at in ((0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1), (9, 7, 5)):
        wanted = a.transform.indexToWorld(at) # two roundings: sums in another order
        assert numpy.allclose(wanted, place(*transforms[name], at), rtol=1e-15, atol=1e-15 * max(map(abs, wanted))), (name, at)
print(len(names(one)), "grids")
END

if ! command -v nanovdb_validate >/dev/null || ! command -v nanovdb_convert >/dev/null; then
    skip nanovdb_validate_accepts_it "libnanovdb-tools is not installed"
elif ! "$python" -c 'import openvdb' 2>/dev/null && ! "$python" -c 'import pyopenvdb' 2>/dev/null; then
    skip nanovdb_validate_accepts_it "python3-openvdb is not installed"
else
    # It says what fails, and exits with 0 all the same.
    valid() { nanovdb_validate "$1" >valid.txt 2>&1 && [ ! -s valid.txt ]; }
    for file in v s b; do
        check "nanovdb_validate_accepts_$file" valid $file.nvdb
        check "nanovdb_convert_reads_$file" nanovdb_convert -f $file.nvdb $file.back.vdb
        check "the_grids_of_${file}_come_back" "$python" same.py $file.vdb $file.back.vdb $file.nvdb
    done
    # After the file's head of 385 bytes: the grids as NanoVDB's own conversion makes them, each after a head of its own.
    for grid in density gradient; do
        nanovdb_convert -f --checksum full --stats all --grid $grid v.vdb $grid.nvdb
    done
    size=$(($(stat -c %s density.nvdb) - 200))
    same_grid() { cmp -n $size -i "$1" "$2" "$3"; }
    check density_is_that_of_its_own_conversion same_grid 385:200 v.nvdb density.nvdb
    check gradient_too cmp -i $((385 + size)):201 v.nvdb gradient.nvdb
    nanovdb_print v.nvdb >print.txt 2>&1
    check names_types_and_classes bash -c "grep -q 'density *float *FOG' print.txt && grep -q 'gradient *Vec3f' print.txt && grep -q 'NONE' print.txt"
    notice another_files_grids "$python" same.py v.vdb b.back.vdb b.nvdb
    notice another_transform "$python" same.py v.vdb v.back.vdb s.nvdb
    # Our own reader of volumes finds the same volume; the unit's name alone is lost.
    "$ISOSHADE" info v.vdb >one.txt 2>&1 && "$ISOSHADE" info v.back.vdb >two.txt 2>&1
    check our_reader_finds_the_same_volume bash -c 'test "$(tail -n +2 one.txt | grep -v "^  unit")" = "$(tail -n +2 two.txt | grep -v "^  unit")" && grep -q "20 x 24 x 16" two.txt'
    # A byte in the middle of the values.
    cp v.nvdb damaged.nvdb && printf '\377' | dd of=damaged.nvdb bs=1 seek=$(($(stat -c %s v.nvdb) / 2)) conv=notrunc 2>/dev/null
    check a_byte_is_changed bash -c '! cmp -s v.nvdb damaged.nvdb'
    notice a_changed_byte valid damaged.nvdb
    notice a_changed_byte_of_the_grid cmp -i $((385 + size)):201 damaged.nvdb gradient.nvdb
fi

# Leaves are not kept: the memory is that of --to vdb, where each of the 2 million voxels takes 16 bytes in the file.
if has_peak; then
    "$ISOSHADE" make shells --size 128 --type uint8 -q -o large.nrrd
    less=$(peak "$ISOSHADE" export large.nrrd --to vdb --dense -q -o large.vdb)
    holds leaves_are_not_kept "$(peak "$ISOSHADE" export large.nrrd --to nanovdb --dense -q -o large.nvdb) - $less < 8192"
    holds their_bytes_would_be_seen "$(stat -c %s large.nvdb) > 4 * 8192 * 1024"
else
    skip leaves_are_not_kept "no /usr/bin/time, or a build with sanitizers, whose memory is another"
fi

refuse half_floats 2 "--half cannot be used with --to nanovdb" one --to nanovdb --half -o x.nvdb
refuse a_usda 2 "a .usda needs OpenVDB files" one --to nanovdb --scene "$scene" --for karma -o x.nvdb
refuse no_such_folder 3 "no/x.nvdb" one --to nanovdb -o no/x.nvdb
exit $failed
