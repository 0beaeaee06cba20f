/* SPDX-License-Identifier: MIT */
/* gnuplot.h - charts by gnuplot, so that each can be restyled and drawn again by hand.
 *
 * A chart NAME leaves in its folder NAME.csv (the data), NAME.gp (how it is
 * drawn), style.gp (what all charts share: terminal, fonts, colors) and the
 * picture. To restyle, edit style.gp and run "gnuplot NAME.gp" in the folder. */
#ifndef ISO_REPORT_GNUPLOT_H
#define ISO_REPORT_GNUPLOT_H

#include <stdio.h>

#include "base/status.h"

/* format: "svg" or "pdf" (vector text, fonts embedded). A style.gp that is in the folder stays.
 * ISO_E_MISSING without gnuplot, ISO_E_PROGRAM when it fails. */
iso_status iso_gnuplot_draw(const char *dir, const char *name, const char *csv, const char *script, const char *format,
                            iso_error *err);

/* The same of a script that brings its own data; "png", transparent, and "tex", NAME-latex.tex over NAME-latex.pdf, too. */
iso_status iso_gnuplot_draw_script(const char *dir, const char *name, const char *script, const char *format,
                                   iso_error *err);

/* Before charts are drawn in the folder: its style.gp is a copy of the file `from`. */
iso_status iso_gnuplot_use_style(const char *from, const char *dir, iso_error *err);

/* One picture alone, NAME.png, .svg or .pdf by its ending: `write` prints the gnuplot script that follows "set terminal" and
 * "set output". Width and height in pixels of 1/96 inch; a PNG has twice as many, for print. The picture appears when it is
 * whole. ISO_E_USAGE: another ending; ISO_E_MISSING without gnuplot; ISO_E_PROGRAM where it leaves no picture, ISO_E_IO
 * where that has no end, as on a full disk. */
typedef iso_status (*iso_gnuplot_writer)(FILE *gp, void *user, iso_error *err);
iso_status iso_gnuplot_picture(const char *output, double width, double height, iso_gnuplot_writer write, void *user,
                               iso_error *err);
/* "png", "svg" or "pdf"; NULL where a name ends with none of them. */
const char *iso_gnuplot_ending(const char *output);
/* A text between double quotes of a script; of each byte that gnuplot could read as something else stands the number.
 * (Between single quotes gnuplot 5.4 reads two of them as one, but not at the beginning, nor twice.) Never enhanced:
 * "noenhanced" is for the caller. */
void iso_gnuplot_put_quoted(FILE *gp, const char *text);

#endif
