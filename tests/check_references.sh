#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# What comments and pages refer to exists: papers by their keys in doc/reference/references.md, files, functions.
. "$(dirname "$0")/lib.sh"

found=$(python3 "$top/tests/references.py" "$top")
if [ -z "$found" ]; then ok every_reference_resolves; else not_ok every_reference_resolves "$(head -n 20 <<<"$found")"; fi

# Planted faults: one of each kind, beside references that are good.
mkdir -p planted/src planted/doc/reference planted/doc/guide && cd planted || exit 1
printf -- '- [good-2001] A work.\n- [idle-1999] Another.\n' >doc/reference/references.md
printf 'See [good-2001](../reference/references.md), x.h and gone.md.\n' >doc/guide/blender.md
cat >src/x.h <<'END'
/* x.h - after [good-2001] and [unknown-2002]; see src/gone.c and x.h. */
int iso_there(void); /* iso_there() is, iso_gone() is not */
/* Smith and Jones 2003 have a key, or should. */
END
python3 "$top/tests/references.py" . >found
planted() { check "$1" grep -qxF -- "$2" found; }
planted an_unknown_key_is_found 'src/x.h:1: key unknown-2002 is not in doc/reference/references.md'
planted a_missing_file_is_found 'src/x.h:1: no file src/gone.c'
planted a_missing_page_is_found 'doc/guide/blender.md:1: no file gone.md'
planted a_missing_function_is_found 'src/x.h:2: no function iso_gone()'
planted a_paper_by_name_is_found 'src/x.h:3: "Smith and Jones 2003" has a key in doc/reference/references.md, or should'
planted a_key_that_nothing_cites_is_found 'doc/reference/references.md: nothing cites idle-1999'
check nothing_else_is_found test "$(grep -c . found)" = 6
exit $failed
