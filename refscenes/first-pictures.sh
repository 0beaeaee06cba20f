#!/bin/sh
# SPDX-License-Identifier: MIT
# First pictures of volumes of each preset's kind (doc/results/first-pictures.md says where they are from).
#   sh refscenes/first-pictures.sh VOLUMES FOLDER [SIZE]      pictures of SIZE x SIZE (256) in FOLDER
# A line each: what the preset was tuned on, or only reported; the shares of the voxels and of the picture that are visible.
set -eu
isoshade=${ISOSHADE:-$(cd "$(dirname "$0")/.." && pwd)/isoshade}
volumes=$1 out=$2 size=${3:-256}
mkdir -p "$out"
draw() { # HALF PRESET VOLUME OPTIONS
    half=$1 preset=$2 volume=$3
    shift 3
    [ -e "$volumes/$volume" ] || { echo "$half  $preset  $volume  is not there"; return; }
    picture="$out/$half-$preset-$(echo "$volume" | tr '/.' '--').png"
    shown=$("$isoshade" render "$volumes/$volume" --tf "$preset" --size "$size" -q --json -o "$picture" "$@" |
        tr -d ' \n' | sed 's/.*"visible":{\([^}]*\)}.*/\1/; s/"//g; s/,/ /g')
    echo "$half  $preset  $volume  $shown"
}
draw tuned ct-bone cranium_ct_hu.nrrd
draw tuned ct-soft-tissue cranium_ct_hu.nrrd
draw tuned ct-soft-tissue lung
draw tuned ct-lung lung
draw tuned ct-vessels CT_AVM.nii.gz
draw tuned angiography aneurism_256.nrrd
draw tuned microscopy cells/c1.tif --spacing 0.000065x0.000065x0.00029
draw tuned orbital cn9-homo.cube
draw tuned simulation heptane_302.nrrd
draw reported ct-bone Iguana.nii.gz
draw reported ct-bone CT_pitch.nii.gz
draw reported ct-bone lung2
draw reported ct-soft-tissue lung2
draw reported ct-lung lung2
draw reported ct-vessels aneurism_256.nrrd
draw reported angiography chris_MRA.nii.gz --view top
draw reported angiography CT_AVM.nii.gz
draw reported microscopy cells/c2.tif --spacing 0.000065x0.000065x0.00029
draw reported microscopy cells/c0.tif --spacing 0.000065x0.000065x0.00029
draw reported microscopy Bead_Image1_crop.tif
draw reported orbital d-only.cube
draw reported orbital f-only.cube
draw reported orbital hydrogen.vti
draw reported simulation fuel_crop.nrrd
draw reported simulation isabel_30.vti
draw reported simulation carotid.vtk
draw reported auto lung
draw reported auto lung2
