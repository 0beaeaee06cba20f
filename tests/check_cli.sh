#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# The command line: help by either word order, guesses for mistyped words, limits and endings that all commands share.
. "$(dirname "$0")/lib.sh"

"$ISOSHADE" make shells --size 12 -o v.nrrd -q && "$ISOSHADE" build v.nrrd --levels 1 -o one.iso -q >out
same() { diff <("$ISOSHADE" $1) <("$ISOSHADE" $2); }
check help_of_a_command same "help render" "render --help"
check help_of_a_benchmark same "help bench build" "bench build --help"
check help_alone same help --help
notice another_help same "help render" "help export"
refuse help_of_no_command 2 'unknown command "nothing"; isoshade --help' "$ISOSHADE" help nothing

while IFS='|' read -r name words command; do
    refuse "$name" 2 "$words" "$ISOSHADE" $command
done <<'END'
a_mistyped_command|unknown command "rendr" (did you mean render?); isoshade|rendr v.nrrd
a_mistyped_option|--scne: unknown option (did you mean --scene?)|render v.nrrd --scne x -o x.png
an_option_with_a_value|(did you mean --levels?)|build v.nrrd --leves=2 -o x.iso
a_mistyped_benchmark|unknown benchmark "biuld" (did you mean build?)|bench biuld
a_mistyped_action|unknown action "adpt" (did you mean adapt?), must be one of: adapt, bound|tf adpt v.nrrd
a_mistyped_preset|"simulatoin" (did you mean simulation?)|render v.nrrd --tf simulatoin -o x.png
a_mistyped_target|unknown export target "vbd" (did you mean vdb?), must be one of: vdb|export v.nrrd --to vbd -o x.vdb
no_guess_for_another_word|unknown command "nothing"; isoshade|nothing
no_target|isoshade export: --to is missing: vdb, nanovdb, blender, povray, pbrt or paraview|export v.nrrd -o x.vdb
vdb_named_blend|x.blend: the name for --to vdb must end in .vdb|export v.nrrd --to vdb -o x.blend
nanovdb_named_vdb|x.vdb: the name for --to nanovdb must end in .nvdb|export v.nrrd --to nanovdb -o x.vdb
a_folder_named_blend|x.blend: ends in .blend as for --to blender|export v.nrrd --to povray -o x.blend
END

# One exit code for too many levels.
for command in "build -o x.iso" "bench build" "export --to vdb -o x.vdb" "view -o x.html" "validate -o x" "chart -o x" plan \
    "figure -o x" "figure --kind grid -o x" "scenes --write x" "tf adapt -o x" "tf bound"; do
    set -- $command
    [ "$1" = tf ] && first="$1 $2" || first=$1
    [ "$command" = "bench build" ] && first=$command volume= || volume=v.nrrd
    refuse "levels_of_${command//[^a-z]/_}" 2 "--levels is 40, must be" "$ISOSHADE" $first $volume ${command#"$first"} --levels 40
done

# One is singular.
"$ISOSHADE" plan v.nrrd --tf simulation --size 16 --brick 4 --levels 1 -q >plan.txt
check one_view grep -q '; 1 view, ' plan.txt
"$ISOSHADE" view one.iso -o one.html >view.txt 2>err
check one_level grep -q ': level 0, the finest' view.txt
refuse one_level_in_errors 5 "level 3: the pyramid has level 0 alone" "$ISOSHADE" render one.iso --level 3 -o x.png
check make_help_has_no_variable bash -c "! make -s -C '$top' help | grep -F '\$('"
exit $failed
