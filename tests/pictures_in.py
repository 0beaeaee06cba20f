# SPDX-License-Identifier: MIT
"""Pictures that other programs write, over the forms of OpenEXR and PNG, against those programs' own pixels: OpenImageIO for
OpenEXR, pypng, which stands on no other library, for PNG. Prints a case per line. Argument: the shared library."""
import ctypes
import itertools
import struct
import sys
import zlib

import numpy as np
import OpenImageIO as oiio
import png


class Image(ctypes.Structure):
    _fields_ = [("width", ctypes.c_size_t), ("height", ctypes.c_size_t), ("rgba", ctypes.POINTER(ctypes.c_float)),
                ("origin", ctypes.c_int * 2), ("reserved", ctypes.c_void_p * 4)]


library = ctypes.CDLL(sys.argv[1])
library.iso_image_destroy.restype = None


def load(path):
    """Our decode: rows x columns x RGBA, or the message."""
    image, error = Image(), ctypes.create_string_buffer(65536)
    function = library.iso_image_load_png if path.endswith(".png") else library.iso_image_load_exr
    if function(path.encode(), ctypes.byref(image), error) != 0:
        return error.value.decode()
    pixels = np.ctypeslib.as_array(image.rgba, (image.height, image.width, 4)).copy()
    library.iso_image_destroy(ctypes.byref(image))
    return pixels


def differs(found, wanted, tolerance=0.0):
    """Why a decode is not the wanted one, or None."""
    if isinstance(found, str):
        return found
    if found.shape != wanted.shape:
        return f"size {found.shape}, must be {wanted.shape}"
    if not np.abs(found - wanted).max() <= tolerance:
        return f"channels R, G, B, A differ by {np.abs(found - wanted).max((0, 1))}"
    return None


failures, seen, planted = [], {}, {}


def judge(case, form, found, wanted, tolerance=0.0):
    """Compares, and gives the comparison wrong decodes, of which it must reject each that is another picture."""
    why = differs(found, wanted, tolerance)
    seen[case] = seen.get(case, 0) + 1
    if why:
        failures.append(f"{case}: {form}: {why}")
        return
    wrong = {"channels_in_reverse_order": found[:, :, ::-1], "red_and_blue_swapped": found[:, :, [2, 1, 0, 3]],
             "rows_in_reverse_order": found[::-1], "columns_moved_by_one": np.roll(found, 1, 1),
             "alpha_ignored": np.dstack([found[:, :, :3], np.ones(found.shape[:2])])}
    for name, picture in wrong.items():
        if np.abs(picture - wanted).max() > 10 * tolerance + 1e-3:
            planted[name] = planted.get(name, 0) + 1
            if not differs(picture, wanted, tolerance):
                failures.append(f"{case}: {form}: {name} is not noticed")


# ---- OpenEXR ----

WIDTH, HEIGHT = 37, 29
NAMES = {1: ["Y"], 2: ["Y", "A"], 3: ["R", "G", "B"], 4: ["R", "G", "B", "A"], 5: ["R", "G", "B", "A", "Z"],
         6: ["R", "G", "B", "A", "AO", "Z"]}
# first column and row of the data, size and first pixel of the picture
WINDOWS = {"same": (0, 0, WIDTH, HEIGHT, 0, 0), "moved": (5, -7, WIDTH, HEIGHT, 5, -7),
           "smaller_data": (4, 3, WIDTH + 9, HEIGHT + 5, 0, 0), "larger_data": (-3, -2, WIDTH - 7, HEIGHT - 6, 0, 0),
           "partly_outside": (-6, 8, WIDTH, HEIGHT, 0, 0), "apart": (100, 0, WIDTH, HEIGHT, 0, 0)}
COMPRESSIONS = ["none", "rle", "zips", "zip", "piz", "pxr24", "b44", "b44a", "dwaa", "dwab"]
LAYOUTS = ["lines", "tiles", "mipmap"]
ORDERS = ["increasingY", "decreasingY", "randomY"]
LOSSY = {"pxr24": ("float",), "b44": ("half",), "b44a": ("half",), "dwaa": ("half", "float"), "dwab": ("half", "float")}


def source(channels, types):
    """Smooth planes, each another one, so that lossy codes stay near."""
    y, x = np.mgrid[0:HEIGHT, 0:WIDTH]
    planes = [0.5 + 0.4 * np.sin(0.05 * (c + 1) * x + 0.07 * (channels - c) * y + c) for c in range(channels)]
    return [np.floor(p * 4e9).astype(np.uint32) if t == "uint" else p.astype(np.float16 if t == "half" else np.float32)
            for p, t in zip(planes, types)]


def spec_of(channels, kind, compression, layout, order, window):
    spec = oiio.ImageSpec(WIDTH, HEIGHT, channels, kind)
    spec.channelnames = tuple(NAMES[channels])
    spec.x, spec.y, spec.full_width, spec.full_height, spec.full_x, spec.full_y = WINDOWS[window]
    spec.attribute("compression", compression)
    spec.attribute("openexr:lineOrder", order)
    if layout != "lines":
        spec.tile_width, spec.tile_height = 16, 16
    return spec


def write_exr(path, spec, planes, mipmap):
    pixels = np.ascontiguousarray(np.dstack(planes))
    if mipmap:
        buffer = oiio.ImageBuf(spec)
        good = buffer.set_pixels(oiio.ROI(), pixels) and oiio.ImageBufAlgo.make_texture(oiio.MakeTxTexture, buffer, path, spec)
        why = oiio.geterror()
    else:
        out = oiio.ImageOutput.create(path)
        good = out.open(path, spec) and out.write_image(pixels)
        why = out.geterror()
        out.close()
    if not good:
        raise RuntimeError(why)


def read_exr(path):
    """OpenImageIO's planes by name, in the file's own types."""
    file = oiio.ImageInput.open(path)
    spec = file.spec()
    pixels = file.read_image(spec.format)
    if pixels is None:
        raise RuntimeError(file.geterror())
    planes = {name: pixels[:, :, c] for c, name in enumerate(spec.channelnames)}
    file.close()
    return planes


def as_picture(planes, window):
    """The display window's pixels: 0 outside the data, alpha 1 in data without it, Y as gray."""
    x, y, width, height, first_x, first_y = WINDOWS[window]
    picture = np.zeros((height, width, 4), np.float32)
    rows, columns = np.arange(height) + first_y - y, np.arange(width) + first_x - x
    in_rows, in_columns = (rows >= 0) & (rows < HEIGHT), (columns >= 0) & (columns < WIDTH)
    for c, name in enumerate("RGBA"):
        plane = planes.get(name, planes.get("Y") if c < 3 else None)
        plane = np.ones((HEIGHT, WIDTH)) if plane is None else plane
        picture[np.ix_(in_rows, in_columns, [c])] = plane[np.ix_(rows[in_rows], columns[in_columns])][:, :, None]
    return picture


def exr(case, channels, kind, compression, layout, order, window):
    if layout == "mipmap":  # OpenImageIO makes textures of whole display windows only
        window = "same"
    form = f"{channels} x {kind}, {compression}, {layout}, {order}, {window}"
    planes = source(channels, [kind] * channels)
    write_exr("form.exr", spec_of(channels, kind, compression, layout, order, window), planes, layout == "mipmap")
    read = read_exr("form.exr")
    found = load("form.exr")
    judge(case, form, found, as_picture(read, window))
    written = dict(zip(NAMES[channels], planes))
    if kind not in LOSSY.get(compression, ()):
        judge(case + "_as_written", form, found, as_picture(written, window))
    else:  # lossy codes keep smooth planes within a tenth of their range
        why = differs(found, as_picture(written, window), 0.1)
        if why:
            failures.append(f"{case}: {form}: far from what was written: {why}")


def all_exr():
    windows, orders = itertools.cycle(WINDOWS), itertools.cycle(ORDERS)
    channels = itertools.cycle([4, 3, 1, 6, 2, 5, 4])
    for compression in COMPRESSIONS:
        for kind, layout in itertools.product(["half", "float", "uint"], LAYOUTS):
            for count in (4, next(channels)):
                exr("exr_" + compression, count, kind, compression, layout, next(orders), next(windows))
    for count, layout in itertools.product(NAMES, LAYOUTS):
        for kind, order in itertools.product(["half", "float", "uint"], ORDERS):
            exr("exr_orders", count, kind, "zip", layout, order, next(windows))
    for window, layout in itertools.product(WINDOWS, LAYOUTS):
        exr("exr_windows", 4, "half", "piz", layout, "increasingY", window)


def attribute(name, kind, value):
    return name + b"\0" + kind + b"\0" + struct.pack("<i", len(value)) + value


def uncompressed(path, types):
    """An EXR of a type for each channel: rows have their channels by name."""
    names = ["A", "B", "G", "R"]
    planes = source(4, types)
    numbers = {"uint": 0, "half": 1, "float": 2}
    channels = b"".join(n.encode() + b"\0" + struct.pack("<iB3xii", numbers[t], 0, 1, 1) for n, t in zip(names, types)) + b"\0"
    window = struct.pack("<4i", 0, 0, WIDTH - 1, HEIGHT - 1)
    head = (b"\x76\x2f\x31\x01\x02\0\0\0" + attribute(b"channels", b"chlist", channels) +
            attribute(b"compression", b"compression", b"\0") + attribute(b"dataWindow", b"box2i", window) +
            attribute(b"displayWindow", b"box2i", window) + attribute(b"lineOrder", b"lineOrder", b"\0") +
            attribute(b"pixelAspectRatio", b"float", struct.pack("<f", 1)) +
            attribute(b"screenWindowCenter", b"v2f", struct.pack("<2f", 0, 0)) +
            attribute(b"screenWindowWidth", b"float", struct.pack("<f", 1)) + b"\0")
    rows = [b"".join(p[y].tobytes() for p in planes) for y in range(HEIGHT)]
    at = len(head) + 8 * HEIGHT
    offsets = b"".join(struct.pack("<Q", at + y * (8 + len(rows[0]))) for y in range(HEIGHT))
    with open(path, "wb") as file:
        file.write(head + offsets + b"".join(struct.pack("<2i", y, len(r)) + r for y, r in enumerate(rows)))
    return dict(zip(names, planes))


def mixed_exr():
    for types in itertools.product(["half", "float", "uint"], repeat=4):
        written = uncompressed("form.exr", types)
        judge("exr_mixed_types", str(types), load("form.exr"), as_picture(written, "same"))


def special_values():
    """NaN, infinities, the smallest halves: each bit as float."""
    values = np.arange(65536, dtype=np.uint16).view(np.float16).reshape(256, 64, 4)
    spec = oiio.ImageSpec(64, 256, 4, "half")
    out = oiio.ImageOutput.create("form.exr")
    out.open("form.exr", spec)
    out.write_image(values)
    out.close()
    found = load("form.exr")
    seen["exr_all_halves"] = 1
    if isinstance(found, str) or not np.array_equal(found, values.astype(np.float32), equal_nan=True):
        failures.append("exr_all_halves: a half has another value as float")


# ---- PNG ----

def linear(v):
    return np.where(v <= 0.04045, v / 12.92, ((v + 0.055) / 1.055) ** 2.4)


def chunk(name, data):
    return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))


# Chunks of colors, and what they do to a sample of 0 to 1. Rec. 2020's matrix is that of ITU-R BT.2087, of 4 digits.
CHRM_709 = struct.pack(">8I", 31270, 32900, 64000, 33000, 30000, 60000, 15000, 6000)
CHRM_2020 = struct.pack(">8I", 31270, 32900, 70800, 29200, 17000, 79700, 13100, 4600)
REC_2020 = np.array([[1.6605, -0.5876, -0.0728], [-0.1246, 1.1329, -0.0083], [-0.0182, -0.1006, 1.1187]])
COLORS = {
    "none": (b"", linear, np.eye(3)),
    "srgb": (chunk(b"sRGB", b"\0"), linear, np.eye(3)),
    "srgb_counts_before_gama": (chunk(b"gAMA", struct.pack(">I", 100000)) + chunk(b"sRGB", b"\0"), linear, np.eye(3)),
    "gama_of_srgb": (chunk(b"gAMA", struct.pack(">I", 45455)), linear, np.eye(3)),
    "gama_linear": (chunk(b"gAMA", struct.pack(">I", 100000)), lambda v: v, np.eye(3)),
    "gama_1.8": (chunk(b"gAMA", struct.pack(">I", 55556)), lambda v: v ** (1 / 0.55556), np.eye(3)),
    "chrm_of_rec_709": (chunk(b"cHRM", CHRM_709), linear, np.eye(3)),
    "chrm_of_rec_2020": (chunk(b"cHRM", CHRM_2020), linear, REC_2020),
}
# bits, gray, alpha, palette, transparent
FORMS = ([(b, True, False, False, t) for b in (1, 2, 4, 8, 16) for t in (False, True)] +
         [(b, g, True, False, False) for b in (8, 16) for g in (True, False)] +
         [(b, False, False, False, t) for b in (8, 16) for t in (False, True)] +
         [(b, False, False, True, t) for b in (1, 2, 4, 8) for t in (False, True)])


def png_file(path, form, interlace, colors):
    bits, gray, alpha, palette, transparent = form
    planes = 1 if palette or (gray and not alpha) else 2 if gray else 4 if alpha else 3
    most = 2 ** bits - 1
    values = np.random.default_rng(bits + 32 * planes).integers(0, most + 1, (11, 13, planes))
    options = {"bitdepth": bits, "interlace": interlace}
    if palette:
        entries = np.random.default_rng(bits).integers(0, 256, (2 ** bits, 4))
        options["palette"] = [tuple(int(v) for v in e[:4 if transparent else 3]) for e in entries]
    else:
        options.update(greyscale=gray, alpha=alpha)
        if transparent:
            options["transparent"] = int(values[3, 4, 0]) if gray else tuple(int(v) for v in values[3, 4])
    with open(path, "wb") as file:
        png.Writer(13, 11, **options).write(file, [[int(v) for v in row.ravel()] for row in values])
    with open(path, "rb") as file:
        data = file.read()
    with open(path, "wb") as file:
        file.write(data[:33] + colors + data[33:])
    # pypng's own pixels
    width, height, rows, info = png.Reader(filename=path).asRGBA()
    return np.array([list(r) for r in rows], float).reshape(height, width, 4) / (2 ** info["bitdepth"] - 1)


def all_png():
    for form, interlace, (name, (data, curve, matrix)) in itertools.product(FORMS, (False, True), COLORS.items()):
        read = png_file("form.png", form, interlace, data)
        wanted = np.dstack([curve(read[:, :, :3]) @ matrix.T * read[:, :, 3:], read[:, :, 3:]])
        # float's digits; the matrix has 4
        judge("png_" + name, f"{form}, interlace {interlace}", load("form.png"), wanted, 4e-4 if name.endswith("2020") else 1e-6)
    damaged = chunk(b"gAMA", struct.pack(">I", 100000))[:-1] + b"?"
    for case, data, words in (("png_of_another_space", chunk(b"cICP", bytes([9, 16, 0, 1])), "cICP"),
                              ("png_with_a_damaged_gama", damaged, "gAMA: CRC error")):
        png_file("form.png", FORMS[-1], False, b"")
        with open("form.png", "rb") as file:
            whole = file.read()
        with open("form.png", "wb") as file:
            file.write(whole[:33] + data + whole[33:])
        found = load("form.png")
        seen[case] = 1
        if not isinstance(found, str) or words not in found:
            failures.append(f"{case}: is not refused by name: {found if isinstance(found, str) else 'read'}")


all_exr()
mixed_exr()
special_values()
all_png()
for case in seen:
    bad = [f for f in failures if f.startswith(case + ":")]
    print(f"not ok {case}: {len(bad)} of {seen[case]} forms: {bad[0]}" if bad else f"ok {case}_{seen[case]}_forms")
for name, count in planted.items():
    bad = [f for f in failures if f.endswith(name + " is not noticed")]
    print(f"not ok planted_{name}: {bad[0]}" if bad else f"ok planted_{name}_in_{count}_decodes")
sys.exit(bool(failures))
