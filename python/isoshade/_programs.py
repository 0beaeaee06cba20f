# SPDX-License-Identifier: MIT
"""Figures, which the program `isoshade` makes."""
import os
import pathlib
import shutil
import subprocess
import tempfile

from . import _native as native


def _program():
    """Finds the program: next to the library, in the bin next to its folder, on PATH."""
    library = pathlib.Path(native.lib._name)
    places = [library.parent / place for place in ("isoshade", "../bin/isoshade")] if library.is_absolute() else []
    for place in places:
        if place.is_file():
            return str(place)
    found = shutil.which(os.environ.get("ISOSHADE_ISOSHADE") or "isoshade")
    if not found:
        raise native.Error(native.Status.MISSING, "isoshade: not found on PATH; install the Debian package isoshade")
    return found


def _run(command, pyramid, scene, options, folder):
    """Runs a command for a pyramid and a scene, which are written into a folder. Its -o is "made" there."""
    pyramid.save(folder / "pyramid.iso")
    scene.save(folder / "scene.scene.json")
    words = [_program(), command, "pyramid.iso", "--scene", "scene.scene.json", "-q", "-o", "made"]
    done = subprocess.run(words + options, cwd=folder, stdin=subprocess.DEVNULL, capture_output=True, text=True)
    if done.returncode != 0:
        lines = done.stderr.strip().splitlines() or ["no message"]
        known = done.returncode in native.Status.__members__.values()
        raise native.Error(done.returncode if known else native.Status.PROGRAM,
                           lines[-1].split(f"isoshade {command}: ", 1)[-1])


def figure(pyramid, scene, kind, form, options):
    """Returns the file of a figure."""
    if form not in ("pdf", "svg", "png"):
        raise ValueError(f"format is {form!r}, must be pdf, svg or png")
    with tempfile.TemporaryDirectory() as name:
        _run("figure", pyramid, scene, ["--kind", kind, "--formats", form if form != "pdf" else "svg"] + options,
             pathlib.Path(name))
        return pathlib.Path(name, "made", f"figure.{form}").read_bytes()
