#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# The add-on of Blender: it is packed, installed and enabled, and each of its buttons does its work (addon_buttons.py).
# Its versions are the header's, and its fit of stops is that of exporters/blender/ramp.c.
. "$(dirname "$0")/lib.sh"
zip=$dir/isoshade.zip
version=$("$ISOSHADE" --version | cut -d' ' -f2)
addon=$top/exporters/blender/addon

check the_manifest_has_the_version grep -q "^version = \"$version\"\$" "$addon/blender_manifest.toml"
check and_so_have_older_blenders grep -qF "\"version\": (${version//./, })," "$addon/__init__.py"
unset MAKEFLAGS MFLAGS # of the make that runs the tests
expect it_is_packed 0 make -s -C "$top" SETUP=no build="$dir/packed" addon
cp "$dir/packed/isoshade-blender-addon.zip" "$zip" || exit 1
python3 -m zipfile -l "$zip" >listed
check with_its_licenses_and_manifest test 4 = \
    "$(grep -cE 'isoshade_addon/(LICENSE|COPYING|blender_manifest.toml|__init__.py) ' listed)"
# Who packs it later gets the same bytes: no time of today is in it.
check without_a_time_of_packing test "$(grep -c '1980-01-01 00:00:00' listed)" = "$(($(wc -l <listed) - 1))"

# No file of it runs what it reads, and no command goes through a shell.
runs() { grep -nE '\<(eval|exec|__import__)\(|shell *= *True|os\.system|\<pickle\>' "$1"/*.py; }
check nothing_read_is_run test -z "$(runs "$addon")"
mkdir planted && echo 'subprocess.run(command, shell=True)' >planted/x.py
check a_planted_shell_is_seen test -n "$(runs planted)"

has_cycles || { skip all_buttons_are_pressed "$lack"; exit $failed; }
"$ISOSHADE" make shells --size 14 -q -o s.nrrd || exit 1
mkdir -p user/scripts user/config user/extensions
BLENDER_USER_RESOURCES=$dir/user BLENDER_USER_SCRIPTS=$dir/user/scripts BLENDER_USER_CONFIG=$dir/user/config \
    BLENDER_USER_EXTENSIONS=$dir/user/extensions \
    "${ISOSHADE_BLENDER:-blender}" -b --factory-startup -noaudio --python-exit-code 9 -P "$top/tests/addon_buttons.py" -- "$zip" \
    "$ISOSHADE" "$dir/s.nrrd" "$top/refscenes/shells.scene.json" "$top/refscenes/shells.tf.json" "$dir" >said 2>&1
code=$?
grep -E '^(not )?ok ' said
grep -q '^not ok ' said && failed=1
[ $code = 0 ] && grep -q '^ok a_second_one_comes_into_this_scene' said && ok all_buttons_are_pressed ||
    not_ok all_buttons_are_pressed "exit code $code: $(tail -n 3 said | tr '\n' ' ')"
exit $failed
