#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Time steps, channels and numbered files: those of other programs' files, each by itself (frames_in.py).
. "$(dirname "$0")/lib.sh"
python=python3
"$python" -c 'import numpy, vtk' 2>/dev/null || python=/usr/bin/python3 # Debian's, where another one comes first
"$python" "$top/tests/frames_in.py" "$ISOSHADE" || failed=1
exit $failed
