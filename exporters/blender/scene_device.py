# SPDX-License-Identifier: GPL-3.0-or-later
"""What Cycles renders on: the processor, which is what figures are of, or a device of Blender's preferences.

Joined with the other scripts of this folder into one (exporters/blender/run.c): build_scene.py is its last part.
"""
import sys

import bpy

# What is taken for "gpu", the first that has a device: the faster of two that drive the same one comes first.
GPU_KINDS = ("OPTIX", "CUDA", "HIP", "ONEAPI", "METAL")


def offered_devices(preferences):
    """Names of devices by kind, of what this Blender was built with and finds."""
    kinds = [kind for kind, *_ in preferences.get_device_types(bpy.context) if kind != 'NONE']
    found = {kind: [one.name for one in preferences.get_devices_for_type(kind) or () if one.type == kind] for kind in kinds}
    return {kind: names for kind, names in found.items() if names}


def refuse_device(asked, offered):
    there = "; ".join(["cpu"] + [f"{kind.lower()} ({', '.join(names)})" for kind, names in offered.items()])
    print(f"isoshade: has no such device: Blender {bpy.app.version_string} has no {asked} device here; what it has: {there}",
          flush=True)
    sys.exit(8)


def choose_device(cycles, preferences, asked):
    """Cycles takes the processor, without a word, where its scene asks for a device and none is switched on. So exactly the
    devices of the kind that is asked for are switched on, and where there are none it is said."""
    if asked == "cpu":
        cycles.device = 'CPU'
        return "CPU"
    offered = offered_devices(preferences)
    wanted = GPU_KINDS if asked == "gpu" else (asked.upper(),)
    kind = next((kind for kind in wanted if kind in offered), None)
    if not kind:
        refuse_device(asked, offered)
    preferences.compute_device_type = kind
    for one in preferences.devices:
        one.use = one.type == kind
    cycles.device = 'GPU'
    return f"{kind} {', '.join(offered[kind])}"


def set_device(cycles, about):
    name = choose_device(cycles, bpy.context.preferences.addons["cycles"].preferences, about.get("device", "cpu"))
    print("isoshade: device", name, flush=True)
