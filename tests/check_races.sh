#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Two and three runs write one output at the same time, by two settings A and B. A run that returns 0 has left a whole
# output, which may be another run's by then; no output is mixed or lost. A run that loses ends with 3 and one line.
#
#   ROUNDS=100 tests/check_races.sh [NAME ...]     so many rounds of these commands; all without
#
# A round: two runs and no output before, three runs over an output, and one that is killed while another waits. With
# ROUNDS a line of sums follows for each command.
. "$(dirname "$0")/lib.sh"
rounds=${ROUNDS:-1}
shells=$top/refscenes/shells.scene.json
"$ISOSHADE" make shells --size 12x10x11 -q -o s.nrrd && "$ISOSHADE" build s.nrrd -o s.iso --levels 2 -q || exit 1
tiny=(--scene "$shells" --size 8)
charted=(chart ../s.nrrd --scene "$shells" --with cpu --levels 1 --codes fit --filters moments --estimators central --steps 1 --budget 0 --want 1)
validated=(validate ../s.nrrd --scene "$shells" --quick --with cpu --levels 1 --level-views 2 --level-size 16)

# command NAME 0|1: by setting A or B, from a folder next to the inputs
command() {
    local b=$2 tf=ct-bone
    [ "$b" = 0 ] || tf=simulation
    case $1 in
    build) set -- build ../s.nrrd --levels $((2 + b)) -o o ;;
    build-resume) set -- build ../s.nrrd --levels $((2 + b)) --resume -o o ;;
    chart) set -- "${charted[@]}" --size $((8 + b)) -o o ;;
    chart-resume) set -- "${charted[@]}" --size 8 --resume -o o ;; # other settings are refused
    validate) set -- "${validated[@]}" --size $((8 + b)) -o o --junit o/junit.xml ;;
    validate-resume) set -- "${validated[@]}" --size $((8 + b)) --resume -o o ;;
    validate-suite) set -- validate --suite ../suite --with cpu --quick --size $((8 + b)) -o o ;;
    to-povray | to-paraview | to-pbrt) set -- export ../s.iso --to "${1#to-}" --scene "$shells" --level "$b" -o o ;;
    scenes-write) set -- scenes ../s.nrrd "${tiny[@]}" --levels $((1 + b)) --write o ;;
    atlas) set -- atlas --case code-poles -o o ;;
    figure) set -- figure ../s.iso --kind tf --level "$b" -o o ;;
    report) # ends with 1, as the reports differ
        "$ISOSHADE" report diff ../r0 "../r$b" -o o -q --threads 1
        code=$?
        exit $((code == 1 ? 0 : code))
        ;;
    make) set -- make shells --size $((12 + b)) -o o.nrrd ;;
    render) set -- render ../s.iso "${tiny[@]}" --with cpu --level "$b" -o o.exr ;;
    to-vdb) set -- export ../s.iso --to vdb --level "$b" -o o.vdb ;;
    to-nanovdb) set -- export ../s.iso --to nanovdb --level "$b" -o o.nvdb ;;
    view) set -- view ../s.iso --scene "$shells" --level "$b" -o o.html ;;
    plan) set -- plan ../s.nrrd "${tiny[@]}" --error 0.0$((1 + b)) -o o.json ;;
    palette) set -- palette ../s.nrrd --entries $((16 + b)) -o o.csv ;;
    tf) set -- tf suggest ../s.nrrd --tf $tf -o o.tf.json ;;
    histogram) set -- tf adapt ../s.iso --tf $tf --level 1 -o o.tf.json ;;
    esac
    exec "$ISOSHADE" "$@" -q --threads 1
}
usual="build chart validate to-povray make"
all="$usual build-resume chart-resume to-pbrt scenes-write render to-vdb tf validate-resume validate-suite to-paraview atlas figure report to-nanovdb view plan palette histogram"
# Their outputs have dates and times, so that two runs of one setting differ.
dated=" chart chart-resume validate validate-resume validate-suite atlas figure report to-vdb "

# is_listed FOLDER: all that is in it stands in its list of files, and nothing is missing
is_listed() {
    sed -n 's/^f \([0-9]*\) [^ ]* /\1 /p' "$1/.isoshade-files" | sort -u >"$dir/listed" || return
    find "$1" -type f ! -path "$1/.isoshade-files" -printf '%s %P\n' | sort | diff "$dir/listed" - && [ -s "$dir/listed" ]
}
# is_same OUTPUT REFERENCE
is_same() { diff -r -q --exclude=.isoshade-files "$1" "$2" >/dev/null; }
# has_size FILE: the size is A's or B's; for a file that holds a time
has_size() { [[ " $(stat -c %s "../$of.0/$1" "../$of.1/$1" | tr '\n' ' ')" == *" $(stat -c %s "$1") "* ]]; }
whole() { # the output of the command that is raced is A's or B's, and nothing else is left
    local output left
    output=$(ls -d o o.* 2>/dev/null)
    [ "$(wc -w <<<"$output")" = 1 ] || { echo "outputs:" $output; return 1; }
    left=$(ls -A | grep -v "^$output\$\|^run[0-9]")
    [ -z "$left" ] || { echo "left: $left"; return 1; }
    [ ! -d "$output" ] || is_listed "$output" || return
    [ "$of" != to-vdb ] || { "$ISOSHADE" info "$output" >/dev/null && has_size "$output"; } || return
    [[ $dated == *" $of "* ]] || is_same "$output" "../$of.0/$output" || is_same "$output" "../$of.1/$output" ||
        { echo "it is neither A's nor B's"; return 1; }
}

won=0 lost=0
# race WANTED SETTING ...: as many runs as settings at the same time; WANTED of them return 0 at least
race() {
    local wanted=$1 pids=() i=0 good=0 code setting
    shift
    for setting in "$@"; do
        (command "$of" "$setting") >"run$i" 2>&1 &
        pids+=($!)
        i=$((i + 1))
    done
    for i in "${!pids[@]}"; do
        wait "${pids[i]}"
        code=$?
        if [ $code = 0 ]; then
            good=$((good + 1))
        elif [ $code != 3 ] || [ "$(wc -l <"run$i")" != 1 ] || ! grep -q 'another process' "run$i"; then
            echo "exit code $code: $(head -n 2 "run$i")"
            return 1
        fi
    done
    won=$((won + good)) lost=$((lost + $# - good))
    [ $good -ge "$wanted" ] || { echo "$good of $# runs ended well: $(cat run0)"; return 1; }
    whole
}
# The first is killed at a moment that differs from round to round; the other, and later commands, have to go on.
kill_one() {
    local first second
    (command "$of" 0) >run0 2>&1 &
    first=$!
    (command "$of" 1) >run1 2>&1 &
    second=$!
    sleep "0.$(printf '%03d' $((round * 37 % 400)))"
    kill -9 $first 2>/dev/null
    wait $first 2>/dev/null
    wait $second || { echo "after the kill: $(cat run1)"; return 1; }
    race 1 1
}
round_of() {
    rm -rf o o.* .o.* .isoshade-* && race 1 0 1 && race 1 0 1 0 && rm -rf o o.* && kill_one
}

wanted=${*:-$usual}
[ -n "${ROUNDS:-}" ] && [ $# = 0 ] && wanted=$all
case " $wanted " in *" report "*) for k in 0 1; do "$ISOSHADE" "${validated[@]/..\/s/s}" --size $((8 + k)) -o r$k -q; done ;; esac
case " $wanted " in *" validate-suite "*) mkdir suite && cp "$top/refscenes/suite/one-voxel-thick.scene.json" suite ;; esac
for of in $wanted; do
    won=0 lost=0 why=
    mkdir "race.$of"
    for k in 0 1; do
        mkdir "$of.$k"
        (cd "$of.$k" && command "$of" $k) >alone 2>&1 || why="alone: $(tail -n 1 alone)"
    done
    for ((round = 1; round <= rounds; ++round)); do
        [ -z "$why" ] || break
        cd "race.$of" && { round_of >../why 2>&1 || why="round $round: $(tail -n 3 ../why)"; } && cd ..
    done
    cd "$dir" || exit 1
    if [ -z "$why" ]; then ok "outputs_of_runs_at_the_same_time_by_$of"; else not_ok "outputs_of_runs_at_the_same_time_by_$of" "$why"; fi
    [ -z "${ROUNDS:-}" ] || echo "$of: $rounds rounds, $won runs returned 0, $lost were refused, $([ -z "$why" ] && echo 0 || echo 1) outputs lost"
done
# Planted faults: a file of another setting, one that is missing, and an unfinished folder.
of=${wanted%% *}
mkdir faulty && cd faulty || exit 1
plant() { rm -rf ./* .[!.]* && cp -r "../$of.0/." . && rm -f alone; }
plant
check an_output_alone_is_whole whole
plant && echo x >>"$(find . -type f -not -name .isoshade-files | sort | head -n 1)"
notice one_that_is_mixed whole
plant && rm "$(find . -type f -not -name .isoshade-files | sort | head -n 1)"
notice one_that_lacks_a_file whole
plant && mkdir .o.partial
notice work_that_is_left whole
exit $failed
