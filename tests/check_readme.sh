#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Every command block of README.md (```sh) runs as it stands, in order, in one folder; only make, which builds what is
# tested here, is left to the reader, and Blender opens its file without a window. Then the examples of each command's
# --help, but for bench.
set -u
top=$(cd "$(dirname "$0")/.." && pwd)
program=${ISOSHADE:-$top/isoshade}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
mkdir "$work/bin" && ln -s "$program" "$work/bin/isoshade"
export PATH=$work/bin:$PATH
bad=0
# A line that needs what this system's Blender lacks, which the program says by name, is skipped.
fail() { # name, output
    local lack
    if lack=$(grep -om1 'Blender [0-9.]* of this system is built without NanoVDB.*' <<<"$2"); then
        echo "ok $1 # SKIP $lack"
    else
        echo "not ok $1: $(tail -n 2 <<<"$2")"
        bad=1
    fi
}
run_lines() { # name; lines on stdin, in the current folder
    local name=$1 line output count=0
    while IFS= read -r line; do
        [ -n "$line" ] || continue
        case $line in
            make\ *) continue ;;
            blender\ *) line="blender -b --python-exit-code 1 ${line#blender } --python-expr 'import bpy; assert bpy.context.scene.camera'" ;;
        esac
        output=$(bash -c "$line" 2>&1 </dev/null) || fail "$name: $line" "$output"
        count=$((count + 1))
    done
    [ $bad = 0 ] && echo "ok $name: $count lines"
}
enter() { mkdir -p "$work/$1" && cd "$work/$1" && ln -sfn "$top/refscenes" refscenes; }

enter readme
run_lines "README.md" < <(awk '/^```sh$/ {on = 1; next} /^```/ {on = 0} on' "$top/README.md")
for command in $("$program" --help | awk '/^commands:/ {on = 1; next} /^$/ {on = 0} on {print $1}'); do
    "$program" "$command" --help >"$work/help.txt" 2>/dev/null || { echo "not ok $command --help: exit code $?"; bad=1; continue; }
    grep -q '^examples:' "$work/help.txt" || { echo "not ok $command --help: no examples"; bad=1; continue; }
    [ "$command" = bench ] && continue # benchmarks are run by hand, on a quiet machine
    enter "help-$command"
    run_lines "$command --help" < <(sed -n '/^examples:/,$p' "$work/help.txt" | sed '1d; s/^  //')
done
[ $bad = 0 ]
