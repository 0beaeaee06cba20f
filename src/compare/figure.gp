# A figure of panels: pictures and difference maps, with a scale bar and a colour legend. figure.csv places them.
name = 'figure'
data = name . '.csv'
set datafile separator comma
stats data skip 1 using 1 nooutput
count = int(STATS_records)
array kind[count]; array file[count]; array wide[count]; array high[count]
array left[count]; array right[count]; array bottom[count]; array top[count]
array title[count]; array note[count]; array side[count]; array bar[count]; array bar_text[count]
stats data skip 1 using (i = int($0) + 1, kind[i] = $1, file[i] = strcol(2), wide[i] = int($3), high[i] = int($4), 0) nooutput
stats data skip 1 using (i = int($0) + 1, left[i] = $5, right[i] = $6, bottom[i] = $7, top[i] = $8, 0) nooutput
stats data skip 1 using (i = int($0) + 1, title[i] = strcol(9), note[i] = strcol(10), side[i] = strcol(11), 0) nooutput
stats data skip 1 using (i = int($0) + 1, bar[i] = $12, bar_text[i] = strcol(13), low = $14, up = $15, in_logs = int($16), 0) nooutput
stats data skip 1 using (width = $17, height = $18, 0) nooutput
load 'style.gp'
set datafile missing
unset border
unset tics
unset key
unset grid
set palette defined (0 '#080818', 0.25 '#48146e', 0.5 '#b02c68', 0.75 '#f47e3c', 1 '#fcf6be')
set cbrange [low:up]
if (in_logs) set cbtics 1 format '10^{%g}' nomirror scale 0.4
if (!in_logs) set cbtics nomirror scale 0.4
shown(s) = s eq '-' ? '' : s
legend = 0
set multiplot
do for [i = 1:count] {
    set lmargin at screen left[i]
    set rmargin at screen right[i]
    set bmargin at screen bottom[i]
    set tmargin at screen top[i]
    set xrange [0:wide[i]]
    set yrange [0:high[i]]
    set label 1 shown(title[i]) at graph 0.5, graph 1 center offset 0, 0.6 noenhanced
    set label 2 shown(note[i]) at graph 0.5, graph 0 center offset 0, -0.65 font ',7' noenhanced
    set label 3 shown(side[i]) at graph 0, graph 0.5 center rotate by 90 offset -0.9, 0 noenhanced
    unset arrow 1
    unset label 4
    if (bar[i] > 0) { set arrow 1 from graph 0.05, graph 0.05 to graph 0.05 + bar[i], graph 0.05 nohead lc rgb '#ffffff' lw 2.5 front }
    if (bar[i] > 0) { set label 4 shown(bar_text[i]) at graph 0.05 + bar[i] / 2, graph 0.05 center offset 0, 0.55 font ',7' textcolor rgb '#ffffff' front noenhanced }
    unset colorbox
    if (kind[i] == 1 && legend == 0) {
        legend = 1
        set colorbox user origin screen 1 - 52.0 / width, screen bottom[i] size screen 11.0 / width, screen top[i] - bottom[i]
    }
    if (kind[i] == 0) {
        plot file[i] binary array=(wide[i], high[i]) flipy origin=(0.5, 0.5) format='%uchar%uchar%uchar' using 1:2:3 with rgbimage
    } else {
        plot file[i] binary array=(wide[i], high[i]) flipy origin=(0.5, 0.5) format='%float' using 1 with image
    }
}
unset multiplot
