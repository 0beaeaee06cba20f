# SPDX-License-Identifier: MIT
# Figure 9 of [diaz-garcia-2016]: SSIM dissimilarity to level 0; one panel per level, one pair of bars per volume.
name = 'figure9'
width = 1100
height = 420
load 'style.gp'
data = name . '.csv'
set datafile separator comma
volumes = ''
level_list = ''
known(list, m) = strstrt(list, '"' . m . '"') > 0
stats data skip 1 using (known(volumes, strcol(1)) ? 0 : (volumes = volumes . ' "' . strcol(1) . '"', 0)) nooutput
stats data skip 1 using (known(level_list, strcol(2)) ? 0 : (level_list = level_list . ' "' . strcol(2) . '"', 0)) nooutput
set style fill solid 0.85 noborder
set boxwidth 0.36
set xrange [-0.7 : words(volumes) - 0.3]
set yrange [0:*]
set xtics ('' 0)
do for [i = 1:words(volumes)] { set xtics add (word(volumes, i) i - 1) }
set xtics rotate by -35 noenhanced scale 0
set ylabel '1 - SSIM'
set grid ytics noxtics
set key outside top center horizontal
set multiplot layout 1, words(level_list)
do for [l in level_list] {
    set title 'level ' . l offset 0, -0.5
    plot data using (strcol(2) eq l && strcol(3) eq 'original' ? $5 - 0.2 : NaN):4 with boxes lc rgb vermillion title 'original', \
         data using (strcol(2) eq l && strcol(3) eq 'default' ? $5 + 0.2 : NaN):4 with boxes lc rgb blue title 'adapted'
}
unset multiplot
