# SPDX-License-Identifier: MIT
# The RMSE of each comparison on a log axis, with its limit and its error bar; worst first, at most 40.
name = 'agreement'
set datafile separator comma
stats name . '.csv' skip 1 using 0 nooutput
rows = STATS_records > 40 ? 40 : STATS_records
width = 900
height = 130 + 22 * rows
longest = 0
stats name . '.csv' every ::1::rows using (n = strlen(strcol(1)), longest = n > longest ? n : longest, 0) nooutput
load 'style.gp'
set lmargin 0.8 * longest
set tmargin 2.8
least = 1e-9
above(x) = x > least ? x : least
color(v) = v eq 'agree' ? 0x0072b2 : v eq 'not compared' ? 0x999999 : 0xd55e00
set logscale x
set format x '10^{%T}'
set xrange [least:*]
# Without any measurement the axis would be unbounded.
largest = 0
stats name . '.csv' every ::1::rows using (largest = $2 > largest ? $2 : largest, $3 > largest ? (largest = $3) : 0, 0) nooutput
if (!(largest > least)) { set xrange [least:1] }
set yrange [rows - 0.4 : -0.6]
set xlabel 'RMSE of linear RGB and alpha'
set ytics noenhanced scale 0
set grid noytics
set border 1
set key at screen 0.02, screen 0.99 left top horizontal maxrows 1 width -2
plot name . '.csv' every ::1::rows using (least):0:(least):(above($2)):($0 - 0.3):($0 + 0.3):(color(strcol(7))):ytic(1) \
         with boxxyerror fill solid 0.85 noborder lc rgb variable notitle, \
     '' every ::1::rows using 3:0:(0):(0.42) with vectors nohead lc rgb black lw 2 notitle, \
     '' every ::1::rows using 3:0:(0):(-0.42) with vectors nohead lc rgb black lw 2 notitle, \
     '' every ::1::rows using 6:0 with points pt 13 ps 0.6 lc rgb orange notitle, \
     NaN with boxes fill solid 0.85 noborder lc rgb blue title 'within the limits', \
     NaN with boxes fill solid 0.85 noborder lc rgb vermillion title 'outside', \
     NaN with lines lc rgb black lw 2 title 'limit', \
     NaN with points pt 13 ps 0.8 lc rgb orange title 'error bar'
