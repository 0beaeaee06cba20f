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
