#!/usr/bin/python3
# SPDX-License-Identifier: MIT
"""The ray caster against VTK's GPU mapper: one volume, image size, step, transfer function, camera and light.

    python3 tests/peers/raycast.py [VOLUME.nrrd] [--image 512] [--runs 3] [--processor-time] [--json]

Both draw by the OpenGL that is there, each in a process of its own, in turn; the least time of all runs counts. VTK draws
in a window of Xvfb where there is no display. VTK shades by differences of the scalar at each sample, isoshade by its
pre-computed directions and, for comparison, by differences too. The images are compared as linear light: RMSE below 0.1 and a
correlation above 0.9, no closer because VTK lights what has no gradient in its own way (haze is darker there). --processor-time counts all cores'
time instead of the clock's: for software GL on a machine that has other work. Debian packages: python3-vtk9, xvfb.
Without a volume: thin shells of 256 voxels a side, made by isoshade."""
import argparse
import json
import math
import os
import shutil
import subprocess
import sys
import tempfile
import time

TOP = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..")
ISOSHADE = os.environ.get("ISOSHADE", os.path.join(TOP, "isoshade"))
DIRECTION, UP, FOV, MARGIN = (0.5, 1.0, -0.4), (0, 0, 1), 30.0, 0.8
LIGHT = (-0.5, 0.5, 1.0)  # towards the light: right, up, backwards
# (part of the range, linear color, opacity of one voxel), as bench render has them
POINTS = {"dense": [(0, (0.2, 0.3, 0.9), 0.002), (1, (1, 0.9, 0.7), 0.02)],
          "sparse": [(0, (0, 0, 0), 0), (0.6, (0.9, 0.4, 0.2), 0), (0.7, (1, 0.9, 0.7), 0.3), (1, (1, 0.9, 0.7), 0.3)]}
WANTED = {"dense": 1.5, "sparse": 6.0}


def normalize(v):
    length = math.sqrt(sum(x * x for x in v))
    return tuple(x / length for x in v)


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


# ---- VTK, in its own process ----------------------------------------------------------------------------------

def read_nrrd(path):
    """Attached raw or gzip: voxels [z, y, x] and spacing; all that the comparison needs of the format."""
    import gzip
    import numpy
    with open(path, "rb") as f:
        head, data = f.read().split(b"\n\n", 1)
    fields = dict(line.split(": ", 1) for line in head.decode("latin-1").splitlines()[1:]
                  if ": " in line and not line.startswith("#"))
    names = {"unsigned char": "u1", "uchar": "u1", "uint8": "u1", "uint8_t": "u1", "short": "i2", "int16": "i2", "int16_t": "i2",
             "signed short": "i2", "unsigned short": "u2", "ushort": "u2", "uint16": "u2", "uint16_t": "u2", "float": "f4"}
    order = ">" if fields.get("endian", "little").strip() == "big" else "<"
    if fields["encoding"].strip() in ("gzip", "gz"):
        data = gzip.decompress(data)
    sizes = [int(n) for n in fields["sizes"].split()]
    voxels = numpy.frombuffer(data, order + names[fields["type"].strip()], sizes[0] * sizes[1] * sizes[2]).reshape(sizes[::-1])
    if "spacings" in fields:
        spacing = [float(h) for h in fields["spacings"].split()]
    elif "space directions" in fields:
        rows = [[float(x) for x in row.strip("()").split(",")] for row in fields["space directions"].split()]
        spacing = [math.sqrt(sum(x * x for x in row)) for row in rows]
    else:
        spacing = [1, 1, 1]
    return numpy.ascontiguousarray(voxels.astype(voxels.dtype.newbyteorder("="))), spacing


def vtk_scene(args, tf):
    import vtk
    from vtkmodules.util import numpy_support
    voxels, spacing = read_nrrd(args.volume)
    image = vtk.vtkImageData()
    image.SetDimensions(voxels.shape[::-1])
    image.SetSpacing(spacing)
    image.GetPointData().SetScalars(numpy_support.numpy_to_vtk(voxels.ravel(), deep=True))
    low, high = image.GetScalarRange()
    color, opacity = vtk.vtkColorTransferFunction(), vtk.vtkPiecewiseFunction()
    for part, rgb, alpha in POINTS[tf]:
        color.AddRGBPoint(low + part * (high - low), *rgb)
        opacity.AddPoint(low + part * (high - low), alpha)
    spacing = min(image.GetSpacing())
    look = vtk.vtkVolumeProperty()
    look.SetColor(color)
    look.SetScalarOpacity(opacity)
    look.SetScalarOpacityUnitDistance(spacing)
    look.SetInterpolationTypeToLinear()
    look.SetShade(not args.unshaded)
    look.SetAmbient(0.3)
    look.SetDiffuse(0.7)
    look.SetSpecular(0)
    mapper = vtk.vtkOpenGLGPUVolumeRayCastMapper()
    mapper.SetInputData(image)
    mapper.SetAutoAdjustSampleDistances(False)
    mapper.SetLockSampleDistanceToInputSpacing(False)
    mapper.SetUseJittering(False)
    mapper.SetSampleDistance(spacing)
    mapper.SetMaxMemoryFraction(1.0)
    volume = vtk.vtkVolume()
    volume.SetMapper(mapper)
    volume.SetProperty(look)
    return image, volume


def vtk_camera(image, camera):
    """The fitted camera of isoshade: the sphere round the box of whole voxels."""
    forward = normalize(DIRECTION)
    spacing, size, origin = image.GetSpacing(), image.GetDimensions(), image.GetOrigin()
    center = [o + 0.5 * (n - 1) * h for o, n, h in zip(origin, size, spacing)]
    radius = MARGIN * 0.5 * math.sqrt(sum((n * h) ** 2 for n, h in zip(size, spacing)))
    distance = radius / math.sin(math.radians(FOV / 2))
    camera.SetFocalPoint(center)
    camera.SetPosition([c - distance * f for c, f in zip(center, forward)])
    camera.SetViewUp(UP)
    camera.SetViewAngle(FOV)
    right = normalize(cross(forward, UP))
    up = cross(right, forward)
    return normalize([LIGHT[0] * r + LIGHT[1] * u - LIGHT[2] * f for r, u, f in zip(right, up, forward)]), center


def vtk_main(args):
    import vtk
    image, volume = vtk_scene(args, args.vtk)
    renderer, window = vtk.vtkRenderer(), vtk.vtkRenderWindow()
    window.SetOffScreenRendering(True)
    window.SetMultiSamples(0)
    window.SetSize(args.image, args.image)
    window.AddRenderer(renderer)
    renderer.SetBackground(0, 0, 0)
    renderer.AddVolume(volume)
    towards, center = vtk_camera(image, renderer.GetActiveCamera())
    light = vtk.vtkLight()
    light.SetLightTypeToSceneLight()
    light.SetPositional(False)
    light.SetFocalPoint(center)
    light.SetPosition([c + 1000 * t for c, t in zip(center, towards)])
    renderer.RemoveAllLights()
    renderer.AddLight(light)
    renderer.SetAutomaticLightCreation(False)
    renderer.ResetCameraClippingRange()
    clock = time.process_time if args.processor_time else time.perf_counter
    least = math.inf
    for run in range(args.runs + 1):  # the first one compiles
        start = clock()
        window.Render()
        window.WaitForCompletion()
        if run > 0:
            least = min(least, clock() - start)
    picture = vtk.vtkWindowToImageFilter()
    picture.SetInput(window)
    picture.ReadFrontBufferOff()
    writer = vtk.vtkPNGWriter()
    writer.SetFileName(args.picture)
    writer.SetInputConnection(picture.GetOutputPort())
    writer.Write()
    print(json.dumps({"seconds": least, "version": vtk.vtkVersion().GetVTKVersion(),
                      "gl": window.ReportCapabilities().split("OpenGL renderer string:")[-1].splitlines()[0].strip()}))


# ---- both ------------------------------------------------------------------------------------------------------

def run(command):
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"{' '.join(command)}: exit code {done.returncode}: {done.stderr.strip()[-500:]}")
    return done.stdout


def vtk_run(args, tf, unshaded, picture):
    command = ["/usr/bin/python3", os.path.abspath(__file__), args.volume, "--vtk", tf, "--picture", picture, "--image",
               str(args.image), "--runs", str(args.runs)]
    command += ["--unshaded"] * unshaded + ["--processor-time"] * args.processor_time
    if not os.environ.get("DISPLAY"):
        command = ["xvfb-run", "-a"] + command
    return json.loads(run(command).splitlines()[-1])


def isoshade_run(args):
    """Milliseconds by (tf, gradients), by the loop that isoshade chooses."""
    command = [ISOSHADE, "bench", "render", args.volume, "--image", str(args.image), "--runs", str(args.runs), "--json"]
    out = json.loads(run(command + ["--processor-time"] * args.processor_time))
    return {(c["tf"], c["gradients"]): c["milliseconds"] for c in out["cases"] if c["loop"] == "auto"}


def isoshade_picture(args, tf, folder):
    points = [{"value": p, "r": c[0], "g": c[1], "b": c[2], "opacity": a} for p, c, a in POINTS[tf]]
    scene = {"schema": "isoshade.scene/1", "image": {"width": args.image, "height": args.image},
             "camera": {"projection": "perspective", "fit": True, "direction": DIRECTION, "up": UP, "margin": MARGIN, "fov_y_deg": FOV},
             "lights": [{"direction": LIGHT, "space": "camera", "intensity": 1}],
             "shading": {"ambient": 0.3, "diffuse": 0.7}, "step_voxels": 1,
             "tf": {"schema": "isoshade.tf/1", "range": "fit", "unit_distance_voxels": 1, "color_space": "linear", "table_size": 256, "points": points}}
    path, picture = os.path.join(folder, tf + ".scene.json"), os.path.join(folder, tf + ".png")
    with open(path, "w") as f:
        json.dump(scene, f)
    run([ISOSHADE, "render", args.volume, "--scene", path, "--shading-from", "on-the-fly", "-o", picture])
    return picture


def pixels(path):
    import vtk
    from vtkmodules.util import numpy_support
    reader = vtk.vtkPNGReader()
    reader.SetFileName(path)
    reader.Update()
    values = numpy_support.vtk_to_numpy(reader.GetOutput().GetPointData().GetScalars())
    return values[:, :3].astype("float64") / 255


def agreement(vtk_picture, own_picture):
    import numpy
    theirs, own = pixels(vtk_picture), pixels(own_picture)
    own = numpy.where(own <= 0.04045, own / 12.92, ((own + 0.055) / 1.055) ** 2.4)  # sRGB to linear
    return float(numpy.sqrt(numpy.mean((theirs - own) ** 2))), float(numpy.corrcoef(theirs.ravel(), own.ravel())[0, 1])


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("volume", nargs="?")
    parser.add_argument("--image", type=int, default=512)
    parser.add_argument("--runs", type=int, default=3)
    parser.add_argument("--keep", metavar="FOLDER", help="leave the images there")
    parser.add_argument("--processor-time", action="store_true")
    parser.add_argument("--json", action="store_true")
    parser.add_argument("--vtk", choices=sorted(POINTS), help=argparse.SUPPRESS)
    parser.add_argument("--unshaded", action="store_true", help=argparse.SUPPRESS)
    parser.add_argument("--picture", help=argparse.SUPPRESS)
    args = parser.parse_args()
    if args.vtk:
        return vtk_main(args)
    if subprocess.run(["/usr/bin/python3", "-c", "import vtk, numpy"], capture_output=True).returncode != 0:
        sys.exit("VTK is not there: Debian packages python3-vtk9 and python3-numpy")
    if not os.environ.get("DISPLAY") and not shutil.which("xvfb-run"):
        sys.exit("no display: Debian package xvfb")
    sys.exit(compare(args))


def compare(args):
    results = []
    with tempfile.TemporaryDirectory() as folder:
        if not args.volume:
            args.volume = os.path.join(folder, "shells.nrrd")
            run([ISOSHADE, "make", "shells", "--size", "256", "-o", args.volume])
        args.volume = os.path.abspath(args.volume)
        own = [isoshade_run(args)]
        for tf in ("dense", "sparse"):
            picture = os.path.join(folder, tf + "-vtk.png")
            theirs = vtk_run(args, tf, False, picture)
            rmse, correlation = agreement(picture, isoshade_picture(args, tf, folder))
            results.append({"tf": tf, "vtk_milliseconds": 1e3 * theirs["seconds"], "vtk": theirs["version"], "gl": theirs["gl"],
                            "images_rmse": rmse, "images_correlation": correlation})
        own.append(isoshade_run(args))
        for r in results:
            for g, name in (("codes", "pre_computed"), ("on-the-fly", "on_the_fly")):
                r[name + "_milliseconds"] = min(o[r["tf"], g] for o in own)
                r[name + "_times_faster"] = r["vtk_milliseconds"] / r[name + "_milliseconds"]
        if args.keep:
            os.makedirs(args.keep, exist_ok=True)
            for name in os.listdir(folder):
                if name.endswith(".png"):
                    shutil.copy(os.path.join(folder, name), args.keep)
    good = all(r["pre_computed_times_faster"] >= WANTED[r["tf"]] and r["images_rmse"] < 0.1 and r["images_correlation"] > 0.9 for r in results)
    if args.json:
        print(json.dumps({"volume": args.volume, "image": args.image, "processor_time": args.processor_time, "cases": results}))
        return 0 if good else 1
    print(f"VTK {results[0]['vtk']} on {results[0]['gl']}; {args.image} x {args.image}, step 1 voxel, shaded; "
          f"{'processor' if args.processor_time else 'wall'} milliseconds, least of {args.runs}")
    print(f"{'tf':8} {'VTK':>8} {'directions':>11} {'faster':>7} {'wanted':>7} {'on the fly':>11} {'faster':>7} "
          f"{'RMSE':>8} {'correlation':>12}")
    for r in results:
        print(f"{r['tf']:8} {r['vtk_milliseconds']:8.0f} {r['pre_computed_milliseconds']:11.0f} "
              f"{r['pre_computed_times_faster']:7.2f} {WANTED[r['tf']]:7.1f} {r['on_the_fly_milliseconds']:11.0f} "
              f"{r['on_the_fly_times_faster']:7.2f} {r['images_rmse']:8.4f} {r['images_correlation']:12.4f}")
    return 0 if good else 1


if __name__ == "__main__":
    main()
