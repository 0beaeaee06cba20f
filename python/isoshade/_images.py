# SPDX-License-Identifier: MIT
"""Images and their comparison."""
import ctypes
import os
from ctypes import byref
from typing import NamedTuple, Tuple

import numpy as np

from . import _native as native


def _struct(image):
    """Returns the struct of an array, and the array that owns its pixels."""
    if np.asarray(image).dtype.kind != "f":
        raise TypeError(f"image has the type {np.asarray(image).dtype}, must be floats: linear light, 1 is white")
    pixels = np.ascontiguousarray(image, np.float32)
    if pixels.ndim != 3 or pixels.shape[2] != 4:
        raise ValueError(f"image has shape {pixels.shape}, must be (height, width, 4)")
    s = native.ImageStruct()
    s.height, s.width = pixels.shape[:2]
    s.rgba = pixels.ctypes.data_as(ctypes.POINTER(ctypes.c_float))
    return s, pixels


class Image(np.ndarray):
    """A numpy array of float32, shape (height, width, 4): linear light, color multiplied by alpha, top row first."""

    def __array_wrap__(self, array, *more):
        return array[()] if array.ndim == 0 else super().__array_wrap__(array, *more)  # image.mean() is a number

    @classmethod
    def _taken(cls, struct):
        """Copies the pixels of a struct of the library, and frees it."""
        shape = (struct.height, struct.width, 4)
        try:
            return np.ctypeslib.as_array(struct.rgba, shape).copy().view(cls)
        finally:
            native.lib.iso_image_destroy(byref(struct))

    def save(self, path, exposure: float = 1) -> None:
        """Writes .exr (float) or .png (8-bit sRGB, colors multiplied by exposure)."""
        s, _pixels = _struct(self)
        ending = os.path.splitext(os.fspath(path))[1].lower()
        if ending == ".exr":
            native.call("iso_image_save_exr", byref(s), native.text(path), None)
        elif ending == ".png":
            native.call("iso_image_save_png", byref(s), native.text(path), exposure)
        else:
            raise ValueError(f"{path}: an image is saved as .exr or .png")

    def _repr_png_(self):
        if self.ndim != 3 or self.shape[2] != 4:
            return None
        s, _pixels = _struct(self)
        data, size = ctypes.c_void_p(), ctypes.c_size_t()
        native.call("iso_image_png", byref(s), 1.0, byref(data), byref(size))
        return native.take_bytes(data, size)


def load_image(path) -> Image:
    """Loads an .exr or .png file."""
    s = native.ImageStruct()
    png = os.fspath(path).lower().endswith(".png")
    native.call("iso_image_load_png" if png else "iso_image_load_exr", native.text(path), byref(s))
    return Image._taken(s)


class Metrics(NamedTuple):
    """Differences of two images: NaN if a pixel is not finite. flip: visible difference, 0 to 1. ssim: 1 if equal."""

    rmse: float
    max_abs: float
    p99_abs: float
    psnr_db: float
    ssim: float
    flip: float
    nonfinite_count: int
    worst: Tuple[int, int]


def compare(a, b) -> Metrics:
    """Compares two images of shape (height, width, 4), linear light."""
    (first, _a), (second, _b) = _struct(a), _struct(b)
    m = native.MetricsStruct()
    native.call("iso_metrics_measure", byref(first), byref(second), byref(m))
    return Metrics(m.rmse, m.max_abs, m.p99_abs, m.psnr_db, m.ssim, m.flip_mean, m.nonfinite_count, tuple(m.worst))
