# SPDX-License-Identifier: MIT
# roots.sh - sourced by elsewhere.sh and packages.sh: clean Debian roots that know nothing of this machine. Needs $top.
#
# Each root has mounts and processes in namespaces of its own: both are gone when the run ends, however it ends. It has
# its own /dev and /proc, never the host's. It is removed from outside of the namespaces, where nothing was mounted.
set -u

die() {
    echo "$(basename "$0"): $*" >&2
    exit 1
}

needs_roots() { # dies if this system makes none; $commit becomes the checkout's
    [ "$(id -u)" = 0 ] || die "needs root: it makes a Debian in a folder and enters it"
    local program
    for program in unshare git debootstrap; do
        command -v $program >/dev/null || die "$program is missing; its Debian package is ${program/unshare/util-linux}"
    done
    commit=$(git -C "$top" rev-parse HEAD) || die "the checkout has no commit"
}

# ---- inside the namespaces -----------------------------------------------------------------------------------------

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

in_root() { # ROOT COMMAND ...: nothing of the host's environment but the way to the network
    local root=$1
    shift
    chroot "$root" /usr/bin/env -i PATH=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin HOME=/root \
        LANG=C.UTF-8 DEBIAN_FRONTEND=noninteractive ${http_proxy:+http_proxy="$http_proxy"} \
        ${https_proxy:+https_proxy="$https_proxy"} ${no_proxy:+no_proxy="$no_proxy"} "$@"
}

# ---- outside -------------------------------------------------------------------------------------------------------

roots=() # removed at the end
remove_roots() {
    local root
    for root in "${roots[@]}"; do
        if grep -qF " $root" /proc/self/mountinfo; then # cannot be, and must not be
            echo "$(basename "$0"): something is mounted in $root; it is left" >&2
        else
            rm -rf --one-file-system "$root"
        fi
    done
}
child=
stop() { # processes in the namespaces end with the process that made them
    [ -z "$child" ] || kill -KILL "$child" 2>/dev/null
    exit 130
}
trap remove_roots EXIT
trap stop INT TERM HUP

apart() { # COMMAND: in namespaces of its own; prints to descriptor 3
    unshare --mount --propagation private --pid --fork --kill-child --mount-proc "$@" >&3 2>&1 </dev/null &
    child=$!
    wait "$child"
    local code=$?
    child=
    return $code
}

make_root() { # SUITE ROOT: a Debian, if the folder is none yet, with names and the way to the mirror
    local suite=$1 root=$2 mirror
    # The mirror of the host's apt; debootstrap's own if the host is no Debian.
    mirror=$(apt-get indextargets --format '$(REPO_URI)' 'Created-By: Packages' 'Origin: Debian' 'Label: Debian' \
        2>/dev/null | head -n 1)
    mirror=${mirror%/}
    # debootstrap needs an empty folder.
    [ -e "$root/etc/debian_version" ] || apart debootstrap --variant=minbase "$suite" "$root" $mirror || return 1
    mkdir -p "$root/etc/apt/apt.conf.d"
    cp -L /etc/resolv.conf "$root/etc/resolv.conf"
    apt-config dump 2>/dev/null | grep -E '^Acquire::(http|https)::|^Acquire::(Check-Valid-Until|Check-Date|Retries) ' \
        >"$root/etc/apt/apt.conf.d/90host"
    [ -z "$mirror" ] || echo "deb $mirror $suite main" >"$root/etc/apt/sources.list"
}

clone_into() { # ROOT: the commit, in /root/isoshade
    local clone=$1/root/isoshade
    rm -rf --one-file-system "$clone"
    git clone --quiet --no-hardlinks "$top" "$clone" && git -C "$clone" checkout --quiet --detach "$commit"
}
