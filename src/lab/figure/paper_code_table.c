/* SPDX-License-Identifier: MIT */
/* paper_code_table.c - the table of the encoder of [diaz-garcia-2017], its Figure 13. */
#include <math.h>

#include "lab/codes/paper_table.h"
#include "lab/figure/paper_own.h"
#include "lab/figure/paper_dots.h"
#include "lab/figure/paper_drawing.h"
#include "lab/figure/paper_kinds.h"

static iso_vec3 entry_place(size_t size, size_t i, size_t j)
{
    const double last = (double)(size - 1);
    return iso_v3((double)i / last, (double)j / last, (last - (double)i - (double)j) / last);
}

/* Draws the unit cube of u, v and w with the plane u + v + w = 1. */
static void draw_table_in_cube(FILE *gp, double panel_mm, const iso_paper_table *t)
{
    iso_drawing d = iso_drawing_begin(gp, panel_mm, 0.98);
    const iso_vec3 half = iso_v3(0.5, 0.5, 0.5);
    static const char *const names[] = {"u", "v", "w"}, *const aligned[] = {"right", "left",
                                                                            "center"}; /* beside lines */
    /* A view that does not look along the plane. */
    iso_drawing_look(&d, iso_v3(0.95, 0.42, 0.5));
    const iso_vec3 corners[3] = {iso_sub(iso_v3(1, 0, 0), half), iso_sub(iso_v3(0, 1, 0), half),
                                 iso_sub(iso_v3(0, 0, 1), half)};
    fputs("$plane << EOD\n", gp);
    iso_drawing_put_triangle(&d, corners);
    fputs("EOD\n$cube << EOD\n", gp);
    for (int axis = 0; axis < 3; ++axis)
        for (int k = 0; k < 4; ++k) {
            const int a = (axis + 1) % 3, b = (axis + 2) % 3;
            const iso_vec3 from = iso_drawing_with(iso_drawing_with(iso_drawing_with(half, axis, -0.5), a,
                                                                    k & 1 ? 0.5 : -0.5),
                                                   b, k & 2 ? 0.5 : -0.5);
            iso_drawing_put_line(&d, from, iso_drawing_with(from, axis, 0.5));
        }
    fputs("EOD\n$entries << EOD\n", gp);
    for (size_t i = 0; i < t->size; ++i)
        for (size_t j = 0; i + j < t->size; ++j)
            iso_drawing_put_dot(&d, iso_sub(entry_place(t->size, i, j), half));
    fputs("EOD\n", gp);
    for (int axis = 0; axis < 3; ++axis) {
        const iso_vec3 at = iso_add(corners[axis],
                                    iso_scale(iso_drawing_with(iso_v3(0, 0, 0), axis, 1), axis == 2 ? 0.1 : 0.05));
        fprintf(gp, "set label note('%s = 1') at first %.3f,%.3f %s front noenhanced font sized(note_pt)\n",
                names[axis], iso_drawing_x(&d, at), iso_drawing_y(&d, at), aligned[axis]);
    }
    fprintf(gp,
            "plot $plane with filledcurves closed fc rgb '#e4edf5', $cube with lines lc rgb '#9aa3ab' lw thick(0.14), "
            "$plane with lines lc rgb '#0b3c6f' lw thick(0.2), $entries with lines lc rgb '#0b3c6f' lw thick(%.3f)\n",
            fmin(0.45 * 1.4 * d.scale / (double)t->size, 0.7));
}

/* Draws the triangle from the front, with an arrow from each entry to its content. */
static void draw_table_contents(FILE *gp, double panel_mm, const iso_paper_table *t, double *longest)
{
    const double side = 0.94 * panel_mm, left = 0.03 * panel_mm, low = 0.5 * panel_mm - 0.5 * side * sqrt(0.75);
    *longest = 0;
    fputs("$arrows << EOD\n", gp);
    for (size_t i = 0; i < t->size; ++i)
        for (size_t j = 0; i + j < t->size; ++j) {
            const iso_vec3 from = entry_place(t->size, i, j);
            const double *e = t->entries[i * t->size + j];
            const iso_vec3 to = iso_v3(e[0], e[1], e[2]);
            /* u at the lower left, v at the lower right, w at the top */
            const double x = left + side * (from.y + 0.5 * from.z), y = low + side * sqrt(0.75) * from.z;
            const double dx = side * (to.y + 0.5 * to.z) + left - x, dy = side * sqrt(0.75) * to.z + low - y;
            *longest = fmax(*longest, sqrt(0.5) * iso_norm(iso_sub(to, from)));
            fprintf(gp, "%.3f %.3f %.3f %.3f\n", x, y, dx, dy);
        }
    fprintf(gp, "EOD\n$triangle << EOD\n%.3f %.3f\n%.3f %.3f\n%.3f %.3f\n%.3f %.3f\nEOD\n", left, low, left + side, low,
            left + 0.5 * side, low + side * sqrt(0.75), left, low);
    fprintf(gp,
            "set label note('u = 1') at first %.3f,%.3f left front noenhanced font sized(note_pt)\n"
            "set label note('v = 1') at first %.3f,%.3f right front noenhanced font sized(note_pt)\n"
            "set label note('w = 1') at first %.3f,%.3f center front noenhanced font sized(note_pt)\n"
            "plot $triangle with lines lc rgb '#9aa3ab' lw thick(0.2), "
            "$arrows with vectors head filled size first %.3f,22 lc rgb '#0b3c6f' lw thick(0.14)\n",
            left, low - 2.2, left + side, low - 2.2, left + 0.5 * side, low + side * sqrt(0.75) + 2.2,
            fmin(0.3 * side / (double)t->size, 1));
}

static iso_status code_table(const iso_figure_job *job, iso_page *page, iso_error *err)
{
    iso_paper p;
    OWNED(iso_paper_table) table = {0};
    double longest;
    char note[96];
    const int bits = iso_lab_figure_of(job)->bits ? iso_lab_figure_of(job)->bits : 5; /* the paper's smallest: 32 */
    if (bits < ISO_DOTS_FEWEST_BITS || bits > ISO_DOTS_MOST_BITS)
        return iso_fail(err, ISO_E_RANGE, "--bits is %d, must be %d to %d: more entries would hide each other", bits,
                        (int)ISO_DOTS_FEWEST_BITS, (int)ISO_DOTS_MOST_BITS);
    const size_t size = (size_t)1 << bits, entries = size * (size + 1) / 2;
    const iso_paper_row row = {
        .columns = 2, .aspect = 1, .gap_mm = 3, .most_mm = 80, .has_titles = true, .has_notes = true};
    NEED(iso_paper_lay_out(&p, job, page, &row, 1, err));
    NEED(iso_paper_table_create(size, &table, err));
    snprintf(note, sizeof note, "%zu entries of a cube of %zu", entries, size);
    draw_table_in_cube(iso_paper_drawing(&p, 0, 0, "(a) entries of the table", note), p.panel_mm[0], &table);
    iso_page_plot_end(page);
    FILE *gp = iso_paper_drawing(&p, 0, 1, "(b) their content", "an arrow from each entry");
    draw_table_contents(gp, p.panel_mm[0], &table, &longest);
    iso_page_plot_end(page);
    fprintf(
        iso_page_caption(page),
        "The table of the barycentric transform T: (a) its %zu entries, a point each, lie in the plane u + v + w = 1 "
        "of a cube of %zu x %zu x %zu; (b) that plane from the front, with an arrow from each entry to its "
        "content, at most %.3f of the triangle's side away.",
        entries, size, size, size, longest);
    json_object_set_new(job->facts, "size", json_integer((json_int_t)size));
    json_object_set_new(job->facts, "entries", json_integer((json_int_t)entries));
    json_object_set_new(job->facts, "longest_move", json_real(longest));
    return ISO_OK;
}

const iso_figure_info iso_figure_code_table = {
    .name = "code-table",
    .summary = "the table of the encoder's transform [diaz-garcia-2017], Figure 13",
    .takes = ISO_FIGURE_OF_NOTHING | ISO_LAB_FIGURE_HAS_BITS,
    .draw = code_table,
};
