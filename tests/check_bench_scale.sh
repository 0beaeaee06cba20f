#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# bench scale: every command is measured with the smallest volume; chart and data; what is refused.
. "$(dirname "$0")/lib.sh"
expect commands_are_measured 0 "$ISOSHADE" bench scale --largest 64 --repeat 1 -o chart --json -q
mv out scale.json
has_keys json_has scale.json machine stages slope is_streamed processor_seconds peak_bytes process_seconds
has_files chart_has chart scale.csv scale.gp scale.svg style.gp
check six_commands_had_a_volume test "$(grep -c '"voxels": 262144' scale.json)" = 6
notice one_that_fails_would_be_seen grep -q '"left_out"' scale.json
check one_size_has_no_slope grep -q '"slope": null' scale.json
expect grain_is_measured 0 "$ISOSHADE" bench scale --largest 64 --repeat 1 --of grain --only build --json -q
check grain_was_made grep -q '"of": "grain"' out
expect what_a_command_reads_is_made 0 "$ISOSHADE" bench scale --largest 64 --repeat 1 --only render --json -q
check and_it_is_measured_alone test "$(grep -c '"voxels": 262144' out)" = 1 -a "$(grep -c 'not requested' out)" = 5
refuse a_command_that_is_none 2 '"nonsense", must be build, histogram' "$ISOSHADE" bench scale --largest 64 --only render,nonsense
refuse a_content_that_is_none 2 'one of: shells, grain' "$ISOSHADE" bench scale --of ramp
refuse a_size_that_is_none 2 'must be 64, 128' "$ISOSHADE" bench scale --largest 100
refuse a_format_that_is_none 2 'svg or pdf' "$ISOSHADE" bench scale --format bmp
exit $failed
