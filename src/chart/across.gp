# SPDX-License-Identifier: MIT
# Designs of coarse levels. Above: bytes and the time of a frame against the error, a point a design and level; the front is
# a staircase. Below: each design's error over the first one's, a panel a level. Restyle in style.gp: fonts, colors, shapes.
name = 'across'
data = name . '.csv'
set datafile separator comma
set datafile columnheaders
stats data using (column("at")) nooutput
designs = int(STATS_max) + 1
stats data using (column("level")) nooutput
levels = int(STATS_max)
stats data using (column("error")) nooutput
low_error = 0.8 * (STATS_min > 0 ? STATS_min : 1e-6); high_error = 1.25 * STATS_max
stats data using (column("ratio_minified")) nooutput
low_ratio = STATS_min; high_ratio = STATS_max
stats data using (column("ratio")) nooutput
low_ratio = 0.96 * (STATS_min < low_ratio ? STATS_min : low_ratio); high_ratio = 1.04 * (STATS_max > high_ratio ? STATS_max : high_ratio)
array design[designs]; array chosen[designs]
stats data using (n = int(column("at")) + 1, design[n] = strcol("design"), chosen[n] = int(column("auto")), 0) nooutput
stats data using (metric = strcol("metric"), volume = strcol("volume"), tf = strcol("tf"), views = column("views"), size = column("size"), 0) nooutput
row = 15.0
dots = designs * row
width = 980
above = 300
foot = 66
height = above + 82 + dots + foot + 40
load 'style.gp'
if (!exists("pale")) pale = '#c4c4c4'
if (!exists("mark")) mark = vermillion
if (!exists("ink")) ink = '#222222'
if (!exists("small")) small = ',9'
scalars = 'mean gauss least-squares damped fitted'
scalar_shapes = '7 11 5 9 13'
treatments = 'original adapted 2D scaled'
index_of(list, w) = words(list[1 : strstrt(list . ' ', w . ' ') + strlen(w)])
shape(s) = int(word(scalar_shapes, index_of(scalars, s)))
is(t) = strcol("treatment") eq word(treatments, t)
array tint[4]
tint[1] = '#8a8a8a'; tint[2] = blue; tint[3] = '#009e73'; tint[4] = mark
array tf_name[4] = ['original TF', 'adapted TF', '2D TF', 'extinction scale']
array scalar_name[5] = ['means', 'Gaussian', 'least squares', 'damped', 'fitted']
outside = 1e30
size_of(k) = 1.25 * 0.8 ** (k - 1)
y(p) = p / height
unset key
set multiplot
# ---- the fronts ----
set logscale xy
set yrange [low_error : high_error]
set format y '%g'
set ytics ()
do for [d = floor(log10(low_error)) : ceil(log10(high_error))] { do for [m in '1 2 5'] { set ytics add (gprintf('%g', m * 10.0 ** d) m * 10.0 ** d) } }
top = 1 - y(12.0); bottom = 1 - y(above - 46.0)
do for [p = 1:2] {
    cost = p == 1 ? 'bytes' : 'milliseconds'
    flag = p == 1 ? 'bytes_front' : 'time_front'
    set autoscale
    stats data using (column(cost)) nooutput
    set yrange [low_error : high_error]
    set xrange [0.8 * STATS_min : 1.25 * STATS_max]
    set format x (p == 1 ? '%.0s %cB' : '%g')
    set xtics ()
    do for [d = floor(log10(STATS_min)) - 1 : ceil(log10(STATS_max))] { do for [m in (STATS_max / STATS_min > 20 ? '1 3' : '1 2 3 5')] { set xtics add (gprintf(p == 1 ? '%.0s %cB' : '%g', m * 10.0 ** d) m * 10.0 ** d) } }
    set lmargin at screen (p == 1 ? 0.075 : 0.56); set rmargin at screen (p == 1 ? 0.495 : 0.98)
    set tmargin at screen top; set bmargin at screen bottom
    set xlabel (p == 1 ? 'bytes of the level' : 'time of a frame, ms') offset 0, 0.4
    set ylabel (p == 1 ? metric . ' to level 0, as rendered' : '') offset 1, 0
    plot data using (column(flag) == 1 ? column(cost) : NaN):(column("error")) smooth unique with steps lc rgb pale lw 2.5, \
         for [t = 1:4] for [s = 1:words(scalars)] data using (is(t) && strcol("scalar") eq word(scalars, s) && strcol("directions") eq 'moments' ? column(cost) : outside):(column("error")):(size_of(column("level"))) with points pt int(word(scalar_shapes, s)) lc rgb tint[t] ps variable, \
         data using (strcol("directions") ne 'moments' ? column(cost) : outside):(column("error")):(size_of(column("level"))) with points pt 2 lc rgb ink ps variable, \
         data using (column("auto") > 0 ? column(cost) : outside):(column("error")) with points pt 6 ps 2.0 lw 1.6 lc rgb ink
}
# ---- legend ----
legend = 1 - y(above + 20.0)
do for [t = 1:4] { set label 100 + t tf_name[t] at screen 0.075 + 0.125 * (t - 1), screen legend left offset 1.3, -0.25 font small point pt 7 ps 1 lc rgb tint[t] noenhanced }
do for [s = 1:words(scalars)] { set label 110 + s scalar_name[s] at screen 0.075 + 0.125 * (s - 1), screen legend - y(row) left offset 1.3, -0.25 font small point pt int(word(scalar_shapes, s)) ps 1 lc rgb ink noenhanced }
set label 120 'other directions' at screen 0.60, screen legend left offset 1.3, -0.25 font small point pt 2 ps 1 lc rgb ink
set label 121 'ringed: chosen by --auto' at screen 0.745, screen legend left offset 1.3, -0.25 font small point pt 6 ps 1.7 lw 1.6 lc rgb ink
do for [k = 1:levels] { set label 130 + k sprintf('level %d', k) at screen 0.745 + 0.085 * (k - 1), screen legend - y(row) left offset 1.3, -0.25 font small point pt 7 ps size_of(k) lc rgb ink }
# ---- the designs, level by level ----
unset logscale
set logscale x
set yrange [designs - 0.4 : -0.6]
set ylabel ''
set format x '%g'
set xtics ('.4' 0.4, '.5' 0.5, '.6' 0.6, '.7' 0.7, '.8' 0.8, '' 0.9, '1' 1, '1.2' 1.2, '1.5' 1.5, '2' 2, '3' 3, '5' 5, '10' 10)
if (high_ratio / low_ratio > 5) set xtics ('.2' 0.2, '.5' 0.5, '1' 1, '2' 2, '5' 5, '10' 10)
set xrange [low_ratio : high_ratio]
set xlabel ''
set tmargin at screen 1 - y(above + 82.0); set bmargin at screen y(foot + 22.0)
set arrow 1 from 1, graph 0 to 1, graph 1 nohead lc rgb ink lw 0.8 back
set grid ytics noxtics lc rgb '#e6e6e6' lt 1
do for [k = 1:levels] {
    set lmargin at screen 0.16 + 0.82 * (k - 1) / levels + (k > 1 ? 0.012 : 0); set rmargin at screen 0.16 + 0.82 * k / levels
    set ytics ()
    do for [n = 1:designs] { set ytics add ((k == 1 ? design[n] : '') n - 1) }
    set ytics font small noenhanced scale 0
    if (k == 1) { set label 201 sprintf('%s of each design over that of %s: filled, minified; hollow, as rendered.'."\n".'  %s, %s, %d view%s of %d pixels', metric, design[1], volume, tf, int(views), int(views) == 1 ? '' : 's', int(size)) at screen 0.075, screen y(foot - 22.0) left noenhanced font small textcolor rgb ink }
    if (k > 1) { unset label 201 }
    set label 200 sprintf('level %d', k) at graph 0.02, screen 1 - y(above + 72.0) left
    plot for [t = 1:4] data using (column("level") == k && is(t) ? column("ratio") : outside):(column("at")) with points pt 6 ps 0.75 lw 1.2 lc rgb tint[t], \
         for [t = 1:4] data using (column("level") == k && is(t) ? column("ratio_minified") : outside):(column("at")) with points pt 7 ps 0.95 lc rgb tint[t], \
         data using (column("level") == k && column("auto") > 0 ? column("ratio_minified") : outside):(column("at")) with points pt 6 ps 1.7 lw 1.4 lc rgb ink
    if (k == 1) {
        do for [i = 101:104] { unset label i }
        do for [i = 111:115] { unset label i }
        unset label 120; unset label 121
        do for [i = 131:130 + levels] { unset label i }
    }
}
unset multiplot
