#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# A build in another folder gives the same bits: one object per rule is compiled there, and all that is installed is linked.
. "$(dirname "$0")/lib.sh"
unset MAKEFLAGS MFLAGS # of the make that runs the tests
export CCACHE_DISABLE=1 # a cache would give the object of this folder
there=$dir/another/folder
built=(isoshade libisoshade.so.* isoshade_openvdb.so isoshade_mpi.so isoshade-itk isoshade-arrays isoshade-vdb)
mkdir -p "$there/build/release"
cd "$top" || exit 1
cp -a Makefile src exporters "$there"
cp -a build/release/{src,exporters,flags,fortified,parts,libdir,exports.map} "$there/build/release" && cp -a build/readers "$there/build"
cd "$there/build" || exit 1
# In C, with an embedded text, with flags of its own, and in C++; those of the programs that read files.
some=(release/src/cli/main.o release/src/base/helper.o release/src/chart/page.o release/src/render/cpu/cast_avx2.o
    release/src/image/exr_codec.o readers/src/volume/child_main.o)
remove() { for object in "${some[@]}"; do rm -f "$object"; done; }
same() { # every file of a list is there, and equal
    local file count=0
    for file in "$@"; do
        [ -e "$top/build/$file" ] || continue
        cmp "$top/build/$file" "$there/build/$file" || return 1
        count=$((count + 1))
    done
    [ $count -gt 1 ]
}
remove
check it_is_built_there make -s -C "$there" SETUP=no config=release all
cd "$top/build/release" && built=("${built[@]}" libisoshade.so.*) && cd "$dir" || exit 1
check objects_are_equal same "${some[@]}"
check programs_and_libraries_are_equal same "${built[@]/#/release/}"
# Planted: paths of the folder in the objects.
cd "$there/build" && remove && cd "$dir" || exit 1
make -s -C "$there" SETUP=no config=release any_folder= all >/dev/null 2>&1
notice a_path_in_an_object_is_found same "${some[@]}"
notice and_in_a_program same release/isoshade release/isoshade-itk
exit $failed
