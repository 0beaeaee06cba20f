#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Levels that are chosen for a transfer function and a budget: what is said, kept and verified; and what is refused.
. "$(dirname "$0")/lib.sh"
tf=$top/refscenes/shells.tf.json
"$ISOSHADE" make shells --size 24x20x22 -q -o v.nrrd

expect levels_are_chosen 0 "$ISOSHADE" build v.nrrd --auto --tf "$tf" --levels 3 -o v.iso
check what_was_predicted_is_said grep -q "^predicted error over the default's: default 1.00, original" out
check and_what_is_chosen grep -q '^chosen: .* bytes a voxel beside the scalar' out
expect as_data 0 "$ISOSHADE" build v.nrrd --auto --tf "$tf" --levels 3 --threads 1 -o w.iso --json
has_keys data out auto chosen designs predicted opacity_errors budget_bytes_per_voxel options bytes_per_voxel
check threads_change_no_byte diff -r v.iso w.iso
expect a_pyramid_says_what_it_was_chosen_for 0 "$ISOSHADE" info v.iso
check with_the_transfer_function grep -q "chosen .*, for ${tf##*/}\$" out
expect it_is_verified 0 "$ISOSHADE" info v.iso --verify

expect a_smaller_budget 0 "$ISOSHADE" build v.nrrd --auto --tf "$tf" --levels 3 --budget 3 -o small.iso
check leaves_out_what_needs_more grep -q 'scaled-damped [0-9.]* (above the budget)' out
check and_takes_three_bytes grep -q '^chosen: .* 3 bytes a voxel' out

# How the levels of a volume or a pyramid are shown.
expect tf_adapt_chooses 0 "$ISOSHADE" tf adapt v.nrrd --auto --tf "$tf" --levels 3 -o chosen
check a_design_a_level test "$(grep -c '^ *chosen: .* predicted error [0-9.]* of what small views' out)" = 2
check files_are_there test -s chosen_level_1.tf.json -a -s chosen_level_2.tf.json
expect of_a_pyramid_too 0 "$ISOSHADE" tf adapt small.iso --auto --budget 3 --tf "$tf" -o chosen --json
has_keys of_each_level out auto chosen options bytes_per_voxel predicted
check within_the_budget test "$(grep -c '"bytes_per_voxel": 3' out)" = 2
"$ISOSHADE" build v.nrrd --scalar-filter gauss --levels 2 -q -o gauss.iso
refuse another_filter 5 "--auto knows mean, damped" "$ISOSHADE" tf adapt gauss.iso --auto --tf "$tf" -o y
refuse two_rules 2 "one of the two" "$ISOSHADE" tf adapt v.nrrd --auto --always --tf "$tf" -o y
refuse too_small_a_budget_to_show 2 "directions alone take 3" \
    "$ISOSHADE" tf adapt v.nrrd --auto --budget 2 --tf "$tf" -o y
check nothing_is_written test ! -e y_level_1.tf.json

refuse a_filter_that_is_given 2 "--auto chooses filters" \
    "$ISOSHADE" build v.nrrd --auto --tf "$tf" --scalar-filter mean -o x.iso
refuse too_small_a_budget 2 "directions alone take 3" "$ISOSHADE" build v.nrrd --auto --tf "$tf" --budget 2 -o x.iso
refuse a_pyramid_is_no_volume 2 "v.iso is a pyramid" "$ISOSHADE" build v.iso --auto --tf "$tf" -o x.iso
refuse a_transfer_function_alone 2 "what --auto or --for first makes levels for" "$ISOSHADE" build v.nrrd --tf "$tf" -o x.iso
refuse too_little_memory 6 "MB, --memory is 0.1" "$ISOSHADE" build v.nrrd --auto --tf "$tf" --memory 0.1 -o x.iso
check nothing_is_left test ! -e x.iso
exit $failed
