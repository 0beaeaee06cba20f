#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Builds the Debian packages of the checkout's HEAD in a clean Debian, with the build dependencies of debian/control
# alone. Installs them in a second clean Debian, uses each, and purges them. Prints a line per case, and their number.
#
#   tests/packages.sh bookworm|trixie|sid          make deb-check RELEASE=trixie does the same
#
# The whole output goes to build/packages-RELEASE.log, fetched packages stay in build/fetched for the next run. Needs
# root, debootstrap and a Debian mirror. If CCACHE_DIR is set, the compiler is ccache with that folder.
set -u
top=$(cd "$(dirname "$0")/.." && pwd)
. "$top/tests/roots.sh"

# ---- inside a root -------------------------------------------------------------------------------------------------

install_packages() { apt-get install -y -q "$@"; }
try() { # NAME COMMAND ...: as lib.sh's check, with the command's whole output in the log
    local name=$1
    shift
    if "$@"; then ok "$name"; else not_ok "$name" "$*"; fi
}

without_findings() { # of lintian, except that the project has no home page
    lintian --fail-on none build/deb/*.changes >"$dir/found" && cat "$dir/found" &&
        ! grep '^[EW]: ' "$dir/found" | grep -v '^W: isoshade: appstream-metadata-validation-failed '
}

build_packages() {
    . "$top/tests/lib.sh"
    cd "$top" || exit 1
    try build_dependencies_are_there sh -c 'apt-get update -qq && apt-get build-dep -y -q --no-install-recommends ./'
    if [ -d /root/.ccache ]; then
        install_packages ccache
        export PATH=/usr/lib/ccache:$PATH CCACHE_DIR=/root/.ccache
    fi
    try packages_are_built make deb
    [ $failed = 0 ] || exit 1
    install_packages --no-install-recommends lintian
    try lintian_finds_nothing without_findings
    exit 0 # the packages are there
}

everything() { # the paths of this root that are no cache and no log; Blender, run as root, compiles its own scripts
    find / -xdev -regextype posix-extended \
        -regex '/(var/cache|var/log|var/lib/apt|var/lib/dpkg|tmp|root|dev|proc|sys)' -prune -o -print |
        grep -v '^/usr/share/blender/scripts/.*__pycache__' | sort
}
left() { everything | diff without - >changed; } # compares with the list `without`
first_picture() {
    isoshade make marschner-lobb --size 24 -q -o first.nrrd && isoshade render first.nrrd -q -o first.png &&
        [ "$(head -c 4 first.png | tail -c 3)" = PNG ]
}
libraries_are_found() { # of all but MPI, which is suggested
    ! ldd $(ls /usr/bin/isoshade /usr/lib/*/isoshade/* | grep -v mpi) | grep 'not found'
}
addon_is_enabled() {
    blender -b --factory-startup --python-exit-code 1 --python-expr 'import addon_utils, bpy
module = addon_utils.enable("bl_ext.system.isoshade" if bpy.app.version >= (4, 2, 0) else "isoshade_addon")
assert module.__file__.startswith("/usr/share/blender/"), module.__file__
assert bpy.ops.isoshade.import_volume.poll()'
}

use_packages() {
    . "$top/tests/lib.sh"
    local debs ours needs
    debs=$(ls "$top"/build/deb/*.deb | grep -v dbgsym)
    ours=$(sed 's|.*/||; s/_.*//' <<<"$debs")
    needs=$(sed -n 's/^Depends: //p' "$top/debian/tests/control" | tr -d ,)
    apt-get update -qq
    try the_program_is_installed install_packages --no-install-recommends "$top"/build/deb/{isoshade,libisoshade0}_*.deb
    try it_draws_without_recommended_packages first_picture
    try it_is_removed apt-get purge -y -q --autoremove isoshade libisoshade0
    # Their dependencies stay from here.
    try all_are_installed install_packages $debs $needs
    try they_are_removed apt-get purge -y -q $ours
    blender -b --factory-startup --python-expr pass
    everything >without
    try they_are_installed_again install_packages $debs
    try libraries_of_all_modules_are_found libraries_are_found
    try the_first_picture_is_drawn first_picture
    try a_report_is_written isoshade validate first.nrrd --quick --levels 1 --size 16 --with gl,cycles -q -o report
    try blender_enables_the_addon addon_is_enabled
    try the_test_of_autopkgtest_passes sh "$top/debian/tests/picture"
    touch /usr/share/isoshade/planted
    try they_are_purged apt-get purge -y -q $ours
    left
    try a_file_that_stays_would_be_seen grep -qx '> /usr/share/isoshade/planted' changed
    rm -r /usr/share/isoshade
    try nothing_of_them_is_left left
    cat changed
    exit $failed
}

# inside ROOT WHAT: mounts, and runs --WHAT of the clone
inside() {
    local root=$1 archives=$1/var/cache/apt/archives
    mkdir -p "$archives" && mount --bind "$top/build/fetched" "$archives" || return 1
    if [ "$2" = build_packages ] && [ -n "${CCACHE_DIR-}" ]; then
        mkdir -p "$root/root/.ccache" && mount --bind "$CCACHE_DIR" "$root/root/.ccache" || return 1
    fi
    mount_devices "$root" && in_root "$root" bash /root/isoshade/tests/packages.sh "--$2"
}

case ${1-} in
--build_packages | --use_packages) "${1#--}" ;;
--inside) inside "$2" "$3"; exit ;;
bookworm | trixie | sid) suite=$1 ;;
*) echo "usage: tests/packages.sh bookworm|trixie|sid" >&2; exit 2 ;;
esac

# ---- outside -------------------------------------------------------------------------------------------------------

needs_roots
[ -z "$(git -C "$top" status --porcelain)" ] || echo "packages: what is not committed is not tested" >&2
mkdir -p "$top/build/fetched"
folder=$(mktemp -d "${TMPDIR:-/var/tmp}/isoshade-$suite.XXXXXX") || die "no folder for the roots"
roots=("$folder")
log=$top/build/packages-$suite.log
start=$SECONDS
exec 3> >(tee "$log" | grep --line-buffered -E '^(not )?ok |^[EW]: ')
tee=$!
make_root "$suite" "$folder/build" && cp -a "$folder/build" "$folder/use" && clone_into "$folder/build" &&
    apart bash "$top/tests/packages.sh" --inside "$folder/build" build_packages &&
    clone_into "$folder/use" && mkdir "$folder/use/root/isoshade/build" &&
    mv "$folder/build/root/isoshade/build/deb" "$folder/use/root/isoshade/build/" &&
    apart bash "$top/tests/packages.sh" --inside "$folder/use" use_packages
code=$?
exec 3>&-
wait "$tee" # the log is complete
passed=$(grep -c '^ok ' "$log")
failures=$(grep -c '^not ok ' "$log")
[ "$code" = 0 ] || [ "$failures" != 0 ] || failures=1 # it ended before its cases
echo "packages $suite, ${commit:0:7}: $(((SECONDS - start + 30) / 60)) min, log: $log"
echo "$passed passed, $failures failed"
[ "$failures" = 0 ]
