#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# make install: what it puts under PREFIX is found, used and removed again; the library exports its interface alone.
. "$(dirname "$0")/lib.sh"
unset MAKEFLAGS MFLAGS # of the make that runs the tests
to=$dir/stage/opt/iso
make_it() { make -s -C "$top" SETUP=no config=release PREFIX=/opt/iso DESTDIR="$dir/stage" "$@"; }
expect it_is_installed 0 make_it install
[ $failed = 0 ] || exit 1
lib=$to/lib/libisoshade.so
version=$("$ISOSHADE" --version | cut -d' ' -f2)

check both_licenses_are_there test -s "$to/share/doc/isoshade/LICENSE" -a -s "$to/share/doc/isoshade/COPYING"
check the_program_runs "$to/bin/isoshade" --version
check the_soname_is_the_major_version test "$(objdump -p "$lib" | sed -n 's/^ *SONAME *//p')" = "libisoshade.so.${version%%.*}"
check and_leads_to_the_library test -e "$to/lib/libisoshade.so.${version%%.*}" -a -f "$to/lib/libisoshade.so.$version"
exports() { nm -D --defined-only "$1" | awk '{print $3}' | sed 's/@.*//' | grep -v '^ISOSHADE_'; }
foreign() { exports "$1" | grep -vE '^iso_'; }
check the_library_exports_functions_of_ours test "$(exports "$lib" | grep -c '^iso_')" -ge 1
check and_nothing_else test -z "$(foreign "$lib")"
declared() { grep -oE '\<iso_[a-z0-9_]+\(' "$1" | tr -d '(' | sort -u; }
check each_function_of_the_header_is_there test "$(declared "$to/include/isoshade.h")" = "$(exports "$lib" | grep '^iso_' | sort -u)"
printf 'int iso_x; int planted;\n' >planted.c && cc -shared -fPIC -o planted.so planted.c
check a_planted_symbol_is_seen test "$(foreign planted.so)" = planted

# Programs in C and in C++ against what is installed alone, by pkg-config as their makefiles would.
cat >user.c <<'END'
#include <isoshade.h>
#include <stdio.h>
#include <string.h>
int main(void)
{
    puts(iso_version());
    return strcmp(iso_version(), ISO_VERSION);
}
END
cp user.c user.cc
export PKG_CONFIG_PATH=$to/lib/pkgconfig PKG_CONFIG_SYSROOT_DIR=$dir/stage
check pkg_config_knows_the_version test "$(pkg-config --modversion isoshade)" = "$version"
flags=$(pkg-config --cflags --libs isoshade 2>/dev/null)
check a_program_in_c_is_built cc -std=c11 -Wall -Wextra -Wpedantic -Werror user.c -o user $flags
check one_in_cxx_as_well c++ -Wall -Wextra -Werror user.cc -o userxx $flags
check it_runs_with_the_shared_library env LD_LIBRARY_PATH="$to/lib" ./user
check the_one_in_cxx_too env LD_LIBRARY_PATH="$to/lib" ./userxx
unset PKG_CONFIG_SYSROOT_DIR
check and_with_the_archive sh -c "c++ -c user.cc -o user.o -I'$to/include' && c++ user.o '$to/lib/libisoshade.a' \$(pkg-config --static --libs-only-l isoshade | sed 's/-lisoshade//') -fopenmp -o static && ./static"

# The manual page and the completions.
man=$to/share/man/man1/isoshade.1
lint() { [ -z "$(LC_ALL=C groff -man -ww -z -Tutf8 "$1" 2>&1)" ]; }
check the_manual_page_is_without_fault lint "$man"
sed 's/^\.TP/.TQP/' "$man" >bad.1
expect a_fault_in_it_is_seen 1 lint bad.1
for command in $("$ISOSHADE" --help | sed -n '/^commands:/,/^$/s/^  \([a-z]*\) .*/\1/p'); do
    grep -q "^\.SS $command\$" "$man" || missing="${missing-} $command"
    for option in $("$ISOSHADE" "$command" --help=all | grep -oE '^ +(-., +)?--[a-z0-9-]+' | sed 's/.*--//'); do
        grep -qF -- "\\-\\-$(sed 's/-/\\-/g' <<<"$option")" "$man" || missing="${missing-} $command --$option"
    done
done
check each_command_and_option_is_in_it test -z "${missing-}"

# Variables that only tests and benchmarks set are left out.
variables() { grep -rohE 'ISOSHADE_[A-Z0-9_]*[A-Z0-9]' "$top/README.md" "$top/doc" --include=*.md | grep -v _FUZZ_ | sort -u; }
for variable in $(variables); do grep -q "$variable" "$man" || unsaid="${unsaid-} $variable"; done
check each_variable_of_the_pages_is_in_it test -z "${unsaid-}" -a -n "$(variables)"

complete_words() { # WORD ...: what completion proposes for the last one
    bash --norc -c '. "$0"; COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1)); _isoshade; echo "${COMPREPLY[*]}"' \
        "$to/share/bash-completion/completions/isoshade" "$@"
}
check commands_are_completed test "$(complete_words isoshade va)" = validate
check options_are_completed test "$(complete_words isoshade render --sce)" = --scene
check options_of_the_command_alone test -z "$(complete_words isoshade compare --sce)"
check values_are_completed test "$(complete_words isoshade export --to b)" = blender
check values_behind_an_equals_sign_too test "$(complete_words isoshade export --to = b)" = blender
check values_of_a_list_are_completed test "$(complete_words isoshade build --direction-filter n)" = naive
check kinds_of_volumes_are_completed test "$(complete_words isoshade make mar)" = marschner-lobb
check benchmarks_are_completed test "$(complete_words isoshade bench sc)" = scale
check with_their_options test "$(complete_words isoshade bench render --brick)" = --bricks
check actions_are_completed test "$(complete_words isoshade tf c)" = convert
check files_are_left_to_the_shell test -z "$(complete_words isoshade render --scene re)"
if command -v zsh >/dev/null; then
    check zsh_reads_its_completion zsh -n "$to/share/zsh/site-functions/_isoshade"
fi

check vtks_row_is_there grep -q vtk-gpu <("$to/bin/isoshade" list --renderers "$to/share/isoshade/renderers/vtk.json")
check with_all_of_its_script sh -c 'python3 -B "$1/render_vtk.py" --version >out 2>&1; ! grep exr out' - "$to/share/isoshade/renderers"
expect it_is_removed 0 make_it uninstall
check and_leaves_no_file test -z "$(find "$dir/stage" ! -type d)"
exit $failed
