# SPDX-License-Identifier: MIT
"""Every type, byte order, packing and layout of a format, as other programs write them. Cases of formats_in.py.

The volumes are tiny, have three sizes and spacings, and each voxel has a value of its own. After each file the comparison
has to find what a wrong reader would give: planted() has the faults.
"""
import itertools
import json
import os
import shutil
import struct
import subprocess

import numpy as np

from phantom import case, expect, must_choose, refused, run

SIZE = (5, 4, 3)
SPACING = np.array([0.75, 0.5, 2.5])
SAY = ["--spacing", "0.75x0.5x2.5"]
STORED = {"uint8": "u1", "int8": "i1", "uint16": "<u2", "int16": "<i2", "float": "<f4"}


def values_of(dtype, size=SIZE):
    """[z, y, x]: no two are equal, all are floats, and no sample is its own mirror image."""
    kind = np.dtype(dtype)
    i = np.arange(int(np.prod(size))).reshape(size[::-1])
    by = {"u1": 4, "i1": 4, "u2": 1001, "i2": 1001, "u4": 70001, "i4": 70001, "u8": 70001, "i8": 70001}
    name = kind.kind + str(kind.itemsize)
    if kind.kind == "f":
        return (i * 0.25 - 5.5).astype(kind)
    return (i * by[name] + 3 - (by[name] * i.size // 2 if kind.kind == "i" else 0)).astype(kind)


def as_read(values):
    """What a pyramid has of them: floats of what has more than 16 bits, or halves."""
    kind = values.dtype
    small = kind.kind in "iu" and kind.itemsize <= 2
    return values.astype(kind.newbyteorder("=") if small else np.float32)


def read(path, options=()):
    """Samples [z, y, x] and steps: by one start of the program."""
    shutil.rmtree("matrix.iso", ignore_errors=True)
    got = run("build", path, "--levels", "1", "-q", "--no-labels", "-o", "matrix.iso", *options)
    expect(got.returncode == 0, f"{path}: exit code {got.returncode}: {got.stderr.strip()}")
    with open("matrix.iso/pyramid.json", encoding="utf-8") as file:
        level = json.load(file)["levels"][0]
    with open(os.path.join("matrix.iso", level["files"]["scalar"]["name"]), "rb") as file:
        data = file.read()
    g = level["geometry"]
    samples = np.frombuffer(data, STORED[level["stored_type"]], offset=data.index(b"\n\n") + 2)
    return samples[samples.size - int(np.prod(g["size"])):].reshape(g["size"][::-1]), np.array(g["index_to_world"]).reshape(3, 3)


def difference(got, steps, values, wanted):
    if got.shape != values.shape or got.dtype != values.dtype:
        return f"{got.dtype} {got.shape}, not {values.dtype} {values.shape}"
    if not np.array_equal(got, values):
        return f"{(got != values).sum()} of {values.size} values differ, {got.flat[0]} and not {values.flat[0]}"
    if not np.allclose(steps, wanted, rtol=1e-6, atol=1e-6 * np.abs(wanted).max()):
        return f"steps {steps.tolist()}, not {np.asarray(wanted).tolist()}"
    return ""


def planted(got, steps):
    """What readers with a fault would give."""
    if got.dtype.itemsize > 1:
        yield "swapped bytes", got.byteswap(), steps
    yield "swapped axes", np.ascontiguousarray(got.T).reshape(got.shape), steps
    yield "reversed rows", got[:, ::-1], steps
    yield "a slice of its neighbor", got[[0, *range(got.shape[0] - 1)]], steps
    yield "an ignored slope", got * got.dtype.type(2), steps
    if got.dtype.kind in "iu":
        yield "the other sign", got.view(got.dtype.str.replace("i", "x").replace("u", "i").replace("x", "u")), steps
    yield "spacing by its presence", got, np.eye(3)


def without_data(path, count, *options):
    got = run("info", path, *SAY, *options, "--json")
    expect(got.returncode == 0 and json.loads(got.stdout)["no_data_voxels"] == count, got.stdout + got.stderr)


def check(path, values, steps=None, options=(), what=""):
    wanted = np.diag(SPACING) if steps is None else steps
    values = as_read(values)
    got, got_steps = read(path, options)
    wrong = difference(got, got_steps, values, wanted)
    expect(not wrong, f"{path} {what}: {wrong}")
    for name, other, other_steps in planted(got, got_steps):
        expect(difference(other, other_steps, values, wanted), f"{path} {what}: {name} would not be found")


TYPES = "u1", "i1", "u2", "i2", "u4", "i4", "u8", "i8", "f4", "f8"


# ---- TIFF by tifffile and libtiff's tiffcp ----

def write_bits(path, values, bits):
    """values [z, y, x], without gaps within a row: the plain form, of which tiffcp makes others."""
    data, before = bytearray(b"II*\0\0\0\0\0"), 4
    for page in values:
        rows = ["".join(f"{v:0{bits}b}" for v in row) for row in page]
        samples = b"".join(int(row.ljust(-(-len(row) // 8) * 8, "0"), 2).to_bytes(-(-len(row) // 8), "big") for row in rows)
        at, height, width = len(data), *page.shape
        data += samples + bytes(len(samples) % 2)
        struct.pack_into("<I", data, before, len(data))
        tags = {256: width, 257: height, 258: bits, 259: 1, 262: 1, 273: at, 277: 1, 278: height, 279: len(samples)}
        data += struct.pack("<H", len(tags)) + b"".join(struct.pack("<HHII", tag, 4, 1, v) for tag, v in tags.items())
        before = len(data)
        data += bytes(4)
    with open(path, "wb") as file:
        file.write(data)


@case
def matrix_tiff():
    import tifffile
    for dtype, order in itertools.product((*TYPES, "f2"), "<>"):
        values = values_of(dtype)
        tifffile.imwrite("type.tif", values.astype(np.dtype(dtype).newbyteorder(order)), photometric="minisblack",
                         byteorder=order)
        check("type.tif", values, None, SAY, f"{dtype} {order}")
    size = (37, 21, 2)  # more than a tile along each axis
    for dtype in "u1", "u2", "f4":
        values = values_of(dtype, size) if dtype != "u1" else (np.arange(37 * 21 * 2) * 7 % 251).astype("u1").reshape(2, 21, 37)
        tifffile.imwrite("plain.tif", values, photometric="miniswhite" if dtype == "u2" else "minisblack")
        difference_of = "3" if dtype[0] == "f" else "2"
        for number, packing in enumerate(("none", "lzw", "zip", "packbits", "zstd", "lzma", f"lzw:{difference_of}", f"zip:{difference_of}")):
            for layout in (["-s", "-r", "4"], ["-t", "-w", "16", "-l", "16", "-8"])[number % 2:number % 2 + 1 + (dtype == "u2")]:
                made = subprocess.run(["tiffcp", "-c", packing, *layout, *(["-B"] if packing == "zip" else []), "plain.tif", "more.tif"],
                                      capture_output=True, text=True)
                expect(made.returncode == 0, f"tiffcp -c {packing} {layout}: {made.stderr}")
                check("more.tif", tifffile.imread("more.tif") if packing == "none" else values, None, SAY, f"{dtype} {packing} {layout}")
    both = np.stack([values_of("i2"), values_of("i2") + 7], 1)  # [z, c, y, x]
    for planar, layout in itertools.product(("separate", "contig"), ({}, {"tile": (16, 16)})):
        data = both if planar == "separate" else np.moveaxis(both, 1, -1)
        with tifffile.TiffWriter("planes.tif") as file:
            for page in data:
                file.write(np.ascontiguousarray(page), photometric="minisblack", planarconfig=planar, metadata=None, **layout)
        for channel in 0, 1:
            check("planes.tif", both[:, channel], None, [*SAY, "--channel", str(channel)], f"{planar} {layout}")
    colors = np.stack([values_of("u1") // k for k in (1, 2, 3)], 1)  # [z, c, y, x]
    weighed = np.einsum("zcyx,c->zyx", colors.astype(float), [0.2126, 0.7152, 0.0722]).astype(np.float32)
    for planar in "separate", "contig":
        data = colors if planar == "separate" else np.moveaxis(colors, 1, -1)
        with tifffile.TiffWriter("colors.tif") as file:
            for page in data:
                file.write(np.ascontiguousarray(page), photometric="rgb", planarconfig=planar, metadata=None)
        check("colors.tif", weighed, None, [*SAY, "--channel", "luminance"], f"luminance {planar}")
        check("colors.tif", colors[:, 1], None, [*SAY, "--channel", "green"], f"green {planar}")
    tifffile.imwrite("one.tif", values_of("u2"), planarconfig="separate", photometric="minisblack", metadata=None)
    must_choose("one.tif", "one page of 3 planes, which are channels: --channel K chooses one", SAY)
    tifffile.imwrite("deep.tif", np.zeros((16, 16, 16), "u2"), photometric="minisblack", volumetric=True, tile=(16, 16, 16))
    refused("deep.tif", 4, "has 16 slices in a page (ImageDepth), which is not read", SAY)
    tifffile.imwrite("complex.tif", np.zeros((3, 4, 5), "c8"), photometric="minisblack")
    refused("complex.tif", 4, "samples of 64 bits, format 6, must be a gray integer", SAY)
    for bits, packing in itertools.product((1, 4, 12), ("none", "zip")):
        values = (np.arange(60) * 7 % 2 ** bits).reshape(3, 4, 5).astype("u2" if bits > 8 else "u1")
        write_bits("bits.tif", values, bits)
        made = subprocess.run(["tiffcp", "-c", packing, "bits.tif", "more.tif"], capture_output=True, text=True)
        expect(made.returncode == 0, made.stderr)
        got, steps = read("more.tif", SAY)
        expect(not difference(got, steps, values, np.diag(SPACING)), f"{bits} bits: {difference(got, steps, values, np.diag(SPACING))}")


# ---- NIfTI by nibabel ----

@case
def matrix_nifti():
    import nibabel
    turn = np.array([[0, -1, 0], [1, 0, 0], [0, 0, 1]]) * SPACING
    affine = np.eye(4)
    affine[:3, :3] = turn
    containers = itertools.cycle(((nibabel.Nifti1Image, "m.nii"), (nibabel.Nifti2Image, "m.nii.gz"), (nibabel.Nifti1Pair, "m.img"),
                                  (nibabel.Nifti2Image, "m.nii"), (nibabel.Nifti1Image, "m.nii.gz"), (nibabel.Nifti1Pair, "m.img.gz")))
    places = itertools.cycle(("sform", "qform", "both", "none"))
    scales = itertools.cycle(((None, None), (0.5, -3), (-2, 0.25), (1, 8), (None, None)))
    for dtype, order, _ in itertools.product(TYPES, "<>", range(2)):
        (kind, name), place, (slope, shift) = next(containers), next(places), next(scales)
        values = values_of(dtype)
        header = kind.header_class(endianness=order)
        header.set_data_dtype(np.dtype(dtype).newbyteorder(order))
        image = kind(values.T, affine, header)
        image.set_sform(affine, 1 if place in ("sform", "both") else 0)
        image.set_qform(affine, 1 if place in ("qform", "both") else 0)
        image.header.set_zooms(SPACING)
        nibabel.save(image, name)
        path = name.replace(".img", ".hdr")
        if slope is not None:  # nibabel scales what it saves: the numbers alone
            with nibabel.openers.Opener(path) as file:
                data = bytearray(file.read())
            at, form = (112, "ff") if kind is not nibabel.Nifti2Image else (176, "dd")
            struct.pack_into(order + form, data, at, slope, shift)
            with nibabel.openers.Opener(path, "wb") as file:
                file.write(bytes(data))
        again = nibabel.load(name)
        stored = np.asanyarray(again.dataobj.get_unscaled()).T
        expect(np.array_equal(stored, values) and again.header.endianness == order, f"nibabel reads {name} otherwise")
        scaled = stored if slope is None else (slope * stored.astype(np.float64) + shift).astype(np.float32)
        expect(np.allclose(again.get_fdata().T, scaled, rtol=1e-6), f"nibabel scales {name} otherwise")
        check(path, scaled, np.diag(SPACING) if place == "none" else turn, (), f"{dtype} {order} {place} {slope}")
    # Large integers of 64 bits, and unsigned ones beyond those of 31.
    for values in (np.arange(60).reshape(3, 4, 5) - 9) << 40, np.arange(60).reshape(3, 4, 5) * 2**20 + 2**31:
        nibabel.save(nibabel.Nifti1Image(values.T.astype(np.int64), affine, dtype="int64"), "wide.nii")
        check("wide.nii", values, turn, (), "int64")
    values = values_of("i2")
    image = nibabel.Nifti1Image(values.T, affine)
    image.set_sform(affine, 0)
    image.set_qform(affine, 1)
    nibabel.save(image, "header.nii")
    with open("header.nii", "rb") as file:
        good = bytes(file.read())

    def changed(*changes):
        data = bytearray(good)
        for form, at, *numbers in changes:
            struct.pack_into("<" + form, data, at, *numbers)
        with open("header.nii", "wb") as file:
            file.write(data)
        return "header.nii"

    negative = ("fff", 80, *(-SPACING))
    check(changed(negative), values, turn, (), "negative pixdim")
    check(changed(negative, ("h", 252, 0)), values, np.diag(SPACING), (), "negative pixdim alone")
    for number, says in (0.0, "spacing along axis 2 is 0 mm"), (np.inf, "spacing along axis 2 is inf mm"), (
            np.nan, "does not state the spacing along its axis 2"):
        for code in 0, 1:
            refused(changed(("f", 84, number), ("h", 252, code)), 4, says)
            check(changed(("f", 84, number), ("h", 252, code)), values, turn if code else None, SAY)
    zeros = ("h", 254, 1), ("12f", 280, *[0.0] * 12)
    refused(changed(*zeros), 4, "its sform (code 1) has an axis of zeros")
    check(changed(*zeros), values, turn, SAY, "sform of zeros")


# ---- NRRD by teem ----

@case
def matrix_nrrd():
    names = {"u1": "uchar", "i1": "signed char", "u2": "ushort", "i2": "short", "u4": "uint", "i4": "int", "u8": "ulonglong",
             "i8": "longlong", "f4": "float", "f8": "double"}

    def header(dtype, *more, endian="little", spacings="spacings: 0.75 0.5 2.5"):
        lines = ["NRRD0005", f"type: {names[dtype]}", "dimension: 3", "sizes: 5 4 3", spacings, f"endian: {endian}",
                 "encoding: raw", *more]
        return "\n".join(line for line in lines if line) + "\n"

    for dtype, endian in itertools.product(TYPES, ("little", "big")):
        values = values_of(dtype)
        stored = values.astype(np.dtype(dtype).newbyteorder("<" if endian == "little" else ">"))
        with open("data.raw", "wb") as file:
            file.write(b"first line\nsecond one\n" + b"\xff" * 5 + stored.tobytes())
        for number, skip in enumerate((["line skip: 2", "byte skip: 5"], ["byte skip: 27"], ["byte skip: -1"])):
            with open("m.nhdr", "w", encoding="ascii") as file:
                file.write(header(dtype, *skip, "data file: data.raw", endian=endian))
            if number == 0 or endian == "big":
                check("m.nhdr", values, None, (), f"{dtype} {endian} {skip}")
        with open("attached.nrrd", "wb") as file:
            file.write(header(dtype, endian=endian).encode() + b"\n" + stored.tobytes())
        encodings = ("raw", "gzip") if endian == "little" else ("bzip2", "ascii", "hex")
        for encoding in encodings:
            for name in ("m.nrrd", "m.nhdr")[:1 if encoding in ("ascii", "hex") else 2]:
                order = [] if encoding == "ascii" else ["-en", endian]  # unu writes numbers of swapped bytes as text
                made = subprocess.run(["teem-unu", "save", "-f", "nrrd", "-e", encoding, *order, "-i", "attached.nrrd", "-o", name],
                                      capture_output=True, text=True)
                expect(made.returncode == 0, f"unu save -e {encoding}: {made.stderr}")
                check(name, values, None, (), f"{dtype} {endian} {encoding}")
    stored = values_of("i2").tobytes()
    for spacings, says in (("", "does not state the spacing of its voxels"), ("spacings: 0.75 0.5 nan", "spacing between its slices"),
                           ("spacings: 0.75 -0.5 2.5", "spacing along axis 2 is -0.5 mm"),
                           ("space dimension: 3\nspace directions: (1,0,0) (0,1,0) (0,0,0)", "spacing along axis 3 is 0 mm")):
        with open("spacing.nrrd", "wb") as file:
            file.write(header("i2", spacings=spacings).encode() + b"\n" + stored)
        refused("spacing.nrrd", 4, says)
        check("spacing.nrrd", values_of("i2"), None, SAY, spacings)


# ---- VTK's image data by VTK ----

@case
def matrix_vti():
    import vtk
    from vtk.util import numpy_support

    def image(values, of_cells):
        made = vtk.vtkImageData()
        made.SetDimensions([n + of_cells for n in values.shape[::-1]])
        made.SetSpacing(SPACING)
        array = numpy_support.numpy_to_vtk(values.ravel(), deep=True)
        array.SetName("values")
        (made.GetCellData() if of_cells else made.GetPointData()).SetScalars(array)
        return made

    def write(writer, values, of_cells=False):
        writer.SetInputData(image(values, of_cells))
        writer.SetFileName("m.vti")
        writer.Write()

    number = 0
    for dtype in TYPES:
        # text, base64 inline, appended in base64 and raw; packed or not, lengths of 32 and 64 bits, both byte orders
        for (mode, encode), pack, wide, big in itertools.product(((0, 0), (1, 0), (2, 1), (2, 0)), (0, 1), (0, 1), (0, 1)):
            number += 1
            if (mode == 0 and (pack or wide or big)) or (dtype not in ("i2", "f8") and number % 5):
                continue
            writer = vtk.vtkXMLImageDataWriter()
            writer.SetDataMode(mode)
            writer.SetEncodeAppendedData(encode)
            (writer.SetCompressorTypeToZLib if pack else writer.SetCompressorTypeToNone)()
            writer.SetBlockSize(64)
            (writer.SetHeaderTypeToUInt64 if wide else writer.SetHeaderTypeToUInt32)()
            (writer.SetByteOrderToBigEndian if big else writer.SetByteOrderToLittleEndian)()
            values = values_of(dtype)
            write(writer, values, number % 2 == 0)
            check("m.vti", values, None, (), f"{dtype} mode {mode} {encode} packed {pack} wide {wide} big {big}")
    for pack in "LZ4", "LZMA":
        writer = vtk.vtkXMLImageDataWriter()
        getattr(writer, f"SetCompressorTypeTo{pack}")()
        write(writer, values_of("i2"))
        check("m.vti", values_of("i2"), None, (), pack)
    for dtype, text in itertools.product(TYPES, (False, True)):
        if text and dtype in ("u1", "u8", "i8"):  # bytes as text are colors to VTK
            continue
        writer = vtk.vtkStructuredPointsWriter()
        (writer.SetFileTypeToASCII if text else writer.SetFileTypeToBinary)()
        writer.SetInputData(image(values_of(dtype), text))
        writer.SetFileName("m.vtk")
        writer.Write()
        check("m.vtk", values_of(dtype), None, (), f"legacy {dtype} {text}")
    for spacing, says in ("1 0 1", "spacing along axis 2 is 0 mm"), ("1 1 -2", "spacing along axis 3 is -2 mm"), ("1 nan 1", "spacing"):
        write(vtk.vtkXMLImageDataWriter(), values_of("i2"))
        with open("m.vti", "rb") as file:
            data = file.read()
        with open("m.vti", "wb") as file:
            file.write(data.replace(b'Spacing="0.75 0.5 2.5"', f'Spacing="{spacing}"'.encode()))
        refused("m.vti", 4, says)
        check("m.vti", values_of("i2"), None, SAY, spacing)


# ---- Zarr 2 by zarr and numcodecs ----

@case
def matrix_zarr():
    import numcodecs
    import zarr
    codecs = [None, numcodecs.Zlib(), numcodecs.GZip(), numcodecs.Zstd(), numcodecs.BZ2(), numcodecs.LZMA()] + [
        numcodecs.Blosc(name, shuffle=shuffle)
        for name, shuffle in itertools.product(("blosclz", "lz4", "lz4hc", "zlib", "zstd"), (0, 1, 2))]
    new = zarr.__version__[0] > "2"

    def array(values, codec, order="C", separator=".", dtype=None, fill=0, chunks=(2, 3, 2)):
        shutil.rmtree("m.zarr", ignore_errors=True)
        how = {"shape": values.shape, "chunks": chunks, "dtype": dtype or values.dtype, "order": order, "fill_value": fill}
        if new:
            made = zarr.create_array("m.zarr", zarr_format=2, compressors=codec,
                                     chunk_key_encoding={"name": "v2", "separator": separator}, **how)
        else:
            made = zarr.open_array("m.zarr", mode="w", compressor=codec, dimension_separator=separator, **how)
        made[...] = values
        return made

    types = itertools.cycle((*TYPES, "f2"))
    for number, codec in enumerate([*codecs, *codecs[:5]]):
        dtype, order = next(types), "<>"[number % 2]
        made = array(values_of(dtype), codec, "CF"[number // 2 % 2], "./"[number // 3 % 2], np.dtype(dtype).newbyteorder(order))
        expect(np.array_equal(made[...], values_of(dtype)), "zarr reads it otherwise")
        check("m.zarr", values_of(dtype), None, SAY, f"{dtype} {order} {codec}")
    values = values_of("i2")
    for fill, separator in (0, "."), (-31, "/"):  # a chunk that was never written
        made = array(values, None, separator=separator, fill=fill)
        os.remove(f"m.zarr/1{separator}0{separator}1")
        check("m.zarr", made[...], None, SAY, f"fill {fill}")
    array(values_of("f4"), None, fill=-9999)
    os.remove("m.zarr/1.0.1")
    without_data("m.zarr", 6)
    array(values, numcodecs.LZ4())
    check("m.zarr", values, None, SAY, "lz4")
    zeros = np.zeros((256, 256, 128), "u1")
    zeros[3, 2, 1] = 7
    array(zeros, numcodecs.BZ2(), chunks=(256, 256, 64))  # a chunk of nothing: 45 bytes
    check("m.zarr", zeros, None, SAY, "bz2 of zeros")
    for dtype in ("<i2", ">u4", "|u1", "<f8", "<i8") if not new else ():
        shutil.rmtree("m.zarr", ignore_errors=True)
        made = zarr.open_array("m.zarr", mode="w", shape=values.shape, chunks=(2, 3, 2), dtype=dtype, fill_value=0,
                               filters=[numcodecs.Delta(dtype)], compressor=numcodecs.LZ4())
        made[...] = values_of(dtype[1:])
        check("m.zarr", values_of(dtype[1:]), None, SAY, f"delta {dtype}")
    for dtype in ("<f4", "<f8", ">f4") if not new else ():
        rounders = [numcodecs.Quantize(2, dtype)] + ([numcodecs.BitRound(7)] if dtype[0] == "<" else [])
        for rounder in rounders:
            shutil.rmtree("m.zarr", ignore_errors=True)
            made = zarr.open_array("m.zarr", mode="w", shape=values.shape, chunks=(2, 3, 2), dtype=dtype, fill_value=0,
                                   filters=[rounder], compressor=numcodecs.LZ4())
            made[...] = values_of(dtype[1:])
            check("m.zarr", np.asarray(made[...]), None, SAY, f"{rounder.codec_id} {dtype}")
    shutil.rmtree("m.zarr", ignore_errors=True)
    array(values, None)
    with open("m.zarr/.zarray", encoding="utf-8") as file:
        about = json.load(file)
    for key, value, why in (
            ("compressor", {"id": "zfpy"}, 'packed by "zfpy", must be blosc, bz2, gzip, lz4, lzma, zlib, zstd or nothing'),
            ("filters", [{"id": "packbits"}], 'filtered by "packbits", must be bitround, delta, quantize or nothing'),
            ("filters", [{"id": "quantize", "digits": 2, "dtype": "<f8", "astype": "<f4"}],
             'filtered by quantize of the types "<f8" and "<f4", must be that of the array'),
            ("filters", [{"id": "delta", "dtype": "<i4"}], 'filtered by delta of the types "<i4" and ""')):
        with open("m.zarr/.zarray", "w", encoding="utf-8") as file:
            json.dump({**about, key: value}, file)
        refused("m.zarr", 4, why, SAY)


def write_zarr3(values, codecs, pack, chunk=(2, 3, 2), shard=None, v2_keys=False, **more):
    """By the specification of Zarr 3: a file per chunk, or per shard with an index at its end."""
    names = {"b": "bool", "u": "uint", "i": "int", "f": "float"}
    name = names[values.dtype.kind] + ("" if values.dtype.kind == "b" else str(8 * values.dtype.itemsize))
    shutil.rmtree("m3.zarr", ignore_errors=True)
    os.makedirs("m3.zarr")
    outer = shard or chunk
    if shard:
        codecs = [{"name": "sharding_indexed", "configuration": {
            "chunk_shape": chunk, "codecs": codecs, "index_location": more.get("index", "end"),
            "index_codecs": [{"name": "bytes", "configuration": {"endian": "little"}}, {"name": "crc32c"}]}}]
    about = {"zarr_format": 3, "node_type": "array", "shape": values.shape, "data_type": name, "fill_value": 0,
             "chunk_grid": {"name": "regular", "configuration": {"chunk_shape": outer}},
             "chunk_key_encoding": {"name": "v2" if v2_keys else "default"}, "codecs": codecs, "attributes": {}}
    with open("m3.zarr/zarr.json", "w", encoding="utf-8") as file:
        json.dump({**about, "dimension_names": ["z", "y", "x"]}, file)

    def piece(at, of):
        full = np.zeros(of, values.dtype)
        part = values[tuple(slice(i * n, (i + 1) * n) for i, n in zip(at, of))]
        full[tuple(slice(0, n) for n in part.shape)] = part
        return full

    for at in itertools.product(*(range(-(-n // c)) for n, c in zip(values.shape, outer))):
        block = piece(at, outer)
        if shard:
            body, index = b"", b""
            start = 16 * int(np.prod([s // c for s, c in zip(shard, chunk)])) + 4 if more.get("index") == "start" else 0
            for inner in itertools.product(*(range(s // c) for s, c in zip(shard, chunk))):
                part = block[tuple(slice(i * c, (i + 1) * c) for i, c in zip(inner, chunk))]
                packed = pack(part) if part.any() else b""
                index += struct.pack("<QQ", start + len(body), len(packed)) if packed else b"\xff" * 16
                body += packed
            data = index + b"\0" * 4 + body if start else body + index + b"\0" * 4
        else:
            data = pack(block)
        path = "m3.zarr/" + (".".join(map(str, at)) if v2_keys else "c/" + "/".join(map(str, at)))
        os.makedirs(os.path.dirname(path), exist_ok=True)
        with open(path, "wb") as file:
            file.write(data)


@case
def matrix_zarr3():
    import numcodecs
    little, big = ({"name": "bytes", "configuration": {"endian": e}} for e in ("little", "big"))
    packers = [([], bytes), *(([{"name": c.codec_id}], c.encode) for c in (
        numcodecs.GZip(), numcodecs.Zstd(), numcodecs.BZ2(), numcodecs.LZMA(), numcodecs.Blosc("zstd", shuffle=1))),
               ([{"name": "crc32c"}], lambda b: b + b"\0" * 4)]
    forms = [{}, {"shard": (4, 6, 4)}, {"v2_keys": True}, {"shard": (4, 3, 6), "index": "start"}]
    for dtype, (codecs, encode), form, order in zip((*TYPES, "f2") * 2, itertools.cycle(packers), itertools.cycle(forms),
                                                    itertools.cycle((little, big, little))):
        values = values_of(dtype)

        def pack(block, to="<" if order is little else ">", encode=encode):
            return bytes(encode(block.astype(block.dtype.newbyteorder(to)).tobytes()))
        write_zarr3(values, [order, *codecs], pack, **form)
        check("m3.zarr", values, None, SAY, f"{dtype} {codecs} {form}")
    write_zarr3(values_of("i2"), [{"name": "transpose", "configuration": {"order": [2, 1, 0]}}, little],
                lambda block: block.T.tobytes())
    check("m3.zarr", values_of("i2"), None, SAY, "transposed")
    write_zarr3(values_of("i2"), [{"name": "transpose", "configuration": {"order": [0, 2, 1]}}, little], bytes)
    refused("m3.zarr", 4, "a transposition that is not a reversal of all axes", SAY)
    write_zarr3(values_of("i2"), [little, {"name": "zfpy"}], lambda block: block.tobytes())
    refused("m3.zarr", 4, 'packed by "zfpy", must be', SAY)
    write_zarr3(values_of("i2"), [little], lambda block: block.tobytes(), shard=(4, 6, 4))
    with open("m3.zarr/c/0/0/0", "r+b") as file:  # an index beyond the file's end
        file.seek(-20, 2)
        file.write(struct.pack("<Q", 1 << 60))
    got = run("build", "m3.zarr", *SAY, "-q", "-o", "matrix.iso")
    expect(got.returncode == 4 and "damaged: a chunk at byte" in got.stderr, got.stderr)


# ---- MRC by mrcfile ----

@case
def matrix_mrc():
    import mrcfile
    steps = np.diag(SPACING) * 1e-7

    def write(values, extended=0, change=None):
        with mrcfile.new("m.mrc", overwrite=True) as file:
            file.set_data(values)
            file.set_volume()
            file.voxel_size = tuple(SPACING)
            if extended:
                file.set_extended_header(np.arange(extended, dtype=np.uint8))
            if change:
                change(file.header)

    for (dtype, mode), order, extended in itertools.product((("i1", 0), ("i2", 1), ("f4", 2), ("u2", 6), ("f2", 12)), "<>", (0, 768)):
        values = values_of(dtype)
        write(values.astype(np.dtype(dtype).newbyteorder(order)), extended)
        with mrcfile.open("m.mrc") as file:
            expect(file.header.mode == mode and np.array_equal(file.data, values), f"mrcfile reads mode {mode} otherwise")
        check("m.mrc", values, steps, (), f"mode {mode} {order} {extended}")
    for turn in itertools.permutations((0, 1, 2)):  # the axis of the cell that columns, rows and sections run along
        def put(header, turn=turn):
            header.mapc, header.mapr, header.maps = (axis + 1 for axis in turn)
            for file_axis, axis in enumerate(turn):
                header["m" + "xyz"[axis]] = SIZE[file_axis]
                header.cella["xyz"[axis]] = SIZE[file_axis] * SPACING[axis]
        write(values_of("i2"), 0, put)
        wanted = np.zeros((3, 3))
        for file_axis, axis in enumerate(turn):
            wanted[axis, file_axis] = SPACING[axis] * 1e-7
        check("m.mrc", values_of("i2"), wanted, (), f"axes {turn}")
    for flags, dtype in (0, "u1"), (1, "i1"), (8, "u1"):  # IMOD says by its bit 0 that bytes have a sign
        write(values_of("i1"))
        with open("m.mrc", "r+b") as file:
            file.seek(152)
            file.write(struct.pack("<ii", 1146047817, flags))
        check("m.mrc", values_of("i1").view(dtype), steps, (), f"IMOD's flags {flags}")
    write(values_of("i2"), 0, lambda header: header.cella.fill(0))
    refused("m.mrc", 4, "does not state the spacing of its voxels")
    check("m.mrc", values_of("i2"), None, SAY)
    write(np.zeros((3, 4, 5), "c8"))
    refused("m.mrc", 4, "mode 4, must be 0, 1, 2, 6 or 12")


# ---- arrays by numpy ----

@case
def matrix_npy():
    for dtype, order, layout in itertools.product((*TYPES, "f2"), "<>", "CF"):
        values = values_of(dtype).astype(np.dtype(dtype).newbyteorder(order))
        np.save("a.npy", values if layout == "C" else np.asfortranarray(values.T))
        check("a.npy", values_of(dtype), None, SAY, f"{dtype} {order} {layout}")
    truth = values_of("u1") % 2 == 1
    np.save("a.npy", truth)
    got, steps = read("a.npy", SAY)
    expect(not difference(got, steps, truth.astype("u1"), np.diag(SPACING)), "bool")
    with open("a.npy", "wb") as file:
        np.lib.format.write_array(file, values_of("i2"), version=(2, 0))
    check("a.npy", values_of("i2"), None, SAY, "version 2")
    np.save("a.npy", np.stack([values_of("i2"), values_of("i2") + 1]))
    check("a.npy", values_of("i2") + 1, None, [*SAY, "--frame", "1"], "time")
    must_choose("a.npy", "has 2 frames", SAY)
    refused("a.npy", 4, "does not state the spacing of its voxels", ["--frame", "1"])
    for count, layout in itertools.product((3, 4), "CF"):
        planes = [values_of("u1") + channel for channel in range(count)]
        np.save("a.npy", np.stack(planes, -1) if layout == "C" else np.asfortranarray(np.stack(planes).T))
        check("a.npy", planes[2], None, [*SAY, "--channel", "blue"], f"{count} colors {layout}")
        must_choose("a.npy", f"has {count} channels", SAY)
    np.save("a.npy", np.stack([np.stack([values_of("f4") + channel + 10 * frame for channel in range(3)], -1)
                               for frame in range(2)]))
    check("a.npy", values_of("f4") + 12, None, [*SAY, "--frame", "1", "--channel", "2"], "frames of channels")
    for values, why in ((np.zeros((1, 2, 3, 4, 5, 6)), "an array of more than 5 axes"),
                        (np.zeros((3, 4, 5), [("a", "f4"), ("b", "f4")]), "its type has fields")):
        np.save("a.npy", values)
        refused("a.npy", 4, why, SAY)
    np.save("a.npy", np.zeros((2, 3, 4, 5, 6), "u1"))
    refused("a.npy", 4, "5 axes with 6 samples along the fastest, at most 4 can be channels", SAY)
    for values, why in ((values_of("i2")[0], "a volume has 3 axes"), (values_of("f4").astype("c8"), "its type is '<c8'")):
        np.save("a.npy", values)
        refused("a.npy", 4, why, SAY)
    np.save("a.npy", values_of("i2"))
    with open("a.npy", "rb") as file:
        whole = file.read()
    for cut, why in ((len(whole) - 1, "truncated"), (60, "damaged"), (8, "damaged")):
        with open("a.npy", "wb") as file:
            file.write(whole[:cut])
        refused("a.npy", 4, why, SAY)


# ---- packers below all formats ----

@case
def matrix_packed():
    """A file of each kind of reader, packed by each program."""
    import mrcfile
    import tifffile
    values = values_of("i2")
    with mrcfile.new("p.mrc", overwrite=True) as file:
        file.set_data(values)
        file.set_volume()
        file.voxel_size = tuple(SPACING)
    tifffile.imwrite("p.tif", values, photometric="minisblack")
    np.save("p.npy", values)
    values.tofile("p.raw")
    with open("p.nrrd", "wb") as file:
        file.write(b"NRRD0004\ntype: int16\ndimension: 3\nsizes: 5 4 3\nspacings: .75 .5 2.5\nendian: little\nencoding: raw\n\n" +
                   values.tobytes())
    raw = ["--raw-size", "5x4x3", "--raw-type", "int16", "--raw-spacing", "0.75x0.5x2.5"]
    files = {"p.mrc": (np.diag(SPACING) * 1e-7, ()), "p.tif": (None, SAY), "p.npy": (None, SAY), "p.raw": (None, raw), "p.nrrd": (None, ())}
    packers = {"gz": ["gzip"], "bz2": ["bzip2"], "xz": ["xz"], "zst": ["zstd", "-q", "--rm"]}
    for ending, pack in packers.items():
        if not shutil.which(pack[0]):
            continue
        for name, (steps, options) in files.items():
            shutil.copy(name, "copy")
            subprocess.run([*pack, "-f", "copy"], check=True)
            os.replace(f"copy.{ending}", f"{name}.{ending}")
            check(f"{name}.{ending}", values, steps, options, pack[0])
        with open(f"p.mrc.{ending}", "rb") as file:
            whole = file.read()
        with open(f"cut.mrc.{ending}", "wb") as file:
            file.write(whole[:len(whole) // 2])
        got = run("info", f"cut.mrc.{ending}")
        expect(got.returncode == 4 and got.stderr.count("\n") == 1 and f"cut.mrc.{ending}: " in got.stderr and "tmp" not in got.stderr,
               f"cut by half, {ending}: {got.returncode}: {got.stderr}")
    with open("p.raw", "r+b") as file:  # a volume whose first samples are those of a packed file
        file.write(b"\x1f\x8b\x08\x00")
    check("p.raw", np.fromfile("p.raw", "i2").reshape(3, 4, 5), None, raw, "samples like gzip's first bytes")


# ---- what no format may do without a word ----

@case
def numbers():
    """Values that floats cannot hold, and values that stand for none."""
    import netCDF4
    base = np.arange(60).reshape(3, 4, 5)
    for values, says in ((base * 1e-5 + 1e9, "fewer than 256 steps"), (base * 1e-12 + 1, "fewer than 256 steps"),
                         (base * 1e300, "at most 3.40282e+38 fits into a float")):
        values.astype("<f8").tofile("v.raw")
        got = run("info", "v.raw", "--raw-size", "5x4x3", "--raw-type", "double")
        expect(got.returncode == 5 and says in got.stderr, got.stderr)
    (base + 1e6).astype("<f8").tofile("v.raw")  # no float is lost
    check("v.raw", base + 1e6, np.eye(3) * 1.5, ["--raw-size", "5x4x3", "--raw-type", "double", "--raw-spacing", "1.5"])
    (base * 1e36).astype("<f4").tofile("v.raw")
    got = run("build", "v.raw", "--raw-size", "5x4x3", "--raw-type", "float", "--levels", "2", "-q", "-o", "large.iso")
    expect(got.returncode == 5 and "so that sums of them are floats" in got.stderr and not os.path.exists("large.iso"), got.stderr)

    def net(dtype, fill, data, **attributes):
        with netCDF4.Dataset("f.nc", "w", format="NETCDF3_CLASSIC") as file:
            for name, n in zip("zyx", data.shape):
                file.createDimension(name, n)
            v = file.createVariable("t", dtype, ("z", "y", "x"), fill_value=fill)
            v.set_auto_maskandscale(False)
            v.setncatts(attributes)
            v[:] = data.astype(dtype)
        return "f.nc"

    data = values_of("f4").copy()
    data[1] = 1e20
    for fill, attributes in (1e20, {}), (None, {"missing_value": np.float32(1e20)}):
        without_data(net("f4", fill, data, **attributes), 20)
        without_data("f.nc", 0, "--no-data", "none")
        without_data("f.nc", 40, "--no-data=-1e19,1e19")
    packed = values_of("i2").copy()
    packed[0, 0] = -32767
    without_data(net("i2", -32767, packed // 100, scale_factor=0.5, add_offset=2.0), 0)  # it is in no voxel
    packed = packed // 100
    packed[0, 0] = -32767
    without_data(net("i2", -32767, packed, scale_factor=0.5, add_offset=2.0), 5)
    inside = values_of("i2")  # a fill value within the range of the others makes none
    check(net("i2", int(inside[1, 2, 3]), inside), inside, None, SAY)
    with open("e.cube", "w", encoding="ascii") as file:  # no letter before an exponent of three digits
        file.write("a\nb\n 1 0 0 0\n 2 1 0 0\n 2 0 1 0\n 2 0 0 1\n 1 0 0 0 0\n1.5-101 -2.5-002 1.5E-3 -1.5D2 1 2 3.25+001 4\n")
    numbers_of = np.array([1.5e-101, -2.5e-2, 1.5e-3, -150, 1, 2, 32.5, 4]).reshape(2, 2, 2).T
    check("e.cube", numbers_of, np.eye(3) * 5.29177210903e-8, (), "exponents")
    with open("e.cube", "w", encoding="ascii") as file:  # columns without a space: fixed widths that are full
        file.write("a\nb\n 1 0 0 0\n 2 1 0 0\n 2 0 1 0\n 2 0 0 1\n 1 0 0 0 0\n"
                   "-1.5E-101-2.5E-002-1.5E-3 1.5-101-2.5+001-3.5\n1.25-7.5D0\n")
    numbers_of = np.array([-1.5e-101, -2.5e-2, -1.5e-3, 1.5e-101, -25, -3.5, 1.25, -7.5]).reshape(2, 2, 2).T
    check("e.cube", numbers_of, np.eye(3) * 5.29177210903e-8, (), "full columns")


@case
def missing_number():
    """A picture that is missing, by the number in its name."""
    import vtk
    from phantom import vtk_image, vtk_write
    os.makedirs("row", exist_ok=True)
    values = values_of("u2", (5, 4, 10))
    for k, pixels in enumerate(values):
        vtk_write(vtk.vtkPNGWriter(), vtk_image(pixels[None, ::-1].copy()), f"row/s2_{10 * (k + 1):03d}b.png")
    check("row", values, None, SAY, "every tenth number")
    os.remove("row/s2_070b.png")
    refused("row", 4, "number 70 is missing between s2_060b.png and s2_080b.png", SAY)
    os.rename("row/s2_060b.png", "row/other.png")  # not like most of the names
    refused("row", 4, "number 60 is missing between s2_050b.png and s2_080b.png", SAY)
    for name in os.listdir("row"):  # no numbers any more: in the order of their names
        os.rename(f"row/{name}", "row/" + "".join(chr(97 + int(c)) if c.isdigit() else c for c in name))
    check("row", values[[5, 0, 1, 2, 3, 4, 7, 8, 9]], None, SAY, "")
