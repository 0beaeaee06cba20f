#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# The first sentence of a report names the renderer, the cause and the size of the difference: of five planted faults.
. "$(dirname "$0")/lib.sh"
python_with numpy
"$python" - "$top/doc/guide/numpy_renderer.py" <<'END'
import json
import sys

with open(sys.argv[1]) as f:
    right = f.read()
COARSER = """def coarser(g):
    half = [(n + 1) // 2 for n in g.shape[:3]]
    total, count = np.zeros((*half, g.shape[3])), np.zeros((*half, 1))
    for x, y, z in np.ndindex(2, 2, 2):
        part = g[x::2, y::2, z::2]
        place = tuple(slice(n) for n in part.shape[:3])
        total[place] += part
        count[place] += 1
    return total / count

"""
DISPLAY = """    c = np.maximum(rgba[:, :3], 0)
    rgba[:, :3] = np.where(c <= 0.0031308, 12.92 * c, 1.055 * c ** (1 / 2.4) - 0.055)
    return rgba.reshape(h, w, 4)
"""
LEAST = "np.linalg.norm(np.array(v['index_to_world'])[:, :3], axis=0).min()"
faults = {
    "shift": [("np.clip(p - 0.5,", "np.clip(p,")],
    "gamma": [("    return rgba.reshape(h, w, 4)\n", DISPLAY)],
    "sign": [("shade(r, field[:, 1:]", "shade(r, field[:, 1:] * (1, 1, -1)")],
    "units": [("-sigma * (b - a)[i]", "-sigma * (b - a)[i] / " + LEAST)],
    "level": [("np.clip(p - 0.5,", "np.clip(p / 2 - 0.5,"), ("if __name__", COARSER + "if __name__"),
              ("render(r, np.concatenate(grids, 3)", "render(r, coarser(np.concatenate(grids, 3))")],
}
rows = []
for name, changes in faults.items():
    wrong = right
    for old, new in changes:
        assert wrong.count(old) == 1, (name, old)
        wrong = wrong.replace(old, new)
    with open(name + ".py", "w") as f:
        f.write(wrong)
    rows.append({"name": name, "command": [sys.executable, name + ".py"], "tier": "samples",
                 "can": ["lights", "orthographic", "clip planes"]})
with open("r.json", "w") as f:
    json.dump({"schema": "isoshade.renderers/1", "renderers": rows}, f)
END
"$ISOSHADE" make marschner-lobb --size 14x12x11 --spacing 0.7x0.7x0.9 -q -o v.nrrd
size='(placement|slab|light) is [0-9.e-]+ [a-z ]+, at most [0-9.e-]+'
# A renderer each, as its author would validate it.
while read -r name cause; do
    "$ISOSHADE" validate v.nrrd --scene "$top/refscenes/marschner-lobb.scene.json" --quick --levels 1 --size 12 \
        --with "$name" --renderers r.json -q -o "$name" >/dev/null 2>&1 </dev/null
    sentence=$(python3 -c 'import json, sys; print(json.load(open(sys.argv[1] + "/report.json"))["sentence"])' "$name")
    explained='\(explains (100|99[.0-9]*) % of the difference\)'
    check "$name" grep -qE "^$name draws as if $cause $explained: $size\. " <<<"$sentence"
done <<'END'
shift the volume stood half a voxel off toward -x, -y, -z
gamma the picture were in sRGB
sign z of the directions had the wrong sign
units lengths along the ray were in units of the smallest spacing
level voxels were those of the next coarser level
END
exit $failed
