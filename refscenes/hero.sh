#!/bin/sh
# SPDX-License-Identifier: MIT
# The picture of README.md: a brain at three levels in several renderers, and how far each is from the reference.
#   sh refscenes/hero.sh [PICTURE.jpg [DPI]]     DPI: of the print, 178 mm wide (150)
#   HERO_RENDERERS="reference,gl" sh refscenes/hero.sh     these alone
set -eu
cd "$(dirname "$0")/.."
out=${1:-build/figures/hero.jpg}
isoshade=${ISOSHADE:-./isoshade}
volume=/usr/share/mricron/templates/ch2bet.nii.gz
[ -r "$volume" ] || { echo "hero: $volume is missing; it comes with the Debian package mricron-data" >&2; exit 3; }
mkdir -p build/figures "$(dirname "$out")"
"$isoshade" figure "$volume" --kind grid --scene refscenes/hero.scene.json --levels 3 --adapt \
    --with "${HERO_RENDERERS:-reference,gl,cycles,povray}" --dpi "${2:-150}" -q -o build/figures/hero >/dev/null
pdftoppm -r "${2:-150}" -jpeg -jpegopt quality=88,optimize=y -singlefile build/figures/hero/figure.pdf "${out%.jpg}"
echo "$out: $(stat -c %s "$out") bytes"
