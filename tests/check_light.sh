#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# A library or program that is missing costs its own feature, and the message names the Debian package; setup names number
# and size of the packages before it installs them.
. "$(dirname "$0")/lib.sh"
unset MAKEFLAGS MFLAGS # of the make that runs the tests
value() { make -s -C "$top" --eval 'value:;@echo $($(V))' V="$1" value; }

# A program as the packages of `make setup` give it: without OpenGL, and without modules next to it.
here=$(dirname "$(readlink -f "$ISOSHADE")")
check the_interface_without_opengl_is_complete gcc -std=c11 -Wall -Wextra -Werror -I"$top/src" -c "$top/src/render/no_gl.c" -o no_gl.o
mkdir bin
check it_takes_the_place_of_the_ray_caster gcc -fopenmp -o bin/isoshade "$here/src/cli/main.o" no_gl.o \
    "$here/libcommands.a" "$here/libisoshade.a" $(value LDLIBS)
check nothing_of_the_ray_caster_is_left test -z "$(nm bin/isoshade | grep epoxy_)"
light=$dir/bin/isoshade
"$light" make shells --size 12 -q -o s.nrrd
check a_first_picture_needs_none_of_them "$light" render s.nrrd --size 32 -q -o a.png
refuse opengl_names_its_packages 7 'libepoxy-dev, libegl-dev' "$light" render s.nrrd --size 32 --with gl -q -o b.png
refuse openvdb_names_its_packages 7 'libopenvdb-dev and libnanovdb-dev' "$light" export s.nrrd --to vdb -q -o s.vdb
printf 'CDF\001\0\0\0\0' >s.nc
refuse netcdf_names_its_package 7 libnetcdf-dev "$light" info s.nc
head -c 200 /dev/zero >s.dcm && printf DICM | dd of=s.dcm bs=1 seek=128 conv=notrunc status=none
refuse dicom_names_its_package 7 libinsighttoolkit5-dev "$light" info s.dcm
empty() { env -u ISOSHADE_GNUPLOT -u ISOSHADE_POVRAY -u ISOSHADE_BLENDER PATH="$dir/bin" "$light" "$@" -q; }
refuse gnuplot_names_its_package 7 'package gnuplot-nox' empty info s.nrrd --histogram h.png
refuse povray_names_its_package 7 'package povray' empty render s.nrrd --with povray --size 8 -o p.png
refuse blender_names_its_package 7 'package blender' empty render s.nrrd --with cycles --size 8 -o c.png

# A program built with OpenGL on a system without libEGL.so.1, which the preloaded dlopen() does not find.
cat >hidden.c <<'C'
#define _GNU_SOURCE
#include <dlfcn.h>
#include <string.h>
void *dlopen(const char *name, int flags)
{
    void *(*next)(const char *, int) = (void *(*)(const char *, int))dlsym(RTLD_NEXT, "dlopen");
    return name && strstr(name, "libEGL") ? NULL : next(name, flags);
}
C
gcc -shared -fPIC hidden.c -o hidden.so
check a_first_picture_needs_no_libegl env LD_PRELOAD="$dir/hidden.so" "$ISOSHADE" render s.nrrd --size 32 -q -o d.png
refuse libegl_names_its_package 7 'package libegl1' env LD_PRELOAD="$dir/hidden.so" "$ISOSHADE" render s.nrrd --with gl -q -o e.png

# setup, with an apt-get and a dpkg-query of the test.
mkdir fakes build
printf '#!/bin/sh\n[ "$4" = libpng-dev ] && echo "install ok installed"\n' >fakes/dpkg-query
cat >fakes/apt-get <<'FAKE'
#!/bin/sh
echo "$*" >>calls
case "$*" in
*' -s') printf 'Inst a\nInst b\nInst c\nConf c\n' ;;
*--print-uris) printf "'u' a 1500000 h\n'u' b 2000000 h\n" ;;
*Status-Fd*) echo dlstatus:1:50.5:fetching; echo words; echo pmstatus:b:75:unpacking; [ ! -e broken ] ;;
esac
FAKE
chmod +x fakes/*
printf '#!/bin/sh\necho 0\n' >fakes/id && chmod +x fakes/id
setup() { PATH=$dir/fakes:$PATH sh "$top/tests/install-packages.sh" "$@"; }
expect packages_are_installed 0 setup libpng-dev libtiff-dev
check their_number_and_size_come_first grep -qx '.*: 3 packages, 4 MB to fetch' <(sed -n 2p out)
check then_progress test "$(sed -n '3,$p' out | tr '\n' ' ')" = 'fetched 50 % installed 70 % '
check only_missing_ones_are_named grep -q ': libtiff-dev$' out
check other_lines_go_to_the_log grep -qx words build/apt.log
touch broken
expect a_failure_is_reported 1 setup libtiff-dev
check by_name grep -qx 'apt-get could not install: libtiff-dev' err
rm calls
expect packages_that_are_there_need_nothing 0 setup libpng-dev
check not_even_a_call test ! -e calls

# The lists: each contains the one before, and the first has nothing that a first picture does not need.
lists() { value "$1" | tr ' ' '\n' | sort -u; }
check demo_has_the_first_list test -z "$(comm -23 <(lists packages) <(lists demo_packages))"
check and_check_that_of_demo test -z "$(comm -23 <(lists demo_packages) <(lists check_packages))"
check the_first_list_is_short test "$(lists packages | wc -l)" -le 20
exit $failed
