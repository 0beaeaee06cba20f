#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Builds in two folders give the same bits with REPRODUCIBLE=yes: one object per rule is compiled in each, and programs and
# libraries are linked with it.
. "$(dirname "$0")/lib.sh"
unset MAKEFLAGS MFLAGS # of the make that runs the tests
export CCACHE_DISABLE=1 # a cache would give the object of the other folder
# In C, with an embedded text, with flags of its own, and in C++; those of the programs that read files.
objects=(release/src/cli/main.o release/src/base/helper.o release/src/chart/page.o release/src/encode/decode_float.o
    release/src/image/exr_codec.o readers/src/volume/child_main.o)
cd "$top" || exit 1
linked=(release/isoshade $(cd build && ls release/libisoshade.so.* release/isoshade_*.so release/isoshade-{itk,arrays,vdb}))
build_in() { # FOLDER VALUE TARGET
    mkdir -p "$1/build/release" && cp -a Makefile src exporters "$1" && cp -a build/readers "$1/build" &&
        cp -a build/release/{src,exporters,flags,fortified,parts,libdir,exports.map} "$1/build/release" &&
        (cd "$1/build" && rm -f "${objects[@]}") && make -s -C "$1" SETUP=no config=release REPRODUCIBLE="$2" all
}
same() { # FILE ...: equal in both folders
    local file
    for file; do cmp "$dir/one/build/$file" "$dir/another/folder/build/$file" || return 1; done
}
check it_is_built_in_a_folder build_in "$dir/one" yes all
check and_in_another build_in "$dir/another/folder" yes all
check objects_are_equal same "${objects[@]}"
check programs_and_libraries_are_equal same "${linked[@]}"
rm -rf "$dir/another"
check it_is_built_with_its_path build_in "$dir/another/folder" '' build/release/isoshade
notice a_path_in_an_object_is_found same release/src/cli/main.o
notice and_in_a_program same release/isoshade
exit $failed
