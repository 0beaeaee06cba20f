#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Every scene of refscenes/suite by the ray caster, and those that need no first hit or many entries by the other
# programs, at 16 x 16 pixels: each scene has rows of each renderer that was asked, and all agree. check_suite.sh has
# what else suites do.
. "$(dirname "$0")/lib.sh"
suite=$top/refscenes/suite
validate() { "$ISOSHADE" validate --quick -q --size 16 "$@"; }

cat >rows.py <<'END'
# With a report, a folder and renderers as arguments: each scene of the folder has compared rows of each renderer, and each row agrees.
import json, os, sys
report, folder, renderers = sys.argv[1], sys.argv[2], sys.argv[3:]
rows = json.load(open(report + "/report.json"))["agreement"]
scenes = sorted(name.removesuffix(".scene.json") for name in os.listdir(folder))
assert scenes
for scene in scenes:
    for renderer in renderers:
        own = [r for r in rows if r["scene"] == scene and r["b"].split(",")[0] == renderer]
        assert own, f"{scene}: no row of {renderer}"
        for row in own:
            assert row["verdict"] in ("agree", "not compared"), f"{scene}: {row['b']}: {row['verdict']}"
        assert any(r["verdict"] == "agree" for r in own) or scene in ("empty",), f"{scene}: {renderer} is compared in no row"
END

check every_scene_agrees_in_gl validate --with gl --suite "$suite" -o gl
check and_has_rows_of_it python3 rows.py gl "$suite" gl

# These have a tier other than first hits, which Cycles does not draw.
mkdir eight
for name in ramp-rotated inside-constant opaque-constant negative-ramp one-voxel-thick border left-handed highlights; do
    cp "$suite/$name.scene.json" eight
done
programs=povray,cycles
has_cycles || { programs=povray; skip the_eight_agree_in_cycles "$lack"; }
check the_eight_agree_in_the_programs validate --with $programs --suite eight -o programs
check and_have_rows_of_each python3 rows.py programs eight ${programs//,/ }

# Planted: a report that lacks a scene's rows, and one with a row that differs.
plant() { # NAME, python that changes rows
    mkdir "$1" && python3 -c 'import json, sys
report = json.load(open("gl/report.json")); rows = report["agreement"]
exec(sys.argv[2]); json.dump(report, open(sys.argv[1] + "/report.json", "w"))' "$@"
}
plant lacks 'rows[:] = [r for r in rows if r["scene"] != "step"]'
notice a_scene_without_rows_is_noticed python3 rows.py lacks "$suite" gl
plant differs 'next(r for r in rows if r["b"] == "gl")["verdict"] = "differ"'
notice a_row_that_differs_is_noticed python3 rows.py differs "$suite" gl
exit $failed
