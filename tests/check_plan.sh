#!/usr/bin/env bash
# The commands of mixed resolution: plan, bench seams, bench render --bricks.
. "$(dirname "$0")/lib.sh"
number() { sed -n "s/.*\"$2\": \([-0-9.e]*\),*$/\1/p" "$1" | head -1; }
holds() { # name, awk condition, its values
    if awk "BEGIN { exit !($2) }"; then ok "$1"; else not_ok "$1" "$2"; fi
}
scene=$top/refscenes/shells.scene.json
plan=("$ISOSHADE" plan v.nrrd --scene "$scene" --size 64 --brick 8 --levels 3 --quiet)
"$ISOSHADE" make shells --size 41x44x33 --type float -o v.nrrd --quiet || exit 1

"${plan[@]}" --error 0.02 -o a.json --image a.png >out 2>err || not_ok plan_runs "$(cat err)"
holds plan_is_within_its_error "$(number a.json measured_rmse) <= 0.02 && $(number a.json measured_rmse) > 0"
holds plan_is_smaller_than_the_full_model "$(number a.json bytes_part) < 0.9"
[ -s a.png ] && ok plan_writes_the_picture || not_ok plan_writes_the_picture "no a.png"
"${plan[@]}" --error 0.02 -o b.json >out 2>err
diff <(grep -v '"command"' a.json) <(grep -v '"command"' b.json) >diff && ok plan_is_deterministic || not_ok plan_is_deterministic "$(head -5 diff)"
"${plan[@]}" --memory 400000 -o c.json >out 2>err || not_ok memory_runs "$(cat err)"
holds memory_is_kept "$(number c.json bytes) <= 400000 && $(number c.json bytes) > 100000"
refuse memory_that_no_plan_fits_is_refused 5 "memory is 1000 bytes" "${plan[@]}" --levels 1 --memory 1000 -o refused.json
refuse brick_that_is_no_power_of_two_is_refused 5 "24 voxels" "${plan[@]}" --brick 24 -o refused.json
refuse unknown_faces_are_refused 2 "round" "${plan[@]}" --faces round -o refused.json
refuse negative_error_is_refused 2 "error" "${plan[@]}" --error -1 -o refused.json

"$ISOSHADE" bench seams --layouts 3 -o seams.png >out 2>err && [ -s seams.png ] && ok bench_seams_draws_its_picture || not_ok bench_seams_draws_its_picture "$(cat err)"
if awk '$1 == "nodes-baked" || $1 == "paper-mended" { if (!($2 <= 1e-12)) exit 1; n++ }
        $1 == "paper-written" || $1 == "nodes-own" { if (!($2 > 0.01)) exit 1; n++ } END { exit n != 4 }' out
then ok bench_seams_tells_smooth_schemes_from_others; else not_ok bench_seams_tells_smooth_schemes_from_others "$(cat out)"; fi
"$ISOSHADE" bench render --size 32 --image 32 --runs 1 --bricks 8 --json >out 2>err && grep -q '"nodes_rmse"' out && ok bench_of_bricks_runs || not_ok bench_of_bricks_runs "$(cat err)"
exit $failed
