# SPDX-License-Identifier: MIT
"""Files of several time steps, several numbers a voxel, or several files a series, written by other programs.

    frames_in.py ISOSHADE [CASE ...]      as formats_in.py, with the phantom varied in each frame and each channel
"""
import json
import os
import shutil
import subprocess
import sys

import numpy as np

from phantom import (FIRST, LPS, SPACING, STEPS, Wrong, cut, expect, main, must_choose, phantom, refused, run, same,
                     vtk_image, vtk_write)

CASES = {}


def case(f):
    CASES[f.__name__] = f
    return f


def series(count=3, dtype=np.int16):
    """[t, z, y, x]: each time step another one, the landmark the largest value of each."""
    return np.stack([phantom(dtype) + np.dtype(dtype).type(5 * t) for t in range(count)])


def info(path, *options):
    got = run("info", path, "--json", *options)
    expect(got.returncode == 0, f"info ends with {got.returncode}: {got.stderr.strip()}")
    return json.loads(got.stdout)


def each_frame(path, values, said=(0, ""), **more):
    """The first and the last frame, and what is said of them."""
    for t in 0, len(values) - 1:
        same(path, values[t], options=["--frame", str(t)], **more)
    about = info(path, "--frame", "1")
    expect((about["frames"], about["frame"]) == (len(values), 1), f"frames {about['frames']}, frame {about['frame']}")
    expect((about["frame_step"], about["frame_unit"]) == said,
           f"the frames are {about['frame_step']} {about['frame_unit']} apart, not {said}")
    must_choose(path, f"has {len(values)} frames")
    refused(path, 2, f'numbered from 0 to {len(values) - 1}; --frame is "{len(values)}"', ["--frame", str(len(values))])
    refused(path, 2, '--frame is "-1"', ["--frame=-1"])


def each_channel(path, values, names=None, **more):
    for c, one in enumerate(values):
        same(path, one, options=["--channel", names[c] if names and c else str(c)], **more)
    about = info(path, "--channel", "1")
    expect((about["channels"], about["channel"]) == (len(values), 1), f"channels {about['channels']}")
    must_choose(path, f"has {len(values)} channels a voxel; --channel chooses one of them: 0 ")
    refused(path, 2, '--channel is "purple"', ["--channel", "purple"])


def luminance(colors):
    """[..., 3 or 4]"""
    c = colors.astype(np.float64)
    return (0.2126 * c[..., 0] + 0.7152 * c[..., 1] + 0.0722 * c[..., 2]).astype(np.float32)


def colors(count=3):
    """[z, y, x, c] of bytes."""
    base = phantom(np.uint8)
    rest = [(base // (c + 1)).astype(np.uint8) for c in range(count)]
    return np.stack(rest, -1)


def affine():
    a = np.eye(4)
    a[:3, :3], a[:3, 3] = STEPS, FIRST
    return a


@case
def nifti_time():
    import nibabel
    values = series()
    for suffix in "nii", "nii.gz":
        image = nibabel.Nifti1Image(values.T, affine())
        image.header.set_xyzt_units("mm", "sec")
        image.header["pixdim"][4] = 2.5
        nibabel.save(image, f"time.{suffix}")
    each_frame("time.nii", values, (2.5, "s"), tolerance=1e-5)
    same("time.nii.gz", values[1], tolerance=1e-5, options=["--frame", "1"])
    image.header.set_slope_inter(0.5, -3)
    nibabel.save(image, "scaled.nii")
    stored = np.asanyarray(nibabel.load("scaled.nii").dataobj.get_unscaled()).T
    same("scaled.nii", (0.5 * stored[2] - 3).astype(np.float32), tolerance=1e-5, options=["--frame", "2"])
    cut("time.nii", "cut.nii", 0.9)
    refused("cut.nii", 4, "truncated", ["--frame", "0"])
    # the last frame's samples end early; frames before it are there
    cut("time.nii.gz", "cut.nii.gz", 0.9)
    refused("cut.nii.gz", 4, "truncated", ["--frame", "2"])
    # time and components; and five axes of one component
    both = np.stack([values, values + 100])  # [c, t, z, y, x]
    nibabel.save(nibabel.Nifti1Image(both.T, affine()), "both.nii")
    same("both.nii", both[1, 2], tolerance=1e-5, options=["--frame", "2", "--channel", "1"])
    must_choose("both.nii", "has 3 frames", ["--channel", "1"])
    must_choose("both.nii", "has 2 channels a voxel", ["--frame", "1"])
    nibabel.save(nibabel.Nifti1Image(values[None].T, affine()), "five.nii")
    same("five.nii", values[1], tolerance=1e-5, options=["--frame", "1"])


@case
def nifti_colors():
    import nibabel
    rgb = colors()
    packed = np.zeros(rgb.shape[:3], [("R", "u1"), ("G", "u1"), ("B", "u1")])
    for c, name in enumerate("RGB"):
        packed[name] = rgb[..., c]
    nibabel.save(nibabel.Nifti1Image(packed.T, affine()), "rgb.nii.gz")
    each_channel("rgb.nii.gz", [rgb[..., c] for c in range(3)], ["red", "green", "blue"], tolerance=1e-5)
    same("rgb.nii.gz", luminance(rgb), tolerance=1e-5, options=["--channel", "luminance"])


def nhdr(name, values, axes, kinds, encodings):
    """A header of NRRD beside the samples, which unu then writes as one file; axes: -1 for one that is not of space."""
    values.tofile(f"{name}.raw")
    steps = ["none" if a < 0 else "(" + ",".join(f"{c:.17g}" for c in LPS @ STEPS[:, a]) + ")" for a in axes]
    origin = "(" + ",".join(f"{c:.17g}" for c in LPS @ FIRST) + ")"
    kind = {"int16": "short", "uint8": "uchar", "float32": "float"}[str(values.dtype)]
    with open(f"{name}.nhdr", "w", encoding="ascii") as file:
        file.write(f"NRRD0005\ntype: {kind}\ndimension: {values.ndim}\nspace: left-posterior-superior\n"
                   f"sizes: {' '.join(str(n) for n in values.shape[::-1])}\nspace directions: {' '.join(steps)}\n"
                   f"kinds: {kinds}\nspace origin: {origin}\nencoding: raw\nendian: little\n"
                   f"data file: {name}.raw\n")
    for encoding in encodings:
        subprocess.run(["teem-unu", "save", "-f", "nrrd", "-e", encoding, "-i", f"{name}.nhdr", "-o", f"{name}.{encoding}.nrrd"],
                       check=True)
        yield f"{name}.{encoding}.nrrd"


@case
def nrrd_time():
    values = series()
    # Behind the axes of space, as unu join -a 3 has it; before them, as 3D Slicer's sequences and multivolumes.
    for file in nhdr("behind", values, [0, 1, 2, -1], "domain domain domain time", ["raw"]):
        each_frame(file, values)
    for file in nhdr("behind", values, [0, 1, 2, -1], "domain domain domain time", ["gzip", "ascii"]):
        same(file, values[2], options=["--frame", "2"])
    inside = np.moveaxis(values, 0, -1).copy()
    for file in nhdr("inside", inside, [-1, 0, 1, 2], "list domain domain domain", ["raw"]):
        each_frame(file, values)
    # Without directions and kinds the last of four axes is time, where the first has more than four samples.
    values.tofile("bare.raw")
    subprocess.run(["teem-unu", "make", "-t", "short", "-s", "11", "13", "7", "3", "-sp", "0.75", "0.5", "2.5", "40",
                    "-u", "mm", "mm", "mm", "ms", "-e", "raw", "-en", "little", "-i", "bare.raw", "-o", "bare.nrrd"],
                   check=True)
    with open("bare.nrrd", "rb") as file:
        data = file.read()
    with open("bare.nrrd", "wb") as file:  # teem 1.11 leaves units away when it writes
        file.write(data.replace(b'units: "" "" "" ""', b'units: "mm" "mm" "mm" "ms"'))
    each_frame("bare.nrrd", values, (40, "ms"), steps=np.diag(SPACING), first=None, ras=False)
    cut("behind.raw.nrrd", "cut.nrrd")
    refused("cut.nrrd", 4, "truncated", ["--frame", "0"])


@case
def nrrd_colors():
    rgb = colors()
    for file in nhdr("rgb", rgb, [-1, 0, 1, 2], "RGB-color domain domain domain", ["raw", "ascii"]):
        each_channel(file, [rgb[..., c] for c in range(3)], ["red", "green", "blue"])
        same(file, luminance(rgb), options=["--channel", "luminance"])
    vector = np.stack([phantom(np.float32) * f for f in (1, 2)], -1).astype(np.float32)
    for file in nhdr("vector", vector, [-1, 0, 1, 2], "vector domain domain domain", ["gzip"]):
        same(file, vector[..., 1], options=["--channel", "1"])
        must_choose(file, "chooses one of them: 0 to 1")
        refused(file, 2, '--channel is "luminance"', ["--channel", "luminance"])
    # Without kinds a first axis of at most four is of components, which have no names.
    rgb.tofile("bare.raw")
    subprocess.run(["teem-unu", "make", "-t", "uchar", "-s", "3", "11", "13", "7", "-sp", "nan", "1", "1", "1", "-e", "raw", "-i", "bare.raw",
                    "-o", "bare.nrrd"], check=True)
    same("bare.nrrd", rgb[..., 2], np.eye(3), None, False, ["--channel", "2"])
    must_choose("bare.nrrd", "chooses one of them: 0 to 2")


@case
def metaimage_channels():
    import vtk
    rgb = colors()
    image = vtk_image(rgb[..., 0].copy(), np.diag(SPACING), [1, 2, 3])
    image.GetPointData().SetScalars(vtk_array(rgb))
    writer = vtk.vtkMetaImageWriter()
    for pack in False, True:
        writer.SetCompression(pack)
        vtk_write(writer, image, "rgb.mha")
        same("rgb.mha", rgb[..., 2], LPS @ np.diag(SPACING), LPS @ [1, 2, 3], options=["--channel", "2"])
        same("rgb.mha", luminance(rgb), LPS @ np.diag(SPACING), LPS @ [1, 2, 3], options=["--channel", "luminance"])
        must_choose("rgb.mha", "has 3 channels a voxel; --channel chooses one of them: 0 red, 1 green, 2 blue")


def vtk_array(values):
    """[z, y, x, c]"""
    from vtk.util import numpy_support
    array = numpy_support.numpy_to_vtk(values.reshape(-1, values.shape[-1]), deep=True)
    array.SetName("values")
    return array


@case
def metaimage_time():
    # ITK's own header of four axes
    values = series()
    turn = " ".join(f"{c:.12g}" for c in np.block([[LPS @ STEPS / SPACING, np.zeros((3, 1))],
                                                    [np.zeros((1, 3)), np.ones((1, 1))]]).T.ravel())
    place = " ".join(f"{c:.12g}" for c in (*(LPS @ FIRST), 0))
    with open("time.mha", "wb") as file:
        file.write(f"ObjectType = Image\nNDims = 4\nBinaryData = True\nBinaryDataByteOrderMSB = False\n"
                   f"TransformMatrix = {turn}\nOffset = {place}\nElementSpacing = 0.75 0.5 2.5 1.5\n"
                   f"DimSize = 11 13 7 3\nElementType = MET_SHORT\nElementDataFile = LOCAL\n".encode())
        file.write(values.tobytes())
    each_frame("time.mha", values, (1.5, ""))


@case
def vtk_channels():
    import vtk
    rgb = colors()
    image = vtk_image(rgb[..., 0].copy(), np.diag(SPACING), [1, 2, 3])
    image.GetPointData().SetScalars(vtk_array(rgb))
    where = (np.diag(SPACING), [1, 2, 3], False)
    writer = vtk.vtkStructuredPointsWriter()
    writer.SetFileTypeToBinary()
    vtk_write(writer, image, "rgb.vtk")
    for mode in 0, 1, 2:
        writer = vtk.vtkXMLImageDataWriter()
        writer.SetDataMode(mode)
        vtk_write(writer, image, f"rgb{mode}.vti")
    for c, (file, name) in enumerate((("rgb.vtk", "red"), ("rgb0.vti", "green"), ("rgb1.vti", "blue"), ("rgb2.vti", "0"))):
        same(file, rgb[..., c % 3], *where, ["--channel", name])
    for file in "rgb.vtk", "rgb2.vti":
        same(file, luminance(rgb), *where, ["--channel", "luminance"])
        must_choose(file, "has 3 channels a voxel; --channel chooses one of them: 0 red, 1 green, 2 blue, luminance")
    named = vtk_array(colors(2).astype(np.float32))
    named.SetComponentName(0, "speed")
    named.SetComponentName(1, "pressure")
    image.GetPointData().SetScalars(named)
    vtk_write(vtk.vtkXMLImageDataWriter(), image, "named.vti")
    same("named.vti", colors(2)[..., 1].astype(np.float32), *where, ["--channel", "pressure"])
    must_choose("named.vti", "0 speed, 1 pressure")


@case
def tiff_frames():
    import tifffile
    values = series(3, np.uint16)
    both = np.stack([values, values + 100], 2)  # [t, z, c, y, x]
    spaced = {"spacing": 2.5, "unit": "mm", "finterval": 0.25}
    tifffile.imwrite("imagej.tif", both, imagej=True, resolution=(1 / 0.75, 1 / 0.5), metadata={"axes": "TZCYX", **spaced})
    where = (np.diag(SPACING), None, False)
    for t, c in (0, 0), (1, 0), (2, 1):
        same("imagej.tif", both[t, :, c], *where, ["--frame", str(t), "--channel", str(c)])
    about = info("imagej.tif", "--frame", "0", "--channel", "0")
    expect((about["frame_step"], about["frame_unit"]) == (0.25, "s"), f"frame step {about['frame_step']}")
    must_choose("imagej.tif", "has 3 frames (0.25 s apart)")
    sizes = {"PhysicalSizeX": 750, "PhysicalSizeY": 500, "PhysicalSizeZ": 2500, "TimeIncrement": 40,
             "TimeIncrementUnit": "ms", "Channel": {"Name": ["DAPI", "GFP"]}}
    for axes, order in ("TZCYX", both), ("TCZYX", both.swapaxes(1, 2)), ("CTZYX", both.transpose(2, 0, 1, 3, 4)):
        tifffile.imwrite("order.ome.tif", order, metadata={"axes": axes, **sizes})
        for t, c, name in (1, 1, "1"), (2, 0, "dapi"):
            same("order.ome.tif", both[t, :, c], *where, ["--frame", str(t), "--channel", name])
    must_choose("order.ome.tif", "has 2 channels a voxel; --channel chooses one of them: 0 DAPI, 1 GFP", ["--frame", "0"])
    rgb = colors()
    tifffile.imwrite("rgb.tif", rgb, photometric="rgb")
    spacing = ["--spacing", "0.75x0.5x2.5"]
    for c, name in enumerate(("red", "green", "blue")):
        same("rgb.tif", rgb[..., c], *where, ["--channel", name, *spacing])
    same("rgb.tif", luminance(rgb), *where, ["--channel", "luminance", *spacing])
    cut("order.ome.tif", "cut.tif", 0.7)
    refused("cut.tif", 4, "cut.tif", ["--frame", "0", "--channel", "0"])


@case
def numbered_files():
    import vtk
    values = series(4)
    for t, one in enumerate(values):
        vtk_write(vtk.vtkXMLImageDataWriter(), vtk_image(one, STEPS, FIRST), f"step_{t * 5 + 8:04d}.vti")
    each_frame("step_%04d.vti", values, ras=False)
    same("./step_%d.vti", values[2], ras=False, options=["--frame", "2"])
    refused("none_%04d.vti", 3, "none_%04d.vti: no file has a number in this place")
    refused("step_%04d.txt", 3, "no file has a number")


# ---- DICOM: several times of a place, in one folder or in one file ----

def dicom_times(folder, values, stamp, order=5):
    """A file for each slice of each time, by stamp(dataset, time, slice); the files' names say nothing."""
    from formats_medical import dicom_slice
    import pydicom
    shutil.rmtree(folder, ignore_errors=True)
    os.makedirs(folder)
    for t, volume in enumerate(values):
        for k, pixels in enumerate(volume):
            number = t * len(volume) + k
            path = f"{folder}/{(number * order) % (len(values) * len(volume)):03d}.dcm"
            dicom_slice(path, pixels, FIRST + STEPS[:, 2] * k, "1.2.3.44", number + 1)
            d = pydicom.dcmread(path)
            stamp(d, t, k)
            d.save_as(path, write_like_original=False)


def set_words(**words):
    def stamp(d, t, k):
        for name, value in words.items():
            setattr(d, name, value(t, k))
    return stamp


@case
def dicom_time():
    values = series()
    stamps = {
        (40, "ms"): set_words(TemporalPositionIdentifier=lambda t, k: t + 1, TemporalResolution=lambda t, k: 40),
        (33, "ms"): set_words(TriggerTime=lambda t, k: 33 * t),
        # each slice at its own time: the order at each place
        (2, "s"): set_words(AcquisitionTime=lambda t, k: f"1000{2 * t:02d}.{(k * 3) % 7:02d}0000"),
        (0, ""): set_words(AcquisitionNumber=lambda t, k: t + 1),
        (4.5, "ms"): set_words(EchoTime=lambda t, k: 1.5 + 4.5 * t, AcquisitionTime=lambda t, k: f"1000{k:02d}"),
    }
    for said, stamp in stamps.items():
        dicom_times("times", values, stamp)
        same("times", values[2], options=["--frame", "2"])
        about = info("times", "--frame", "1")
        expect((about["frames"], about["frame_step"], about["frame_unit"]) == (3, *said), f"frames {about['frames']}, "
               f"{about['frame_step']} {about['frame_unit']} apart, not {said}")
    dicom_times("times", values, set_words(TriggerTime=lambda t, k: 33 * t))
    each_frame("times", values, (33, "ms"), unit="mm")
    os.remove("times/004.dcm")
    refused("times", 4, "2 to 3 slices at a place (a time step is not complete?)", ["--frame", "0"])
    dicom_times("times", values, set_words(ContentTime=lambda t, k: f"1000{t:02d}"))
    refused("times", 4, "3 slices at each place, which no time, echo or b-value distinguishes", ["--frame", "0"])
    dicom_times("times", values[:1], lambda d, t, k: setattr(d, "ImageOrientationPatient", [1, 0, 0, 0, 1, 0]) if k == 3 else None)
    refused("times", 4, "slices are not equally far apart (one is missing?)")  # the turned one is left out
    dicom_times("times", values[:1], lambda d, t, k: setattr(d, "ImageType", ["ORIGINAL", "PRIMARY", "M", "MOSAIC"]))
    refused("times", 4, "a mosaic of slices in one picture")


@case
def dicom_multiframe_time():
    """One file whose frames are in the order of places, then of times, and backwards."""
    import pydicom
    from pydicom.dataset import Dataset
    from formats_medical import dicom_slice
    values = series()
    dicom_slice("enhanced.dcm", values[0, 0], FIRST, "1.2.3.45", 1)
    d = pydicom.dcmread("enhanced.dcm")
    d.SOPClassUID = d.file_meta.MediaStorageSOPClassUID = "1.2.840.10008.5.1.4.1.1.4.1"
    shared, orientation, measures = Dataset(), Dataset(), Dataset()
    orientation.ImageOrientationPatient, measures.PixelSpacing = d.ImageOrientationPatient, d.PixelSpacing
    measures.SliceThickness = "1"
    shared.PlaneOrientationSequence, shared.PixelMeasuresSequence = [orientation], [measures]
    order = [(t, k) for k in range(values.shape[1]) for t in range(3)][::-1]
    d.SharedFunctionalGroupsSequence, d.PerFrameFunctionalGroupsSequence = [shared], []
    d.NumberOfFrames, d.PixelData = len(order), b"".join(values[t, k].tobytes() for t, k in order)
    for word in "ImageOrientationPatient", "ImagePositionPatient", "PixelSpacing", "SliceThickness", "RescaleSlope", "RescaleIntercept":
        delattr(d, word)

    def write(path, **more):
        frames = []
        for t, k in order:
            frame, position, content, heart = Dataset(), Dataset(), Dataset(), Dataset()
            position.ImagePositionPatient = [f"{c:.11f}" for c in LPS @ (FIRST + STEPS[:, 2] * k)]
            content.TemporalPositionIndex, heart.NominalCardiacTriggerDelayTime = t + 1, 25.0 * t
            frame.PlanePositionSequence, frame.FrameContentSequence = [position], [content]
            frame.CardiacSynchronizationSequence = [heart]
            for word, value in more.items():
                setattr(frame, word, value(t, k))
            frames.append(frame)
        d.PerFrameFunctionalGroupsSequence = frames
        d.save_as(path, write_like_original=False)

    write("enhanced.dcm")
    each_frame("enhanced.dcm", values, (25, "ms"), unit="mm")

    def scale(t, k):
        own = Dataset()
        own.RescaleIntercept, own.RescaleSlope, own.RescaleType = "0", str(1 + k), "US"
        return [own]

    write("scaled.dcm", PixelValueTransformationSequence=scale)
    scales = (1 + np.arange(values.shape[1]))[:, None, None]
    each_frame("scaled.dcm", (values * scales).astype(np.int16), (25, "ms"))
    # neither a place a frame nor a spacing: pictures of one place in a row, as of ultrasound
    d.PerFrameFunctionalGroupsSequence, measures.SliceThickness = [], None
    del d.PerFrameFunctionalGroupsSequence, d.SharedFunctionalGroupsSequence
    d.save_as("cine.dcm", write_like_original=False)
    refused("cine.dcm", 4, "does not state the spacing of its voxels")


# ---- lists of files, and arrays with a time ----

@case
def listed_files():
    """ParaView's .pvd and VTK's .series, as their documentation has them; the files by VTK."""
    import vtk
    values = series()
    os.makedirs("parts", exist_ok=True)
    for t, one in enumerate(values):
        vtk_write(vtk.vtkXMLImageDataWriter(), vtk_image(one, STEPS, FIRST), f"parts/a&b{7 - t}.vti")
    pvd = "".join(f'    <DataSet timestep="{0.5 * t}" group="" part="0" file="parts/a&amp;b{7 - t}.vti"/>\n' for t in (2, 0, 1))
    with open("list.pvd", "w", encoding="ascii") as file:
        file.write('<?xml version="1.0"?>\n<VTKFile type="Collection" version="0.1" byte_order="LittleEndian">\n'
                   f"  <Collection>\n{pvd}  </Collection>\n</VTKFile>\n")
    with open("list.vti.series", "w", encoding="ascii") as file:
        json.dump({"file-series-version": "1.0",
                   "files": [{"name": f"parts/a&b{7 - t}.vti", "time": 0.5 * t} for t in range(3)]}, file)
    for path in "list.pvd", "list.vti.series":
        each_frame(path, values, (0.5, ""), ras=False)
        cut(path, "cut." + path)
        refused("cut." + path, 4, "cut." + path, ["--frame", "0"])
    with open("list.pvd", encoding="ascii") as file:
        text = file.read()
    for change, code, words in ((('timestep="0.5"', 'timestep="1.0"'), 4, "two files of the time 1"),
                                (('timestep="0.5"', 'timestep="x"'), 4, "has no finite time"),
                                (("a&amp;b6", "gone"), 3, "parts/gone.vti: cannot be opened")):
        with open("wrong.pvd", "w", encoding="ascii") as file:
            file.write(text.replace(*change))
        refused("wrong.pvd", code, words, ["--frame", "1"])
    with open("uneven.pvd", "w", encoding="ascii") as file:
        file.write(text.replace('timestep="1.0"', 'timestep="7"'))
    expect(info("uneven.pvd", "--frame", "1")["frame_step"] == 0, "uneven times have no step")
    with open("empty.series", "w", encoding="ascii") as file:
        file.write('{"file-series-version": "1.0", "files": []}')
    refused("empty.series", 4, "lists no files")


@case
def array_times():
    import h5py
    import netCDF4
    from formats_arrays import zarr_array, zarr_group
    values = series(3, np.uint16)
    for kind in "NETCDF3_CLASSIC", "NETCDF4":
        with netCDF4.Dataset("time.nc", "w", format=kind) as file:
            for name, n, step, unit in (("time", 3, 6, "hours since 2000-01-01"), ("z", 7, 2.5, "mm"), ("y", 13, 0.5, "mm"),
                                        ("x", 11, 0.75, "mm")):
                file.createDimension(name, n)
                at = file.createVariable(name, "f8", (name,))
                at[:], at.units = np.arange(n) * step, unit
            file.createVariable("t", "i2", ("time", "z", "y", "x"))[:] = values.astype(np.int16)
        each_frame("time.nc", values.astype(np.int16), (6, "hours"), steps=np.diag(SPACING), first=np.zeros(3), ras=False)
    group = zarr_group("time.zarr")
    zarr_array(group, "0", values)
    group.attrs["multiscales"] = [{
        "version": "0.4",
        "axes": [{"name": "t", "type": "time", "unit": "second"}] + [
            {"name": n, "type": "space", "unit": "millimeter"} for n in "zyx"],
        "datasets": [{"path": "0", "coordinateTransformations": [{"type": "scale", "scale": [0.2, *SPACING[::-1]]}]}]}]
    each_frame("time.zarr", values, (0.2, "second"), steps=np.diag(SPACING), first=np.zeros(3), ras=False)
    with h5py.File("time.h5", "w") as file:
        data = file.create_dataset("v", data=values)
        for axis, (name, step) in enumerate((("time", 2), ("z", 2.5), ("y", 0.5), ("x", 0.75))):
            file[name] = np.arange(values.shape[axis]) * step
            file[name].attrs["units"] = "s" if name == "time" else "mm"
            file[name].make_scale(name)
            data.dims[axis].attach_scale(file[name])
    each_frame("time.h5:v", values, (2, "s"), steps=np.diag(SPACING), first=np.zeros(3), ras=False)


if __name__ == "__main__":
    sys.exit(main(CASES))
