#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Data flows one way: the files of a room (a folder of src or exporters, with the folders in it) include only files of the
# rooms that its row names, and of their own. No exemptions; a row names none that stands below it.
set -u
cd "$(dirname "$0")/.."

# What renderers and exporters share, in the order in which data flows through it.
shared="base image volume gradient encode palette pyramid tf fit brick scene"
table="
base:
image:      base
compare:    base image
volume:     base
gradient:   base volume
encode:     base volume gradient
palette:    base image volume gradient
pyramid:    base volume gradient encode palette
tf:         base image compare volume gradient encode palette pyramid
fit:        base image volume gradient encode palette pyramid tf
brick:      base volume gradient encode palette pyramid tf
scene:      base image volume gradient encode palette pyramid tf fit brick
render:     $shared
vdb:        $shared
povray:     $shared
blender:    $shared vdb
renderers:  $shared render vdb povray blender
plan:       $shared render compare
targets:    $shared render vdb povray blender compare plan
report:     base image compare
library:    $shared render vdb povray blender renderers compare plan targets
validate:   $shared render renderers compare targets report
chart:      $shared render renderers compare plan report
options:    $shared
atlas:      $shared render compare report options
rivals:     $shared render
bench:      $shared render vdb povray blender renderers compare plan report validate options rivals
cli:        $shared render vdb povray blender renderers compare plan targets report validate chart options atlas rivals bench
"
allowed() { sed -n "s/^$1: *//p" <<<"$table"; } # room: what it may include
rooms=$(sed -n 's/^\([a-z]*\):.*/\1/p' <<<"$table")

check() { # file, room: a line for each include that the room's row does not name
    local include
    for include in $(sed -n 's/^#include "\([a-z_]*\)\/[^"]*".*/\1/p' "$1"); do
        case " $(allowed "$2") $2 " in
            *" $include "*) ;;
            *) echo "not ok layering: $1 includes a file of $include" ;;
        esac
    done
}

bad=0
fail() { echo "not ok layering: $*"; bad=1; }

count=0
for file in $(find src exporters -name '*.[ch]' -o -name '*.cc'); do
    room=${file#*/}
    case $room in */*) room=${room%%/*} ;; *) continue ;; esac # src/isoshade.h stands above all rooms
    grep -qx "$room" <<<"$rooms" || fail "$file lies in $room, which has no row"
    found=$(check "$file" "$room")
    [ -z "$found" ] || { echo "$found"; bad=1; }
    count=$((count + 1))
done

# Rows name only what stands above them: no two rooms include each other, directly or by a third.
above=" "
for room in $rooms; do
    for other in $(allowed "$room"); do
        case $above in *" $other "*) ;; *) fail "$room may include $other, which does not stand above it" ;; esac
    done
    above="$above$room "
done

# The check can fail: in each room an include of each room that its row does not name is found, and none that it names.
planted=$(mktemp)
trap 'rm -f "$planted"' EXIT
for room in $rooms; do
    for other in $rooms; do
        [ "$room" = "$other" ] && continue
        echo "#include \"$other/x.h\"" >"$planted"
        case " $(allowed "$room") " in
            *" $other "*) [ -z "$(check "$planted" "$room")" ] || fail "an include of $other in $room was refused" ;;
            *) [ -n "$(check "$planted" "$room")" ] || fail "an include of $other planted in $room was not found" ;;
        esac
    done
done

# No room holds more than a sixth of the code.
lines() { find "$@" -name '*.[ch]' -o -name '*.cc' -o -name '*.glsl' -o -name '*.js' -o -name '*.py' | xargs cat | wc -l; }
total=$(lines src exporters)
for room in src/*/ exporters/*/; do
    part=$(lines "$room")
    [ $((part * 6)) -le "$total" ] || fail "${room%/} holds $part of $total lines, more than a sixth"
done
[ $bad = 0 ] && echo "ok layering of $count files in $(wc -w <<<"$rooms") rooms"
exit $bad
