/* SPDX-License-Identifier: MIT */
/* of_report.c - a figure from a report's own pictures, enlarged by whole numbers.
 *
 *   levels      columns: levels; for each method, under each chosen TF, the
 *               image and, below, its difference from level 0, on one linear scale
 *   renderers   columns: comparisons at one level; both images and their
 *               difference, on one log scale
 * The scale bar applies to the plane through the center of the volume's box. It
 * is omitted if the report does not have the size of a pixel.
 *
 * job->methods: "naive,moments,moments+adapted" (iso_report_consistency_name()), in the report's order; NULL: the first
 * and the last under the original TF. job->variant: comparisons whose name contains it; NULL: those without method and
 * TF. job->look.scene: name of a scene in the report of a suite. */
#define _GNU_SOURCE

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/json.h"
#include "compare/metrics.h"
#include "figure/kinds.h"
#include "figure/sheet.h"
#include "base/progress_line.h"
#include "renderers/renderers.h"
#include "report/report.h"
#include "report/sections.h"

enum { max_panels = 256 };

typedef iso_figure_panel panel;

typedef struct figure {
    const iso_figure_job *job;
    bool of_levels;
    const char *report_dir;
    json_t *report;
    panel *panels;
    size_t count, rows, columns;
    size_t pictures, empty; /* pictures of the volume, and those of them that show almost nothing of it */
    const char *first_empty;
    bool in_logs;
    double low, high; /* of the difference maps; log10 if in_logs */
    FILE *caption;
} figure;

static void figure_destroy(figure *f)
{
    for (size_t i = 0; i < f->count; ++i) {
        iso_image_destroy(&f->panels[i].a);
        iso_image_destroy(&f->panels[i].b);
    }
    free(f->panels);
    json_decref(f->report);
}

static const char *string_of(const json_t *object, const char *key)
{
    const char *s = json_string_value(json_object_get(object, key));
    return s ? s : "";
}

static double number_of(const json_t *object, const char *key)
{
    const json_t *value = json_object_get(object, key);
    return json_is_number(value) ? json_number_value(value) : NAN;
}

/* Returns a file's name for captions, without its folder. */
static const char *file_name_of(const json_t *report, const char *key)
{
    return iso_path_base(string_of(report, key));
}

static iso_status load_image(const figure *f, const char *name, iso_image *image, iso_error *err)
{
    FREED char *path = NULL;
    if (asprintf(&path, "%s/images/%s.exr", f->report_dir, name) < 0)
        return iso_fail(err, ISO_E_MEMORY, "figure: out of memory");
    return iso_image_load_exr(path, image, err);
}

static iso_status add_panel(figure *f, panel p, iso_error *err)
{
    if (f->count == max_panels)
        return iso_fail(err, ISO_E_RANGE, "figure: more than %d panels", (int)max_panels);
    panel *kept = &f->panels[f->count++]; /* destroyed with the figure */
    p.mm_per_pixel = number_of(json_object_get(json_object_get(f->report, "images"), p.image), "mm_per_pixel");
    if (!(p.mm_per_pixel > 0))
        p.mm_per_pixel = 0;
    *kept = p;
    NEED(load_image(f, p.image, &kept->a, err));
    if (p.against) {
        NEED(load_image(f, p.against, &kept->b, err));
        NEED(iso_metrics_measure(&kept->a, &kept->b, &kept->metrics, err));
    } else {
        const double least = 1e-3; /* ISO_VISIBLE_LEAST of scene/visible.h, which reports do not store */
        ++f->pictures;
        if (iso_image_shown_share(&kept->a) < least && f->empty++ == 0)
            f->first_empty = p.image;
    }
    f->rows = p.row + 1 > f->rows ? p.row + 1 : f->rows;
    f->columns = p.column + 1 > f->columns ? p.column + 1 : f->columns;
    return ISO_OK;
}

/* ---- levels ----------------------------------------------------------------- */

static bool is_in_list(const char *list, const char *word)
{
    size_t n = strlen(word);
    for (const char *at = list; at; at = strchr(at, ',') ? strchr(at, ',') + 1 : NULL)
        if (strncmp(at, word, n) == 0 && (at[n] == 0 || at[n] == ','))
            return true;
    return false;
}

static bool is_adapted(const json_t *row)
{
    return strcmp(string_of(row, "tf"), "adapted") == 0;
}

/* Returns the report's methods that have pictures, each under each TF, in its order: an object with
 * iso_report_consistency_name() as keys; the value is true if the TF is adapted. */
static json_t *pictured_methods(const json_t *rows)
{
    json_t *methods = json_object(), *row;
    size_t i;
    json_array_foreach (rows, i, row) {
        char name[ISO_CONSISTENCY_NAME_BYTES];
        iso_report_consistency_name(row, name);
        if (string_of(row, "image")[0] && string_of(row, "reference_image")[0])
            json_object_set_new(methods, name, json_boolean(is_adapted(row)));
    }
    return methods;
}

static iso_status check_methods(json_t *methods, const char *list, iso_error *err)
{
    for (const char *at = list; at; at = strchr(at, ',') ? strchr(at, ',') + 1 : NULL) {
        char word[ISO_CONSISTENCY_NAME_BYTES], known[400] = "";
        const char *method;
        json_t *adapted;
        snprintf(word, sizeof word, "%.*s", (int)strcspn(at, ","), at);
        if (json_object_get(methods, word))
            continue;
        json_object_foreach (methods, method, adapted)
            snprintf(known + strlen(known), sizeof known - strlen(known), "%s%s", known[0] ? ", " : "", method);
        return iso_fail(err, ISO_E_RANGE, "--methods: the report has no pictures of \"%s\", but of %s", word, known);
    }
    return ISO_OK;
}

/* Returns the methods of a list; without one the first and the last under the original TF. */
static json_t *chosen_methods(json_t *methods, const char *list)
{
    json_t *chosen = json_object(), *adapted;
    const char *method, *first = NULL, *last = NULL;
    json_object_foreach (methods, method, adapted) {
        if (list && is_in_list(list, method))
            json_object_set(chosen, method, adapted);
        if (!json_is_true(adapted))
            first = first ? first : method, last = method;
    }
    if (!list && last) {
        json_object_set_new(chosen, first, json_false());
        json_object_set_new(chosen, last, json_false());
    }
    return chosen;
}

static iso_status add_level(figure *f, const json_t *row, size_t at, iso_error *err)
{
    size_t level = (size_t)json_integer_value(json_object_get(row, "level"));
    panel p = {.row = 2 * at, .column = level, .image = string_of(row, "image")};
    if (at == 0)
        snprintf(p.title, sizeof p.title, "level %zu", level);
    NEED(add_panel(f, p, err));
    p = (panel){.row = 2 * at + 1, .column = level, .image = p.image, .against = string_of(row, "reference_image")};
    NEED(add_panel(f, p, err));
    panel *added = &f->panels[f->count - 1];
    snprintf(added->note, sizeof added->note, "RMSE %.3g|1−SSIM %.3g|FLIP %.3g", added->metrics.rmse,
             1 - added->metrics.ssim, added->metrics.flip_mean);
    fprintf(f->caption, " %s%s, level %zu: 1 - SSIM %.3g, FLIP %.3g, direction error %.3g degrees",
            iso_figure_method_words(string_of(row, "method")),
            is_adapted(row) ? " with the adapted transfer function" : "", level,
            number_of(row, "ssim_dissimilarity_mean"), number_of(row, "flip_mean"),
            number_of(row, "gradient_angle_mean_deg"));
    fputs(string_of(row, "original_kept")[0] ? " (adapting refused, the original kept)." : ".", f->caption);
    return ISO_OK;
}

/* Adds the levels of one method under one TF. */
static iso_status add_levels(figure *f, const json_t *rows, const char *method, size_t at, iso_error *err)
{
    bool first = true;
    json_t *row;
    size_t i;
    json_array_foreach (rows, i, row) {
        char name[ISO_CONSISTENCY_NAME_BYTES];
        iso_report_consistency_name(row, name);
        if (strcmp(name, method) != 0 || !string_of(row, "image")[0])
            continue;
        if (first && at == 0) { /* level 0 once: all methods have the same volume */
            panel p = {.image = string_of(row, "reference_image"), .title = "level 0", .scale_bar = true};
            NEED(add_panel(f, p, err));
        }
        const size_t leftmost = at == 0 ? 0 : f->count;
        NEED(add_level(f, row, at, err));
        if (first)
            snprintf(f->panels[leftmost].side, sizeof f->panels->side, "%.60s%s",
                     iso_figure_method_words(string_of(row, "method")), is_adapted(row) ? " (adapted TF)" : "");
        first = false;
    }
    return ISO_OK;
}

static iso_status plan_levels(figure *f, iso_error *err)
{
    const json_t *rows = json_object_get(f->report, "consistency");
    json_t *adapted;
    json_auto_t *methods = pictured_methods(rows), *chosen = chosen_methods(methods, f->job->methods);
    const char *method;
    size_t shown = 0;
    if (json_object_size(f->job->methods ? methods : chosen) == 0)
        return iso_fail(err, ISO_E_RANGE, "%s: the report has no pictures of levels", f->report_dir);
    NEED(check_methods(methods, f->job->methods, err));
    fprintf(f->caption,
            "Levels of %s (%s), one view: pictures, and below them their largest difference from level 0 over the "
            "channels, on a linear scale. Figures below a map are of this view; means over all views:",
            file_name_of(f->report, "volume"), file_name_of(f->report, "scene"));
    json_object_foreach (chosen, method, adapted) {
        NEED(add_levels(f, rows, method, shown++, err));
    }
    return ISO_OK;
}

/* ---- renderers -------------------------------------------------------------- */

/* Describes a comparison: renderer, pictures, and difference from the scene's own settings. Unknown renderers keep
 * their names. */
static void name_comparison(const json_t *row, char title[96])
{
    const iso_row_identity id = iso_row_identify(row);
    const iso_renderer_info *info = NULL;
    const bool known = iso_renderer_from_name(id.renderer, &info, NULL) == ISO_OK;
    const char *how = iso_row_comparison_words(row), *rest = strchr(id.variant, ',');
    char method[sizeof id.variant];
    snprintf(method, sizeof method, "%.*s", (int)strcspn(id.variant, ","), id.variant);
    const int length = snprintf(title, 96, "%s%s%s%s%s%s", known ? info->title : id.renderer, how[0] ? ", " : "", how,
                                method[0] ? ", " : "", iso_figure_method_words(method), rest ? rest : "");
    if (length >= 96)
        memcpy(title + 92, "...", 4);
}

static iso_status add_comparison(figure *f, const json_t *row, size_t column, iso_error *err)
{
    const char *a = string_of(row, "image_a"), *b = string_of(row, "image_b"), *against = string_of(row, "a");
    panel top = {.row = 0, .column = column, .image = a, .scale_bar = column == 0};
    panel middle = {.row = 1, .column = column, .image = b},
          bottom = {.row = 2, .column = column, .image = b, .against = a};
    name_comparison(row, top.title);
    if (column == 0) {
        snprintf(top.side, sizeof top.side, "reference");
        snprintf(middle.side, sizeof middle.side, "renderer");
        snprintf(bottom.side, sizeof bottom.side, "difference");
    }
    NEED(add_panel(f, top, err));
    NEED(add_panel(f, middle, err));
    NEED(add_panel(f, bottom, err));
    panel *added = &f->panels[f->count - 1];
    snprintf(added->note, sizeof added->note, "RMSE %.2g|max %.2g", added->metrics.rmse, added->metrics.max_abs);
    fprintf(f->caption, " %s, against %.*s: RMSE %.3g, largest difference %.3g, FLIP %.3g (%s).", top.title,
            (int)strcspn(against, ","), against, added->metrics.rmse, added->metrics.max_abs, added->metrics.flip_mean,
            string_of(row, "verdict"));
    return ISO_OK;
}

/* True for renderers under the scene's own TF, or if the variant contains the given words. */
static bool is_shown(const json_t *row, const iso_figure_job *job)
{
    const iso_row_identity id = iso_row_identify(row);
    if ((size_t)json_integer_value(json_object_get(row, "level")) != (size_t)job->level ||
        iso_row_verdict(row) == ISO_VERDICT_REFUSED)
        return false;
    if (!string_of(row, "image_a")[0] || !string_of(row, "image_b")[0] ||
        (job->look.scene && strcmp(string_of(row, "scene"), job->look.scene) != 0))
        return false;
    if (job->variant)
        return strstr(id.variant, job->variant) || strstr(iso_comparison_word(id.comparison), job->variant);
    return !id.variant[0] && id.comparison != ISO_COMPARISON_EXACT;
}

/* Sorts comparisons by renderer. */
static int by_renderer(const void *a, const void *b)
{
    const json_t *x = *(json_t *const *)a, *y = *(json_t *const *)b;
    char of_x[ISO_ROW_NAME_BYTES], of_y[ISO_ROW_NAME_BYTES];
    iso_row_name_of(x, of_x);
    iso_row_name_of(y, of_y);
    int order = strcmp(of_x, of_y);
    return order ? order : strcmp(string_of(x, "tier"), string_of(y, "tier"));
}

/* Refuses several scenes in one figure. */
static iso_status check_one_scene(json_t *const *shown, size_t count, iso_error *err)
{
    json_t *scenes = json_object();
    const char *name;
    json_t *value;
    char names[400] = "";
    for (size_t i = 0; i < count; ++i)
        json_object_set_new(scenes, string_of(shown[i], "scene"), json_true());
    json_object_foreach (scenes, name, value)
        snprintf(names + strlen(names), sizeof names - strlen(names), "%s%s", names[0] ? ", " : "", name);
    size_t scene_count = json_object_size(scenes);
    json_decref(scenes);
    return scene_count <= 1
               ? ISO_OK
               : iso_fail(err, ISO_E_RANGE, "the report has %zu scenes, --scene chooses one: %s", scene_count, names);
}

static iso_status plan_renderers(figure *f, iso_error *err)
{
    const json_t *rows = json_object_get(f->report, "agreement");
    FREED json_t **shown = calloc(json_array_size(rows) + 1, sizeof *shown);
    json_t *row;
    size_t i, count = 0;
    NEED_MEMORY(shown, err, "figure: out of memory");
    json_array_foreach (rows, i, row)
        if (is_shown(row, f->job))
            shown[count++] = row;
    qsort(shown, count, sizeof *shown, by_renderer);
    const char *volume = file_name_of(f->report, "volume"); /* in the report of a suite, one per scene */
    fprintf(f->caption,
            "Renderers at level %zu of %s%s%s%s: the reference, each renderer, and the largest difference over the "
            "channels on a log scale.",
            (size_t)f->job->level, volume, *volume ? " (" : "the scene ",
            f->job->look.scene ? f->job->look.scene : file_name_of(f->report, "scene"), *volume ? ")" : "");
    if (count == 0)
        return iso_fail(err, ISO_E_RANGE, "%s: the report has no pictures of comparisons at level %zu%s%s",
                        f->report_dir, (size_t)f->job->level, f->job->variant ? " with a name like " : "",
                        f->job->variant ? f->job->variant : "");
    NEED(check_one_scene(shown, count, err));
    for (i = 0; i < count; ++i)
        NEED(add_comparison(f, shown[i], i, err));
    return ISO_OK;
}

/* ---- drawing ---------------------------------------------------------------- */

/* Chooses the scale: linear up to the largest p99 of the maps, or logs over the decades that the pictures use. */
static void choose_scale(figure *f)
{
    f->in_logs = !f->of_levels;
    f->low = f->in_logs ? -8 : 0;
    f->high = 0;
    for (size_t i = 0; i < f->count && !f->in_logs; ++i)
        if (f->panels[i].against)
            f->high = fmax(f->high, f->panels[i].metrics.p99_abs);
    if (!f->in_logs)
        f->high = iso_figure_round_up(f->high);
}

static void notice(const figure *f)
{
    if (f->empty == 0)
        return;
    if (f->job->cli)
        iso_progress_line_hide(f->job->cli->progress);
    fprintf(stderr,
            "isoshade figure: warning: %zu of %zu pictures show the volume on less than .1 %% of their "
            "pixels, the first is %s/images/%s.exr; validate again with a scene that fits the volume\n",
            f->empty, f->pictures, f->report_dir, f->first_empty);
}

/* Describes the size of the report's pictures in print. */
static void describe_density(const figure *f, const iso_figure_sheet *sheet, const iso_page *page)
{
    const iso_image *first = &f->panels[0].a;
    double width_mm = 0;
    if (iso_figure_panel_width(sheet, &width_mm, NULL) != ISO_OK)
        return;
    const double dpi = (double)first->width / (width_mm / 25.4);
    const size_t times = iso_page_times(page, width_mm, first->width);
    fprintf(f->caption, " Pictures have %zu x %zu pixels, %.0f per inch", first->width, first->height, dpi);
    if (times > 1)
        fprintf(f->caption, ", each drawn as %zu x %zu dots", times, times);
    fputc('.', f->caption);
    json_object_set_new(f->job->facts, "pixels_per_inch", json_real(dpi));
    if (times > 1 && f->job->cli && !f->job->cli->quiet) {
        iso_progress_line_hide(f->job->cli->progress);
        fprintf(stderr,
                "isoshade figure: note: the report's pictures have %.0f pixels per inch here, not %g; a figure of the "
                "volume renders new ones at this size\n",
                dpi, f->job->dpi);
    }
}

static iso_status draw_sheet(figure *f, iso_page *page, iso_error *err)
{
    choose_scale(f);
    const iso_figure_sheet sheet = {.panels = f->panels,
                                    .count = f->count,
                                    .rows = f->rows,
                                    .columns = f->columns,
                                    .rows_per_side = f->of_levels ? 2 : 1,
                                    .in_logs = f->in_logs,
                                    .low = f->low,
                                    .high = f->high,
                                    .width_mm = f->job->width_mm,
                                    .height_mm = f->job->height_mm,
                                    .map = f->job->map};
    NEED(iso_figure_draw(&sheet, page, err));
    iso_figure_describe(&sheet, f->caption);
    describe_density(f, &sheet, page);
    return ISO_OK;
}

iso_status iso_figure_draw_report(const iso_figure_job *job, bool of_levels, iso_page *page, iso_error *err)
{
    OWNED(figure)
    f = {.job = job,
         .of_levels = of_levels,
         .report_dir = job->input,
         .caption = iso_page_caption(page),
         .panels = calloc(max_panels, sizeof *f.panels)};
    NEED(f.panels ? iso_report_load(job->input, &f.report, err) : iso_fail(err, ISO_E_MEMORY, "figure: out of memory"));
    NEED(of_levels ? plan_levels(&f, err) : plan_renderers(&f, err));
    NEED(draw_sheet(&f, page, err));
    notice(&f);
    return ISO_OK;
}

bool iso_figure_is_of_report(const iso_figure_job *job)
{
    FREED char *path = job->input ? iso_path_join(job->input, "report.json") : NULL;
    const bool is = path && iso_path_exists(path);
    return is;
}
