#!/bin/sh
# SPDX-License-Identifier: MIT
# Draws the pictures of doc/ again, into doc/figures.
#   sh refscenes/figures.sh              all of them: hours, since some time a machine
#   sh refscenes/figures.sh quick        those that take minutes: hero sheet report levels adaptive-tf seams failures palettes papers kinds
#   sh refscenes/figures.sh NAME ...     these; the others are codes sensitivity scale chart chart-page
#                                        certificates opened viewer addon first-pictures
# What needs a volume or a program that is not there says so and is left out: the volume of $ENGINE (256 x 256 x 128, else
# ../shared/data/engine_256x256x128.nrrd), the folder $VOLUMES of doc/results/first-pictures.md, Xvfb, ImageMagick,
# Chromium, teem-unu (of teem-apps).
# What is made on the way stays in build/figures.
set -eu
cd "$(dirname "$0")/.."
isoshade=${ISOSHADE:-$PWD/isoshade}
templates=/usr/share/mricron/templates
engine=${ENGINE:-../shared/data/engine_256x256x128.nrrd}
work=$PWD/build/figures
out=$PWD/doc/figures
mkdir -p "$work"

screenshot() { # page, picture, width, height
    chromium --headless --no-sandbox --disable-gpu --hide-scrollbars --force-device-scale-factor=0.75 --window-size="$3,$4" \
        --user-data-dir="$work/browser" --virtual-time-budget=20000 --screenshot="$2" "file://$1" 2>/dev/null
}

hero() { sh refscenes/hero.sh "$out/hero.jpg"; } # README.md
sheet() { # doc/reference/tf-formats.md
    kind sheet.png $templates/ch2bet.nii.gz --kind sheet --tf auto --tf mri-brain --tf ct-vessels --tf angiography --width 110
}
report() { # doc/method/comparison.md
    "$isoshade" validate $templates/ch2bet.nii.gz --scene refscenes/brain.scene.json --quick --with gl --levels 2 --size 256 \
        -q -o build/figures/report # the page shows the command
    screenshot "$work/report/index.html" "$out/report.png" 1300 1680
}
levels() { # doc/guide/blender.md
    "$isoshade" export $templates/ch2.nii.gz --to blender --scene refscenes/brain.scene.json --levels 3 --adapt \
        --size 240x240 -q -o "$work/brain.blend"
    blender -b "$work/brain.blend" -P refscenes/levels.py >/dev/null
    cp "$work/brain_level_0.png" "$work/brain_level_1.png" "$work/brain_level_2.png" "$out"
    "$isoshade" export $templates/ch2.nii.gz --to blender --scene refscenes/brain.scene.json --level 1 --adapt \
        --material physical -q -o "$work/lit.blend"
    blender -b "$work/lit.blend" -P refscenes/lamps.py >/dev/null
    cp "$work/brain_lit.jpg" "$out"
}
viewer() { # doc/guide/viewer.md
    "$isoshade" view $templates/ch2bet.nii.gz --scene refscenes/hero.scene.json -q -o "$work/viewer.html"
    python3 tests/view_page.py shot "$work/viewer.html" "$out/viewer.jpg"
}
chart_page() { # doc/results/chart.md
    "$isoshade" chart $templates/ch2bet.nii.gz --scene refscenes/brain.scene.json --budget 25 -q -o "$work/chart-quick" >/dev/null
    python3 tests/chart_page.py "$work/chart-quick/index.html" "$work"
    cp "$work/wide.jpg" "$out/chart-page.jpg"
}
certificates() { # doc/results/fidelity.md
    bash tests/peers/fidelity.sh
    PYTHONPATH=tests:tests/peers python3 tests/certificate_page.py build/fidelity/site/index.html \
        "$out/certificates.png"
}
opened() { # doc/guide/blender.md: the window of Blender by Xvfb, and ImageMagick's import
    "$isoshade" export $templates/ch2bet.nii.gz --to blender --scene refscenes/hero.scene.json --level 1 --size 400x330 \
        --force -q -o "$work/opened.blend"
    # Shown is a view with many colors in its middle that no longer changes, however long its shaders take.
    xvfb-run -a -s '-screen 0 1280x800x24' sh -c 'blender --factory-startup -p 0 0 1280 800 "$1" \
        --python-expr "import bpy; bpy.context.preferences.view.show_splash = False" >/dev/null 2>&1 &
        for try in $(seq 60); do
            sleep 10; import -window root "ppm:$2.now"
            [ "$(convert "ppm:$2.now" -crop 400x300+330+230 -format %k info:)" -gt 5000 ] && cmp -s "$2.now" "$2" && break
            mv "$2.now" "$2"
        done
        kill $!; [ -e "$2.now" ]' opened "$work/opened.blend" "$work/opened.ppm"
    convert "$work/opened.ppm" -quality 80 "$out/blender-opened.jpg"
}
adaptive_tf() { # doc/method/adaptive-tf.md
    kind adaptive-tf.png $templates/ch2.nii.gz --scene refscenes/brain.scene.json --kind tf --levels 4 --adapt --width 170
}
seams() { "$isoshade-lab" seams -o "$out/mixed-resolution-seams.png"; } # doc/method/mixed-resolution.md
failures() { # doc/results/failures.md
    "$isoshade" atlas --case vanishing-gradients,sharp-tf,code-poles -q -o "$work/atlas"
    screenshot "$work/atlas/index.html" "$out/failures.png" 1150 2720
}
palettes() { # doc/results/palettes.md
    "$isoshade" palette --ellipsoid 5000 --method anneal --entries 510 --steps 2000 -q -o "$out/palettes-figure9.svg"
}
papers() { # doc/results/paper-figures.md
    for picture in paper-code-points.png paper-code-regions.png paper-code-spheres.png \
        paper-code-table.png paper-joint-histogram.png paper-joint-row.png \
        paper-mixed-volume.png paper-mixed-surface.png paper-palette-views.png; do
        kind=${picture#paper-} kind=${kind%.png}
        "$isoshade" figure --kind "$kind" --width 110 --dpi 150 -q -o "$work/$kind" >/dev/null
        cp "$work/$kind/figure.png" "$out/$picture"
    done
}
kind() { # picture, words of isoshade figure
    picture=$1
    shift
    rm -rf "$work/kind"
    "$isoshade" figure "$@" --dpi 150 --formats png -q -o "$work/kind" >/dev/null
    cp "$work/kind/figure.png" "$out/$picture"
}
kinds() { # doc/guide/figures.md, doc/method/adaptive-tf.md
    scene="--scene refscenes/hero.scene.json"
    kind figure-levels.png $templates/ch2bet.nii.gz $scene --levels 3 --zoom 0.35,0.3,0.25,0.25 --letters --background white --width 120
    kind figure-tf.png $templates/ch2bet.nii.gz $scene --kind tf --width 110
    kind figure-plan.png $templates/ch2bet.nii.gz $scene --kind plan --width 120
    kind figure-failure.png --kind failure --case noise --width 110
    (isoshade=$isoshade-lab && kind figure-roi.png $templates/ch2bet.nii.gz $scene --kind roi --level 3 --roi 0,90,60,90,180,150 --width 170)
    kind figure-slices.png $templates/ch2bet.nii.gz --kind slices --levels 3 --width 110
    kind figure-turntable.png $templates/ch2bet.nii.gz $scene --kind turntable --frames 6 --zoom 0.86 --width 120
}

# Longer ones.
codes() { # doc/results/direction-codes.md
    "$isoshade-lab" encode --chart "$work"
    cp "$work/figure10.svg" "$out/gradients-figure10.svg"
}
sensitivity() { # doc/results/validation.md
    "$isoshade-lab" power --sensitivity -q -o "$work/sensitivity"
    cp "$work/sensitivity/sensitivity.svg" "$out/validation-sensitivity.svg"
}
scale() { # doc/guide/large-volumes.md: 4 minutes, 12 GB of disk and of memory
    "$isoshade" bench scale --largest 1024 -q -o "$work/scale" >/dev/null
    cp "$work/scale/scale.svg" "$out/scale.svg"
}
chart() { # doc/results/chart.md
    "$isoshade" chart $templates/ch2bet.nii.gz --scene refscenes/brain.scene.json --size 128 --codes fit --filters moments \
        --estimators central --processor-time --budget 165 --want 1/255 -q -o "$work/chart-brain"
    cp "$work/chart-brain/pareto.svg" "$out/chart-brain.svg"
}
addon() { # doc/guide/blender.md; by Xvfb and ImageMagick
    make -s SETUP=no addon
    rm -rf "$work/addon" && mkdir -p "$work/addon/scripts" "$work/addon/config" "$work/addon/extensions"
    "$isoshade" make marschner-lobb --size 40 -q -o "$work/addon/lobb.nrrd"
    BLENDER_USER_SCRIPTS=$work/addon/scripts BLENDER_USER_CONFIG=$work/addon/config BLENDER_USER_EXTENSIONS=$work/addon/extensions \
        xvfb-run -a -s "-screen 0 1100x1000x24" blender --factory-startup -noaudio --window-geometry 0 0 1100 1000 \
        -P refscenes/addon_picture.py -- "$PWD/build/release/isoshade-blender-addon.zip" "$(realpath "$isoshade")" \
        "$work/addon/lobb.nrrd" "$PWD/refscenes/marschner-lobb.scene.json" "$work/addon" "$work/addon/window.png" >"$work/addon/log"
    convert "$work/addon/window.png" -crop 670x830+238+78 +repage -resize 90% -colors 128 -strip "$out/blender-addon.png"
}
first_pictures() { # doc/results/first-pictures.md, which says where the volumes are from
    sh refscenes/first-pictures.sh "$VOLUMES" "$work/first-pictures" 224
    montage -label %t "$work"/first-pictures/tuned-*.png "$work"/first-pictures/reported-*.png -resize 200x200 -tile 7x \
        -geometry +2+2 -pointsize 9 -quality 86 "$out/first-pictures.jpg"
}

# What a picture needs: files, and programs without a slash.
needs() { # name
    case $1 in
        hero) echo $templates/ch2bet.nii.gz blender povray pdftoppm ;;
        sheet | chart | kinds) echo $templates/ch2bet.nii.gz ;;
        adaptive-tf) echo $templates/ch2.nii.gz ;;
        report) echo $templates/ch2bet.nii.gz chromium ;;
        levels) echo $templates/ch2.nii.gz blender ;;
        viewer | chart-page) echo $templates/ch2bet.nii.gz chromium python3 ;;
        certificates) echo chromium blender povray npm xvfb-run ;;
        opened) echo $templates/ch2bet.nii.gz blender xvfb-run import ;;
        failures) echo chromium ;;
        addon) echo blender xvfb-run convert ;;
        first-pictures) echo "${VOLUMES:-./\$VOLUMES}" montage ;;
    esac
}
missing() { # name: the first thing that it needs and that is not there
    for need in $(needs "$1"); do
        case $need in
            */*) [ -r "$need" ] || { echo "$need"; return; } ;;
            *) command -v "$need" >/dev/null || { echo "$need"; return; } ;;
        esac
    done
}

quick="hero sheet report levels adaptive-tf seams failures palettes papers kinds"
longer="codes sensitivity scale chart chart-page certificates opened viewer addon first-pictures"
[ $# -gt 0 ] || set -- $quick $longer
[ "$*" != quick ] || set -- $quick
skipped=
for name in "$@"; do
    case " $quick $longer " in *" $name "*) ;; *) echo "figures: no \"$name\" among them" >&2; exit 2 ;; esac
    lacks=$(missing "$name")
    if [ -n "$lacks" ]; then
        echo "figures: $name is left out: $lacks is not there"
        skipped="$skipped $name"
        continue
    fi
    echo "figures: $name"
    $(echo "$name" | tr - _)
done
[ -z "$skipped" ] || echo "figures: left out:$skipped"
