#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Pictures of other programs: each form of OpenEXR and PNG is read as its own program reads it; of files with several parts
# or layers one is chosen, and files of other kinds are refused by the name of their kind.
. "$(dirname "$0")/lib.sh"
python_with numpy,OpenImageIO,png
compare=("$ISOSHADE" compare)
shared=$(find "$(dirname "$(realpath "$ISOSHADE")")" -maxdepth 1 -name 'libisoshade.so.*' | head -n 1)
if ! "$python" -c 'import numpy, OpenImageIO, png' 2>/dev/null; then
    skip forms_of_pictures "python3-openimageio, python3-png or python3-numpy is not installed"
    exit $failed
elif [ -z "$shared" ]; then
    skip forms_of_pictures "this build has no shared library"
else
    "$python" "$top/tests/pictures_in.py" "$shared" || failed=1
fi

check files_of_parts_and_layers_are_written "$python" "$top/tests/pictures_of_parts.py"
refuse several_parts_need_a_choice 4 'parts.exr: has 2 parts, must be one; choose by --part: 1 "left", 2 "right"' "${compare[@]}" parts.exr left.exr
expect a_part_by_its_name 0 "${compare[@]}" parts.exr right.exr --part right
expect a_part_by_its_number 0 "${compare[@]}" left.exr parts.exr --part 1
expect the_other_part_differs 1 "${compare[@]}" parts.exr left.exr --part 2
refuse a_part_that_is_not_there 5 'has no part "middle"; its parts are 1 "left", 2 "right"' "${compare[@]}" parts.exr left.exr --part middle
refuse a_part_of_files_without_parts 2 'neither file has several parts' "${compare[@]}" left.exr left.exr --part left
refuse layers_need_a_choice 4 'choose by --layer: "ViewLayer.Combined", "ViewLayer.DiffCol"' "${compare[@]}" layers.exr left.exr
expect a_layer 0 "${compare[@]}" layers.exr left.exr --layer ViewLayer.Combined
expect another_layer 0 "${compare[@]}" right.exr layers.exr --layer ViewLayer.DiffCol
refuse a_layer_that_is_no_picture 5 'has no layer "ViewLayer.Depth"' "${compare[@]}" layers.exr left.exr --layer ViewLayer.Depth
refuse a_layer_of_files_without_layers 2 'neither file has layers' "${compare[@]}" left.exr left.exr --layer Combined
refuse channels_that_are_no_picture_are_named 4 'its channels are "Z"' "${compare[@]}" depth.exr left.exr
refuse deep_pictures_are_named 4 'deep.exr: is a deep OpenEXR picture' "${compare[@]}" deep.exr left.exr
# The matrix has 4 digits, halves 11 bits.
expect other_primaries_are_converted 0 "${compare[@]}" rec2020.exr rec709.exr --max-abs 1e-3
expect and_were_others 1 "${compare[@]}" rec2020.exr left.exr --max-abs 1e-2

# The first bytes of files of other kinds, under the name of a picture.
kind() { # NAME WORDS BYTES
    printf "$3" >other.exr
    refuse "$1" 4 "other.exr: is $2, must be OpenEXR, PNG or PPM of 16 bits" "${compare[@]}" other.exr left.exr
}
kind jpeg_is_named 'a JPEG picture' '\377\330\377\340\0\020JFIF\0'
kind tiff_is_named 'a TIFF picture' 'II*\0\010\0\0\0'
kind big_endian_tiff_is_named 'a TIFF picture' 'MM\0*\0\0\0\010'
kind radiance_is_named 'a Radiance HDR picture (RGBE)' '#?RADIANCE\n'
kind webp_is_named 'a WebP picture' 'RIFF\044\0\0\0WEBPVP8 '
kind pdf_is_named 'a PDF document' '%%PDF-1.7\n'
kind volumes_are_named 'a volume file (NRRD)' 'NRRD0004\n'
refuse folders_are_named 3 'is a folder' "${compare[@]}" . left.exr
: >other.exr
refuse empty_files_are_named 4 'other.exr: is empty' "${compare[@]}" other.exr left.exr
echo 'some words' >other.exr
refuse unknown_files_are_refused 4 'is no picture of a known kind' "${compare[@]}" other.exr left.exr
# The content counts: a PNG under another name, and alpha that only one file has.
"$ISOSHADE" make shells --size 20 -q -o v.nrrd
"$ISOSHADE" render v.nrrd --scene "$top/refscenes/shells.scene.json" --with cpu --size 12x11 -q -o clear.exr --png clear.png >/dev/null
mv clear.png png.exr
expect a_png_of_another_name_without_alpha 0 "${compare[@]}" clear.exr png.exr --max-abs 0.01
exit $failed
