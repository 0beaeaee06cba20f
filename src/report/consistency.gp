# SPDX-License-Identifier: MIT
# Distance of each level from level 0, one color per method, solid under the original TF and dashed under the adapted one:
# structure, visible difference, directions.
name = 'consistency'
data = name . '.csv'
set datafile separator comma
methods = ''
known(m) = strstrt(methods, '"' . m . '"') > 0
stats data skip 1 using (known(strcol(1)) ? 0 : (methods = methods . ' "' . strcol(1) . '"', 0)) nooutput
stats data skip 1 using (strcol(8) eq 'adapted') nooutput
adapted = STATS_max > 0
stats data skip 1 using 9 nooutput
kept = STATS_max > 0
# A TF that shows nothing has no directions; gnuplot draws no picture without points.
angles = 0
stats data skip 1 using (strstrt(strcol(6), 'nan') ? 0 : (angles = 1, 0)) nooutput
stats data skip 1 using 2 nooutput
count = words(methods)
width = 980
method_rows = (count + 3) / 4
legend_rows = method_rows + (adapted ? 1 : 0)
height = 310 + 20 * legend_rows
load 'style.gp'
of(i, tf) = strcol(1) eq word(methods, i) && strcol(8) eq tf
hollow(i) = int(word('6 4 8 12 10 7 5 9', (i - 1) % 8 + 1))
across(i) = 0.06 + 0.235 * i
up(i) = (20.0 * (legend_rows - i) - 8) / height
set xtics 1
set xlabel 'level' offset 0,0.4
set xrange [STATS_min - 0.2 : STATS_max + 0.2]
set yrange [0:*]
set multiplot layout 1,3 margins 0.055, 0.985, (62.0 + 20 * legend_rows) / height, 1 - 34.0 / height spacing 0.06,0.1
unset key
do for [i = 1:count] {
    set label i word(methods, i) at screen across((i - 1) % 4), screen up((i - 1) / 4) left offset 1.2, -0.25 point lt i ps 0.8 noenhanced
}
if (adapted) {
    set arrow 1 from screen across(0) - 0.01, screen up(method_rows) to screen across(0) + 0.025, screen up(method_rows) nohead lt 1 lc rgb black lw 1.6
    set label 100 'original TF' at screen across(0) + 0.032, screen up(method_rows) left offset 0, -0.05
    set arrow 2 from screen across(1) - 0.01, screen up(method_rows) to screen across(1) + 0.025, screen up(method_rows) nohead lt 1 dt 2 lc rgb black lw 1.6
    set label 101 'adapted TF' at screen across(1) + 0.032, screen up(method_rows) left offset 0, -0.05
}
if (kept) {
    set label 102 'adapting refused: original TF kept' at screen across(2), screen up(method_rows) left offset 1.2, -0.25 point pt 2 ps 0.9 lc rgb black
}
# Without a point gnuplot would warn.
crosses = kept ? ', data skip 1 using ($9 == 1 ? $2 : NaN):column with points pt 2 ps 0.9 lc rgb black' : ''
set title offset 0,-0.3
do for [column = 4:5] {
    set title column == 4 ? 'structure: 1 − SSIM' : 'what people see: mean FLIP'
    plot for [i = 1:count] data skip 1 using (of(i, 'original') ? $2 : NaN):column with linespoints lt i, \
         for [i = 1:count] data skip 1 using (of(i, 'adapted') ? $2 : NaN):column with linespoints lt i dt 2 pt hollow(i) @crosses
    if (column == 4) {
        do for [i = 1:count] { unset label i }
        unset arrow
        unset label
    }
}
set title 'direction error, ° (dotted: 95th percentile)'
if (angles) {
    plot for [i = 1:count] data skip 1 using (of(i, 'original') ? $2 : NaN):6 with linespoints lt i, \
         for [i = 1:count] data skip 1 using (of(i, 'original') ? $2 : NaN):7 with lines lt i dt 3 lw 1
} else {
    set yrange [0:1]
    set label 103 'none to measure' at graph 0.5, 0.5 center
    plot -1 notitle
}
unset multiplot
