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
paraview:   $shared
blender:    $shared vdb
renderers:  $shared render vdb povray blender
plan:       $shared render compare
bake:       $shared render vdb
pbrt:       $shared render vdb bake
targets:    $shared render vdb povray paraview blender compare plan bake pbrt
report:     base image compare
view:       $shared
library:    $shared render vdb povray blender renderers compare plan bake pbrt targets view
validate:   $shared render renderers compare bake targets report
options:    $shared
chart:      $shared render renderers compare plan report options
atlas:      $shared render compare report options
figure:     $shared render renderers compare plan report options chart atlas
bench:      $shared render vdb povray blender renderers compare plan report validate options
cli:        $shared render vdb povray blender renderers compare plan bake pbrt targets report view validate options chart atlas figure bench
lab:        $shared render vdb povray blender renderers compare plan bake pbrt targets report view validate options chart atlas figure bench cli
"
rooms=$(sed -n 's/^\([a-z]*\):.*/\1/p' <<<"$table")
declare -A may # of each room: what it may include, itself too, each between blanks
while IFS=: read -r room names; do
    [ -z "$room" ] || may[$room]=" $names $room "
done <<<"$table"

# files: "FILE ROOM" for each include of a file of a room
includes() { awk -F'"' '/^#include "[a-z_]*\/[^"]*"/ { sub(/\/.*/, "", $2); print FILENAME, $2 }' "$@"; }

refused() { [[ ${may[$1]-} != *" $2 "* ]]; } # room, what it includes

bad=0
fail() { echo "not ok layering: $*"; bad=1; }

room_of() { # path, into $room; no room stands for src/isoshade.h, which stands above all rooms
    room=${1#*/}
    case $room in */*) room=${room%%/*} ;; *) room= ;; esac
}

mapfile -t files < <(find src exporters -mindepth 2 -name '*.[ch]' -o -mindepth 2 -name '*.cc')
count=${#files[@]}
for file in "${files[@]}"; do
    room_of "$file"
    [ -n "${may[$room]-}" ] || fail "$file lies in $room, which has no row"
done
while read -r file include; do
    room_of "$file"
    ! refused "$room" "$include" || fail "$file includes a file of $include"
done < <(includes "${files[@]}")

# Rows name only what stands above them: no two rooms include each other, directly or by a third.
above=" "
for room in $rooms; do
    for other in ${may[$room]}; do
        [ "$other" = "$room" ] || [[ $above == *" $other "* ]] || fail "$room may include $other, which does not stand above it"
    done
    above="$above$room "
done

# The check can fail: in each room an include of each room that its row does not name is found, and none that it names.
planted=$(mktemp)
trap 'rm -f "$planted"' EXIT
for other in $rooms; do echo "#include \"$other/x.h\""; done >"$planted"
for room in $rooms; do
    names=" $(sed -n "s/^$room: *//p" <<<"$table") $room "
    found=" "
    while read -r file include; do
        ! refused "$room" "$include" || found="$found$include "
    done < <(includes "$planted")
    for other in $rooms; do
        if [[ $names == *" $other "* ]]; then
            [[ $found != *" $other "* ]] || fail "an include of $other in $room was refused"
        else
            [[ $found == *" $other "* ]] || fail "an include of $other planted in $room was not found"
        fi
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
