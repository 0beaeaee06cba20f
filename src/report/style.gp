# SPDX-License-Identifier: MIT
# Shared by all charts. Edit this file and run "gnuplot NAME.gp" in this folder to restyle a chart.
if (!exists("format")) format = 'svg'
if (!exists("width")) width = 760
if (!exists("height")) height = 400
if (!exists("dpi")) dpi = 300
# pdfcairo prints two thirds of the given size: 13 is 8.7 points, 11 is 7.3.
if (format eq 'pdf') {
    set terminal pdfcairo size width / 96.0, height / 96.0 font 'DejaVu Sans,13' linewidth 1.2 rounded
}
if (format eq 'png') {
    set terminal pngcairo transparent size int(width / 96.0 * dpi + 0.5), int(height / 96.0 * dpi + 0.5) font sprintf('DejaVu Sans,%g', 8.7 * dpi / 96) linewidth 1.2 rounded
}
if (format eq 'tex') {
    set terminal cairolatex pdf input colortext size width / 96.0, height / 96.0 linewidth 1.2 rounded
}
if (format eq 'svg') {
    set terminal svg size width, height font 'Helvetica Neue,Helvetica,Arial,DejaVu Sans,sans-serif,13' linewidth 1.2 rounded background '#ffffff'
}
set output name . (format eq 'tex' ? '-latex' : '') . '.' . format
set encoding utf8
set datafile separator comma
set datafile missing NaN
# Colors for all kinds of color vision (Okabe and Ito).
blue = '#0072b2'; vermillion = '#d55e00'; green = '#009e73'; orange = '#e69f00'
sky = '#56b4e9'; purple = '#cc79a7'; black = '#222222'; gray = '#999999'
set linetype 1 lc rgb blue lw 1.6 pt 7 ps 0.55
set linetype 2 lc rgb vermillion lw 1.6 pt 5 ps 0.5
set linetype 3 lc rgb green lw 1.6 pt 9 ps 0.6
set linetype 4 lc rgb orange lw 1.6 pt 13 ps 0.6
set linetype 5 lc rgb purple lw 1.6 pt 11 ps 0.6
set linetype 6 lc rgb sky lw 1.6 pt 6 ps 0.55
set linetype 7 lc rgb black lw 1.6 pt 4 ps 0.5
set linetype 8 lc rgb gray lw 1.6 pt 8 ps 0.6
set linetype 9 lc rgb '#6a3d9a' lw 1.6 pt 15 ps 0.6
set linetype 10 lc rgb '#8c564b' lw 1.6 pt 10 ps 0.6
set linetype 11 lc rgb '#8a9a00' lw 1.6 pt 12 ps 0.6
set linetype 12 lc rgb '#d05a8a' lw 1.6 pt 14 ps 0.6
set linetype 13 lc rgb '#00414f' lw 1.6 pt 2 ps 0.55
set linetype 14 lc rgb '#4f9a68' lw 1.6 pt 3 ps 0.55
set linetype 15 lc rgb '#7a4b00' lw 1.6 pt 13 ps 0.6
set linetype 16 lc rgb '#3a3a9a' lw 1.6 pt 5 ps 0.5
set linetype cycle 16
# Charts of points: front, chosen points, text, small text, size of points.
pale = '#c4c4c4'; mark = vermillion; ink = black
small = ',11'; point_scale = 1.0
set border 3 lc rgb '#444444' lw 0.8
set tics nomirror out scale 0.5 textcolor rgb '#222222'
set grid lc rgb '#e2e2e2' lw 0.6 lt 1
set key noenhanced samplen 2 spacing 1.1
