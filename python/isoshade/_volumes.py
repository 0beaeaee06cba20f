# SPDX-License-Identifier: MIT
"""Volumes and pyramids."""
import ctypes
import html
import json
import operator
import os
from ctypes import POINTER, byref, c_double, c_size_t, c_ssize_t
from typing import Callable, Optional, Sequence, Tuple, Union

import numpy as np

from . import _native as native
from . import _programs
from ._images import Image
from ._scenes import Scene, Tf, scene_for

Progress = Union[None, bool, Callable[[str, float], None]]

_NAMES = {"float32": "float", "float64": "double"}
_TARGETS = {".blend": "blender", ".vdb": "vdb", ".nvdb": "nanovdb"}


def _view(pointer, dtype, shape, owner):
    """Returns a read-only array over memory of the library, which keeps its owner alive."""
    memory = (ctypes.c_ubyte * (int(np.prod(shape)) * np.dtype(dtype).itemsize)).from_address(
        ctypes.cast(pointer, ctypes.c_void_p).value)
    memory._owner = owner
    array = np.frombuffer(memory, dtype).reshape(shape)
    array.flags.writeable = False
    return array


def _matrix(grid):
    return np.array([list(row) for row in grid.index_to_world])


def _spacing(grid):
    spacing = (c_double * 3)()
    native.lib.iso_grid_spacing_mm(byref(grid), spacing)
    return tuple(spacing)


def _grid(size, spacing, index_to_world):
    """Returns a grid of size (x, y, z): centered at the origin, or by a matrix."""
    grid = native.lib.iso_grid_axis_aligned((c_size_t * 3)(*size), (c_double * 3)(*spacing))
    if index_to_world is not None:
        matrix = np.asarray(index_to_world, float)
        if matrix.shape not in ((3, 4), (4, 4)):
            raise ValueError(f"index_to_world has shape {matrix.shape}, must be (3, 4) or (4, 4)")
        for row in range(3):
            grid.index_to_world[row][:] = matrix[row]
    return grid


def _matrix_of_coordinates(array):
    """Returns the matrix of an xarray.DataArray [z, y, x], whose coordinates are centers of voxels in mm. An axis
    without coordinates, or with a single one, has voxels of 1 mm."""
    matrix = np.zeros((3, 4))
    for row, dim in enumerate(reversed(array.dims)):
        at = np.asarray(array.coords[dim]) if dim in array.coords else np.arange(array.shape[2 - row]) + 0.5
        if at.dtype.kind not in "iuf":
            raise ValueError(f"coordinates along {dim} have the type {at.dtype}, must be lengths in mm; pass spacing")
        steps = np.diff(at.astype(float)) if len(at) > 1 else np.ones(1)
        if not np.allclose(steps, steps[0], rtol=1e-3) or steps[0] == 0:
            raise ValueError(f"coordinates along {dim} are not even, {steps.min():g} to {steps.max():g} apart; "
                             "interpolate them, or pass spacing")
        matrix[row, row], matrix[row, 3] = steps[0], at[0] - steps[0] / 2
    return matrix


def _lengths(spacing):
    """Returns three edges (x, y, z) of a voxel, of one number or three."""
    edges = np.asarray(spacing, float)
    edges = np.repeat(edges, 3) if edges.ndim == 0 else edges
    if edges.shape != (3,) or not (edges > 0).all():
        raise ValueError(f"spacing is {spacing}, must be one or three lengths (x, y, z) above 0")
    return tuple(edges.tolist())


def _samples(array):
    """Returns an array of a type that the library takes, in the machine's byte order. Masked samples become NaN."""
    if np.ma.is_masked(array):
        array = array.astype(np.result_type(array.dtype, np.float16)).filled(np.nan)
    array = np.asarray(array)
    if array.ndim != 3:
        raise ValueError(f"array has {array.ndim} dimensions, must have 3: z, y, x")
    if array.dtype.kind not in "biuf" or array.dtype.itemsize > 8:
        raise TypeError(f"array has the type {array.dtype}, must be bool, or integers or floats of at most 64 bits")
    return array if array.dtype.isnative else array.astype(array.dtype.newbyteorder("="))


def _restore(array, matrix):
    return Volume(array, index_to_world=matrix)


def _take_region(options, roi):
    """Sets the region of interest of a struct of options: a box in voxels of level 0, and the level inside."""
    if roi is not None:
        lo, hi, *rest = roi
        options.region = ctypes.pointer(native.Region(tuple(lo), tuple(hi), *(rest or (0,)), 2))


class Volume(native.Handle):
    """A grid of numbers.

    array: shape (nz, ny, nx), indexed [z, y, x]: any integer, bool or float type, any strides; or an xarray.DataArray,
        whose coordinates give the place. It is copied. NaN and masked samples are no data; others must be finite.
    spacing: voxel edges (x, y, z) in mm, or one for all; the volume is centered at the origin.
    index_to_world: (3, 4) matrix from continuous index (x, y, z, 1), voxel centers at i + 1/2, to mm; replaces spacing.
    """

    _free = "iso_volume_free"

    def __init__(self, array, spacing: Union[None, float, Sequence[float]] = None, *, index_to_world=None):
        if hasattr(array, "dims") and hasattr(array, "coords") and len(array.dims) == 3:
            array = array.transpose("z", "y", "x") if set(array.dims) == set("xyz") else array
            if spacing is None and index_to_world is None:
                index_to_world = _matrix_of_coordinates(array)
        array = _samples(array)
        grid = _grid(array.shape[::-1], _lengths(1 if spacing is None else spacing), index_to_world)
        made = self._made_by("iso_volume_from_array", byref(grid),
                             native.text(_NAMES.get(array.dtype.name, array.dtype.name)), array.ctypes.data,
                             (c_ssize_t * 3)(*array.strides[::-1]))
        super().__init__(made._pointer)
        made._pointer = None

    @property
    def _grid(self):
        return native.lib.iso_volume_grid(self._pointer)

    @property
    def shape(self) -> Tuple[int, int, int]:
        """Voxels along z, y, x."""
        return tuple(self._grid.size)[::-1]

    @property
    def spacing(self) -> Tuple[float, float, float]:
        """Voxel edges along x, y, z in mm."""
        return _spacing(self._grid)

    @property
    def index_to_world(self) -> np.ndarray:
        """Matrix (3, 4) from a continuous index (x, y, z, 1) to mm."""
        return _matrix(self._grid)

    @property
    def array(self) -> np.ndarray:
        """The samples, shape (nz, ny, nx): read-only, without a copy. Voxels without data are -2**100."""
        name = native.lib.iso_volume_type(self._pointer).decode()
        dtype = {v: k for k, v in _NAMES.items()}.get(name, name)
        return _view(native.lib.iso_volume_samples(self._pointer), dtype, self.shape, self)

    def __array__(self, dtype=None, copy=None):
        return np.array(self.array, dtype) if copy or dtype else self.array

    def __reduce__(self):
        return _restore, (np.array(self.array), self.index_to_world)

    def __repr__(self):
        grid = self._grid
        size, spacing = " x ".join(map(str, grid.size)), " x ".join(f"{s:.4g}" for s in _spacing(grid))
        return f"Volume of {size} voxels, {spacing} mm, {native.lib.iso_volume_type(self._pointer).decode()}"

    def to_xarray(self):
        """Returns an xarray.DataArray with coordinates in mm, for volumes along the world's axes. Needs xarray."""
        import xarray
        m, n = self.index_to_world, self._grid.size
        if not np.allclose(m[:, :3], np.diag(np.diag(m[:, :3]))):
            raise ValueError("the volume is turned against the world's axes, so that it has no coordinates per axis")
        coords = {d: m[a, a] * (np.arange(n[a]) + 0.5) + m[a, 3] for a, d in enumerate("xyz")}
        return xarray.DataArray(self.array, dims=("z", "y", "x"), coords={d: coords[d] for d in "zyx"},
                                attrs={"units": "mm"})

    def save(self, path, gzip: bool = False) -> None:
        """Writes an NRRD file, NAME.nrrd."""
        if os.path.splitext(os.fspath(path))[1].lower() != ".nrrd":
            raise ValueError(f"{path}: a volume is saved as .nrrd")
        native.call("iso_volume_save", self._pointer, native.text(path), gzip)

    def build(self, levels: int = 4, *, code: Optional[str] = None, estimator: Optional[str] = None,
              scalar_filter: Optional[str] = None, direction_filter: Optional[str] = None, keep_float: bool = False,
              keep_magnitude: bool = False, threads: int = 0, progress: Progress = None) -> "Pyramid":
        """Builds a pyramid of at most `levels` levels. progress: True for a bar (tqdm), or f(stage, fraction)."""
        o = native.lib.iso_build_defaults()
        o.levels, o.keep_float, o.keep_magnitude, o.threads = levels, keep_float, keep_magnitude, threads
        for name, value in (("code", code), ("estimator", estimator), ("scalar_filter", scalar_filter),
                            ("direction_filter", direction_filter)):
            if value is not None:
                setattr(o, name, native.text(value))
        return Pyramid._made_by("iso_build", self._pointer, byref(o), options=o, progress=progress)

    def render(self, **options) -> Image:
        """Renders the volume; Pyramid.render() has the options."""
        return self.build(1, progress=options.get("progress")).render(**options)

    def _repr_html_(self):
        return self.build()._repr_html_()


class Level:
    """A level of a pyramid. Arrays are read-only and without a copy.

    values: shape (nz, ny, nx). directions: (nz, ny, nx, 3), decoded, of length 0 (undefined) to 1. spacing in mm.
    """

    def __init__(self, pyramid, number):
        view = native.LevelView()
        native.call("iso_pyramid_level", pyramid._pointer, number, byref(view))
        self.index_to_world, self.spacing = _matrix(view.grid), _spacing(view.grid)
        self.shape = tuple(view.grid.size)[::-1]
        self.values = _view(view.values, np.float32, self.shape, pyramid)
        self._pyramid, self._number = pyramid, number

    def __repr__(self):
        return f"Level {self._number} of {' x '.join(map(str, self.shape[::-1]))} voxels"

    @property
    def directions(self) -> np.ndarray:
        """Shading directions in world axes; each call decodes them."""
        directions = np.empty(self.shape + (3,), np.float32)
        native.call("iso_pyramid_directions", self._pyramid._pointer, self._number, directions.ctypes.data)
        return directions


class Pyramid(native.Handle):
    """A volume at several levels, made by Volume.build() or open("NAME.iso")."""

    _free = "iso_pyramid_free"

    def __init__(self, *_):
        raise TypeError("Volume.build() and open() make pyramids")

    def __len__(self):
        return native.lib.iso_pyramid_level_count(self._pointer)

    def __getitem__(self, number: int) -> Level:
        number = operator.index(number)
        if not -len(self) <= number < len(self):
            raise IndexError(f"level {number} of {len(self)} levels")
        return Level(self, number % len(self))

    def __repr__(self):
        size = " x ".join(map(str, self[0].shape[::-1]))
        return f"Pyramid of {len(self)} levels, the finest {size} voxels"

    def __reduce__(self):
        raise TypeError("a pyramid is not pickled; pickle its volume, or save it")

    def save(self, folder) -> None:
        """Writes a folder NAME.iso."""
        native.call("iso_pyramid_save", self._pointer, native.text(folder))

    def suggest(self, name: Optional[str] = None) -> Tf:
        """Suggests a transfer function: by a preset's name, or by the values."""
        return Tf._made_by("iso_tf_suggest", self._pointer, native.text(name))

    def scene(self, tf=None, view: Optional[str] = None, zoom: float = 0, size=None) -> Scene:
        """Makes the scene of a first picture. size: pixels, one number or (width, height)."""
        return scene_for(self, None, tf, view, zoom, size)

    def render(self, *, scene=None, tf=None, view: Optional[str] = None, zoom: float = 0, size=None, level: int = 0,
               adapt: bool = True, extinction_scale: bool = False, roi=None,
               renderer: Optional[str] = None, shading: Optional[str] = None, step: float = 0,
               samples: int = 0, seed: int = 0, threads: int = 0, progress: Progress = None) -> Image:
        """Renders a level: float32, shape (height, width, 4), linear light, color multiplied by alpha.

        scene: a Scene or a file; None: automatic. tf: a Tf, a preset or a file. view: a name, or "AZ,EL" in degrees.
        size: pixels, one number or (width, height). adapt: adapts the transfer function to coarse levels;
        extinction_scale: their voxels' extinction, too. roi: ((x0, y0, z0), (x1, y1, z1)) in voxels of level 0, shown
        finer than the rest, by level 0 or a third element. renderer: "cpu", with roi "gl"; "reference" (exact and slow)
        ... step: along rays, in voxels; 0: the renderer's own.
        """
        made = scene_for(self, scene, tf, view, zoom, size)
        o, image = native.lib.iso_frame_defaults(), native.ImageStruct()
        renderer = renderer or ("cpu" if roi is None else "gl")
        o.renderer, o.level, o.adapt, o.threads = native.text(renderer), level, adapt and level > 0, threads
        o.step_voxels, o.samples, o.seed, o.extinction_scale = step, samples, seed, extinction_scale
        _take_region(o, roi)
        if shading:
            o.shading = native.text(shading)
        native.call_long("iso_render", self._pointer, made._pointer, byref(o), byref(image), options=o,
                         progress=progress)
        return Image._taken(image)

    def export(self, path, *, to: Optional[str] = None, scene=None, tf=None, view: Optional[str] = None, size=None,
               level: int = 0, levels: int = 1, adapt: bool = False, extinction_scale: bool = False, roi=None,
               plan: Optional[dict] = None, half: bool = False, threads: int = 0,
               progress: Progress = None) -> Optional[bytes]:
        """Exports levels for another program. to: the target, by default by the name's ending (.vdb, .blend, .nvdb).

        path None, with to="vdb" or "nanovdb": returns the file. extinction_scale, roi: as for render(). plan: of
        plan(), for the same scene: only its bricks.
        """
        target = to or _TARGETS.get(os.path.splitext(os.fspath(path))[1] if path is not None else "")
        if not target:
            raise ValueError(f"{path}: no target has this ending; name one by to=: {', '.join(native.choices(7))}")
        needs_scene = target not in ("vdb", "nanovdb") or extinction_scale or plan
        if not needs_scene and not scene is tf is view is size is None:
            raise ValueError(f"export to {target} has no scene, tf, view or size")
        made = scene_for(self, scene, tf, view, 0, size) if needs_scene else None
        o = native.lib.iso_export_defaults()
        o.level, o.level_count, o.half_float, o.adapt, o.threads = level, levels, half, adapt, threads
        o.extinction_scale, o.plan = extinction_scale, native.text(json.dumps(plan)) if plan else None
        _take_region(o, roi)
        if path is None:
            data, count = ctypes.c_void_p(), c_size_t()
            native.call_long("iso_export_bytes", self._pointer, made and made._pointer, native.text(target), byref(o),
                             byref(data), byref(count), options=o, progress=progress)
            return native.take_bytes(data, count)
        native.call_long("iso_export", self._pointer, made and made._pointer, native.text(target), native.text(path),
                         byref(o), options=o, progress=progress)

    def plan(self, error: float = 1 / 255, *, memory: float = 0, scene=None, tf=None, view: Optional[str] = None,
             size=None, levels: int = 4, brick: int = 16, views: int = 1, threads: int = 0,
             progress: Progress = None) -> dict:
        """Plans the smallest model whose picture has at most this RMSE, for export(plan=).

        memory: limit in bytes, instead of the error. brick: voxels along a side. views: number, turned around the
        scene's up axis. Returns the content of a plan file (doc/reference/files-chart.md), with "measured_rmse",
        "bytes" and "full_bytes".
        """
        made = scene_for(self, scene, tf, view, 0, size)
        o, result = native.lib.iso_plan_defaults(), native.PlanResult()
        o.error, o.memory_bytes, o.levels, o.brick_voxels, o.views = error, memory, levels, brick, views
        o.threads = threads
        native.call_long("iso_plan", self._pointer, made._pointer, byref(o), byref(result), options=o,
                         progress=progress)
        try:
            return json.loads(result.json)
        finally:
            native.lib.iso_plan_result_destroy(byref(result))

    def figure(self, kind: str = "levels", *, format: str = "pdf", scene=None, tf=None, view: Optional[str] = None,
               size=None, width: float = 178, dpi: float = 300, levels: int = 0,
               renderers: Union[str, Sequence[str]] = ()) -> bytes:
        """Returns a publication figure, `width` mm wide, as "pdf", "svg" or "png". Runs the program isoshade.

        kind: "levels", "renderers", "tf" ... (`isoshade figure`). levels, renderers (["gl", "povray"]): of kinds with them.
        """
        options = ["--width", repr(float(width)), "--dpi", repr(float(dpi))]
        levels = levels or (min(4, len(self)) if kind in ("levels", "grid") else 0)
        options += ["--levels", str(levels)] if levels else []
        options += ["--with", native.words(renderers)] if renderers else []
        return _programs.figure(self, scene_for(self, scene, tf, view, 0, size), kind, format, options)

    def page(self, *, scene=None, tf=None, view: Optional[str] = None, title: Optional[str] = None,
             most_voxels: int = 0, compact: bool = False, progress: Progress = None) -> str:
        """Returns an interactive page as HTML.

        most_voxels: of its finest level; 0: 32 million. compact: starts with the picture alone.
        """
        made = scene_for(self, scene, tf, view, 0, None)
        o, page = native.PageOptions(), ctypes.c_void_p()
        o.title, o.most_voxels, o.compact = native.text(title), most_voxels, compact
        native.call_long("iso_view_page", self._pointer, made._pointer, byref(o), byref(page), options=o,
                         progress=progress)
        return native.take_text(page)

    def _repr_html_(self):
        page = html.escape(self.page(most_voxels=4_000_000, compact=True))
        return f'<iframe srcdoc="{page}" style="width: 100%; height: 36em; border: 0"></iframe>'


def open(path, *, series=None, frame=None, channel=None, spacing: Union[None, float, Sequence[float]] = None,
         unit: Optional[str] = None, stored: bool = False, labels: Optional[bool] = None,
         raw_size: Optional[Sequence[int]] = None, raw_type: Optional[str] = None, raw_skip_bytes: int = 0,
         raw_is_big_endian: bool = False, resample: bool = False, force_spacing: bool = False,
         no_data: Union[str, float, Sequence[float], None] = None) -> Union[Volume, Pyramid]:
    """Opens a volume file or a folder of slices, or a pyramid NAME.iso.

    series, frame, channel: which volume of several. spacing (x, y, z) and unit replace the file's. raw_*: layout of a
    file without a header. resample, force_spacing: interpolate slices at uneven distances, or take them for even.
    no_data: a value, (lo, hi) or "none", instead of the file's.
    """
    given = dict(locals())
    if os.path.isfile(os.path.join(path, "pyramid.json")):
        if any(value not in (None, False, 0) for name, value in given.items() if name != "path"):
            raise ValueError(f"{path}: is a pyramid, which takes no options")
        return Pyramid._made_by("iso_pyramid_open", native.text(path))
    o = native.OpenOptions()
    o.series, o.frame, o.channel, o.unit = map(native.text, (series, frame, channel, unit))
    o.spacing[:] = (0, 0, 0) if spacing is None else _lengths(spacing)
    o.raw_size[:] = raw_size or (0, 0, 0)
    o.raw_type, o.raw_skip_bytes, o.raw_is_big_endian = native.text(raw_type), raw_skip_bytes, raw_is_big_endian
    o.stored, o.labels = stored, 0 if labels is None else 1 if labels else -1
    o.resample, o.force_spacing = resample, force_spacing
    if no_data is not None and not isinstance(no_data, str):
        no_data = ",".join(repr(float(v)) for v in (no_data if isinstance(no_data, Sequence) else [no_data]))
    o.no_data = native.text(no_data)
    return Volume._made_by("iso_volume_open_with", native.text(path), byref(o))
