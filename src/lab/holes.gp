# SPDX-License-Identifier: MIT
# Pictures of one level by several directions, next to level 0, with the share of holes in each.
name = 'holes'
data = name . '.csv'
set datafile separator comma
stats data skip 1 using 3 nooutput
count = int(STATS_records)
array file[count]; array title[count]; array dark[count]; array dssim[count]
stats data skip 1 using (i = int($0) + 1, file[i] = strcol(1), title[i] = strcol(2), dark[i] = $3, dssim[i] = $4, pixels = $5, 0) nooutput
width = 200 * count
height = 250
load 'style.gp'
unset border; unset tics; unset key; unset grid
set size ratio -1
# The camera frames the corners of the box; its content fills half of the picture.
set xrange [0.24 * pixels : 0.76 * pixels]
set yrange [0.24 * pixels : 0.76 * pixels]
set multiplot
do for [i = 1:count] {
    set lmargin at screen (i - 1.0) / count + 0.004
    set rmargin at screen (1.0 * i) / count - 0.004
    set bmargin at screen 24.0 / height
    set tmargin at screen 1 - 26.0 / height
    set label 1 title[i] at graph 0.5, graph 1 center offset 0, 0.6 noenhanced
    set label 2 (i == 1 ? '' : sprintf('holes %.2f %%, DSSIM %.3f', 100 * dark[i], dssim[i])) at graph 0.5, graph 0 center offset 0, -0.7 font ',11' noenhanced
    plot file[i] binary filetype=png with rgbimage
}
unset multiplot
