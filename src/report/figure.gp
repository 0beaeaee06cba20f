# SPDX-License-Identifier: MIT
# A figure of panels: pictures and difference maps, with a scale bar and a colour legend. figure.csv places them.
name = 'figure'
data = name . '.csv'
set datafile separator comma
stats data skip 1 using 1 nooutput
count = int(STATS_records)
array kind[count]; array file[count]; array wide[count]; array high[count]
array left[count]; array right[count]; array bottom[count]; array top[count]; array middle[count]
array title[count]; array note[count]; array side[count]; array bar[count]; array bar_text[count]; array bar_color[count]
stats data skip 1 using (i = int($0) + 1, kind[i] = $1, file[i] = strcol(2), wide[i] = int($3), high[i] = int($4), 0) nooutput
stats data skip 1 using (i = int($0) + 1, left[i] = $5, right[i] = $6, bottom[i] = $7, top[i] = $8, 0) nooutput
stats data skip 1 using (i = int($0) + 1, title[i] = strcol(9), note[i] = strcol(10), side[i] = strcol(11), 0) nooutput
stats data skip 1 using (i = int($0) + 1, bar[i] = $12, bar_text[i] = strcol(13), low = $14, up = $15, in_logs = int($16), 0) nooutput
stats data skip 1 using (i = int($0) + 1, width = $17, height = $18, bar_color[i] = strcol(19), middle[i] = $20, 0) nooutput
load 'style.gp'
set datafile missing
unset border
unset tics
unset key
unset grid
set palette defined (0 '#080818', 0.25 '#48146e', 0.5 '#b02c68', 0.75 '#f47e3c', 1 '#fcf6be')
set cbrange [low:up]
# pdfcairo prints two thirds of the size that it is told; SVG counts in pixels, 96 an inch.
told(points) = sprintf(',%g', format eq 'pdf' ? 1.5 * points : points / 0.75)
note_font = told(note_pt); title_font = told(title_pt); tick_font = told(tick_pt)
line(points) = 1.25 * points / 0.75 # from line to line, in the pixels of width and height
if (in_logs) set cbtics 2 format '10^{%g}' nomirror scale 0.3 offset -0.8, 0 font tick_font
half = 0.5 * (up - low)
if (!in_logs) set cbtics low, half, up nomirror scale 0.3 offset -0.8, 0 font tick_font format '%.2g'
# A '|' in a text begins a new line, and a ';' is a comma, which would end a cell of figure.csv.
comma(s) = strstrt(s, ';') ? s[1:strstrt(s, ';') - 1] . ',' . comma(s[strstrt(s, ';') + 1:*]) : s
parts(s) = strstrt(s, '|') ? 1 + parts(s[strstrt(s, '|') + 1:*]) : 1
part(s, k) = k > 1 ? part(s[strstrt(s, '|') + 1:*], k - 1) : strstrt(s, '|') ? s[1:strstrt(s, '|') - 1] : s
lines(s) = s eq '-' ? 0 : parts(s)
legend = 0
set multiplot
do for [i = 1:count] {
    set lmargin at screen left[i]
    set rmargin at screen right[i]
    set bmargin at screen bottom[i]
    set tmargin at screen top[i]
    set xrange [0:wide[i]]
    set yrange [0:high[i]]
    unset label
    unset object
    do for [k = 1:lines(title[i])] {
        set label comma(part(title[i], k)) at screen 0.5 * (left[i] + right[i]), top[i] + (0.62 + lines(title[i]) - k) * line(title_pt) / height center noenhanced font title_font
    }
    do for [k = 1:lines(note[i])] {
        set label part(note[i], k) at screen 0.5 * (left[i] + right[i]), bottom[i] - (k - 0.3) * line(note_pt) / height center noenhanced font note_font
    }
    do for [k = 1:lines(side[i])] {
        set label comma(part(side[i], k)) at screen left[i] - (0.6 + lines(side[i]) - k) * line(title_pt) / width, middle[i] center rotate by 90 noenhanced font title_font
    }
    if (bar[i] > 0) {
        # A rectangle: the ends of a line would add to its length.
        set object 1 rectangle from graph 0.05, graph 0.05 to graph 0.05 + bar[i], screen bottom[i] + 0.05 * (top[i] - bottom[i]) + 1.8 / height front fillcolor rgb bar_color[i] fillstyle solid noborder
        set label bar_text[i] at graph 0.05, screen bottom[i] + 0.05 * (top[i] - bottom[i]) + 0.75 * line(note_pt) / height left front noenhanced font note_font textcolor rgb bar_color[i]
    }
    unset colorbox
    if (kind[i] == 1 && legend == 0) {
        legend = 1
        set colorbox user origin screen legend_left, screen legend_bottom size screen legend_width, screen legend_height noborder
        do for [k = 1:lines(legend_text)] {
            set label part(legend_text, k) at screen legend_left - (0.6 + lines(legend_text) - k) * line(note_pt) / width, legend_bottom + 0.5 * legend_height center rotate by 90 noenhanced font note_font
        }
    }
    if (kind[i] == 0) {
        plot file[i] binary array=(wide[i], high[i]) flipy origin=(0.5, 0.5) format='%uchar%uchar%uchar' using 1:2:3 with rgbimage
    } else {
        plot file[i] binary array=(wide[i], high[i]) flipy origin=(0.5, 0.5) format='%float' using 1 with image
    }
}
unset multiplot
