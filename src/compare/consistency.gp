# How far each level is from level 0, one line a method: structure, what people see, directions.
name = 'consistency'
data = name . '.csv'
set datafile separator comma
methods = ''
known(m) = strstrt(methods, '"' . m . '"') > 0
stats data skip 1 using (known(strcol(1)) ? 0 : (methods = methods . ' "' . strcol(1) . '"', 0)) nooutput
stats data skip 1 using 2 nooutput
count = words(methods)
of(i) = strcol(1) eq word(methods, i)
width = 980
legend_rows = (count + 3) / 4
height = 310 + 20 * legend_rows
load 'style.gp'
set xtics 1
set xlabel 'level' offset 0,0.4
set xrange [STATS_min - 0.2 : STATS_max + 0.2]
set yrange [0:*]
set multiplot layout 1,3 margins 0.055, 0.985, (62.0 + 20 * legend_rows) / height, 1 - 34.0 / height spacing 0.06,0.1
unset key
do for [i = 1:count] {
    set label i word(methods, i) at screen 0.06 + 0.235 * ((i - 1) % 4), screen (20.0 * (legend_rows - (i - 1) / 4) - 8) / height left offset 1.2, -0.25 point lt i ps 0.8 noenhanced
}
set title offset 0,-0.3
set title 'structure: 1 − SSIM'
plot for [i = 1:count] data skip 1 using (of(i) ? $2 : NaN):4 with linespoints lt i
do for [i = 1:count] { unset label i }
set title 'what people see: mean FLIP'
plot for [i = 1:count] data skip 1 using (of(i) ? $2 : NaN):5 with linespoints lt i
set title 'direction error, ° (dotted: 95th percentile)'
plot for [i = 1:count] data skip 1 using (of(i) ? $2 : NaN):6 with linespoints lt i, \
     for [i = 1:count] data skip 1 using (of(i) ? $2 : NaN):7 with lines lt i dt 3 lw 1
unset multiplot
