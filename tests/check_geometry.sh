#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Signed or not, rotated or not, of equal spacing or not, right- and left-handed: the ray caster and POV-Ray agree with the
# reference on each, and the pictures differ from each other, so that each property was shown.
. "$(dirname "$0")/lib.sh"
mkdir matrix
fit_points() { # the points of the scene as fractions of the range
    python3 - "$1" <<'END'
import json, sys
path = sys.argv[1]
s = json.load(open(path))
for point, value in zip(s["tf"]["points"], (0, 0.38, 0.5, 0.62, 1)):
    point["value"] = value
s["tf"]["range"] = "fit"
json.dump(s, open(path, "w"))
END
}
for sign in signed positive; do
    for turn in straight oblique mirrored; do
        for spacing in even uneven; do
            make=$([ $sign = signed ] && echo "--type int16 --range -1000,300" || echo "--type float --range 1e-6,3e-6")
            [ $turn = oblique ] && make="$make --rotate 1,2,3,40"
            [ $turn = mirrored ] && make="$make --rotate 0,1,0,1,0,0,0,0,1"
            [ $spacing = uneven ] && make="$make --spacing 1x0.7x4"
            name=$sign-$turn-$spacing
            sed "s/\"make\": \"[^\"]*\"/\"make\": \"noise --size 17x23x13 --seed 5 $make\"/" \
                "$top/refscenes/suite/negative-noise.scene.json" >"matrix/$name.scene.json"
            fit_points "matrix/$name.scene.json"
        done
    done
done
check all_twelve_agree "$ISOSHADE" validate --suite matrix --with gl,povray --quick --size 16 -q -o report
cat >rows.py <<'END'
import json, sys
rows = json.load(open("report/report.json"))["agreement"]
assert len({r["scene"] for r in rows}) == 12, {r["scene"] for r in rows}
for renderer in ("gl", "povray"):
    for comparison in ("lock-step", "limit"):
        own = [r for r in rows if r["renderer"] == renderer and r["comparison"] == comparison]
        assert len(own) == 12 and all(r["verdict"] == "agree" for r in own), (renderer, comparison, len(own))
END
check in_each_comparison_of_each_renderer python3 rows.py
image() { ls report/images/*"$1"*gl-lockstep.exr | grep -v reference | head -n 1; }
for name in straight-even oblique-even mirrored-even straight-uneven oblique-uneven; do
    check "there_is_a_picture_of_$name" "$ISOSHADE" compare "$(image "signed-$name")" "$(image "signed-$name")"
done
for pair in oblique-even:straight-even mirrored-even:straight-even straight-uneven:straight-even oblique-uneven:oblique-even; do
    notice "${pair%%:*}_is_another_picture_than_${pair##*:}" \
        "$ISOSHADE" compare "$(image "signed-${pair%%:*}")" "$(image "signed-${pair##*:}")" --max-rmse 1e-3
done
# The center of the box, and grain, as made.
"$ISOSHADE" make constant --size 4 --spacing 0.5 --center 52000,-31000,8000.5 --grain 0.1 --type float -q -o far.nrrd
expect a_far_volume_is_described 0 "$ISOSHADE" info far.nrrd
check it_is_around_its_center grep -q 'corner *51999, -31001, 7999.5 mm' out
check its_grain_is_there grep -Eq 'range *0\.[1-4][0-9]* to 0\.[6-9]' out
refuse a_center_without_z 2 'must be X,Y,Z in mm' "$ISOSHADE" make constant --size 4 --center 1,2 -q -o no.nrrd
refuse grain_above_the_range 2 'must be 0 to 1' "$ISOSHADE" make constant --size 4 --grain 1.5 -q -o no.nrrd
exit $failed
