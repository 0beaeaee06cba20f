/* SPDX-License-Identifier: MIT */
/* gnuplot.h - charts by gnuplot. Each one can be restyled and drawn again by hand.
 *
 * A chart NAME leaves in its folder NAME.csv (the data), NAME.gp (the script), style.gp (shared by all charts:
 * terminal, fonts, colors) and the picture. To restyle, edit style.gp and run "gnuplot NAME.gp" in the folder. */
#pragma once

#include <stdio.h>

#include "base/status.h"

/* Draws a chart as "svg" or "pdf" (vector text, fonts embedded). An existing style.gp in the folder stays.
 * ISO_E_MISSING: gnuplot is not installed; ISO_E_PROGRAM: it fails. */
iso_status iso_gnuplot_draw(const char *dir, const char *name, const char *csv, const char *script, const char *format,
                            iso_error *err);

/* Draws the same from a script that contains its data. More formats: "png", transparent, and "tex", NAME-latex.tex
 * over NAME-latex.pdf. */
iso_status iso_gnuplot_draw_script(const char *dir, const char *name, const char *script, const char *format,
                                   iso_error *err);

/* Copies the file `from` as the folder's style.gp; call it before charts are drawn. */
iso_status iso_gnuplot_use_style(const char *from, const char *dir, iso_error *err);

/* Draws one picture, NAME.png, .svg or .pdf by its ending. `write` prints the gnuplot script after "set terminal"
 * and "set output". Width and height in pixels of 1/96 inch; a PNG has twice as many, for print. The file appears
 * once it is complete. ISO_E_USAGE: another ending; ISO_E_MISSING: gnuplot is not installed; ISO_E_PROGRAM: it wrote
 * no picture; ISO_E_IO: the picture is incomplete, for example on a full disk. */
typedef iso_status (*iso_gnuplot_writer)(FILE *gp, void *user, iso_error *err);
iso_status iso_gnuplot_picture(const char *output, double width, double height, iso_gnuplot_writer write, void *user,
                               iso_error *err);
/* Returns "png", "svg" or "pdf"; NULL for other endings. */
const char *iso_gnuplot_ending(const char *output);
/* Writes a text between double quotes into a script; bytes with a meaning to gnuplot become escapes. (Between single
 * quotes, gnuplot 5.4 reads two of them as one, but not at the beginning, nor twice.) The caller adds "noenhanced". */
void iso_gnuplot_put_quoted(FILE *gp, const char *text);
