#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# The Python package: python_package.py, against the library and the program of this build.
. "$(dirname "$0")/lib.sh"
python_with numpy
library=$(dirname "$ISOSHADE")/libisoshade.so.0
[ -e "$library" ] || { skip package "$library is not built in this config"; exit 0; }
export ISOSHADE_LIBRARY=$library ISOSHADE_ISOSHADE=$ISOSHADE PYTHONDONTWRITEBYTECODE=1
{
    printf '#include <isoshade.h>\n#include <stdio.h>\nint main(void)\n{\n'
    sed -n 's/^} \(iso_[a-z_]*\);$/\1/p' "$top/src/isoshade.h" | grep -vE '^iso_(status|choice|image_note)$' |
        sed 's/.*/    printf("& %zu\\n", sizeof(&));/'
    printf '    return 0;\n}\n'
} >sizes.c
check sizes_are_printed sh -c 'gcc -I"$1/src" sizes.c -o sizes && ./sizes >sizes.txt' - "$top"
# One line per test: "test_name (class) ... ok"
"$python" "$top/tests/python_package.py" sizes.txt >out 2>err
code=$?
while read -r name result; do
    case $result in
        ok) ok "$name" ;;
        skipped*) skip "$name" "${result#skipped }" ;;
        *) not_ok "$name" "$result: $(grep -vE '^ |^$|^Ran|^FAILED|^-|^=' err | tail -n 2 | tr '\n' ' ')" ;;
    esac
done < <(sed -n 's/^\(test_[a-z_]*\) .* \.\.\. \(.*\)/\1 \2/p' err)
[ $code = 0 ] && grep -q '^Ran [1-9]' err && ok package || not_ok package "$(tail -n 3 err)"
exit $failed
