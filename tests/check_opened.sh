#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# An exported .blend as a person opens it, and that what a person changed in it is not overwritten.
. "$(dirname "$0")/lib.sh"
has_cycles || { skip opened "no Blender"; exit $failed; }
"$ISOSHADE" make shells --size 21x30x17 -q -o v.nrrd || exit 1
scene=$top/refscenes/shells.scene.json
export_it() { "$ISOSHADE" export v.nrrd --to blender --scene "$scene" --levels 2 -q -o "$@"; }
check it_is_written export_it one.blend
mkdir moved && cp one* moved
blender=${ISOSHADE_BLENDER:-blender}
"$blender" -b moved/one.blend -P "$top/tests/opened.py" -- one >out 2>&1
count=0
while read -r _ name answer; do
    count=$((count + 1))
    check "$name" test "$answer" = yes
done < <(grep '^opened: ' out)
check all_was_asked test $count = 16 || tail -5 out
refuse a_file_that_was_saved_since_stays 3 'moved/one.blend: was saved or changed since' export_it moved/one.blend
refuse at_once_and_not_after_the_work 3 'one.blend: was saved' "$ISOSHADE" export none.nrrd --to blender -q -o moved/one.blend
cp moved/one.blend saved.blend
check force_overwrites_it export_it moved/one.blend --force
check and_keeps_it_beside_the_backup_of_blender cmp saved.blend moved/one.blend2
cp one.blend copy.blend
check an_unchanged_copy_is_overwritten export_it copy.blend
printf x | dd of=one.blend bs=1 seek=5000 conv=notrunc 2>/dev/null
refuse a_changed_byte_is_seen 3 'one.blend: was saved or changed since' export_it one.blend
echo notes >other.blend
refuse and_a_file_from_elsewhere 3 'or is not from isoshade' export_it other.blend
exit $failed
