#!/usr/bin/python3
# SPDX-License-Identifier: MIT
"""The first picture of a NIfTI file, side by side with other programs: from the start of the process to the PNG.

    python3 tests/peers/first_picture.py [VOLUME.nii.gz] [--size 512] [--runs 3]

Each draws with the transfer function of `isoshade tf suggest`, in turn; medians, and the largest process's memory. VTK's
mappers are used as its examples do. NiiVue gets its volume unpacked and draws without light, as a renderer's request. Left out by name:
what is not installed. Debian packages: mricron-data, python3-vtk9, xvfb, paraview; nodejs and tests/peers/web/fetch.sh."""
import argparse
import json
import os
import shutil
import statistics
import subprocess
import sys
import tempfile
import time

TOP = os.path.realpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", ".."))
ISOSHADE = os.environ.get("ISOSHADE", os.path.join(TOP, "isoshade"))
BRAIN = "/usr/share/mricron/templates/ch2better.nii.gz"
WEB = os.path.join(TOP, "build", "web")


def draw_vtk(kind, volume, tf, size, png):
    from vtkmodules.vtkCommonDataModel import vtkPiecewiseFunction
    from vtkmodules.vtkIOImage import vtkNIFTIImageReader, vtkPNGWriter
    from vtkmodules.vtkRenderingCore import (vtkColorTransferFunction, vtkRenderer, vtkRenderWindow, vtkVolume,
                                             vtkVolumeProperty, vtkWindowToImageFilter)
    from vtkmodules.vtkRenderingVolume import vtkFixedPointVolumeRayCastMapper
    from vtkmodules.vtkRenderingVolumeOpenGL2 import vtkOpenGLGPUVolumeRayCastMapper
    reader = vtkNIFTIImageReader()
    reader.SetFileName(volume)
    opacity, color = vtkPiecewiseFunction(), vtkColorTransferFunction()
    for point in tf["points"]:
        opacity.AddPoint(point["value"], point["opacity"])
        color.AddRGBPoint(point["value"], point["r"], point["g"], point["b"])
    look = vtkVolumeProperty()
    look.SetScalarOpacity(opacity)
    look.SetColor(color)
    look.SetScalarOpacityUnitDistance(tf["unit_distance_mm"])
    look.SetInterpolationTypeToLinear()
    look.ShadeOn()
    mapper = vtkFixedPointVolumeRayCastMapper() if kind == "cpu" else vtkOpenGLGPUVolumeRayCastMapper()
    mapper.SetInputConnection(reader.GetOutputPort())
    thing, renderer, window = vtkVolume(), vtkRenderer(), vtkRenderWindow()
    thing.SetMapper(mapper)
    thing.SetProperty(look)
    renderer.AddVolume(thing)
    window.SetOffScreenRendering(1)
    window.SetMultiSamples(0)
    window.SetSize(size, size)
    window.AddRenderer(renderer)
    renderer.ResetCamera()
    camera = renderer.GetActiveCamera()  # from the front and as large as isoshade's
    camera.SetFocalPoint(thing.GetCenter())
    x, y, z = thing.GetCenter()
    camera.SetPosition(x, y + camera.GetDistance(), z)
    camera.SetViewUp(0, 0, 1)
    camera.Zoom(1.37)
    renderer.ResetCameraClippingRange()
    window.Render()
    grab, writer = vtkWindowToImageFilter(), vtkPNGWriter()
    grab.SetInput(window)
    writer.SetInputConnection(grab.GetOutputPort())
    writer.SetFileName(png)
    writer.Write()


def keep_request(volume, tf, size, folder):
    """The request that isoshade writes for a renderer of others: a renderer that copies it and fails."""
    kept = os.path.join(folder, "request")
    keeper = os.path.join(folder, "keeper.json")
    with open(keeper, "w") as file:
        json.dump({"schema": "isoshade.renderers/1", "renderers": [
            {"name": "keeper", "title": "keeper", "command": ["sh", "-c", f'cp -r "$(dirname "$0")" "{kept}"; exit 1'],
             "package": "dash", "tier": "8 bits", "can": ["orthographic"], "why": "none",
             "limits": {"rmse": 0.05, "max_abs": 0.05, "sharp_rmse": 0.05, "sharp_max_abs": 0.05}}]}, file)
    subprocess.run([ISOSHADE, "render", volume, "--scene", os.path.join(TOP, "refscenes", "brain-unlit.scene.json"), "--tf", tf, "--size",
                    str(size), "--with", "keeper", "--no-sandbox", "-q", "-o", os.path.join(folder, "none.exr")], capture_output=True,
                   env={**os.environ, "ISOSHADE_RENDERERS": keeper})
    return os.path.join(kept, "request.json")


def peers(volume, tf, size, folder):
    screen = [] if os.environ.get("DISPLAY") else ["xvfb-run", "-a"]
    png = os.path.join(folder, "picture.png")
    yield "isoshade render", [ISOSHADE, "render", volume, "--size", str(size), "-q", "-o", png], None
    has_vtk = subprocess.run(["/usr/bin/python3", "-c", "import vtkmodules"], capture_output=True).returncode == 0
    for kind, title, first in (("cpu", "VTK, its CPU mapper", screen), ("gpu", "VTK, its OpenGL mapper", screen)):
        yield (title, first + ["/usr/bin/python3", os.path.abspath(__file__), volume, "--draw", kind, tf, png, "--size",
                               str(size)], None if has_vtk else "python3-vtk9 is not installed")
    request = keep_request(volume, tf, size, folder) if os.path.exists(os.path.join(WEB, "niivue.html")) else None
    yield ("NiiVue in Chromium", ["node", os.path.join(TOP, "tests/peers/web/render.mjs"), "niivue", request],
           None if request else "tests/peers/web/fetch.sh has not been run")


def measure(command):
    begin = time.monotonic()
    child = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, start_new_session=True)
    words = child.stderr.read()
    _, status, usage = os.wait4(child.pid, 0)
    if status:
        sys.exit(f"{' '.join(command)}: {words.decode()[-500:]}")
    return time.monotonic() - begin, usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("volume", nargs="?", default=BRAIN)
    parser.add_argument("--size", type=int, default=512)
    parser.add_argument("--runs", type=int, default=3)
    parser.add_argument("--draw", nargs=3, metavar=("KIND", "TF", "PNG"), help="draw by VTK (used by itself)")
    options = parser.parse_args()
    if options.draw:
        kind, tf, png = options.draw
        with open(tf) as file:
            draw_vtk(kind, options.volume, json.load(file), options.size, png)
        return
    folder = tempfile.mkdtemp()
    tf = os.path.join(folder, "tf.json")
    subprocess.run([ISOSHADE, "tf", "suggest", options.volume, "-q", "-o", tf], check=True, stdout=subprocess.DEVNULL)
    rows = list(peers(options.volume, tf, options.size, folder))
    found = {name: [] for name, _, lack in rows if not lack}
    for _ in range(options.runs):
        for name, command, lack in rows:
            if not lack:
                found[name].append(measure(command))
    first = statistics.median(run[0] for run in found[rows[0][0]])
    print("| program | time | ratio | processor time | memory |\n|---|---|---|---|---|")
    for name, _, lack in rows:
        if lack:
            print(f"| {name} | {lack} | | | |")
            continue
        seconds, cpu, memory = (statistics.median(run[i] for run in found[name]) for i in range(3))
        # Chromium's processes do not end as children of the one that is measured.
        own = "| | |" if "Chromium" in name else f"| {cpu:.2f} s | {memory:.0f} MB |"
        print(f"| {name} | {seconds:.2f} s | {seconds / first:.1f} {own}")
    shutil.rmtree(folder)


main()
