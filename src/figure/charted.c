/* SPDX-License-Identifier: MIT */
/* The result of a chart in print: error against time and bytes, with the fronts as stairs and numbered settings. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/json.h"
#include "figure/kinds.h"
#include "figure/page_text.h"
#include "renderers/renderers.h"

enum { MOST_SERIES = 8, MOST_LISTED = 40 };
static const char *const colors[MOST_SERIES] = {"#0072b2", "#d55e00", "#009e73", "#e69f00",
                                                "#cc79a7", "#56b4e9", "#222222", "#999999"};
static const int points[MOST_SERIES] = {7, 5, 9, 13, 11, 6, 4, 8};

typedef struct charted {
    const json_t *options, *cases;
    const char *metric, *bytes_key;
    char names[MOST_SERIES][64]; /* renderers, each with a color and a shape */
    size_t series;
} charted;

static double number_of(const json_t *object, const char *key)
{
    const json_t *value = json_object_get(object, key);
    return json_is_number(value) ? json_number_value(value) : NAN;
}

static const char *string_of(const json_t *object, const char *key)
{
    const char *s = json_string_value(json_object_get(object, key));
    return s ? s : "";
}

static double error_of(const charted *c, const json_t *one)
{
    if (!strcmp(c->metric, "flip"))
        return number_of(one, "flip_mean");
    return !strcmp(c->metric, "rmse") ? number_of(one, "rmse") : 1 - number_of(one, "ssim");
}

static size_t series_of(const charted *c, const json_t *one)
{
    size_t i = 0;
    while (i < c->series && strcmp(c->names[i], string_of(one, "renderer")) != 0)
        ++i;
    return i < MOST_SERIES ? i : MOST_SERIES - 1;
}

static void find_series(charted *c)
{
    json_t *one;
    size_t i;
    json_array_foreach (c->cases, i, one) {
        const size_t at = series_of(c, one);
        if (at == c->series && c->series < MOST_SERIES)
            snprintf(c->names[c->series++], sizeof *c->names, "%s", string_of(one, "renderer"));
    }
}

typedef struct corner {
    double cost, error;
} corner;

static int by_cost(const void *a, const void *b)
{
    const corner *x = a, *y = b;
    return (x->cost > y->cost) - (x->cost < y->cost);
}

/* Draws stairs: the least error for up to each cost. */
static void put_front(FILE *gp, const charted *c, bool of_time)
{
    FREED corner *corners = calloc(json_array_size(c->cases) + 1, sizeof *corners);
    json_t *one;
    size_t i, count = 0;
    if (!corners)
        return;
    json_array_foreach (c->cases, i, one)
        if (json_is_true(json_object_get(one, of_time ? "on_time_front" : "on_bytes_front")))
            corners[count++] = (corner){number_of(one, of_time ? "milliseconds" : c->bytes_key), error_of(c, one)};
    qsort(corners, count, sizeof *corners, by_cost);
    fprintf(gp, "$front%d << EOD\n", of_time);
    for (i = 0; i < count; ++i) {
        if (i > 0)
            fprintf(gp, "%.9g %.9g\n", corners[i].cost, corners[i - 1].error);
        fprintf(gp, "%.9g %.9g\n", corners[i].cost, corners[i].error);
    }
    fputs("EOD\n", gp);
}

/* ---- a panel ---- */

/* One axis each for costs and errors. */
typedef struct axes {
    double range[2][2], mm[2];
    bool of_time;
} axes;

static bool place_of(const charted *c, const axes *a, const json_t *one, double at[2])
{
    at[0] = number_of(one, a->of_time ? "milliseconds" : c->bytes_key);
    at[1] = error_of(c, one);
    return at[0] > 0 && at[1] > 0;
}

/* Finds the ranges of all settings, with a margin. */
static void find_ranges(const charted *c, axes *a)
{
    static const double before[2] = {1.5, 1.6}, behind[2] = {1.3, 1.6};
    double least[2] = {INFINITY, INFINITY}, most[2] = {0, 0};
    json_t *one;
    size_t i;
    json_array_foreach (c->cases, i, one) {
        double at[2];
        for (int k = 0; k < 2 && place_of(c, a, one, at); ++k)
            least[k] = fmin(least[k], at[k]), most[k] = fmax(most[k], at[k]);
    }
    for (int k = 0; k < 2; ++k)
        a->range[k][0] = least[k] / before[k], a->range[k][1] = most[k] * behind[k];
}

/* True if a number would overlap no other; false: it is omitted. placed: positions of the others, in millimeters. */
static bool has_room(const axes *a, const double at[2], double (*placed)[2], size_t *count)
{
    const double wide_mm = 3.2, high_mm = 2.4;
    double mm[2];
    for (int k = 0; k < 2; ++k)
        mm[k] = log(at[k] / a->range[k][0]) / log(a->range[k][1] / a->range[k][0]) * a->mm[k];
    for (size_t i = 0; i < *count; ++i)
        if (fabs(placed[i][0] - mm[0]) < wide_mm && fabs(placed[i][1] - mm[1]) < high_mm)
            return false;
    memcpy(placed[(*count)++], mm, sizeof mm);
    return true;
}

/* Writes a row per setting: cost, error, level, series, and its number if it is shown. */
static void put_data(FILE *gp, const charted *c, const axes *a)
{
    double(*placed)[2] = calloc(json_array_size(c->cases) + 1, sizeof *placed);
    json_t *one;
    size_t i, count = 0;
    fprintf(gp, "$rows%d << EOD\n", a->of_time);
    json_array_foreach (c->cases, i, one) {
        double at[2];
        if (!place_of(c, a, one, at))
            continue;
        const bool on_front = json_is_true(json_object_get(one, a->of_time ? "on_time_front" : "on_bytes_front"));
        const double number = on_front ? fmax(number_of(one, "number"), 0) : 0;
        fprintf(gp, "%.9g %.9g %g %zu %g\n", at[0], at[1], number_of(one, "level"), series_of(c, one),
                number > 0 && placed && has_room(a, at, placed, &count) ? number : 0);
    }
    fputs("EOD\n", gp);
    free(placed);
    put_front(gp, c, a->of_time);
}

/* Writes ticks at 1, 2 and 5 of each decade, or only at decades if there are many, in the given unit. Below a
 * thousandth they are powers of ten. */
static void put_ticks(FILE *gp, char axis, const double range[2], double unit)
{
    const bool many = log10(range[1] / range[0]) > 2.4;
    const char *before = "";
    fprintf(gp, "set %crange [%.6g:%.6g]; set m%ctics default; set %ctics (", axis, range[0], range[1], axis, axis);
    for (int decade = (int)floor(log10(range[0])); decade <= (int)ceil(log10(range[1])); ++decade)
        for (int m = 1; m <= (many ? 1 : 5); m = m == 1 ? 2 : m + 3) {
            const double at = m * pow(10, decade);
            if (at < range[0] || at > range[1])
                continue;
            char text[64];
            iso_page_number(at / unit, at / unit / m, text);
            fputs(before, gp);
            iso_page_text_put(gp, "note_pt", text);
            fprintf(gp, " %.9g", at);
            before = ", ";
        }
    fprintf(gp, ") offset %s\n", axis == 'x' ? "0, 0.4" : "0.8, 0");
}

static void put_panel(iso_page *page, const charted *c, const iso_page_box *box, bool of_time, bool named)
{
    axes a = {.of_time = of_time, .mm = {box->width, box->height}};
    FILE *gp = iso_page_plot_begin(page, box);
    iso_page_add_panel(page, &(iso_page_box){box->left - 10, box->top - 3, box->width, box->height});
    find_ranges(c, &a);
    put_data(gp, c, &a);
    fputs("set logscale xy; set grid lc rgb '#e8e8e8' lw pen(0.4) lt 1\n", gp);
    put_ticks(gp, 'x', a.range[0], of_time ? 1 : 1e6);
    put_ticks(gp, 'y', a.range[1], 1);
    fprintf(gp, "plot $front%d using 1:2 with lines lc rgb '#b0b0b0' lw pen(1)", of_time);
    for (size_t i = 0; i < c->series; ++i)
        fprintf(
            gp,
            ", $rows%d using ($4 == %zu ? $1 : NaN):2:(pen(0.5 * 0.75 ** $3)) with points pt %d ps variable lc rgb '%s'",
            of_time, i, points[i], colors[i]);
    fprintf(gp,
            ", $rows%d using ($5 > 0 ? $1 : NaN):2:(note(sprintf('%%d', $5))) with labels right offset -0.6, -0.3 "
            "font note_font textcolor rgb '#222222'\n",
            of_time);
    iso_page_plot_end(page);
    iso_page_put_text(page,
                      &(iso_page_text){box->left + 0.5 * box->width, box->top + box->height + 7.5, ISO_PAGE_NOTE,
                                       ISO_PAGE_CENTER, 0, NULL},
                      of_time                                 ? "time of a frame, ms"
                      : !strcmp(c->bytes_key, "stored_bytes") ? "megabytes of the level in files"
                                                              : "megabytes that the renderer holds");
    if (named)
        iso_page_put_text(page,
                          &(iso_page_text){1.7, box->top + 0.5 * box->height, ISO_PAGE_NOTE, ISO_PAGE_CENTER, 1, NULL},
                          !strcmp(c->metric, "rmse")   ? "RMSE to level 0"
                          : !strcmp(c->metric, "flip") ? "FLIP to level 0"
                                                       : "1 − SSIM to level 0");
}

static const char *title_of(const char *renderer)
{
    const iso_renderer_info *info = NULL;
    return iso_renderer_from_name(renderer, &info, NULL) == ISO_OK ? info->title : renderer;
}

/* Puts renderers by color and shape. */
static void put_legend(iso_page *page, const charted *c, double left, double y)
{
    for (size_t i = 0; i < c->series; ++i) {
        const iso_page_box square = {left, y - 0.8, 1.6, 1.6};
        iso_page_put_rectangle(page, &square, colors[i], NULL);
        iso_page_put_text(page, &(iso_page_text){.x = left + 2.2, .y = y, .role = ISO_PAGE_NOTE},
                          title_of(c->names[i]));
        left += 6 + iso_page_text_mm(page, ISO_PAGE_NOTE, title_of(c->names[i]));
    }
    iso_page_put_text(page, &(iso_page_text){.x = left, .y = y, .role = ISO_PAGE_NOTE}, "smaller: coarser levels");
}

static int by_number(const void *a, const void *b)
{
    const double x = number_of(*(json_t *const *)a, "number"), y = number_of(*(json_t *const *)b, "number");
    return (x > y) - (x < y);
}

static void write_caption(const charted *c, FILE *f)
{
    json_t *one, **numbered = calloc(json_array_size(c->cases) + 1, sizeof *numbered);
    size_t i, count = 0;
    fprintf(f, "Error against cost of %zu settings for %s (%s): stairs join the front.", json_array_size(c->cases),
            string_of(c->options, "volume"), string_of(c->options, "scene"));
    json_array_foreach (c->cases, i, one)
        if (numbered && number_of(one, "number") > 0)
            numbered[count++] = one;
    if (numbered)
        qsort(numbered, count, sizeof *numbered, by_number);
    for (i = 0; i < count && i < MOST_LISTED; ++i)
        fprintf(f, " %g: %s.", number_of(numbered[i], "number"), string_of(numbered[i], "setting"));
    free(numbered);
}

static iso_status draw_loaded(const iso_figure_job *job, charted *c, iso_page *page, iso_error *err)
{
    const double width = job->width_mm, left = 12, gap = 10, foot = 10, head = 5;
    const bool stacked = width < 120;
    const double panel = stacked ? width - left - 3 : (width - 2 * left - gap + 7) / 2;
    const double high = fmin(0.75 * panel,
                             stacked ? (job->height_mm - head - 2 * foot) / 2 : job->height_mm - head - foot);
    find_series(c);
    if (json_array_size(c->cases) == 0)
        return iso_fail(err, ISO_E_RANGE, "%s: the chart has no measured setting", job->input);
    if (high < 20)
        return iso_fail(err, ISO_E_RANGE, "figure: a chart does not fit into %g x %g mm; increase --width or --height",
                        width, job->height_mm);
    iso_page_set_size(page, width, head + (stacked ? 2 : 1) * (high + foot));
    put_legend(page, c, left, 0.5 * head);
    put_panel(page, c, &(iso_page_box){left, head, panel, high}, true, true);
    put_panel(page, c,
              &(iso_page_box){stacked ? left : left + panel + gap, head + (stacked ? high + foot : 0), panel, high},
              false, stacked);
    write_caption(c, iso_page_caption(page));
    return ISO_OK;
}

static iso_status draw_chart(const iso_figure_job *job, iso_page *page, iso_error *err)
{
    json_auto_t *root = NULL;
    FREED char *path = iso_path_join(job->input, "chart.json");
    NEED(path ? iso_json_load(path, &root, err) : iso_fail(err, ISO_E_MEMORY, "figure: out of memory"));
    charted c = {.options = json_object_get(root, "options"), .cases = json_object_get(root, "cases")};
    c.metric = string_of(c.options, "metric");
    c.bytes_key = !strcmp(string_of(c.options, "bytes"), "stored") ? "stored_bytes" : "device_bytes";
    if (!json_is_array(c.cases) || strncmp(string_of(root, "schema"), "isoshade.chart/", 15) != 0)
        return iso_fail(err, ISO_E_FORMAT, "%s: not a chart of settings; its schema is \"%s\"", path,
                        string_of(root, "schema"));
    return draw_loaded(job, &c, page, err);
}

const iso_figure_info iso_figure_chart = {
    .name = "chart",
    .summary = "result of `isoshade chart`: error against time and bytes, with the fronts",
    .takes = ISO_FIGURE_OF_CHART,
    .draw = draw_chart,
};
