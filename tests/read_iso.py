# SPDX-License-Identifier: MIT
"""Reads what isoshade writes, by doc/reference/files-pyramid.md and files-scene.md alone: numpy and the standard library, no source of it.

    read_iso.py pyramid NAME.iso [GRID.vdb]     checksums, headers, geometry, values and directions of every level
    read_iso.py slab IMAGE.exr NAME.iso SCENE   a constant volume, seen along an axis: the pixel in the middle
    read_iso.py examples PAGE                   the worked examples of the page

Ends with 1 and a line that says why where something is not as it should be. WRONG=name in the environment plants a
fault: a decoder or a rule of this file that is not the documented one.
"""
import json
import math
import os
import re
import struct
import sys
import zlib

import numpy as np

WRONG = os.environ.get("WRONG", "")


class Wrong(Exception):
    pass


def expect(condition, message):
    if not condition:
        raise Wrong(message)


# ---- checksums: XXH3, 64 bits, seed 0, of more than 240 bytes (specified at github.com/Cyan4973/xxHash) ----

SECRET = bytes.fromhex(
    "b8fe6c3923a44bbe7c01812cf721ad1cded46de9839097db7240a4a4b7b3671fcb79e64eccc0e578825ad07dccff7221"
    "b8084674f743248ee03590e6813a264c3c2852bb91c300cb88d0658b1b532ea371644897a20df94e3819ef46a9deacd8"
    "a8fa763fe39c343ff9dcbbc7c70b4f1d8a51e04bcdb45931c89f7ec9d9787364eac5ac8334d3ebc3c581a0fffa1363eb"
    "170ddd51b7f0da49d316552629d4689e2b16be587d47a1fc8ff8b8d17ad031ce45cb3a8f95160428afd7fbcabb4b407e"
)
PRIME32_1, PRIME32_2, PRIME32_3 = 0x9E3779B1, 0x85EBCA77, 0xC2B2AE3D
PRIME64 = [0x9E3779B185EBCA87, 0xC2B2AE3D27D4EB4F, 0x165667B19E3779F9, 0x85EBCA77C2B2AE63, 0x27D4EB2F165667C5]
MASK = (1 << 64) - 1


def accumulate(acc, data, secret):
    """Stripes of 64 bytes: 8 lanes each; stripe n uses the secret from byte 8 n on."""
    stripes = len(data) // 64
    lanes = np.frombuffer(data, "<u8", 8 * stripes).reshape(stripes, 8)
    keys = np.stack([np.frombuffer(secret, "<u8", 8, 8 * n) for n in range(stripes)])
    mixed = lanes ^ keys
    products = (mixed & np.uint64(0xFFFFFFFF)) * (mixed >> np.uint64(32))
    acc += products.sum(axis=0, dtype=np.uint64)
    acc += lanes.sum(axis=0, dtype=np.uint64)[[1, 0, 3, 2, 5, 4, 7, 6]]


def xxh3_64(data):
    expect(len(data) > 240, "files of at most 240 bytes have another sum")
    acc = np.array([PRIME32_3, *PRIME64[:4], PRIME32_2, PRIME64[4], PRIME32_1], np.uint64)
    with np.errstate(over="ignore"):
        blocks = (len(data) - 1) // 1024
        for b in range(blocks):
            accumulate(acc, data[1024 * b:1024 * (b + 1)], SECRET)
            acc ^= acc >> np.uint64(47)
            acc ^= np.frombuffer(SECRET, "<u8", 8, 128)
            acc *= np.uint64(PRIME32_1)
        rest = data[1024 * blocks:]
        stripes = (len(rest) - 1) // 64
        if stripes:
            accumulate(acc, rest[:64 * stripes], SECRET)
        accumulate(acc, data[-64:], SECRET[121:])
    result = len(data) * PRIME64[0] & MASK
    for i in range(4):
        a = int(acc[2 * i]) ^ int.from_bytes(SECRET[11 + 16 * i:19 + 16 * i], "little")
        b = int(acc[2 * i + 1]) ^ int.from_bytes(SECRET[19 + 16 * i:27 + 16 * i], "little")
        product = a * b
        result = (result + ((product & MASK) ^ (product >> 64))) & MASK
    result ^= result >> 37
    result = result * 0x165667919E3779F9 & MASK
    return "%016x" % (result ^ (result >> 32))


# ---- NRRD ----

NRRD_TYPES = {"uint8": "u1", "int8": "i1", "uint16": "<u2", "int16": "<i2", "float": "<f4"}


def read_nrrd(data, name):
    """Fields, and samples as an array [z, y, x] or [z, y, x, component]."""
    end = data.index(b"\n\n") + 2
    lines = data[:end].decode("ascii").splitlines()
    expect(lines[0] == "NRRD0004", f"{name}: starts with {lines[0]}")
    expect(end % 64 == 0, f"{name}: samples begin at byte {end}, no multiple of 64")
    fields = dict(line.split(": ", 1) for line in lines[1:] if line and not line.startswith("#"))
    expect(fields["encoding"] == "raw" and fields["endian"] == "little", f"{name}: not raw and little-endian")
    sizes = [int(s) for s in fields["sizes"].split()]
    expect(len(sizes) == int(fields["dimension"]), f"{name}: {len(sizes)} sizes")
    dtype = np.dtype(NRRD_TYPES[fields["type"]])
    expect(len(data) - end == dtype.itemsize * math.prod(sizes), f"{name}: {len(data) - end} bytes of samples")
    return fields, np.frombuffer(data, dtype, offset=end).reshape(sizes[::-1])


def vector(text):
    return np.array([float(v) for v in text.strip("()").split(",")])


# ---- direction codes ----

SIGNED = {"fit", "snorm", "shell", "free"}


def trust(e):
    length = np.linalg.norm(e, axis=-1)
    return np.clip(4.0 * (length - 0.006793), 0, 1)


def of_length(v, length):
    return v * (length / np.maximum(np.linalg.norm(v, axis=-1), 1e-9))[..., None]


def unit(e):
    return of_length(e, trust(e))


def by_rank(e, change):
    """change: from (high, middle, low) of |e| to new ones; each component gets that of its rank, and its own sign."""
    order = np.argsort(-np.abs(e), axis=-1, kind="stable")
    ranked = np.take_along_axis(np.abs(e), order, -1)
    new = change(np.maximum(ranked[..., 0], 1e-9), ranked[..., 1], ranked[..., 2])
    out = np.empty_like(e)
    np.put_along_axis(out, order, new, -1)
    return of_length(np.copysign(out, e), trust(e))


def region48(e):
    lam = 0.5 if WRONG == "lambda" else 0.61

    def change(high, middle, low):
        u, v, w = ((1 - lam + lam * t) * t for t in (1 - middle / high, (middle - low) / high, low / high))
        return np.stack([u + v + w, v + w, w], -1)
    return by_rank(e, change)


DECODERS = {"fit": lambda e: e, "snorm": lambda e: e, "shell": lambda e: e, "free": unit, "cube": unit,
            "region48": region48}
# The largest angle between a direction and what its code stands for, in degrees.
LARGEST_ERROR = {"fit": 0.33, "snorm": 0.3907, "shell": 0.34, "free": 0.3198, "cube": 0.3178, "region48": 0.17304}


def decode(code, stored):
    if code in SIGNED:
        e = stored.astype(np.float64) / (128 if WRONG == "signed" else 127)
    else:
        e = (2.0 * stored.astype(np.float64) - 255) / 255
    return DECODERS[code](e)


# ---- a pyramid ----

def read_file(folder, entry):
    expect("/" not in entry["name"], "a file outside its folder")
    with open(os.path.join(folder, entry["name"]), "rb") as file:
        data = file.read()
    expect(len(data) == entry["bytes"], f"{entry['name']}: {len(data)} bytes, pyramid.json says {entry['bytes']}")
    expect(xxh3_64(data) == entry["xxh3_64"], f"{entry['name']}: checksum {xxh3_64(data)}, not {entry['xxh3_64']}")
    return read_nrrd(data, entry["name"])


def check_header(name, fields, geometry, components):
    matrix = np.array(geometry["index_to_world"]).reshape(3, 3)
    first = np.array(geometry["origin_mm"]) + matrix @ [0.5, 0.5, 0.5]
    columns = [vector(v) for v in fields["space directions"].replace("none ", "").split()]
    expect(np.allclose(np.stack(columns, -1), matrix, rtol=1e-15, atol=0), f"{name}: space directions")
    expect(np.allclose(vector(fields["space origin"]), first, rtol=1e-15, atol=1e-15), f"{name}: space origin")
    sizes = [int(s) for s in fields["sizes"].split()]
    expect(sizes[-3:] == geometry["size"] and sizes[:-3] == components, f"{name}: sizes {sizes}")


NO_CHECKSUM = "0" * 16


def with_checksum(text, place):
    """The text of a pyramid.json with its own checksum at a place: of the text with zeros there."""
    zeroed = text[:place] + NO_CHECKSUM + text[place + 16:]
    return text[:place] + xxh3_64(zeroed.encode()) + text[place + 16:]


def write_description(path, description):
    """A pyramid.json that is as a careful forger leaves it: its checksum fits."""
    text = json.dumps({**description, "xxh3_64": NO_CHECKSUM}, indent=2)
    with open(path, "w", encoding="utf-8") as file:
        file.write(with_checksum(text, text.rindex(NO_CHECKSUM)))


def read_pyramid(folder):
    with open(os.path.join(folder, "pyramid.json"), encoding="utf-8") as file:
        text = file.read()
    description = json.loads(text)
    expect(with_checksum(text, text.rindex(description["xxh3_64"])) == text, "pyramid.json: its own checksum")
    expect(description["schema"] == "isoshade.pyramid/1", f"schema {description['schema']}")
    code = description["options"]["code"]
    levels = []
    for k, level in enumerate(description["levels"]):
        arrays = {}
        for key, entry in level["files"].items():
            fields, arrays[key] = read_file(folder, entry)
            check_header(entry["name"], fields, level["geometry"], [3] if key in ("codes", "directions") else [])
        expect(arrays["scalar"].dtype == np.dtype(NRRD_TYPES[level["stored_type"]]), f"level {k}: type of the scalar")
        expect((float(arrays["scalar"].min()), float(arrays["scalar"].max())) == (level["min"], level["max"]),
               f"level {k}: min and max")
        arrays["decoded"] = decode(code, arrays["codes"])
        levels.append(arrays)
    return description, levels


def check_geometry(description):
    for fine, coarse in zip(description["levels"], description["levels"][1:]):
        f, c = fine["geometry"], coarse["geometry"]
        expect(c["size"] == [(n + 1) // 2 for n in f["size"]], "a level's sizes")
        expect(np.array_equal(np.array(c["index_to_world"]), 2 * np.array(f["index_to_world"])), "a level's spacing")
        expect(c["origin_mm"] == f["origin_mm"], "a level's origin")
        expect(np.array_equal(np.array(c["box_index"]), np.array(f["box_index"]) / 2), "a level's box")


def check_means(description, levels):
    """A level is the mean of eight voxels; where a size is odd, the fine level is continued by its edge."""
    if description["options"]["scalar_filter"] != "mean":
        return
    for k, (fine, coarse) in enumerate(zip(levels, levels[1:])):
        s = fine["scalar"].astype(np.float64)
        s = np.pad(s, [(0, n % 2) for n in s.shape], mode="edge")
        mean = sum(s[a::2, b::2, c::2] for a in (0, 1) for b in (0, 1) for c in (0, 1)) / 8
        # floats of the level, and of the sums of eight
        tolerance = 4e-7 * np.abs(s).max()
        expect(np.abs(mean - coarse["scalar"]).max() <= tolerance, f"level {k + 1}: not the means of the finer level")


def angles_deg(a, b):
    return np.degrees(np.arctan2(np.linalg.norm(np.cross(a, b), axis=-1), (a * b).sum(-1)))


def check_directions(code, level, k):
    """Against the floats that were encoded (--keep-float). Codes of directions alone are sure of all that has one."""
    if "directions" not in level:
        return 0.0
    true, got = level["directions"].astype(np.float64), level["decoded"]
    length = np.linalg.norm(true, axis=-1)
    expect(np.all(np.linalg.norm(got[length == 0], axis=-1) <= 1e-12), f"level {k}: a direction where there is none")
    keeps_length = code in ("fit", "snorm")
    sure = length > (0.25 if keeps_length else 0.01)
    if not sure.any():
        return 0.0
    # A vector of half the length has half the steps across: its angle is twice as coarse.
    error = angles_deg(true[sure], got[sure]) * (length[sure] if keeps_length else 1)
    # 2 %: lengths of fit are not quite those that were asked for; 1e-4 degrees: floats
    expect(error.max() <= LARGEST_ERROR[code] * (1.02 if code == "fit" else 1) + 1e-4,
           f"level {k}: off by {error.max():.4f} degrees, {code} by at most {LARGEST_ERROR[code]}")
    return error.max()


def check_vdb(path, description, levels):
    """What the program decodes itself: float grids of level K, x fastest, voxel centers at whole indices."""
    import pyopenvdb as vdb
    for k, level in enumerate(levels):
        suffix = f"_level_{k}" if len(levels) > 1 else ""
        shape = level["scalar"].shape
        density = np.zeros(shape[::-1], np.float32)
        vdb.read(path, "density" + suffix).copyToArray(density)
        same = np.array_equal(density.transpose(2, 1, 0), level["scalar"].astype(np.float32))
        expect(same, f"level {k}: values of the VDB")
        gradient = np.zeros(shape[::-1] + (3,), np.float32)
        vdb.read(path, "gradient" + suffix).copyToArray(gradient)
        worst = np.abs(gradient.transpose(2, 1, 0, 3) - level["decoded"]).max()
        # the program decodes in single precision
        expect(worst <= 5e-6, f"level {k}: decoded directions differ from the program's by {worst:.2g}")


def pyramid(folder, vdb=None):
    description, levels = read_pyramid(folder)
    check_geometry(description)
    check_means(description, levels)
    code = description["options"]["code"]
    worst = max(check_directions(code, level, k) for k, level in enumerate(levels))
    if vdb:
        check_vdb(vdb, description, levels)
    print(f"{code}: {len(levels)} levels, directions within {worst:.4f} degrees")


# ---- transfer functions and scenes ----

def srgb_to_linear(c):
    return c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4


def tf_table(tf, low, high, mean_spacing_mm):
    """Entries (r, g, b, extinction per mm) over [lo, hi]."""
    fit = tf["range"] == "fit"
    lo, hi = (low, high) if fit else tf["range"]
    unit_mm = tf["unit_distance_mm"] if "unit_distance_mm" in tf else tf["unit_distance_voxels"] * mean_spacing_mm
    to_linear = srgb_to_linear if tf["color_space"] == "srgb" else float
    values = [lo + p["value"] * (hi - lo) if fit else p["value"] for p in tf["points"]]
    entries = []
    count = tf.get("table_size", 256)
    at = lo + np.arange(count) * (hi - lo) / (count - 1)
    for key in "rgb":
        entries.append(np.interp(at, values, [to_linear(p[key]) for p in tf["points"]]))
    opacity = np.minimum(np.interp(at, values, [p["opacity"] for p in tf["points"]]), 0.9999)
    entries.append(-np.log1p(-opacity) / unit_mm)
    return lo, hi, np.stack(entries, -1), unit_mm


def tf_lookup(table, value):
    lo, hi, entries, unit_mm = table
    x = np.clip((value - lo) / (hi - lo), 0, 1) * (len(entries) - 1)
    if WRONG == "opacity":  # opacity between entries, where extinction is to be
        opacity = 1 - np.exp(-entries[:, 3] * unit_mm)
        return [np.interp(x, range(len(entries)), entries[:, c]) for c in range(3)] + [
            -math.log1p(-np.interp(x, range(len(entries)), opacity)) / unit_mm]
    return [float(np.interp(x, range(len(entries)), entries[:, c])) for c in range(4)]


def read_exr(path):
    """An array [row, column, R G B A]; files hold A B G R, in scan lines of floats that are packed by ZIP."""
    with open(path, "rb") as file:
        data = file.read()
    expect(data[:4] == b"\x76\x2f\x31\x01", f"{path}: no EXR")
    at, header = 8, {}
    while data[at]:
        name = data[at:].split(b"\0", 1)[0]
        at += len(name) + 1
        kind = data[at:].split(b"\0", 1)[0]
        at += len(kind) + 1
        size, = struct.unpack_from("<i", data, at)
        header[name.decode()] = data[at + 4:at + 4 + size]
        at += 4 + size
    at += 1
    x0, y0, x1, y1 = struct.unpack("<4i", header["dataWindow"])
    width, height = x1 - x0 + 1, y1 - y0 + 1
    expect(header["compression"] == b"\x03", f"{path}: not packed by ZIP")
    image = np.zeros((height, 4, width), "<f4")
    for offset in struct.unpack_from(f"<{(height + 15) // 16}Q", data, at):
        row, size = struct.unpack_from("<ii", data, offset)
        rows = min(16, y0 + height - row)
        block = data[offset + 8:offset + 8 + size]
        if size < rows * width * 16:
            packed = np.frombuffer(zlib.decompress(block), np.uint8).astype(np.int64)
            packed[1:] -= 128
            packed = (np.cumsum(packed) & 255).astype(np.uint8)
            half = (len(packed) + 1) // 2
            plain = np.empty_like(packed)
            plain[0::2], plain[1::2] = packed[:half], packed[half:]
            block = plain.tobytes()
        image[row - y0:row - y0 + rows] = np.frombuffer(block, "<f4").reshape(rows, 4, width)
    return image.transpose(0, 2, 1)[:, :, ::-1]


def slab(image_path, folder, scene_path):
    description, levels = read_pyramid(folder)
    with open(scene_path, encoding="utf-8") as file:
        scene = json.load(file)
    tf = scene["tf"]
    if isinstance(tf, str):
        with open(os.path.join(os.path.dirname(scene_path), tf), encoding="utf-8") as file:
            tf = json.load(file)
    level = description["levels"][0]
    expect(level["min"] == level["max"], "the volume is not constant")
    matrix = np.array(level["geometry"]["index_to_world"]).reshape(3, 3)
    spacing = np.linalg.norm(matrix, axis=0)
    table = tf_table(tf, level["min"], level["max"], np.cbrt(abs(np.linalg.det(matrix))))
    r, g, b, extinction = tf_lookup(table, level["min"])
    # Along the axis that the camera looks along. No direction anywhere: n = 0, so the ambient light alone.
    depth = float(np.abs(np.array(scene["camera"]["direction"])) @ (spacing * level["geometry"]["box_index"]))
    alpha = 1 - math.exp(-extinction * depth)
    shade = scene["shading"]["ambient"]
    wanted = [alpha * shade * c + (1 - alpha) * w for c, w in zip((r, g, b), scene["background"])] + [alpha]
    image = read_exr(image_path)
    got = image[image.shape[0] // 2, image.shape[1] // 2]
    expect(image.shape[:2] == (scene["image"]["height"], scene["image"]["width"]), f"an image of {image.shape}")
    # the table and the image are floats
    expect(np.abs(got - wanted).max() <= 1e-6, f"the pixel is {got}, by its formula {wanted}")
    print(f"slab: alpha {alpha:.6f}")


def examples(page):
    """Rows "| code | 3 bytes | dx, dy, dz |"."""
    count = 0
    with open(page, encoding="utf-8") as file:
        for row in re.finditer(r'^\| "(\w+)" \| (-?\d+), (-?\d+), (-?\d+) \| ([-.\d, ]+) \|$', file.read(), re.M):
            code, stored = row[1], np.array([[int(row[2]), int(row[3]), int(row[4])]])
            shown = [float(v) for v in row[5].split(",")]
            got = decode(code, stored)[0]
            # the page shows four digits
            right = np.abs(got - shown).max() <= 0.5e-4
            expect(right, f"{code} of {stored[0]}: the page has {shown}, the formulas give {got}")
            count += 1
    expect(count >= len(DECODERS), f"{count} examples, fewer than codes")
    print(f"examples: {count}")


def main(arguments):
    try:
        if arguments[0] == "pyramid":
            pyramid(*arguments[1:])
        elif arguments[0] == "slab":
            slab(*arguments[1:])
        else:
            examples(arguments[1])
    except Wrong as why:
        print(f"read_iso: {why}")
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
