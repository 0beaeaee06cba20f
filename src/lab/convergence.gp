# SPDX-License-Identifier: MIT
# RMSE against the converged reference over the ray step. Gray lines show quadratic convergence. A circle is the error
# of the limit extrapolated from the two finest steps, a cross its error bar.
name = 'convergence'
data = name . '.csv'
set datafile separator comma
series = ''
known(m) = strstrt(series, '"' . m . '"') > 0
stats data skip 1 using (known(strcol(1)) ? 0 : (series = series . ' "' . strcol(1) . '"', 0)) nooutput
count = words(series)
of(i, kind) = strcol(1) eq word(series, i) && strcol(2) eq kind
stats data skip 1 using (strcol(2) eq 'step' ? $3 : NaN) nooutput
coarsest = STATS_max
finest = STATS_min
stats data skip 1 using (strcol(2) eq 'step' ? $4 : NaN) nooutput
highest = STATS_max
width = 620
height = 430
load 'style.gp'
set logscale xy
set logscale x 2
set format y '10^{%T}'
set format x '%g'
set xrange [finest / 1.5 : coarsest * 1.25]
set xlabel 'ray step, voxels'
set ylabel 'RMSE of linear RGB and alpha'
set key left top reverse Left
guide(x, level) = level * (x / coarsest) ** 2
plot for [k = 0:3] guide(x, highest * 4.0 ** (1 - k)) with lines lc rgb '#dddddd' lw 1 notitle, \
     for [i = 1:count] data skip 1 using (of(i, 'step') ? $3 : NaN):4 with linespoints lt i title word(series, i), \
     for [i = 1:count] data skip 1 using (of(i, 'limit') ? $3 : NaN):4 with points lt i pt 6 ps 1.2 notitle, \
     for [i = 1:count] data skip 1 using (of(i, 'limit') ? $3 : NaN):5 with points lt i pt 2 ps 0.8 notitle, \
     NaN with points pt 6 ps 1.2 lc rgb black title 'limit of the two finest', \
     NaN with points pt 2 ps 0.8 lc rgb black title 'its error bar'
