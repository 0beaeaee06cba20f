# SPDX-License-Identifier: MIT
# scaled_suite.py FACTOR FROM TO [SCENE...] - the suite of the folder FROM, or some of its scenes, in TO with all lengths
# multiplied: the spacings of the volumes that are made, and what scenes say in mm. Pictures stay the same.
import json, os, sys


def scaled_make(text, factor):
    words = text.split()
    if "--spacing" not in words:
        words += ["--spacing", "1x1x1"]
    at = words.index("--spacing") + 1
    words[at] = "x".join(repr(float(h) * factor) for h in words[at].split("x"))
    if "--center" in words:
        at = words.index("--center") + 1
        words[at] = ",".join(repr(float(c) * factor) for c in words[at].split(","))
    return " ".join(words)


def scaled(thing, factor, key=""):
    if isinstance(thing, dict):
        return {k: scaled(v, factor, k) for k, v in thing.items()}
    if key == "make":
        return scaled_make(thing, factor)
    if isinstance(thing, list):
        return [scaled(v, factor, key if key in ("position", "look_at", "point_mm") else "") if isinstance(v, (int, float))
                else scaled(v, factor) for v in thing]
    is_length = key.endswith("_mm") or key in ("position", "look_at")
    return thing * factor if is_length and isinstance(thing, (int, float)) else thing


if __name__ == "__main__":
    factor, source, target, wanted = float(sys.argv[1]), sys.argv[2], sys.argv[3], sys.argv[4:]
    os.makedirs(target)
    for name in sorted(os.listdir(source)):
        if name.endswith(".scene.json") and (not wanted or name.removesuffix(".scene.json") in wanted):
            with open(os.path.join(source, name)) as f:
                scene = json.load(f)
            with open(os.path.join(target, name), "w") as f:
                json.dump(scaled(scene, factor), f)
