# SPDX-License-Identifier: MIT
"""Formats of medicine: DICOM, MetaImage, GIPL, NRRD, NIfTI, raw. Cases of formats_in.py."""
import gzip
import os
import resource
import subprocess
import zlib

import numpy as np

from phantom import (FIRST, ISOSHADE, LPS, SPACING, STEPS, case, cut, expect, load, must_choose, phantom, refused, run,
                     same, vtk_image, vtk_write)


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
    same("dicom", phantom(), unit="mm", value_unit="HU")


@case
def dicom_of_a_length():
    """An element that says it is of 3 GB, in a file of some kB: no more memory is asked for than a file of its size may."""
    dicom_series("length", phantom())
    path = next(entry.path for entry in os.scandir("length"))
    with open(path, "rb") as file:
        data = file.read()
    at = data.index(b"\xe0\x7f\x10\0OW\0\0") + 8
    with open("length.dcm", "wb") as file:
        file.write(data[:at] + (3 << 30).to_bytes(4, "little") + data[at + 4:])
    got = run("info", "length.dcm")
    expect(got.returncode in (4, 6), f"length.dcm: exit code {got.returncode}: {got.stderr.strip()}")
    peak = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1024
    expect(peak < 300 + 16 * os.cpu_count(), f"length.dcm: {peak:.0f} MB were touched")


@case
def dicom_of_another_vr():
    """Data of implicit VR under a header that says explicit: read, without the memory that lengths seem to ask for."""
    import pydicom
    values = (np.arange(4 * 256 * 256) % 1999).reshape(4, 256, 256).astype(np.int16)
    dicom_series("implicit", values)
    for name in os.listdir("implicit"):
        explicit = pydicom.dcmread(f"implicit/{name}")
        data, meta = pydicom.filebase.DicomBytesIO(), pydicom.filebase.DicomBytesIO()
        data.is_little_endian = data.is_implicit_VR = True
        pydicom.filewriter.write_dataset(data, pydicom.Dataset({e.tag: e for e in explicit}))
        pydicom.filewriter.write_file_meta_info(meta, explicit.file_meta)
        with open(f"implicit/{name}", "wb") as file:
            file.write(b"\0" * 128 + b"DICM" + meta.getvalue() + data.getvalue())
    same("implicit", values, unit="mm")
    with subprocess.Popen([ISOSHADE, "info", "implicit"], stdout=subprocess.DEVNULL) as reader:
        _, status, used = os.wait4(reader.pid, 0)
        reader.returncode = status
    expect(status == 0 and used.ru_maxrss < 700000, f"status {status}, {used.ru_maxrss} kB")


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
    same("multi.dcm", values.astype(np.int16) - 1024, unit="mm", value_unit="HU")
    cut("multi.dcm", "cut.dcm", 0.9)
    # the shared groups as bytes of which the file does not say the type, as programs write what they do not know
    implicit = pydicom.Dataset()
    implicit.SharedFunctionalGroupsSequence = [shared]
    buffer = pydicom.filebase.DicomBytesIO()
    buffer.is_little_endian, buffer.is_implicit_VR = True, True
    pydicom.filewriter.write_dataset(buffer, implicit)
    d = pydicom.dcmread("multi.dcm")
    del d.SharedFunctionalGroupsSequence
    known, pydicom.config.replace_un_with_known_vr = pydicom.config.replace_un_with_known_vr, False
    d.add(pydicom.DataElement(0x52009229, "UN", buffer.getvalue()[8:]))
    d.save_as("unknown.dcm", write_like_original=False)
    pydicom.config.replace_un_with_known_vr = known
    same("unknown.dcm", values.astype(np.int16) - 1024, unit="mm")
    refused("cut.dcm", 4, "cut.dcm: ")


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
    # The product of what a header says is no number of bytes any more; nor are the samples of a channel there.
    for channels, name in (1 << 30, "wide.mha"), (1, "high.mha"):
        with open(name, "wb") as file:
            file.write(b"ObjectType = Image\nNDims = 3\nDimSize = 32768 65536 1\nElementNumberOfChannels = %d\n"
                       b"ElementSpacing = 1 1 1\nCompressedData = True\nElementType = MET_DOUBLE\n"
                       b"ElementDataFile = LOCAL\n" % channels + zlib.compress(bytes(1000)))
        refused(name, 4, "compressed bytes cannot hold the", ["--channel", "0"] if channels > 1 else [])
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
    expect("has 3 channels a voxel" in run("build", "colors.mha", "-o", "never.iso").stderr, "channels are not named")
    with open("nowhere.mhd", "wb") as file:
        file.write(data[:data.index(b"ElementDataFile")] + b"ElementDataFile = none.raw\n")
    refused("nowhere.mhd", 3, "none.raw: cannot be opened")


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
    with open("large.gipl.gz", "wb") as file:
        file.write(gzip.compress(b"\x7f\xff\x7f\xff" + data[4:]))
    refused("large.gipl.gz", 4, "compressed bytes cannot hold the")
    with open("colors.gipl", "wb") as file:
        file.write(data[:8] + b"\0\x90" + data[10:])
    refused("colors.gipl", 4, "type 144, must be an integer of 8, 16 or 32 bits")
    with open("times.gipl", "wb") as file:
        file.write(data[:6] + b"\0\2" + data[8:])
    refused("times.gipl", 4, "2 time steps")


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
                   "sample units: HU\nencoding: raw\nendian: little\ndata file: plain.raw\n")
    for encoding in "raw", "gzip", "ascii":
        subprocess.run(["teem-unu", "save", "-f", "nrrd", "-e", encoding, "-i", "detached.nhdr", "-o", "unu.nrrd"], check=True)
        same("unu.nrrd", values, unit="um", value_unit="HU")
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
    nibabel.save(nibabel.Nifti1Pair(phantom().T, affine), "capitals.hdr")
    for ending in "hdr", "img":
        os.replace(f"capitals.{ending}", f"CAPITALS.{ending.upper()}")
    for ending in "HDR", "IMG":
        same(f"CAPITALS.{ending}", phantom(), tolerance=1e-5)
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
