#!/usr/bin/python3
# SPDX-License-Identifier: MIT
"""SSIM and FLIP against programs of others, on pairs that are made here and on pairs of yours.

    python3 tests/peers/metrics.py
    python3 tests/peers/metrics.py --flip REFERENCE.png TEST.png MAP.png

SSIM: scikit-image's structural_similarity as [wang-2004] has it (Gaussian window of sigma 1.5 and 11 x 11, sample
variances without correction, range 1), on the luma of the sRGB colors, windows inside the image; limit 1e-7, for pictures
travel as 16 bits, which both read alike, and isoshade's pixels are floats. FLIP: MAP.png is what the program of its authors
wrote for the pair (colors of matplotlib's magma, 8 bits): 99 % of the pixels have to lie within half a step of it, all within
two thirds of one (single precision), and the means within 1e-4. Debian packages: python3-skimage, python3-matplotlib."""
import argparse
import json
import os
import subprocess
import sys
import tempfile

import numpy

TOP = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..")
ISOSHADE = os.environ.get("ISOSHADE", os.path.join(TOP, "isoshade"))


def compare(a, b, *options):
    result = subprocess.run([ISOSHADE, "compare", a, b, "--json", *options], stdout=subprocess.PIPE, check=False)
    if result.returncode > 1:
        sys.exit("isoshade compare failed")
    return json.loads(result.stdout)


def write_ppm(path, linear):
    """16 bits, linear; returns what was kept."""
    bits = numpy.round(numpy.clip(linear, 0, 1) * 65535).astype(">u2")
    with open(path, "wb") as f:
        f.write(b"P6\n%d %d\n65535\n" % (bits.shape[1], bits.shape[0]) + bits.tobytes())
    return (bits.astype(float) / 65535).astype(numpy.float32).astype(float)


def luma(linear):
    srgb = numpy.where(linear <= 0.0031308, 12.92 * linear, 1.055 * numpy.maximum(linear, 1e-9) ** (1 / 2.4) - 0.055)
    return srgb @ [0.299, 0.587, 0.114]


def pairs():
    """Noise, a shift, a blur, less contrast, a brighter image: of a picture with edges, waves and fine noise."""
    random = numpy.random.default_rng(1)
    y, x = numpy.mgrid[0:93, 0:117]
    picture = numpy.stack([0.5 + 0.3 * numpy.sin(0.31 * x) * numpy.cos(0.2 * y), 0.4 + 0.3 * numpy.cos(0.17 * (x + 2 * y)),
                           numpy.where((x - 60) ** 2 + (y - 40) ** 2 < 700, 0.8, 0.1)], axis=-1)
    picture = numpy.clip(picture + 0.03 * random.standard_normal(picture.shape), 0, 1)
    yield "noise", picture, picture + 0.1 * random.standard_normal(picture.shape)
    yield "one pixel aside", picture, numpy.roll(picture, 1, axis=1)
    yield "mean of neighbors", picture, (picture + numpy.roll(picture, 1, 0) + numpy.roll(picture, 1, 1)) / 3
    yield "half the contrast", picture, 0.25 + 0.5 * picture
    yield "twice as bright", 0.5 * picture, picture
    yield "something else", picture, picture[::-1, ::-1]


def check_ssim(folder):
    from skimage.metrics import structural_similarity
    good = True
    a, b = os.path.join(folder, "a.ppm"), os.path.join(folder, "b.ppm")
    for name, first, second in pairs():
        images = [luma(write_ppm(path, image)) for path, image in ((a, first), (b, second))]
        theirs = structural_similarity(*images, gaussian_weights=True, sigma=1.5, use_sample_covariance=False, data_range=1)
        ours = compare(a, b)["ssim"]
        same = abs(ours - theirs) <= 1e-7
        good = good and same
        print(f"ssim  {name:20} scikit-image {theirs:.9f}  isoshade {ours:.9f}  {'same' if same else 'DIFFERENT'}")
    return good


def check_flip(folder, reference, test, map_path):
    import matplotlib.pyplot
    theirs = matplotlib.pyplot.imread(map_path)[..., :3]
    magma = numpy.array([matplotlib.pyplot.get_cmap("magma")(i)[:3] for i in range(256)])
    table = {tuple(color): i for i, color in enumerate(numpy.round(255 * magma).astype(int).tolist())}
    colors = numpy.round(255 * theirs).astype(int).reshape(-1, 3)
    steps = numpy.array([table.get(tuple(c), -1) for c in colors.tolist()])
    if (steps < 0).any():
        sys.exit(f"{map_path}: has colors that are none of magma's")
    own = os.path.join(folder, "map.exr")
    gray = os.path.join(folder, "authors.ppm")
    mean = compare(reference, test, "--flip-map", own)["flip_mean"]
    write_ppm(gray, numpy.repeat((steps / 255).reshape(*theirs.shape[:2], 1), 3, axis=2))
    apart = compare(own, gray)
    # Half a step of 8 bits, and the 16 bits of the picture on the way.
    same = apart["p99_abs"] <= 0.5 / 255 + 2e-5 and apart["max_abs"] <= 0.67 / 255 and abs(mean - steps.mean() / 255) <= 1e-4
    print(f"flip  mean of the authors' map {steps.mean() / 255:.6f} (8 bits)  isoshade {mean:.6f}; largest difference of a pixel "
          f"{255 * apart['max_abs']:.3f} steps of 8 bits, of 99 % {255 * apart['p99_abs']:.3f}  {'same' if same else 'DIFFERENT'}")
    return same


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--flip", nargs=3, metavar=("REFERENCE.png", "TEST.png", "MAP.png"))
    args = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        good = check_flip(folder, *args.flip) if args.flip else check_ssim(folder)
    sys.exit(0 if good else 1)


main()
