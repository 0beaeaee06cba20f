#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# The library as others use it: its header alone, in C and C++; what it exports; the tutorial, built against the installed
# header and library, shared and static; programs in C, C++17 and by ctypes that call each function.
. "$(dirname "$0")/lib.sh"
header=$top/src/isoshade.h
prefix=$dir/installed

check install make -s -C "$top" SETUP=no PREFIX="$prefix" install

# ---- the header ----
echo '#include <isoshade.h>' >only.c
for standard in c99 c11; do
    check "header_is_$standard" gcc -std=$standard -Wall -Wextra -Wpedantic -Werror -I"$prefix/include" -fsyntax-only only.c
done
check header_is_cplusplus g++ -x c++ -std=c++11 -Wall -Wextra -Wpedantic -Werror -I"$prefix/include" -fsyntax-only only.c

# ---- what the shared library exports is what the header declares ----
declared() { gcc -E -P -I"$(dirname "$1")" "$1" | tr '\n' ' ' | grep -oE '\biso_[a-z0-9_]+ ?\(' | tr -d ' (' | sort -u; }
exported() {
    nm -D --defined-only "$prefix/lib/libisoshade.so" | awk '$2 != "A" { sub(/@.*/, "", $3); print $3 }' | sort
}
exports_agree() { diff <(declared "$1") <(exported); }
check exports_are_the_header exports_agree "$prefix/include/isoshade.h"
[ "$(exported | wc -l)" -gt 30 ] && ok exports_are_many || not_ok exports_are_many "$(exported | wc -l) functions"
[ -z "$(exported | grep -v '^iso_')" ] && ok exports_have_the_prefix || not_ok exports_have_the_prefix "$(exported | grep -v '^iso_' | head -3)"
mkdir planted
sed 's/^const char \*iso_version(void);/&\nint iso_planted(void);/' "$header" >planted/isoshade.h
expect a_function_that_is_declared_alone_is_found 1 exports_agree "$dir/planted/isoshade.h"
grep -v iso_version "$header" >planted/isoshade.h
expect a_function_that_is_exported_alone_is_found 1 exports_agree "$dir/planted/isoshade.h"
readelf -d "$prefix/lib/libisoshade.so" >needed
grep -q 'NEEDED.*libteem' needed && ! grep -qE 'popt|openvdb' needed && ok no_command_line_inside || not_ok no_command_line_inside "$(grep -c NEEDED needed) libraries"

# ---- one version ----
version=$(sed -n 's/^#define ISO_VERSION_\(MAJOR\|MINOR\|PATCH\) //p' "$header" | paste -sd.)
export PKG_CONFIG_PATH=$prefix/lib/pkgconfig
[ "$(pkg-config --modversion isoshade)" = "$version" ] && ok version_of_pkg_config || not_ok version_of_pkg_config "$(pkg-config --modversion isoshade), the header says $version"
"$prefix/bin/isoshade" --version | grep -qw "$version" && ok version_of_the_program || not_ok version_of_the_program "$("$prefix/bin/isoshade" --version)"

# ---- the tutorial ----
warnings="-Wall -Wextra -Wpedantic -Werror"
for standard in c99 c11; do
    check "tutorial_is_$standard" gcc -std=$standard $warnings -c "$top/doc/guide/tutorial.c" -o "$standard.o" $(pkg-config --cflags isoshade)
done
check shared_links gcc c99.o -o shared $(pkg-config --libs isoshade) -lm
check static_links gcc c99.o -o static $(pkg-config --static --libs isoshade | sed 's/-lisoshade\b/-l:libisoshade.a/') -lm
readelf -d static | grep -q libisoshade && not_ok static_is_static "it needs libisoshade.so" || ok static_is_static
for way in shared static; do
    mkdir "$way.d"
    expect "tutorial_runs_$way" 0 env -C "$way.d" LD_LIBRARY_PATH="$prefix/lib" "$dir/$way"
    cp out "$way.out"
    for file in level0.png level1.png volume.vdb; do
        [ -s "$way.d/$file" ] && ok "${way}_wrote_$file" || not_ok "${way}_wrote_$file" "it is not there"
    done
done
check shared_and_static_agree diff shared.out static.out
# The page says what it prints. Renders do not depend on the machine but in their last digits.
shown=$(grep -o 'levels 0 and 1 differ by [0-9.]* (RMSE), [0-9.]* (FLIP)' "$top/doc/guide/library.md")
[ -n "$shown" ] && [ "$shown" = "$(cat shared.out)" ] && ok page_shows_the_output || not_ok page_shows_the_output "it prints $(cat shared.out), the page has $shown"

# A missing file ends as its status says, and what the library has to say is the program's to print.
cat >missing.c <<'END'
#include <isoshade.h>
int main(void)
{
    iso_volume *volume;
    iso_error error = {""};
    return iso_volume_open("no such file", &volume, &error) == ISO_E_IO && !volume && error.text[0] ? 0 : 1;
}
END
check missing_links gcc $warnings missing.c -o missing $(pkg-config --cflags --libs isoshade)
expect errors_are_codes 0 env LD_LIBRARY_PATH="$prefix/lib" ./missing
[ -s out ] || [ -s err ] && not_ok nothing_is_printed "$(cat out err)" || ok nothing_is_printed

# ---- programs in C, in C++17 and by ctypes that call each function ----
whole=$top/tests/whole_library
check whole_links_as_c99 gcc -std=c99 $warnings "$whole.c" -o whole-c $(pkg-config --cflags --libs isoshade)
check whole_links_as_cplusplus17 g++ -std=c++17 $warnings -x c++ "$whole.c" -x none -o whole-c++ $(pkg-config --cflags --libs isoshade)
python_with numpy
ran=(env -u ISOSHADE_ISOSHADE LD_LIBRARY_PATH="$prefix/lib" ISOSHADE_LIBRARY="$prefix/lib/libisoshade.so" PYTHONDONTWRITEBYTECODE=1)
for program in ./whole-c ./whole-c++ "$python $whole.py"; do
    expect "it_runs_${program##*[-.]}" 0 "${ran[@]}" $program
done
uncalled() { comm -23 <(declared "$1") <(grep -ohE '\biso_[a-z0-9_]+' "$2" | sort -u); } # HEADER PROGRAM
each_is_called() { [ -z "$(uncalled "$@")" ] || { uncalled "$@"; return 1; }; }
sed 's/^const char \*iso_version(void);/&\nint iso_planted(void);/' "$header" >planted/isoshade.h
for program in "$whole.c" "$whole.py"; do
    check "each_function_is_called_by_${program##*.}" each_is_called "$header" "$program"
    notice "a_function_that_${program##*.}_lacks_is_found" each_is_called "$dir/planted/isoshade.h" "$program"
done

nm "$prefix/lib/libisoshade.a" 2>/dev/null | awk '$2 ~ /^[TDBR]$/ { print $3 }' | sort -u >visible
[ "$(cat visible)" = "$(exported)" ] && ok internal_names_are_hidden || not_ok internal_names_are_hidden "$(wc -l <visible) names"
exit $failed
