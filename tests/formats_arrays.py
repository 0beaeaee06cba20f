# SPDX-License-Identifier: MIT
"""Formats of simulations and of arrays: cube, XSF, HDF5, netCDF, MINC, OME-Zarr, OpenVDB. Cases of formats_in.py."""
import json
import os
import shutil
import struct
import subprocess

import numpy as np

from phantom import (FILES, FIRST, SIZE, SPACING, STEPS, case, cut, expect, load, must_choose, phantom, refused, run,
                     same, vtk_image, vtk_write)


# ---- Gaussian cube and XSF by ASE (formats/make.py) ----

def small():
    x, y, z = np.meshgrid(np.arange(4), np.arange(5), np.arange(3), indexing="ij")
    return (0.25 * x - 0.5 * y * y + 0.125 * z * x + 3 * z).T.astype(np.float32)


CELL = np.array([[2.0, 0.5, 0.25], [0, 2.5, -0.75], [0, 0, 1.5]]) * 1e-7  # columns, mm


@case
def cube():
    # six decimals of bohr
    same(f"{FILES}/phantom.cube", small(), CELL / [4, 5, 3], np.array([0.1, -0.2, 0.3]) * 1e-7, False, unit="bohr",
         tolerance=1e-12)
    cut(f"{FILES}/phantom.cube", "cut.cube")
    refused("cut.cube", 4, "truncated")
    cut(f"{FILES}/phantom.cube", "cut.cube", 0.2)
    refused("cut.cube", 4, "truncated before the values")
    with open(f"{FILES}/phantom.cube", encoding="ascii") as file:
        lines = file.readlines()
    shutil.copy(f"{FILES}/phantom.cube", "PHANTOM.CUBE")
    expect(run("info", "PHANTOM.CUBE").returncode == 0, "a name in capitals")
    with open("angstrom.cube", "w", encoding="ascii") as file:
        file.writelines([*lines[:3], *(line.replace("    ", "   -", 1) for line in lines[3:6]), *lines[6:]])
    bohr = 0.529177210903
    same("angstrom.cube", small(), CELL / [4, 5, 3] / bohr, np.array([0.1, -0.2, 0.3]) * 1e-7 / bohr, False,
         unit="angstrom", tolerance=1e-12)
    told = run("info", "angstrom.cube").stdout.splitlines()[2]  # in a unit of its size
    lengths = " x ".join(f"{v * 1e7:.6g}" for v in np.linalg.norm(CELL / [4, 5, 3] / bohr, axis=0))
    expect(told == f"  spacing    {lengths} angstrom", f"\"{told}\", not {lengths}")
    with open("orbitals.cube", "w", encoding="ascii") as file:
        both = (f"{value} {-float(value)}\n" for line in lines[8:] for value in line.split())
        file.writelines([*lines[:2], lines[2].replace("2", "-2", 1), *lines[3:8], "    2    5    6\n", *both])
    must_choose("orbitals.cube", "has 2 channels a voxel; --channel chooses one of them: 0 orbital 5, 1 orbital 6")
    for channel, sign in ("0", 1), ("orbital 6", -1):
        same("orbitals.cube", sign * small(), CELL / [4, 5, 3], np.array([0.1, -0.2, 0.3]) * 1e-7, False, unit="bohr",
             options=["--channel", channel])
    for more, why in (("\n1", "too long: more follows the 60 numbers"), ("\nEND", "too long: more follows"),
                      ("0" * 80, "a word of more than 63 letters after 59 of 60 numbers")):
        with open("more.cube", "w", encoding="ascii") as file:
            file.writelines([*lines, more])
        refused("more.cube", 4, why)


@case
def xsf():
    # ASE's vectors are those of n + 1 samples, which the format gives to n: from the first to the last
    steps = CELL * ((np.array([4, 5, 3]) + 1) / [4, 5, 3] / [3, 4, 2])
    same(f"{FILES}/phantom.xsf", small(), steps, np.zeros(3), False, unit="angstrom", tolerance=1e-12)
    cut(f"{FILES}/phantom.xsf", "cut.xsf")
    refused("cut.xsf", 4, "truncated")
    with open(f"{FILES}/phantom.xsf", "rb") as file:
        data = file.read()
    with open("two.xsf", "wb") as file:
        file.write(data + data)
    refused("two.xsf", 4, "has several grids")
    end = data.index(b"END_DATAGRID_3D")
    with open("more.xsf", "wb") as file:
        file.write(data[:end] + b" 1\n" + data[end:])
    refused("more.xsf", 4, "too long: more follows the 60 numbers")


# ---- HDF5 by h5py, netCDF by netCDF4, MINC by its own tools, OME-Zarr by zarr ----

def h5_scale(file, dataset, axis, name, values, unit):
    file[name] = values
    file[name].attrs["units"] = unit
    file[name].make_scale(name)
    dataset.dims[axis].attach_scale(file[name])


@case
def hdf5():
    import h5py
    values = phantom()
    for more in {}, {"chunks": (3, 5, 4), "compression": "gzip", "shuffle": True}, {"chunks": (2, 13, 11)}:
        with h5py.File("phantom.h5", "w") as file:
            data = file.create_dataset("a/volume", data=values, **more)
            data.attrs["element_size_um"] = SPACING[::-1]
        same("phantom.h5", values, np.diag(SPACING) / 1000, None, False, unit="um")
        same("phantom.h5:a/volume", values, np.diag(SPACING) / 1000, None, False, unit="um")
        cut("phantom.h5", "cut.h5", 0.7)
        refused("cut.h5", 4, "cut.h5: ")
    refused("phantom.h5:b", 2, 'has no dataset "b" of three axes, FILE:DATASET must name one of: a/volume (11 x 13 x 7)')
    for dtype in np.uint8, np.uint16, np.float32, ">i2", np.float16, bool:
        stored = phantom(np.uint8) > 100 if dtype == bool else phantom(np.int16).astype(dtype)
        with h5py.File("types.h5", "w") as file:
            data = file.create_dataset("v", data=stored)
            for axis, name in enumerate("zyx"):
                at = FIRST["xyz".index(name)] + np.arange(stored.shape[axis]) * SPACING["xyz".index(name)]
                h5_scale(file, data, axis, name, at, "nm")
        wanted = stored.astype({"float16": np.float32, "bool": np.uint8}.get(np.dtype(dtype).name, stored.dtype.newbyteorder("=")))
        same("types.h5:v", wanted, np.diag(SPACING) * 1e-6, FIRST * 1e-6, False, unit="nm", tolerance=1e-12)
    with h5py.File("two.h5", "w") as file:
        file["plain"], file["other"], file["wide"] = values, values + 1, values.astype(np.int64)
        file.create_dataset("lzf", data=values, compression="lzf")
        file["list"], file["frames"] = np.arange(9), np.stack([values, values + 1])
        file["parts"], file["five"] = np.stack([values, values + 1], -1), np.zeros((2, 3, 4, 5, 6))
    refused("two.h5", 2, "holds 7 datasets of three axes or more, FILE:DATASET must name one of: five (6 x 5 x 4 x 3 x 2), ")
    refused("two.h5:plain", 4, "does not state the spacing of its voxels; set --spacing SXxSYxSZ")
    same("two.h5:/other", values + 1, np.diag(SPACING), None, False, ["--spacing", "0.75x0.5x2.5"])
    same("two.h5:wide", values.astype(np.float32), np.diag(SPACING), None, False, ["--spacing", "0.75x0.5x2.5"])
    for name, option in ("frames", "--frame"), ("parts", "--channel"):  # axes without names, as in NumPy
        same(f"two.h5:{name}", values + 1, np.diag(SPACING), None, False, ["--spacing", "0.75x0.5x2.5", option, "1"])
    refused("two.h5:five", 4, "6 x 5 x 4 x 3 x 2 samples along 5 axes without names: names for a volume's three axes")
    refused("two.h5:lzf", 4, "packed by filter 32000 (lzf), which HDF5 has no plugin for")
    with h5py.File("sparse.h5", "w") as file:  # chunks beside each other unpack to more than the file's size allows
        data = file.create_dataset("v", shape=(64, 2048, 1024), dtype=np.uint16, chunks=(64, 64, 64), compression="gzip")
        data[9, 99, 5] = 7
        file.create_dataset("void", shape=(5000, 5000, 5000), dtype=np.uint8, chunks=(64, 64, 64))
    got = run("info", "sparse.h5:v", "--spacing", "1", "--json")
    expect(got.returncode == 0 and json.loads(got.stdout)["max"] == 7, got.stderr)
    refused("sparse.h5:void", 4, "its chunks have 0 bytes, each of which can hold 131072 of samples",
            ["--spacing", "1"])
    with h5py.File("version7.3.mat", "w", userblock_size=512) as file:
        file["v"] = values
    with open("version7.3.mat", "r+b") as file:
        file.write(b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(128))
    same("version7.3.mat", values, np.diag(SPACING), None, False, ["--spacing", "0.75x0.5x2.5"])
    whole = h5py.VirtualLayout(values.shape, values.dtype)
    whole[:] = h5py.VirtualSource("version7.3.mat", "v", values.shape)
    with h5py.File("virtual.h5", "w", libver="latest") as file:
        file.create_virtual_dataset("v", whole)
    refused("virtual.h5", 4, "virtual: its samples are in other files", ["--spacing", "1"])
    values.tofile("plain.raw")
    with open("plain.h5", "wb") as file:
        file.write(b"\x89HDF\r\n\x1a\n" + values.tobytes())
    refused("plain.h5", 4, "plain.h5: HDF5: ")


@case
def hdf5_without_end():
    """A heap whose free part has no length: HDF5's library looks for its end for ever."""
    import h5py
    with h5py.File("heap.h5", "w") as file:
        data = file.create_dataset("v", data=phantom())
        for axis, name in enumerate("zyx"):
            h5_scale(file, data, axis, name, np.arange(data.shape[axis]) * 0.5, "nm")
    expect(load("heap.h5:v")[0].shape == phantom().shape, "the heap as it was written")
    with open("heap.h5", "rb") as file:
        content = bytearray(file.read())
    at, index, length = content.index(b"GCOL") + 16, 1, 0
    while index != 0:
        index, length = struct.unpack_from("<HxxxxxxQ", content, at)
        at += 16 + (length + 7) // 8 * 8 if index != 0 else 0
    struct.pack_into("<Q", content, at + 8, 0)
    with open("heap.h5", "wb") as file:
        file.write(content)
    refused("heap.h5", 4, "heap.h5: damaged? not opened after 4 s of processor time")


@case
def imaris():
    """The layout of Imaris 5.5 as its maker describes it, by h5py: attributes a character each, arrays filled up to chunks."""
    import h5py
    values = phantom(np.uint16)

    def put(group, **attributes):
        for name, value in attributes.items():
            group.attrs[name] = np.array([c.encode() for c in str(value)], "S1")

    with h5py.File("phantom.ims", "w") as file:
        image = file.create_group("DataSetInfo/Image")
        put(image, Unit="um", X=SIZE[0], Y=SIZE[1], Z=SIZE[2])
        for a in range(3):
            put(image, **{f"ExtMin{a}": FIRST[a] - SPACING[a] / 2, f"ExtMax{a}": FIRST[a] + SPACING[a] * (SIZE[a] - 0.5)})
        for t in 0, 1:
            put(file.require_group("DataSetInfo/TimeInfo"), **{f"TimePoint{t + 1}": f"2005-06-06 12:00:{30 * t:02d}.000"})
            for c, name in enumerate(("DAPI", "GFP")):
                put(file.require_group(f"DataSetInfo/Channel {c}"), Name=name)
                for level in 0, 1:
                    part = (values + 2 * t + c)[::1 + level, ::1 + level, ::1 + level]
                    group = file.create_group(f"DataSet/ResolutionLevel {level}/TimePoint {t}/Channel {c}")
                    put(group, ImageSizeX=part.shape[2], ImageSizeY=part.shape[1], ImageSizeZ=part.shape[0])
                    filled = np.zeros([-(-n // 4) * 4 for n in part.shape], np.uint16)
                    filled[tuple(slice(0, n) for n in part.shape)] = part
                    group.create_dataset("Data", data=filled, chunks=(4, 4, 4), compression="gzip")
    where = (np.diag(SPACING) / 1000, FIRST / 1000, False)
    same("phantom.ims", values, *where, ["--frame", "0", "--channel", "0"], unit="um")
    same("phantom.ims", values + 3, *where, ["--frame", "1", "--channel", "gfp"])
    must_choose("phantom.ims", "has 2 frames (30 s apart)", ["--channel", "0"])
    must_choose("phantom.ims", "chooses one of them: 0 DAPI, 1 GFP", ["--frame", "0"])
    expect(load("phantom.ims:DataSet/ResolutionLevel 1/TimePoint 0/Channel 1/Data")[0].shape == (4, 7, 6), "its second level")
    cut("phantom.ims", "cut.ims", 0.8)
    refused("cut.ims", 4, "cut.ims: ", ["--frame", "0", "--channel", "0"])


@case
def netcdf():
    import netCDF4
    for kind in "NETCDF3_CLASSIC", "NETCDF3_64BIT_OFFSET", "NETCDF3_64BIT_DATA", "NETCDF4":
        values = phantom(np.float32)
        with netCDF4.Dataset("phantom.nc", "w", format=kind) as file:
            for axis, name in enumerate("zyx"):
                i = "xyz".index(name)
                file.createDimension(name, SIZE[i])
                at = file.createVariable(name, "f4", (name,))
                at[:] = FIRST[i] + np.arange(SIZE[i]) * SPACING[i] * (-1 if name == "y" else 1)
                at.units = "m" if name == "z" else "micron"
            v = file.createVariable("density", "f4", ("z", "y", "x"), **({"zlib": True} if kind == "NETCDF4" else {}))
            v[:], v.units = values, "kg m-3"
        unit = np.array([1e-3, 1e-3, 1e3])
        # coordinates are floats
        same("phantom.nc", values, np.diag(SPACING * [1, -1, 1] * unit), FIRST * unit, False, unit="um", tolerance=1e-3,
             value_unit="kg m-3")
        same("phantom.nc:density", values, np.diag(SPACING * [1, -1, 1] * unit), FIRST * unit, False, tolerance=1e-3)
        refused("phantom.nc:x", 2, 'has no dataset "x" of three axes, FILE:DATASET must name one of: density (11 x 13 x 7)')
        cut("phantom.nc", "cut.nc", 0.7)
        refused("cut.nc", 4, "cut.nc: ")
    # Axes in another order, packed values, and levels that are not equally far apart.
    stored = phantom(np.int16)
    with netCDF4.Dataset("packed.nc", "w", format="NETCDF3_CLASSIC") as file:
        for name, n, step in ("time", 1, 1), ("lon", 7, 2.5), ("lat", 13, 0.5), ("lev", 11, 0.75):
            file.createDimension(name, n)
            at = file.createVariable(name, "f8", (name,))
            at[:], at.units = np.arange(n) * step, "cm"
        v = file.createVariable("t", "i2", ("time", "lon", "lat", "lev"))
        v.set_auto_maskandscale(False)
        v[0], v.scale_factor, v.add_offset = stored, 0.5, 3.0
    turned = np.zeros((3, 3))
    turned[2, 0], turned[1, 1], turned[0, 2] = SPACING * 10
    same("packed.nc", (stored * 0.5 + 3).astype(np.float32), turned, np.zeros(3), False, unit="cm")
    same("packed.nc", stored, turned, np.zeros(3), False, ["--stored"])
    with netCDF4.Dataset("packed.nc", "r+") as file:
        file["lev"][:] = file["lev"][:] ** 2
    refused("packed.nc", 4, "does not state the spacing evenly: the steps of lev are")
    with netCDF4.Dataset("packed.nc", "r+") as file:
        file["lat"].units = "degrees_north"
    refused("packed.nc", 4, 'unknown unit "degrees_north"', ["--spacing", "1"])


def classic(version, name_bytes=1, axes=3, attribute_bytes=1):
    """A classic netCDF file, byte by byte: a dimension of 2, and a variable of eight bytes with it along each axis."""
    def number(n):
        return n.to_bytes(8 if version == 5 else 4, "big")

    def name(letter, n):
        return number(n) + letter * n + b"\0" * (-n % 4)

    def word(n):
        return n.to_bytes(4, "big")

    place_bytes = 4 if version == 1 else 8
    head = b"".join([b"CDF", bytes([version]), number(0),
                     word(10), number(1), name(b"d", name_bytes), number(2),
                     word(12), number(1), name(b"a", attribute_bytes), word(1), number(1), b"x\0\0\0",
                     word(11), number(1), name(b"v", 1), number(axes), number(0) * axes,
                     word(0), number(0), word(1), number(8)])
    return head + (len(head) + place_bytes).to_bytes(place_bytes, "big") + bytes(range(8))


@case
def netcdf_headers():
    """Names and lists that netCDF's library would copy into buffers of 256 bytes and 1024 numbers."""
    def written(*args, **more):
        with open("header.nc", "wb") as file:
            file.write(classic(*args, **more))
        return "header.nc"

    cube, spacing = np.arange(8, dtype=np.uint8).reshape(2, 2, 2), ["--spacing", "1"]
    for version in 1, 2, 5:
        for name_bytes in 1, 5, 256:
            same(written(version, name_bytes, attribute_bytes=name_bytes), cube, np.eye(3), None, False, spacing)
        refused(written(version, 257), 4, "damaged netCDF header: 257 bytes in a name, at most 256")
        refused(written(version, attribute_bytes=5000), 4, "5000 bytes in a name, at most 256")
        refused(written(version, axes=1025), 4, "1025 dimensions of a variable, at most 1024")
        with open("header.nc", "wb") as file:
            file.write(classic(version)[:60])
        refused("header.nc", 4, "damaged netCDF header: ")


@case
def minc():
    values = phantom()
    steps = [word for axis, r in zip("xyz", range(3)) for word in
             (f"-{axis}step", str(SPACING[r]), f"-{axis}start", str(np.linalg.solve(STEPS / SPACING, FIRST)[r]),
              f"-{axis}dircos", *(str(c) for c in STEPS[:, r] / SPACING[r]))]
    values.tofile("minc.raw")
    for version in [], ["-2"]:
        subprocess.run(["rawtominc", "-clobber", *version, "-signed", "-short", "-oshort", "-osigned", "-range", "-32768", "32767",
                        "-real_range", "-32768", "32767", *steps, "-input", "minc.raw", "phantom.mnc", "7", "13", "11"],
                       check=True, stdout=subprocess.DEVNULL)
        same("phantom.mnc", values, unit="mm", tolerance=1e-4)
        cut("phantom.mnc", "cut.mnc")
        refused("cut.mnc", 4, "cut.mnc: ")
        # A scale of each slice.
        subprocess.run(["rawtominc", "-clobber", *version, "-signed", "-short", "-oshort", "-osigned", "-scan_range",
                        *steps, "-input", "minc.raw", "scaled.mnc", "7", "13", "11"], check=True, stdout=subprocess.DEVNULL)
        got = load("scaled.mnc")[0]
        expect(np.abs(got - values).max() < 0.1 and got.dtype == np.float32, f"values off by {np.abs(got - values).max()}")
        # Frames and vectors, of which each slice has a scale of its own.
        both = np.stack([values, 3 * values + 7])
        both.tofile("minc4.raw")
        subprocess.run(["rawtominc", "-clobber", *version, "-signed", "-short", "-oshort", "-osigned", "-scan_range", *steps,
                        "-input", "minc4.raw", "times.mnc", "2", "7", "13", "11"], check=True, stdout=subprocess.DEVNULL)
        must_choose("times.mnc", "has 2 frames")
        for k in range(2):
            got = load("times.mnc", ["--frame", str(k)])[0]
            expect(np.abs(got - both[k]).max() < 0.2, f"frame {k}: off by {np.abs(got - both[k]).max()}")
        expect(np.abs(got - both[0]).max() > 1, "the frames are one")  # the test's power
        np.ascontiguousarray(np.moveaxis(both, 0, -1)).tofile("minc4.raw")
        subprocess.run(["rawtominc", "-clobber", *version, "-signed", "-short", "-oshort", "-osigned", "-range", "-32768", "32767",
                        "-real_range", "-32768", "32767", *steps, "-vector", "2", "-input", "minc4.raw", "vector.mnc", "7", "13",
                        "11"], check=True, stdout=subprocess.DEVNULL)
        must_choose("vector.mnc", "has 2 channels a voxel")
        same("vector.mnc", both[1], options=["--channel", "1"], tolerance=1e-4)


def zarr_group(path):
    import zarr
    return zarr.open_group(path, mode="w", **({"zarr_format": 2} if zarr.__version__[0] > "2" else {}))


def zarr_array(group, name, data, chunks=None, codec=None, separator=".", dtype=None, order="C"):
    import zarr
    how = {"shape": data.shape, "chunks": chunks or data.shape, "dtype": np.dtype(dtype or data.dtype), "order": order,
           "fill_value": 0}
    if zarr.__version__[0] > "2":
        array = group.create_array(name, compressors=codec, chunk_key_encoding={"name": "v2", "separator": separator}, **how)
    else:
        array = group.create_dataset(name, compressor=codec, dimension_separator=separator, **how)
    array[...] = data


@case
def ome_zarr():
    import numcodecs
    values = phantom(np.uint16)
    scale = [{"type": "scale", "scale": [1, *SPACING[::-1]]}, {"type": "translation", "translation": [0, *FIRST[::-1]]}]
    axes = [{"name": "c", "type": "channel"}] + [{"name": n, "type": "space", "unit": "micrometer"} for n in "zyx"]
    codecs = [None, numcodecs.Zlib(), numcodecs.GZip(), numcodecs.Zstd()] + [
        numcodecs.Blosc(name, shuffle=shuffle) for name, shuffle in (("lz4", 1), ("zstd", 2), ("blosclz", 0), ("zlib", 1))]
    for number, codec in enumerate(codecs):
        shutil.rmtree("phantom.zarr", ignore_errors=True)
        group = zarr_group("phantom.zarr")
        for level in 0, 1:
            data = values[None, ::2 ** level, ::2 ** level, ::2 ** level]
            zarr_array(group, str(level), data, (1, 3, 8, 5), codec, "/" if number % 2 else ".",
                       ">u2" if number == 1 else None, "F" if number == 2 else "C")
        group.attrs["multiscales"] = [{"version": "0.4", "axes": axes, "datasets": [
            {"path": str(k), "coordinateTransformations": scale} for k in (0, 1)]}]
        same("phantom.zarr", values, np.diag(SPACING) / 1000, FIRST / 1000, False, unit="um")
    zarr_group("converted.zarr").attrs["bioformats2raw.layout"] = 3
    shutil.copytree("phantom.zarr", "converted.zarr/0")
    same("converted.zarr", values, np.diag(SPACING) / 1000, FIRST / 1000, False, unit="um")
    shutil.copytree("phantom.zarr", "converted.zarr/1")
    refused("converted.zarr", 2, "FILE:DATASET must name one of: 0/0 (11 x 13 x 7 x 1), 0/1")
    same("converted.zarr:1/0", values, np.diag(SPACING) / 1000, FIRST / 1000, False, unit="um")
    refused("phantom.zarr:2", 2, 'has no dataset "2" of three axes, FILE:DATASET must name one of: 0 (11 x 13 x 7 x 1), 1 (6 x 7 x 4 x 1)')
    expect(load("phantom.zarr:1")[0].shape == (4, 7, 6), "the other level is of another size")
    same("phantom.zarr/0", values, np.diag(SPACING), None, False, ["--spacing", "0.75x0.5x2.5"])
    refused("phantom.zarr/0", 4, "does not state the spacing of its voxels")
    cut("phantom.zarr/0/0/1/0/1", "chunk", 0.6)
    shutil.copy("chunk", "phantom.zarr/0/0/1/0/1")
    info = run("build", "phantom.zarr", "-q", "-o", "cut.iso")
    expect(info.returncode == 4 and "truncated or damaged" in info.stderr, info.stderr)
    os.remove("phantom.zarr/0/0/1/0/1")  # never written: the fill value
    expect((load("phantom.zarr")[0] == 0).sum() > 50, "no fill value")
    with open("phantom.zarr/0/.zarray", "w", encoding="ascii") as file:
        file.write('{"zarr_format": 2, "shape"')
    refused("phantom.zarr", 4, "phantom.zarr/0/.zarray: line 1: ")
    group = zarr_group("times.zarr")
    zarr_array(group, "0", np.stack([values, values + 1]))
    group.attrs["multiscales"] = [{"version": "0.4", "axes": [{"name": "t", "type": "time"}, *axes[1:]],
                                   "datasets": [{"path": "0", "coordinateTransformations": scale}]}]
    must_choose("times.zarr", "has 2 frames; --frame K chooses one, from 0 to 1")
    same("times.zarr", values + 1, np.diag(SPACING) / 1000, FIRST / 1000, False, ["--frame", "1"])
    group = zarr_group("colors.zarr")
    zarr_array(group, "0", np.stack([np.stack([values + 2 * t + c for c in (0, 1)]) for t in (0, 1, 2)]))
    group.attrs["multiscales"] = [{"version": "0.4", "axes": [{"name": "t", "type": "time"}, *axes],
                                   "datasets": [{"path": "0", "coordinateTransformations": [
                                       {"type": "scale", "scale": [1, 1, *SPACING[::-1]]}]}]}]
    group.attrs["omero"] = {"channels": [{"label": "DAPI"}, {"label": "GFP"}]}
    must_choose("colors.zarr", "has 2 channels a voxel; --channel chooses one of them: 0 DAPI, 1 GFP", ["--frame", "2"])
    same("colors.zarr", values + 5, np.diag(SPACING) / 1000, np.zeros(3), False, ["--frame", "2", "--channel", "gfp"])
    os.makedirs("new.zarr/0", exist_ok=True)  # OME-Zarr 0.5, which is of Zarr 3
    with open("new.zarr/zarr.json", "w", encoding="ascii") as file:
        json.dump({"zarr_format": 3, "node_type": "group", "attributes": {"ome": {
            "version": "0.5", "multiscales": [{"axes": axes[1:], "datasets": [{"path": "0", "coordinateTransformations": [
                {"type": s["type"], s["type"]: s[s["type"]][1:]} for s in scale]}]}]}}}, file)
    with open("new.zarr/0/zarr.json", "w", encoding="ascii") as file:
        json.dump({"zarr_format": 3, "node_type": "array", "shape": values.shape, "data_type": "uint16", "fill_value": 0,
                   "chunk_grid": {"name": "regular", "configuration": {"chunk_shape": values.shape}},
                   "chunk_key_encoding": {"name": "v2"}, "codecs": [{"name": "bytes", "configuration": {"endian": "little"}}],
                   "attributes": {}}, file)
    values.astype("<u2").tofile("new.zarr/0/0.0.0")
    same("new.zarr", values, np.diag(SPACING) / 1000, FIRST / 1000, False, unit="um")
    for dtype in np.float16, np.float32, np.int8, bool:
        stored = (phantom(np.int16) % 100).astype(dtype)
        zarr_array(zarr_group("types.zarr"), "0", stored)
        same("types.zarr", stored.astype({"float16": np.float32, "bool": np.uint8}.get(np.dtype(dtype).name, dtype)),
             np.diag(SPACING), None, False, ["--spacing", "0.75x0.5x2.5"])
    os.makedirs("many.zarr")
    with open("many.zarr/.zarray", "w", encoding="ascii") as file:
        json.dump({"zarr_format": 2, "shape": [2, 1 << 24, 2], "chunks": [2, 2, 2], "dtype": "<u2", "compressor": None,
                   "fill_value": 0, "order": "C", "filters": None}, file)
    refused("many.zarr", 4, "more than 2097152 chunks")  # each of which would be looked for
    empty_chunks()


def empty_chunks():
    """Chunks that are not there are of the fill value: of a huge volume not all. And axes without coordinates."""
    import numcodecs

    def describe(folder, shape, chunks, axes, codec=None):
        os.makedirs(folder)
        with open(f"{folder}/.zarray", "w", encoding="ascii") as file:
            json.dump({"zarr_format": 2, "shape": shape, "chunks": chunks, "dtype": "|u1", "compressor": codec,
                       "fill_value": 0, "order": "C", "filters": None}, file)
        with open(f"{folder}/.zattrs", "w", encoding="ascii") as file:
            json.dump({"_ARRAY_DIMENSIONS": axes}, file)
    for number, (shape, chunks) in enumerate((([2000000000, 1, 1], [1000000, 1, 1]), ([5000] * 3, [1, 5000, 5000]))):
        describe(f"void{number}.zarr", shape, chunks, list("zyx"))
        refused(f"void{number}.zarr", 4, "its chunks have 0 bytes, each of which can hold 131072 of samples",
                ["--spacing", "1"])
    # Of 3000 chunks of 30 kB one is there, or none; and of 512 small ones none.
    describe("large.zarr", [3000, 300, 100], [1, 300, 100], list("zyx"))
    describe("sparse.zarr", [3000, 300, 100], [1, 300, 100], list("zyx"))
    with open("sparse.zarr/7.0.0", "wb") as file:
        file.write(bytes([5]) * 30000)
    describe("small.zarr", [16] * 3, [2] * 3, list("zyx"))
    # One chunk, of which zstd makes a 10000th; and one of fewer bytes than any that unpack to so many.
    one = np.zeros((640, 512, 512), np.uint8)
    one[3, 4, 5] = 7
    describe("one.zarr", one.shape, one.shape, list("zyx"), {"id": "zstd"})
    with open("one.zarr/0.0.0", "wb") as file:
        file.write(numcodecs.Zstd().encode(one))
    describe("bomb.zarr", [1290] * 3, [1290] * 3, list("zyx"), {"id": "zstd"})
    with open("bomb.zarr/0.0.0", "wb") as file:
        file.write(bytes(1000))
    refused("bomb.zarr", 4, "does not unpack to 2146689000 bytes", ["--spacing", "1"])
    for folder, most in ("sparse.zarr", 5), ("large.zarr", 0), ("small.zarr", 0), ("one.zarr", 7):
        got = json.loads(run("info", folder, "--spacing", "1", "--json").stdout)
        expect(got["max"] == most, f"{folder}: largest value {got['max']}")
    os.makedirs("none.zarr")
    with open("none.zarr/.zgroup", "w", encoding="ascii") as file:
        file.write('{"zarr_format": 2}')
    describe("none.zarr/v", [2, 2, 2], [2, 2, 2], list("zyx"))
    for axis in "zyx":
        describe(f"none.zarr/{axis}", [0], [1], [axis])
    refused("none.zarr:v", 4, "does not state the spacing of its voxels")


# ---- OpenVDB by its own module, and by isoshade ----

def vdb_grid(values, kind, name, steps=STEPS, first=FIRST, background=0, half=False):
    grid = kind(background)
    grid.copyFromArray(np.ascontiguousarray(values.T), ijk=(3, -2, 100))
    m = np.eye(4)
    m[:3, :3], m[3, :3] = steps.T, first - steps @ [3, -2, 100]
    grid.transform = openvdb_module().createLinearTransform(m.tolist())
    grid.name, grid.saveFloatAsHalf = name, half
    return grid


def openvdb_module():
    try:
        import pyopenvdb
        return pyopenvdb
    except ImportError:  # its name since OpenVDB 11
        import openvdb
        return openvdb


@case
def openvdb():
    vdb, values, sheared = openvdb_module(), phantom(np.float32), STEPS.copy()
    sheared[:, 2] += 0.3 * STEPS[:, 0]
    vdb.write("phantom.vdb", vdb_grid(values, vdb.FloatGrid, "density"))
    same("phantom.vdb", values, ras=False)
    same("phantom.vdb:density", values, STEPS * 1e-6, FIRST * 1e-6, False, ["--unit", "nm"], "nm")
    cut("phantom.vdb", "cut.vdb")
    refused("cut.vdb", 4, "cut.vdb: ")
    vdb.write("phantom.vdb", vdb_grid(values, vdb.FloatGrid, "density", sheared, half=True))
    same("phantom.vdb", values.astype(np.float16).astype(np.float32), sheared, ras=False)
    holes = values.copy()
    holes[2:5, 3:6, 4:9] = -7
    speed = vdb.Vec3SGrid()
    speed.name = "speed"
    vdb.write("several.vdb", [vdb_grid(holes, vdb.FloatGrid, "a", background=-7),
                              vdb_grid(values > 0, vdb.BoolGrid, "mask", background=False), speed])
    refused("several.vdb", 2, "holds 2 scalar grids, FILE:GRID must name one of: a (float), mask (bool), speed (vec3s)")
    refused("several.vdb:b", 2, 'has no grid "b"')
    refused("several.vdb:speed", 4, "values of type vec3s")
    same("several.vdb:a", holes, ras=False)
    vdb.write("empty.vdb", [vdb.FloatGrid()])
    refused("empty.vdb", 4, "has no active voxels")


@case
def openvdb_of_isoshade():
    """build, export, read back: the same samples at the same place, in the unit that the file names."""
    import vtk
    for scale, unit in (1, "mm"), (1e-7, "angstrom"):
        values = phantom(np.float32)
        vtk_write(vtk.vtkXMLImageDataWriter(), vtk_image(values, STEPS, FIRST), "phantom.vti")
        shutil.rmtree("vdb.iso", ignore_errors=True)
        for words in (["build", "phantom.vti", "--levels", "2", "--unit", unit, "-q", "-o", "vdb.iso"],
                      ["export", "vdb.iso", "--to", "vdb", "--level", "0", "-q", "-o", "own.vdb"]):
            got = run(*words)
            expect(got.returncode == 0, got.stderr)
        same("own.vdb", values, STEPS * scale, FIRST * scale, False, unit=unit, tolerance=1e-10 * scale)
        with open("vdb.iso/pyramid.json", encoding="utf-8") as file:
            expect(json.load(file)["unit"]["name"] == unit, "pyramid.json names another unit")
        expect(f"unit       of its file: {unit}" in run("info", "vdb.iso").stdout, "info names another unit")


    # left-handed, and a coarse level whose grid is larger than the box: 11 voxels along x are 6 of two, the last half out
    values, mirrored = phantom(np.float32), STEPS * [-1, 1, 1]
    image = vtk_image(values, np.abs(mirrored), FIRST)
    image.SetDirectionMatrix((mirrored / SPACING).ravel())
    vtk_write(vtk.vtkXMLImageDataWriter(), image, "left.vti")
    for words in (["build", "left.vti", "--levels", "2", "-q", "-o", "left.iso"],
                  ["export", "left.iso", "--to", "vdb", "--level", "0", "-q", "-o", "left.vdb"],
                  ["export", "left.iso", "--to", "vdb", "--level", "1", "-q", "-o", "left1.vdb"],
                  ["build", "left1.vdb", "--levels", "1", "-q", "-o", "left1.iso"]):
        got = run(*words)
        expect(got.returncode == 0, got.stderr)
    same("left.vdb", values, mirrored, FIRST, False, unit="mm", tolerance=1e-10)
    levels = []
    for name, level in ("left.iso", 1), ("left1.iso", 0):
        with open(f"{name}/pyramid.json", encoding="utf-8") as file:
            levels.append(json.load(file)["levels"][level])
    a, b = (level["geometry"] for level in levels)
    expect(a["size"] == b["size"] and np.allclose(a["index_to_world"], b["index_to_world"], atol=1e-12) and
           np.allclose(a["origin_mm"], b["origin_mm"], atol=1e-9) and np.allclose(a["box_index"], b["box_index"]),
           f"level 1 comes back as {b}, it was {a}")
    with open("left.iso/" + levels[0]["files"]["scalar"]["name"], "rb") as x, \
            open("left1.iso/" + levels[1]["files"]["scalar"]["name"], "rb") as y:
        n = int(np.prod(a["size"])) * 4
        expect(x.read()[-n:] == y.read()[-n:], "level 1 has other samples")
