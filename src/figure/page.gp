# SPDX-License-Identifier: MIT
# Sizes in points: pdfcairo prints two thirds of what it is told; SVG counts in pixels, 96 an inch; LaTeX is told by the text.
sized(pt) = sprintf(',%g', format eq 'pdf' ? 1.5 * pt : format eq 'png' ? pt * dpi / 96.0 : pt / 0.75)
latex_size(pt) = sprintf('\fontsize{%g}{%g}\selectfont{}', pt, 1.2 * pt)
say(pt, plain, latex) = format eq 'tex' ? latex_size(pt) . latex : plain
title(s) = say(title_pt, s, s)
note(s) = say(note_pt, s, s)
# Writes 10^k, k from 0 to 15.
power(k) = say(note_pt, '10' . word('⁰ ¹ ² ³ ⁴ ⁵ ⁶ ⁷ ⁸ ⁹ ¹⁰ ¹¹ ¹² ¹³ ¹⁴ ¹⁵', k + 1), sprintf('$10^{%d}$', k))
ticks(f) = format eq 'tex' ? latex_size(note_pt) . '$' . f . '$' : f
pen(pt) = format eq 'png' ? pt * dpi / 72.0 / 1.2 : format eq 'svg' ? pt / 0.75 / 1.2 : pt / 0.6
# Fonts of ticks and labels of axes have to be variables.
note_font = sized(note_pt)
title_font = sized(title_pt)
