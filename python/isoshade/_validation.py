# SPDX-License-Identifier: MIT
"""Validation of renderers."""
import ctypes
import html
import json
import pathlib
from ctypes import byref
from typing import Callable, Dict, Optional, Sequence, Union

import numpy as np

from . import _native as native
from ._scenes import _copy, _sizes
from ._volumes import Progress, Volume, _matrix


class Request:
    """A picture to draw. The renderer returns an array (height, width, 3 or 4): linear light over the background.

    values: (nz, ny, nx). directions: (nz, ny, nx, 3), or None if no light is visible. grid: both, (nz, ny, nx, 1 or 4).
    step_mm: samples are in the middle of [k step, (k + 1) step] from the eye. json: camera, lights, shading, tf ... as
    in doc/reference/files-request.md.
    """

    def __init__(self, r):
        shape = tuple(r.grid.size)[::-1]
        self.width, self.height, self.step_mm, self.level = r.width, r.height, r.step_mm, r.level
        self.scene, self.json = r.scene.decode(), json.loads(r.json)
        self.index_to_world = _matrix(r.grid)
        self.values = np.ctypeslib.as_array(r.values, shape).copy()
        self.directions = np.ctypeslib.as_array(r.directions, shape + (3,)).copy() if r.directions else None

    @property
    def grid(self) -> np.ndarray:
        """Values and directions in one array of doubles."""
        parts = [self.values[..., None]] + ([] if self.directions is None else [self.directions])
        return np.concatenate(parts, 3).astype(float)


class Report:
    """Result of validate(). agrees: True if no comparison and no calibration failed. summary: one line.

    json: report.json as a dict. html: the page.
    """

    def __init__(self, result):
        self.agrees, self.summary = result.agrees, result.summary.decode()
        self.json, self.html = json.loads(result.json), result.html.decode()

    def save(self, path) -> None:
        """Writes the page."""
        pathlib.Path(path).write_text(self.html)

    def __repr__(self):
        return f"Report: {self.summary}"

    def _repr_html_(self):
        return f'<iframe srcdoc="{html.escape(self.html)}" style="width: 100%; height: 36em; border: 0"></iframe>'


def _render_callback(function, watch):
    """Returns a C function that draws a request by a Python function; its exceptions end the validation."""
    def render(_user, request, rgba):
        try:
            r = Request(request.contents)
            image = np.asarray(function(r), np.float32)
            if image.shape not in ((r.height, r.width, 3), (r.height, r.width, 4)):
                raise ValueError(f"the renderer returned shape {image.shape}, must be {(r.height, r.width, 4)}")
            out = np.ctypeslib.as_array(rgba, (r.height, r.width, 4))
            out[..., 3] = 1
            out[..., :image.shape[2]] = image
            return True
        except BaseException as failure:
            watch.fail(failure)
            return False
    return native.RENDER(render)


def validate(volume: Volume, renderers: Optional[Dict[str, Callable[[Request], np.ndarray]]] = None, *,
             with_: Union[str, Sequence[str]] = (), scene=None, folder=None, levels: int = 1, size=None, quick: bool = True,
             progress: Progress = None) -> Report:
    """Validates renderers: calibrations with known pictures, then comparisons with the exact reference.

    renderers: functions by name, which draw a Request. with_: isoshade's renderers, such as ["gl", "povray"].
    folder: for the whole report; None: only the page is kept. Runs the program isoshade.
    """
    watch = native._Watch(progress)
    o, result = native.lib.iso_validate_defaults(), native.ValidationResult()
    own = [native.OwnRenderer(native.text(name), _render_callback(f, watch), None)
           for name, f in (renderers or {}).items()]
    o.renderers = (native.OwnRenderer * len(own))(*own)
    o.renderer_count, o.with_, o.folder = len(own), native.text(native.words(with_) or None), native.text(folder)
    made = None if scene is None else _copy(scene)
    o.scene = made and made._pointer
    o.levels, o.quick, (o.width, o.height) = levels, quick, _sizes(size)
    native.call_long("iso_validate", native.pointer(volume, "Volume"), byref(o), byref(result), options=o, watch=watch)
    try:
        return Report(result)
    finally:
        native.lib.iso_validation_result_destroy(byref(result))
