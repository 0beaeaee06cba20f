#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Each kind of figure: nothing left over, texts of 6 to 9 points that touch no other, pictures with a pixel a dot, the same in
# the PNG; LaTeX takes its form.
. "$(dirname "$0")/lib.sh"
. "$top/tests/figure_forms.sh"
cd "$dir" || exit 1
"$ISOSHADE" make shells --size 24x26x22 --quiet -o v.nrrd
"$ISOSHADE" make marschner-lobb --size 24 --quiet -o ml.nrrd # its optimized level stands edits of the scene
mkdir tried && cat >tried/chart.json <<'END'
{"schema": "isoshade.chart/2", "options": {"volume": "v.nrrd", "scene": "s", "metric": "rmse", "bytes": "device"}, "cases": [
{"setting": "gl, level 1", "renderer": "gl", "level": 1, "milliseconds": 1, "device_bytes": 1000, "rmse": 0.1, "on_time_front": true, "on_bytes_front": true, "number": 1},
{"setting": "gl, level 0", "renderer": "gl", "level": 0, "milliseconds": 8, "device_bytes": 9000, "rmse": 0.002, "on_time_front": true, "on_bytes_front": true, "number": 2},
{"setting": "povray, level 0", "renderer": "povray", "level": 0, "milliseconds": 800, "device_bytes": 9900, "rmse": 0.004, "on_time_front": false, "on_bytes_front": false}]}
END

# Every picture of the PDF lies in the PNG, byte by byte but where a text or a frame stands over it.
in_the_png() { # figure's folder
    rm -f p-*.ppm && pdfimages "$1/figure.pdf" p
    PYTHONPATH=$top/tests python3 - "$1/figure.png" <<'END'
import glob, sys
from sheet_panel import load
rows = [b"".join(bytes(p[:3]) for p in row) for row in load(sys.argv[1])]
for path in glob.glob("p-*.ppm"):
    magic, size, depth, pixels = open(path, "rb").read().split(b"\n", 3)
    w, h = map(int, size.split())
    if w < 2: continue
    middle = slice(3 * (w // 8), 3 * (w - w // 8))
    lines = [pixels[3 * w * y:3 * w * (y + 1)][middle] for y in range(h)]
    best, k = 0, 3 * h // 4
    for y in range(k, len(rows) - h + k + 1):
        x = rows[y].find(lines[k])
        while x >= 0 and best < h:
            if x % 3 == 0: best = max(best, sum(rows[y - k + i][x:x + len(lines[0])] == lines[i] for i in range(h)))
            x = rows[y].find(lines[k], x + 1)
    if best < 0.5 * h: print(path, w, h, best); sys.exit(1)
END
}
# Of all forms one kind is drawn, of the others those that are looked at.
kind() { # name, options
    local name=$1
    shift
    expect "a_figure_$name" 0 "$ISOSHADE" figure "$@" --kind "$name" --width 85 --dpi 72 --formats "$forms" -q -o "$name"
    check "${name}_is_all_there" test "$(cd "$name" && echo *)" = "caption.txt figure-latex.pdf figure-latex.tex figure.pdf$more"
    check "${name}_has_its_fonts" fonts_are_inside "$name/figure.pdf"
    check "${name}_has_texts_of_6_to_9_points" sizes_are_right "$name/figure.pdf"
    check "${name}_has_a_pixel_a_dot" dense_enough "$name/figure.pdf" 71
    check "${name}_has_a_caption" grep -qE '.{60}' "$name/caption.txt"
}
forms=latex more=
kind tf v.nrrd
kind sheet v.nrrd --tf auto --tf simulation --view front --view 30,20 --view top
kind failure --case thin-plates
kind chart tried --letters
check a_chart_needs_no_kind "$ISOSHADE" figure tried --width 85 --dpi 72 --formats latex --letters -q -o usual
check and_is_drawn_as_with_one cmp usual/caption.txt chart/caption.txt
kind plan v.nrrd --error 0.2 --size 48 # the size that plans are measured at
kind slices v.nrrd --levels 2 --map viridis --unit um
kind levels ml.nrrd --scene "$top/refscenes/marschner-lobb.scene.json" --levels 2 --methods default,optimized
kind grid v.nrrd --with gl,cpu --levels 2 --adapt
kind renderers v.nrrd --with gl --level 1 --size 48x24
more=" frames turntable.png"
kind turntable v.nrrd --frames 3
forms=svg,png,latex more=" figure.png figure.svg"
kind methods ml.nrrd --scene "$top/refscenes/marschner-lobb.scene.json" --level 1 --methods moments+adapted,optimized --zoom 0.4,0.3,0.25,0.25
check an_optimized_level_is_nearer python3 -c 'import re
built, best = (float(x) for x in re.findall(r"1 - SSIM ([0-9.e-]+)", open("methods/caption.txt").read()))
assert best < 0.95 * built, (built, best)'
check in_a_figure_of_levels_too python3 -c 'import re
built, best = (float(x) for x in re.findall(r"1 - SSIM ([0-9.e-]+)", open("levels/caption.txt").read()))
assert best < 0.95 * built, (built, best)'
latex_takes latex_takes_each_kind $kinds_of_volumes
# A grid has levels downward and renderers across: a picture for each pair with the reference, and a bar.
check a_grid_has_a_picture_for_each_pair test "$(pdfimages -list grid/figure.pdf | awk 'NR > 2 && $3 == "image"' | wc -l)" = 7
check a_grid_has_its_bars grep -q 'Scale bar: .* Bar: the transfer function of level 0' grid/caption.txt
check a_grid_compares_with_the_first test "$(grep -o RMSE grid/caption.txt | wc -l)" = 4
refuse more_rows_than_there_is_room 2 'must be 1 to 4' "$ISOSHADE" figure v.nrrd --kind grid --with gl --levels 5 -o f -q
refuse a_grid_of_nothing 2 'needs a volume' "$ISOSHADE" figure --kind grid -o f
# A picture for each pair, and a bar under each row; several levels of one transfer function on one axis.
count_of() { pdfimages -list "$1/figure.pdf" | awk -v bars="$2" 'NR > 2 && ($4 > 6 * $5) == bars' | wc -l; }
check a_sheet_has_a_picture_for_each_pair test "$(count_of sheet 0)-$(count_of sheet 1)" = 6-2
check the_rows_differ test "$(rm -f s-*.ppm && pdfimages sheet/figure.pdf s && md5sum s-*.ppm | cut -d' ' -f1 | sort | uniq -d | wc -l)" = 0
check a_sheet_names_its_sides test "$(pdftotext sheet/figure.pdf - | grep -cxE 'front|30,20|top')" = 3
"$ISOSHADE" figure v.nrrd --kind tf --levels 3 --adapt --width 85 --formats pdf --sources -q -o adapted >/dev/null
check each_level_has_a_transfer_function test "$(pdftotext adapted/figure.pdf - | grep -cE '^level [0-2]')-$(count_of adapted 1)" = 3-3
curve_of() { awk '$0 == "$curve << EOD" {++n; next} $0 == "EOD" {on = 0} 1 {if (n == k && !done) print} $0 == "EOD" && n == k {done = 1}' k="$1" adapted/figure.gp; }
check an_adapted_one_is_another_one test "$(curve_of 1 | md5sum)" != "$(curve_of 2 | md5sum)"
check all_have_one_axis test "$(grep -o '^set xrange [^;]*; set yrange .0:1' adapted/figure.gp | sort | uniq -c | awk '{print $1}')" = 6
check all_kinds_are_drawn_by_a_script test "$(printf '%s\n' $kinds_of_volumes | sort)" = "$("$ISOSHADE" list | sed -n '/^kinds of figures:/,/^$/s/^  \([a-z-]*\) .*/\1/p' | sort)"
check the_png_has_the_same_pixels in_the_png methods
check the_inset_is_told_of grep -q 'rendered again with 4 times as many pixels' methods/caption.txt
check insets_have_pixels_of_their_own test "$(pdfimages methods/figure.pdf q && md5sum q-*.ppm | cut -d' ' -f1 | sort | uniq -d | wc -l)" = 0
check the_turntable_moves test "$(grep -c fcTL turntable/turntable.png)-$(grep -ao fcTL turntable/turntable.png | wc -l)-$(grep -ao fdAT turntable/turntable.png | wc -l)" = "$(grep -c fcTL turntable/turntable.png)-3-2"
# Frames are the pixels of `render`, the first one as the PNG has it without knowing of animations.
size=$(pdfimages -list turntable/figure.pdf | awk 'NR == 3 {print $4 "x" $5}')
"$ISOSHADE" render v.nrrd --size "$size" -q -o first.png >/dev/null
same() { PYTHONPATH=$top/tests python3 -c 'import sys; from sheet_panel import load; sys.exit(load(sys.argv[1]) != load(sys.argv[2]))' "$1" "$2"; }
check the_first_frame_is_that_of_render same first.png turntable/turntable.png
check and_the_first_of_the_files cmp first.png turntable/frames/000.png
check each_frame_has_a_file test "$(ls turntable/frames | tr '\n' ' ')" = "000.png 001.png 002.png "

# Six volumes at the narrowest width: the bar of the transfer function has two marks or more and says that they are
# values; a picture has a scale bar within it, or the caption says how wide it is.
says_what_it_needs() { # figure's folder
    pdftotext -bbox "$1/figure.pdf" - | python3 -c '
import re, sys
words = [(float(x0), float(x1), float(y), w) for x0, y, x1, w in re.findall(
    r"xMin=\"([\d.]+)\" yMin=\"([\d.]+)\" xMax=\"([\d.]+)\" yMax=\"[\d.]+\">([^<]*)<", sys.stdin.read())]
values = [y for x0, x1, y, w in words if w == "value"]
above = [w for x0, x1, y, w in words if values and values[0] - 12 < y < values[0] - 4]
marks = [w for w in above if re.fullmatch("[−.×0-9⁰-⁹¹²³]+", w)]
caption = open(sys.argv[1]).read()
bar = [x0 >= 0 and x1 < 40 / 25.4 * 72 for x0, x1, y, w in words if w == "mm" and y < values[0] - 20]
print(words, marks)
sys.exit(not (values and len(marks) >= 2 and len(set(marks)) == len(marks)
              and (all(bar) and bar if "Scale bar" in caption else "mm wide" in caption)))' "$1/caption.txt"
}
for name in shells sphere marschner-lobb tubes noise constant; do
    "$ISOSHADE" make $name --size 12x14x10 --quiet -o narrow.nrrd
    "$ISOSHADE" figure narrow.nrrd --kind turntable --frames 4 --width 40 --dpi 72 --formats pdf --sources -q -o "n-$name" >/dev/null
    check "a_narrow_figure_of_${name}_says_what_it_needs" says_what_it_needs "n-$name"
done
sed -i '/^set xtics (/s/(.*/(0)/' n-shells/figure.gp && (cd n-shells && gnuplot -e "format='pdf'" figure.gp)
notice a_bar_with_one_mark_is_noticed says_what_it_needs n-shells

# More frames than a page shows: all move, 32 stand on the page, the last one is near the end of the turn.
"$ISOSHADE" figure v.nrrd --kind turntable --frames 65 --size 8x6 --width 100 --dpi 36 --formats pdf -q -o many >/dev/null
check all_frames_are_files test "$(ls many/frames | wc -l)-$(grep -ao fcTL many/turntable.png | wc -l)" = 65-65
check some_of_them_are_shown test "$(pdftotext many/figure.pdf - | grep -o '[0-9.]*°' | wc -l)-$(pdftotext many/figure.pdf - | grep -o '343.4°')" = 32-343.4°
# Titles of lower rows stand between the pictures, not on them.
titles_stand_clear() { # pdf: left of each title the page is as white as paper
    pdftoppm -r 72 -gray "$1" page && python3 - "$1" <<'END'
import re, subprocess, sys
data = open("page-1.pgm", "rb").read()
magic, size, most, pixels = data.split(b"\n", 3)
width, height = map(int, size.split())
words = re.findall(r'xMin="([\d.]+)" yMin="([\d.]+)" xMax="([\d.]+)" yMax="([\d.]+)">[^<]*°<', subprocess.run(
    ["pdftotext", "-bbox", sys.argv[1], "-"], capture_output=True, text=True, check=True).stdout)
corners = [pixels[int(float(y0) + 2) * width + int(float(x0)) - 2] for x0, y0, x1, y1 in words]
print(len(words), corners)
sys.exit(not (words and min(corners) > 250))
END
}
check titles_stand_on_paper titles_stand_clear many/figure.pdf

# Letters in reading order, on the panels and not on the bars; the bar of the transfer function below what is rendered.
"$ISOSHADE" figure v.nrrd --levels 2 --width 85 --dpi 72 --zoom 0.4,0.3,0.25,0.25 --letters --background white --formats png -q -o lettered >/dev/null
letters() { pdftotext -bbox "$1" - | sed -n 's/.*xMin="\([0-9.]*\)" yMin="\([0-9.]*\)".*>(\(.\))<.*/\2 \1 \3/p' | awk '{printf "%d %d %s\n", $1 / 6, $2, $3}' | sort -n -k1,1 -k2,2 | awk '{printf "%s", $3}'; }
check letters_are_in_reading_order test "$(letters lettered/figure.pdf)" = abcde
check a_chart_has_plain_numbers test "$(pdftotext chart/figure.pdf - | tr ' ' '\n' | grep -xE '10|100|1000|0.1|0.05' | sort -u | paste -sd' ')" = "0.05 0.1 10 100 1000"
notice and_no_powers_of_ten grep -qE '[0-9]e[-0-9]' <(pdftotext chart/figure.pdf -)
check and_names_its_renderers_in_words grep -q 'OpenGL ray caster' <(pdftotext chart/figure.pdf - | tr '\n' ' ')
# Two settings nearly on each other: one number for both.
mkdir crowded && sed 's/"milliseconds": 8, "device_bytes": 9000, "rmse": 0.002/"milliseconds": 1.01, "device_bytes": 1010, "rmse": 0.099/' tried/chart.json >crowded/chart.json
"$ISOSHADE" figure crowded --kind chart --width 85 --formats pdf --sources -q -o crowd >/dev/null
numbers_of() { awk '/^\$rows1/ {on = 1} $0 == "EOD" {on = 0} on && NF == 5 && $5 > 0' "$1/figure.gp" | wc -l; }
check numbers_that_would_meet_are_one test "$(numbers_of crowd)" = 1
check a_chart_has_letters test "$(letters chart/figure.pdf)" = ab
check none_where_none_is_asked_for test -z "$(letters methods/figure.pdf)"
check the_bar_is_told_of grep -q 'Bar: the transfer function, colors over value with the opacity of' lettered/caption.txt
check the_bar_is_there test "$(pdfimages -list lettered/figure.pdf | awk 'NR > 2 && $4 > 6 * $5' | wc -l)" = 1
for name in levels renderers methods failure plan turntable; do
    check "the_bar_is_under_$name" grep -q 'Bar: the transfer function' $name/caption.txt
done
check and_is_that_of_level_0_where_others_have_their_own grep -q 'Bar: the transfer function of level 0' failure/caption.txt
notice a_figure_without_one_is_noticed grep -q 'Bar:' slices/caption.txt
check lengths_have_their_symbol grep -q 'Scale bar: [0-9]* µm' slices/caption.txt
check also_in_latex grep -q '[0-9] $.mu$m' slices/figure-latex.tex
rm -f l-*.ppm && pdfimages lettered/figure.pdf l
corner() { tail -c "$(awk 'NR == 2 {print 3 * $1 * $2; exit}' "$1")" "$1" | head -c 3 | od -An -tu1 | tr -d ' '; }
check the_background_is_paper test "$(corner l-000.ppm)" = 255255255

# A bar that is looked at along its length: the camera frames it from the side, too.
"$ISOSHADE" make constant --size 8x40x8 --type uint8 -q -o bar.nrrd
cat >bar.scene.json <<'END'
{"schema": "isoshade.scene/1", "image": {"width": 100, "height": 80},
 "camera": {"projection": "perspective", "fit": true, "direction": [0, 1, 0], "up": [0, 0, 1], "margin": 0.45, "fov_y_deg": 30},
 "lights": [{"direction": [0, 0, 1], "space": "camera", "intensity": 1}], "shading": {"ambient": 1, "diffuse": 0}, "background": [0, 0, 0],
 "tf": {"schema": "isoshade.tf/1", "range": [0, 255], "unit_distance_voxels": 1, "color_space": "linear", "table_size": 2,
        "points": [{"value": 0, "r": 1, "g": 1, "b": 1, "opacity": 0.9}, {"value": 255, "r": 1, "g": 1, "b": 1, "opacity": 0.9}]}}
END
"$ISOSHADE" figure bar.nrrd --scene bar.scene.json --kind turntable --frames 4 --width 60 --dpi 72 --formats pdf -q -o bar >/dev/null
pdfimages bar/figure.pdf bar
borders() { python3 - "$1" <<'END'
import sys
head, data = open(sys.argv[1], 'rb').read().split(b'\n255\n', 1)
width, height = map(int, head.split()[1:3])
rows = [data[3 * width * y:3 * width * (y + 1)] for y in range(height)]
assert max(rows[height // 2]) > 200, 'nothing is shown'
assert not any(rows[0]) and not any(rows[-1]) and not any(max(r[:3] + r[-3:]) for r in rows), 'the bar reaches the edge'
END
}
for frame in bar-00[0-3].ppm; do check "the_bar_is_whole_in_$frame" borders "$frame"; done

# Planted: a text of 5 points, a picture with half the pixels.
"$ISOSHADE" figure tried --kind chart --width 85 --formats pdf --sources -q -o planted >/dev/null
(cd planted && sed -i 's/^note_pt = .*/note_pt = 5/' figure.gp && gnuplot -e "format='pdf'" figure.gp)
notice small_text_is_noticed sizes_are_right planted/figure.pdf
notice few_pixels_are_noticed dense_enough methods/figure.pdf 144

# What a kind would pass over is refused, and so is what is no part of a picture.
refuse frames_are_of_turntables 2 'kind tf does not take --frames' "$ISOSHADE" figure v.nrrd --kind tf --frames 3 -o f
refuse a_kind_that_is_none 2 'kind of figure' "$ISOSHADE" figure v.nrrd --kind photo -o f
refuse several_transfer_functions_are_of_a_sheet 2 'kind tf does not take several of --tf or --view' "$ISOSHADE" figure v.nrrd --kind tf --tf auto --tf simulation -o f
refuse more_sides_than_there_is_room 5 'at most 8 times' "$ISOSHADE" figure v.nrrd --kind sheet --view={1,2,3,4,5,6,7,8,9},0 -o f
refuse levels_of_one_transfer_function 2 'goes with --adapt' "$ISOSHADE" figure v.nrrd --kind tf --levels 3 -o f -q
refuse a_map_that_is_none 2 'color map' "$ISOSHADE" figure v.nrrd --map jet -o f
refuse an_inset_beyond_the_picture 5 'parts of the picture' "$ISOSHADE" figure v.nrrd --zoom 0.9,0,0.5,0.5 -o f
refuse a_zoom_that_is_none 2 'must be X or X,Y,W,H' "$ISOSHADE" figure v.nrrd --zoom 1,2 -o f
refuse a_form_that_is_none 2 'none of pdf' "$ISOSHADE" figure v.nrrd --formats gif -o f
refuse a_case_that_is_none 2 'the atlas has no' "$ISOSHADE" figure --kind failure --case x -o f
refuse a_background_that_is_none 2 'must be white, black or' "$ISOSHADE" figure v.nrrd --background paper -o f
refuse a_background_beyond_white 5 'between 0 and 1' "$ISOSHADE" figure v.nrrd --background 0,0,2 -o f
refuse no_volume 2 'needs a volume' "$ISOSHADE" figure --kind tf -o f
check nothing_is_left test ! -e f
exit $failed
