# SPDX-License-Identifier: MIT
# Each direction filter on each scene: angle to the field's own gradients, one panel per scene.
name = 'filters'
data = name . '.csv'
set datafile separator comma
scenes = ''; filters = ''
known(list, w) = strstrt(list, '"' . w . '"') > 0
stats data skip 1 using (known(scenes, strcol(1)) ? 0 : (scenes = scenes . ' "' . strcol(1) . '"', 0)) nooutput
stats data skip 1 using (known(filters, strcol(2)) ? 0 : (filters = filters . ' "' . strcol(2) . '"', 0)) nooutput
stats data skip 1 using 3 nooutput
count = words(filters); panels = words(scenes); rows = (panels + 2) / 3
width = 980
legend_rows = (count + 5) / 6
height = 205 * rows + 20 * legend_rows + 44
load 'style.gp'
set linetype 9 lc rgb '#8c564b' lw 1.6 pt 12 ps 0.6
set linetype 10 lc rgb '#17becf' lw 1.6 pt 3 ps 0.6
set linetype 11 lc rgb '#7f7f00' lw 1.6 pt 2 ps 0.6
set linetype 12 lc rgb '#444444' lw 1.6 pt 1 ps 0.6 dt 2
set linetype cycle 12
set xtics 1 offset 0,0.4
set xrange [STATS_min - 0.15 : STATS_max + 0.15]
set logscale y
unset key
top(row) = 1 - (32.0 + 205.0 * row) / height
set multiplot
do for [p = 1:panels] {
    row = (p - 1) / 3; column = (p - 1) % 3
    set lmargin at screen 0.075 + 0.318 * column
    set rmargin at screen 0.075 + 0.318 * column + 0.268
    set tmargin at screen top(row)
    set bmargin at screen top(row) - 140.0 / height
    set title word(scenes, p) offset 0,-0.5 noenhanced
    set ylabel (column == 0 ? 'angle to exact gradients, °' : '') offset 0.5,0
    set xlabel (p + 3 > panels ? 'level' : '') offset 0,0.7
    if (p == 1) {
        do for [i = 1:count] {
            set label i word(filters, i) at screen 0.06 + 0.157 * ((i - 1) % 6), screen (20.0 * (legend_rows - (i - 1) / 6) - 8) / height left offset 1.2, -0.25 point lt i ps 0.8 noenhanced
        }
    }
    plot for [i = 1:count] data skip 1 using (strcol(1) eq word(scenes, p) && strcol(2) eq word(filters, i) ? $3 : NaN):4 with linespoints lt i
    if (p == 1) { do for [i = 1:count] { unset label i } }
}
unset multiplot
