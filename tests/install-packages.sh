#!/bin/sh
# SPDX-License-Identifier: MIT
# Installs those of the named Debian packages that are missing: as root or by sudo, else prints the command and stops.
# Prints their number and size first, then progress. --missing only prints the names.
set -eu
only_names=
[ "${1-}" != --missing ] || { only_names=yes; shift; }
missing=
for package; do
    dpkg-query -W -f '${Status}' "$package" 2>/dev/null | grep -q 'ok installed' || missing="$missing $package"
done
[ -z "$only_names" ] || { echo $missing; exit 0; }
[ -n "$missing" ] || exit 0
if [ "$(id -u)" = 0 ]; then
    as_root=
elif command -v sudo >/dev/null 2>&1 && { [ -t 0 ] || sudo -n true 2>/dev/null; }; then
    as_root=sudo
else
    echo "isoshade needs Debian packages that are not installed. As root, run:" >&2
    echo "    apt-get update && apt-get install --no-install-recommends -y$missing" >&2
    exit 1
fi
fail() {
    tail -n 20 build/apt.log >&2
    echo "apt-get could not install:$missing" >&2
    exit 1
}
export DEBIAN_FRONTEND=noninteractive
echo "Debian packages that are missing (SETUP=no skips them; log: build/apt.log):$missing"
$as_root apt-get update -qq >build/apt.log 2>&1 || fail
install="apt-get install -y -q --no-install-recommends$missing"
count=$($install -s 2>>build/apt.log | grep -c '^Inst ') || fail
$install -qq --print-uris | awk -v count="$count" '{bytes += $3}
    END {printf "with those that they need: %d packages, %.0f MB to fetch\n", count, bytes / 1e6}'
# Lines of apt's status: dlstatus:NUMBER:PERCENT:TEXT while it fetches, pmstatus:PACKAGE:PERCENT:TEXT while it installs.
{ $as_root $install -o APT::Status-Fd=1 </dev/null 2>>build/apt.log || echo failed; } |
    awk -F: '$1 == "failed" {exit 1}
        !/^[dp][lm]status:/ {print >>"build/apt.log"; next}
        {verb = $1 == "dlstatus" ? "fetched" : "installed"; tenth = int($3 / 10)}
        verb != last || tenth > shown {printf "%s %d %%\n", verb, 10 * tenth; fflush(); last = verb; shown = tenth}' || fail
