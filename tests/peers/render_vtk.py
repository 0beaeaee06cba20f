#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""VTK as a renderer of isoshade: python3 render_vtk.py [--as-is | --gpu] REQUEST.json (vtk.json, doc/guide/renderers.md).

Needs Debian's python3-vtk9 and python3-numpy, and no display: vtkFixedPointVolumeRayCastMapper runs on the CPU, and its
picture is taken from where the mapper keeps it, 15 bits a channel, before a window would make 8 of them.

What VTK does by its own rules, and what is done about it here; --as-is does nothing about it:
  its box goes from the first voxel's center to the last one's   the volume is padded by edge values, and clipping planes
                                                                 cut it at the outer faces of the voxels
  a ray loses a thousandth of itself at each end                 both lie in the padding
  opacities between two points are linear in opacity             both tables are given at the mapper's own 32768 entries
  all steps count whole, those that the box cuts too             a picture is the mean of many, whose samples lie a part of
                                                                 a step farther from the camera each
  a ray ends where 255/32767 of the light come through           it is drawn in pieces that let more through
  a step's direction is rounded to 2^-15 of a voxel, which       such a pixel is the mean of other steps, which are rounded
  ends rays early that are nearly parallel to an axis' planes    down
  every product is rounded up to 15 bits                         steps are as long as the transfer function allows
  places are multiplied by 32767 and divided by 32768, which    the volume is made that much smaller
  moves voxel 90 by 0.003 of a voxel
  the first step is left out where the camera is inside          what is near is drawn in short steps
  its shading takes scalar differences, lit from one side        switched off: no lights
--gpu is vtkOpenGLGPUVolumeRayCastMapper: values of cells, whose box is that of whole voxels, one picture of 8 bits; it
needs a display."""
import argparse
import collections
import ctypes
import json
import math
import os
import sys

try:
    import numpy as np
    from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
    from vtkmodules.vtkCommonCore import vtkVersion
    from vtkmodules.vtkCommonDataModel import vtkImageData, vtkPiecewiseFunction, vtkPlane
    from vtkmodules.vtkCommonMath import vtkMatrix4x4
    from vtkmodules.vtkRenderingCore import (vtkColorTransferFunction, vtkRenderer, vtkRenderWindow, vtkVolume,
                                             vtkVolumeProperty)
    from vtkmodules.vtkRenderingVolume import vtkFixedPointVolumeRayCastMapper
    import vtkmodules.vtkRenderingVolumeOpenGL2  # noqa: F401  the mapper makes one of its objects
except ImportError as missing:  # another python3 is first in PATH than the one that Debian's packages are for
    if os.path.realpath(sys.executable) == os.path.realpath("/usr/bin/python3") or not os.path.exists("/usr/bin/python3"):
        sys.exit(f"{missing.name or missing}: Debian packages python3-vtk9 and python3-numpy")
    os.execv("/usr/bin/python3", ["/usr/bin/python3"] + sys.argv)

from exr import write_exr  # noqa: E402  beside this file

ENTRIES = 32768   # of the mapper's tables
MOST = 32767      # the integer that stands for 1
THICKEST = 4.5    # optical depth of a piece of a ray: exp(-4.85) is where the mapper ends it
MOST_PIECES = 32
STEPS = [2 ** (k / 3 - 0.5) for k in range(4)]
THIN = 0.1        # optical depth of a step: shorter ones add up more of what is rounded, longer ones miss more
FINE = 0.006      # and of the part of one by which samples lie farther from picture to picture, 8 to 32 of them
MOST_LOST = 0.2    # steps of a piece that rounding may cut off
TYPES = {"float": "f4", "uint8": "u1", "uchar": "u1", "unsigned char": "u1", "int16": "i2", "short": "i2",
         "uint16": "u2", "ushort": "u2", "unsigned short": "u2"}


# ---- files ----

def read_nrrd(path):
    """An attached raw NRRD, little endian: samples [z, y, x] or [z, y, x, component]."""
    with open(path, "rb") as f:
        head, data = f.read().split(b"\n\n", 1)
    fields = dict(line.split(": ", 1) for line in head.decode("latin-1").splitlines() if ": " in line and line[0] != "#")
    sizes = [int(n) for n in fields["sizes"].split()]
    return np.frombuffer(data, "<" + TYPES[fields["type"].strip()], math.prod(sizes)).reshape(sizes[::-1])


# ---- the model ----

def lookup(tf, values):
    """Linear color and extinction of values: [..., 3] and [...]."""
    entries = np.column_stack([np.asarray(tf["color"], float), np.asarray(tf["extinction_per_mm"], float)])
    last = len(entries) - 1
    at = np.clip((np.asarray(values, float) - tf["lo"]) / (tf["hi"] - tf["lo"]) * last, 0, last) if last else np.zeros(np.shape(values))
    low = np.minimum(at.astype(int), max(last - 1, 0))
    part = (at - low)[..., None]
    found = entries[low] * (1 - part) + entries[np.minimum(low + 1, last)] * part
    return found[..., :3], found[..., 3]


def affine(request):
    m = np.eye(4)
    m[:3] = request["volume"]["index_to_world"]
    axes = m[:3, :3] / np.linalg.norm(m[:3, :3], axis=0)
    if abs(axes.T @ axes - np.eye(3)).max() > 1e-6:
        sys.exit("a sheared grid: VTK counts its steps along a ray without the shear")
    return m


# ---- the mapper ----

class Picture:
    """A mapper on a grid, whose samples are points of the fixed-point mapper, cells of another."""

    def __init__(self, request, grid, to_world, position, other=None):
        self.request = request
        image = vtkImageData()
        size = grid.shape[2::-1]
        # What is no rotation goes into the spacing, by which VTK counts its steps; the rest into the volume's matrix.
        spacing = np.sqrt((to_world[:3, :3] ** 2).sum(0))
        image.SetDimensions([n + 1 if other else n for n in size])
        image.SetSpacing(spacing)
        self.kept = numpy_to_vtk(grid.reshape(-1, grid.shape[3]), deep=False), grid  # borrowed by VTK
        (image.GetCellData() if other else image.GetPointData()).SetScalars(self.kept[0])
        matrix = vtkMatrix4x4()
        turned = to_world @ np.diag([*(1 / spacing), 1])
        for r in range(4):
            for c in range(4):
                matrix.SetElement(r, c, turned[r, c])
        self.mapper = other or vtkFixedPointVolumeRayCastMapper()
        self.mapper.SetInputData(image)
        self.mapper.AutoAdjustSampleDistancesOff()
        self.mapper.SetImageSampleDistance(1)
        if not other:
            self.mapper.IntermixIntersectingGeometryOff()
            self.mapper.SetNumberOfThreads(max(request.get("threads", 0), 0) or os.cpu_count())
        self.property = vtkVolumeProperty()
        self.property.ShadeOff()
        self.property.SetInterpolationType(0 if request["volume"]["interpolation"] == "nearest" else 1)
        self.volume = vtkVolume()
        self.volume.SetMapper(self.mapper)
        self.volume.SetProperty(self.property)
        self.volume.SetUserMatrix(matrix)
        self.renderer, self.window = vtkRenderer(), vtkRenderWindow()
        self.window.SetOffScreenRendering(1)  # the fixed-point mapper never opens it: it has a size
        self.window.SetSize(request["image"]["width"], request["image"]["height"])
        self.window.AddRenderer(self.renderer)
        self.renderer.AddVolume(self.volume)
        camera, c = self.renderer.GetActiveCamera(), request["camera"]
        camera.SetPosition(position)
        camera.SetFocalPoint(position + np.asarray(c["forward"]))
        camera.SetViewUp(c["up"])
        if c["projection"] == "orthographic":
            camera.ParallelProjectionOn()
            camera.SetParallelScale(c["half_height"])
        else:
            camera.SetViewAngle(math.degrees(2 * math.atan(c["half_height"])))

    def set_tables(self, color, opacity, unit_mm, of=(0, MOST)):
        """color [32768, 3] and opacity [32768] over these values."""
        rgb, alpha = vtkColorTransferFunction(), vtkPiecewiseFunction()
        rgb.BuildFunctionFromTable(*of, ENTRIES, np.ascontiguousarray(color, float).ravel())
        alpha.BuildFunctionFromTable(*of, ENTRIES, np.ascontiguousarray(opacity, float))
        self.property.SetColor(rgb)
        self.property.SetScalarOpacity(alpha)
        self.property.SetScalarOpacityUnitDistance(unit_mm)

    def draw(self, near, far, step, planes):
        """Premultiplied colors and alpha, [row, column, 4], of the samples near + k step, k = 1, 2 ..."""
        self.mapper.SetSampleDistance(step)
        self.mapper.RemoveAllClippingPlanes()
        for point, normal in planes:
            plane = vtkPlane()
            plane.SetOrigin(point)
            plane.SetNormal(normal)
            self.mapper.AddClippingPlane(plane)
        self.renderer.GetActiveCamera().SetClippingRange(near, far)
        m, nothing = self.mapper, [0.0] * 3
        m.PerImageInitialization(self.renderer, self.volume, 0, nothing, nothing, [0] * 6)
        m.PerVolumeInitialization(self.renderer, self.volume)
        m.PerSubVolumeInitialization(self.renderer, self.volume, 0)
        m.RenderSubVolume()
        width, height = self.request["image"]["width"], self.request["image"]["height"]
        out = np.zeros((height, width, 4))
        kept = m.GetRayCastImage()
        (used, rows), (stride, _), (left, bottom) = kept.GetImageInUseSize(), kept.GetImageMemorySize(), kept.GetImageOrigin()
        pointer = kept.GetImage()
        if used > 0 and rows > 0 and pointer:
            address = int(pointer.strip("_").split("_")[0], 16)
            words = np.ctypeslib.as_array(ctypes.cast(address, ctypes.POINTER(ctypes.c_uint16)), (rows, stride, 4))
            out[bottom:bottom + rows, left:left + used] = words[:, :used] / MOST
        return out[::-1]


def faces_of_box(to_world, box, clip_planes):
    """(point, normal) of what cuts the rays: the outer faces of the box, and the request's planes."""
    planes = []
    gradients = np.linalg.inv(to_world[:3, :3])  # rows: how an index grows in the world
    for a in range(3):
        for end in range(2):
            point = to_world @ [*np.eye(3)[a] * box[end][a], 1]
            normal = gradients[a] / np.linalg.norm(gradients[a]) * (1 - 2 * end)
            planes.append((point[:3], normal))
    for clip in clip_planes or []:
        normal = np.asarray(clip["normal"], float)
        planes.append((normal * clip["offset_mm"], normal))
    return planes


Stretch = collections.namedtuple("Stretch", "begin end near step")  # depths; samples lie at near + k step, k = 1, 2 ...


class Way:
    """The way of the rays through the box: where they are cut, and where their samples lie."""

    def __init__(self, request, to_world, step, phases, as_is):
        self.request = request
        box, camera = request["volume"]["box_index"], request["camera"]
        self.forward = np.asarray(camera["forward"], float)
        self.position = np.asarray(camera["position"], float)
        self.planes = faces_of_box(to_world, box, request.get("clip_planes"))[6 if as_is else 0:]
        corners = [(to_world @ [*(box[corner >> a & 1][a] for a in range(3)), 1])[:3] for corner in range(8)]
        found = [np.dot(corner - self.position, self.forward) for corner in corners]
        self.nearest, self.farthest = max(min(found), 0), max(found)
        self.starts_inside = min(found) < 0
        self.step, self.phases = step, phases
        self.cuts_off = 0
        if camera["projection"] == "orthographic" and self.starts_inside:  # its rays may begin behind the camera
            self.cuts_off = self.farthest - min(found)
            self.position = self.position - self.cuts_off * self.forward
            self.nearest, self.farthest = self.nearest + self.cuts_off, self.farthest + self.cuts_off

    def lattices(self, step):
        """[[Stretch, ...], ...]: for each picture of a step its stretches of depth, nearest first. Samples lie an equal part of
        a step farther from picture to picture."""
        lists = []
        for phase in range(self.phases):
            part = (phase + 0.5) / self.phases
            begin, stretches = self.nearest, []
            if begin < 2.01 * step:  # no near plane lies behind the camera
                short = step / 4
                first, begin = begin, begin + 12 * short
                stretches.append(Stretch(first, begin + short, first + short * part, short))
            if begin < self.farthest:
                stretches.append(Stretch(begin, self.farthest, begin - step * (1 + part), step))
            lists.append(stretches)
        return lists

    def whole(self, step, to_voxels, longest):
        """Whether the mapper draws a pixel's rays to their ends, [row, column]. It rounds a step to 2^-15 of a voxel along each
        axis and counts steps by each; where a ray is nearly parallel to a plane of voxels, one that is rounded up ends it
        early, by a half at worst."""
        c, image = self.request["camera"], self.request["image"]
        aspect = image["width"] / image["height"]
        x = ((np.arange(image["width"]) + 0.5) / image["width"] * 2 - 1) * c["half_height"] * aspect
        y = (1 - (np.arange(image["height"]) + 0.5) / image["height"] * 2) * c["half_height"]
        right, up = np.asarray(c["right"], float), np.asarray(c["up"], float)
        ray = np.broadcast_to(self.forward, (len(y), len(x), 3))
        if c["projection"] == "perspective":
            ray = ray + x[None, :, None] * right + y[:, None, None] * up
            ray = ray / np.linalg.norm(ray, axis=-1, keepdims=True)
        units = abs(ray @ to_voxels[:3, :3].T) * step * MOST
        rounded = np.floor(units + 0.5)
        lost = np.where(units > 0.49, 1 - units / np.maximum(rounded, 1), 0) * longest / step
        return (lost < MOST_LOST).all(-1)

    def planes_between(self, begin, end):
        planes = list(self.planes)
        if begin > self.nearest or self.cuts_off:
            planes.append((self.position + begin * self.forward, self.forward))
        if end < self.farthest:
            planes.append((self.position + end * self.forward, -self.forward))
        return planes


def draw_step(draw, way, shape, thickest, step):
    """The mean of pictures whose samples are a part of a step apart, and their pieces, {step: length}. Each picture is made of pieces
    in depth, thin enough to let so much of the light through that the mapper draws them to their end."""
    mean, pieces = np.zeros(shape), {}
    for stretches in way.lattices(step):
        total = np.zeros(shape)
        for s in stretches:
            count = int(min(max(math.ceil((s.end - s.begin) / thickest), 1), MOST_PIECES))
            cuts = np.linspace(s.begin, s.end, count + 1)
            pieces[s.step] = cuts[1] - cuts[0]
            for first, last in zip(cuts[:-1], cuts[1:]):
                piece = draw(s.near, s.end + 1e-3 * s.step, s.step, way.planes_between(first, last))
                total += (1 - total[..., 3:]) * piece
        mean += total / way.phases
    return mean, pieces


def compose(draw, way, shape, thickest, to_voxels, steps):
    """The mean of several steps, for each pixel of those in which its ray is whole, of all where it never is."""
    if way.farthest <= 0:
        return np.zeros(shape)
    mean, plain, weight = np.zeros(shape), np.zeros(shape), np.zeros(shape[:2] + (1,))
    for factor in steps:
        found, pieces = draw_step(draw, way, shape, thickest, factor * way.step)
        whole = np.all([way.whole(step, to_voxels, length) for step, length in pieces.items()], axis=0)[..., None]
        mean += found * whole
        plain += found / len(steps)
        weight += whole
    return np.where(weight > 0, mean / np.maximum(weight, 1), plain)


# ---- grids ----

def padded(samples, pad):
    return np.pad(samples, [(p, p) for p in pad[::-1]] + [(0, 0)], mode="edge")


def to_integers(values, low, high):
    return np.rint((values - low) * (MOST / (high - low) if high > low else 0)).astype(np.uint16)


class Painter:
    """What is drawn of a request: the mapper's grid and tables."""

    def __init__(self, request, folder, as_is):
        volume, tf = request["volume"], request["tf"]
        scalar = read_nrrd(os.path.join(folder, volume["file"])).astype("f4")[..., None]
        pad = [0 if as_is else 2 + n // 400 for n in scalar.shape[2::-1]]
        scalar = padded(scalar, pad)
        place = np.eye(4)
        place[:3, 3] = [0.5 - p for p in pad]
        place = affine(request) @ place
        low, high = float(scalar.min()), float(scalar.max())
        color, extinction = lookup(tf, low + (high - low) * np.arange(ENTRIES) / (ENTRIES - 1))
        self.request, self.as_is = request, as_is
        self.most = max(extinction.max(), 1e-30)
        self.unit = 2 / self.most  # mm: opacities up to 0.86
        self.opacity = -np.expm1(-extinction * self.unit)
        color = color * request["shading"]["ambient"]
        self.peak = max(float(color[extinction > 0].max(initial=0)), 1e-30)
        self.grid = to_integers(scalar, low, high)
        self.table = np.minimum(color / self.peak, 1)
        self.to_world = place if as_is else place @ np.diag([MOST / ENTRIES] * 3 + [1])
        if not as_is or low == high:  # corners of the padding, which no sample reaches: the mapper's tables are for this range
            self.grid[0, 0, 0], self.grid[-1, -1, -1] = 0, MOST

    def draw(self, step, phases):
        request = self.request
        way = Way(request, affine(request), step, phases, self.as_is)
        shape = (request["image"]["height"], request["image"]["width"], 4)
        picture = Picture(request, self.grid, self.to_world, way.position)
        picture.set_tables(self.table, self.opacity, self.unit)
        out = compose(picture.draw, way, shape, math.inf if self.as_is else THICKEST / self.most,
                      np.linalg.inv(self.to_world), [1] if self.as_is else STEPS)
        if self.as_is:
            out = np.rint(out * 255) / 255
        out[..., :3] *= self.peak
        out[..., :3] += (1 - out[..., 3:]) * np.asarray(request["background"], float)
        return out


def render(request, folder, frame, as_is=False):
    painter = Painter(request, folder, as_is)
    voxel = np.linalg.norm(affine(request)[:3, :3], axis=0).min()
    step = frame["step_mm"] if as_is else min(max(THIN / painter.most, frame["step_mm"] / 4), max(voxel, frame["step_mm"]))
    phases = 1 if as_is else int(min(max(math.ceil(painter.most * step * STEPS[-1] / FINE), 8), 32))
    return painter.draw(step, phases)


# ---- the GPU's mapper ----

def render_gpu(request, folder, frame):
    from vtkmodules.vtkRenderingCore import vtkWindowToImageFilter
    from vtkmodules.vtkRenderingVolume import vtkGPUVolumeRayCastMapper
    volume, tf = request["volume"], request["tf"]
    if volume["interpolation"] == "nearest":
        sys.exit("labels are not for --gpu")
    scalar = read_nrrd(os.path.join(folder, volume["file"])).astype("f4")
    picture = Picture(request, scalar[..., None], affine(request), np.asarray(request["camera"]["position"], float),
                      vtkGPUVolumeRayCastMapper())
    mapper, most = picture.mapper, max(max(tf["extinction_per_mm"]), 1e-30)
    mapper.SetUseJittering(False)
    mapper.SetLockSampleDistanceToInputSpacing(False)
    mapper.SetSampleDistance(frame["step_mm"] / 8)
    faces = faces_of_box(affine(request), volume["box_index"], request["clip_planes"])
    whole = [True, False] * 3  # the box's own faces, but for those of a coarse level's last voxels, which overhang it
    for a in range(3):
        whole[2 * a + 1] = volume["box_index"][1][a] >= volume["size"][a] - 1e-9
    for point, normal in [face for i, face in enumerate(faces) if i >= 6 or not whole[i]]:
        plane = vtkPlane()
        plane.SetOrigin(point)
        plane.SetNormal(normal)
        mapper.AddClippingPlane(plane)
    low, high = tf["lo"], tf["hi"]
    color, extinction = lookup(tf, low + (high - low) * np.arange(ENTRIES) / (ENTRIES - 1))
    color = color * request["shading"]["ambient"]
    peak = max(float(color.max()), 1)
    picture.set_tables(color / peak, -np.expm1(-extinction * 2 / most), 2 / most, (low, high))
    window, renderer = picture.window, picture.renderer
    window.SetMultiSamples(0)
    window.SetAlphaBitPlanes(1)
    renderer.SetBackground(0, 0, 0)
    renderer.SetBackgroundAlpha(0)
    renderer.ResetCameraClippingRange()
    window.Render()
    grab = vtkWindowToImageFilter()
    grab.SetInput(window)
    grab.SetInputBufferTypeToRGBA()
    grab.ReadFrontBufferOff()
    grab.Update()
    image = grab.GetOutput()
    size = image.GetDimensions()
    out = vtk_to_numpy(image.GetPointData().GetScalars()).reshape(size[1], size[0], 4)[::-1] / 255.0
    out[..., :3] *= peak
    out[..., :3] += (1 - out[..., 3:]) * np.asarray(request["background"], float)
    return out


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--version", action="version", version=f"VTK {vtkVersion().GetVTKVersion()}")
    parser.add_argument("--as-is", action="store_true", help="VTK's own box, one picture, 8 bits")
    parser.add_argument("--gpu", action="store_true", help="the mapper of OpenGL")
    parser.add_argument("request")
    if "--gpu" in sys.argv and not os.environ.get("DISPLAY"):
        sys.exit("VTK's OpenGL mapper needs a display: set DISPLAY, or run isoshade by xvfb-run")
    options = parser.parse_args()
    with open(options.request, encoding="utf-8") as f:
        request = json.load(f)
    if request["directions"]:
        sys.exit("a scene with lights: VTK shades by scalar differences, from one side")
    folder = os.path.dirname(os.path.abspath(options.request))
    for frame in request["frames"]:
        picture = render_gpu(request, folder, frame) if options.gpu else render(request, folder, frame, options.as_is)
        picture[..., :3] = np.minimum(picture[..., :3], 1)
        write_exr(os.path.join(folder, frame["file"]), *picture.shape[1::-1], picture.astype("f4").ravel())


if __name__ == "__main__":
    main()
