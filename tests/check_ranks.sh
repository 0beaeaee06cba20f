#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# build under mpirun: the bytes of the build without, whatever the number of ranks; a bad input or a rank that dies gives
# one message, the exit code, and nothing that looks finished.
. "$(dirname "$0")/lib.sh"
export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 OMPI_MCA_btl_base_warn_component_unused=0
export OMP_NUM_THREADS=1
# MPI keeps what it allocates at start until the end, and the leak checker is for our own.
export ASAN_OPTIONS=${ASAN_OPTIONS:-}:detect_leaks=0
command -v mpirun >/dev/null || { not_ok mpirun "not found: install openmpi-bin"; exit 1; }
ranks() { patiently mpirun -n "$1" --oversubscribe "$ISOSHADE" build "${@:2}"; }
same() { diff -rq "$1" "$2"; }
# The one message of the program's own; mpirun adds its own lines.
one_message() { [ "$(grep -c '^isoshade build:' err)" = 1 ]; }
nothing_left() { [ -z "$(ls -A | grep -E 'no\.iso')" ]; }

check the_program_alone_is_not_linked_with_mpi bash -c '! ldd "$0" | grep -q libmpi' "$ISOSHADE"

"$ISOSHADE" make marschner-lobb --size 21x16x75 --spacing 1x1x2.5 --rotate 1,2,3,40 -o v.nrrd -q || exit 1
"$ISOSHADE" make noise --size 13x18x67 --type float -o f.nrrd -q || exit 1
"$ISOSHADE" make noise --size 10x11x53 --gzip -o z.nrrd -q || exit 1
try() { # NAME RANKS VOLUME OPTIONS
    local name=$1 n=$2 volume=$3 pids
    shift 3
    rm -rf one.iso many.iso
    "$ISOSHADE" build "$volume" -o one.iso -q "$@" >one.txt && ranks "$n" "$volume" -o many.iso -q "$@" >many.txt 2>err ||
        { not_ok "$name" "$(tail -n 2 err)"; return; }
    check "$name" same one.iso many.iso
}
try two_ranks_write_the_same_bytes 2 v.nrrd --levels 4
check and_speak_once diff <(sed s/one/many/ one.txt) many.txt
try five_ranks_do 5 v.nrrd --levels 3 --estimator fourth
try the_longest_reach 2 f.nrrd --estimator bspline --levels 3
try one_rank_does 1 v.nrrd
try levels_above_the_carried_one_too 3 v.nrrd --levels 7 --keep-float --keep-magnitude
try floats_are_measured_in_shares 3 f.nrrd --levels 6 --direction-filter tensor
try eq1_goes_on_from_rank_to_rank 2 v.nrrd --direction-filter eq1 --levels 4
try wide_filters_of_everything 3 f.nrrd --direction-filter eq1 --scalar-filter gauss --gauss-radius 3 --levels 3 --code region48
try means_beside_gaussians 2 f.nrrd --direction-filter naive --scalar-filter gauss --levels 6 --keep-magnitude
try least_squares_directions 3 v.nrrd --direction-filter least-squares --levels 4 --keep-float
try and_beside_damped_levels 2 f.nrrd --direction-filter least-squares --scalar-filter damped --levels 7
try damped_levels 3 v.nrrd --scalar-filter damped --levels 7
try least_squares_beside_eq1 2 f.nrrd --scalar-filter least-squares --direction-filter eq1 --levels 3
try least_squares_above_the_carried_level 3 v.nrrd --scalar-filter least-squares --levels 7
try filters_that_are_chosen_in_shares 3 v.nrrd --direction-filter auto --levels 7 --keep-magnitude
try and_of_floats 2 f.nrrd --direction-filter auto --scalar-filter gauss --levels 4
try more_ranks_than_slabs 4 z.nrrd --levels 7 --memory 40

expect help_is_printed_once 0 ranks 3 --help
check and_only_once test "$(grep -c '^usage' out)" = 1
expect a_missing_volume_is_an_error 3 ranks 3 none.nrrd -o no.iso
check said_once one_message
expect a_wrong_option_is 2 ranks 2 v.nrrd -o no.iso --levels 0
check said_once_too one_message
head -c 30000 v.nrrd >short.nrrd
expect a_truncated_volume_is 4 ranks 2 short.nrrd -o no.iso
head -c 8000 z.nrrd >damaged.nrrd
expect a_volume_that_breaks_off_amid_the_slabs_is 4 ranks 3 damaged.nrrd -o no.iso --levels 3
check said_once_again one_message
head -c $((4 * 40 * 9 * 8)) /dev/zero >infinite.raw
printf '\x00\x00\x80\x7f' | dd of=infinite.raw bs=1 seek=$((4 * 72 * 30)) conv=notrunc 2>/dev/null
expect an_infinite_value_in_one_share_is 5 ranks 3 infinite.raw --raw-size 9x8x40 --raw-type float -o no.iso
check with_its_plane grep -q 'plane 30' err
check nothing_half_written_is_left nothing_left
expect a_foreign_folder_is_kept 3 ranks 2 v.nrrd -o "$dir"

# Killed amid the work: a rank dies, the rest ends with it; what was left is taken up by another number of ranks. A build
# that was over before the shell came to kill it proves nothing, so that it is made again until one is met amid its work.
head -c $((2 * 320 * 320 * 1400)) /dev/zero >big.raw
big="big.raw --raw-size 320x320x1400 --raw-type uint16 --memory 30 --save-every 0 -q"
last_rank() { # the process of the last rank of this folder's build
    pgrep -f "build big.raw .*-o no.iso" | while read -r p; do
        [ "$(cat /proc/$p/comm)" = isoshade ] && [ "$(readlink /proc/$p/cwd)" = "$dir" ] && echo "$p"
    done 2>/dev/null | tail -n 1
}
for ((try = 0; try < 100; ++try)); do
    rm -rf no.iso .no.iso.partial
    ranks 3 $big -o no.iso >/dev/null 2>err &
    while [ ! -e .no.iso.partial/progress.json ] && kill -0 $! 2>/dev/null; do sleep 0.02; done
    kill -9 $(last_rank) 2>/dev/null
    wait $!
    code=$?
    [ -e no.iso ] && [ $code = 0 ] || break
done
if [ $code != 0 ] && [ ! -e no.iso ] && [ -e .no.iso.partial/progress.json ]; then ok a_rank_that_is_killed_leaves_nothing_that_looks_finished
else not_ok a_rank_that_is_killed_leaves_nothing_that_looks_finished "code $code, $(ls -A | tr '\n' ' ')"; fi
expect two_ranks_take_up_what_three_left 0 ranks 2 $big -o no.iso --resume --json
check from_where_they_stood grep -qE '"resumed_at_plane": [1-9]' out
"$ISOSHADE" build $big -o one.iso >/dev/null
check to_the_same_bytes same one.iso no.iso
# Planted: a file that differs in one byte is found.
printf 'x' | dd of=no.iso/level_1_dir.nrrd bs=1 seek=5000 conv=notrunc 2>/dev/null
check one_byte_would_be_seen bash -c '! diff -rq one.iso no.iso >/dev/null'

# ---- validate: ranks share the pictures -------------------------------------------------------------------------------
"$ISOSHADE" make shells --size 24x20x22 -o shells.nrrd -q || exit 1
validate() { # FOLDER, options: a report in FOLDER/r; by RANKS ranks
    mkdir -p "$1" && (cd "$1" && patiently ${RANKS:+mpirun -n $RANKS --oversubscribe} "$ISOSHADE" validate ../shells.nrrd \
        --scene "$top/refscenes/shells.scene.json" --quick --with cpu --threads 1 -o r "${@:2}")
}
# The report without times, and without the work of the rank that writes it.
facts() {
    python3 - "$1/r/report.json" <<'EOF'
import json, sys
def without(value):
    if isinstance(value, dict):
        times = ("seconds", "processor_seconds", "work", "made")
        return {key: without(part) for key, part in value.items() if key not in times}
    return [without(part) for part in value] if isinstance(value, list) else value
print(json.dumps(without(json.load(open(sys.argv[1]))), indent=1))
EOF
}
same_report() { facts "$1" >first.txt && facts "$2" >second.txt && [ "$(wc -l <first.txt)" -gt 100 ] && cmp first.txt second.txt; }
pictures() { python3 -c 'import json, sys; print(json.load(open(sys.argv[1]))["work"]["pictures"])' "$1/r/report.json"; }
by_two() { RANKS=2 validate "$@"; }
no_death() { ! grep -q died err; }
other_is_seen() { ! same_report alone other; }
expect one_rank_validates 0 validate alone --size 32
expect two_ranks_validate 0 by_two two --size 32
check and_none_dies no_death
check with_the_same_report same_report alone two
check of_which_each_drew_a_part test "$(pictures two)" -lt "$(pictures alone)"
check the_pictures_are_removed test ! -e two/r.work
expect another_size_validates 0 validate other --size 33
check and_another_report_would_be_seen other_is_seen

expect an_input_that_is_missing 3 patiently mpirun -n 2 --oversubscribe "$ISOSHADE" validate none.nrrd -o missing
check is_no_death no_death
check and_one_message test "$(grep -c '^isoshade validate:' err)" = 1

# The process of rank 1 that works in FOLDER, a child of the one that mpirun started, is killed while it draws.
of_rank_1() {
    pgrep -x isoshade | while read -r p; do
        grep -qz OMPI_COMM_WORLD_RANK=1 /proc/$p/environ && [ "$(readlink /proc/$p/cwd)" = "$dir/$1" ] && echo "$p"
    done 2>/dev/null
}
kill_worker() {
    until [ -n "$(ls "$1"/r.work/*.picture 2>/dev/null)" ] && [ "$(of_rank_1 "$1" | wc -l)" = 2 ]; do sleep 0.01; done
    kill -9 "$(of_rank_1 "$1" | tail -n 1)"
}
kill_worker killed &
expect a_rank_that_dies_does_not_end_the_job 0 by_two killed --size 48
kill $! 2>/dev/null
check it_is_reported grep -q 'rank 1 died of signal 9' err
expect the_same_alone 0 validate whole --size 48
check and_its_pictures_are_drawn same_report whole killed

# ---- figure: ranks share the frames of a turntable; other commands refuse ranks ---------------------------------------
turn() { # FOLDER, options
    mkdir -p "$1" && (cd "$1" && patiently ${RANKS:+mpirun -n $RANKS --oversubscribe} "$ISOSHADE" figure ../shells.nrrd \
        --kind turntable --frames 12 --with reference --formats png --dpi 40 --threads 1 -o r --json "${@:2}")
}
same_frames() { cmp "$1/r/turntable.png" "$2/r/turntable.png" && diff -r "$1/r/frames" "$2/r/frames"; }
turn_by_two() { RANKS=2 turn "$@"; }
expect one_rank_turns 0 turn turned
check alone_it_counts_no_ranks bash -c '! grep -q ranks out'
expect two_ranks_turn 0 turn_by_two turned-by-two
check of_the_frames_each_drew_some grep -qE '"frames_of_other_ranks": ([1-9]|1[01])$' out
check with_the_same_frames same_frames turned turned-by-two
check the_frames_in_between_are_removed test ! -e turned-by-two/r.work
kill_worker turned-killed &
expect a_turning_rank_dies 0 turn_by_two turned-killed
kill $! 2>/dev/null
check it_is_reported_too grep -q 'isoshade figure: warning: rank 1 died of signal 9' err
check and_its_frames_are_drawn same_frames turned turned-killed
# Planted: a byte of a frame.
printf 'x' | dd of=turned-killed/r/turntable.png bs=1 seek=60 conv=notrunc 2>/dev/null
notice other_frames_would_be_seen same_frames turned turned-killed

two() { patiently mpirun -n 2 --oversubscribe "$ISOSHADE" "$@"; }
refuses() { # NAME, message's beginning, command: exit code 2, one message, no output
    expect "$1" 2 two "${@:3}"
    check "${1}_in_one_message" test "$(grep -c '^isoshade' err)" = 1
    check "${1}_by_name" grep -q "^isoshade $2: .*start one process" err
    check "${1}_without_output" test ! -e refused
}
refuses rendering_refuses_ranks render render shells.nrrd -o refused
refuses a_chart_does chart chart shells.nrrd -o refused
refuses a_benchmark_does 'bench build' bench build --size 16
refuses another_kind_of_figure_does figure figure shells.nrrd --kind levels -o refused
expect help_is_for_any_rank 0 two render --help
expect one_rank_renders 0 patiently mpirun -n 1 --oversubscribe "$ISOSHADE" render shells.nrrd --size 8 -o one.png
expect independent_processes_render 0 patiently mpirun -n 2 --oversubscribe env -u OMPI_COMM_WORLD_SIZE -u PMI_SIZE \
    sh -c '"$0" render shells.nrrd --size 8 -o rank$OMPI_COMM_WORLD_RANK.png' "$ISOSHADE"
check each_of_its_own cmp rank0.png rank1.png
expect the_ranks_of_srun_are_seen 2 env SLURM_PROCID=0 SLURM_STEP_NUM_TASKS=2 "$ISOSHADE" render shells.nrrd -o refused
expect but_its_batch_script_is_one 0 env SLURM_PROCID=0 SLURM_NTASKS=2 "$ISOSHADE" render shells.nrrd --size 8 -o one.png
exit $failed
