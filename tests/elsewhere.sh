#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Builds and tests the checkout's HEAD on another Debian release, from nothing: a clean root by debootstrap, a clone in
# it, `make check` inside, then all scenes of refscenes/suite by the Cycles of that release, and one summary line at the
# end. The scenes have to agree; a Blender that is built without NanoVDB has to be refused by that name.
#
#   tests/elsewhere.sh [--target TARGET] [--scenes] [--keep DIR] bookworm|trixie|sid
#
#   --scenes          builds, and has Cycles draw the scenes, without the tests
#   --target TARGET   runs `make TARGET` instead of `make check`; "all tests" builds without running anything
#   --keep DIR        uses the root in DIR, makes it where it is not there, and leaves it for the next run
#
# The whole output goes to build/elsewhere-RELEASE.log. Needs root, debootstrap and a Debian mirror.
set -u
top=$(cd "$(dirname "$0")/.." && pwd)
. "$top/tests/roots.sh"

# ---- inside the namespaces: process 1 of its own ------------------------------------------------------------------

inside() { # ROOT TARGET SCENES
    local root=$1 target=$2 scenes=$3
    mount_devices "$root" && in_root "$root" sh -euc '
            apt-get update -qq
            apt-get install -y -qq --no-install-recommends make git >/dev/null
            cd /root/isoshade
            make setup-check # by a make of its own: the next one looks for what this one installs
            make $1
            if [ "$2" = yes ]; then bash tests/elsewhere.sh --cycles; fi
            version() { dpkg-query -W -f "\${source:Upstream-Version}" "$1" 2>/dev/null || echo none; }
            echo "elsewhere: gcc $(gcc -dumpfullversion 2>/dev/null || echo none), OpenVDB $(version libopenvdb-dev)," \
                "OpenEXR $(version libopenexr-dev), Blender $(version blender)"
        ' sh "$target" "$scenes"
}

cycles() { # in the clone: do all scenes of the suite agree, or does it say why there can be no picture?
    local code=0 said=build/elsewhere-scenes.log
    build/release/isoshade validate --suite refscenes/suite --quick --with cycles --size 24 -q -o build/elsewhere-scenes >$said 2>&1 || code=$?
    cat $said
    if [ $code = 0 ]; then
        echo "elsewhere: Cycles: $(grep -m 1 '^The renderers' $said)"
    elif [ $code = 7 ] && grep -q 'Blender [5-9].* is built without NanoVDB: Cycles shows no volumes' $said; then
        echo "elsewhere: Cycles: none, as it says: $(grep -o -m 1 'Blender [0-9.]* of this system is built without NanoVDB' $said)"
    else
        echo "elsewhere: Cycles: FAILED on the scenes, exit code $code"
        return 1
    fi
}

if [ "${1-}" = --cycles ]; then
    cycles
    exit
fi
if [ "${1-}" = --inside ]; then
    shift
    inside "$@"
    exit
fi

# ---- outside: arguments, the root, the clone, the summary ---------------------------------------------------------

usage() {
    echo "usage: tests/elsewhere.sh [--target TARGET] [--scenes] [--keep DIR] bookworm|trixie|sid" >&2
    exit 2
}

target=check scenes='' keep='' suite=''
while [ $# -gt 0 ]; do
    case $1 in
    --target) [ $# -ge 2 ] || usage; target=$2; shift 2 ;;
    --scenes) scenes=yes; target=all; shift ;;
    --keep) [ $# -ge 2 ] || usage; keep=$2; shift 2 ;;
    bookworm | trixie | sid) [ -z "$suite" ] || usage; suite=$1; shift ;;
    *) usage ;;
    esac
done
[ -n "$suite" ] || usage
[ "$target" != check ] || scenes=yes
needs_roots
[ -z "$(git -C "$top" status --porcelain)" ] || echo "elsewhere: what is not committed is not tested" >&2

if [ -n "$keep" ]; then
    mkdir -p "$keep" && root=$(cd "$keep" && pwd -P) || die "$keep: cannot be made"
    [ "$root" != / ] || die "--keep is the host's own root"
    if [ -n "$(ls -A "$root")" ] && ! grep -qsE "^deb [^ ]+ $suite " "$root/etc/apt/sources.list"; then
        die "$keep: is neither empty nor a Debian $suite that this script or debootstrap made"
    fi
else
    root=$(mktemp -d "${TMPDIR:-/var/tmp}/isoshade-$suite.XXXXXX") || die "no folder for the root"
    roots=("$root")
fi

log=$top/build/elsewhere-$suite.log
mkdir -p "$top/build"
start=$SECONDS
exec 3> >(tee "$log")
tee=$!
make_root "$suite" "$root" && clone_into "$root" &&
    apart bash "$top/tests/elsewhere.sh" --inside "$root" "$target" "${scenes:-no}"
code=$?
exec 3>&-
wait "$tee" # the log is complete

tests=$(grep -E '^[0-9]+ passed, [0-9]+ failed' "$log" | tail -n 1)
cycles=$(sed -n 's/^elsewhere: Cycles: //p' "$log" | tail -n 1)
warnings=$(grep -cE '(^|[^-])warning: ' "$log")
versions=$(sed -n 's/^elsewhere: \(gcc .*\)/\1/p' "$log" | tail -n 1)
[ "$warnings" = 0 ] || [ "$code" != 0 ] || code=1
verdict=$([ "$code" = 0 ] && echo passed || echo FAILED)
echo "elsewhere $suite: make $target $verdict${tests:+: $tests}${cycles:+; Cycles: $cycles}; $warnings warnings, $(((SECONDS - start + 30) / 60)) min" \
    "(${versions:-log: $log}; ${commit:0:7})"
[ "$code" = 0 ]
