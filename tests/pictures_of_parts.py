# SPDX-License-Identifier: MIT
"""Writes OpenEXR files of several parts, of layers, deep, subsampled, and of other primaries, by OpenImageIO."""
import numpy as np
import OpenImageIO as oiio


def write(path, *pictures):
    """pictures: name of the part, names of the channels, value of each, extra attributes."""
    specs = []
    for name, channels, _, attributes in pictures:
        spec = oiio.ImageSpec(8, 6, len(channels), "half")
        spec.channelnames = tuple(channels)
        if name:
            spec.attribute("oiio:subimagename", name)
        for key, (kind, value) in attributes.items():
            spec.attribute(key, kind, value)
        specs.append(spec)
    out = oiio.ImageOutput.create(path)
    good = out.open(path, tuple(specs)) if len(specs) > 1 else out.open(path, specs[0])
    for i, (_, channels, values, _) in enumerate(pictures):
        if i:
            good = good and out.open(path, specs[i], "AppendSubimage")
        good = good and out.write_image(np.tile(np.array(values, np.float16), (6, 8, 1)))
    if not good:
        raise RuntimeError(path + ": " + out.geterror())
    out.close()


COLOR = ["R", "G", "B"]
write("left.exr", ("", COLOR, [0.25, 0.5, 0.75], {}))
write("right.exr", ("", COLOR, [0.75, 0.5, 0.25], {}))
write("parts.exr", ("left", COLOR, [0.25, 0.5, 0.75], {}), ("right", COLOR, [0.75, 0.5, 0.25], {}))
layers = [f"ViewLayer.{pass_name}.{c}" for pass_name in ("Combined", "DiffCol") for c in "RGB"]
write("layers.exr", ("", layers + ["ViewLayer.Depth.Z"], [0.25, 0.5, 0.75, 0.75, 0.5, 0.25, 9], {}))
write("depth.exr", ("", ["Z"], [1], {}))
chroma = ("float[8]", [0.708, 0.292, 0.170, 0.797, 0.131, 0.046, 0.3127, 0.3290])
write("rec2020.exr", ("", COLOR, [0.25, 0.5, 0.75], {"chromaticities": chroma}))
r, g, b = np.array([[1.6605, -0.5876, -0.0728], [-0.1246, 1.1329, -0.0083], [-0.0182, -0.1006, 1.1187]]) @ [0.25, 0.5, 0.75]
write("rec709.exr", ("", COLOR, [r, g, b], {}))

spec = oiio.ImageSpec(4, 4, 5, "half")
spec.channelnames = ("R", "G", "B", "A", "Z")
spec.deep = True
deep = oiio.DeepData()
deep.init(16, 5, tuple(spec.channelformat(c) for c in range(5)), spec.channelnames)
for pixel in range(16):
    deep.set_samples(pixel, 2)
out = oiio.ImageOutput.create("deep.exr")
if not (out.open("deep.exr", spec) and out.write_deep_image(deep)):
    raise RuntimeError(out.geterror())
out.close()
