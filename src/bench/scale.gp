# SPDX-License-Identifier: MIT
# Processor time and peak memory over voxels, both logarithmic: one line per command; gray lines have slope 1.
name = 'scale'
data = name . '.csv'
set datafile separator comma
series = ''
known(m) = strstrt(series, '"' . m . '"') > 0
stats data skip 1 using (known(strcol(1)) ? 0 : (series = series . ' "' . strcol(1) . '"', 0)) nooutput
count = words(series)
stats data skip 1 using 2 nooutput
least = STATS_min
most = STATS_max
stats data skip 1 using 3 nooutput
set_seconds = sprintf('set yrange [%g:%g]', STATS_min / 2, STATS_max * 30) # room for the key
stats data skip 1 using 4 nooutput
set_bytes = sprintf('set yrange [%g:%g]', STATS_min / 2, STATS_max * 2)
width = 900
height = 400
load 'style.gp'
set logscale xy
set format x '10^{%T}'
set format y '10^{%T}'
set xrange [least / 2 : most * 2]
set xlabel 'voxels'
set key left top reverse Left
set multiplot layout 1,2
set ylabel 'processor time, s'
@set_seconds
guide(x, level) = level * (x / least)
plot for [k = -4:4] guide(x, 10.0 ** k) with lines lc rgb '#dddddd' lw 1 notitle, \
     for [i = 1:count] data skip 1 using (strcol(1) eq word(series, i) ? $2 : NaN):3 with linespoints lt i title word(series, i)
unset key
set ylabel 'peak memory, bytes'
@set_bytes
plot for [k = 5:11] guide(x, 10.0 ** k) with lines lc rgb '#dddddd' lw 1 notitle, \
     for [i = 1:count] data skip 1 using (strcol(1) eq word(series, i) ? $2 : NaN):4 with linespoints lt i notitle
unset multiplot
