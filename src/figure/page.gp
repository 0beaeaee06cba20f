# SPDX-License-Identifier: MIT
# Sizes in points: pdfcairo prints two thirds of what it is told; SVG counts in pixels, 96 an inch; LaTeX is told by the text.
sized(pt) = sprintf(',%g', format eq 'pdf' ? 1.5 * pt : format eq 'png' ? pt * dpi / 96.0 : pt / 0.75)
latex_size(pt) = sprintf('\fontsize{%g}{%g}\selectfont{}', pt, 1.2 * pt)
say(pt, plain, latex) = format eq 'tex' ? latex_size(pt) . latex : plain
title(s) = say(title_pt, s, s)
note(s) = say(note_pt, s, s)
ticks(f) = format eq 'tex' ? latex_size(note_pt) . '$' . f . '$' : f
powers = format eq 'tex' ? latex_size(note_pt) . '$10^{%T}$' : '1e%T'
pen(pt) = format eq 'png' ? pt * dpi / 72.0 / 1.2 : format eq 'svg' ? pt / 0.75 / 1.2 : pt / 0.6
# Fonts of ticks and labels of axes have to be variables.
note_font = sized(note_pt)
title_font = sized(title_pt)
