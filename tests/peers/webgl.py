# SPDX-License-Identifier: MIT
"""The viewer's ray caster as a renderer (viewer.json): the page of `isoshade view` without its controls, in Chromium
without a window. It takes the page's parts from the source tree.

webgl.py REQUEST.json     writes the pictures that the request asks for (doc/reference/files-request.md)
webgl.py --version        says what would draw them"""
import array
import base64
import json
import os
import sys

from chromium import Chromium
from exr import write_exr

TOP = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..")
SCRIPTS = [f"src/view/{name}.js" for name in ("vectors", "arrays", "camera", "transfer", "adapt", "occupancy", "context",
                                              "textures", "overlay", "caster")] + ["tests/peers/webgl.js"]
SHADERS = ["src/encode/code_decode.h"]
SHADERS += [f"src/render/gl/shaders/{name}" for name in ("es.glsl", "fullscreen.glsl", "held.glsl", "probe.glsl", "raycast.glsl", "roi.glsl", "variants.h")]


def text_of(path):
    with open(os.path.join(TOP, path), encoding="utf-8") as f:
        return f.read()


def nrrd_floats(path):
    """Of a raw little-endian NRRD, as floats, in base64."""
    with open(path, "rb") as f:
        header, data = f.read().split(b"\n\n", 1)
    kind = next(line.split(b":")[1].strip().decode() for line in header.split(b"\n") if line.startswith(b"type:"))
    code = {"float": "f", "uint8": "B", "unsigned char": "B", "int16": "h", "short": "h", "uint16": "H", "unsigned short": "H", "int8": "b",
            "signed char": "b"}[kind]
    if code != "f":
        data = array.array("f", array.array(code, data)).tobytes()
    return base64.b64encode(data).decode()


def inlined(value):
    return json.dumps(value).replace("<", "\\u003c")


def page_of(request, folder):
    parts = ["<!doctype html><meta charset=utf-8><title>isoshade</title>",
             f"<script type=application/json id=shaders>{inlined({os.path.basename(path): text_of(path) for path in SHADERS})}</script>",
             f"<script type=application/json id=request>{inlined(request)}</script>"]
    for key in ("volume", "directions"):
        if request.get(key):
            parts.append(f"<script type=text/plain id={key}>{nrrd_floats(os.path.join(folder, request[key]['file']))}</script>")
    parts += ["<script>'use strict';(() => {", *map(text_of, SCRIPTS), "})();</script>"]
    return "\n".join(parts)


def render(path):
    with open(path, encoding="utf-8") as f:
        request = json.load(f)
    folder = os.path.dirname(os.path.abspath(path))
    page = os.path.join(folder, "page.html")
    with open(page, "w", encoding="utf-8") as f:
        f.write(page_of(request, folder))
    width, height = request["image"]["width"], request["image"]["height"]
    with Chromium(size=(200, 150), seconds=3600, within=os.getcwd()) as browser:  # the caller has its own time limit
        browser.open(page, "window.isoshade && document.readyState === 'complete'")
        browser.evaluate("isoshade.makeRequest().then(draw => { window.draw = draw; })")
        for i, frame in enumerate(request["frames"]):
            pixels = array.array("f", base64.b64decode(browser.evaluate(f"draw({i})")))
            write_exr(os.path.join(folder, frame["file"]), width, height, pixels)


def version():
    with Chromium(size=(200, 150), seconds=60, within=os.getcwd()) as browser:
        product = browser.call("Browser.getVersion")["product"]
        name = browser.evaluate("(() => { const gl = document.createElement('canvas').getContext('webgl2'); if (!gl) return '';"
                                " const e = gl.getExtension('WEBGL_debug_renderer_info');"
                                " return gl.getParameter(e ? e.UNMASKED_RENDERER_WEBGL : gl.RENDERER); })()")
    if not name:
        sys.exit(f"{product} has no WebGL2 on this machine")
    print(f"{product}, WebGL2 on {name}")


if __name__ == "__main__":
    try:
        version() if sys.argv[1:] == ["--version"] else render(sys.argv[1])
    except (FileNotFoundError, RuntimeError, TimeoutError) as problem:
        sys.exit(str(problem))
