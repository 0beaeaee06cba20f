#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# The programs of a release have random addresses, no table of functions that can be written once they run,
# and measure copies where they read what others wrote.
. "$(dirname "$0")/lib.sh"
here=$(dirname "$(readlink -f "$ISOSHADE")")
has_random_addresses() { readelf -hW "$1" | grep -q 'Type: *DYN (Position-Independent'; }
has_tables_that_stay() { readelf -lW "$1" | grep -q GNU_RELRO && readelf -dW "$1" | grep -qE 'BIND_NOW|FLAGS.*NOW'; }
has_no_code_on_the_stack() { readelf -lW "$1" | grep -qE 'GNU_STACK.* RW  *0x'; }
has_copies_that_are_measured() { readelf --dyn-syms -W "$1" | grep -qE '__(mem|str|sn?printf|vsn?printf|read|fread)[a-z]*_chk'; }
for program in isoshade isoshade-itk isoshade-arrays isoshade-vdb; do
    [ -x "$here/$program" ] || continue
    check "${program}_has_random_addresses" has_random_addresses "$here/$program"
    check "${program}_has_tables_that_stay" has_tables_that_stay "$here/$program"
    check "${program}_has_no_code_on_the_stack" has_no_code_on_the_stack "$here/$program"
done
check isoshade_has_copies_that_are_measured has_copies_that_are_measured "$here/isoshade"
for library in "$here"/libisoshade.so.* "$here/isoshade_openvdb.so"; do
    [ ! -f "$library" ] || check "$(basename "$library")_has_tables_that_stay" has_tables_that_stay "$library"
done
# Planted: a program without.
echo 'int main(void) { return 0; }' >plain.c
gcc -no-pie -Wl,-z,norelro,-z,lazy,-z,execstack -o plain plain.c 2>/dev/null
notice fixed_addresses_are_seen has_random_addresses ./plain
notice tables_that_can_be_written_are_seen has_tables_that_stay ./plain
notice code_on_the_stack_is_seen has_no_code_on_the_stack ./plain
notice copies_that_nobody_measures_are_seen has_copies_that_are_measured ./plain
exit $failed
