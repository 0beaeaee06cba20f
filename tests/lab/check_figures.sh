#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
# The figures of the papers: what is on them is counted, and agrees with closed forms; mixed levels jump only where they
# should; fonts are inside; what cannot be drawn is refused in one sentence.
. "$(dirname "$0")/../lib.sh"
. "$top/tests/figure_forms.sh"
cd "$dir" || exit 1

draw() { # kind, options: FOLDER is KIND, facts in KIND.json
    local kind=$1
    shift
    expect "$kind" 0 "$LAB" figure "$@" --kind "$kind" --formats latex --json -q -o "$kind"
    cp out "$kind.json"
}
fact() { # file, python's way to a number of "facts"
    python3 -SE -c 'import json, sys; print(eval(sys.argv[2], {"f": json.load(open(sys.argv[1]))["facts"]}))' "$1.json" "$2"
}
holds() { # file, an expression of f, the facts
    [ "$(fact "$1" "$2")" = True ] || { fact "$1" f; return 1; }
}

# Directions, each once: vectors of whole numbers without a common factor; signed ones -m to m, unsigned ones odd.
distinct() { # bits, signed or unsigned
    python3 -SE - "$@" <<'END'
import sys
from math import gcd
bits, signed = int(sys.argv[1]), sys.argv[2] == "signed"
m = 2 ** (bits - 1) - 1 if signed else 2 ** bits - 1
line = range(-m, m + 1) if signed else range(-m, m + 1, 2)
print(sum(gcd(gcd(x, y), z) == 1 for x in line for y in line for z in line))
END
}
draw code-points --bits 3 --width 60 --sources
check points_are_those_of_the_texture holds code-points 'f["points"] == 512 and f["dots"]["places"] == 512'
check each_direction_is_counted_once test "$(fact code-points 'f["dots"]["directions"]')" = "$(distinct 3 unsigned)"
# A dot is a block of two lines.
dots_in() { awk -v name="$2" '$0 == name " << EOD" {on = 1; next} $0 == "EOD" {on = 0} on && NF == 0 {++n} END {print n + 0}' "$1/figure.gp"; }
check dots_are_drawn test "$(dots_in code-points '$dots')" = "$(fact code-points 'f["shown"]')"
check half_of_them_are_near test "$(fact code-points '2 * f["shown"]')" = "$(distinct 3 unsigned)"
check the_cloud_is_whole test "$(for i in 0 1 2 3 4 5; do dots_in code-points "\$cloud$i"; done | awk "{sum += \$1} END {print sum}")" = 512
draw code-dots --bits 4 --code fit --width 60
check signed_codes_too test "$(fact code-dots 'f["dots"]["directions"]')" = "$(distinct 4 signed)"
# Without a transform the biggest hole is round an axis, whose next direction is (m, 1, 1).
draw code-spheres --bits 4 --width 60
check the_hole_is_round_an_axis holds code-spheres 'abs(f["without"]["biggest_hole_deg"] - 2 * __import__("math").degrees(__import__("math").atan(2 ** 0.5 / 15))) < 3e-4'
check the_code_has_a_smaller_one holds code-spheres 'f["with"]["biggest_hole_deg"] < 0.8 * f["without"]["biggest_hole_deg"] and f["with"]["directions"] == f["without"]["directions"]'
draw code-regions --bits 3 --width 60
check regions_show_three_faces holds code-regions '0 < f["shown"] < f["dots"]["directions"]'
draw code-table --bits 3 --width 60
check the_table_is_a_triangle holds code-table 'f["entries"] == 8 * 9 // 2'
# T undoes Eq. 2, u to u (1 - l + l u): v = w = 0 and the middle stay, an edge's third moves most; by Eq. 2's own numbers.
check its_moves_are_those_of_eq_2 holds code-table '0.05 < f["longest_move"] < 0.1'

"$ISOSHADE" make constant --size 8 -q -o constant.nrrd >/dev/null
"$ISOSHADE" make plate --size 16 -q -o plate.nrrd >/dev/null
"$ISOSHADE" make plate --size 8 -q -o small.nrrd >/dev/null
draw joint-histogram constant.nrrd --levels 2 --width 60
check a_constant_is_one_pair holds joint-histogram 'f["levels"][0]["pairs"] == 1 and f["levels"][0]["rms_of_z_minus_s"] == 0 and f["levels"][0]["voxels"] == 512'
draw joint-row plate.nrrd --width 60
check a_plate_is_spread holds joint-row 'f["levels"][0]["voxels"] == 4096 and f["levels"][0]["rms_of_z_minus_s"] > 0.01 and f["row"]["deviation"] > 0'

# Nodes are floats of the range: what is interpolated twice agrees to some of their steps. Unequal faces are seen.
draw mixed-volume --bricks 8 --width 60 --dpi 36
draw mixed-surface --bricks 8 --width 44 --dpi 300
check smooth_has_no_jump holds mixed-surface 'f["jump_smooth"] < 1e-6'
check discontinuous_has holds mixed-surface 'f["jump_discontinuous"] > 0.05'
check it_is_magnified holds mixed-surface 'f["magnification"] > 2'
check three_pictures_have_300_dpi test "$(pdfimages -list mixed-surface/figure.pdf | awk 'NR > 2 && $3 == "image" && $13 >= 299 && $14 >= 299' | wc -l)" = 3
check fonts_are_in_the_file fonts_are_inside mixed-surface/figure.pdf
check a_volume_has_the_bar_of_its_transfer_function grep -q 'Bar: the transfer function' mixed-volume/caption.txt
check and_a_scale_bar grep -q 'Scale bar: ' mixed-volume/caption.txt
notice a_surface_has_a_color_and_no_such_bar grep -q 'Bar: the transfer function' mixed-surface/caption.txt
check the_caption_says_it grep -q 'of the range if each brick keeps its own samples' mixed-surface/caption.txt
draw palette-views small.nrrd --entries 60 --width 60 --dpi 36 --surface 0.4
check wings_fill_the_picture_whose_width_is_given grep -q "A picture is .* mm wide" palette-views/caption.txt
check fitted_is_nearer holds palette-views 'f["palettes"][0]["norm1"] < f["palettes"][1]["norm1"] and [p["entries"] for p in f["palettes"]] == [60, 60]'

draw seams small.nrrd --width 120 --dpi 72
draw roi plate.nrrd --level 1 --width 120 --dpi 72
latex_takes latex_takes_each_kind $kinds_of_papers
check all_kinds_are_drawn test "$(printf '%s\n' $kinds_of_papers | sort)" = "$("$LAB" figure --help | sed -n '/^figures:/,/^$/s/^  \([a-z0-9-]*\) .*/\1/p' | sort)"

refuse a_code_without_a_lattice 5 'no lattice of three' "$LAB" figure --kind code-dots --code oct24 -o f
refuse an_unknown_code 2 'must be one of' "$LAB" figure --kind code-dots --code none -o f
refuse too_many_dots 5 '--bits is 9, must be 3 to 6' "$LAB" figure --kind code-points --bits 9 -o f
refuse an_option_of_others 2 'does not take --bits' "$LAB" figure --kind joint-row --bits 4 -o f
refuse a_volume_where_none_is_shown 2 'takes no input' "$LAB" figure plate.nrrd --kind code-dots -o f
refuse a_surface_beyond_the_range 5 '--surface is 2, must be between 0 and 1' "$LAB" figure --kind mixed-surface --surface 2 -o f -q
refuse bricks_that_are_none 5 'power of two' "$LAB" figure --kind mixed-surface --bricks 3 -o f -q
refuse negative_bricks 5 '--bricks is -4' "$LAB" figure --kind mixed-volume --bricks -4 -o f -q
refuse too_few_bricks 5 '2 along each axis' "$LAB" figure constant.nrrd --kind mixed-surface --bricks 8 -o f -q
refuse an_odd_palette 5 'must be even' "$LAB" figure --kind palette-views --entries 61 -o f -q
refuse a_level_that_is_not_there 5 'needs level 9' "$LAB" figure plate.nrrd --kind joint-row --level 9 -o f -q
refuse a_region_that_is_none 2 'must be six numbers' "$LAB" figure plate.nrrd --kind roi --roi 1,2 -o f -q
refuse too_narrow 5 'leave' "$LAB" figure --kind joint-histogram --levels 5 --width 40 -o f -q
exit $failed
