#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Each file of source says its licence in its first lines: MIT, or GPL-3.0-or-later where it is a script for Blender, whose
# Python interface (bpy) asks for that. Volumes under tests/formats are what another program wrote, byte
# for byte, and tests/fuzz/seeds are damaged files.
. "$(dirname "$0")/lib.sh"

sources() { find "$1"/src "$1"/exporters "$1"/tests "$1"/refscenes "$1"/Makefile "$1"/.ci -type f ! -name '*.json' ! -path '*/__pycache__/*' ! -path '*/node_modules/*' ! -path '*/tests/formats/phantom.*' ! -path '*/tests/fuzz/seeds/*'; }

wrong() { # folder: a line for each file whose licence is not what it should be
    local file wanted
    sources "$1" | while read -r file; do
        wanted=MIT
        case $file in *.py) grep -qE '^(import|from) bpy' "$file" && wanted=GPL-3.0-or-later ;; esac
        head -n 2 "$file" | grep -qE "SPDX-License-Identifier: $wanted( |\$)" || echo "${file#"$1"/}: wanted $wanted"
    done
}

found=$(wrong "$top")
check each_file_says_its_licence test -z "$found"
[ -z "$found" ] || head -n 20 <<<"$found"
check the_licence_itself_is_there grep -q '^MIT License' "$top/LICENSE"

# Planted faults: a file without a line, and a script for Blender under the other licence.
mkdir -p planted/src planted/exporters planted/tests planted/refscenes planted/.ci && cd planted || exit 1
printf '# SPDX-License-Identifier: MIT\n' >Makefile
printf 'int x;\n' >src/x.c
printf '# SPDX-License-Identifier: MIT\nimport bpy\n' >exporters/scene.py
printf '/* SPDX-License-Identifier: MIT */\n' >tests/good.c
check a_file_without_one_is_named test "$(wrong . | sort)" = "exporters/scene.py: wanted GPL-3.0-or-later
src/x.c: wanted MIT"
exit $failed
