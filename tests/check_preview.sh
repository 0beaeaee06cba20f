#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# An exported .blend opens with nearly the picture that it renders: EEVEE against Cycles at three levels (preview.py).
. "$(dirname "$0")/lib.sh"
has_cycles || { skip preview "$lack"; exit $failed; }
command -v xvfb-run >/dev/null || { skip preview "xvfb is not installed"; exit $failed; }
"$ISOSHADE" make shells --size 40x44x36 -q -o v.nrrd || exit 1
check it_is_written "$ISOSHADE" export v.nrrd --to blender --scene "$top/refscenes/shells.scene.json" --adapt --levels 3 -q -o v.blend
xvfb-run -a "${ISOSHADE_BLENDER:-blender}" -b -noaudio --python-exit-code 9 v.blend -P "$top/tests/preview.py" -- 64 >log 2>&1 ||
    not_ok blender_came_to_the_end "$(tail -n 3 log)"
grep -aE '^(not )?ok ' log
grep -aq '^not ok ' log && failed=1
exit $failed
