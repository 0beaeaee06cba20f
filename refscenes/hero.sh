#!/bin/sh
# SPDX-License-Identifier: MIT
# The picture of README.md: a brain at three levels in several renderers, and how far each is from the reference.
#   sh refscenes/hero.sh [PICTURE.jpg [WxH]]     WxH: of a panel; what was rendered stays in build/figures and is kept
#   HERO_RENDERERS="reference gl" sh refscenes/hero.sh     these alone
set -eu
cd "$(dirname "$0")/.."
out=${1:-build/figures/hero.jpg}
size=${2:-160x132}
isoshade=${ISOSHADE:-./isoshade}
volume=/usr/share/mricron/templates/ch2bet.nii.gz
[ -r "$volume" ] || { echo "hero: $volume is missing; it comes with the Debian package mricron-data" >&2; exit 3; }
dir=build/figures/hero-$size
mkdir -p "$dir" "$(dirname "$out")"
renderers=${HERO_RENDERERS:-reference gl cycles povray}
for level in 0 1 2; do
    for renderer in $renderers; do
        image=$dir/$renderer-$level
        [ -f "$image.exr" ] || "$isoshade" render "$volume" --scene refscenes/hero.scene.json --size "$size" --with "$renderer" \
            --level "$level" $([ "$level" = 0 ] || echo --adapt) $([ "$renderer" = povray ] && echo --step 0.25) -q --png "$image.png" -o "$image.exr"
        # compare's exit code 1 says that images differ, as those of different programs do
        "$isoshade" compare "$dir/reference-$level.exr" "$image.exr" --json >"$image.json" || [ $? = 1 ]
    done
done

# One page by gnuplot, of which poppler makes a JPEG at 200 dpi.
rmse() { sed -n 's/.*"rmse": *\([0-9.e+-]*\).*/\1/p' "$1" | head -n 1; }
{
    cat <<GNUPLOT
full_w = ${size%x*}.0; full_h = ${size#*x}.0 # with a point: no division of whole numbers
scale = 256 / full_w # of a panel on the page: 256 pixels at 100 dpi
w = 256.0; h = scale * full_h; left = 48; top = 36; line = 20
width = left + $(echo $renderers | wc -w) * w; height = top + 3 * (h + line)
set terminal pdfcairo size width / 100, height / 100 background "#000000" font "DejaVu Sans,9"
set output page
unset key; unset border; unset tics
set xrange [0 : full_w]; set yrange [0 : full_h]
array part[3] = ["full resolution", "1/8 of the voxels", "1/64 of the voxels"]
set multiplot
GNUPLOT
    row=0
    for level in 0 1 2; do
        column=0
        for renderer in $renderers; do
            text="RMSE to the reference $(printf '%.5f' "$(rmse "$dir/$renderer-$level.json")")"
            [ "$renderer" = reference ] && text="double precision"
            case $renderer in
                gl) title="ray caster (OpenGL)" ;;
                cycles) title="Blender Cycles" ;;
                povray) title="POV-Ray" ;;
                *) title=$renderer ;;
            esac
            cat <<GNUPLOT
x = left + $column * w; y = height - top - ($row + 1) * (h + line) + line
unset label
set label "$text" at graph 0.5, screen (y - 0.3 * line) / height center front tc rgb "#b8b8b8" font ",9"
if ($row == 0) set label "$title" at graph 0.5, screen 1 - 0.55 * top / height center front tc rgb "#ffffff" font ",13"
if ($column == 0) set label "level $level" at screen 0.32 * left / width, screen (y + 0.5 * h) / height center rotate front tc rgb "#ffffff" font ",13"
if ($column == 0) set label part[$row + 1] at screen 0.72 * left / width, screen (y + 0.5 * h) / height center rotate front tc rgb "#b8b8b8" font ",9"
set lmargin at screen x / width; set rmargin at screen (x + w) / width
set bmargin at screen y / height; set tmargin at screen (y + h) / height
plot "$dir/$renderer-$level.png" binary filetype=png origin=(0.5, 0.5) dx=1 dy=1 with rgbimage
GNUPLOT
            column=$((column + 1))
        done
        row=$((row + 1))
    done
} >"$dir/hero.gp"
gnuplot -e "page = '$dir/hero.pdf'" "$dir/hero.gp"
pdftoppm -r 200 -jpeg -jpegopt quality=85,optimize=y -singlefile "$dir/hero.pdf" "${out%.jpg}"
echo "$out: $(stat -c %s "$out") bytes"
