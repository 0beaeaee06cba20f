# SPDX-License-Identifier: MIT
"""sheet_panel.py SHEET.json NUMBER PICTURE.png: exits 0 where that picture of the sheet is PICTURE.png, pixel by pixel."""
import json
import struct
import sys
import zlib


def load(path):
    """Rows of (r, g, b) of an 8-bit PNG, RGB or RGBA, not interlaced."""
    data = open(path, "rb").read()
    at, body = 8, b""
    while at < len(data):
        size, kind = struct.unpack(">I4s", data[at : at + 8])
        if kind == b"IHDR":
            width, height, bits, color = struct.unpack(">IIBB", data[at + 8 : at + 18])
        if kind == b"IDAT":
            body += data[at + 8 : at + 8 + size]
        at += 12 + size
    assert bits == 8 and color in (2, 6), (bits, color)
    n = 3 if color == 2 else 4
    raw, before, rows = zlib.decompress(body), bytearray(width * n), []
    for y in range(height):
        start = y * (width * n + 1)
        kind, row = raw[start], bytearray(raw[start + 1 : start + 1 + width * n])
        for i in range(width * n):
            a, b, c = (row[i - n] if i >= n else 0), before[i], (before[i - n] if i >= n else 0)
            if kind == 1:
                row[i] = (row[i] + a) & 255
            elif kind == 2:
                row[i] = (row[i] + b) & 255
            elif kind == 3:
                row[i] = (row[i] + (a + b) // 2) & 255
            elif kind == 4:
                p = a + b - c
                near = min((abs(p - a), 0, a), (abs(p - b), 1, b), (abs(p - c), 2, c))[2]
                row[i] = (row[i] + near) & 255
        rows.append([tuple(row[n * x : n * x + 3]) for x in range(width)])
        before = row
    return rows


def main():
    sheet = json.load(open(sys.argv[1]))
    panel = sheet["pictures"][int(sys.argv[2]) - 1]
    left, top, size = panel["left"], panel["top"], panel["size"]
    picture = load(sys.argv[3])
    crop = [row[left : left + size] for row in load(sheet["sheet"])[top : top + size]]
    if len(picture) != size or any(len(row) != size for row in picture):
        sys.exit("the picture is %d pixels high, the panel %d" % (len(picture), size))
    worst = max(abs(a - b) for p, q in zip(picture, crop) for u, v in zip(p, q) for a, b in zip(u, v))
    shown = len({u for row in picture for u in row})
    if worst > 0:
        sys.exit("differs by up to %d of 255" % worst)
    if shown < 8:
        sys.exit("shows %d colors only" % shown)


if __name__ == "__main__":
    main()
