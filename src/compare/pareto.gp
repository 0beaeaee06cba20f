# Image error against time and against bytes: one colour a kind of gradients, one shape a level, the front in grey.
name = 'pareto'
data = name . '.csv'
set datafile separator comma
series = ''
known(m) = strstrt(series, '"' . m . '"') > 0
stats data skip 1 using (known(strcol(1)) ? 0 : (series = series . ' "' . strcol(1) . '"', 0)) nooutput
count = words(series)
of(i) = strcol(1) eq word(series, i)
stats data skip 1 using 4 nooutput
levels = int(STATS_max) + 1
stats data skip 1 using 12 nooutput
want = STATS_max
stats data skip 1 using 8 nooutput
best = want > 0 && want < STATS_min ? want : STATS_min > 0 ? STATS_min : 1e-9
worst = want > STATS_max ? want : STATS_max
stats data skip 1 using 14 nooutput
preintegrated = STATS_max > 0
fastest = ''
smallest = ''
stats data skip 1 using ((int($13) & 1) ? (fastest = strcol(2), 0) : 0) nooutput
stats data skip 1 using ((int($13) & 2) ? (smallest = strcol(2), 0) : 0) nooutput
legend_rows = (count + 3) / 4 + 1
width = 980
height = 440 + 20 * legend_rows
load 'style.gp'
shapes = '7 5 9 13 11 15 6 4 8 12'
shape(k) = int(word(shapes, k % 10 + 1))
unset key
set logscale xy
set format xy '10^{%T}'
set yrange [10 ** floor(log10(0.9 * best)) : 10 ** ceil(log10(1.1 * worst))]
do for [i = 1:count] {
    set label 100 + i word(series, i) at screen 0.09 + 0.23 * ((i - 1) % 4), screen (4.0 + 20 * (legend_rows - (i - 1) / 4)) / height - 0.01 left offset 1.2, -0.25 point lt i pt 7 ps 0.8 noenhanced
}
do for [k = 0:levels - 1] {
    set label 200 + k sprintf('level %d', k) at screen 0.09 + 0.115 * (k % 8), screen 14.0 / height left offset 1.2, -0.25 point pt shape(k) ps 0.8 lc rgb black
}
if (preintegrated) set label 300 'white centre: pre-integrated' at screen 0.09 + 0.115 * (levels % 8), screen 14.0 / height left offset 1.2, -0.25 point pt 6 ps 0.8 lc rgb black
if (want > 0) set arrow 1 from graph 0, first want to graph 1, first want nohead lc rgb vermillion dt 2 lw 1.2 back
if (want > 0) set label 1 sprintf('wanted: %.2g', want) at graph 0.01, first want left offset 0,0.5 textcolor rgb vermillion
set multiplot layout 1,2 margins 0.085, 0.985, (72.0 + 20 * legend_rows) / height, 1 - 30.0 / height spacing 0.075,0.1
do for [panel = 0:1] {
    cost = panel == 0 ? 6 : 7
    flag = panel == 0 ? 10 : 11
    set ylabel (panel == 0 ? 'RMSE against the converged reference of level 0' : '') offset 1,0
    set xlabel (panel == 0 ? 'time of one image, ms' : 'bytes of the level: scalars and directions')
    set title (panel == 0 ? 'time' : 'bytes') offset 0,-0.4
    chosen = panel == 0 ? fastest : smallest
    set label 2 (chosen eq '' ? '' : (panel == 0 ? 'fastest: ' : 'smallest: ') . chosen) at graph 0.01, graph 0.04 left textcolor rgb vermillion noenhanced
    plot data skip 1 using (column(flag) == 1 ? column(cost) : NaN):8 smooth unique with lines lc rgb '#c4c4c4' lw 3, \
         for [i = 1:count] for [k = 0:levels - 1] data skip 1 using (of(i) && $4 == k ? column(cost) : NaN):8 with points lt i pt shape(k) ps 0.6, \
         data skip 1 using ($14 == 1 ? column(cost) : NaN):8 with points pt 7 ps 0.18 lc rgb '#ffffff', \
         data skip 1 using (int(column(13)) & (panel + 1) ? column(cost) : NaN):8 with points pt 6 ps 1.9 lw 2 lc rgb vermillion
    do for [i = 1:count] { unset label 100 + i }
    do for [k = 0:levels - 1] { unset label 200 + k }
    unset label 300
}
unset multiplot
