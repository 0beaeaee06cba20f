/* SPDX-License-Identifier: MIT */
/* tf_bar.h - a transfer function as a bar: its colors over value, with the opacity of a length, over gray squares. */
#pragma once

#include "figure/picture.h"

/* Returns the length that a table's opacities are stated for; 1 mm if it has none. */
double iso_figure_tf_unit_mm(const iso_tf_table *t);
/* Returns 1 - exp(-extinction * length). */
double iso_figure_opacity(double extinction_per_mm, double length_mm);
/* Writes "value", with the unit of the volume of a job if it has one: "value in HU". job: or NULL. */
void iso_figure_value_text(const iso_figure_job *job, char *text, size_t size);
/* Computes the range of values of the table and the volume. */
void iso_figure_tf_range(const iso_tf_table *t, const iso_level *level0, double range[2]);

/* Puts the bar with an axis of values below it. Its upper half shows the colors of fifty times the length. box: that
 * of the bar alone. */
void iso_figure_put_tf_bar(iso_page *page, const iso_page_box *box, const iso_tf_table *t, const double range[2]);
/* Writes the part of a caption that explains it. */
void iso_figure_describe_tf_bar(FILE *caption, double unit_mm);

/* The bar under rendered pictures. Zeroed: none. */
typedef struct iso_figure_tf_foot {
    const iso_tf_table *tf; /* borrowed */
    const iso_figure_job *job; /* with the input that names the values' unit; NULL: values have none */
    double range[2];        /* values at its ends */
    bool of_level0;         /* True if coarser levels have other transfer functions */
} iso_figure_tf_foot;
/* Returns the bar of a subject; none for label maps, which have no opacity over value. */
iso_figure_tf_foot iso_figure_tf_foot_of(const iso_figure_subject *s);
/* Returns the height of the bar with its texts; 0: none. */
double iso_figure_tf_foot_mm(const iso_figure_tf_foot *foot);
/* Puts the bar above_mm over the page's lower edge, and describes it in the caption. */
void iso_figure_put_tf_foot(const iso_figure_tf_foot *foot, iso_page *page, double above_mm);
