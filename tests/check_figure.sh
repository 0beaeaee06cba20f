#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# Publication figures as a journal takes them: fonts inside, text that is text and apart, sizes, resolution, the scale bar.
. "$(dirname "$0")/lib.sh"
cd "$top" || exit 1
"$ISOSHADE" make shells --size 24x26x22 --quiet -o "$dir/v.nrrd"
for level in 0 1; do
    "$ISOSHADE" render "$dir/v.nrrd" --scene refscenes/shells.scene.json --level $level --size 48x30 --quiet -o "$dir/level-$level.exr" >/dev/null
done
cd "$dir" || exit 1

# A report of so many levels, with these methods, and a comparison for each of these renderers.
report() { # folder, levels, "methods", "renderers"
    mkdir -p "$1/images"
    cp level-0.exr level-1.exr "$1/images"
    {
        echo '{"schema": "isoshade.validate/1", "command": "x", "volume": "a/b/v.nrrd", "scene": "s.scene.json",'
        echo '"images": {"level-0": {"mm_per_pixel": 0.5}, "level-1": {"mm_per_pixel": 0.5}}, "agreement": ['
        local comma="" IFS=,
        for renderer in $4; do
            local name=${renderer%%; *} how=lock-step
            local variant=${renderer#"$name"} && variant=${variant#; }
            case $variant in limit*) how=limit variant=${variant#limit} variant=${variant#; } ;; esac
            echo "$comma"'{"scene": "s", "level": 0, "a": "reference", "renderer": "'"$name"'", "comparison": "'"$how"'", "variant": "'"$variant"'", "tier": "convergence", "image_a": "level-0", "image_b": "level-1", "verdict": "agree"}'
            comma=,
        done
        echo '], "consistency": ['
        comma=""
        for method in $3; do
            for ((level = 1; level < $2; ++level)); do
                echo "$comma"'{"method": "'"$method"'", "level": '$level', "image": "level-1", "reference_image": "level-0", "ssim_dissimilarity_mean": 0.1, "flip_mean": 0.2, "gradient_angle_mean_deg": 3}'
                comma=,
            done
        done
        echo ']}'
    } >"$1/report.json"
}
report four 4 on-the-fly,naive,eq1,moments gl,povray,cycles
report long 4 "directions on the fly from the level's own scalar,moments of the gradients with coherence as length" \
    "the ray caster in OpenGL by the same samples,Cycles by the mean over seeds,povray"
report methods 4 moments "gl,gl; limit,gl; naive; adapted TF,gl; eq1" && sed -i 's/; /, /g' methods/report.json
report one 1 "" gl

# What a word processor's checks would look at.
millimeters() { pdfinfo "$1" | awk '/Page size/ {printf "%.0f %.0f", $3 / 72 * 25.4, $5 / 72 * 25.4}'; }
fonts_are_inside() { pdffonts "$1" | awk 'NR > 2 {++n; if ($(NF - 4) != "yes") bad = 1} END {exit !(n > 0 && !bad)}'; }
# gnuplot 6 draws the color legend as an image one pixel wide, a pixel a shade: that is no picture.
dense_enough() {
    pdfimages -list "$1" | awk 'NR > 2 && $4 > 1 {++n; if ($13 < 300 || $14 < 300) bad = 1} END {exit !(n > 0 && !bad)}'
}
# Words may touch no other word, and lie on the page.
words_are_apart() {
    pdftotext -bbox "$1" - | tr -d '\r' | awk -F'"' '/<page/ {w = $2; h = $4}
        /<word/ {++n; l[n] = $2; t[n] = $4; r[n] = $6; b[n] = $8; if (l[n] < 0 || t[n] < 0 || r[n] > w || b[n] > h) {print "off the page: " $0; bad = 1}}
        END {for (i = 1; i <= n; ++i) for (j = 1; j < i; ++j)
            # The boxes hold ascenders and descenders of the font, which lines of text share.
            if (l[i] < r[j] - 0.2 && l[j] < r[i] - 0.2 && t[i] < b[j] - 1.5 && t[j] < b[i] - 1.5) {print "words " i " and " j " meet at " l[i] " " t[i]; bad = 1}
            exit !(n > 0 && !bad)}'
}
# Sizes stand in the figure's own script.
readable() {
    awk '$1 ~ /^(title|note)_pt$/ {++found; if ($3 < 6 || $3 > 9) bad = 1} END {exit found != 2 || bad}' "$1/figure.gp"
}
# Text beyond the edge of the page is no text to the reader.
words_are_all_there() { # pdf, words: each of them is in it
    local word found
    found=$(pdftotext -bbox "$1" - | sed -n 's/.*<word.*>\(.*\)<.word>.*/\1/p' | sed "s/&apos;/'/")
    for word in $2; do grep -qxF -- "$word" <<<"$found" || { echo "no $word"; return 1; }; done
}
# The bar's white pixels beside the panel's, at 1200 dpi: the part of the panel that figure.csv says, within a pixel at each end.
bar_is_right() { # the figure's folder
    local high row
    high=$(pdfinfo "$1/figure.pdf" | awk '/Page size/ {print $5 / 72 * 1200}')
    row=$(awk -F, -v high="$high" 'NR == 2 {print int((1 - $7 - 0.05 * ($8 - $7)) * high - 0.25 / 25.4 * 1200)}' "$1/figure.csv")
    pdftoppm -r 1200 -gray -f 1 -l 1 -x 0 -y "$row" -W 100000 -H 1 "$1/figure.pdf" print
    awk -F, 'NR == 2 {print $5, $6, $12}' "$1/figure.csv" >place
    python3 - print*.pgm <<'END'
import re, sys
left, right, bar = map(float, open('place').read().split())
magic, size, depth, line = open(sys.argv[1], 'rb').read().split(b'\n', 3)
wide, high = map(int, size.split())
assert high == 1
line = line[int(left * wide):int(right * wide)]
longest = max(map(len, re.findall(b'\xff+', line)))
if abs(longest - bar * (right - left) * wide) > 2: print(longest, 'pixels, wanted', bar * (right - left) * wide); sys.exit(1)
END
}
# The most panels on a page, and the longest words in a column.
for kind in levels renderers; do
    for from in four_178 long_85; do
        width=${from#*_} from=${from%_*}
        name=${from}_${kind}_$width
        methods=()
        [ $kind = levels ] && methods=(--methods "$(sed -n 's/.*"method": "\([^"]*\)".*/\1/p' $from/report.json | uniq | paste -sd,)")
        expect "$name" 0 "$ISOSHADE" figure $from --formats $([ $name = four_levels_178 ] && echo svg || echo pdf) --sources --kind $kind --width $width "${methods[@]}" -o $name
        read -r wide high <<<"$(millimeters $name/figure.pdf)"
        check ${name}_fits test "$wide" -le $width -a "$high" -le 230
        check ${name}_has_its_fonts fonts_are_inside $name/figure.pdf
        check ${name}_has_300_dpi dense_enough $name/figure.pdf
        check ${name}_can_be_read readable $name
        check ${name}_has_its_words_apart words_are_apart $name/figure.pdf
        keys=$([ $kind = levels ] && echo method || echo b)
        words=$(sed -n 's/.*"'$keys'": "\([^"]*\)".*/\1/p' $from/report.json | uniq)
        [ $name = four_levels_178 ] && words="directions on the fly means of weighted (Eq. 1) moments"
        [ $name = four_renderers_178 ] && words="OpenGL ray caster POV-Ray Blender Cycles"
        [ $name = long_renderers_85 ] && words="${words//povray/POV-Ray}"
        check ${name}_has_all_its_words words_are_all_there $name/figure.pdf "$words"
    done
done
# Planted: titles that are twice as large as the layout knows run into each other.
cp -r long_renderers_85 planted && sed -i 's/^title_pt = [0-9.]*/title_pt = 14/' planted/figure.gp
(cd planted && gnuplot -e "format='pdf'" figure.gp)
check words_that_meet_are_noticed test -n "$(words_are_apart planted/figure.pdf)"

# The bar: its line in the SVG beside the panel that it stands in, 48 pixels of 0.5 mm.
check the_bar_says_5_mm grep -q '5 mm' four_levels_178/figure.svg
check the_bar_has_its_length_in_print bar_is_right four_levels_178
cp -r four_levels_178 longer
sed -i 's|^\(set object rectangle from [0-9.]*, [0-9.]* to \)\([0-9.]*\)\(.*noborder\)|\1\2 + 0.5\3|' longer/figure.gp && (cd longer && gnuplot -e "format='pdf'" figure.gp)
check a_longer_bar_is_noticed test -n "$(bar_is_right longer)"
check the_bar_has_its_length awk -F, 'NR == 2 {exit !($13 == "5 mm" && ($12 - 5 / 24) ^ 2 < 1e-8)}' four_levels_178/figure.csv

check renderers_stand_in_order test "$(awk -F, 'NR > 1 && $9 != "-" {print $9}' four_renderers_178/figure.csv | paste -sd' ')" = "Blender Cycles OpenGL ray caster POV-Ray"
check the_caption_names_the_file grep -q 'level 0 of v.nrrd (s.scene.json)' four_renderers_178/caption.txt
check the_caption_says_how_dense_a_reports_pictures_are grep -qE 'Pictures have [0-9]+ x [0-9]+ pixels, [0-9]+ per inch, each drawn as ([0-9]+) x \1 dots' four_renderers_178/caption.txt
check the_caption_has_the_bar grep -q 'Scale bar: 5 mm' four_renderers_178/caption.txt
expect renderers_alone 0 "$ISOSHADE" figure methods --formats pdf --dpi 72 --kind renderers --sources -o renderers
check methods_stay_away test "$(cut -d, -f9 renderers/figure.csv | tr "|" " " | grep GL | paste -sd+)" = "OpenGL ray caster+OpenGL ray caster; limit of halved steps"
check a_limit_keeps_its_comma words_are_all_there renderers/figure.pdf "OpenGL ray caster, limit of halved steps"
expect a_variant_can_be_asked_for 0 "$ISOSHADE" figure methods --formats pdf --dpi 72 --kind renderers --variant adapted --sources -o variant
check it_stands_alone test "$(cut -d, -f9 variant/figure.csv | tr "|" " " | grep GL)" = "OpenGL ray caster; means of directions; adapted TF"
check with_its_comma words_are_all_there variant/figure.pdf "OpenGL ray caster, means of directions, adapted TF"
refuse an_unknown_variant_is_named 5 'name like tensor' "$ISOSHADE" figure methods --kind renderers --variant tensor -o f
sed '0,/"scene": "s", "level"/s//"scene": "other", "level"/' four/report.json >r.json && cp -r four suite && mv r.json suite/report.json
refuse a_suite_has_many_scenes 5 'has 2 scenes, --scene chooses one: ' "$ISOSHADE" figure suite --kind renderers -o f
expect one_scene_of_a_suite 0 "$ISOSHADE" figure suite --formats pdf --dpi 72 --kind renderers --scene s --sources -o of_suite
check it_has_the_others_only test "$(cut -d, -f9 of_suite/figure.csv | grep -cE 'OpenGL|POV-Ray|Cycles')" = 2
refuse no_scene_of_that_name 5 'no pictures of comparisons' "$ISOSHADE" figure suite --kind renderers --scene t -o f
refuse methods_are_for_levels 2 'kind renderers does not take --methods' "$ISOSHADE" figure four --kind renderers --methods naive -o f
refuse variants_are_for_renderers 2 'kind levels does not take --variant' "$ISOSHADE" figure four --variant naive -o f
check the_caption_names_the_scene grep -q 'level 0 of v.nrrd (s)' of_suite/caption.txt
expect one_level_has_renderers 0 "$ISOSHADE" figure one --formats pdf --dpi 72 --kind renderers -o one_renderers
refuse one_level_has_no_levels 5 'no pictures of levels' "$ISOSHADE" figure one -o f
sed 's/"consistency"/"other"/' one/report.json >r.json && mkdir bare && mv r.json bare/report.json
refuse a_report_without_consistency_is_refused 5 'no pictures of levels' "$ISOSHADE" figure bare -o f
report torn 3 moments gl && rm torn/images/level-1.exr
refuse a_missing_image_is_named 3 'torn/images/level-1.exr' "$ISOSHADE" figure torn -o f
head -c 2000 four/images/level-1.exr >torn/images/level-1.exr
refuse half_an_image_is_refused 4 'level-1.exr' "$ISOSHADE" figure torn -o f
refuse a_figure_too_narrow_is_refused 5 'do not fit' "$ISOSHADE" figure long --kind renderers --width 40 -o f
refuse a_width_that_is_none 5 '--width is 20' "$ISOSHADE" figure four --width 20 -o f
refuse a_height_that_is_none 5 '--height is 2000' "$ISOSHADE" figure four --height 2000 -o f
mkdir mine && touch mine/thesis.txt
refuse a_folder_of_somebody_else_is_kept 3 mine "$ISOSHADE" figure four -o mine
# /proc takes no files from anybody, root included.
refuse a_folder_that_takes_no_files 3 /proc/figure "$ISOSHADE" figure four -o /proc/figure

# Of a volume: rendered for its place in print, a pixel a dot, the same as render gives; no picture twice, nothing left over.
expect a_volume_is_drawn 0 "$ISOSHADE" figure v.nrrd --scene "$top/refscenes/shells.scene.json" --size 48x30 --levels 3 --width 85 -o volume -q
check only_the_figure_is_there test "$(cd volume && echo *)" = 'caption.txt figure-latex.pdf figure-latex.tex figure.pdf figure.png figure.svg'
pixels=$(pdfimages -list volume/figure.pdf | awk 'NR > 2 && $4 > 1 && $4 < 6 * $5 {print $4 "x" $5}' | uniq)
check its_pictures_are_alike test "$(wc -w <<<"$pixels")" = 1
check they_have_300_dpi dense_enough volume/figure.pdf
check its_words_are_apart words_are_apart volume/figure.pdf
check its_fonts_are_inside fonts_are_inside volume/figure.pdf
# The first mark of a transfer function's bar may stand at its very end, as that of Hounsfield units from -1024 on.
python3 - <<'END'
import array
values = array.array('h', ((4010 * (x + y + z) // 33 - 1024) if 2 < x < 9 and 2 < y < 9 else -1024
                           for z in range(12) for y in range(12) for x in range(12)))
with open('hounsfield.nrrd', 'wb') as f:
    f.write(b'NRRD0004\ntype: int16\ndimension: 3\nsizes: 12 12 12\nspacings: 1 1 1\nendian: little\nencoding: raw\n\n')
    values.tofile(f)
END
expect a_range_below_zero 0 "$ISOSHADE" figure hounsfield.nrrd --levels 2 --width 85 --tf ct-bone --formats pdf -q -o hounsfield
check has_its_marks_on_the_page words_are_apart hounsfield/figure.pdf
check the_first_one_too words_are_all_there hounsfield/figure.pdf −1000
expect a_narrow_one 0 "$ISOSHADE" figure hounsfield.nrrd --levels 1 --width 40 --tf ct-bone --formats pdf -q -o narrow
check has_them_as_well words_are_apart narrow/figure.pdf
check it_keeps_the_aspect test "$(awk -Fx '{d = $2 - $1 * 30 / 48; print (d * d < 1)}' <<<"$pixels")" = 1
mkdir panels && pdfimages volume/figure.pdf panels/p
for level in 0 1 2; do
    "$ISOSHADE" render v.nrrd --scene "$top/refscenes/shells.scene.json" --level $level --size "$pixels" -q -o "print$level.png" >/dev/null
done
in_the_figure() { # PNG ...: each stands in the figure once, and no picture of it stands there twice
    PYTHONPATH=$top/tests python3 - "$@" <<'END'
import glob, sys
from sheet_panel import load
def pixels(path):
    return b"".join(bytes(p) for row in load(path) for p in row)
figure = [open(p, "rb").read().split(b"\n", 3)[3] for p in sorted(glob.glob("panels/p-*.ppm"))]
sys.exit(any(figure.count(pixels(p)) != 1 for p in sys.argv[1:]) or len(set(figure)) < len(figure))
END
}
check its_pictures_are_those_of_render in_the_figure print0.png print1.png print2.png
"$ISOSHADE" render v.nrrd --scene "$top/refscenes/shells.scene.json" --level 1 --size "$pixels" --step 0.4 -q -o other.png >/dev/null
notice another_picture_is_noticed in_the_figure other.png
expect renderers_of_a_volume 0 "$ISOSHADE" figure v.nrrd --formats pdf --scene "$top/refscenes/shells.scene.json" --size 24x15 --kind renderers --with gl --dpi 72 --width 85 -o two -q
check the_caption_names_what_differs grep -q 'OpenGL ray caster: RMSE 0' two/caption.txt
refuse methods_of_levels_are_two 2 'default, optimized or' "$ISOSHADE" figure v.nrrd --methods naive -o f
refuse pictures_of_a_report_are_there 2 'with its own pictures' "$ISOSHADE" figure four --size 20 -o f
refuse levels_that_are_not_there 5 'would show level 9' "$ISOSHADE" figure v.nrrd --levels 10 -o f -q
refuse a_folder_that_is_not_there 3 nowhere "$ISOSHADE" figure four -o nowhere/figure
exit $failed
