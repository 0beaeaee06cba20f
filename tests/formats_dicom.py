# SPDX-License-Identifier: MIT
"""DICOM beyond one slice a file: transfer syntaxes, sample types, scales and spacings. Cases of formats_in.py.

pydicom writes files, dcmtk and OpenJPEG compress them. What is expected is the array that was written, never what GDCM
says of the file.
"""
import os
import shutil
import subprocess

import numpy as np

from formats_medical import dicom_series, dicom_slice
from phantom import (FIRST, LPS, SPACING, STEPS, Wrong, case, expect, must_choose, phantom, read_samples, refused, run,
                     same)

ENHANCED = "1.2.840.10008.5.1.4.1.1.2.1"
DOSE = "1.2.840.10008.5.1.4.1.1.481.2"


def item(**elements):
    from pydicom.dataset import Dataset
    one = Dataset()
    for name, value in elements.items():
        setattr(one, name, value)
    return one


def multiframe(path, values, without=(), **elements):
    """All slices in a file that gives the first one's place, and how far frames are apart."""
    import pydicom
    dicom_slice(path, values[0].astype(np.uint16), FIRST, "1.2.3.8", 1)
    d = pydicom.dcmread(path)
    bits = 8 * values.dtype.itemsize
    d.BitsAllocated, d.BitsStored, d.HighBit = bits, bits, bits - 1
    d.PixelRepresentation = int(values.dtype.kind == "i")
    d.NumberOfFrames, d.SpacingBetweenSlices = len(values), str(SPACING[2])
    data = values.astype(values.dtype.newbyteorder("<")).tobytes()
    d.PixelData = data + b"\0" * (len(data) % 2)
    d["PixelData"].VR = "OB" if bits == 8 else "OW"
    for name, value in elements.items():
        setattr(d, name, value)
        if name.endswith("Descriptor"):
            d[name].VR = "US"
        if isinstance(value, bytes) and len(value) % 2:
            setattr(d, name, value + b"\0")
    d.file_meta.MediaStorageSOPClassUID = d.SOPClassUID
    for name in without:
        delattr(d, name)
    d.save_as(path, write_like_original=False)
    return d


def stored(kind):
    """The phantom in all the bits of a type."""
    v = phantom(np.int16).astype(np.int64)
    if kind.itemsize == 1:
        v = (v * 7) % 250 - (125 if kind.kind == "i" else 0)
        v[5, 3, 8] = 124 if kind.kind == "i" else 250
    elif kind.kind == "u":
        v = v + 500
    return (v * (70001 if kind.itemsize == 4 else 1)).astype(kind)


# ---- transfer syntaxes ----

def dcmtk(*words):
    done = subprocess.run(words, capture_output=True, text=True)
    expect(done.returncode == 0, f"{' '.join(words)}: {done.stderr.strip()}")


def jpeg2000(path, to):
    import pydicom
    from pydicom.encaps import encapsulate
    d = pydicom.dcmread(path)
    frames, bits = [], d.BitsAllocated
    size = d.Rows * d.Columns * bits // 8
    for k in range(int(d.get("NumberOfFrames", 1))):
        with open("frame.rawl", "wb") as file:
            file.write(d.PixelData[k * size:(k + 1) * size])
        form = f"{d.Columns},{d.Rows},1,{bits},{'s' if d.PixelRepresentation else 'u'}"
        dcmtk("opj_compress", "-i", "frame.rawl", "-o", "frame.j2k", "-F", form, "-n", "3")
        with open("frame.j2k", "rb") as file:
            frames.append(file.read())
    d.PixelData = encapsulate(frames)
    d["PixelData"].is_undefined_length = True
    d["PixelData"].VR = "OB"
    d.file_meta.TransferSyntaxUID = "1.2.840.10008.1.2.4.90"
    d.save_as(to, write_like_original=False)


SYNTAXES = {  # name: how, and the largest samples in bytes
    "explicit": (shutil.copyfile, 4),
    "implicit": (lambda path, to: dcmtk("dcmconv", "+ti", path, to), 4),
    "big": (lambda path, to: dcmtk("dcmconv", "+tb", path, to), 4),
    "deflated": (lambda path, to: dcmtk("dcmconv", "+td", path, to), 4),
    "rle": (lambda path, to: dcmtk("dcmcrle", path, to), 4),
    "jpeg57": (lambda path, to: dcmtk("dcmcjpeg", "+el", path, to), 2),
    "jpeg70": (lambda path, to: dcmtk("dcmcjpeg", "+e1", path, to), 2),
    "jpegls": (lambda path, to: dcmtk("dcmcjpls", "+el", path, to), 2),
    "jpeg2000": (jpeg2000, 2),
}


def same_values(path, values):
    got = read_samples(path)
    expect(got.shape == values.shape and np.array_equal(got, values), f"{(got != values).sum()} of {values.size} values differ")


@case
def dicom_forms():
    for kind in map(np.dtype, ("u1", "i1", "u2", "i2", "u4", "i4")):
        values = stored(kind)[3:6]
        multiframe("plain.dcm", values)
        for name, (convert, most) in SYNTAXES.items():
            if kind.itemsize > most:
                continue
            try:
                convert("plain.dcm", "form.dcm")
                if (name, kind.itemsize) == ("big", 4):
                    refused("form.dcm", 4, "big-endian samples of 32 bits")
                else:
                    same_values("form.dcm", values.astype(np.float32) if kind.itemsize == 4 else values)
            except Wrong as why:
                raise Wrong(f"{name}, {kind}: {why}") from why
    dicom_series("plain", phantom())
    for name in "rle", "jpeg70":
        shutil.rmtree("form", ignore_errors=True)
        os.makedirs("form")
        for slice_name in os.listdir("plain"):
            SYNTAXES[name][0](f"plain/{slice_name}", f"form/{slice_name}")
        same("form", phantom(), unit="mm")


# ---- values ----

def per_frame(values, slopes, **shared):
    frames = [item(PlanePositionSequence=[item(ImagePositionPatient=[f"{c:.11f}" for c in LPS @ (FIRST + STEPS[:, 2] * k)])],
                   PixelValueTransformationSequence=[item(RescaleIntercept="0", RescaleSlope=str(s), RescaleType="US")])
              for k, s in zip(range(len(values)), slopes)]
    measures = item(PixelSpacing=[str(SPACING[1]), str(SPACING[0])], SliceThickness="1")
    return {"SOPClassUID": ENHANCED, "PerFrameFunctionalGroupsSequence": frames,
            "SharedFunctionalGroupsSequence": [item(PixelMeasuresSequence=[measures], **shared)]}


@case
def dicom_values():
    values = stored(np.dtype("u2"))
    slopes = 1 + 0.25 * np.arange(len(values))
    multiframe("slopes.dcm", values, ["PixelSpacing", "ImagePositionPatient", "RescaleSlope", "RescaleIntercept",
                                      "SpacingBetweenSlices", "SliceThickness"], **per_frame(values, slopes))
    same("slopes.dcm", (values * slopes[:, None, None]).astype(np.float32), unit="mm")
    offsets = [str(k * SPACING[2]) for k in range(len(values))]
    dose = {"SOPClassUID": DOSE, "GridFrameOffsetVector": offsets}
    multiframe("dose.dcm", values, ["SpacingBetweenSlices"], DoseGridScaling="0.001", **dose)
    same("dose.dcm", (values * 0.001).astype(np.float32), unit="mm")
    multiframe("unscaled.dcm", values, **dose)
    refused("unscaled.dcm", 4, "an RT dose without DoseGridScaling")
    multiframe("zero.dcm", values, RescaleSlope="0")
    refused("zero.dcm", 4, "the slope of its values is 0")
    multiframe("mono.dcm", values, PhotometricInterpretation="MONOCHROME1")
    same("mono.dcm", values)
    # 12 bits with a sign, whose upper bits hold overlays; then 10 bits in the middle
    signed = np.clip(phantom(), -2048, 2047)
    words = (signed & 0xfff).astype(np.uint16) | np.uint16(0xa000)
    multiframe("overlay.dcm", words, BitsStored=12, HighBit=11, PixelRepresentation=1)
    same("overlay.dcm", signed)
    small = values % 1024
    multiframe("middle.dcm", ((small << 3) | 0xe005).astype(np.uint16), BitsStored=10, HighBit=12)
    same("middle.dcm", small)
    for bits, name in (32, "FloatPixelData"), (64, "DoubleFloatPixelData"):
        floats = phantom(np.float32).astype(f"f{bits // 8}")
        multiframe("float.dcm", values, ["PixelData", "BitsStored", "HighBit", "PixelRepresentation"], BitsAllocated=bits,
                   **{name: floats.tobytes()})
        same("float.dcm", floats.astype(np.float32))
        dcmtk("dcmconv", "+tb", "float.dcm", "big.dcm")
        same("big.dcm", floats.astype(np.float32))
    multiframe("lut.dcm", values, ["RescaleSlope", "RescaleIntercept"],
               ModalityLUTSequence=[item(LUTDescriptor=[2, 0, 16], ModalityLUTType="US", LUTData=b"\1\0\2\0")])
    refused("lut.dcm", 4, "ModalityLUTSequence")
    multiframe("wide.dcm", values, BitsAllocated=64, BitsStored=64, HighBit=63)
    refused("wide.dcm", 4, "BitsAllocated is 64")


# ---- spacings ----

@case
def dicom_spacings():
    values = stored(np.dtype("u2"))
    multiframe("between.dcm", values)
    same("between.dcm", values, unit="mm")
    multiframe("unsaid.dcm", values, ["SpacingBetweenSlices"])
    refused("unsaid.dcm", 4, "does not state the spacing between its frames (SliceThickness 1 is not that); set --spacing")
    spacing = ["--spacing", "x".join(map(str, SPACING))]
    expect(run("info", "unsaid.dcm", *spacing).returncode == 0, "--spacing is no remedy")
    multiframe("pixels.dcm", values, ["PixelSpacing"])
    refused("pixels.dcm", 4, "does not state the spacing of its pixels")
    for name in "NominalScannedPixelSpacing", "ImagerPixelSpacing":
        multiframe("other.dcm", values, ["PixelSpacing"], **{name: [str(SPACING[1]), str(SPACING[0])]})
        got = run("info", "other.dcm")
        expect("0.75 x 0.5 x 2.5 mm" in got.stdout, f"{name}: {got.stdout}{got.stderr}")
        expect(("warning: other.dcm: the spacing of pixels is ImagerPixelSpacing" in got.stderr) == (name[0] == "I"), got.stderr)
    # offsets as z of axial slices, from below and from above; uneven ones; those of neither form
    axial = {"SOPClassUID": DOSE, "DoseGridScaling": "1", "ImagePositionPatient": ["1", "2", "3"]}
    for side in 1, -1:
        z = [str(3 + side * 2.5 * k) for k in range(len(values))]
        multiframe("z.dcm", values, GridFrameOffsetVector=z, ImageOrientationPatient=["1", "0", "0", "0", "1", "0"], **axial)
        turned = values[::side]
        same("z.dcm", turned, np.diag([-0.75, -0.5, 2.5]), np.array([-1, -2, 3 - (6 * 2.5 if side < 0 else 0)]))
    offsets = [0, 2.5, 5, 7.5, 10, 12.5, 18]
    multiframe("uneven.dcm", values, GridFrameOffsetVector=[str(v) for v in offsets], **axial)
    refused("uneven.dcm", 4, "slices are not equally far apart")
    multiframe("neither.dcm", values, GridFrameOffsetVector=[str(v + 50) for v in offsets], **axial)
    refused("neither.dcm", 4, "GridFrameOffsetVector")
    # steps that were rounded and added up, and a tilt that is none of rounding
    for shift, is_straight in (1e-5, True), (1e-3, False):
        steps = np.diag([-0.75, -0.5, 2.5])
        for k in range(len(values)):
            dicom_slice(f"{k}.dcm", values[k], np.zeros(3), "1.2.3.9", k + 1, steps=steps)
        shutil.rmtree("rounded", ignore_errors=True)
        os.makedirs("rounded")
        import pydicom
        for k in range(len(values)):
            d = pydicom.dcmread(f"{k}.dcm")
            d.ImagePositionPatient = [f"{5 + shift * k:.5f}", "6.00000", f"{2.5 * k:.5f}"]
            d.save_as(f"rounded/{k}.dcm", write_like_original=False)
        z = [line for line in run("info", "rounded").stdout.splitlines() if line.startswith("  z axis")]
        expect((" 0, 0, 1" in z[0].replace("-0,", "0,")) == is_straight, f"a shift of {shift} mm: {z}")


# ---- what a folder holds ----

@case
def dicom_left_out():
    dicom_series("folder", phantom())
    names = sorted(os.listdir("folder"))
    shutil.copyfile(f"folder/{names[3]}", f"folder/copy of {names[3]}")
    got = run("info", "folder")
    expect(got.returncode == 0 and f"copy of {names[3]}" in got.stderr and "is ignored" in got.stderr, got.stderr)
    expect("11 x 13 x 7" in got.stdout, got.stdout)
    os.remove(f"folder/copy of {names[3]}")
    turned = STEPS[:, [0, 2, 1]]
    dicom_slice("folder/scout.dcm", phantom()[0], FIRST, "1.2.3.4", 99, steps=turned)
    got = run("info", "folder")
    expect(got.returncode == 0 and "folder/scout.dcm is left out" in got.stderr and "11 x 13 x 7" in got.stdout, got.stderr)
    shutil.rmtree("cd", ignore_errors=True)
    os.makedirs("cd/IMAGES/SERIES")
    for k, name in enumerate(names):
        shutil.copyfile(f"folder/{name}", f"cd/IMAGES/SERIES/S{k}")
    dcmtk("dcmmkdir", "+D", "cd/DICOMDIR", "+id", "cd", "+r", "+I")
    same("cd", phantom(), unit="mm")  # the folders below stand for it
    refused("cd/DICOMDIR", 4, "give the folder")
    os.remove("cd/DICOMDIR")
    same("cd", phantom(), unit="mm")
    dicom_series("cd/IMAGES/OTHER", phantom() + 1, uid="1.2.3.5")
    refused("cd", 2, "holds 2 series, --series must be one of: 1 \"phantom\" (7 files, in OTHER), 2 \"phantom\" (7 files, in SERIES)")
    # a multi-frame file for each time
    shutil.rmtree("times", ignore_errors=True)
    os.makedirs("times")
    values = stored(np.dtype("u2"))
    for t in range(2):
        multiframe(f"times/{t}.dcm", values + t, TemporalPositionIdentifier=t + 1, SOPInstanceUID=f"1.2.3.77.{t}")
    same("times", values + 1, options=["--frame", "1"])
    # times that InstanceNumber alone tells apart
    import pydicom
    shutil.rmtree("numbers", ignore_errors=True)
    os.makedirs("numbers")
    for t in range(2):
        for k in range(len(values)):
            path = f"numbers/{(5 * (7 * t + k)) % 14}.dcm"
            dicom_slice(path, values[k] + t, FIRST + STEPS[:, 2] * k, "1.2.3.10", 7 * t + k + 1)
            d = pydicom.dcmread(path)
            d.NumberOfTemporalPositions, d.RepetitionTime = 2, "2000"
            d.save_as(path, write_like_original=False)
    same("numbers", values + 1, options=["--frame", "1"])
    must_choose("numbers", "has 2 frames (2 s apart)")
    # no place at all: in the order of their numbers, if the spacing is given
    for name in os.listdir("plain") if os.path.isdir("plain") else []:
        os.remove(f"plain/{name}")
    dicom_series("plain", values)
    for name in os.listdir("plain"):
        d = pydicom.dcmread(f"plain/{name}")
        del d.ImagePositionPatient, d.ImageOrientationPatient
        d.save_as(f"plain/{name}", write_like_original=False)
    refused("plain", 4, "does not state the spacing between its slices")
    same("plain", values, np.diag(SPACING), None, False, ["--spacing", "x".join(map(str, SPACING))])
    multiframe("preamble.dcm", values)
    with open("preamble.dcm", "r+b") as file:
        file.write(b"II*\0\x08\0\0\0")
    same("preamble.dcm", values, unit="mm")


@case
def dicom_uneven():
    """A missing slice: interpolated, or the rest taken for even; and distances that differ."""
    values = stored(np.dtype("i2"))
    shutil.rmtree("gap", ignore_errors=True)
    dicom_series("gap", values, leave_out=(5,))
    refused("gap", 4, "mm on average; --resample interpolates, --force-spacing takes the average")
    refused("gap", 2, "--resample and --force-spacing: one or the other", ["--resample", "--force-spacing"])
    wanted = values.copy()
    wanted[5] = np.rint((values[4].astype(float) + values[6]) / 2)
    expect(read_samples("gap", ["--resample"]).shape == wanted.shape, "not 7 slices")
    expect(np.array_equal(read_samples("gap", ["--resample"]), wanted), "other values than between the neighbors")
    expect(not np.array_equal(wanted, values), "the interpolated slice is not to be seen")  # the test's power
    got = run("info", "gap", "--resample")
    expect("gap: 1 of 7 slices are interpolated" in got.stderr, got.stderr)
    rest = np.delete(values, 5, 0)
    expect(np.array_equal(read_samples("gap", ["--force-spacing"]), rest), "--force-spacing")
    uneven = STEPS.copy()
    shutil.rmtree("far", ignore_errors=True)
    os.makedirs("far")
    for k, at in enumerate([0, 1, 2.5, 400]):
        dicom_slice(f"far/{k}.dcm", values[k], FIRST + uneven[:, 2] * at, "1.2.3.4", k + 1)
    refused("far", 4, "--resample would make 401 slices of 4, must be at most 64", ["--resample"])
    # of one series, in two directions
    shutil.rmtree("two", ignore_errors=True)
    dicom_series("two", values)
    for k in range(3):
        dicom_slice(f"two/turned{k}.dcm", values[k], FIRST + STEPS[:, 1] * k, "1.2.3.4", 50 + k, steps=STEPS[:, [0, 2, 1]])
    got = run("info", "two")
    expect("(7 files, " in got.stderr and "(3 files, " in got.stderr, got.stderr)


# ---- planted ----

@case
def dicom_faults():
    """The comparison finds a reader that does one of these."""
    values = stored(np.dtype("i4"))
    multiframe("plain.dcm", values, RescaleSlope="0.5", RescaleIntercept="-1")
    right = (values * 0.5 - 1).astype(np.float32)
    faults = {
        "slope ignored": ((values - 1).astype(np.float32), STEPS),
        "bytes swapped": ((values.byteswap() * 0.5 - 1).astype(np.float32), STEPS),
        "words swapped": ((((values.view("u4") >> 16) | (values.view("u4") << 16)).view("i4") * 0.5 - 1).astype(np.float32), STEPS),
        "inverted": ((~values * 0.5 - 1).astype(np.float32), STEPS),
        "sign lost": ((values.view("u4") * 0.5 - 1).astype(np.float32), STEPS),
        "1 mm": (right, STEPS / SPACING),
        "1 mm between frames": (right, STEPS / [1, 1, SPACING[2]]),
    }
    same("plain.dcm", right)
    for name, (wrong, steps) in faults.items():
        try:
            same("plain.dcm", wrong, steps)
        except Wrong:
            continue
        raise Wrong(f"not found: {name}")


# ---- colors ----

def of_color(path, pixels, kind, planar=0, **elements):
    """pixels [z, y, x, 3], or of a palette [z, y, x]."""
    data = np.moveaxis(pixels, -1, 1) if planar else pixels
    planes = pixels[..., 0] if pixels.ndim == 4 else pixels
    samples = np.ascontiguousarray(data).astype(planes.dtype.newbyteorder("<")).tobytes()
    multiframe(path, planes, SamplesPerPixel=1 if pixels.ndim == 3 else 3, PhotometricInterpretation=kind,
               PlanarConfiguration=planar, PixelData=samples, **elements)


def colors_of(dtype):
    v = phantom(np.uint16).astype(np.int64)
    scale = 1 if dtype == "u1" else 257
    return np.stack([(v * k) % 251 * scale for k in (1, 3, 7)], -1).astype(dtype)


def rgb_of_ybr(pixels):
    y, cb, cr = (pixels[..., c].astype(float) - (128 if c else 0) for c in range(3))
    rgb = np.stack([y + 1.402 * cr, y - (0.114 * 1.772 * cb + 0.299 * 1.402 * cr) / 0.587, y + 1.772 * cb], -1)
    return np.clip(np.floor(rgb + 0.5), 0, 255).astype(np.uint8)


def each_color(path, rgb):
    for c, name in enumerate(("red", "green", "blue")):
        same(path, rgb[..., c], options=["--channel", name], unit="mm")
    weighed = (rgb.astype(float) @ [0.2126, 0.7152, 0.0722]).astype(np.float32)
    same(path, weighed, options=["--channel", "luminance"])
    must_choose(path, "has 3 channels a voxel; --channel chooses one of them: 0 red, 1 green, 2 blue, luminance")


@case
def dicom_colors():
    """Against the definitions of PS3.3 C.7.6.3.1.2; pydicom's conversion is the same one."""
    for dtype in "u1", "u2":
        rgb = colors_of(dtype)
        for planar in 0, 1:
            of_color("rgb.dcm", rgb, "RGB", planar)
            each_color("rgb.dcm", rgb)
            dcmtk("dcmcrle", "rgb.dcm", "rle.dcm")
            each_color("rle.dcm", rgb)
    rgb = colors_of("u1")
    of_color("rgb.dcm", rgb, "RGB")
    for convert in (["dcmcjpls", "+el"], ["dcmcjpeg", "+e1"]):  # without loss
        dcmtk(*convert, "rgb.dcm", "packed.dcm")
        each_color("packed.dcm", rgb)
    of_color("ybr.dcm", rgb, "YBR_FULL")
    each_color("ybr.dcm", rgb_of_ybr(rgb))
    half = rgb[:, :, :10].copy()  # pairs of pixels share two components
    half[:, :, 1::2, 1:] = half[:, :, ::2, 1:]
    pairs = np.stack([half[:, :, ::2, 0], half[:, :, 1::2, 0], half[:, :, ::2, 1], half[:, :, ::2, 2]], -1)
    multiframe("half.dcm", half[..., 0], SamplesPerPixel=3, PhotometricInterpretation="YBR_FULL_422",
               PlanarConfiguration=0, PixelData=pairs.tobytes())
    got = read_samples("half.dcm", ["--channel", "green"])
    expect(np.array_equal(got, rgb_of_ybr(half)[..., 1]), "YBR_FULL_422")
    expect(not np.array_equal(got, half[..., 1]), "the conversion is not to be seen")  # the test's power
    # with loss: as dcmtk decodes the same file; decoders may round differently by 2, a swapped channel is far off
    dcmtk("dcmcjpeg", "+eb", "+q", "95", "rgb.dcm", "lossy.dcm")
    dcmtk("dcmdjpeg", "lossy.dcm", "unpacked.dcm")
    import pydicom
    wanted = pydicom.dcmread("unpacked.dcm").pixel_array
    got = np.stack([read_samples("lossy.dcm", ["--channel", str(c)]) for c in range(3)], -1).astype(int)
    expect(np.abs(got - wanted).max() <= 2, f"JPEG differs by {np.abs(got - wanted).max()}")
    expect(np.abs(got[..., ::-1] - wanted).max() > 2, "swapped channels are not to be seen")
    four = np.concatenate([rgb, rgb[..., :1]], -1)
    multiframe("four.dcm", rgb[..., 0], SamplesPerPixel=4, PhotometricInterpretation="ARGB", PlanarConfiguration=0,
               PixelData=four.tobytes())
    refused("four.dcm", 4, "4 components per voxel (ARGB), must be RGB")


@case
def dicom_palettes():
    index = (phantom(np.uint16) % 61 + 3).astype(np.uint8)
    for bits, first in (8, 3), (16, 3), (16, 10):
        tables = [(np.arange(60) * k % 250 * (1 if bits == 8 else 200)).astype("u2") for k in (1, 5, 11)]
        names = "RedPaletteColorLookupTable", "GreenPaletteColorLookupTable", "BluePaletteColorLookupTable"
        words = {}
        for name, table in zip(names, tables):
            words[name + "Descriptor"] = [60, first, bits]
            words[name + "Data"] = table.astype("u1" if bits == 8 else "u2").tobytes()
        of_color("palette.dcm", index, "PALETTE COLOR", **words)
        at = np.clip(index.astype(int) - first, 0, 59)
        each_color("palette.dcm", np.stack([t[at] for t in tables], -1).astype("u1" if bits == 8 else "u2"))
    for name in names:
        words[name + "Data"] = tables[0].tobytes()
    of_color("gray.dcm", index, "PALETTE COLOR", **words)
    same("gray.dcm", tables[0][at])
    of_color("without.dcm", index, "PALETTE COLOR")
    refused("without.dcm", 4, "indices into a palette that is missing")
    for name in names:
        words[name + "Data"] = tables[0][:20].tobytes()
    of_color("short.dcm", index, "PALETTE COLOR", **words)
    refused("short.dcm", 4, "its palette has 40 bytes for 60 colors of 16 bits; segmented palettes are not read")


# ---- segmentations ----

SEGMENTATION = "1.2.840.10008.5.1.4.1.1.66.4"


def of_segments(path, masks, left_out=(), kind="BINARY", fraction=1):
    """masks: [z, y, x] of each segment, numbered from 1. A frame for each segment and slice that is not left out."""
    frames, groups = [], []
    for number, (name, mask) in enumerate(masks.items(), 1):
        for k in range(len(mask)):
            if (number, k) in left_out:
                continue
            frames.append(mask[k])
            place = LPS @ (FIRST + STEPS[:, 2] * k)
            groups.append(item(
                PlanePositionSequence=[item(ImagePositionPatient=[f"{c:.11f}" for c in place])],
                SegmentIdentificationSequence=[item(ReferencedSegmentNumber=number)]))
    frames = np.array(frames)
    measures = item(PixelSpacing=[str(SPACING[1]), str(SPACING[0])], SliceThickness="1")
    names = [item(SegmentNumber=n, SegmentLabel=name) for n, name in enumerate(masks, 1)]
    bits = {} if fraction > 1 else {"BitsAllocated": 1, "BitsStored": 1, "HighBit": 0,
                                    "PixelData": np.packbits(frames.ravel(), bitorder="little").tobytes()}
    without = ("PixelSpacing", "ImagePositionPatient", "SliceThickness", "SpacingBetweenSlices", "RescaleSlope",
               "RescaleIntercept")
    return multiframe(path, (frames * fraction).astype(np.uint8), without, SOPClassUID=SEGMENTATION,
                      SegmentationType=kind, SegmentSequence=names, PerFrameFunctionalGroupsSequence=groups,
                      SharedFunctionalGroupsSequence=[item(PixelMeasuresSequence=[measures])], **bits)


def encapsulated(d, path, syntax, pack):
    from pydicom.encaps import encapsulate
    count, size = int(d.NumberOfFrames), d.Rows * d.Columns
    bits = np.unpackbits(np.frombuffer(d.PixelData, "u1"), bitorder="little")
    frames = (np.packbits(bits[k * size:(k + 1) * size], bitorder="little").tobytes() for k in range(count))
    d.PixelData = encapsulate([pack(frame) for frame in frames])
    d["PixelData"].is_undefined_length = True
    d["PixelData"].VR = "OB"
    d.file_meta.TransferSyntaxUID = syntax
    d.save_as(path, write_like_original=False)


def rle(data):
    """PackBits of literal runs, and of runs of equal bytes."""
    out = bytearray()
    while data:
        equal = next((n for n in range(1, min(len(data), 128)) if data[n] != data[0]), min(len(data), 128))
        out += bytes([257 - equal, data[0]]) if equal > 1 else bytes([0, data[0]])
        data = data[equal:]
    return np.array([1, 64] + 14 * [0], "<u4").tobytes() + bytes(out) + b"\0" * (len(out) % 2)


@case
def dicom_segments():
    """Segments of one bit: as labels; those that overlap, or of fractions, one by one. A frame has 143 bits."""
    v = phantom(np.int16)
    masks = {"liver": v > 300, "vessel": v < -200, "all": v > -1000}
    apart = {name: masks[name] for name in ("liver", "vessel")}
    labels = (apart["liver"] * 1 + apart["vessel"] * 2).astype(np.uint16)
    expect(set(np.unique(labels)) == {0, 1, 2}, "the masks have no voxels")
    d = of_segments("seg.dcm", apart)
    same("seg.dcm", labels, unit="mm")
    about = run("info", "seg.dcm")
    expect("label map, 3 labels" in about.stdout, about.stdout)
    named = ("label      1: liver\n", "label      2: vessel\n")
    expect(all(line in about.stdout for line in named), about.stdout)
    encapsulated(d, "rle.dcm", "1.2.840.10008.1.2.5", rle)
    same("rle.dcm", labels)
    d = of_segments("seg.dcm", apart)
    encapsulated(d, "jpeg.dcm", "1.2.840.10008.1.2.4.90", lambda data: data)
    refused("jpeg.dcm", 4, "must be RLE with one fragment per frame")
    # empty slices are left out, as programs do
    empty = [k for k in range(len(v)) if k in (1, 4)]
    for mask in apart.values():
        mask[empty] = False
    of_segments("left_out.dcm", apart, [(n, k) for n in (1, 2) for k in empty])
    same("left_out.dcm", (apart["liver"] * 1 + apart["vessel"] * 2).astype(np.uint16))
    of_segments("overlap.dcm", masks)
    must_choose("overlap.dcm", "has 3 channels a voxel; --channel chooses one of them: 0 liver, 1 vessel, 2 all")
    same("overlap.dcm", (masks["vessel"] * 2).astype(np.uint16), options=["--channel", "vessel"])
    of_segments("fraction.dcm", apart, kind="FRACTIONAL", fraction=200)
    same("fraction.dcm", (apart["vessel"] * 200).astype(np.uint16), options=["--channel", "1"])
    # labels as samples
    multiframe("map.dcm", labels, SegmentationType="LABELMAP", SOPClassUID="1.2.840.10008.5.1.4.1.1.66.7",
               SegmentSequence=[item(SegmentNumber=n, SegmentLabel=name) for n, name in ((2, "vessel"), (1, "liver"))])
    same("map.dcm", labels.astype(np.uint16))
    about = run("info", "map.dcm")
    expect("label map, 3 labels" in about.stdout, "not a label map")
    expect(all(line in about.stdout for line in named), about.stdout)


# ---- Siemens mosaics ----

def csa(version=2, **entries):
    """Siemens' header of entries with texts."""
    out = (b"SV10\4\3\2\1" if version == 2 else b"") + np.array([len(entries), 77], "<u4").tobytes()
    for name, texts in entries.items():
        kind = {"A": b"SH", "N": b"IS", "S": b"FD"}[name[0]] + b"\0\0"
        out += name.encode().ljust(64, b"\0") + np.array([len(texts)], "<u4").tobytes() + kind
        out += np.array([6, len(texts), 77], "<u4").tobytes()
        for text in texts:
            data = text.encode() + b"\0"
            length = len(data) if version == 2 else len(data) + len(next(iter(entries.values())))
            out += np.array([length, len(data), 77, 0], "<u4").tobytes() + data + b"\0" * (-len(data) % 4)
    return out


def mosaic(path, values, number, up=1, version=2, private=True):
    import pydicom
    side = int(np.ceil(np.sqrt(len(values))))
    sheet = np.zeros((side, values.shape[1], side, values.shape[2]), values.dtype)
    for k in range(len(values)):
        sheet[k // side, :, k % side] = values[k]
    sheet = sheet.reshape(side * values.shape[1], side * values.shape[2])
    first = FIRST if up > 0 else FIRST + STEPS[:, 2] * (len(values) - 1)
    corner = first - STEPS[:, :2] @ [(sheet.shape[1] - values.shape[2]) / 2, (sheet.shape[0] - values.shape[1]) / 2]
    dicom_slice(path, sheet, corner, "1.2.3.11", number)
    d = pydicom.dcmread(path)
    d.ImageType, d.AcquisitionNumber = ["ORIGINAL", "PRIMARY", "M", "ND", "MOSAIC"], number
    d.SpacingBetweenSlices, d.RescaleSlope, d.RescaleIntercept = str(SPACING[2]), "1", "0"
    normal = LPS @ STEPS[:, 2] / SPACING[2] * up
    if private:
        header = csa(version, AcquisitionMatrixText=["13p*11"], NumberOfImagesInMosaic=[f"{len(values):<8}"],
                     SliceNormalVector=[f"{c:.8f}" for c in normal])
        d.private_block(0x29, "SIEMENS CSA HEADER", create=True).add_new(0x10, "OB", header)
    else:
        times = [0.5 * k for k in range(len(values))]
        d.private_block(0x19, "SIEMENS MR HEADER", create=True).add_new(0x29, "FD", times)
    d.save_as(path, write_like_original=False)
    return sheet


@case
def dicom_mosaic():
    values = phantom(np.uint16)
    for version in 1, 2:
        mosaic("mosaic.dcm", values, 1, version=version)
        same("mosaic.dcm", values, unit="mm")
    sheet = mosaic("down.dcm", values[::-1], 1, up=-1)  # tiles from the top
    same("down.dcm", values)
    expect(not np.array_equal(sheet[:13, :11], values[0]), "the order of tiles is not to be seen")  # the test's power
    mosaic("times.dcm", values, 1, private=False)  # without the number: by the times of its slices
    same("times.dcm", values)
    import nibabel.nicom.dicomwrappers as wrappers
    mosaic("mosaic.dcm", values, 1)
    wrapper = wrappers.wrapper_from_file("mosaic.dcm")
    expect(np.allclose(LPS @ wrapper.affine[:3, 3], FIRST, atol=1e-5), "nibabel places the first slice elsewhere")
    shutil.rmtree("series", ignore_errors=True)
    os.makedirs("series")
    for t in range(3):
        mosaic(f"series/{t}.dcm", values + t, t + 1)
    same("series", values + 2, options=["--frame", "2"])
    must_choose("series", "has 3 frames")
    import pydicom
    d = pydicom.dcmread("mosaic.dcm")
    del d[0x29, 0x1010]
    d.save_as("unknown.dcm", write_like_original=False)
    refused("unknown.dcm", 4, "without Siemens' number of them")
    d.private_block(0x29, "SIEMENS CSA HEADER").add_new(0x10, "OB", csa(NumberOfImagesInMosaic=["30"]))
    d.save_as("many.dcm", write_like_original=False)
    refused("many.dcm", 4, "damaged: a mosaic of 30 slices in 1 pictures of 33 x 39 pixels")
