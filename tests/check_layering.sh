#!/usr/bin/env bash
# Data flows one way: a folder includes only itself and those before it; exporters and render do not meet; compare
# knows only images and results; only src/cli sequences stages.
set -u
cd "$(dirname "$0")/.."
bad=0
allowed() { # folder
    case $1 in
        base) echo base ;;
        image) echo base image ;;
        volume) echo base volume ;;
        gradient) echo base volume gradient ;;
        encode) echo base volume gradient encode ;;
        pyramid) echo base volume gradient encode pyramid ;;
        tf) echo base volume gradient encode pyramid tf ;;
        brick) echo base volume gradient encode pyramid tf brick ;;
        render) echo base image volume gradient encode pyramid tf brick render ;;
        compare) echo base image compare ;;
        # Exporters see what is rendered - scene.h: cameras, lights; focus.h: a region of interest - but no renderer.
        # Blender reads the volume through the VDB door.
        vdb | povray) echo base image volume gradient encode pyramid tf brick "$1" ;;
        blender) echo base image volume gradient encode pyramid tf brick vdb blender ;;
        cli) echo base image volume gradient encode pyramid tf brick render compare cli vdb blender povray ;;
        *) return 1 ;;
    esac
}
check() { # file, folder
    local list include folder
    list=$(allowed "$2") || { echo "not ok layering: $1 lies in $2, which has no place in the order"; bad=1; return; }
    for include in $(sed -n 's/^#include "\([a-z_]*\/[^"]*\)".*/\1/p' "$1"); do
        folder=${include%%/*}
        case $include in render/scene.h | render/focus.h) [ "$2" != compare ] && continue ;; esac
        case " $list " in
            *" $folder "*) ;;
            *) echo "not ok layering: $1 includes $include"; bad=1 ;;
        esac
    done
}
count=0
for file in src/*/*.[ch] exporters/*/*.[ch] exporters/*/*.cc; do
    folder=${file%/*}
    check "$file" "${folder##*/}"
    count=$((count + 1))
done
# The check can fail: a planted include must be found.
planted=$(mktemp -d)
echo '#include "cli/cli.h"' >"$planted/x.c"
(check "$planted/x.c" base) | grep -q 'not ok' || { echo "not ok layering: a planted fault was not found"; bad=1; }
rm -r "$planted"
[ $bad = 0 ] && echo "ok layering of $count files"
exit $bad
