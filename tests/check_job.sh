#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# What the main job draws and starts: no more than its decisions need, and it is counted.
. "$(dirname "$0")/lib.sh"
"$ISOSHADE" make shells --size 24x22x20 -q -o v.nrrd || exit 1
scene=$top/refscenes/shells.scene.json
job() { "$ISOSHADE" validate v.nrrd --scene "$scene" --with gl --quick --level-views 2 --level-size 16 -q "$@"; }

# ---- few pixels of a faint level: a single halving leaves .63 of the error by chance, one more tells that from a fault ----
check a_faint_level_is_no_false_alarm job --size 32 --levels 2 -o faint

# ---- limits have at most the pixels that are asked for, the same samples all of them ----
check a_job_with_small_limits job --size 40x30 --limit-size 20 --levels 1 -o small
cat >small.py <<'PY'
import json
r = json.load(open("small/report.json"))
limit = [row for row in r["agreement"] if row["comparison"] == "limit"]
assert [row["statistics"]["pixels"] for row in limit] == [[20, 15]], limit
size = lambda name: [r["images"][name]["width"], r["images"][name]["height"]]
assert all(size(row[k]) == [20, 15] for row in limit for k in ("image_a", "image_b"))
assert all(size(row["image_b"]) == [40, 30] for row in r["agreement"] if row["comparison"] == "lock-step" and not row["variant"])
assert all("--size 20x15" in row["command"] for row in limit)
work = r["work"]
assert work["program_starts"] == 0 and work["processor_seconds"] > 0
assert work["renderers"]["gl"]["pictures"] > 10 and work["renderers"]["gl"]["pixel_steps"] > work["renderers"]["gl"]["pixels"]
assert sum(r["processor_seconds"].values()) <= 1.01 * work["processor_seconds"] + 0.1
PY
check sizes_and_work_are_in_the_report python3 small.py

# ---- one start of POV-Ray draws both passes of both steps of a limit ----
if command -v povray >/dev/null; then
    printf '#!/bin/sh\necho started >>"%s/starts"\nexec %s "$@"\n' "$dir" "$(command -v povray)" >counted && chmod +x counted
    check a_limit_by_povray env ISOSHADE_POVRAY="$dir/counted" "$ISOSHADE" render v.nrrd --scene "$scene" --with povray --size 8 --limit --step 1 -q -o limit.exr
    check is_one_start_and_one_for_its_version test "$(wc -l <starts)" -le 2
fi
exit $failed
