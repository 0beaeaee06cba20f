#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# An exported .blend as people change it: each change leaves the picture that was validated (changed.py).
. "$(dirname "$0")/lib.sh"
has_cycles || { skip changed "$lack"; exit $failed; }
"$ISOSHADE" make marschner-lobb --size 24x30x20 -q -o v.nrrd || exit 1
mkdir here work
check it_is_written "$ISOSHADE" export v.nrrd --to blender --scene "$top/refscenes/marschner-lobb.scene.json" --levels 2 -q -o here/v.blend
"${ISOSHADE_BLENDER:-blender}" -b -noaudio --python-exit-code 9 here/v.blend -P "$top/tests/changed.py" -- "$dir/work" >log 2>&1 ||
    not_ok blender_came_to_the_end "$(tail -n 3 log)"
grep -aE '^(not )?ok ' log
grep -aq '^not ok ' log && failed=1
exit $failed
