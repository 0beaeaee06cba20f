#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Every command block of README.md (```sh) runs as it stands, in order, in one folder; only make, which builds what is
# tested here, is left to the reader, and Blender opens its file without a window. Then the examples of each command's
# --help, but for bench.
. "$(dirname "$0")/lib.sh"
mkdir bin && ln -s "$ISOSHADE" bin/isoshade
export PATH=$dir/bin:$PATH
# A line that needs what this system's Blender lacks, which the program says by name, is skipped, and so is one that opens
# what such a line would have written.
fail() { # name, output
    local said
    if said=$(grep -om1 'Blender [0-9.]* of this system is built without NanoVDB.*' <<<"$2"); then ok "$1 # SKIP $said"
    elif [[ $1 == *" blender -b "* ]] && ! has_cycles; then skip "$1" "no .blend file was made"
    else not_ok "$1" "$(tail -n 2 <<<"$2")"; bad=1; fi
}
run_lines() { # name; lines on stdin, in the current folder: at least one of them has to be a command
    local name=$1 line output count=0 bad=0
    while IFS= read -r line; do
        [ -n "$line" ] || continue
        case $line in
            make\ *) continue ;;
            blender\ *) line="blender -b --python-exit-code 1 ${line#blender } --python-expr 'import bpy; assert bpy.context.scene.camera'" ;;
        esac
        output=$(bash -c "$line" 2>&1 </dev/null) || fail "$name: $line" "$output"
        count=$((count + 1))
    done
    if [ $count = 0 ]; then not_ok "$name" "no command lines were found"
    elif [ $bad = 0 ]; then ok "$name: $count lines"; fi
}
blocks() { awk '/^```sh$/ {on = 1; next} /^```/ {on = 0} on' "$1"; } # file: the lines of its command blocks
enter() { mkdir -p "$dir/$1" && cd "$dir/$1" && ln -sfn "$top/refscenes" refscenes; }

# Planted: a page without commands, and one whose command fails, are told.
notice_lines() { [ -n "$(run_lines "$1" | grep '^not ok')" ]; }
check a_page_without_commands_would_be_seen notice_lines planted </dev/null
check a_command_that_fails_would_be_seen notice_lines planted <<<'isoshade info nothing.nrrd'

enter readme
run_lines "README.md" < <(blocks "$top/README.md")
commands=$("$ISOSHADE" --help | awk '/^commands:/ {on = 1; next} /^$/ {on = 0} on {print $1}')
check the_help_lists_commands test "$(wc -w <<<"$commands")" -ge 10
for command in $commands; do
    "$ISOSHADE" "$command" --help >"$dir/help.txt" 2>/dev/null || { not_ok "$command --help" "exit code $?"; continue; }
    grep -q '^examples:' "$dir/help.txt" || { not_ok "$command --help" "no examples"; continue; }
    [ "$command" = bench ] && continue # benchmarks are run by hand, on a quiet machine
    enter "help-$command"
    run_lines "$command --help" < <(sed -n '/^examples:/,$p' "$dir/help.txt" | sed '1d; s/^  //')
done
exit $failed
