#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# The commands of mixed resolution: plan, isoshade-lab seams and plan, bench render --bricks.
. "$(dirname "$0")/lib.sh"
scene=$top/refscenes/shells.scene.json
plan=("$ISOSHADE" plan v.nrrd --scene "$scene" --size 64 --brick 8 --levels 3 --quiet)
"$ISOSHADE" make shells --size 41x44x33 --type float -o v.nrrd --quiet || exit 1

"${plan[@]}" --error 0.02 -o a.json --image a.png >out 2>err || not_ok plan_runs "$(cat err)"
holds plan_is_within_its_error "$(json_number a.json measured_rmse) <= 0.02 && $(json_number a.json measured_rmse) > 0"
holds plan_is_smaller_than_the_full_model "$(json_number a.json bytes_part) < 0.9"
check plan_writes_the_picture test -s a.png
"${plan[@]}" --error 0.02 -o b.json >out 2>err
diff <(grep -v '"command"' a.json) <(grep -v '"command"' b.json) >diff && ok plan_is_deterministic || not_ok plan_is_deterministic "$(head -5 diff)"
# A pyramid's plan is its volume's. It reads level 0's samples alone, in their own type, and checks them.
facts_of() { grep -vE '"(command|volume)"' "$1"; }
same_plan() { diff <(facts_of volume.json) <(facts_of pyramid.json) && [ "$(facts_of volume.json | wc -l)" -gt 20 ]; }
for type in uint8 int16 float; do
    "$ISOSHADE" make shells --size 41x44x33 --type $type -o t.nrrd --quiet
    "$ISOSHADE" build t.nrrd -o $type.iso --levels 3 --quiet >out
    "$ISOSHADE" plan t.nrrd --scene "$scene" --size 64 --brick 8 --levels 3 --error 0.02 -o volume.json --quiet >out 2>err
    "$ISOSHADE" plan $type.iso --scene "$scene" --size 64 --brick 8 --levels 3 --error 0.02 -o pyramid.json --quiet >out 2>err
    check "a_pyramid_of_${type}_has_the_plan_of_its_volume" same_plan
    "$ISOSHADE" tf suggest t.nrrd -o volume.tf.json --no-provenance --quiet >out && "$ISOSHADE" tf suggest $type.iso -o pyramid.tf.json --no-provenance --quiet >out
    check "and_of_${type}_its_transfer_function" diff volume.tf.json pyramid.tf.json
done
printf x | dd of=uint8.iso/level_0.nrrd bs=1 seek=20000 conv=notrunc 2>/dev/null
refuse a_pyramid_that_was_changed_is_refused 4 checksum "$ISOSHADE" plan uint8.iso --scene "$scene" --quiet
if has_peak; then
    "$ISOSHADE" make shells --size 160 --type uint8 -o large.nrrd --quiet && "$ISOSHADE" build large.nrrd -o large.iso --levels 3 --quiet >out
    of_volume=$(peak "$ISOSHADE" plan large.nrrd --scene "$scene" --size 16 --threads 1)
    # 8 bytes per voxel of all levels for floats and codes would be 37 MB
    holds it_takes_the_memory_of_the_volume "$(peak "$ISOSHADE" plan large.iso --scene "$scene" --size 16 --threads 1) < $of_volume + 8000 && $of_volume > 5000"
else
    skip it_takes_the_memory_of_the_volume "no /usr/bin/time, or a build with sanitizers, whose memory is another"
fi
"${plan[@]}" --memory 400000 -o c.json >out 2>err || not_ok memory_runs "$(cat err)"
holds memory_is_kept "$(json_number c.json bytes) <= 400000 && $(json_number c.json bytes) > 100000"
refuse memory_that_no_plan_fits_is_refused 5 "may have 1000 bytes" "${plan[@]}" --levels 1 --memory 1000 -o refused.json
refuse brick_that_is_no_power_of_two_is_refused 5 "24 voxels" "${plan[@]}" --brick 24 -o refused.json
"${plan[@]}" --memory 500 -o tight.json >out 2>err
grep -q "shows anything needs" err && ok memory_in_which_nothing_shows_is_refused || not_ok memory_in_which_nothing_shows_is_refused "$(cat err)"
"$ISOSHADE" plan v.nrrd --scene "$scene" --size 64 --brick 8 --levels 3 --memory 60000 >out 2>err
grep -q "warning: the RMSE .*raise --memory" err && ok memory_that_leaves_little_warns || not_ok memory_that_leaves_little_warns "$(cat out err)"

{ head -c 2456 /dev/zero; printf '\377'; head -c 2456 /dev/zero; } >one.raw # a voxel alone
"$ISOSHADE" plan one.raw --raw-size 17x17x17 --raw-type uint8 --scene "$scene" --size 32 --brick 16 --levels 4 --error 0.9 >out 2>err
check an_error_that_leaves_little_is_named grep -q 'warning: the RMSE .*; lower --error$' err
"$ISOSHADE" plan one.raw --raw-size 17x17x17 --raw-type uint8 --scene "$scene" --size 32 --brick 16 --levels 4 --error 0.001 -o one.json >out 2>err
holds what_shows_between_nodes_is_within_its_error "$(json_number one.json measured_rmse) <= 0.001"

# What no ray saw of the volume, behind what is nearly opaque, shows a little: it stays where so little is an error.
"$ISOSHADE" make noise --size 41x44x33 --type float -o noise.nrrd --quiet
for view in front iso; do
    "$ISOSHADE" plan noise.nrrd --tf microscopy --view $view --size 48 --brick 8 --levels 3 --error 1e-6 --quiet -o tiny.json >out 2>err
    holds "a_tiny_error_is_kept_from_$view" "$(json_number tiny.json measured_rmse) <= 1e-6"
done

# Several views: each brick that one of them sees is kept, and each image is within the error.
"${plan[@]}" --error 0.02 --views 3 -o views.json >out 2>err || not_ok views_run "$(cat err)"
holds views_are_all_within_the_error "$(json_number views.json measured_rmse) <= 0.02 && $(json_number views.json views) == 3"
for side in a views; do sed -n 's/.*"use": "\(.*\)".*/\1/p' $side.json | tr -d 'dh\n' | wc -c >$side.unseen; done
holds more_views_leave_fewer_bricks_unseen "$(cat views.unseen) <= $(cat a.unseen)"
"${plan[@]}" --error 0.02 --scene "$scene,$top/refscenes/brain.scene.json" -o two.json >out 2>err || not_ok two_scenes_run "$(cat err)"
holds two_scenes_are_planned_for "$(json_number two.json views) == 2 && $(json_number two.json measured_rmse) <= 0.02"

# An update bakes part of the bricks, and the command itself compares the bytes.
"${plan[@]}" --error 0.01 --update a.json -o u.json >out 2>err || not_ok update_runs "$(cat err)"
holds update_bakes_what_changed "$(json_number u.json baked_count) > 0 && $(json_number u.json baked_count) < $(json_number u.json drawn_count)"
"${plan[@]}" --error 0.02 --update a.json -o u.json >out 2>err
holds update_without_a_change_bakes_nothing "$(json_number u.json baked_count) == 0 && $(json_number u.json changed_count) == 0"
refuse update_of_other_bricks_is_refused 5 "other bricks" "$ISOSHADE" plan v.nrrd --scene "$scene" --size 32 --brick 16 --levels 3 --update a.json --quiet

# Exports.
export_plan=("$ISOSHADE" export v.nrrd --scene "$scene" --plan a.json --quiet)
"$ISOSHADE" export v.nrrd --to vdb -o full.vdb --quiet >out 2>err
for grids in merged levels; do
    "${export_plan[@]}" --to vdb --grids $grids -o $grids.vdb >out 2>err || not_ok "export_of_${grids}_runs" "$(cat err)"
    holds "vdb_of_a_plan_shrinks_$grids" "$(stat -c %s $grids.vdb) < 0.7 * $(stat -c %s full.vdb)"
done
# Both leave out what the scene does not show, and have directions in half floats. The planted fault: a file that does neither.
"$ISOSHADE" export v.nrrd --to vdb --scene "$scene" -o shown.vdb --quiet >out 2>err
holds vdb_of_a_plan_is_as_small_as_what_is_shown "$(stat -c %s merged.vdb) < 1.05 * $(stat -c %s shown.vdb)"
holds vdb_of_all_voxels_is_not "$(stat -c %s full.vdb) > 1.05 * $(stat -c %s shown.vdb)"
# Behind the random number that OpenVDB gives each file.
mv merged.vdb first.vdb # the file holds the command, and its own name
"${export_plan[@]}" --to vdb --grids merged -o merged.vdb >out 2>err
check export_is_deterministic cmp -i 57 first.vdb merged.vdb
"$ISOSHADE" export v.nrrd --to povray --scene "$scene" -o full-pov --quiet >out 2>err
"${export_plan[@]}" --to povray -o plan-pov >out 2>err || not_ok export_to_povray_runs "$(cat err)"
holds df3s_are_cropped "$(cat plan-pov/*.df3 | wc -c) < $(cat full-pov/*.df3 | wc -c)"
refuse plan_without_its_scene_is_refused 2 "scene" "$ISOSHADE" export v.nrrd --to vdb --plan a.json -o refused.vdb
sed '/"use"/s/[dh]/u/g' a.json >unseen.json
for to in vdb povray; do
    refuse "a_plan_of_nothing_is_refused_by_name_to_$to" 5 "unseen.json: the plan draws none of its" "$ISOSHADE" export v.nrrd --to $to --plan unseen.json --scene "$scene" -o "refused.${to/povray/pov}" --quiet
done
refuse a_tf_besides_a_plan_is_refused 2 "--tf and --plan exclude each other" "$ISOSHADE" export v.nrrd --to vdb --plan a.json --tf simulation -o refused.vdb
refuse plan_for_another_scene_is_refused 5 "another one" "$ISOSHADE" export v.nrrd --to vdb --plan a.json --scene "$top/refscenes/brain.scene.json" -o refused.vdb --quiet
"$ISOSHADE" make shells --size 20 -o small.nrrd --quiet
refuse plan_for_another_volume_is_refused 5 "bricks" "$ISOSHADE" export small.nrrd --to vdb --plan a.json --scene "$scene" -o refused.vdb --quiet
refuse grids_without_a_plan_are_refused 2 "plan" "$ISOSHADE" export v.nrrd --to vdb --grids levels -o refused.vdb

# Cycles of both: RMSE as predicted. The planted fault is half a voxel: a shift of it changes this image by 0.05 and more.
if ! has_cycles; then
    skip cycles_of_a_plan_is_cycles_of_the_volume "$lack"
elif command -v blender >/dev/null; then
    "$ISOSHADE" make sphere --size 24x20x22 -o ball.nrrd --quiet
    "$LAB" plan ball.nrrd --scene "$top/refscenes/marschner-lobb.scene.json" --size 48 --levels 3 --error 0.01 --cycles 32 --step 0.25 --json --quiet >bench.json 2>err ||
        not_ok bench_plan_runs "$(cat err)"
    holds cycles_of_a_plan_is_cycles_of_the_volume "$(json_number bench.json cycles_rmse) > 0 && $(json_number bench.json cycles_rmse) <= 0.011"
fi
# A cache that is too small: mixed, coarser the smaller, never more bytes than allowed; pages change nothing.
cached=("$ISOSHADE" render v.nrrd --scene "$scene" --with gl --size 64 --brick 8 --brick-levels 3)
compare_rmse() { json_number <("$ISOSHADE" compare "$1" "$2" --json 2>err) rmse; }
rmse_to_full() { compare_rmse "$1" c-full.exr; }
"${cached[@]}" --cache-bytes 1e9 -o c-full.exr >full.out 2>err || not_ok cache_runs "$(cat err)"
for bytes in 400000 340000; do
    "${cached[@]}" --cache-bytes $bytes -o c-$bytes.exr >$bytes.out 2>err || not_ok "cache_of_$bytes runs" "$(cat err)"
    holds "cache_of_$bytes is_kept" "$(sed -n 's/cache: \([0-9.e+]*\) bytes.*/\1/p' $bytes.out) <= $bytes"
    holds "cache_of_$bytes is_mixed" "$(grep -o 'at level' $bytes.out | wc -l) > 1"
done
holds a_smaller_cache_errs_more "$(rmse_to_full c-400000.exr) < $(rmse_to_full c-340000.exr) && $(rmse_to_full c-340000.exr) < 0.1"
predicted=$(sed -n 's/.*RMSE \([0-9.e-]*\) predicted/\1/p' 400000.out)
holds a_cache_is_within_what_is_predicted "$(rmse_to_full c-400000.exr) <= 4 * $predicted"
"${cached[@]}" --cache-bytes 1e9 --page-side 30 -o c-pages.exr >pages.out 2>err || not_ok pages_run "$(cat err)"
grep -q "on [2-4] pages" pages.out && "$ISOSHADE" compare c-pages.exr c-full.exr --max-abs 2e-5 >out 2>&1 && ok pages_change_nothing || not_ok pages_change_nothing "$(cat pages.out out)"
refuse cache_that_nothing_fits_is_refused 5 "allow more levels" "${cached[@]}" --cache-bytes 1000 -o refused.exr --quiet
# The CPU ray caster draws the same bricks, in fewer bytes: nodes alone.
by_cpu=("$ISOSHADE" render v.nrrd --scene "$scene" --with cpu --size 64 --brick 8 --brick-levels 3)
"${cached[@]}" --plan-error 1/50 -o gl-plan.exr >gl-plan.out 2>err || not_ok gl_plan_runs "$(cat err)"
"${by_cpu[@]}" --plan-error 1/50 -o cpu-plan.exr >cpu-plan.out 2>err || not_ok cpu_plan_runs "$(cat err)"
bricks_of() { grep -o '[0-9]* bricks,.*' "$1"; }
check both_ray_casters_draw_the_same_bricks test "$(bricks_of gl-plan.out)" = "$(bricks_of cpu-plan.out)"
holds bricks_of_several_levels "$(grep -o 'at level' cpu-plan.out | wc -l) > 1"
# 16 bits of GL's texture filter, and floats of its places, through a steep transfer function: 1e-5 was seen.
holds both_ray_casters_show_the_same "$(compare_rmse gl-plan.exr cpu-plan.exr) <= 1e-4"
holds another_plan_is_seen "$(compare_rmse c-full.exr cpu-plan.exr) > 1e-3"
"${by_cpu[@]}" --cache-bytes 200000 -o cpu-small.exr >cpu-small.out 2>err || not_ok cpu_cache_runs "$(cat err)"
holds its_bytes_are_kept "$(sed -n 's/cache: \([0-9.e+]*\) bytes.*/\1/p' cpu-small.out) <= 200000"
refuse pages_are_of_textures 2 "page-side" "${by_cpu[@]}" --cache-bytes 1e9 --page-side 30 -o refused.exr --quiet
refuse cache_of_another_renderer_is_refused 2 "cache-bytes" "${cached[@]}" --cache-bytes 1000 --with reference -o refused.exr --quiet
refuse a_picture_of_a_plan_is_no_jpeg 2 "must end with .exr or .png" "${plan[@]}" --image refused.jpg -o refused.json
refuse nor_is_that_of_all 2 "must end with .exr or .png" "${plan[@]}" --full-image refused.jpg -o refused.json
refuse unknown_faces_are_refused 2 "round" "${plan[@]}" --faces round -o refused.json
refuse negative_error_is_refused 2 "error" "${plan[@]}" --error -1 -o refused.json

"$LAB" seams --layouts 3 -o seams.png >out 2>err && [ -s seams.png ] && ok bench_seams_draws_its_picture || not_ok bench_seams_draws_its_picture "$(cat err)"
if awk '$1 == "nodes-baked" || $1 == "paper-corrected" { if (!($2 <= 1e-12)) exit 1; n++ }
        $1 == "paper-written" || $1 == "nodes-own" { if (!($2 > 0.01)) exit 1; n++ } END { exit n != 4 }' out
then ok bench_seams_tells_smooth_schemes_from_others; else not_ok bench_seams_tells_smooth_schemes_from_others "$(cat out)"; fi
"$ISOSHADE" bench render --size 32 --image 32 --runs 1 --bricks 8 --json >out 2>err && grep -q '"bricks-baked"' out && ok bench_of_bricks_runs || not_ok bench_of_bricks_runs "$(cat err)"
exit $failed
