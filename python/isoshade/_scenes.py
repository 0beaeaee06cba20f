# SPDX-License-Identifier: MIT
"""Transfer functions and scenes."""
import ctypes
import json
import os
from ctypes import byref
from typing import Optional, Sequence, Tuple

import numpy as np

from . import _native as native


def _text(name, handle):
    made = ctypes.c_void_p()
    native.call(name, native.pointer(handle, "Tf" if name == "iso_tf_text" else "Scene"), byref(made))
    return native.take_text(made)


class Tf(native.Handle):
    """A transfer function: color and opacity per value.

    points: at least two of (value, (r, g, b), opacity) with rising values; colors are linear light, 0 to 1.
    unit: length in mm that opacities refer to.
    """

    _free = "iso_tf_free"

    def __init__(self, points: Sequence[Tuple[float, Sequence[float], float]], unit: float = 1):
        array = (native.TfPoint * len(points))()
        for to, point in zip(array, points):
            try:
                to.value, to.rgb_linear[:], to.opacity = point
            except (TypeError, ValueError):
                raise ValueError(f"a point is {point}, must be (value, (r, g, b), opacity)") from None
        made = self._made_by("iso_tf_from_points", array, len(points), unit)
        super().__init__(made._pointer)
        made._pointer = None

    @classmethod
    def open(cls, path) -> "Tf":
        """Opens NAME.tf.json, or a file of another program."""
        return cls._made_by("iso_tf_open", native.text(path))

    @property
    def points(self):
        """List of (value, (r, g, b), opacity)."""
        count = native.lib.iso_tf_points(self._pointer, None, 0)
        array = (native.TfPoint * count)()
        native.lib.iso_tf_points(self._pointer, array, count)
        return [(p.value, tuple(p.rgb_linear), p.opacity) for p in array]

    def evaluate(self, pyramid, values) -> np.ndarray:
        """Looks up values, of any shape, as renderers of the pyramid do: (..., 4) of r, g, b, extinction per mm."""
        values = np.ascontiguousarray(values, float)
        out = np.empty(values.shape + (4,))
        native.call("iso_tf_evaluate", self._pointer, native.pointer(pyramid, "Pyramid"), values.ctypes.data, values.size,
                    out.ctypes.data)
        return out

    def adapt(self, pyramid, level: int) -> "Tf":
        """Returns the transfer function with which the level looks like the volume."""
        native.check_count("level", level)
        return Tf._made_by("iso_tf_adapt", self._pointer, native.pointer(pyramid, "Pyramid"), level)

    def save(self, path) -> None:
        """Writes NAME.tf.json."""
        native.call("iso_tf_save", self._pointer, native.text(path))

    def __reduce__(self):
        return _restore_tf, (_text("iso_tf_text", self),)

    def __repr__(self):
        points = self.points
        return f"Tf of {len(points)} points, {points[0][0]:g} to {points[-1][0]:g}"


def _restore_tf(text):
    return Tf._made_by("iso_tf_from_text", native.text(text))


class Scene(native.Handle):
    """Camera, lights, shading, background and transfer function.

    source: a dict with the keys of a scene file (doc/reference/files-scene.md). scene["background"] = [1, 1, 1] changes
    a part; Pyramid.scene() makes one for a volume.
    """

    _free = "iso_scene_free"

    def __init__(self, source: dict):
        made = self._made_by("iso_scene_from_text", native.text(json.dumps(source)))
        super().__init__(made._pointer)
        made._pointer = None

    @classmethod
    def open(cls, path) -> "Scene":
        """Opens NAME.scene.json."""
        return cls._made_by("iso_scene_open", native.text(path))

    def to_dict(self) -> dict:
        """Returns the keys of its file."""
        return json.loads(_text("iso_scene_text", self))

    def __getitem__(self, key):
        return self.to_dict()[key]

    def __setitem__(self, key, value):
        native.call("iso_scene_set", self._pointer, native.text(json.dumps({key: value})))

    def set_tf(self, tf: Tf) -> None:
        """Replaces the transfer function."""
        native.call("iso_scene_set_tf", self._pointer, native.pointer(tf, "Tf"))

    def save(self, path) -> None:
        """Writes NAME.scene.json."""
        native.call("iso_scene_save", self._pointer, native.text(path))

    def __reduce__(self):
        return Scene, (self.to_dict(),)

    def __repr__(self):
        image = self["image"]
        return f"Scene of {image['width']} x {image['height']} pixels"


def _sizes(size):
    if size is None:
        return 0, 0
    sizes = (size, size) if np.ndim(size) == 0 else tuple(size)
    if len(sizes) != 2 or not all(s > 0 for s in sizes):
        raise ValueError(f"size is {size}, must be one number of pixels, or (width, height)")
    return sizes


def _copy(scene):
    """Returns a copy of a Scene, of one in a file, or of a dict."""
    if isinstance(scene, (str, os.PathLike)):
        return Scene.open(scene)
    return Scene(scene if isinstance(scene, dict) else json.loads(_text("iso_scene_text", scene)))


def scene_for(pyramid, scene, tf, view: Optional[str], zoom: float, size) -> Scene:
    """Returns a scene for a pyramid: automatic, or a copy of the given one, with what is given besides."""
    width, height = _sizes(size)
    if scene is not None and (view or zoom):
        raise ValueError("view and zoom are for automatic scenes; change the scene's camera instead")
    if scene is None:
        look = native.LookOptions()
        look.tf = native.text(tf) if not isinstance(tf, Tf) else None
        look.view, look.zoom, look.width, look.height = native.text(view), zoom, width, height
        made = Scene._made_by("iso_scene_automatic", pyramid._pointer, byref(look))
    else:
        made = _copy(scene)
        if width:
            made["image"] = {"width": width, "height": height}
        if tf is not None and not isinstance(tf, Tf):
            tf = pyramid.suggest(tf)
    if isinstance(tf, Tf):
        made.set_tf(tf)
    return made
