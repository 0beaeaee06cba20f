#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# render --memory: the picture of a pyramid whose bricks are read when rays need them is that of the one in memory, bit for
# bit, whatever the memory, the threads and the type of the samples; and the memory is kept to.
. "$(dirname "$0")/lib.sh"
export OMP_NUM_THREADS=2
scene=$top/refscenes/solid.scene.json
equal() { "$ISOSHADE" compare "$1" "$2"; } # without limits only equal images agree
paged() { # NAME.iso IMAGE MB OPTIONS
    "$ISOSHADE" render "$1" -q --scene "$scene" --size 72x40 --memory "$3" -o "$2" "${@:4}"
}
whole() { "$ISOSHADE" render "$1" --scene "$scene" --size 72x40 --with cpu -o "$2" "${@:3}"; }

# Sizes that end within a brick, on a brick's last voxel and on its first.
"$ISOSHADE" make shells --size 49x48x47 --spacing 1x1.2x1 --type uint8 -o u8.nrrd -q || exit 1
"$ISOSHADE" make tubes --size 40x33x31 --type float -o f32.nrrd -q || exit 1
"$ISOSHADE" make balls --size 36x34x32 --type int16 -o i16.nrrd -q || exit 1
for v in u8 f32 i16; do
    "$ISOSHADE" build $v.nrrd -o $v.iso --levels 3 -q >/dev/null || exit 1
    whole $v.iso $v.exr >/dev/null
    check "${v}_in_pages_is_the_same_picture" paged $v.iso paged_$v.exr 3 --json
    check "${v}_to_the_last_bit" equal paged_$v.exr $v.exr
    # Of a volume, the bricks that rays look into are made from its samples.
    whole $v.nrrd made_$v.exr >/dev/null
    check "${v}_of_the_volume_too" equal made_$v.exr $v.exr
done
check one_thread_draws_it paged u8.iso one.exr 3 --threads 1
check the_same_bits_by_one_thread equal one.exr u8.exr

# A picture of many small pages: the same bricks are loaded again, and nothing changes.
"$ISOSHADE" make noise --size 130x120x60 --type uint8 -o n.nrrd -q && "$ISOSHADE" build n.nrrd -o n.iso --levels 2 -q >/dev/null || exit 1
whole n.iso n.exr >/dev/null
check much_memory paged n.iso much.exr 100 --json
"$ISOSHADE" render n.iso --scene "$scene" --size 72x40 --memory 100 -o much.exr --json >much.json
"$ISOSHADE" render n.iso --scene "$scene" --size 72x40 --memory 2.8 -o little.exr --json >little.json
check is_the_same_as_little equal much.exr little.exr
check and_as_all_of_it equal little.exr n.exr
holds little_memory_takes_more_passes "$(json_number little.json passes) > $(json_number much.json passes)"
holds memory_is_kept_to "$(json_number little.json memory_bytes) <= 2.8 * 1048576"
holds what_is_hidden_is_not_loaded "$(json_number much.json bricks_loaded) < .8 * $(json_number much.json bricks_of_level)"

# Coarse levels first.
check coarse_levels_come_first paged u8.iso refined.exr 3 --refine --png refined.png
for k in 1 2; do
    whole u8.iso level_$k.exr --level $k >/dev/null
    check "level_${k}_is_that_of_the_level" equal refined_level_$k.exr level_$k.exr
done
check the_last_one_has_the_name equal refined.exr u8.exr
has_files each_as_a_png . refined.png refined_level_1.png refined_level_2.png

# What the process takes, less what it takes for next to nothing: within the memory, where the whole level takes more.
if has_peak; then
    least=$(peak "$ISOSHADE" render u8.iso --level 2 --scene "$scene" --size 8 --memory 3 -o least.exr)
    holds the_process_keeps_to_it "$(peak "$ISOSHADE" render n.iso --scene "$scene" --size 72x40 --memory 3 -o p.exr) - $least < 3.5 * 1024"
    holds the_whole_level_would_not "$(peak "$ISOSHADE" render n.iso --scene "$scene" --size 72x40 --with cpu -o p.exr) - $least > 3 * 3.5 * 1024"
else
    skip the_process_keeps_to_it "no /usr/bin/time, or a build with sanitizers, whose memory is another"
fi

# Without --memory the free memory decides, here that of `ulimit -d`: a level that it does not hold is refused, and coarse
# ones are made without it.
if has_peak; then
    "$ISOSHADE" make shells --size 256x256x128 --type uint8 -o large.nrrd -q || exit 1
    large() { "$ISOSHADE" render large.nrrd --scene "$scene" --size 24 "$@" -q; }
    little() { (ulimit -d 64000 && large "$@"); }
    refuse what_does_not_fit_is_refused 6 "free; take --with cpu, a coarser --level" little --with reference -o no.exr
    check what_is_made_on_demand_fits little --with cpu -o little_0.exr
    check a_coarse_level_too little --with cpu --level 2 -o little_2.exr
    refuse but_not_all_levels 6 memory little --with cpu --level 2 --adapt -o no.exr
    large --with cpu -o large_0.exr >/dev/null && large --with cpu --level 2 -o large_2.exr >/dev/null || exit 1
    check the_same_picture equal little_0.exr large_0.exr
    check and_the_same_of_the_coarse_level equal little_2.exr large_2.exr
    notice which_is_another equal large_0.exr large_2.exr
fi

refuse too_little_says_what_is_needed 5 "this picture needs" "$ISOSHADE" render n.iso --scene "$scene" --size 72x40 --memory 1 -o no.exr
needed='s/.*needs \([0-9.]*\) MB: \([0-9.]*\) for empty space, \([0-9.]*\) for rays and the image, \([0-9.]*\) for 64 pages$/\1 - \2 - \3 - \4/p'
holds its_parts_are_the_sum "($(sed -n "$needed" err)) ^ 2 < 1e-6"
refuse no_memory_is_too_little 2 "--memory is 0" "$ISOSHADE" render n.iso --scene "$scene" --memory 0 -o no.exr
refuse a_pyramid_that_is_not_there 3 "nowhere.iso: cannot be opened: No such file" "$ISOSHADE" render nowhere.iso --scene "$scene" --memory 30 -o no.exr
refuse a_volume_has_no_pages 2 "isoshade build" "$ISOSHADE" render u8.nrrd --scene "$scene" --memory 10 -o no.exr
refuse another_renderer_has_none 2 "--with cpu" "$ISOSHADE" render u8.iso --scene "$scene" --with gl --memory 10 -o no.exr
refuse values_would_be_read 2 "tf suggest" "$ISOSHADE" render u8.iso --memory 10 -o no.exr
refuse refine_alone 2 "--memory" "$ISOSHADE" render u8.iso --scene "$scene" --refine -o no.exr
refuse a_level_that_is_not_there 5 "levels 0 to 2" "$ISOSHADE" render u8.iso --scene "$scene" --memory 10 --level 3 -o no.exr

# Planted: one voxel of a brick that is seen; a file that is cut; a header of another volume.
cp -r u8.iso other.iso
size=$(stat -c %s other.iso/level_0.nrrd)
printf '\377\377\377\377\377\377\377\377' | dd of=other.iso/level_0.nrrd bs=1 seek=$((size - 49 * 48 * 24 + 49 * 24 + 20)) conv=notrunc 2>/dev/null
check a_changed_voxel_is_drawn paged other.iso other.exr 3
notice and_seen equal other.exr u8.exr
truncate -s -100 other.iso/level_0_dir.nrrd
refuse a_cut_file_is_refused 4 "level_0_dir.nrrd" "$ISOSHADE" render other.iso --scene "$scene" --memory 10 -o no.exr
rm other.iso/level_0_dir.nrrd
refuse a_missing_file_too 3 "level_0_dir.nrrd" "$ISOSHADE" render other.iso --scene "$scene" --memory 10 -o no.exr
sed 's/NRRD0004/NRRD0005/' n.iso/level_1.nrrd >level_1.nrrd && cp level_1.nrrd n.iso/level_1.nrrd
refuse another_header_is_refused 4 "header" "$ISOSHADE" render n.iso --scene "$scene" --memory 10 --level 1 -o no.exr
exit $failed
