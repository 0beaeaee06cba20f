# SPDX-License-Identifier: MIT
"""An OpenEXR file of 32-bit floats without compression, by the standard library alone."""
import array
import struct
import sys


def write_exr(path, width, height, rgba):
    """rgba: floats, four a pixel, row 0 on top."""
    def attribute(name, kind, data):
        return name.encode() + b"\0" + kind.encode() + b"\0" + struct.pack("<i", len(data)) + data

    channels = b"".join(c + b"\0" + struct.pack("<iBxxxii", 2, 0, 1, 1) for c in (b"A", b"B", b"G", b"R")) + b"\0"
    window = struct.pack("<4i", 0, 0, width - 1, height - 1)
    header = struct.pack("<ii", 20000630, 2) + b"".join([
        attribute("channels", "chlist", channels), attribute("compression", "compression", b"\0"),
        attribute("dataWindow", "box2i", window), attribute("displayWindow", "box2i", window),
        attribute("lineOrder", "lineOrder", b"\0"), attribute("pixelAspectRatio", "float", struct.pack("<f", 1)),
        attribute("screenWindowCenter", "v2f", struct.pack("<2f", 0, 0)),
        attribute("screenWindowWidth", "float", struct.pack("<f", 1))]) + b"\0"
    line = 8 + 16 * width
    first = len(header) + 8 * height
    with open(path, "wb") as f:
        f.write(header + struct.pack(f"<{height}Q", *(first + y * line for y in range(height))))
        for y in range(height):
            row = rgba[4 * width * y:4 * width * (y + 1)]
            f.write(struct.pack("<ii", y, 16 * width))
            for c in (3, 2, 1, 0):
                part = array.array("f", row[c::4])
                if sys.byteorder == "big":
                    part.byteswap()
                f.write(part.tobytes())
