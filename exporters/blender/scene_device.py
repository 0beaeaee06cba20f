# SPDX-License-Identifier: GPL-3.0-or-later
"""Selects the device of Cycles: the processor, or a device of Blender's preferences.

Joined with the other scripts of this folder into one (exporters/blender/run.c): build_scene.py is its last part."""
import sys

import bpy

# Candidates for "gpu": the first with a device; of two that drive the same device, the faster one comes first.
GPU_KINDS = ("OPTIX", "CUDA", "HIP", "ONEAPI", "METAL")


def offered_devices(preferences):
    """Returns the names of available devices, by kind."""
    kinds = [kind for kind, *_ in preferences.get_device_types(bpy.context) if kind != 'NONE']
    found = {kind: [one.name for one in preferences.get_devices_for_type(kind) or () if one.type == kind] for kind in kinds}
    return {kind: names for kind, names in found.items() if names}


def refuse_device(asked, offered):
    there = "; ".join(["cpu"] + [f"{kind.lower()} ({', '.join(names)})" for kind, names in offered.items()])
    print(f"isoshade: has no such device: Blender {bpy.app.version_string} has no {asked} device here; available: {there}",
          flush=True)
    sys.exit(8)


def choose_device(cycles, preferences, asked):
    """Enables exactly the devices of the requested kind, and fails if there are none. Otherwise Cycles would silently
    use the processor."""
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
