#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Every command block (```sh) of README.md and of each page of the guide runs as it stands, in order, in a folder of its
# own. Lines that install or build are left to the reader; Blender opens its file without a window. README.md calls the
# program by its path until it has set PATH. Then the examples of each command's --help, except bench.
# Pages can be named as arguments: doc/guide/povray.md ...
. "$(dirname "$0")/lib.sh"
mkdir bin && ln -s "$ISOSHADE" bin/isoshade
export PATH=$dir/bin:$PATH
python_with numpy # the example renderer's
[ "$python" = python3 ] || ln -s "$python" bin/python3
# A line that ends with 7 names a program or device that this system lacks. It is skipped, and so is one that opens a file
# that such a line would have written.
fail() { # name, exit code, output
    if [ "$2" = 7 ]; then skip "$1" "$(tail -n 1 <<<"$3")"
    elif [[ $1 == *" blender -b "* ]] && ! has_cycles; then skip "$1" "no .blend file was made"
    else not_ok "$1" "$(tail -n 2 <<<"$3")"; bad=1; fi
}
run_lines() { # name; lines on stdin, in the current folder: at least one of them has to be a command
    local name=$1 line output count=0 left=0 bad=0
    while IFS= read -r line; do
        [ -n "$line" ] || continue
        case $line in
            make | make\ * | apt-get\ * | export\ * | cc\ * | ./tutorial) left=$((left + 1)); continue ;;
            blender\ *) line="blender -b --python-exit-code 1 ${line#blender } --python-expr 'import bpy; assert bpy.context.scene.camera'" ;;
        esac
        output=$(bash -c "$line" 2>&1 </dev/null) || fail "$name: $line" $? "$output"
        count=$((count + 1))
    done
    if [ $((count + left)) = 0 ]; then not_ok "$name" "no command lines were found"
    elif [ $bad = 0 ]; then ok "$name: $count lines, $left left to the reader"; fi
}
blocks() { awk '/^```sh$/ {on = 1; next} /^```/ {on = 0} on' "$1"; } # file: the lines of its command blocks
enter() { mkdir -p "$dir/$1" && cd "$dir/$1" && ln -sfn "$top/refscenes" refscenes && ln -sfn "$top/doc" doc && ln -sfn "$top/tests" tests && ln -sfn "$ISOSHADE" isoshade; }
# page: each call of the program before PATH is set has to be ./isoshade
called_too_early() { blocks "$1" | awk '/^export PATH=\$PWD:/ {exit} /^isoshade / {print}'; }

# Planted: a page without commands, and one whose command fails.
notice_lines() { [ -n "$(run_lines "$1" | grep '^not ok')" ]; }
check a_page_without_commands_would_be_seen notice_lines planted </dev/null
check a_command_that_fails_would_be_seen notice_lines planted <<<'isoshade info nothing.nrrd'
check a_missing_program_is_skipped grep -q '^ok .* # SKIP ' <(run_lines planted <<<'sh -c "echo lacking; exit 7"')

printf '```sh\n./isoshade list\nisoshade list\nexport PATH=$PWD:$PATH\nisoshade info\n```\n' >early.md
check a_bare_name_before_the_path_would_be_seen test "$(called_too_early early.md)" = "isoshade list"
check readme_calls_the_program_by_its_path test -z "$(called_too_early "$top/README.md")"
run_page() { enter "pages/${1//\//-}" && run_lines "$1" < <(blocks "$top/$1"); } # page, from the project's folder
if [ $# -gt 0 ]; then
    for page; do run_page "$page"; done
    exit $failed
fi
# check_python.sh runs the page that has Python alone.
for page in README.md $(cd "$top" && ls doc/guide/*.md | grep -v /python.md); do run_page "$page"; done
# Examples with less work: of an option that stands twice the last one counts. All cases of the atlas: test_atlas.
with_less_work() {
    sed -e '/^isoshade validate .* --quick --with gl --size/s/$/ --levels 2/' \
        -e '/^isoshade validate .* --with gl,povray/s/$/ --with gl/' -e '/^isoshade build .* --effort fast$/s/$/ --levels 2/' \
        -e '/^isoshade atlas -o atlas$/s/$/ --case code-poles/' \
        -e '/^isoshade chart /s/$/ --steps 1 --codes fit --filters moments --estimators central --plans none/'
}
commands=$("$ISOSHADE" --help | awk '/^commands:/ {on = 1; next} /^$/ {on = 0} on {print $1}')
check the_help_lists_commands test "$(wc -w <<<"$commands")" -ge 10
for command in $commands; do
    "$ISOSHADE" "$command" --help >"$dir/help.txt" 2>/dev/null || { not_ok "$command --help" "exit code $?"; continue; }
    grep -q '^examples:' "$dir/help.txt" || { not_ok "$command --help" "no examples"; continue; }
    [ "$command" = bench ] && continue # benchmarks are run by hand, on a quiet machine
    enter "help-$command"
    run_lines "$command --help" < <(sed '1,/^examples:/d; s/^  //' "$dir/help.txt" | with_less_work)
done
exit $failed
