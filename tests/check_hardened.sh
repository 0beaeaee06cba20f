#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# The programs and libraries of a release have PIE (ASLR), full RELRO, no executable stack, and _FORTIFY_SOURCE.
. "$(dirname "$0")/lib.sh"
here=$(dirname "$(readlink -f "$ISOSHADE")")
has_random_addresses() { readelf -hW "$1" | grep -q 'Type: *DYN (Position-Independent'; }
has_tables_that_stay() { readelf -lW "$1" | grep -q GNU_RELRO && readelf -dW "$1" | grep -qE 'BIND_NOW|FLAGS.*NOW'; }
has_no_code_on_the_stack() { readelf -lW "$1" | grep -qE 'GNU_STACK.* RW  *0x'; }
# Where one file that prints were compiled without _FORTIFY_SOURCE, it would do so by the plain functions.
has_texts_that_are_measured() { ! readelf --dyn-syms -W "$1" | grep -qE 'UND v?f?printf(@|$)'; }
has_copies_that_are_measured() { readelf --dyn-syms -W "$1" | grep -qE '__(mem|str|sn?printf|vsn?printf|read|fread)[a-z]*_chk'; }
for program in isoshade isoshade-itk isoshade-arrays isoshade-vdb; do
    [ -x "$here/$program" ] || continue
    check "${program}_has_random_addresses" has_random_addresses "$here/$program"
    check "${program}_has_tables_that_stay" has_tables_that_stay "$here/$program"
    check "${program}_has_no_code_on_the_stack" has_no_code_on_the_stack "$here/$program"
    check "${program}_has_texts_that_are_measured" has_texts_that_are_measured "$here/$program"
done
for library in "$here"/libisoshade.so.* "$here"/isoshade_{openvdb,mpi}.so; do
    [ -f "$library" ] || continue
    check "$(basename "$library")_has_texts_that_are_measured" has_texts_that_are_measured "$library"
    check "$(basename "$library")_has_tables_that_stay" has_tables_that_stay "$library"
done
for measured in "$here/isoshade" "$here"/libisoshade.so.*; do
    [ ! -f "$measured" ] || check "$(basename "$measured")_has_copies_that_are_measured" has_copies_that_are_measured "$measured"
done
# Planted: a program without.
printf '#include <stdio.h>\nint main(int n, char **w) { return printf("%%d %%s", n, w[0]); }\n' >plain.c
gcc -no-pie -Wl,-z,norelro,-z,lazy,-z,execstack -o plain plain.c 2>/dev/null
notice fixed_addresses_are_seen has_random_addresses ./plain
notice tables_that_can_be_written_are_seen has_tables_that_stay ./plain
notice code_on_the_stack_is_seen has_no_code_on_the_stack ./plain
notice copies_without_a_check_are_seen has_copies_that_are_measured ./plain
notice texts_without_a_check_are_seen has_texts_that_are_measured ./plain
exit $failed
