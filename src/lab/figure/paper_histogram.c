/* SPDX-License-Identifier: MIT */
/* paper_histogram.c - joint histograms of level 0 and a coarse level (tf/histogram.h): darkness is the logarithm of the
 * count, level 0 runs to the right and the coarse level upward. A line shows the means of the rows. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "lab/figure/paper_own.h"
#include "lab/figure/paper_kinds.h"
#include "tf/histogram.h"
#include "volume/synthetic.h"

enum { BITS = 8, MOST_LEVELS = 4, OWN_SIDE = 96 };

/* Makes thin shells, which coarse levels dilute most, with scanner-like noise. */
static iso_status make_shells(iso_volume *v, iso_error *err)
{
    const size_t size[3] = {OWN_SIDE, OWN_SIDE, OWN_SIDE};
    const iso_field field = {.kind = ISO_FIELD_SHELLS,
                             .grain = 0.02,
                             .geometry = iso_geometry_axis_aligned(size, (const double[3]){1, 1, 1})};
    return iso_field_sample(&field, ISO_F32, v, err);
}
static const iso_paper_own shells = {"two shells by a formula", make_shells};

/* ---- a row ---- */

typedef struct row {
    double count, mean, deviation; /* of z, in units of bins */
} row;

static row measure_row(const iso_joint *j, size_t i)
{
    row r = {0, 0, 0};
    for (size_t e = j->row_start[i]; e < j->row_start[i + 1]; ++e) {
        r.count += (double)j->entry_count_of[e];
        r.mean += (double)j->entry_count_of[e] * j->entry_z[e];
    }
    r.mean /= fmax(r.count, 1);
    for (size_t e = j->row_start[i]; e < j->row_start[i + 1]; ++e)
        r.deviation += (double)j->entry_count_of[e] * pow(j->entry_z[e] - r.mean, 2);
    r.deviation = sqrt(r.deviation / fmax(r.count, 1));
    return r;
}

/* Returns the RMS of z - s over all voxels, in values: the error of applying level 0's transfer function. */
static double spread(const iso_joint *j)
{
    double sum = 0;
    for (size_t i = 0; i < j->s.count; ++i)
        for (size_t e = j->row_start[i]; e < j->row_start[i + 1]; ++e) {
            const double z = j->z.lo + j->entry_z[e] * j->z.step, s = j->s.lo + (double)i * j->s.step;
            sum += (double)j->entry_count_of[e] * (z - s) * (z - s);
        }
    return sqrt(sum / (double)j->voxel_count);
}

/* ---- the map ---- */

/* Space below the panels for ticks and axis label, and at their left and right. */
static const double foot_mm = 8, axis_room_mm = 9.5, bar_room_mm = 13;
/* Least width of a figure with two panels next to each other; below it they are stacked. */
static const double beside_from_mm = 100;

/* Reverses the color map, so that low counts are pale and high counts dark. part: 0 to 1. */
static void shade(const iso_figure_job *job, double part, unsigned char rgb[3])
{
    iso_colormap_lookup(job->map, 0.94 * (1 - part), rgb);
}

static double most_of(const iso_joint *j)
{
    uint64_t most = 1;
    for (size_t e = 0; e < j->entry_count; ++e)
        most = j->entry_count_of[e] > most ? j->entry_count_of[e] : most;
    return (double)most;
}

/* Draws counts from 1 to `most` in logarithms, one pixel per bin, s upward; zero counts stay white. */
static iso_status put_pixels(const iso_paper *p, const iso_page_box *box, const iso_joint *j, double most,
                             iso_error *err)
{
    const size_t bytes = 3 * j->z.count * j->s.count;
    FREED unsigned char *rgb = malloc(bytes);
    NEED_MEMORY(rgb, err, "figure: out of memory");
    memset(rgb, 255, bytes);
    for (size_t i = 0; i < j->s.count; ++i)
        for (size_t e = j->row_start[i]; e < j->row_start[i + 1]; ++e)
            shade(p->job, log((double)j->entry_count_of[e]) / fmax(log(most), 1e-9),
                  rgb + 3 * ((j->s.count - 1 - i) * j->z.count + j->entry_z[e]));
    iso_page_put_colors(p->page, box, rgb, j->z.count, j->s.count);
    return ISO_OK;
}

/* Draws the ticks of an axis in units of bins. */
static void put_ticks(FILE *gp, char axis, const iso_bins *bins)
{
    const double range = bins->step * (double)(bins->count - 1), step = iso_paper_tick_step(range);
    const double first = ceil(bins->lo / step - 1e-9);
    fprintf(gp, "set %ctics (", axis);
    for (double t = first; t * step <= bins->lo + range * (1 + 1e-9); ++t)
        fprintf(gp, "%sticks('%.6g') %.4f", t > first ? ", " : "", t * step + 0.0,
                (t * step - bins->lo) / bins->step + 0.5);
    fprintf(gp, ") nomirror out scale 0.4 font note_font offset %s\n", axis == 'x' ? "0, 0.4" : "0.6, 0");
}

/* Draws the axes, in units of bins: level 0 to the right; upward: label of the coarse level's axis, or NULL. */
static void put_axes(FILE *gp, const iso_joint *j, const char *upward)
{
    fprintf(gp, "thick(mm) = pen(72 / 25.4 * mm)\nset xrange [0:%zu]\nset yrange [0:%zu]\nset border 15\nunset ytics\n",
            j->z.count, j->s.count);
    put_ticks(gp, 'x', &j->z);
    if (upward)
        put_ticks(gp, 'y', &j->s);
    fputs("set xlabel note('value of level 0') offset 0, 0.9\n", gp);
    if (upward)
        fprintf(gp, "set ylabel note('%s') offset 1.6, 0\n", upward);
}

/* Draws the means of the rows and the diagonal, and the row itself unless row_at is negative. */
static void put_lines(FILE *gp, const iso_joint *j, const char *name, double row_at)
{
    fprintf(gp, "$means%s << EOD\n", name);
    for (size_t i = 0; i < j->s.count; ++i) {
        const row r = measure_row(j, i);
        if (r.count > 0)
            fprintf(gp, "%.3f %.1f\n", r.mean + 0.5, (double)i + 0.5);
    }
    fprintf(gp, "EOD\n$equal << EOD\n0 0\n%zu %zu\nEOD\n", j->z.count, j->s.count);
    if (row_at >= 0)
        fprintf(gp, "set arrow from 0,%.3f to %zu,%.3f nohead front lc rgb '#0072b2' lw thick(0.2)\n", row_at,
                j->z.count, row_at);
    fprintf(gp,
            "plot $equal with lines lc rgb '#555555' lw thick(0.12) dt 2, $means%s with lines lc rgb '#ffffff' lw "
            "thick(0.7), $means%s with lines lc rgb '#009e73' lw thick(0.35)\n",
            name, name);
}

/* Draws one map in its panel. */
static iso_status put_map(const iso_paper *p, size_t column, const char *title, const iso_joint *j, double most,
                          const char *upward, double row_at, iso_error *err)
{
    char name[24];
    const iso_page_box box = iso_paper_panel(p, 0, column, title, NULL);
    const iso_status status = put_pixels(p, &box, j, most, err);
    FILE *gp = iso_page_plot_begin(p->page, &box);
    snprintf(name, sizeof name, "%zu", column);
    put_axes(gp, j, upward);
    put_lines(gp, j, name, row_at);
    iso_page_plot_end(p->page);
    return status;
}

/* Draws the color bar at the right of the last panel, with powers of ten. */
static void put_bar(const iso_paper *p, size_t column, double most)
{
    enum { COLORS = 128 };
    unsigned char rgb[3];
    iso_page_box box = iso_paper_panel(p, 0, column, NULL, NULL);
    const int decades = (int)floor(log10(most)), step = decades / 5 + 1;
    box.left += box.width + 1.5;
    box.width = 2.2;
    for (int i = 0; i < COLORS; ++i) { /* as iso_page_put_color_bar() does */
        char color[8];
        shade(p->job, 1 - (i + 0.5) / COLORS, rgb);
        snprintf(color, sizeof color, "#%02x%02x%02x", rgb[0], rgb[1], rgb[2]);
        iso_page_put_rectangle(p->page,
                               &(iso_page_box){box.left, box.top + box.height * i / COLORS, box.width,
                                               box.height * (COLORS - i) / COLORS},
                               color, NULL);
    }
    for (int k = 0; k <= decades; k += step) {
        const double x = box.left + box.width, y = box.top + box.height * (1 - k / log10(most));
        char text[16];
        snprintf(text, sizeof text, k < 4 ? "%.0f" : "1e%g", k < 4 ? pow(10, k) : k);
        iso_page_put_line(p->page, x, y, x + 0.6, y, &(iso_page_pen){"#444444", 0.4, 0});
        iso_page_put_text(p->page, &(iso_page_text){.x = x + 0.9, .y = y, .role = ISO_PAGE_NOTE}, text);
    }
    iso_page_put_text(p->page,
                      &(iso_page_text){.x = box.left + box.width + 0.9 +
                                            iso_page_text_mm(p->page, ISO_PAGE_NOTE, "1000") +
                                            0.6 * iso_page_line_mm(p->page, ISO_PAGE_NOTE),
                                       .y = box.top + 0.5 * box.height,
                                       .role = ISO_PAGE_NOTE,
                                       .align = ISO_PAGE_CENTER,
                                       .upright = 1},
                      "voxels");
}

/* ---- the figures ---- */

static iso_status load(const iso_figure_job *job, size_t coarsest, iso_pyramid *p, iso_error *err)
{
    iso_pyramid_options build = iso_pyramid_defaults();
    build.level_count = coarsest + 1;
    const iso_status status = iso_paper_load(job, &shells, &build, p, err);
    if (status == ISO_OK && p->level_count <= coarsest)
        return iso_fail(err, ISO_E_RANGE, "%s has levels 0 to %zu, the figure needs level %zu",
                        iso_paper_volume_name(job, &shells), p->level_count - 1, coarsest);
    return status;
}

static void put_fact(json_t *rows, size_t level, const iso_joint *j)
{
    json_array_append_new(rows,
                          json_pack("{s:i, s:I, s:I, s:f}", "level", (int)level, "voxels", (json_int_t)j->voxel_count,
                                    "pairs", (json_int_t)j->entry_count, "rms_of_z_minus_s", spread(j)));
}

/* Draws all histograms on one scale of counts. */
static iso_status draw_histograms(const iso_figure_job *job, iso_page *page, const iso_joint *joints, size_t count,
                                  iso_error *err)
{
    const iso_paper_row shape = {.columns = count,
                                 .aspect = 1,
                                 .left_mm = axis_room_mm,
                                 .right_mm = bar_room_mm,
                                 .gap_mm = 3,
                                 .foot_mm = foot_mm,
                                 .most_mm = 74,
                                 .has_titles = true};
    iso_paper p;
    json_t *rows = json_array();
    double most = 10;
    iso_status status = iso_paper_lay_out(&p, job, page, &shape, 1, err);
    json_object_set_new(job->facts, "levels", rows);
    for (size_t i = 0; i < count; ++i)
        most = fmax(most, most_of(&joints[i]));
    for (size_t i = 0; i < count && status == ISO_OK; ++i) {
        char title[64];
        snprintf(title, sizeof title, "(%c) level %zu", (char)('a' + (int)i), i + 1);
        status = put_map(&p, i, title, &joints[i], most, i == 0 ? "value of the coarse level" : NULL, -1, err);
        put_fact(rows, i + 1, &joints[i]);
        fprintf(iso_page_caption(page), " Level %zu: %zu pairs of values, rms of their difference %.4g.", i + 1,
                joints[i].entry_count, spread(&joints[i]));
    }
    if (status == ISO_OK)
        put_bar(&p, count - 1, most);
    return status;
}

/* Draws a joint histogram per coarse level. --levels includes level 0, like the other kinds. */
static iso_status joint_histogram(const iso_figure_job *job, iso_page *page, iso_error *err)
{
    const int levels = job->levels ? job->levels - 1 : 2;
    OWNED(iso_pyramid) p = {0};
    iso_joint joints[MOST_LEVELS] = {{.entry_count = 0}};
    if (levels < 1 || levels > MOST_LEVELS)
        return iso_fail(err, ISO_E_RANGE,
                        "--levels is %d, must be 2 to %d here: level 0, and one panel per coarse level", levels + 1,
                        (int)MOST_LEVELS + 1);
    iso_status status = load(job, (size_t)levels, &p, err);
    for (int k = 0; k < levels && status == ISO_OK; ++k)
        status = iso_joint_compute(&p, (size_t)k + 1, BITS, ISO_SECOND_VALUE_NONE, job->cli->threads, &joints[k], err);
    if (status == ISO_OK) {
        fprintf(
            iso_page_caption(page),
            "Joint histograms of %s: the number of voxels of level 0 with a value (across) where a coarse level has "
            "another (upward), in logs. Green: the mean of each row. Dashed: equal values.",
            iso_paper_volume_name(job, &shells));
        status = draw_histograms(job, page, joints, (size_t)levels, err);
    }
    for (int k = 0; k < levels; ++k)
        iso_joint_destroy(&joints[k]);
    return status;
}

/* Selects the row with the widest spread, among those with at least a thousandth of the voxels. */
static size_t widest_row(const iso_joint *j)
{
    size_t widest = 0;
    double most = -1;
    for (size_t i = 0; i < j->s.count; ++i) {
        const row r = measure_row(j, i);
        if (r.count >= 1e-3 * (double)j->voxel_count && r.deviation > most)
            most = r.deviation, widest = i;
    }
    return widest;
}

/* Draws the counts of one row as bars, and the weights of Eq. 7 scaled to the highest count. */
static void draw_row(FILE *gp, const iso_joint *j, size_t i)
{
    const row r = measure_row(j, i);
    const double deviation = fmax(r.deviation, 0.5);
    double top = 0;
    for (size_t e = j->row_start[i]; e < j->row_start[i + 1]; ++e)
        top = fmax(top, (double)j->entry_count_of[e]);
    fputs("$bars << EOD\n", gp);
    for (size_t e = j->row_start[i]; e < j->row_start[i + 1]; ++e)
        fprintf(gp, "%.1f %.5f\n", j->entry_z[e] + 0.5, (double)j->entry_count_of[e]);
    fputs("EOD\n$weights << EOD\n", gp);
    for (size_t z = 0; z < 4 * j->z.count; ++z) {
        const double x = ((double)z / 4 - r.mean) / deviation;
        if (fabs(x) <= 3) /* the paper's window */
            fprintf(gp, "%.2f %.5f\n", (double)z / 4 + 0.5, top * exp(-0.5 * x * x));
    }
    fprintf(
        gp,
        "EOD\nset border 3\nset boxwidth 1\nset yrange [0:%.5f]\nset ytics %g nomirror out scale 0.4 font note_font offset 0.6, 0\n"
        "set arrow from %.3f,graph 0 to %.3f,graph 0.98 nohead front lc rgb '#009e73' lw thick(0.35)\n"
        "set label note('mean') at %.3f,graph 0.97 offset 0.6,0 left front font sized(note_pt) textcolor rgb '#00684c'\n"
        "set label note('weights') at %.3f,%.5f offset 0.8,0 left front font sized(note_pt) textcolor rgb '#a84a00'\n"
        "plot $bars with boxes fs solid noborder lc rgb '#8fa6bd', $weights with lines lc rgb '#d55e00' lw "
        "thick(0.35)\n",
        fmax(top, 1) / 0.92, iso_paper_tick_step(fmax(top, 3)), r.mean + 0.5, r.mean + 0.5, r.mean + 0.5,
        r.mean + deviation + 0.5, top * exp(-0.5));
}

static iso_status draw_one_row(const iso_figure_job *job, iso_page *page, const iso_joint *j, int level, iso_error *err)
{
    const bool beside = job->width_mm >= beside_from_mm;
    const iso_paper_row shape = {.columns = beside ? 2 : 1,
                                 .aspect = 1,
                                 .left_mm = axis_room_mm,
                                 .right_mm = beside ? 2 : bar_room_mm,
                                 .gap_mm = bar_room_mm + axis_room_mm,
                                 .foot_mm = foot_mm,
                                 .most_mm = 74,
                                 .has_titles = true};
    iso_paper p;
    const size_t i = widest_row(j);
    const row r = measure_row(j, i);
    const double s = j->s.lo + (double)i * j->s.step, mean = j->z.lo + r.mean * j->z.step;
    char title[64], upward[64];
    iso_status status = iso_paper_lay_out(&p, job, page, (iso_paper_row[]){shape, shape}, beside ? 1 : 2, err);
    if (status != ISO_OK)
        return status;
    const double most = fmax(most_of(j), 10);
    snprintf(title, sizeof title, "(a) level %d against level 0", level);
    snprintf(upward, sizeof upward, "value of level %d", level);
    status = put_map(&p, 0, title, j, most, upward, (double)i + 0.5, err);
    put_bar(&p, 0, most);
    snprintf(title, sizeof title, "(b) voxels at %.3g", s);
    const iso_page_box box = iso_paper_panel(&p, beside ? 0 : 1, beside ? 1 : 0, title, NULL);
    FILE *gp = iso_page_plot_begin(page, &box);
    put_axes(gp, j, NULL);
    draw_row(gp, j, i);
    iso_page_plot_end(page);
    fprintf(
        iso_page_caption(page),
        " (a) Green: the mean of each row; dashed: equal values; blue: the row at the value %.4g. (b) That row: %.0f "
        "voxels of level 0 with the mean %.4g and the deviation %.3g, and the weights of Eq. 7, a Gaussian within 3 "
        "deviations.",
        s, r.count, mean, r.deviation * j->z.step);
    json_object_set_new(job->facts, "row",
                        json_pack("{s:f, s:f, s:f, s:f}", "s", s, "voxels", r.count, "mean", mean, "deviation",
                                  r.deviation * j->z.step));
    return status;
}

static iso_status joint_row(const iso_figure_job *job, iso_page *page, iso_error *err)
{
    const int level = job->level ? job->level : 1;
    OWNED(iso_pyramid) p = {0};
    OWNED(iso_joint) joint = {.entry_count = 0};
    NEED(load(job, (size_t)level, &p, err));
    NEED(iso_joint_compute(&p, (size_t)level, BITS, ISO_SECOND_VALUE_NONE, job->cli->threads, &joint, err));
    json_t *rows = json_array();
    put_fact(rows, (size_t)level, &joint);
    json_object_set_new(job->facts, "levels", rows);
    fprintf(
        iso_page_caption(page),
        "The joint histogram of %s: the number of voxels of level 0 with a value (across) where level %d has another "
        "(upward), in logs.",
        iso_paper_volume_name(job, &shells), level);
    return draw_one_row(job, page, &joint, level, err);
}

const iso_figure_info iso_figure_joint_histogram = {
    .name = "joint-histogram",
    .summary = "joint histograms of level 0 and coarse levels [diaz-garcia-2016], Figure 3",
    .takes = ISO_FIGURE_OF_NOTHING | ISO_FIGURE_OF_VOLUME | ISO_FIGURE_HAS_LEVELS,
    .draw = joint_histogram,
};
const iso_figure_info iso_figure_joint_row = {
    .name = "joint-row",
    .summary = "one joint histogram, one of its rows and the weights [diaz-garcia-2016], Figure 2",
    .takes = ISO_FIGURE_OF_NOTHING | ISO_FIGURE_OF_VOLUME | ISO_FIGURE_HAS_LEVEL,
    .draw = joint_row,
};
