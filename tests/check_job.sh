#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# What the main job draws and starts: no more than its decisions need, and it is counted.
. "$(dirname "$0")/lib.sh"
"$ISOSHADE" make shells --size 24x22x20 -q -o v.nrrd || exit 1
scene=$top/refscenes/shells.scene.json
# By the CPU ray caster, which takes a third of the time of OpenGL in software.
job() { "$ISOSHADE" validate v.nrrd --scene "$scene" --with cpu --quick --level-views 2 --level-size 16 -q "$@"; }

# ---- few pixels of a faint level: a single halving leaves .63 of the error by chance, one more tells that from a fault ----
check a_faint_level_is_no_false_alarm job --size 32 --levels 2 -o faint

# ---- one start of POV-Ray draws both passes of both steps of a limit ----
if command -v povray >/dev/null; then
    printf '#!/bin/sh\necho started >>"%s/starts"\nexec %s "$@"\n' "$dir" "$(command -v povray)" >counted && chmod +x counted
    # It counts outside of its folder.
    check a_limit_by_povray env ISOSHADE_SANDBOX=off ISOSHADE_POVRAY="$dir/counted" "$ISOSHADE" render v.nrrd --scene "$scene" --with povray --size 8 --limit --step 1 -q -o limit.exr
    check is_one_start_and_one_for_its_version test "$(wc -l <starts)" -le 2

    # ---- its calibrations: side by side, each by a start of its own, or all by one, to the same values ----
    calibrate() { # the file of starts, then options
        rm -f starts && ISOSHADE_SANDBOX=off ISOSHADE_POVRAY=$dir/counted "$ISOSHADE" validate v.nrrd --scene "$scene" \
            --with povray --quick --levels 1 --size 8 --level-views 2 --level-size 16 -q "${@:2}" && mv starts "$1"
    }
    check calibrations_of_one_thread calibrate together.starts --threads 1 -o together
    check and_of_two calibrate apart.starts --threads 2 -o apart
    check six_starts_more test $(($(wc -l <apart.starts) - $(wc -l <together.starts))) -eq 6
    cat >values.py <<'PY'
import json
a, b = (json.load(open(f"{name}/report.json")) for name in ("together", "apart"))
rows = [[(c["renderer"], c["check"], c["value"], c["verdict"]) for c in r["calibration"]] for r in (a, b)]
assert rows[0] == rows[1] and sum(c[0] == "povray" for c in rows[0]) >= 7, rows
PY
    check with_the_same_values python3 values.py
fi

# ---- a job that is killed is gone on with, to the same result; what was changed is not taken ----
"$ISOSHADE" make shells --size 12x11x10 -q -o v.nrrd
long() { job --size 20x16 --limit-size 10 --levels 2 "$@"; }
check a_whole_job long --resume -o whole
mkdir killed bin && cp v.nrrd killed && printf '#!/bin/sh\nkill -KILL $PPID\n' >bin/gnuplot && chmod +x bin/gnuplot # which the report needs
(cd killed && PATH=$dir/bin:$PATH job --size 20x16 --limit-size 10 --levels 2 -o whole) >/dev/null 2>&1
mv killed/whole.work saved
check pictures_are_left_of_it test "$(ls saved/*.picture | wc -l)" -ge 24 -a ! -e killed/whole
ls saved/*.picture | sed -n 1~2p | xargs rm # as if it had been killed half-way
cat >same.py <<'PY'
import json, sys
a, b = (json.load(open(f"{name}/report.json")) for name in sys.argv[1:3])
for r in (a, b):
    for key in ("made", "command", "seconds", "processor_seconds", "work"):
        r.pop(key)
    r["agreement"] = sorted(json.dumps({k: v for k, v in row.items() if k not in ("seconds", "command", "number")}) for row in r["agreement"])
assert a == b, [k for k in a if a[k] != b[k]]
PY
resume() { rm -rf "$1.work" && cp -r saved "$1.work" && long --resume -o "$1"; }
taken() { python3 -c 'import json, sys; print(json.load(open(sys.argv[1] + "/report.json"))["work"]["pictures_taken"])' "$1"; }
check a_job_that_goes_on resume on
check comes_to_the_same_result python3 same.py whole on
check and_leaves_nothing_behind test ! -e on.work
fresh=$(taken whole) # of its own: the same picture is asked for more than once
check it_took_what_was_finished test "$(taken on)" -ge $((fresh + 10))
for f in saved/*.picture; do printf '\101\102' | dd of="$f" bs=1 seek=1000 conv=notrunc status=none; done
check a_job_with_pictures_that_were_changed resume changed
check takes_none_of_them test "$(taken changed)" = "$fresh"
check and_comes_to_the_same_result python3 same.py whole changed

# ---- what a person has where pictures are kept stays ----
kept_for_a_person() { # what is at kept.work
    refuse "$1_is_refused" 3 'kept.work' job --size 16 --levels 1 -o kept
    refuse "and_to_go_on_with_$1" 3 'kept.work' job --size 16 --levels 1 --resume -o kept
}
mkdir kept.work && echo thesis >kept.work/paper.tex
kept_for_a_person a_folder_of_a_person_for_pictures
check and_stays_as_it_is grep -q thesis kept.work/paper.tex
cp saved/isoshade-pictures kept.work
kept_for_a_person a_file_of_a_person_among_pictures
check and_stays_there grep -q thesis kept.work/paper.tex
mv kept.work elsewhere && ln -s elsewhere kept.work
kept_for_a_person a_link
check and_what_it_names_stays test -L kept.work -a -s elsewhere/paper.tex
rm kept.work && echo thesis >kept.work
kept_for_a_person a_file
check and_is_not_removed grep -q thesis kept.work
rm kept.work && mkdir kept.work && touch kept.work/00112233445566778899aabbccddeeff.picture
kept_for_a_person a_folder_that_nothing_says_is_of_a_job
rm kept.work/* # an empty folder is no loss
check an_empty_folder_is_taken job --size 16 --levels 1 -o kept
check and_leaves_nothing_either test ! -e kept.work
mkdir kept.work && touch kept.work/.isoshade-0123abcd-1-2-abcdefgh-isoshade-pictures
check so_is_one_of_a_run_that_was_killed_as_it_began job --size 16 --levels 1 -o kept
# Of two at once for one report neither removes what the other has drawn.
rm -rf kept.work; cp -r saved kept.work && ls kept.work >listed
exec 9<kept.work && flock 9
kept_for_a_person a_folder_that_another_run_works_in
exec 9<&-
check and_all_of_it_stays test "$(ls kept.work)" = "$(cat listed)"
flock kept.work sleep 0.3 & # as what a killed run had started, until it is gone, too
check a_lock_that_ends_soon_is_waited_for job --size 16 --levels 1 -o kept
wait
rm -rf kept.work
# ---- an interruption: no further step starts, and the message has the command to continue ----
cat >stopped <<'END'
#!/bin/sh
case "$*" in *-version*) echo "POV-Ray 3.7.0.10"; exit 0 ;; esac
echo started >>"$STOPPED/starts"
if mkdir "$STOPPED/first" 2>/dev/null; then
    while [ ! -s "$STOPPED/pid" ]; do sleep 0.05; done
    kill -TERM "$(cat "$STOPPED/pid")"
fi
exec sleep 1000
END
chmod +x stopped
stop() { # threads: one draws all calibrations by one start, two draw four at a time, each by its own
    rm -rf starts first pid interrupted.work
    env STOPPED="$dir" ISOSHADE_SANDBOX=off ISOSHADE_POVRAY="$dir/stopped" "$ISOSHADE" validate v.nrrd --scene "$scene" --with povray --quick --size 8 --levels 1 -q --threads "$1" -o interrupted 2>err &
    echo $! >pid.new && mv pid.new pid
    wait $!
}
for threads in 1 2; do
    stop $threads
    check nothing_is_begun_after_an_interruption_of_$threads test $? != 0 -a "$(wc -l <starts)" -le $((threads * threads))
    check and_one_line_says_how_to_go_on test "$(wc -l <err)" = 1 -a "$(grep -c 'signal 15; continue from interrupted.work with --resume$' err)" = 1
done

# ---- limits have at most the pixels that are asked for, the same samples all of them ----
cat >small.py <<'PY'
import json
r = json.load(open("whole/report.json"))
limit = [row for row in r["agreement"] if row["comparison"] == "limit"]
assert [row["statistics"]["pixels"] for row in limit] == [[10, 8]] * 2, limit
size = lambda name: [r["images"][name]["width"], r["images"][name]["height"]]
assert all(size(row[k]) == [10, 8] for row in limit for k in ("image_a", "image_b"))
assert all(size(row["image_b"]) == [20, 16] for row in r["agreement"] if row["comparison"] == "lock-step" and not row["variant"])
assert all("--size 10x8" in row["command"] for row in limit)
work = r["work"]
assert work["program_starts"] == 0 and work["processor_seconds"] > 0
assert work["renderers"]["cpu"]["pictures"] > 10 and work["renderers"]["cpu"]["pixel_steps"] > work["renderers"]["cpu"]["pixels"]
assert sum(r["processor_seconds"].values()) <= 1.01 * work["processor_seconds"] + 0.1
PY
check sizes_and_work_are_in_the_report python3 small.py

# ---- a budget: skipped checks are listed, without a verdict ----
expect nothing_is_compared_in_no_time 1 "$ISOSHADE" validate v.nrrd --scene "$scene" --with gl --quick --size 16 --levels 2 --budget 0.01 -q -o hurried
check which_is_said grep -q "not compared: shells, level 0, gl: the budget of 0.01 s was over" out
check whole_stages_first test "$(grep '^not compared' out | sed -n '1,5s/^not compared: stage, .*/stage/p' | wc -l)" = 5
check and_that_no_level_was_judged grep -qx 'The levels were not judged: the budget of 0.01 s was over before it could be asked.' out
cat >hurried.py <<'PY'
import json
r = json.load(open("hurried/report.json"))
assert r["options"]["budget_seconds"] == 0.01 and r["levels"] == [] and r["calibration"]
assert r["agreement"] and all(row["verdict"] == "not compared" and row["not_compared"] == "budget" for row in r["agreement"])
assert r["levels_sentence"].startswith("The levels were not judged: the budget")
assert {"consistency", "on-the-fly", "moments"} <= {row["variant"] for row in r["agreement"]}
PY
check in_the_report_too python3 hurried.py
check enough_time_is_no_hurry long --budget 3600 -o enough
cat >enough.py <<'PY'
import json
a, b = (json.load(open(f"{name}/report.json")) for name in ("whole", "enough"))
key = lambda row: [row[k] for k in ("level", "b", "verdict", "rmse")]
assert sorted(map(str, map(key, a["agreement"]))) == sorted(map(str, map(key, b["agreement"]))) and a["levels"] == b["levels"]
PY
check and_the_verdict_is_the_same python3 enough.py
for budget in -1 0; do refuse "a_budget_of_$budget" 2 "--budget is $budget, must be above 0 seconds" job --budget $budget -o no; done
exit $failed
