# SPDX-License-Identifier: MIT
# What the scripts of figures ask of any figure; after lib.sh.

# All kinds, by the script that draws them.
kinds_of_volumes="tf sheet failure chart plan slices turntable grid levels renderers methods"
kinds_of_papers="code-points code-regions code-dots code-spheres code-table joint-histogram joint-row mixed-volume mixed-surface palette-views seams roi"

# Of DejaVu Sans a box of a word is 1.164 of the size high; of an upright word it is as wide.
sizes_are_right() { # pdf
    pdftotext -bbox "$1" - | awk -F'"' 'function right(mm) {return mm / 1.164 >= 5.95 && mm / 1.164 <= 9.05}
        /<word/ {++n; if (!right($8 - $4) && !right($6 - $2)) {print "neither " $8 - $4 " nor " $6 - $2 " high: " $0; bad = 1}}
        END {exit !(n > 0 && !bad)}'
}
fonts_are_inside() { pdffonts "$1" | awk 'NR > 2 {++n; if ($(NF - 4) != "yes") bad = 1} END {exit !(n > 0 && !bad)}'; }
# As dense as was asked for; a color bar is one pixel wide.
dense_enough() { pdfimages -list "$1" | awk -v d="$2" 'NR > 2 && $4 > 1 {if ($13 < d || $14 < d) bad = 1} END {exit bad}'; }

# latex_takes NAME KIND...: folders of these names; one document with all of them, a page each, whose texts are in LaTeX's fonts.
latex_pages() { # folders
    {
        printf '\\documentclass{article}\\usepackage{graphicx,color}\\begin{document}\n'
        for folder in "$@"; do
            grep -q 'fontsize{' "$folder/figure-latex.tex" || echo "\\error{$folder has no texts}"
            printf '\\graphicspath{{%s/}}\\noindent\\input{%s/figure-latex}\\clearpage\n' "$folder" "$folder"
        done
        printf '\\end{document}\n'
    } >all.tex
    pdflatex -interaction=batchmode -halt-on-error all.tex >/dev/null || { grep -m 3 -A 3 '^!' all.log; return 1; }
    pdffonts all.pdf | grep -q CMR && test "$(pdfinfo all.pdf | sed -n 's/^Pages: *//p')" -ge $#
}
latex_takes() {
    local name=$1
    shift
    if command -v pdflatex >/dev/null; then
        check "$name" latex_pages "$@"
        cp -r "$1" broken && sed -i 's/fontsize{/undefinedcommand{/' broken/figure-latex.tex
        notice "${name}_a_broken_one_is_noticed" latex_pages broken
    else
        skip "$name" "pdflatex is not installed (Debian's texlive-latex-base): LaTeX forms of $* are not compiled"
    fi
}
