#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# What outputs say of where they came from: a name is planted in folders, in a DICOM header and in a NRRD header, and looked
# for in every kind of output.
. "$(dirname "$0")/lib.sh"
python_with numpy,pydicom
mkdir -p PLANTED_NAME/in
plant=$dir/PLANTED_NAME
cp "$top"/refscenes/shells.{scene,tf}.json "$plant/"
cp "$plant/shells.scene.json" "$plant/itsscene.scene.json"
export HOME=$plant/home # Blender's file browsers stand there
mkdir "$HOME"
"$ISOSHADE" make shells --size 12x14x10 -o "$plant/s.nrrd" -q >/dev/null
sed -i '1,3s/^type:/content: PLANTED_NAME\npatient:=PLANTED_NAME\n&/' "$plant/s.nrrd"
PYTHONPATH=$top/tests "$python" - "$plant/in" 2>dicom.log <<'END'
import sys
import numpy as np
import pydicom
from formats_medical import dicom_slice
for k in range(4):
    path = f"{sys.argv[1]}/{k}.dcm"
    dicom_slice(path, np.arange(80, dtype="<i2").reshape(10, 8) + 30 * k, np.array([0, 0, 2. * k]), "1.2.3.4", k + 1, "PLANTED_NAME")
    d = pydicom.dcmread(path)
    d.PatientName = d.PatientID = d.InstitutionName = d.StudyDescription = d.OperatorsName = "PLANTED_NAME"
    d.save_as(path)
END
cp "$plant/s.nrrd" "$plant/t.nrrd"
S="--scene $plant/itsscene.scene.json"

# outputs OPTION...: every kind of output under made; the terminal may name files as they were given.
outputs() {
    rm -rf made && mkdir made
    local all=("$@")
    run() { "$ISOSHADE" "$@" -q "${all[@]}" >>log 2>&1 || echo "$?: $*" >>failures; }
    : >failures
    run build "$plant/s.nrrd" -o "$dir/made/s.iso" --levels 2
    run build "$plant/in" -o "$dir/made/d.iso"
    run build "$plant/s.nrrd" -o "$dir/made/for.iso" --levels 2 --effort fast --for "$plant/itsscene.scene.json"
    run render "$plant/s.nrrd" $S --with gl --size 8 -o "$dir/made/p.exr" --png "$dir/made/p.png"
    run export "$plant/s.nrrd" $S --to vdb -o "$dir/made/e.vdb"
    run export "$plant/s.nrrd" $S --to vdb --bake density,Cd -o "$dir/made/baked.vdb"
    run export "$plant/s.nrrd" $S --to povray -o "$dir/made/pov"
    if has_cycles; then
        run export "$plant/s.nrrd" $S --to blender -o "$dir/made/b.blend"
        run export "$plant/s.nrrd" $S --to blender --add "$plant/t.nrrd" -o "$dir/made/two.blend"
    fi
    for to in pbrt paraview; do run export "$plant/s.nrrd" $S --to $to -o "$dir/made/$to"; done
    run view "$plant/s.nrrd" $S -o "$dir/made/v.html"
    run plan "$plant/s.nrrd" $S -o "$dir/made/plan.json"
    run chart "$plant/s.nrrd" $S --size 8 --budget 0.5 -o "$dir/made/c"
    run palette "$plant/s.nrrd" --entries 8 -o "$dir/made/p.inc" -o "$dir/made/p.py" -o "$dir/made/palette.exr" -o "$dir/made/p.csv"
    run scenes "$plant/s.nrrd" --tf ct-bone --view front --size 32 -o "$dir/made/sheet.svg"
    run tf suggest "$plant/s.nrrd" -o "$dir/made/t.tf.json"
    run tf adapt "$plant/s.nrrd" --tf "$plant/shells.tf.json" -o "$dir/made/a.tf.json"
    "$ISOSHADE" validate "$plant/s.nrrd" $S --with gl --quick --size 12 --levels 2 --level-size 32 --anyway -o "$dir/made/r" --junit "$dir/made/j.xml" -q "$@" >>log 2>&1
    [ -f made/r/report.json ] || echo "no report" >>failures
    run figure "$dir/made/r" -o "$dir/made/f"
    run report diff "$dir/made/accepted.json" "$dir/made/r" --accept
}
all_made() { [ ! -s failures ] && ok "$1" || not_ok "$1" "$(cat failures; tail -n 3 log)"; }
holding() { grep -rlaE "$1" made | sort; }
# nothing_holds NAME PATTERN
nothing_holds() {
    local found
    found=$(holding "$2")
    [ -z "$found" ] && ok "$1" || not_ok "$1" "$(tr '\n' ' ' <<<"$found")"
}

outputs
all_made all_outputs_are_made
nothing_holds folders_and_headers_are_left_out PLANTED_NAME
check the_machine_is_not_named grep -q 'hostname="localhost"' made/j.xml
if has_cycles; then check names_are_kept_b.blend grep -qa 's\.nrrd' made/b.blend; else skip blend_files "$lack"; fi
for f in p.exr r/report.json r/index.html j.xml s.iso/pyramid.json e.vdb baked.vdb plan.json c/chart.json c/pareto.csv sheet.json p.inc; do
    check "names_are_kept_$f" grep -qa 's\.nrrd' "made/$f"
done

# The search above can find them.
expect build_with_paths 0 "$ISOSHADE" build "$plant/s.nrrd" -o full.iso --full-paths -q
check paths_are_kept_in_a_pyramid grep -q "$plant/s\.nrrd" full.iso/pyramid.json
expect render_with_paths 0 "$ISOSHADE" render "$plant/s.nrrd" $S --with gl --size 8 -o full.exr --full-paths -q
check paths_are_kept_in_a_picture grep -qa "$plant/s\.nrrd" full.exr

# What a program of somebody else prints, and an error that quotes it.
printf '%s\n' "open('$plant/none')" >"$plant/bad.py"
echo '{"schema": "isoshade.renderers/1", "renderers": [{"name": "bad", "command": ["python3", "bad.py"], "tier": "samples"}]}' >"$plant/renderers.json"
rm -rf made && mkdir made
expect a_program_that_names_folders 9 "$ISOSHADE" validate "$plant/s.nrrd" $S --with bad --renderers "$plant/renderers.json" --quick --size 12 --levels 1 --anyway -o "$dir/made/bad" -q
check its_words_are_in_the_report grep -q "No such file or directory: 'none'" made/bad/report.json
nothing_holds but_not_the_folders PLANTED_NAME

outputs --no-provenance
all_made all_outputs_without_provenance_are_made
nothing_holds no_provenance_leaves_the_name_out '\b[st]\.nrrd|itsscene|shells\.tf|PLANTED_NAME'
check nor_is_it_in_a_name_of_a_file test -z "$(find made -name '*itsscene*' -o -name '*_s.vdb' -o -name '*_t.vdb')"
nothing_holds no_provenance_leaves_the_command_out 'isoshade (validate|export|build|chart|plan|palette|render) [^`]*-o'
refuse both_at_once 2 "exclude each other" "$ISOSHADE" build "$plant/s.nrrd" -o x.iso --full-paths --no-provenance
exit $failed
