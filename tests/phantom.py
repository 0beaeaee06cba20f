# SPDX-License-Identifier: MIT
"""One phantom, written by other programs in every format that is read, and read back by isoshade.

    phantom.py ISOSHADE [CASE ...]      "ok NAME", "ok NAME # SKIP why" or "not ok NAME: why" a case, in the current folder

The phantom has three different sizes and spacings, no symmetry, and a landmark: the largest value. Where a format can say
so it stands oblique in the world. Values have to be equal bit by bit, the landmark at the same world mm.
"""
import json
import os
import shutil
import subprocess
import sys

import numpy as np

ISOSHADE = os.path.abspath(sys.argv[1])
SIZE = (11, 13, 7)
LANDMARK = (8, 3, 5)
SPACING = np.array([0.75, 0.5, 2.5])


def rotation():
    a, b = np.radians(20), np.radians(-35)
    rx = np.array([[1, 0, 0], [0, np.cos(a), -np.sin(a)], [0, np.sin(a), np.cos(a)]])
    rz = np.array([[np.cos(b), -np.sin(b), 0], [np.sin(b), np.cos(b), 0], [0, 0, 1]])
    return rz @ rx


STEPS = rotation() * SPACING  # columns: from a sample to the next, in right, anterior, superior
FIRST = np.array([-40.5, 12.25, 100.0])  # the center of the first sample
LPS = np.diag([-1.0, -1.0, 1.0])


def phantom(dtype=np.int16):
    """[z, y, x]; negative values too, where the type has them."""
    z, y, x = np.meshgrid(*(np.arange(n) for n in SIZE[::-1]), indexing="ij")
    v = 3 * x + 17 * y * y + 5 * z * x + 29 * z - 400
    if np.dtype(dtype) == np.uint8:
        v = (v * 7) % 240
    elif np.dtype(dtype).kind == "u":
        v = v + 500
    v = v.astype(dtype)
    if np.dtype(dtype).kind == "f":
        v = v * np.dtype(dtype).type(0.37)
    v[LANDMARK[2], LANDMARK[1], LANDMARK[0]] = v.max() + 10
    return v


class Wrong(Exception):
    pass


def expect(condition, message):
    if not condition:
        raise Wrong(message)


def run(*words):
    return subprocess.run([ISOSHADE, *words], stdin=subprocess.DEVNULL, capture_output=True, text=True)


def load(path, options=()):
    """Samples [z, y, x], steps, the first sample's center, whether the world is right, anterior, superior."""
    shutil.rmtree("read.iso", ignore_errors=True)
    got = run("build", path, "--levels", "1", "-q", "-o", "read.iso", *options)
    expect(got.returncode == 0, f"exit code {got.returncode}: {got.stderr.strip()}")
    info = run("info", path, "--json", *options)
    expect(info.returncode == 0 and not info.stderr, f"info ends with {info.returncode}: {info.stderr.strip()}")
    info = json.loads(info.stdout)
    with open("read.iso/pyramid.json", encoding="utf-8") as file:
        level = json.load(file)["levels"][0]
    with open(os.path.join("read.iso", level["files"]["scalar"]["name"]), "rb") as file:
        data = file.read()
    types = {"uint8": "u1", "int8": "i1", "uint16": "<u2", "int16": "<i2", "float": "<f4"}
    g = level["geometry"]
    samples = np.frombuffer(data, types[level["stored_type"]], offset=data.index(b"\n\n") + 2)
    size = samples.size - int(np.prod(g["size"]))
    samples = samples[size:].reshape(g["size"][::-1])
    steps = np.array(g["index_to_world"]).reshape(3, 3)
    return samples, steps, np.array(g["origin_mm"]) + steps @ [0.5, 0.5, 0.5], info


def same(path, values, steps=STEPS, first=FIRST, ras=True, options=(), unit=None, tolerance=1e-6):
    """tolerance: mm, of decimals that the format has."""
    got, got_steps, got_first, info = load(path, options)
    expect(got.shape == values.shape, f"size {got.shape[::-1]}, not {values.shape[::-1]}")
    expect(np.array_equal(got, values), f"{(got != values).sum()} of {values.size} values differ, "
           f"the first by {(got.astype(float) - values).flat[(got != values).argmax()]:g}")
    if first is None:  # around its center
        first = steps @ -(np.array(values.shape[::-1]) - 1) / 2
    place, wanted = got_first + got_steps @ LANDMARK, first + steps @ LANDMARK
    expect(np.abs(place - wanted).max() <= tolerance, f"the landmark is at {place}, not {wanted}")
    expect(np.allclose(got_steps, steps, rtol=1e-5, atol=1e-5 * np.abs(steps).max()), f"steps {got_steps}, not {steps}")
    expect(info["world_is_ras"] == ras, f"world_is_ras is {info['world_is_ras']}")
    expect(unit is None or info["unit"] == unit, f"the unit is {info['unit']}, not {unit}")


def refused(path, code, words, options=()):
    got = run("info", path, *options)
    lines = got.stderr.strip().splitlines()
    expect(got.returncode == code, f"{path}: exit code {got.returncode}, wanted {code}: {got.stderr.strip()}")
    expect(len(lines) == 1 and not got.stdout, f"{path}: {len(lines)} lines of messages: {got.stderr}{got.stdout[:80]}")
    expect(words in lines[0], f"{path}: \"{lines[0]}\" lacks \"{words}\"")


def cut(path, to, fraction=0.6):
    with open(path, "rb") as file:
        data = file.read()
    with open(to, "wb") as file:
        file.write(data[:int(len(data) * fraction)])


CASES = {}


def case(f):
    CASES[f.__name__] = f
    return f


# ---- DICOM, by pydicom ----

def dicom_slice(path, pixels, position, uid, number, description="phantom", slope=1, intercept=0, steps=STEPS):
    import pydicom
    from pydicom.dataset import FileDataset, FileMetaDataset
    meta = FileMetaDataset()
    meta.MediaStorageSOPClassUID = "1.2.840.10008.5.1.4.1.1.2"
    meta.MediaStorageSOPInstanceUID = f"{uid}.{number}"
    meta.TransferSyntaxUID = pydicom.uid.ExplicitVRLittleEndian
    d = FileDataset(path, {}, file_meta=meta, preamble=b"\0" * 128)
    d.is_little_endian, d.is_implicit_VR = True, False
    d.SOPClassUID, d.SOPInstanceUID = meta.MediaStorageSOPClassUID, meta.MediaStorageSOPInstanceUID
    d.Modality, d.PatientName, d.PatientID = "CT", "Phantom", "1"
    d.StudyInstanceUID, d.SeriesInstanceUID, d.FrameOfReferenceUID = "1.2.3.1", uid, "1.2.3.9"
    d.SeriesDescription, d.SeriesNumber, d.InstanceNumber = description, 1, number
    d.Rows, d.Columns = pixels.shape
    lps = LPS @ steps
    row, column = lps[:, 0] / np.linalg.norm(lps[:, 0]), lps[:, 1] / np.linalg.norm(lps[:, 1])
    d.ImageOrientationPatient = [f"{c:.13f}" for c in (*row, *column)]
    d.ImagePositionPatient = [f"{c:.11f}" for c in LPS @ position]
    d.PixelSpacing = [f"{SPACING[1]}", f"{SPACING[0]}"]  # between rows, then between columns
    d.SliceThickness = "1"  # thinner than they are apart
    d.SamplesPerPixel, d.PhotometricInterpretation = 1, "MONOCHROME2"
    d.BitsAllocated, d.BitsStored, d.HighBit = 16, 16, 15
    d.PixelRepresentation = int(pixels.dtype.kind == "i")
    d.RescaleSlope, d.RescaleIntercept = str(slope), str(intercept)
    d.PixelData = pixels.tobytes()
    d.save_as(path, write_like_original=False)


def dicom_series(folder, values, uid="1.2.3.4", steps=STEPS, leave_out=(), **more):
    """The files are not named in the order in which they stand."""
    os.makedirs(folder, exist_ok=True)
    for k, pixels in enumerate(values):
        if k not in leave_out:
            dicom_slice(f"{folder}/{uid}.{(k * 5) % 7}.dcm", pixels, FIRST + steps[:, 2] * k, uid, k + 1, steps=steps, **more)


@case
def dicom():
    dicom_series("dicom", phantom())
    same("dicom", phantom(), unit="mm")


@case
def dicom_rescaled():
    dicom_series("rescaled", phantom(np.uint16), intercept=-1024)
    same("rescaled", phantom(np.uint16).astype(np.int16) - 1024)
    dicom_series("half", phantom(np.uint16), slope=0.5, intercept=-3)
    same("half", (phantom(np.uint16) * 0.5 - 3).astype(np.float32))


@case
def dicom_tilted_gantry():
    tilted = STEPS.copy()
    tilted[:, 2] += 0.3 * STEPS[:, 1]
    dicom_series("tilted", phantom(), steps=tilted)
    same("tilted", phantom(), steps=tilted)


@case
def dicom_mixed_series():
    dicom_series("mixed", phantom(), uid="1.2.3.5", description="bone")
    dicom_series("mixed", phantom()[::-1].copy(), uid="1.2.3.6", description="soft tissue")
    refused("mixed", 2, 'holds 2 series, --series must be one of: 1 "bone" (7 files), 2 "soft tissue" (7 files)')
    refused("mixed", 2, 'has no series "lung"', ["--series", "lung"])
    same("mixed", phantom()[::-1], options=["--series", "soft tissue"])
    same("mixed", phantom(), options=["--series", "1"])


@case
def dicom_damaged():
    dicom_series("gap", phantom(), leave_out=[3])
    refused("gap", 4, "slices are not equally far apart (one is missing?): 5 mm before")
    for part in 0.6, 0.95:  # in the header, and in the samples
        dicom_series("cut", phantom())
        cut("cut/1.2.3.4.0.dcm", "short.dcm", part)
        os.replace("short.dcm", "cut/1.2.3.4.0.dcm")
        refused("cut", 4, "cut")
    with open("named.dcm", "wb") as file:
        file.write(b"\0" * 128 + b"DICM" + b"what this is nobody knows" * 9)
    refused("named.dcm", 4, "named.dcm: ")
    with open("named.png", "wb") as file:
        file.write(b"nothing of the kind")
    refused("named.png", 4, 'starts with "nothing "')
    dicom_series("twice", phantom())
    dicom_slice("twice/again.dcm", phantom()[2], FIRST + STEPS[:, 2] * 2, "1.2.3.4", 9)
    refused("twice", 4, "two slices at one place (time steps or echoes?)")
    dicom_series("one", phantom()[:1])
    refused("one/1.2.3.4.0.dcm", 4, "is one slice; a volume is the folder of its slices")


@case
def dicom_multiframe():
    """One file of all slices, each with its place: GDCM's place is that of the first, its step that of the first two."""
    import pydicom
    from pydicom.dataset import Dataset
    values = phantom(np.uint16)
    dicom_slice("multi.dcm", values[0], FIRST, "1.2.3.7", 1)
    d = pydicom.dcmread("multi.dcm")
    d.SOPClassUID = d.file_meta.MediaStorageSOPClassUID = "1.2.840.10008.5.1.4.1.1.2.1"
    d.NumberOfFrames, d.PixelData = len(values), values.tobytes()
    shared, orientation, measures = Dataset(), Dataset(), Dataset()
    orientation.ImageOrientationPatient, measures.PixelSpacing = d.ImageOrientationPatient, d.PixelSpacing
    measures.SliceThickness = measures.SpacingBetweenSlices = str(SPACING[2])
    shared.PlaneOrientationSequence, shared.PixelMeasuresSequence = [orientation], [measures]
    rescale = Dataset()
    rescale.RescaleIntercept, rescale.RescaleSlope, rescale.RescaleType = "-1024", "1", "HU"
    shared.PixelValueTransformationSequence = [rescale]
    d.SharedFunctionalGroupsSequence, frames = [shared], []
    for k in range(len(values)):
        frame, position = Dataset(), Dataset()
        position.ImagePositionPatient = [f"{c:.11f}" for c in LPS @ (FIRST + STEPS[:, 2] * k)]
        frame.PlanePositionSequence = [position]
        frames.append(frame)
    d.PerFrameFunctionalGroupsSequence = frames
    for word in "ImageOrientationPatient", "ImagePositionPatient", "PixelSpacing", "SliceThickness", "RescaleSlope", "RescaleIntercept":
        delattr(d, word)
    d.save_as("multi.dcm", write_like_original=False)
    same("multi.dcm", values.astype(np.int16) - 1024, unit="mm")
    cut("multi.dcm", "cut.dcm", 0.9)
    refused("cut.dcm", 4, "cut.dcm: ")


# ---- pictures, by VTK ----

def vtk_image(values, steps=None, first=None):
    """values [z, y, x]."""
    import vtk
    from vtk.util import numpy_support
    image = vtk.vtkImageData()
    image.SetDimensions(values.shape[::-1])
    if steps is not None:
        image.SetSpacing(np.linalg.norm(steps, axis=0))
        image.SetOrigin(first)
        image.SetDirectionMatrix((steps / np.linalg.norm(steps, axis=0)).ravel())
    array = numpy_support.numpy_to_vtk(values.ravel(), deep=True)
    array.SetName("values")
    image.GetPointData().SetScalars(array)
    return image


def vtk_write(writer, image, path):
    writer.SetInputData(image)
    writer.SetFileName(path)
    writer.Write()


@case
def png_stack():
    import vtk
    os.makedirs("png", exist_ok=True)
    values = phantom(np.uint16)
    for k, pixels in enumerate(values):  # VTK counts rows from the bottom
        vtk_write(vtk.vtkPNGWriter(), vtk_image(pixels[None, ::-1].copy()), f"png/slice{9 + k}.png")
    refused("png", 4, "does not say the spacing of its voxels, as pictures do not; --spacing SXxSYxSZ does")
    same("png", values, np.diag(SPACING), None, False, ["--spacing", "0.75x0.5x2.5"])
    cut("png/slice10.png", "short.png")
    os.replace("short.png", "png/slice10.png")
    refused("png", 4, "slice10.png", ["--spacing", "1"])
    vtk_write(vtk.vtkPNGWriter(), vtk_image(values[:1, 1:].copy()), "png/slice10.png")
    refused("png", 4, "slices of different sizes", ["--spacing", "1"])


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
        refused(folder, 4, "does not say the spacing of its voxels, as pictures do not")
        same(folder, wanted, np.diag(SPACING), None, False, ["--spacing", "0.75x0.5x2.5"])
        cut(f"{folder}/{last}", "short", 0.5)
        os.replace("short", f"{folder}/{last}")
        refused(folder, 4, last, ["--spacing", "1"])
        with open(f"{folder}/{last}", "wb") as file:
            file.write(b"nothing of the kind")
        refused(folder, 4, last, ["--spacing", "1"])


# ---- MetaImage by VTK ----

@case
def metaimage():
    import vtk
    values = phantom()
    for suffix, compress in ("mha", False), ("mha", True), ("mhd", False), ("mhd", True):
        writer = vtk.vtkMetaImageWriter()
        writer.SetCompression(compress)
        vtk_write(writer, vtk_image(values, np.diag(SPACING), [1, 2, 3]), f"vtk.{suffix}")
        same(f"vtk.{suffix}", values, LPS @ np.diag(SPACING), LPS @ [1, 2, 3])
    cut("vtk.zraw", "short.zraw")
    os.replace("short.zraw", "vtk.zraw")
    refused("vtk.mhd", 4, "truncated: the compressed samples end after")
    cut("vtk.mha", "cut.mha", 0.3)
    refused("cut.mha", 4, "cut.mha")
    # Oblique: VTK's header has the lines, with an identity.
    writer = vtk.vtkMetaImageWriter()
    writer.SetCompression(False)
    vtk_write(writer, vtk_image(values, np.diag(SPACING), LPS @ FIRST), "oblique.mha")
    with open("oblique.mha", "rb") as file:
        data = file.read()
    turn = " ".join(f"{c:.12g}" for c in (LPS @ STEPS / SPACING).T.ravel())
    expect(b"TransformMatrix = 1 0 0 0 1 0 0 0 1" in data, "VTK writes no TransformMatrix")
    with open("oblique.mha", "wb") as file:
        file.write(data.replace(b"TransformMatrix = 1 0 0 0 1 0 0 0 1", f"TransformMatrix = {turn}".encode()))
    same("oblique.mha", values)
    with open("oblique.mha", "rb") as file:
        data = file.read()
    with open("unit.mha", "wb") as file:
        file.write(data.replace(b"NDims", b"DistanceUnits = um\nNDims"))
    same("unit.mha", values, STEPS / 1000, FIRST / 1000, unit="um")
    with open("colors.mha", "wb") as file:
        file.write(data.replace(b"ElementType", b"ElementNumberOfChannels = 3\nElementType"))
    refused("colors.mha", 2, "has 3 channels a voxel")
    with open("nowhere.mhd", "wb") as file:
        file.write(data[:data.index(b"ElementDataFile")] + b"ElementDataFile = none.raw\n")
    refused("nowhere.mhd", 3, "none.raw: cannot be opened")


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
    writer = vtk.vtkRectilinearGridWriter()
    writer.SetInputData(vtk.vtkRectilinearGrid())
    writer.SetFileName("grid.vtk")
    writer.Write()
    refused("grid.vtk", 4, "a dataset of VTK's kind RECTILINEAR_GRID, must be STRUCTURED_POINTS")


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


# ---- TIFF by tifffile ----

@case
def tiff():
    import tifffile
    for dtype in np.uint8, np.uint16, np.int16, np.float32:
        values = phantom(dtype)
        tifffile.imwrite("plain.tif", values, photometric="minisblack")
        refused("plain.tif", 4, "does not say the spacing of its voxels; --spacing SXxSYxSZ does")
        same("plain.tif", values, np.diag(SPACING), None, False, ["--spacing", "0.75x0.5x2.5"])
    for more in {"bigtiff": True}, {"compression": "zlib"}, {"tile": (16, 16)}, {"byteorder": ">"}, {"rowsperstrip": 4}:
        tifffile.imwrite("more.tif", values, photometric="minisblack", **more)
        same("more.tif", values, np.diag(SPACING), None, False, ["--spacing", "0.75x0.5x2.5"])
        cut("more.tif", "cut.tif", 0.8)
        refused("cut.tif", 4, "cut.tif", ["--spacing", "1"])
    tifffile.imwrite("colors.tif", np.zeros((9, 9, 3), np.uint8), photometric="rgb")
    refused("colors.tif", 2, "has 3 channels a voxel")


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
    refused("flat.tif", 4, "does not say the spacing between its slices")
    both = np.stack([values, values], 1)
    tifffile.imwrite("channels.tif", both, imagej=True, metadata={"axes": "ZCYX"})
    refused("channels.tif", 2, "has 2 channels a voxel")


@case
def tiff_ome():
    import tifffile
    values = phantom(np.uint16)
    about = {"axes": "ZYX", "PhysicalSizeX": 0.75, "PhysicalSizeY": 0.5, "PhysicalSizeZ": 2500.0,
             "PhysicalSizeZUnit": "nm"}
    tifffile.imwrite("phantom.ome.tif", values, metadata=about)  # micrometers where no unit is named
    same("phantom.ome.tif", values, np.diag(SPACING) / 1000, None, False)
    tifffile.imwrite("unknown.ome.tif", values, metadata={**about, "PhysicalSizeZUnit": "parsec"})
    refused("unknown.ome.tif", 4, 'its unit is "parsec"')
    tifffile.imwrite("flat.ome.tif", values, metadata={"axes": "ZYX", "PhysicalSizeX": 1, "PhysicalSizeY": 1})
    refused("flat.ome.tif", 4, "does not say the spacing between its slices")


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


# ---- GIPL by ITK (formats/make_gipl.cc) ----

@case
def gipl():
    import gzip
    formats = os.path.join(os.path.dirname(os.path.abspath(__file__)), "formats")
    with open(f"{formats}/phantom.gipl", "rb") as file:
        data = file.read()
    for suffix, pack in ("gipl", bytes), ("gipl.gz", gzip.compress):
        with open(f"phantom.{suffix}", "wb") as file:
            file.write(pack(data))
        same(f"phantom.{suffix}", phantom(), LPS @ np.diag(SPACING), LPS @ [1, 2, 3], unit="mm")
        cut(f"phantom.{suffix}", f"cut.{suffix}")
        refused(f"cut.{suffix}", 4, "truncated")
    with open("colors.gipl", "wb") as file:
        file.write(data[:8] + b"\0\x90" + data[10:])
    refused("colors.gipl", 4, "type 144, must be an integer of 8, 16 or 32 bits")
    with open("times.gipl", "wb") as file:
        file.write(data[:6] + b"\0\2" + data[8:])
    refused("times.gipl", 4, "2 time steps")


# ---- Gaussian cube and XSF by ASE (formats/make.py) ----

def small():
    x, y, z = np.meshgrid(np.arange(4), np.arange(5), np.arange(3), indexing="ij")
    return (0.25 * x - 0.5 * y * y + 0.125 * z * x + 3 * z).T.astype(np.float32)


CELL = np.array([[2.0, 0.5, 0.25], [0, 2.5, -0.75], [0, 0, 1.5]]) * 1e-7  # columns, mm
FILES = os.path.join(os.path.dirname(os.path.abspath(__file__)), "formats")


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
    with open("angstrom.cube", "w", encoding="ascii") as file:
        file.writelines([*lines[:3], *(line.replace("    ", "   -", 1) for line in lines[3:6]), *lines[6:]])
    bohr = 0.529177210903
    same("angstrom.cube", small(), CELL / [4, 5, 3] / bohr, np.array([0.1, -0.2, 0.3]) * 1e-7 / bohr, False,
         unit="angstrom", tolerance=1e-12)
    with open("orbitals.cube", "w", encoding="ascii") as file:
        file.writelines([*lines[:2], lines[2].replace("2", "-2", 1), *lines[3:8], "    2    5    6\n", *lines[8:]])
    refused("orbitals.cube", 4, "2 values a voxel (orbitals)")


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
        file["list"], file["frames"] = np.arange(9), np.stack([values, values])
    refused("two.h5", 2, "holds 5 datasets of three axes or more, FILE:DATASET must name one of: frames (11 x 13 x 7 x 2), ")
    refused("two.h5:plain", 4, "does not say the spacing of its voxels; --spacing SXxSYxSZ does")
    same("two.h5:/other", values + 1, np.diag(SPACING), None, False, ["--spacing", "0.75x0.5x2.5"])
    refused("two.h5:wide", 4, "integers of 64 bits")
    refused("two.h5:frames", 4, "11 x 13 x 7 x 2 samples along 4 axes without names: which are a volume's three is not said")
    refused("two.h5:lzf", 4, "packed by filter 32000 (lzf), which HDF5 has no plugin for")
    values.tofile("plain.raw")
    with open("plain.h5", "wb") as file:
        file.write(b"\x89HDF\r\n\x1a\n" + values.tobytes())
    refused("plain.h5", 4, "plain.h5: HDF5: ")


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
            v[:] = values
        unit = np.array([1e-3, 1e-3, 1e3])
        # coordinates are floats
        same("phantom.nc", values, np.diag(SPACING * [1, -1, 1] * unit), FIRST * unit, False, unit="um", tolerance=1e-3)
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
    refused("packed.nc", 4, "does not say the spacing evenly: the steps of lev are")
    with netCDF4.Dataset("packed.nc", "r+") as file:
        file["lat"].units = "degrees_north"
    refused("packed.nc", 4, 'its unit is "degrees_north"', ["--spacing", "1"])


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
    refused("phantom.zarr:2", 2, 'has no dataset "2" of three axes, FILE:DATASET must name one of: 0 (11 x 13 x 7 x 1), 1 (6 x 7 x 4 x 1)')
    expect(load("phantom.zarr:1")[0].shape == (4, 7, 6), "the other level is of another size")
    same("phantom.zarr/0", values, np.diag(SPACING), None, False, ["--spacing", "0.75x0.5x2.5"])
    refused("phantom.zarr/0", 4, "does not say the spacing of its voxels")
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
    refused("times.zarr", 2, "has 2 frames; --frame K chooses one, from 0 to 1")
    same("times.zarr", values + 1, np.diag(SPACING) / 1000, FIRST / 1000, False, ["--frame", "1"])
    group = zarr_group("colors.zarr")
    zarr_array(group, "0", np.stack([np.stack([values + 2 * t + c for c in (0, 1)]) for t in (0, 1, 2)]))
    group.attrs["multiscales"] = [{"version": "0.4", "axes": [{"name": "t", "type": "time"}, *axes],
                                   "datasets": [{"path": "0", "coordinateTransformations": [
                                       {"type": "scale", "scale": [1, 1, *SPACING[::-1]]}]}]}]
    group.attrs["omero"] = {"channels": [{"label": "DAPI"}, {"label": "GFP"}]}
    refused("colors.zarr", 2, "has 2 channels a voxel; --channel chooses one of them: 0 DAPI, 1 GFP", ["--frame", "2"])
    same("colors.zarr", values + 5, np.diag(SPACING) / 1000, np.zeros(3), False, ["--frame", "2", "--channel", "gfp"])
    os.makedirs("new.zarr", exist_ok=True)
    with open("new.zarr/zarr.json", "w", encoding="ascii") as file:
        file.write('{"zarr_format": 3}')
    refused("new.zarr", 4, "is of Zarr 3 (OME-Zarr 0.5), which is not read")
    for dtype in np.float16, np.float32, np.int8, bool:
        stored = (phantom(np.int16) % 100).astype(dtype)
        zarr_array(zarr_group("types.zarr"), "0", stored)
        same("types.zarr", stored.astype({"float16": np.float32, "bool": np.uint8}.get(np.dtype(dtype).name, dtype)),
             np.diag(SPACING), None, False, ["--spacing", "0.75x0.5x2.5"])


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
                              vdb_grid(values > 0, vdb.BoolGrid, "mask"), speed])
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


@case
def damaged_bytes():
    """Files with a few wrong bytes are read, or refused in one line; the child may end, isoshade does not."""
    import random
    random.seed(20261122)
    files = ["phantom.h5", "phantom.nc", "packed.nc", "scaled.mnc", "phantom.gipl", "several.vdb", "colors.zarr/0/.zarray",
             "colors.zarr/0/0.0.0.0.0", "colors.zarr/.zattrs"]
    lacking = [name for name in files if not os.path.exists(name)]
    expect(not lacking, f"{lacking} are of other cases, which come before")
    for name in files:
        with open(name, "rb") as file:
            whole = file.read()
        for number in range(6):
            data = bytearray(whole)
            for _ in range(random.choice((1, 2, 8))):
                data[random.randrange(min(len(data), 4096) if number % 2 else len(data))] = random.choice((0, 127, 255))
            with open(name, "wb") as file:
                file.write(data)
            got = run("info", name if "zarr" not in name else "colors.zarr", "--spacing", "1", "--channel", "0", "--frame", "0")
            lines = got.stderr.strip().splitlines()
            expect(got.returncode in (0, 2, 4, 5, 6) and len(lines) == (got.returncode != 0),
                   f"{name}, change {number}: exit code {got.returncode}: {got.stderr[:300]}")
        with open(name, "wb") as file:
            file.write(whole)


# ---- NRRD by teem, NIfTI by nibabel, raw ----

@case
def nrrd():
    values = phantom()
    values.tofile("plain.raw")
    steps = " ".join("(" + ",".join(f"{c:.17g}" for c in 1000 * LPS @ STEPS[:, a]) + ")" for a in range(3))
    origin = "(" + ",".join(f"{c:.17g}" for c in 1000 * LPS @ FIRST) + ")"
    with open("detached.nhdr", "w", encoding="ascii") as file:
        file.write("NRRD0005\ntype: short\ndimension: 3\nspace: left-posterior-superior\nsizes: 11 13 7\n"
                   f"space directions: {steps}\nspace origin: {origin}\nspace units: \"um\" \"um\" \"um\"\n"
                   "encoding: raw\nendian: little\ndata file: plain.raw\n")
    for encoding in "raw", "gzip", "ascii":
        subprocess.run(["teem-unu", "save", "-f", "nrrd", "-e", encoding, "-i", "detached.nhdr", "-o", "unu.nrrd"], check=True)
        same("unu.nrrd", values, unit="um")
        cut("unu.nrrd", "cut.nrrd")
        refused("cut.nrrd", 4, "cut.nrrd")


@case
def nifti():
    import nibabel
    affine = np.eye(4)
    affine[:3, :3], affine[:3, 3] = STEPS, FIRST
    for kind, suffix in (nibabel.Nifti1Image, "nii"), (nibabel.Nifti2Image, "nii.gz"):
        image = kind(phantom().T, affine)
        image.header.set_xyzt_units("mm")
        nibabel.save(image, f"nibabel.{suffix}")
        # NIfTI-1 has floats
        same(f"nibabel.{suffix}", phantom(), unit="mm", tolerance=1e-5)
        cut(f"nibabel.{suffix}", f"cut.{suffix}")
        refused(f"cut.{suffix}", 4, "cut.nii")
    image = nibabel.Nifti1Image(phantom().T, affine)
    image.header.set_slope_inter(0.5, -3)
    nibabel.save(image, "scaled.nii")
    stored = np.asanyarray(nibabel.load("scaled.nii").dataobj.get_unscaled()).T
    same("scaled.nii", (0.5 * stored - 3).astype(np.float32), tolerance=1e-5)
    same("scaled.nii", stored, tolerance=1e-5, options=["--stored"])


@case
def raw():
    phantom().tofile("plain.raw")
    options = ["--raw-size", "11x13x7", "--raw-type", "int16", "--raw-spacing", "750x500x2500", "--unit", "um"]
    same("plain.raw", phantom(), np.diag(SPACING), None, False, options)
    refused("plain.raw", 4, "too long", [*options, "--raw-size", "11x13x6"])


def main(cases):
    if sys.argv[1] == "--list":
        print("\n".join(cases))
        return 0
    failed = 0
    for name in sys.argv[2:] or cases:
        try:
            cases[name]()
            print("ok", name)
        except Exception as why:  # a missing module, too
            failed = 1
            print(f"not ok {name}: {type(why).__name__}: {why}")
        sys.stdout.flush()
    return failed


if __name__ == "__main__":
    sys.exit(main(CASES))
