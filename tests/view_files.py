# SPDX-License-Identifier: MIT
"""Untrusted files in the viewer's page: those that the page reads lie where `isoshade info` says and have
its values, all others are refused by a sentence that says why, and the page goes on.

make_files(FOLDER)             writes them
open_files(PAGE, FOLDER)       opens each in the page of chromium.py's Chromium; yields a sentence for each that goes wrong"""
import gzip
import json
import os
import struct
import subprocess
from array import array

SIZE = (5, 4, 3)
VALUES = [(37 * i * i + 11 * i) % 1200 - 300 for i in range(SIZE[0] * SIZE[1] * SIZE[2])]
AXES = ["dimension: 3", "sizes: 5 4 3"]
OBLIQUE = ["space directions: (1,0.2,0) (0.1,-1.4,0.3) (0,0.2,2.1)", "space origin: (-10,20.5,3)"]


def samples(letter="h", big=False, values=VALUES):
    data = array(letter, values)
    if big:
        data.byteswap()
    return data.tobytes()


def nrrd(fields, data, encoding="raw", end="\n"):
    if not any(field.startswith("spac") for field in fields):
        axes = next(int(field.split()[1]) for field in fields if field.startswith("dimension"))
        fields = [*fields, "spacings:" + " 1" * axes]
    lines = ["NRRD0004", *fields, f"encoding: {encoding}", "", ""]
    return end.join(lines).encode() + (gzip.compress(data, mtime=0) if encoding == "gzip" else data)


def nifti(data, kind=4, order="<", dims=(3, *SIZE), forms=(0, 1), slope=(0.0, 0.0), unit=2, pixdim=(1, 1, 1.5, 2), magic=b"n+1\0"):
    """forms: the codes of quaternion and matrix."""
    head = bytearray(352)
    put = lambda at, form, *values: struct.pack_into(order + form, head, at, *values)
    put(0, "i", 348)
    put(40, f"{len(dims)}h", *dims)
    put(70, "h", kind)
    put(76, "4f", *pixdim)
    put(108, "f", 352)
    put(112, "2f", *slope)
    put(123, "B", unit)
    put(252, "2h", *forms)
    put(256, "6f", 0.1, -0.2, 0.3, 4, 5, 6)
    put(280, "12f", -1.2, 0.3, 0, 10, 0.2, 1.5, 0.1, -20, 0, -0.1, 2, 5)
    head[344:348] = magic
    return bytes(head) + data


SHORT = ["type: short", "endian: little", *AXES]
FLOAT = ["type: float", "endian: little", *AXES]
GOOD = {
    "little.nrrd": nrrd([*SHORT, "spacings: 1 1.5 2"], samples()),
    "big.nrrd": nrrd(["type: short", "endian: big", *AXES], samples(big=True)),
    "big-float.nrrd": nrrd(["type: float", "endian: big", *AXES], samples("f", True), "gzip"),
    "long.nrrd": nrrd(["type: longlong", "endian: little", *AXES], samples("q")),
    "unsigned-long.nrrd": nrrd(["type: uint64", "endian: big", *AXES], samples("Q", True, [v + 300 for v in VALUES])),
    "double.nrrd": nrrd(["type: double", "endian: little", *AXES], samples("d")),
    "lines-of-windows.nrrd": nrrd(SHORT, samples(), end="\r\n"),
    "keys.nrrd": nrrd(["# a comment: no field", *SHORT, "sizes:=9 9 9"], samples()),
    "left-posterior.nrrd": nrrd([*SHORT, "space: left-posterior-superior", *OBLIQUE], samples()),
    "left-anterior.nrrd": nrrd([*SHORT, "space: LAS", *OBLIQUE], samples()),
    "no-origin.nrrd": nrrd([*SHORT, "space dimension: 3", OBLIQUE[0]], samples()),
    "micrometers.nrrd": nrrd([*SHORT, "space: RAS", 'space units: "um" "um" "um"', *OBLIQUE], samples()),
    "centimeters.nrrd": nrrd([*SHORT, "spacings: .1 .2 .3", 'units: "cm" "cm" "cm"'], samples()),
    "corner.nrrd": nrrd([*SHORT, "spacings: 1 2 3", "axis mins: 5 6 7", "centers: cell node cell"], samples()),
    "slope.nrrd": nrrd([*SHORT, "scale_slope:=0.5", "scale_intercept:=-7"], samples()),
    "four-axes.nrrd": nrrd(["type: short", "endian: little", "dimension: 4", "sizes: 5 4 3 1"], samples()),
    "skip.nrrd": nrrd([*SHORT, "line skip: 2", "byte skip: 3"], b"a\nb\nxyz" + samples()),
    "at-the-end.nrrd": nrrd([*SHORT, "byte skip: -1"], b"xyz" + samples()),
    "constant.nrrd": nrrd(["type: uchar", *AXES], bytes(60)),
    "not-a-number.nrrd": nrrd(FLOAT, samples("f", values=[float("nan"), *VALUES[1:]])),
    "matrix.nii": nifti(samples()),
    "big.nii.gz": gzip.compress(nifti(samples(big=True), order=">"), mtime=0),
    "slope.nii.gz": gzip.compress(nifti(samples(), slope=(0.5, -100.25)), mtime=0),
    "quaternion.nii": nifti(samples(), forms=(1, 0), pixdim=(-1, 1, 1.5, 2)),
    "spacings.nii": nifti(samples("f"), kind=16, forms=(0, 0)),
    "negative.nii": nifti(samples(), forms=(1, 0), pixdim=(1, 1, -1.5, 2)),
    "mirrored.nii": nifti(samples(), forms=(0, 0), pixdim=(1, -1, 1.5, 2)),
    "long.nii": nifti(samples("q"), kind=1024),
    "micrometers.nii": nifti(samples(), unit=3),
    "one-time-step.nii": nifti(samples(), dims=(4, *SIZE, 1)),
}
CUT = gzip.compress(nifti(samples()), mtime=0)
BAD = {  # and a word of what the page says of it
    "empty.nrrd": (b"", "is empty"),
    "text.nii": (b"hello, world\n" * 40, "neither NRRD nor NIfTI"),
    "short.nrrd": (nrrd(SHORT, samples()[:-20]), "the file ends after"),
    "no-end.nrrd": (b"NRRD0004\ntype: short\nsizes: 5 4 3", "header does not end"),
    "damaged.nrrd": (nrrd(SHORT, samples(), "gzip")[:-60] + b"no gzip data" * 5, "compressed bytes are damaged"),
    "cut.nii.gz": (CUT[:len(CUT) // 2], "compressed bytes are damaged"),
    "infinite.nrrd": (nrrd(FLOAT, samples("f", values=[float("inf"), *VALUES[1:]])), "1 of 60 voxels are infinite"),
    "no-data.nrrd": (nrrd(FLOAT, samples("f", values=[float("nan")] * 60)), "no voxel has data"),
    "flat.nrrd": (nrrd([*SHORT, "space dimension: 3", "space directions: (1,0,0) (2,0,0) (0,0,1)"], samples()), "span no volume"),
    "huge.nrrd": (nrrd(["type: short", "endian: little", "dimension: 3", "sizes: 70000 70000 70000"], samples()), "are needed"),
    "negative.nrrd": (nrrd(["type: short", "endian: little", "dimension: 3", "sizes: -5 4 3"], samples()), "each must be at least 1"),
    "colors.nrrd": (nrrd(["type: uchar", "dimension: 4", "sizes: 3 5 4 3", "kinds: RGB-color domain domain domain"], bytes(180)), "4 axes"),
    "spacings.nrrd": (nrrd([*SHORT, "spacings: 1 nan 1"], samples()), "does not state the spacing"),
    "no-step.nii": (nifti(samples(), forms=(0, 0), pixdim=(1, 1, 0, 2)), "does not state the spacing"),
    "furlongs.nrrd": (nrrd([*SHORT, 'units: "furlong" "mm" "mm"', "spacings: 1 1 1"], samples()), "furlong"),
    "detached.nrrd": (nrrd([*SHORT, "data file: x.raw"], b""), "another file"),
    "short.nii": (nifti(samples())[:400], "the file ends after"),
    "header.nii": (nifti(b"", magic=b"ni1\0"), "another file"),
    "colors.nii": (nifti(bytes(180), kind=128), "data type 128"),
}


def make_files(folder):
    for name, data in {**GOOD, **{name: data for name, (data, _) in BAD.items()}}.items():
        with open(os.path.join(folder, name), "wb") as f:
            f.write(data)


def differs(shown, told):
    """What the page has and the program does not, or None. Floats of a file are floats in the page."""
    for key, here, there in (("size", shown["size"], told["size"]), ("origin", shown["origin"], told["origin_mm"]),
                             ("axes", sum(shown["axes"], []), sum(told["index_to_world_mm"], [])), ("range", shown["range"], [told["min"], told["max"]])):
        most = max(map(abs, there))
        if not all(abs(a - b) <= 1e-6 * most for a, b in zip(here, there)):
            return f"{key} {here}, isoshade info says {there}"
    return None


def open_files(page, folder, program):
    root = page.call("DOM.getDocument")["root"]["nodeId"]
    chooser = page.call("DOM.querySelector", nodeId=root, selector="#open")["nodeId"]
    for name in [*BAD, *GOOD]:
        path = os.path.abspath(os.path.join(folder, name))
        page.evaluate("document.querySelector('#message span').textContent = ''")
        page.call("DOM.setFileInputFiles", nodeId=chooser, files=[path])
        page.wait(f"isoshade.data.title === '{name}' || /^{name}: /.test(document.querySelector('#message span').textContent)")
        page.evaluate("isoshade.frames.settled()")
        said = page.evaluate("document.querySelector('#message span').textContent")
        told = subprocess.run([program, "info", path, "--json"], capture_output=True, text=True, check=False)
        if name in BAD:  # info shows the first channel of colors; what draws them asks for one
            drawn = subprocess.run([program, "tf", "suggest", path, "-q"], capture_output=True, check=False)
            if drawn.returncode == 0 or BAD[name][1] not in said:
                yield f"{name}: the page says {said!r}, the program ended with {drawn.returncode}"
        elif said or told.returncode != 0:
            yield f"{name}: the page says {said!r}, the program {told.stderr!r}"
        else:
            shown = page.evaluate("(g => ({size: g.size, axes: g.index_to_world, origin: g.origin_mm, range: isoshade.data.value_range}))(isoshade.data.geometry)")
            wrong = differs(shown, json.loads(told.stdout))
            if wrong:
                yield f"{name}: {wrong}"
