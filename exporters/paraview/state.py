# SPDX-License-Identifier: MIT
# Written by isoshade, export --to paraview. "pvbatch THIS.py" writes the picture next to this file; in ParaView:
# File > Load State. Accuracy of the picture: doc/guide/other-programs.md of isoshade.
import inspect
import math
import os

import paraview.simple
from paraview.servermanager import vtkProcessModule
from paraview.simple import *

SCENE = {}


def folder():
    """The folder of this file; ParaView does not always set __file__ for a loaded state."""
    path = globals().get("__file__") or inspect.currentframe().f_code.co_filename
    return os.path.dirname(os.path.abspath(path)) if os.path.exists(path) else os.getcwd()


def make_view():
    camera = SCENE["camera"]
    view = CreateView("RenderView")
    view.ViewSize = [SCENE["width"], SCENE["height"]]
    view.CameraPosition = camera["position"]
    view.CameraFocalPoint = [p + f for p, f in zip(camera["position"], camera["forward"])]
    view.CameraViewUp = camera["up"]
    if camera["projection"] == "orthographic":
        view.CameraParallelProjection = 1
        view.CameraParallelScale = camera["half_height"]
    else:
        view.CameraViewAngle = math.degrees(2 * math.atan(camera["half_height"]))
    view.CenterOfRotation = SCENE["center"]
    view.OrientationAxesVisibility = 0
    view.UseColorPaletteForBackground = 0
    view.Background = SCENE["background"]
    return view


def show(view, reader):
    tf = SCENE["tf"]
    colors, opacities = GetColorTransferFunction("value"), GetOpacityTransferFunction("value")
    colors.AutomaticRescaleRangeMode = "Never"
    colors.ColorSpace = "RGB"
    colors.Discretize = 0
    colors.RGBPoints = [number for point in tf["colors"] for number in point]
    opacities.Points = [number for value, opacity in tf["opacities"] for number in (value, opacity, 0.5, 0.0)]
    shown = Show(reader, view, "UniformGridRepresentation")
    shown.SetRepresentationType("Volume")
    shown.ColorArrayName = ["CELLS", "value"]
    shown.LookupTable = colors
    shown.OpacityTransferFunction = shown.ScalarOpacityFunction = opacities
    shown.ScalarOpacityUnitDistance = tf["unit_mm"]
    return shown


def light(view, shown):
    """ParaView's own shading by scalar differences, with the scene's lights; none if no light has an effect."""
    shading = SCENE["shading"]
    shown.Shade = SCENE["shade"]
    if not SCENE["shade"]:
        return
    shown.Ambient, shown.Diffuse = shading["ambient"], shading["diffuse"]
    shown.Specular, shown.SpecularPower = shading["specular"], shading["power"]
    view.UseLight = 0
    lights = []
    for one in SCENE["lights"]:
        made = CreateLight()
        made.Coords, made.Type = "Scene", "Directional"
        made.FocalPoint = SCENE["center"]
        made.Position = [c + d for c, d in zip(SCENE["center"], one["direction"])]
        made.Intensity = one["intensity"]
        lights.append(made)
    view.AdditionalLights = lights


paraview.simple._DisableFirstRenderCameraReset()  # like states saved by ParaView
view = make_view()
shown = show(view, OpenDataFile(os.path.join(folder(), SCENE["name"] + ".vti")))
light(view, shown)
Render(view)
if vtkProcessModule.GetProcessType() == vtkProcessModule.PROCESS_BATCH:  # in pvbatch; the window shows the view
    SaveScreenshot(os.path.join(folder(), SCENE["name"] + ".png"), view, ImageResolution=view.ViewSize)
