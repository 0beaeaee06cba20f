# SPDX-License-Identifier: MIT
# Figure 8 of [diaz-garcia-2016]: SSIM dissimilarity to level 0 with several averages, one group of bars per volume.
name = 'figure8'
width = 1000
height = 420
load 'style.gp'
data = name . '.csv'
set datafile separator comma
volumes = ''
methods = ''
known(list, m) = strstrt(list, '"' . m . '"') > 0
stats data skip 1 using (known(volumes, strcol(1)) ? 0 : (volumes = volumes . ' "' . strcol(1) . '"', 0)) nooutput
stats data skip 1 using (known(methods, strcol(2)) ? 0 : (methods = methods . ' "' . strcol(2) . '"', 0)) nooutput
set style fill solid 0.85 noborder
wide = 0.84 / words(methods)
set boxwidth 0.92 * wide
set xrange [-0.7 : words(volumes) - 0.3]
set yrange [0:*]
set xtics ('' 0)
do for [i = 1:words(volumes)] { set xtics add (word(volumes, i) i - 1) }
set xtics rotate by -35 noenhanced scale 0
set ylabel '1 - SSIM, mean over levels and transfer functions'
set grid ytics noxtics
set key outside top center horizontal
plot for [m = 1:words(methods)] data using (strcol(2) eq word(methods, m) ? $4 - 0.42 + (m - 0.5) * wide : NaN):3 \
     with boxes title word(methods, m) noenhanced
