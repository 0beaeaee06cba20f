#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# The library as others use it: its header alone, in C and C++; what it exports; the tutorial, built against the installed
# header and library, shared and static.
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
# A program in C++17 has its renderer judged, by the program that is installed next to the library: black pictures fail.
cat >judge.cc <<'END'
#include <isoshade.h>
#include <cstring>
#include <vector>
static bool draw(void *user, const iso_frame_request *request, float *)
{
    ++*static_cast<int *>(user);
    return request->values && request->width > 0 && request->step_mm > 0 && std::strstr(request->json, "camera");
}
int main()
{
    int drawn = 0;
    const size_t size[3] = {9, 8, 7};
    const double spacing_mm[3] = {1, 1, 1};
    const ptrdiff_t strides[3] = {1, 9, 72};
    std::vector<unsigned char> samples(9 * 8 * 7);
    samples[4 + 9 * (4 + 8 * 3)] = 255;
    const iso_grid grid = iso_grid_axis_aligned(size, spacing_mm);
    iso_volume *volume = nullptr;
    iso_error error{};
    const iso_own_renderer own{"black", draw, &drawn};
    iso_validate_options options = iso_validate_defaults();
    options.renderers = &own;
    options.renderer_count = 1;
    options.width = options.height = 12;
    iso_validation_result result;
    if (iso_volume_from_array(&grid, "uint8", samples.data(), strides, &volume, &error) != ISO_OK)
        return 2;
    const iso_status status = iso_validate(volume, &options, &result, &error);
    const bool good = status == ISO_OK && !result.agrees && result.summary[0] && std::strstr(result.json, "black") &&
                      std::strstr(result.html, "<html");
    iso_validation_result_destroy(&result);
    iso_volume_free(volume);
    return good && drawn >= 8 ? 0 : 1;
}
END
# Programs in C and C++ call each function.
uncalled() { comm -23 <(declared "$1") <(grep -ohE '\biso_[a-z0-9_]+' "$top/tests/test_library.c" judge.cc | sort -u); }
each_is_called() { [ -z "$(uncalled "$1")" ] || { uncalled "$1"; return 1; }; }
check each_function_is_called each_is_called "$header"
sed 's/^const char \*iso_version(void);/&\nint iso_planted(void);/' "$header" >planted/isoshade.h
notice a_function_that_nobody_calls_is_found each_is_called "$dir/planted/isoshade.h"
check judge_links g++ -std=c++17 $warnings judge.cc -o judge $(pkg-config --cflags --libs isoshade)
expect renderers_of_a_program_are_judged 0 env -u ISOSHADE_ISOSHADE LD_LIBRARY_PATH="$prefix/lib" ./judge
nm "$prefix/lib/libisoshade.a" 2>/dev/null | awk '$2 ~ /^[TDBR]$/ { print $3 }' | sort -u >visible
[ "$(cat visible)" = "$(exported)" ] && ok internal_names_are_hidden || not_ok internal_names_are_hidden "$(wc -l <visible) names"
exit $failed
