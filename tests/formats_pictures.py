# SPDX-License-Identifier: MIT
"""Stacks of pictures, VTK's files, TIFF, MRC. Cases of formats_in.py."""
import itertools
import os
import re
import struct

import numpy as np

from phantom import (FIRST, SIZE, SPACING, STEPS, build, case, cut, expect, must_choose, phantom, read_samples, refused,
                     run, same, vtk_array, vtk_colors, vtk_image, vtk_write)


@case
def png_stack():
    import vtk
    os.makedirs("png", exist_ok=True)
    values = phantom(np.uint16)
    for k, pixels in enumerate(values):  # VTK counts rows from the bottom
        vtk_write(vtk.vtkPNGWriter(), vtk_image(pixels[None, ::-1].copy()), f"png/slice{9 + k}.png")
    refused("png", 4, "does not state the spacing of its voxels, as pictures do not; set --spacing SXxSYxSZ")
    same("png", values, np.diag(SPACING), None, False, ["--spacing", "0.75x0.5x2.5"])
    cut("png/slice10.png", "short.png")
    os.replace("short.png", "png/slice10.png")
    refused("png", 4, "slice10.png", ["--spacing", "1"])
    vtk_write(vtk.vtkPNGWriter(), vtk_image(values[:1, 1:].copy()), "png/slice10.png")
    refused("png", 4, "slices of different sizes", ["--spacing", "1"])


def write_bitmap(path, pixels, palette):
    """8 bits, rows from the bottom, each of a multiple of 4 bytes: VTK writes 24 bits only."""
    height, width = pixels.shape
    room = -width % 4
    data = b"".join(row.tobytes() + b"\0" * room for row in pixels[::-1])
    colors = b"".join(bytes((c[2], c[1], c[0], 0)) for c in palette)
    with open(path, "wb") as file:
        file.write(struct.pack("<2sIII", b"BM", 54 + len(colors) + len(data), 0, 54 + len(colors)) +
                   struct.pack("<IiiHHIIiiII", 40, width, height, 1, 8, 0, 0, 0, 0, len(palette), 0) + colors + data)


@case
def pictures_of_colors():
    """Colors, palettes and bitmaps; files that are no slices beside them, as scanners write."""
    import png
    import vtk
    red = phantom(np.uint8)
    colors = np.stack([red, red // 2 + 1, 255 - red, red // 4], -1)
    gray = [(255 - i,) * 3 for i in range(256)]
    folders = {"rgb": colors[..., :3], "bmp24": colors[..., :3], "rgba": colors, "palette": None, "grays": None, "bmp8": None}
    for folder in folders:
        os.makedirs(f"of_{folder}", exist_ok=True)
    for k, pixels in enumerate(red):
        name = f"slice{k + 8}"
        rows = pixels.tolist()
        for folder, writer, ending, n in (("rgb", vtk.vtkPNGWriter(), "png", 3), ("rgba", vtk.vtkPNGWriter(), "png", 4),
                                          ("bmp24", vtk.vtkBMPWriter(), "bmp", 3)):
            vtk_write(writer, vtk_colors(np.ascontiguousarray(colors[k, ::-1, :, :n])), f"of_{folder}/{name}.{ending}")
        with open(f"of_palette/{name}.png", "wb") as file:
            png.Writer(*pixels.shape[::-1], palette=[(i, 255 - i, i // 2) for i in range(256)]).write(file, rows)
        with open(f"of_grays/{name}.png", "wb") as file:
            png.Writer(*pixels.shape[::-1], palette=gray).write(file, rows)
        write_bitmap(f"of_bmp8/{name}.bmp", pixels, gray)
    say = ["--spacing", "0.75x0.5x2.5"]
    for folder in "rgb", "rgba", "bmp24":
        must_choose(f"of_{folder}", "--channel chooses one of them: 0 red, 1 green, 2 blue", say)
        refused(f"of_{folder}", 4, "in mm; --channel chooses one of ")
        for c, name in enumerate(("red", "green", "blue")):
            same(f"of_{folder}", colors[..., c], np.diag(SPACING), None, False, [*say, "--channel", name])
        weighed = (colors[..., :3] @ [0.2126, 0.7152, 0.0722]).astype(np.float32)
        same(f"of_{folder}", weighed, np.diag(SPACING), None, False, [*say, "--channel", "luminance"])
    same("of_palette", 255 - red, np.diag(SPACING), None, False, [*say, "--channel", "green"])
    for folder in "grays", "bmp8":
        same(f"of_{folder}", 255 - red, np.diag(SPACING), None, False, say)
    cut("of_bmp8/slice9.bmp", "short")
    os.replace("short", "of_bmp8/slice9.bmp")
    refused("of_bmp8", 4, "slice9.bmp: truncated", say)
    # what a scanner puts beside its slices
    for name in "a__rec.log", "Thumbs.db", "README.txt", "notes 12.csv":
        with open(f"of_grays/{name}", "w", encoding="ascii") as file:
            file.write("MM of no slice")
    same("of_grays", 255 - red, np.diag(SPACING), None, False, say)
    write_bitmap("of_grays/a__rec_spr.bmp", red[0], gray)
    vtk_write(vtk.vtkPNGWriter(), vtk_image(red[:1, :5].copy()), "of_grays/overview.png")
    got = run("info", "of_grays", *say)
    expect(got.returncode == 0 and "11 x 13 x 7" in got.stdout and "of_grays/overview.png is left out" in got.stderr, got.stderr)
    vtk_write(vtk.vtkPNGWriter(), vtk_image(red[:1].copy()), "of_grays/overview.png")  # of the slices' size
    got = run("info", "of_grays", *say)
    expect(got.returncode == 0 and "11 x 13 x 7" in got.stdout and "of_grays/overview.png is left out" in got.stderr, got.stderr)
    os.mkdir("of_two")
    for i, name in enumerate(("a1", "a2", "b1", "b2")):
        vtk_write(vtk.vtkPNGWriter(), vtk_image(red[i:i + 1].copy()), f"of_two/{name}.png")
    for folder, is_two in ("of_two", True), ("of_grays", False):
        warning = run("info", folder, *say).stderr
        expect(("named a#.png and b#.png are read as one volume" in warning) == is_two, warning)
    os.remove("of_grays/slice10.png")
    refused("of_grays", 4, "number 10 is missing between slice9.png and slice11.png", say)


@case
def tiff_and_jpeg_stacks():
    import tifffile
    import vtk
    from vtk.util import numpy_support
    values = phantom(np.uint8)
    for folder in "tiffs", "jpegs":
        os.makedirs(folder, exist_ok=True)
    decoded = []
    for k, pixels in enumerate(values):
        tifffile.imwrite(f"tiffs/slice{9 + k}.tif", pixels, photometric="minisblack", resolution=(72, 72))
        writer = vtk.vtkJPEGWriter()
        writer.SetQuality(90)
        vtk_write(writer, vtk_image(pixels[None, ::-1].copy()), f"jpegs/slice{9 + k}.jpg")
        reader = vtk.vtkJPEGReader()  # lossy: what VTK reads back
        reader.SetFileName(f"jpegs/slice{9 + k}.jpg")
        reader.Update()
        decoded.append(numpy_support.vtk_to_numpy(reader.GetOutput().GetPointData().GetScalars()).reshape(pixels.shape)[::-1])
    for folder, wanted, last in ("tiffs", values, "slice15.tif"), ("jpegs", np.stack(decoded), "slice15.jpg"):
        refused(folder, 4, "does not state the spacing of its voxels, as pictures do not")
        refused(folder, 2, "holds no series", ["--spacing", "1", "--series", "1"])
        same(folder, wanted, np.diag(SPACING), None, False, ["--spacing", "0.75x0.5x2.5"])
        cut(f"{folder}/{last}", "short", 0.5)
        os.replace("short", f"{folder}/{last}")
        refused(folder, 4, last, ["--spacing", "1"])
        with open(f"{folder}/{last}", "wb") as file:
            file.write(b"nothing of the kind")
        refused(folder, 4, last, ["--spacing", "1"])
    for number, dtype in enumerate(("i1", "u2", "i2", "u4", "i4", "u8", "i8", "f2", "f4", "f8")):
        values = (np.round(phantom(np.float32)) % 97).astype(dtype)
        for k, pixels in enumerate(values):
            tifffile.imwrite(f"tiffs/slice{9 + k}.tif", pixels.astype(pixels.dtype.newbyteorder("<>"[number % 2])),
                             photometric="minisblack", byteorder="<>"[number % 2],
                             **({"tile": (16, 16)}, {"rowsperstrip": 4, "compression": "zlib"}, {})[number % 3])
        same("tiffs", values if values.itemsize <= 2 and dtype != "f2" else values.astype(np.float32), np.diag(SPACING),
             None, False, ["--spacing", "0.75x0.5x2.5"])
    cut("tiffs/slice9.tif", "short", 0.7)
    os.replace("short", "tiffs/slice9.tif")
    refused("tiffs", 4, "slice9.tif", ["--spacing", "1"])


# ---- VTK's legacy files ----

@case
def vtk_legacy():
    import vtk
    for dtype in np.uint8, np.int16, np.float32, np.float64:
        for text in False, True:
            writer = vtk.vtkStructuredPointsWriter()
            (writer.SetFileTypeToASCII if text else writer.SetFileTypeToBinary)()
            values = phantom(dtype)
            if text and values.dtype.kind == "f":  # of few digits
                values = np.round(values)
            vtk_write(writer, vtk_image(values, np.diag(SPACING), [1, 2, 3]), "legacy.vtk")
            if text and dtype == np.uint8:
                refused("legacy.vtk", 4, "its samples are bytes as text (COLOR_SCALARS), which is not read")
                continue
            wanted = values if values.dtype != np.float64 else values.astype(np.float32)
            same("legacy.vtk", wanted, np.diag(SPACING), [1, 2, 3], False)
            cut("legacy.vtk", "cut.vtk")
            refused("cut.vtk", 4, "truncated")
    same("legacy.vtk", wanted, np.diag(SPACING) * 1e-6, np.array([1, 2, 3]) * 1e-6, False, ["--unit", "nm"], "nm")
    for text, kind in itertools.product((False, True), ("fields", "vectors")):  # as ParaView saves arrays
        image = vtk_image(values, np.diag(SPACING), [1, 2, 3])
        image.GetPointData().Initialize()
        one = vtk_array(np.stack([values.ravel(), values.ravel() + 1, values.ravel() + 2], -1))
        one.SetName("velocity")
        (image.GetPointData().SetVectors if kind == "vectors" else image.GetPointData().AddArray)(one)
        image.GetFieldData().AddArray(vtk_array(np.arange(2.0)))
        writer = vtk.vtkStructuredPointsWriter()
        (writer.SetFileTypeToASCII if text else writer.SetFileTypeToBinary)()
        vtk_write(writer, image, "fields.vtk")
        same("fields.vtk", np.round(values + 2, 3) if text else values + 2, np.diag(SPACING), [1, 2, 3], False, ["--channel", "2"])
    for text, dtype in itertools.product((False, True), (np.int16, np.float32)):
        values = np.round(phantom(dtype))
        grid = vtk.vtkRectilinearGrid()
        grid.SetDimensions(values.shape[::-1])
        for a, name in enumerate("XYZ"):
            at = (1 + a + SPACING[a] * np.arange(values.shape[2 - a])).astype(np.float64 if a else np.float32)
            if text and dtype == np.float32 and a == 2:
                at[3] += 1
            getattr(grid, f"Set{name}Coordinates")(vtk_array(at))
        scalars = vtk_array(values.ravel())
        scalars.SetName("s")
        grid.GetPointData().SetScalars(scalars)
        writer = vtk.vtkRectilinearGridWriter()
        (writer.SetFileTypeToASCII if text else writer.SetFileTypeToBinary)()
        vtk_write(writer, grid, "grid.vtk")
        if not (text and dtype == np.float32):
            same("grid.vtk", values, np.diag(SPACING), [1, 2, 3], False)
    refused("grid.vtk", 4, "the steps of its z axis are 1.5 to 3.5, must be equal within 1 %")
    same("grid.vtk", values, np.diag(SPACING), [1, 2, 3], False, ["--force-spacing"])
    cut("grid.vtk", "cut.vtk", 0.02)
    refused("cut.vtk", 4, "cut.vtk: ")
    vtk_write(vtk.vtkUnstructuredGridWriter(), vtk.vtkUnstructuredGrid(), "grid.vtk")
    refused("grid.vtk", 4, "a dataset of VTK's kind UNSTRUCTURED_GRID, must be STRUCTURED_POINTS or RECTILINEAR_GRID")
    eight = "1 2 3 4 5 6 7 8"
    for numbers, why in ((f"{eight}\nSCALARS t float\n{eight}", None),
                         (f"{eight} 9 10", "too long: more follows the 8 numbers"),
                         (f"0.{'0' * 80} {eight[2:]}", "a word of more than 63 letters after 0 of 8 numbers")):
        with open("text.vtk", "w", encoding="ascii") as file:
            file.write("# vtk DataFile Version 3.0\nt\nASCII\nDATASET STRUCTURED_POINTS\nDIMENSIONS 2 2 2\n"
                       f"ORIGIN 0 0 0\nSPACING 1 1 1\nPOINT_DATA 8\nSCALARS s float\nLOOKUP_TABLE default\n{numbers}\n")
        if why:
            refused("text.vtk", 4, why)
        else:
            same("text.vtk", np.arange(1, 9, dtype=np.float32).reshape(2, 2, 2), np.eye(3), np.zeros(3), False)


def rectilinear(values, axes, of_cells):
    import vtk
    grid = vtk.vtkRectilinearGrid()
    grid.SetDimensions([len(at) for at in axes])
    for at, name in zip(axes, "XYZ"):
        getattr(grid, f"Set{name}Coordinates")(vtk_array(at))
    scalars = vtk_array(values.ravel())
    scalars.SetName("s")
    (grid.GetCellData() if of_cells else grid.GetPointData()).SetScalars(scalars)
    return grid


def rectilinear_writers():
    import vtk
    for text in False, True:
        writer = vtk.vtkRectilinearGridWriter()
        (writer.SetFileTypeToASCII if text else writer.SetFileTypeToBinary)()
        yield writer, "grid.vtk"
    for mode, encode, pack, big in ((0, False, False, False), (1, False, True, False), (2, False, False, True),
                                    (2, True, True, False)):
        writer = vtk.vtkXMLRectilinearGridWriter()
        writer.SetDataMode(mode)
        writer.SetEncodeAppendedData(encode)
        (writer.SetCompressorTypeToZLib if pack else writer.SetCompressorTypeToNone)()
        (writer.SetByteOrderToBigEndian if big else writer.SetByteOrderToLittleEndian)()
        yield writer, "grid.vtr"


def resampled(values, axes, of_cells):
    """Linear along one axis after the other, at the smallest step. Values, steps, first sample."""
    steps, first = [], []
    for a, at in enumerate(axes):
        least, length = np.diff(at).min(), at[-1] - at[0]
        count = int(round(length / least)) + (not of_cells)
        step = length / (count - (not of_cells))
        new = at[0] + step * (np.arange(count) + 0.5 * of_cells)
        old = (at[1:] + at[:-1]) / 2 if of_cells else at
        values = np.apply_along_axis(lambda row: np.interp(new, old, row), 2 - a, values)  # noqa: B023
        steps.append(step)
        first.append(new[0])
    return values, np.diag(steps), np.array(first)


@case
def vtk_rectilinear():
    """Even grids as they stand; uneven ones refused, taken for even, or interpolated, of points and of cells."""
    for of_cells in False, True:
        values = np.round(phantom(np.float32))
        more = 1 if of_cells else 0
        even = [np.arange(n + more) * SPACING[a] + 1 - more * SPACING[a] / 2 for a, n in enumerate(values.shape[::-1])]
        uneven = [at.copy() for at in even]
        uneven[0][4:] += 0.75
        uneven[2][2:] += 5
        wanted, steps, first = resampled(values.astype(float), uneven, of_cells)
        expect(wanted.shape == (9, 13, 12), f"the test makes {wanted.shape}")
        for writer, name in rectilinear_writers():
            vtk_write(writer, rectilinear(values, even, of_cells), name)
            same(name, values, np.diag(SPACING), [1, 1, 1], False)
            vtk_write(writer, rectilinear(values, uneven, of_cells), name)
            refused(name, 4, "the steps of its x axis are 0.75 to 1.5, must be equal within 1 %; --resample")
            level, got = build(name, ["--resample"])
            got_steps = np.array(level["geometry"]["index_to_world"]).reshape(3, 3)
            got_first = np.array(level["geometry"]["origin_mm"]) + got_steps @ [0.5, 0.5, 0.5]
            told = run("info", name, "--resample").stderr
            expect("12 x 13 x 9 samples are interpolated of 11 x 13 x 7" in told, told)
            # floats of up to 3000 are rounded by 1e-4
            expect(got.shape == wanted.shape and np.allclose(got, wanted, rtol=0, atol=1e-3), f"{name}: --resample")
            expect(not np.allclose(np.roll(got, 1, 0), wanted, rtol=0, atol=1e-3), "moved slices are not seen")
            expect(np.allclose(got_steps, steps) and np.allclose(got_first, first), f"{name}: {got_steps} {got_first}")
            forced = read_samples(name, ["--force-spacing"])
            expect(np.array_equal(forced, values), f"{name}: --force-spacing")
    ints = phantom(np.int16)
    uneven = [at[:n] for at, n in zip(uneven, ints.shape[::-1])]
    vtk_write(writer, rectilinear(ints, uneven, False), "grid.vtr")
    got = read_samples("grid.vtr", ["--resample"])
    off = np.abs(got - resampled(ints.astype(float), uneven, False)[0]).max()
    expect(got.dtype == np.int16 and 0 < off <= 0.5, f"rounded integers are {off} off")
    far = [uneven[0], uneven[1], np.array([0, 1e-4, 1, 2, 3, 4, 5])]
    vtk_write(writer, rectilinear(ints, far, False), "grid.vtr")
    refused("grid.vtr", 4, "--resample would make", ["--resample"])
    cut("grid.vtr", "cut.vtr", 0.5)
    refused("cut.vtr", 4, "cut.vtr: ")


@case
def vti():
    import vtk
    for dtype in np.uint8, np.int16, np.float32:
        values = phantom(dtype)
        for mode, encode, pack, big in ((2, False, False, False), (2, True, False, False), (2, True, True, False),
                                        (2, False, True, True), (1, False, True, False), (1, False, False, True),
                                        (0, False, False, False), (2, False, False, True)):
            writer = vtk.vtkXMLImageDataWriter()
            writer.SetDataMode(mode)  # text, inline binary, appended
            writer.SetEncodeAppendedData(encode)
            if not pack:
                writer.SetCompressorTypeToNone()
            writer.SetBlockSize(512)
            (writer.SetByteOrderToBigEndian if big else writer.SetByteOrderToLittleEndian)()
            written = np.round(values).astype(dtype) if mode == 0 else values
            vtk_write(writer, vtk_image(written, STEPS, FIRST), "phantom.vti")
            same("phantom.vti", written, ras=False)
            cut("phantom.vti", "cut.vti", 0.7)
            refused("cut.vti", 4, "truncated")
    image = vtk_image(phantom(), np.diag(SPACING), [1, 2, 3])
    image.SetExtent(-2, 8, 3, 15, 1, 7)
    vtk_write(vtk.vtkXMLImageDataWriter(), image, "phantom.vti")
    same("phantom.vti", phantom(), np.diag(SPACING), [1, 2, 3] + SPACING * [-2, 3, 1], False)
    for name, more in ("p", 1), ("T", 2):
        image.GetPointData().AddArray(vtk_array(phantom().ravel() + more))
        image.GetPointData().GetArray(more).SetName(name)
    vtk_write(vtk.vtkXMLImageDataWriter(), image, "several.vti")
    same("several.vti", phantom(), np.diag(SPACING), [1, 2, 3] + SPACING * [-2, 3, 1], False)
    same("several.vti:T", phantom() + 2, np.diag(SPACING), [1, 2, 3] + SPACING * [-2, 3, 1], False)
    refused("several.vti:U", 2, 'has no array "U", FILE:ARRAY must be one of: values, p, T')
    for numbers, why in (("1 2 3 4 5 6 7 8 9 10", "too long: more follows the 8 numbers"),
                         (f"0.{'0' * 80} 2 3 4 5 6 7 8", "a word of more than 63 letters after 0 of 8 numbers")):
        with open("text.vti", "w", encoding="ascii") as file:
            file.write('<VTKFile type="ImageData" version="0.1" byte_order="LittleEndian"><ImageData '
                       'WholeExtent="0 1 0 1 0 1" Origin="0 0 0" Spacing="1 1 1"><Piece Extent="0 1 0 1 0 1">'
                       '<PointData Scalars="s"><DataArray type="Float32" Name="s" format="ascii">'
                       f"{numbers}</DataArray></PointData></Piece></ImageData></VTKFile>")
        refused("text.vti", 4, why)


# ---- TIFF by tifffile ----

@case
def tiff():
    import tifffile
    for dtype in np.uint8, np.uint16, np.int16, np.float32:
        values = phantom(dtype)
        tifffile.imwrite("plain.tif", values, photometric="minisblack")
        refused("plain.tif", 4, "does not state the spacing of its voxels; set --spacing SXxSYxSZ")
        same("plain.tif", values, np.diag(SPACING), None, False, ["--spacing", "0.75x0.5x2.5"])
    for more in {"bigtiff": True}, {"compression": "zlib"}, {"tile": (16, 16)}, {"byteorder": ">"}, {"rowsperstrip": 4}:
        tifffile.imwrite("more.tif", values, photometric="minisblack", **more)
        same("more.tif", values, np.diag(SPACING), None, False, ["--spacing", "0.75x0.5x2.5"])
        cut("more.tif", "cut.tif", 0.8)
        refused("cut.tif", 4, "cut.tif", ["--spacing", "1"])
    # Of a page of a gigapixel: the sizes alone are changed.
    for compression in None, "zlib":
        tifffile.imwrite("large.tif", np.zeros((1, 2, 2), np.uint8), photometric="minisblack", compression=compression)
        with tifffile.TiffFile("large.tif", mode="r+b") as file:
            for tag in "ImageWidth", "ImageLength":
                file.pages[0].tags[tag].overwrite(32768)
        refused("large.tif", 4, "compressed bytes cannot hold the 1073741824 that the sizes need", ["--spacing", "1"])
    tifffile.imwrite("colors.tif", np.zeros((9, 9, 3), np.uint8), photometric="rgb")
    must_choose("colors.tif", "has 3 channels a voxel", ["--spacing", "1"])


@case
def tiff_imagej():
    import tifffile
    values = phantom(np.uint16)
    about = {"spacing": 2500.0, "unit": "nm", "axes": "ZYX"}
    tifffile.imwrite("imagej.tif", values, imagej=True, resolution=(1 / 750, 1 / 500), metadata=about)
    # the resolution is a quotient of 32 bits
    same("imagej.tif", values, np.diag(SPACING) / 1000, None, False, unit="nm", tolerance=1e-6)
    tifffile.imwrite("imagej.tif", values, imagej=True, resolution=(1 / 0.75, 1 / 0.5),
                     metadata={"spacing": 2.5, "unit": "\\u00B5m", "axes": "ZYX"})
    same("imagej.tif", values, np.diag(SPACING) / 1000, None, False, unit="um", tolerance=1e-6)
    tifffile.imwrite("flat.tif", values, imagej=True, resolution=(1, 1), metadata={"unit": "um", "axes": "ZYX"})
    refused("flat.tif", 4, "does not state the spacing between its slices")
    both = np.stack([values, values], 1)
    tifffile.imwrite("channels.tif", both, imagej=True, metadata={"axes": "ZCYX"})
    must_choose("channels.tif", "has 2 channels a voxel", ["--spacing", "1"])


@case
def tiff_ome():
    import tifffile
    values = phantom(np.uint16)
    about = {"axes": "ZYX", "PhysicalSizeX": 0.75, "PhysicalSizeY": 0.5, "PhysicalSizeZ": 2500.0,
             "PhysicalSizeZUnit": "nm"}
    tifffile.imwrite("phantom.ome.tif", values, metadata=about)  # micrometers where no unit is named
    same("phantom.ome.tif", values, np.diag(SPACING) / 1000, None, False)
    tifffile.imwrite("unknown.ome.tif", values, metadata={**about, "PhysicalSizeZUnit": "parsec"})
    refused("unknown.ome.tif", 4, 'unknown unit "parsec"')
    tifffile.imwrite("flat.ome.tif", values, metadata={"axes": "ZYX", "PhysicalSizeX": 1, "PhysicalSizeY": 1})
    refused("flat.ome.tif", 4, "does not state the spacing between its slices")
    with open("phantom.ome.tif", "rb") as file:
        data = file.read()
    said = re.search(rb'DimensionOrder="XY..." Type="uint16"', data)[0]
    for order in "XYZZZZZZ", "XYZCC", "XYZC", "XYCTQ":
        with open("order.ome.tif", "wb") as file:  # the description's length stays
            file.write(data.replace(said, f'DimensionOrder="{order}"'.encode().ljust(len(said))))
        refused("order.ome.tif", 4, f"DimensionOrder is {order}, must be XY and each of Z, C and T once")


# ---- MRC by mrcfile ----

@case
def mrc():
    import mrcfile
    for dtype in np.int8, np.int16, np.uint16, np.float32:
        values = phantom(dtype) if dtype != np.int8 else (phantom() % 100).astype(np.int8)
        with mrcfile.new("phantom.mrc", overwrite=True) as file:
            file.set_data(values)
            file.set_volume()
            file.voxel_size = tuple(SPACING)
            file.header.origin = (1, 2, 3)
        same("phantom.mrc", values, np.diag(SPACING) * 1e-7, np.array([1, 2, 3]) * 1e-7, False, unit="angstrom",
             tolerance=1e-13)
    with mrcfile.open("phantom.mrc", "r+") as file:
        file.header.origin = (0, 0, 0)
        file.header.nxstart, file.header.nystart, file.header.nzstart = 4, -5, 6
        file.header.mapc, file.header.mapr, file.header.maps = 3, 1, 2
        file.header.cella = tuple(SPACING * SIZE)
        file.header.mx, file.header.my, file.header.mz = SIZE
    turned = np.zeros((3, 3))
    for file_axis, cell_axis in enumerate((2, 0, 1)):
        turned[cell_axis, file_axis] = SPACING[cell_axis] * 1e-7
    same("phantom.mrc", values, turned, turned @ [4, -5, 6], False, tolerance=1e-13)
    with mrcfile.open("phantom.mrc", "r+") as file:
        file.header.mapc, file.header.mapr, file.header.maps = 1, 2, 3
        file.header.nxstart = file.header.nystart = file.header.nzstart = 0
        file.header.cellb.gamma = 120
    steps = np.diag(SPACING) * 1e-7
    steps[:, 1] = SPACING[1] * 1e-7 * np.array([-0.5, np.sqrt(0.75), 0])
    same("phantom.mrc", values, steps, np.zeros(3), False, tolerance=1e-13)
    cut("phantom.mrc", "cut.mrc")
    refused("cut.mrc", 4, "truncated: holds")
    with open("short.mrc", "wb") as file, open("phantom.mrc", "rb") as whole:
        file.write(whole.read(300))
    refused("short.mrc", 4, "an MRC header has 1024")
