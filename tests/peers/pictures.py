#!/usr/bin/python3
# SPDX-License-Identifier: MIT
"""Reading pictures as numbers without a library of pictures, for the scripts beside this one."""
import struct
import zlib

import numpy as np


def read_exr(path):
    """A scan-line OpenEXR of floats, not compressed or by ZIP, as isoshade writes them: {channel: [row, column]}."""
    data = open(path, "rb").read()
    at, head = 8, {}
    while data[at]:
        name, at = data[at:data.index(b"\0", at)], data.index(b"\0", at) + 1
        at = data.index(b"\0", at) + 1  # the type
        size = struct.unpack_from("<i", data, at)[0]
        head[name], at = data[at + 4:at + 4 + size], at + 4 + size
    names, c = [], 0
    while head[b"channels"][c]:
        end = head[b"channels"].index(b"\0", c)
        assert struct.unpack_from("<i", head[b"channels"], end + 1)[0] == 2, "floats alone"
        names, c = names + [head[b"channels"][c:end].decode()], end + 17
    left, top, right, bottom = struct.unpack("<4i", head[b"dataWindow"])
    width, height = right - left + 1, bottom - top + 1
    lines = {0: 1, 2: 1, 3: 16}[head[b"compression"][0]]
    out = np.zeros((height, len(names), width), "f4")
    for place in struct.unpack_from(f"<{-(-height // lines)}Q", data, at + 1):
        y, size = struct.unpack_from("<ii", data, place)
        rows = min(lines, height - (y - top))
        block, whole = data[place + 8:place + 8 + size], rows * len(names) * width * 4
        if size < whole:  # differences of bytes, even ones before odd ones
            b = np.frombuffer(zlib.decompress(block), np.uint8).astype(np.int64)
            b = (np.cumsum(b) - 128 * np.arange(len(b))) % 256
            block = np.stack([b[:whole // 2], b[whole // 2:]], axis=1).astype(np.uint8).tobytes()
        out[y - top:y - top + rows] = np.frombuffer(block, "<f4").reshape(rows, len(names), width)
    return {name: out[:, i] for i, name in enumerate(names)}


def read_png(path):
    """Its integers as parts of the largest one: [row, column, channel]. 8 or 16 bits, not interlaced, no palette."""
    data = open(path, "rb").read()
    at, parts = 8, b""
    while at < len(data):
        size, kind = struct.unpack_from(">I4s", data, at)
        body = data[at + 8:at + 8 + size]
        if kind == b"IHDR":
            width, height, bits, color, _, _, interlaced = struct.unpack(">IIBBBBB", body)
            assert not interlaced and color in (0, 2, 4, 6) and bits in (8, 16)
        if kind == b"IDAT":
            parts += body
        at += 12 + size
    channels = {0: 1, 2: 3, 4: 2, 6: 4}[color]
    step, raw = channels * bits // 8, zlib.decompress(parts)
    stride = step * width
    out, above = np.zeros((height, stride), np.uint8), np.zeros(stride, np.int64)
    for y in range(height):
        kind, line = raw[y * (stride + 1)], np.frombuffer(raw, np.uint8, stride, y * (stride + 1) + 1).astype(np.int64)
        if kind == 1:
            line = np.cumsum(line.reshape(width, step), axis=0).ravel() % 256
        elif kind == 2:
            line = (line + above) % 256
        elif kind:
            for x in range(stride):
                a, b, c = (line[x - step] if x >= step else 0), above[x], (above[x - step] if x >= step else 0)
                pa, pb, pc = abs(b - c), abs(a - c), abs(a + b - 2 * c)
                near = a if pa <= pb and pa <= pc else b if pb <= pc else c
                line[x] = (line[x] + ((a + b) // 2 if kind == 3 else near)) % 256
        out[y], above = line, line
    return out.view(">u2" if bits == 16 else np.uint8).reshape(height, width, channels) / (2.0 ** bits - 1)
