#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Each file of source says its license in its first lines: MIT, or GPL-3.0-or-later where it is a script for Blender, whose
# Python interface (bpy) asks for that. Volumes under tests/formats are what another program wrote, byte
# for byte, and tests/fuzz/seeds are damaged files.
. "$(dirname "$0")/lib.sh"

sources() { find "$1"/src "$1"/exporters "$1"/tests "$1"/refscenes "$1"/Makefile "$1"/.ci -type f ! -name '*.json' ! -path '*/exporters/blender/COPYING' ! -path '*/__pycache__/*' ! -path '*/node_modules/*' ! -path '*/tests/formats/phantom.*' ! -path '*/tests/fuzz/seeds/*'; }

wrong() { # folder: a line for each file whose license is not what it should be
    sources "$1" | tr '\n' '\0' | xargs -0 grep -HnE 'SPDX-License-Identifier: |^(import|from) bpy' /dev/null |
        awk -F: -v folder="$1/" '
            $3 ~ /^(import|from) bpy/ && $1 ~ /\.py$/ { wanted[$1] = "GPL-3.0-or-later"; next }
            $2 <= 2 && match($0, /SPDX-License-Identifier: [^ ]+/) { has[$1] = substr($0, RSTART + 25, RLENGTH - 25) }
            END {
                while ((getline file < list) > 0) {
                    wish = file in wanted ? wanted[file] : "MIT"
                    if (has[file] != wish) print substr(file, length(folder) + 1) ": wanted " wish
                }
            }' list=<(sources "$1")
}

found=$(wrong "$top")
check each_file_says_its_license test -z "$found"
[ -z "$found" ] || head -n 20 <<<"$found"
check the_license_itself_is_there grep -q '^MIT License' "$top/LICENSE"
check and_the_text_of_the_gpl_beside_its_scripts grep -q 'GNU GENERAL PUBLIC LICENSE' "$top/exporters/blender/COPYING"

# What catalogs and citations say is of this version.
version=$("$ISOSHADE" --version | cut -d' ' -f2)
has_version() { grep -qx "version: $version" "$1/CITATION.cff" && grep -q "\"version\": \"$version\"" "$1/codemeta.json"; }
check citation_and_codemeta_have_the_version has_version "$top"
check codemeta_is_json python3 -m json.tool "$top/codemeta.json"
mkdir older && sed 's/^version: .*/version: 0.0.1/' "$top/CITATION.cff" >older/CITATION.cff && cp "$top/codemeta.json" older
notice an_older_version has_version older
component=$top/debian/org.isoshade.isoshade.metainfo.xml
if command -v appstreamcli >/dev/null; then
    check software_catalogs_take_the_description appstreamcli validate --no-net "$component"
    sed 's/<summary>.*//' "$component" >lame.metainfo.xml
    notice one_without_a_summary appstreamcli validate --no-net lame.metainfo.xml
else
    skip software_catalogs_take_the_description "appstreamcli is not installed (Debian's appstream)"
fi

# Planted faults: a file without a line, and a script for Blender under the other license.
mkdir -p planted/src planted/exporters planted/tests planted/refscenes planted/.ci && cd planted || exit 1
printf '# SPDX-License-Identifier: MIT\n' >Makefile
printf 'int x;\n' >src/x.c
printf '# SPDX-License-Identifier: MIT\nimport bpy\n' >exporters/scene.py
printf '/* SPDX-License-Identifier: MIT */\n' >tests/good.c
check a_file_without_one_is_named test "$(wrong . | sort)" = "exporters/scene.py: wanted GPL-3.0-or-later
src/x.c: wanted MIT"
exit $failed
