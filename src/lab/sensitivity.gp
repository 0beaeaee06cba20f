# SPDX-License-Identifier: MIT
# Smallest amount of each deviation that each gate rejects: a point is the median over the scenes, its line reaches from
# the least to the largest.
name = 'sensitivity'
data = name . '.csv'
set datafile separator comma
rows = ''
gates = ''
colors = ''
known(list, m) = strstrt(list, '"' . m . '"') > 0
stats data skip 1 using (known(rows, strcol(1)) ? 0 : (rows = rows . ' "' . strcol(1) . '"', 0)) nooutput
longest = 0
stats data skip 1 using (longest = strlen(strcol(1)) > longest ? strlen(strcol(1)) : longest, 0) nooutput
stats data skip 1 using (known(gates, strcol(2)) ? 0 : (gates = gates . ' "' . strcol(2) . '"', colors = colors . ' ' . strcol(6), 0)) nooutput
count = words(rows)
series = words(gates)
width = 860
height = 120 + 50 * count
load 'style.gp'
set lmargin 0.8 * longest
set tmargin 3.8
place(r) = (sum [i = 1:count] (word(rows, i) eq r ? i : 0))
offset(k) = 0.8 * ((k - 0.5) / series - 0.5)
# One color per renderer, one shape per gate.
shape(g) = strstrt(g, 'lock-step') > 0 ? 5 : strstrt(g, 'limit') > 0 ? 7 : 13
set errorbars 0.5
set logscale x
set format x '10^{%T}'
set xlabel 'smallest rejected amount, in the unit of the row'
set yrange [count + 0.6 : 0.4]
set ytics ('' 0)
do for [i = 1:count] { set ytics add (word(rows, i) i) }
set ytics noenhanced scale 0
set grid xtics noytics
set border 1
set key at screen 0.5, screen 0.99 center top horizontal maxrows 2 Left reverse width 1
do for [i = 1:count - 1] { set arrow from graph 0, first i + 0.5 to graph 1, first i + 0.5 nohead lc rgb '#e2e2e2' lw 0.6 back }
plot for [k = 1:series] data skip 1 using (strcol(2) eq word(gates, k) ? $4 : NaN):(place(strcol(1)) + offset(k)):3:5 \
         with xerrorbars lc rgb word(colors, k) pt shape(word(gates, k)) ps 0.55 lw 1.3 notitle, \
     for [k = 1:series] NaN with points lc rgb word(colors, k) pt shape(word(gates, k)) ps 0.7 title word(gates, k)
