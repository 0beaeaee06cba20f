# SPDX-License-Identifier: MIT
# Image error against time and against bytes. A series has one color and shape, a level one size. The front is a
# staircase; its corners are named below, except those that hardly improve on a cheaper one. Restyle in style.gp: fonts, colors, shapes (linetype 1, 2 ...), sizes.
name = 'pareto'
data = name . '.csv'
set datafile separator comma
set datafile columnheaders
# Collects the series, levels, ranges, and the settings on the fronts.
series = ''
known(s) = strstrt(series, '"' . s . '"') > 0
of(i) = strcol("series") eq word(series, i)
stats data using (known(strcol("series")) ? 0 : (series = series . ' "' . strcol("series") . '"', 0)) nooutput
scenes = ''; renderers = ''
seen(s) = strstrt(scenes, '"' . s . '"') > 0
met(s) = strstrt(renderers, '"' . s . '"') > 0
stats data using (seen(strcol("scene")) ? 0 : (scenes = scenes . ' "' . strcol("scene") . '"', 0)) nooutput
stats data using (met(strcol("renderer")) ? 0 : (renderers = renderers . ' "' . strcol("renderer") . '"', 0)) nooutput
rows = words(scenes)
here(s) = strcol("scene") eq word(scenes, s)
name_of(scene) = scene[1 : strstrt(scene, '.') > 1 ? strstrt(scene, '.') - 1 : strlen(scene)]
stats data using (metric = strcol("metric"), kind = strcol("bytes_kind"), scene = strcol("scene"), wide = column("width"), high = column("height"), 0) nooutput
stats data using (volume = strcol("volume"), machine = strcol("machine"), clock = strcol("time_kind"), want = column("want"), 0) nooutput
stats data using (column("level")) nooutput
levels = int(STATS_max) + 1
array built[levels]
do for [k = 1:levels] { built[k] = 0 }
stats data using (built[int(column("level")) + 1] = column("build_seconds")) nooutput
gap = STATS_max > 0 ? 0.235 : 0.115 # of the levels in the legend
across = STATS_max > 0 ? 4 : 7
stats data using (strcol("quadrature") eq 'preintegrated' ? 1 : 0) nooutput
preintegrated = STATS_max > 0
stats data using (column("error")) nooutput
best = want > 0 && want < STATS_min ? want : STATS_min > 0 ? STATS_min : 1e-9
worst = want > STATS_max ? want : STATS_max > best ? STATS_max : 10 * best
array low[2]; array up[2]
stats data using (column("milliseconds")) nooutput
low[1] = STATS_min; up[1] = STATS_max
stats data using (column("bytes")) nooutput
low[2] = STATS_min; up[2] = STATS_max
stats data using (column("number")) nooutput
fronts = STATS_max > 0 ? int(STATS_max) : 0
array setting[fronts + 1]; array error[fronts + 1]; array x1[fronts + 1]; array x2[fronts + 1]; array flags[fronts + 1]; array rings[fronts + 1]; array whose[fronts + 1]
at(n) = n > 0 ? int(n) : fronts + 1
stats data using (n = at(column("number")), setting[n] = strcol("setting"), error[n] = column("error"), x1[n] = column("milliseconds"), x2[n] = column("bytes"), 0) nooutput
stats data using (n = at(column("number")), rings[n] = int(column("chosen")), whose[n] = strcol("scene"), flags[n] = int(column("time_front")) + 2 * int(column("bytes_front")), 0) nooutput
# Pixels: the list, the legend, the panels.
count = words(series)
rows_of(n, columns) = (n + columns - 1) / columns
row = 18.0
list_rows = rows_of(fronts, 2)
level_rows = rows_of(levels + preintegrated, across)
legend_rows = rows_of(count, 4) + level_rows
width = 980
list_top = 26 + row * (list_rows + 1)
legend_top = list_top + 10 + row * legend_rows
panel = 384.0 # height of a row of panels, with its axis
height = 14 + panel * rows + legend_top
load 'style.gp'
if (!exists("pale")) pale = '#c4c4c4'
if (!exists("mark")) mark = vermillion
if (!exists("ink")) ink = '#222222'
if (!exists("small")) small = ',9'
if (!exists("point_scale")) point_scale = 1.0
ringed(p) = (int(column("chosen")) & p) > 0
# Place of points to leave out: gnuplot warns about plots without points, but not about points outside.
outside = 1e30
size_of(k) = point_scale * (0.95 * 0.74 ** k)
unset key
set logscale xy
bottom_error = 0.5 * best; top_error = 1.4 * worst
set yrange [bottom_error : top_error]
set format y '10^{%T}'
do for [i = 1:count] {
    set label 100 + i word(series, i) at screen 0.075 + 0.235 * ((i - 1) % 4), screen (legend_top - row * (0.5 + (i - 1) / 4)) / height left offset 1.3, -0.3 point lt i ps 0.95 * point_scale noenhanced
}
level_x(k) = 0.075 + gap * (k % across)
level_y(k) = list_top + 10 + row * (level_rows - 0.5 - k / across)
do for [k = 0:levels - 1] {
    set label 200 + k sprintf('level %d%s', k, built[k + 1] > 0 ? sprintf(', built in %.3g s', built[k + 1]) : '') at screen level_x(k), screen level_y(k) / height left offset 1.3, -0.3 point lt 1 lc rgb ink ps size_of(k)
}
if (preintegrated) set label 300 'with a cross: pre-integrated' at screen level_x(levels), screen level_y(levels) / height left offset 1.3, -0.3 point pt 1 ps 0.7 * point_scale lc rgb ink
do for [n = 1:fronts] {
    set label 400 + n sprintf('%d  %s%s', n, rows > 1 ? name_of(whose[n]) . ': ' : '', setting[n]) at screen 0.065 + 0.47 * ((n - 1) / list_rows), screen (list_top - row * (1.5 + (n - 1) % list_rows)) / height left noenhanced font small
}
set label 301 sprintf('%s, %s, %d x %d pixels; %s', volume, rows > 1 ? sprintf('%d scenes', rows) : scene, wide, high, machine) at screen 0.065, screen 12.0 / height left noenhanced font small textcolor rgb ink
if (want > 0) set arrow 1 from graph 0, first want to graph 1, first want nohead lc rgb mark dt 2 lw 1.2 back
set label 302 (words(renderers) > 1 ? 'fine dashes: the front of a renderer alone; ' : '') . (want > 0 ? sprintf('on the front; ringed: the fastest and the smallest with at most %.3g (dashed)', want) : 'on the front') at screen 0.065, screen (list_top - 0.5 * row) / height left noenhanced font small textcolor rgb (want > 0 ? mark : ink)
panel_height = panel - 70.0
set multiplot
do for [s = 1:rows] { do for [p = 1:2] {
    set lmargin at screen (p == 1 ? 0.075 : 0.56)
    set rmargin at screen (p == 1 ? 0.495 : 0.98)
    set bmargin at screen (legend_top + 70 + panel * (rows - s)) / height
    set tmargin at screen (legend_top + panel * (rows - s + 1)) / height
    if (rows > 1) { set label 600 name_of(word(scenes, s)) at graph 0.99, graph 0.97 right noenhanced front }
    cost = p == 1 ? 'milliseconds' : 'bytes'
    flag = p == 1 ? 'time_front' : 'bytes_front'
    format_x = p == 1 ? '%g' : '%.0s %cB'
    set format x format_x
    left_x = low[p] * (low[p] / up[p]) ** 0.07 * 0.93; right_x = up[p] * (up[p] / low[p]) ** 0.05 * 1.08
    set xrange [left_x : right_x]
    set xtics autofreq
    if (right_x / left_x < 200) {
        set xtics ()
        do for [d = floor(log10(left_x)) : ceil(log10(right_x))] { do for [m in '1 2 5'] { set xtics add (gprintf(format_x, m * 10.0 ** d) m * 10.0 ** d) } }
    }
    set ylabel (p == 1 ? metric . ' to the converged reference of level 0' : '') offset 1, 0
    set xlabel (p == 1 ? (clock eq 'processor' ? 'processor ' : '') . 'time of a frame, ms: the fastest (bars: to the median)' : kind eq 'stored' ? 'bytes of the level in files' : 'bytes that the renderer holds')
    # Numbers stand left of their points, on the empty side of the front, and below the previous number if that is near.
    last = top_error; last_x = left_x
    do for [n = 1:fronts] {
        unset label 500 + n
        if (((flags[n] | rings[n]) & p) && whose[n] eq word(scenes, s)) {
            x = p == 1 ? x1[n] : x2[n]
            below = last * (bottom_error / top_error) ** (13.0 / panel_height)
            near = abs(log(x / last_x) / log(right_x / left_x)) < 0.08
            last = near && error[n] > below ? below : error[n]
            last_x = x
            set label 500 + n sprintf('%d', n) at first x, first last right offset (rings[n] & p ? -1.6 : -1.0), 0 font small textcolor rgb ink front
        }
    }
    plot data using (column(flag) == 1 && here(s) ? column(cost) : NaN):(column("error")) smooth unique with steps lc rgb pale lw 2.5, \
         for [r = 1:words(renderers) > 1 ? words(renderers) : 0] data using (column('renderer_' . flag) == 1 && here(s) && strcol("renderer") eq word(renderers, r) ? column(cost) : NaN):(column("error")) smooth unique with steps lc rgb ink lw 0.8 dt 2, \
         data using (column(cost)):(column(flag) == 1 && p == 1 && here(s) ? column("error") : outside):(column(cost)):(column("milliseconds_median")) with xerrorbars pt -1 lc rgb ink lw 0.8, \
         for [i = 1:count] data using (of(i) && here(s) ? column(cost) : outside):(column("error")):(size_of(column("level"))) with points lt i ps variable, \
         data using (strcol("quadrature") eq 'preintegrated' && here(s) ? column(cost) : outside):(column("error")):(0.7 * size_of(column("level"))) with points pt 1 ps variable lw 0.6 lc rgb ink, \
         data using (ringed(p) && here(s) ? column(cost) : outside):(column("error")) with points pt 6 ps 2.1 * point_scale lw 2 lc rgb mark
    do for [i = 1:count] { unset label 100 + i }
    do for [k = 0:levels - 1] { unset label 200 + k }
    do for [n = 1:fronts] { unset label 400 + n }
    unset label 300
    unset label 301
    unset label 302
} }
unset multiplot
