#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Each format is tested by files of another program, and has a row in the table of doc/reference/formats-read.md.
. "$(dirname "$0")/lib.sh"
page=$top/doc/reference/formats-read.md
python_with numpy,vtk
"$python" "$top/tests/formats_in.py" "$ISOSHADE" || failed=1

# The tests of each format; a test has files of another program.
tests_of_formats="nrrd: nrrd matrix_nrrd
nifti: nifti matrix_nifti
itk: dicom dicom_rescaled dicom_tilted_gantry dicom_mixed_series dicom_damaged dicom_of_a_length dicom_of_another_vr
itk: dicom_left_out dicom_uneven dicom_forms dicom_values dicom_faults dicom_multiframe dicom_spacings
itk: dicom_colors dicom_palettes dicom_segments dicom_mosaic
itk: png_stack pictures_of_colors missing_number tiff_and_jpeg_stacks
metaimage: metaimage
vtk: vtk_legacy
vti: vti matrix_vti vti_packers vtk_rectilinear
pvti: parallel_image parallel_rectilinear
mgh: mgh
fits: fits
dx: opendx
vasp: vasp
mif: mrtrix
afni: afni
tiff: tiff tiff_imagej tiff_ome matrix_tiff
mrc: mrc matrix_mrc matrix_packed
cube: cube
xsf: xsf
npy: matrix_npy
npz: npz
gipl: gipl
hdf5: vtkhdf hdf5 hdf5_without_end imaris minc
netcdf: netcdf netcdf_headers numbers
zarr: ome_zarr matrix_zarr matrix_zarr3
vdb: openvdb openvdb_of_isoshade
raw: raw"
"$ISOSHADE" list --json >list.json
formats() { python3 -c '
import json
for table in json.load(open("list.json"))["lists"]:
    if table["what"] == "volume format":
        for row in table["rows"]: print(row["name"])' | sort -u; }
each_format_has_tests() { diff <(cut -d: -f1 <<<"$1" | sort -u) <(formats); }
each_test_has_a_format() { diff <(sed 's/.*: //' <<<"$1" | tr ' ' '\n' | sort) <("$python" "$top/tests/formats_in.py" --list | sort); }
check all_formats_have_tests each_format_has_tests "$tests_of_formats"
check and_all_tests_a_format each_test_has_a_format "$tests_of_formats"
formats_of() { grep -E '^\|.*\| `[a-z_0-9]+`' "$1" | awk -F'|' '{print $3}' | grep -oE '[a-z_0-9]+' | sort -u; }
each_format_is_there() { diff <(formats_of "$1") <(formats); }
check the_page_has_all_formats each_format_is_there "$page"
# Planted: a page without a row, a format without tests, and a test that is not there.
grep -v '`nifti`' "$page" >less.md
notice a_missing_row_is_found each_format_is_there less.md
notice a_format_without_tests_is_found each_format_has_tests "$(grep -v '^gipl:' <<<"$tests_of_formats")"
notice a_wrong_test_is_found each_test_has_a_format "${tests_of_formats/xsf: xsf/xsf: xfs}"

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
