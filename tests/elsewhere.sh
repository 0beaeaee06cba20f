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
#
# What is mounted is mounted in a namespace of its own, and its processes have a PID namespace of their own: both are
# gone when the run ends, however it ends. The root gets a /dev and a /proc that are its own, never the host's, and it is
# removed from outside of the namespace, where nothing was ever mounted on it.
set -u

# ---- inside the namespaces: process 1 of its own ------------------------------------------------------------------

mount_devices() { # ROOT
    mount -t proc proc "$1/proc" && mount -t tmpfs -o mode=755 tmpfs "$1/dev" || return 1
    local node
    for node in null zero full random urandom tty; do
        : >"$1/dev/$node" && mount --bind "/dev/$node" "$1/dev/$node" || return 1
    done
    ln -s /proc/self/fd "$1/dev/fd"
    ln -s fd/0 "$1/dev/stdin" && ln -s fd/1 "$1/dev/stdout" && ln -s fd/2 "$1/dev/stderr"
    mkdir "$1/dev/shm" "$1/dev/pts"
    mount -t tmpfs -o mode=1777 tmpfs "$1/dev/shm"
    mount -t devpts -o newinstance,ptmxmode=0666 devpts "$1/dev/pts" && ln -s pts/ptmx "$1/dev/ptmx"
    mount -t sysfs -o ro sysfs "$1/sys" 2>/dev/null # the machine's topology; programs do without
    return 0
}

inside() { # ROOT TARGET SCENES
    local root=$1 target=$2 scenes=$3
    mount_devices "$root" || return 1
    # The tests must not find anything of the host: an environment of its own, but for the way to the network.
    chroot "$root" /usr/bin/env -i PATH=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin HOME=/root \
        LANG=C.UTF-8 DEBIAN_FRONTEND=noninteractive ${http_proxy:+http_proxy="$http_proxy"} \
        ${https_proxy:+https_proxy="$https_proxy"} ${no_proxy:+no_proxy="$no_proxy"} sh -euc '
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
die() {
    echo "elsewhere: $*" >&2
    exit 1
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
[ "$(id -u)" = 0 ] || die "needs root: it makes a Debian $suite in a folder and enters it"
for program in unshare git debootstrap; do
    command -v $program >/dev/null || die "$program is missing; it comes with the Debian package ${program/unshare/util-linux}"
done
top=$(cd "$(dirname "$0")/.." && pwd)
[ -z "$(git -C "$top" status --porcelain)" ] || echo "elsewhere: what is not committed is not tested" >&2

if [ -n "$keep" ]; then
    mkdir -p "$keep" && root=$(cd "$keep" && pwd -P) || die "$keep: cannot be made"
    [ "$root" != / ] || die "--keep is the host's own root"
    if [ -n "$(ls -A "$root")" ] && ! grep -qsE "^deb [^ ]+ $suite " "$root/etc/apt/sources.list"; then
        die "$keep: is neither empty nor a Debian $suite that this script or debootstrap made"
    fi
else
    root=$(mktemp -d "${TMPDIR:-/var/tmp}/isoshade-$suite.XXXXXX") || die "no folder for the root"
fi

remove_root() {
    [ -z "$keep" ] || return 0
    if grep -qF " $root" /proc/self/mountinfo; then # cannot be, and must not be
        echo "elsewhere: something is mounted in $root; it is left" >&2
        return 0
    fi
    rm -rf --one-file-system "$root"
}
child=
stop() { # what runs in the namespaces ends with the process that made them
    [ -z "$child" ] || kill -KILL "$child" 2>/dev/null
    exit 130
}
trap remove_root EXIT
trap stop INT TERM HUP

# The mirror that the host's apt uses; none where the host is no Debian: then debootstrap's own.
mirror=$(apt-get indextargets --format '$(REPO_URI)' 'Created-By: Packages' 'Origin: Debian' 'Label: Debian' 2>/dev/null | head -n 1)
mirror=${mirror%/}

prepare() { # what the chroot needs of the host: names, the way to the mirror, the clone
    mkdir -p "$root/etc/apt/apt.conf.d" "$root/root"
    cp -L /etc/resolv.conf "$root/etc/resolv.conf"
    apt-config dump 2>/dev/null | grep -E '^Acquire::(http|https)::|^Acquire::(Check-Valid-Until|Check-Date|Retries) ' \
        >"$root/etc/apt/apt.conf.d/90host"
    [ -z "$mirror" ] || echo "deb $mirror $suite main" >"$root/etc/apt/sources.list"
    rm -rf --one-file-system "$root/root/isoshade"
    git clone --quiet --no-hardlinks "$top" "$root/root/isoshade" &&
        git -C "$root/root/isoshade" checkout --quiet --detach "$commit"
}

log=$top/build/elsewhere-$suite.log
mkdir -p "$top/build"
apart() { # COMMAND: in namespaces of its own
    unshare --mount --propagation private --pid --fork --kill-child --mount-proc "$@" >&3 2>&1 </dev/null &
    child=$!
    wait "$child"
    local code=$?
    child=
    return $code
}

start=$SECONDS
commit=$(git -C "$top" rev-parse HEAD) || die "the checkout has no commit"
exec 3> >(tee "$log")
tee=$!
# debootstrap wants an empty folder, so the rest is prepared between the two.
{ [ -e "$root/etc/debian_version" ] || apart debootstrap --variant=minbase "$suite" "$root" $mirror; } &&
    prepare && apart bash "$top/tests/elsewhere.sh" --inside "$root" "$target" "${scenes:-no}"
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
