#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Each reader takes damaged files, under the sanitizers: all seeds, then mutations of a fixed seed, ISOSHADE_FUZZ_COUNT or
# ISOSHADE_FUZZ_SECONDS of processor time a reader, whichever is less, and 8 at least; readers that start a program for each
# input (dicom, slices, vdb, hdf5, netcdf, zarr) take longer, and are called without one, too, a hundred times as often a second. `make fuzz` and tests/fuzz/campaign.sh go on for as long as one likes.
. "$(dirname "$0")/lib.sh"
count=${ISOSHADE_FUZZ_COUNT:-10000} seconds=${ISOSHADE_FUZZ_SECONDS:-0.2} seed=${ISOSHADE_FUZZ_SEED:-1}
fuzz=$top/build/sanitize/isoshade-fuzz
[ -x "$fuzz" ] || { skip fuzz "no program of the sanitizers is built, as make check does"; exit 0; }
export LSAN_OPTIONS=suppressions=$top/tests/leaks.supp:print_suppressions=0 OMP_NUM_THREADS=1
seeds=$top/tests/fuzz/seeds
reads_a_seed() { grep -qE ' seeds, +[1-9][0-9]* read .* mutations, ' <<<"$1"; } # else only refusals are looked at

for name in $("$fuzz" --list | cut -d' ' -f1 | grep -v planted); do
    if output=$("$fuzz" "$name" "$seeds/$name" "$count" "$seconds" "$seed" 2>&1); then
        echo "$output" | tail -n 1 >>figures
        ok "$name"
        check "${name}_reads_a_seed" reads_a_seed "$output"
    else
        not_ok "$name" "seed $seed: $(tail -n 12 <<<"$output" | cut -c1-300); the input: $(base64 -w 400 <"crash-$name" 2>/dev/null | head -n 1)"
    fi
done
# Within this process, without sanitizers: what ends the reader's program is counted, a broken contract is none of these.
release=$(dirname "$(readlink -f "$ISOSHADE")")/isoshade-fuzz
for of in arrays:hdf5 arrays:netcdf arrays:zarr itk:dicom itk:slices vdb:vdb; do
    name=${of#*:}
    [ -x "$release-${of%:*}" ] || { skip "${name}_in_process" "isoshade-fuzz-${of%:*} of the release is not built"; continue; }
    if output=$("$release-${of%:*}" "$name" "$seeds/$name" "$count" "$seconds" "$seed" 2>&1); then
        echo "$output" | tail -n 1 >>figures
        ok "${name}_in_process"
        check "${name}_in_process_reads_a_seed" reads_a_seed "$output"
    else
        not_ok "${name}_in_process" "seed $seed: $(tail -n 12 <<<"$output" | cut -c1-300)"
    fi
done
if [ -x "$release-vdb" ]; then
    echo '{"level": 9}' >nine.json && echo '{"level": 10}' >ten.json
    notice a_broken_contract_is_found_there_too "$release-vdb" planted nine.json
    check and_what_ends_the_reader_is_counted grep -q '^planted .* 1 inputs ended the reader' <("$release-vdb" planted ten.json)
    rm -f crash-planted
fi
[ ! -s figures ] || cat figures
mkdir none && echo '{"schema": 1}' >none/a.json
notice seeds_that_are_all_refused_are_found reads_a_seed "$("$fuzz" tf_json none 1000 1 "$seed" 2>&1)"
# Whose fault a report of the address sanitizer is: of the first line of its stack that is none of the sanitizer's.
. "$top/tests/fuzz/programs.sh"
report_of() { printf '==7==ERROR: AddressSanitizer: %s\n    #0 0x1  (/lib/libasan.so.8+0x1)\n    #1 0x2  (%s+0x2)\n    #2 0x3  (/bin/isoshade-fuzz-itk+0x3)\n' "$@"; }
report_of heap-use-after-free /bin/isoshade-fuzz-itk >ours.log
report_of heap-use-after-free /lib/libhdf5_serial.so.103 >theirs.log
report_of 'allocator is out of memory' /lib/libstdc++.so.6 >asked.log
check a_fault_in_code_of_ours_is_told is_ours ours.log
notice one_of_a_library_is_not is_ours theirs.log
notice nor_is_memory_that_cannot_be_had is_ours asked.log
# Each has seeds, and each seed is of one.
every_target_has_seeds() { diff <("$fuzz" --list | cut -d' ' -f1 | sort) <(cd "$seeds" && ls | sort); }
check every_reader_has_seeds every_target_has_seeds
# A fault that one value of one key shows.
notice a_planted_fault_is_found "$fuzz" planted "$seeds/planted" 20000 10 "$seed"
check and_its_input_is_kept grep -q '"level"' crash-planted
notice which_shows_it_again "$fuzz" planted crash-planted
# A campaign counts what was done, goes on with other seeds, and keeps what was found.
campaign() { FUZZ_OUT=$dir/fuzzed FUZZ_DRIVER=$fuzz FUZZ_PIECE=5 bash "$top/tests/fuzz/campaign.sh" "$@"; }
campaign 64 words >campaign.txt && campaign 128 words >campaign.txt
check a_campaign_goes_on_from_where_it_ended grep -q '^| words | 128 | [0-9]* | 0 | ' campaign.txt
check with_seeds_that_were_not_used test "$(cut -d' ' -f3 fuzzed/counts | sort -u | wc -l)" = 2
notice and_tells_what_it_found campaign 20000 planted
check which_it_keeps grep -q '"level"' fuzzed/planted-release-1
exit $failed
