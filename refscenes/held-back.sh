#!/bin/sh
# SPDX-License-Identifier: MIT
# Levels of the volumes of refscenes/held-back, judged twice: as `isoshade validate` does, and by 20 views of 256 x 256.
#   sh refscenes/held-back.sh FOLDER [NAME ...]      these; all where none is named
# A line each, and the reports in FOLDER. The renderers' part is `isoshade validate --suite refscenes/held-back`.
set -eu
cd "$(dirname "$0")/.."
isoshade=${ISOSHADE:-$PWD/isoshade}
out=$1
shift
mkdir -p "$out"
[ $# -gt 0 ] || set -- $(cd refscenes/held-back && ls -- *.scene.json | sed 's/\.scene\.json$//')
judge() { # NAME REPORT OPTIONS: 0 where the levels hold, 1 where they do not
    name=$1 report=$2
    shift 2
    code=0
    "$isoshade" validate "$out/$name.nrrd" --scene "refscenes/held-back/$name.scene.json" --with gl --levels 3 --size 16 "$@" \
        -q -o "$out/$report" >"$out/$report.txt" 2>&1 || code=$?
    [ $code -le 1 ] || { echo "held-back: $name: exit code $code: $(tail -n 1 "$out/$report.txt")" >&2; exit $code; }
    return $code
}
for name; do
    make=$(sed -n 's/.*"suite": {"make": "\([^"]*\)"}.*/\1/p' "refscenes/held-back/$name.scene.json")
    # shellcheck disable=SC2086 # words of a command
    "$isoshade" make $make -q -o "$out/$name.nrrd"
    if judge "$name" "$name-few"; then few=hold; else few=differ; fi
    if judge "$name" "$name-many" --level-views 20 --level-size 256; then many=hold; else many=differ; fi
    echo "$name: by six views of 160 x 160 the levels $few, by 20 of 256 x 256 they $many"
done
