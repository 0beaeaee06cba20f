# SPDX-License-Identifier: MIT
"""Reads scenes that isoshade exports for pbrt-v4, by the format's own description, and draws them.

pbrt_scene.py draw FOLDER OUT.exr         the medium's picture, marched in steps of a sixth of a point
pbrt_scene.py same FOLDER BAKED.vdb [LIT] its grids are those of --to vdb --bake density,Cd; LIT: one more file, of the
                                          gradient, where colors are shaded by the light of check_pbrt.sh
"""
import math
import os
import re
import sys

import numpy

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "peers"))
from exr import write_exr  # noqa: E402

DIRECTIVES = {"Film": 1, "PixelFilter": 1, "Sampler": 1, "Integrator": 1, "MediumInterface": 2, "Transform": 0,
              "Camera": 1, "Include": 1, "WorldBegin": 0, "LightSource": 1, "Material": 1, "Shape": 1, "MakeNamedMedium": 1}


def directives(folder, name):
    """[directive, words, {"type name": values}] of a file and those that it includes. Anything else is refused."""
    text = open(os.path.join(folder, name), encoding="ascii").read()
    tokens = re.findall(r'#[^\n]*|"(?:[^"\\\n]|\\.)*"|\[|\]|[^\s"\[\]]+', text)
    assert re.sub(r"\s", "", text) == re.sub(r"\s", "", "".join(tokens)), "something between the tokens"
    tokens, found, at = [t for t in tokens if t[0] != "#"], [], 0

    def values():
        nonlocal at
        if tokens[at] != "[":
            at += 1
            return [tokens[at - 1]]
        end = tokens.index("]", at)
        inside, at = tokens[at + 1:end], end + 1
        return inside

    while at < len(tokens):
        word = tokens[at]
        assert word in DIRECTIVES, f"{name}: unknown directive {word}"
        at += 1
        words, parameters = [], {}
        while len(words) < DIRECTIVES[word]:
            words.append(tokens[at].strip('"'))
            at += 1
        if word == "Transform":
            parameters[""] = [float(v) for v in values()]
        while at < len(tokens) and tokens[at][0] == '"':
            key = tokens[at].strip('"')
            at += 1
            kind = key.split()[0]
            assert kind in ("float", "integer", "point3", "rgb", "string", "bool"), key
            given = values()
            parameters[key] = (numpy.array(given, float) if kind in ("float", "point3", "rgb") else
                               [int(v) for v in given] if kind == "integer" else [v.strip('"') for v in given])
        found += directives(folder, words[0]) if word == "Include" else [(word, words, parameters)]
    return found


def matrix(values):
    return numpy.array(values).reshape(4, 4).T # column by column


class Scene:
    """sigma and color: [z, y, x]; to_grid: the world's places to coordinates whose cells have their points in the middle."""


def read_pbrt(folder):
    scene, ctm, state = Scene(), numpy.eye(4), {}
    outside, began = "", False
    for word, words, given in directives(folder, "scene.pbrt"):
        if word == "Transform":
            ctm = matrix(given[""])
        elif word == "MediumInterface":
            state["inside"], outside = words[0], words[1]
        elif word == "Camera":
            scene.view, scene.kind, scene.window = ctm, words[0], given["float screenwindow"]
            scene.half = math.tan(math.radians(given["float fov"][0] / 2)) if words[0] == "perspective" else 1
            scene.camera_medium = outside
        elif word == "MakeNamedMedium":
            assert words == ["volume"] and given["string type"] == ["rgbgrid"] and not began and hasattr(scene, "view")
            n = [given[f"integer n{a}"][0] for a in "xyz"]
            grids = {}
            for key in ("sigma_a", "sigma_s", "Le"):
                assert given[f"rgb {key}"].size == 3 * n[0] * n[1] * n[2], key
                grids[key] = given[f"rgb {key}"].reshape(n[2], n[1], n[0], 3)
            assert not grids["sigma_s"].any() and (grids["sigma_a"] >= 0).all() and (grids["Le"] >= 0).all()
            assert (grids["sigma_a"] == grids["sigma_a"][..., :1]).all()
            assert abs(given["float Lescale"][0] * 106.856895 - 1) < 1e-8
            assert list(given["point3 p0"]) == [0, 0, 0] and list(given["point3 p1"]) == n
            scene.sigma, scene.color, scene.to_grid = grids["sigma_a"][..., 0], grids["Le"], numpy.linalg.inv(ctm)
            scene.grid = ctm
        elif word == "WorldBegin":
            ctm, began = numpy.eye(4), True
        elif word == "LightSource":
            assert words == ["infinite"]
            scene.background = given["rgb L"]
        elif word == "Film":
            scene.size = given["integer xresolution"][0], given["integer yresolution"][0]
            assert given["bool savefp16"] == ["false"]
        elif word == "Shape":
            corners = given["point3 P"].reshape(-1, 3)
            assert state["inside"] == "volume" and outside == "" and (ctm == scene.grid).all()
            assert (corners.min(0) == 0).all() and list(corners.max(0)) == list(scene.sigma.shape[::-1])
            middle = corners.mean(0)
            for a, b, c in numpy.array(given["integer indices"]).reshape(-1, 3):
                assert numpy.cross(corners[b] - corners[a], corners[c] - corners[a]) @ (corners[a] - middle) > 0, "a face turned inside"
            scene.has_box = len(given["integer indices"]) == 36
    assert scene.has_box
    scene.background = getattr(scene, "background", numpy.zeros(3))
    return scene


def lookup(grid, at):
    """Trilinear between the middles of cells, 0 beyond the outermost ones."""
    padded = numpy.pad(grid, [(1, 1)] * 3 + [(0, 0)] * (grid.ndim - 3))
    p = numpy.clip(at + 0.5, 0, numpy.array(grid.shape[2::-1]) + 0.9999)
    low = numpy.floor(p).astype(int)
    f, value = p - low, 0
    for i in range(8):
        up = numpy.array([i & 1, i >> 1 & 1, i >> 2])
        weight = numpy.prod(numpy.where(up, f, 1 - f), axis=-1)
        x, y, z = numpy.moveaxis(low + up, -1, 0)
        value = value + (weight if grid.ndim == 3 else weight[..., None]) * padded[z, y, x]
    return value


def march(scene):
    width, height = scene.size
    column, row = numpy.meshgrid(numpy.arange(width) + 0.5, numpy.arange(height) + 0.5)
    x = scene.window[0] + (scene.window[1] - scene.window[0]) * column / width
    y = scene.window[3] - (scene.window[3] - scene.window[2]) * row / height
    zero, one = numpy.zeros_like(x), numpy.ones_like(x)
    near = numpy.stack([x * scene.half, y * scene.half, one, one], -1)
    eye, ahead = (numpy.stack([zero, zero, zero, one], -1), near) if scene.kind == "perspective" else (near - (0, 0, 1, 0), near)
    to_grid = scene.to_grid @ numpy.linalg.inv(scene.view)
    start, toward = (p @ to_grid.T for p in (eye, ahead))
    direction = (toward - start)[..., :3]
    world = ((ahead - eye) @ numpy.linalg.inv(scene.view).T)[..., :3]
    scale = numpy.linalg.norm(world, axis=-1) # mm of one unit of t
    size = numpy.array(scene.sigma.shape[::-1])
    with numpy.errstate(divide="ignore", invalid="ignore"):
        a, b = (0 - start[..., :3]) / direction, (size - start[..., :3]) / direction
    t0 = numpy.maximum(numpy.nanmax(numpy.minimum(a, b), -1), 0)
    t1 = numpy.maximum(numpy.nanmin(numpy.maximum(a, b), -1), t0)
    steps = int(6 * size.max())
    dt = (t1 - t0) / steps
    light, through = numpy.zeros((height, width, 3)), numpy.ones((height, width))
    for k in range(steps):
        at = start[..., :3] + (t0 + (k + 0.5) * dt)[..., None] * direction
        sigma = lookup(scene.sigma, at)
        left = through * numpy.exp(-sigma * dt * scale)
        if scene.color.any():
            light += (through - left)[..., None] * lookup(scene.color, at)
        through = left
    return numpy.dstack([light + through[..., None] * scene.background, 1 - through])


def check_same(folder, baked, lit):
    try:
        import pyopenvdb as vdb
    except ImportError:
        import openvdb as vdb
    scene = read_pbrt(folder)
    density, color = vdb.read(baked, "density"), vdb.read(baked, "Cd")
    gradient = vdb.read(lit, "gradient") if lit else None
    d, c, g = (grid.getConstAccessor() if grid else None for grid in (density, color, gradient))
    eye = numpy.linalg.inv(scene.view)[:3, 3]
    compared = visible = 0
    for z, y, x in numpy.ndindex(scene.sigma.shape):
        world = (scene.grid @ (x + 0.5, y + 0.5, z + 0.5, 1))[:3]
        at = tuple(int(round(v)) for v in density.transform.worldToIndex(tuple(world)))
        sigma = scene.sigma[z, y, x]
        assert numpy.float32(sigma) == numpy.float32(d.getValue(at)), (at, sigma, d.getValue(at))
        compared += 1
        if sigma <= 0:
            continue
        shade = 1.0
        if lit:
            near = tuple(int(round(v)) for v in gradient.transform.worldToIndex(tuple(world)))
            n = numpy.array(g.getValue(near), float)
            n /= math.sqrt(n @ n + (1 / 127) ** 2)
            l = numpy.array([1.0, -2.0, 2.0]) / 3
            v = (eye - world) / numpy.linalg.norm(eye - world)
            h = (l + v) / numpy.linalg.norm(l + v)
            shade = 0.2 + 0.5 * abs(n @ l) + 0.3 * abs(n @ h) ** 12
        wanted = shade * numpy.array(c.getValue(at))
        assert numpy.allclose(scene.color[z, y, x], wanted, rtol=2e-6, atol=1e-9), (at, scene.color[z, y, x], wanted)
        visible += 1
    assert visible > 100, visible
    assert sum(1 for i in density.iterOnValues() if (i["value"] if isinstance(i, dict) else i.value) > 0) == visible, "points left out"
    print(compared, "points,", visible, "visible")


if __name__ == "__main__":
    what, folder, path = sys.argv[1:4]
    if what == "draw":
        picture = march(read_pbrt(folder))
        write_exr(path, picture.shape[1], picture.shape[0], picture.astype("f4").ravel())
    else:
        check_same(folder, path, sys.argv[4] if len(sys.argv) > 4 else None)
