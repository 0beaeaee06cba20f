#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# doc/reference/formats-read.md: each row of its table is tested by files of another program, and each format has a row.
. "$(dirname "$0")/lib.sh"
page=$top/doc/reference/formats-read.md
python_with numpy,vtk
"$python" "$top/tests/formats_in.py" "$ISOSHADE" || failed=1

tests_of() { grep -E '^\|.*\| `[a-z_0-9]+`' "$1" | awk -F'|' '{print $6}' | grep -oE '[a-z_0-9]+' | sort -u; }
each_test_is_named() { diff <(tests_of "$1") <("$python" "$top/tests/formats_in.py" --list | sort -u); }
check the_page_names_all_tests each_test_is_named "$page"
"$ISOSHADE" list --json >list.json
formats_of() { grep -E '^\|.*\| `[a-z_0-9]+`' "$1" | awk -F'|' '{print $3}' | grep -oE '[a-z_0-9]+' | sort -u; }
formats() { python3 -c '
import json
for table in json.load(open("list.json"))["lists"]:
    if table["what"] == "volume format":
        for row in table["rows"]: print(row["name"])' | sort -u; }
each_format_is_there() { diff <(formats_of "$1") <(formats); }
check and_all_formats each_format_is_there "$page"
# Planted: a page without a row, and one with a test that is not there.
grep -v '`nifti`' "$page" >less.md
sed 's/`dicom`/`dicon`/' "$page" >other.md
notice a_missing_row_is_found each_format_is_there less.md
notice a_wrong_test_is_found each_test_is_named other.md

# Without ITK such files are refused by name.
cp "$ISOSHADE" alone
printf '\211PNG\r\n\032\n' >picture.png
refuse without_itk 7 'isoshade-itk, which is missing' ./alone info picture.png
printf '\211HDF\r\n\032\n' >file.h5
refuse without_hdf5 7 'isoshade-arrays, which is missing' ./alone info file.h5:a
"$ISOSHADE" make sphere --size 8 -o sphere.nrrd -q
refuse without_openvdb 7 'isoshade_openvdb.so' ./alone export sphere.nrrd --to vdb -o sphere.vdb
"$ISOSHADE" make noise --size 48 --gzip -q -o noise.nrrd
check more_packed_samples_than_are_read_at_once "$ISOSHADE" info noise.nrrd
refuse a_part_of_one_volume 2 'names none of several' ./alone info "$top/tests/formats/phantom.gipl:a"
exit $failed
