# SPDX-License-Identifier: MIT
# programs.sh - sourced by the scripts beside it: what a reader's driver is called behind isoshade-fuzz. Readers that are
# programs of their own are called within a driver of theirs (in_process.cc).
driver_of() {
    case $1 in
    hdf5 | netcdf | zarr) echo -arrays ;;
    dicom | slices) echo -itk ;;
    vdb) echo -vdb ;;
    esac
}
# Is a report of the address sanitizer about code of ours? Its first line of the stack outside of the sanitizer and of the
# libraries of C and C++ is then in the driver. What is GDCM's and was compiled into it looks the same: a person has to say.
is_ours() {
    awk '/ERROR: AddressSanitizer/ { open = /allocator is out of memory/ ? 0 : 1 }
         open && /^ *#[0-9]/ && !/lib(asan|ubsan|stdc\+\+|c)\.so|ld-linux/ { if (/isoshade-fuzz-/) found = 1; open = 0 }
         END { exit !found }' "$1"
}
