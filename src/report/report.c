/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "report/report.h"

#include <math.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "base/file.h"
#include "base/json.h"
#include "base/machine.h"
#include "base/parallel.h"
#include "base/provenance.h"
#include "compare/statistics.h"
#include "report/levels.h"
#include "report/report_files.h"
#include "report/sections.h"

struct iso_report {
    iso_output out;
    pthread_mutex_t lock; /* of the following fields */
    json_t *root;         /* report.json */
    json_t *inlined;      /* only for the page: pictures as text, differences and names of agreement's rows */
    size_t *orders;       /* of agreement's rows */
    double start_seconds;
    int standing; /* lock of the finished folder; negative: none */
    bool finished;
};

/* Makes a string; reasons may quote another program's output. */
static json_t *text(const char *value)
{
    FREED char *copy = value ? strdup(value) : NULL;
    return copy ? json_string(iso_provenance_shorten(copy)) : json_null();
}

static iso_status no_memory(iso_error *err)
{
    return iso_fail(err, ISO_E_MEMORY, "report: out of memory");
}

iso_status iso_report_create(iso_report **report, const char *dir, const iso_report_about *about, iso_error *err)
{
    *report = NULL;
    iso_report *r = calloc(1, sizeof *r);
    if (!r)
        return no_memory(err);
    pthread_mutex_init(&r->lock, NULL);
    r->standing = -1;
    iso_status status = iso_output_begin_dir(&r->out, dir, "report.json", err);
    TRY(status, iso_report_files_begin(r->out.temp_path, err));
    if (status != ISO_OK) {
        iso_report_destroy(r);
        return status;
    }
    char stamp[32];
    time_t now = time(NULL);
    struct tm utc;
    strftime(stamp, sizeof stamp, "%Y-%m-%dT%H:%M:%SZ", gmtime_r(&now, &utc));
    r->start_seconds = iso_clock_seconds();
    r->inlined = json_pack("{s:{}, s:[], s:[], s:{}, s:{}}", "images", "differences", "words", "charts", "mistakes");
    r->root =
        json_pack("{s:s, s:o, s:{}, s:o, s:o, s:o, s:s, s:s, s:s, s:s, s:[], s:[], s:[], s:[], s:{}, s:{}, s:{}, s:{}}",
                  "schema", ISO_REPORT_SCHEMA, "command", text(about->command), "options", "title", text(about->title),
                  "volume", text(iso_provenance_name(about->volume)), "scene", text(iso_provenance_name(about->scene)),
                  "made", stamp, "verdict", "", "sentence", "", "levels_sentence", "", "agreement", "levels",
                  "consistency", "calibration", "images", "machine", "versions", "seconds");
    if (!r->root || !r->inlined) {
        iso_report_destroy(r);
        return no_memory(err);
    }
    *report = r;
    return ISO_OK;
}

bool iso_report_is_finished(const iso_report *r)
{
    return r && r->finished;
}

void iso_report_destroy(iso_report *r)
{
    if (!r)
        return;
    iso_output_abandon(&r->out);
    if (r->standing >= 0)
        close(r->standing);
    json_decref(r->root);
    json_decref(r->inlined);
    pthread_mutex_destroy(&r->lock);
    free(r->orders);
    free(r);
}

const char *iso_report_path(const iso_report *r)
{
    return r->out.final_path;
}

const char *iso_report_dir(const iso_report *r)
{
    return r->out.temp_path;
}

const json_t *iso_report_json(const iso_report *r)
{
    return r->root;
}

void iso_report_put(iso_report *r, const char *section, const char *key, json_t *value)
{
    pthread_mutex_lock(&r->lock);
    json_t *object = json_object_get(r->root, section);
    if (!object) {
        object = json_object();
        json_object_set_new(r->root, section, object);
    }
    json_object_set_new(object, key, value);
    pthread_mutex_unlock(&r->lock);
}

void iso_report_describe_machine(iso_report *r)
{
    json_object_set_new(r->root, "machine", iso_machine_describe());
}

iso_status iso_report_add_image(iso_report *r, const char *name, const iso_image *image, const char *caption,
                                iso_error *err)
{
    const char *good = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789-_.";
    if (!name[0] || name[0] == '.' || strspn(name, good) != strlen(name))
        return iso_fail(err, ISO_E_RANGE, "report: invalid image name \"%s\"; use letters, digits, - _ .", name);
    json_t *images = json_object_get(r->root, "images"), *about;
    about = json_pack("{s:o, s:I, s:I}", "caption", text(caption), "width", (json_int_t)image->width, "height",
                      (json_int_t)image->height);
    pthread_mutex_lock(&r->lock);
    const bool taken = json_object_get(images, name);
    if (!taken) /* reserves the name while its files are written */
        json_object_set(images, name, about);
    pthread_mutex_unlock(&r->lock);
    json_decref(about);
    if (taken)
        return iso_fail(err, ISO_E_RANGE, "report: the image name \"%s\" is taken", name);
    char *uri = NULL;
    iso_status status = iso_report_files_image(r->out.temp_path, name, image, &uri, err);
    pthread_mutex_lock(&r->lock);
    if (status == ISO_OK)
        json_object_set_new(json_object_get(r->inlined, "images"), name, json_string(uri));
    else
        json_object_del(images, name);
    pthread_mutex_unlock(&r->lock);
    free(uri);
    return status;
}

void iso_report_set_scale(iso_report *r, const char *name, double mm_per_pixel)
{
    pthread_mutex_lock(&r->lock);
    json_t *image = json_object_get(json_object_get(r->root, "images"), name);
    if (image && mm_per_pixel > 0 && isfinite(mm_per_pixel))
        json_object_set_new(image, "mm_per_pixel", json_real(mm_per_pixel));
    pthread_mutex_unlock(&r->lock);
}

static const struct {
    const char *key, *name;
} gates[ISO_GATE_COUNT] = {
#define ISO_GATE_ROW(name, key, text) [name] = {key, text},
    ISO_GATE_LIST(ISO_GATE_ROW)
#undef ISO_GATE_ROW
};

const char *iso_gate_name(iso_gate gate)
{
    return gates[gate].name;
}

/* ---- verdict and severity of a row ---- */

/* Returns the largest ratio of a metric to its limit; infinite if nothing can be measured. */
double iso_report_severity(const iso_report_agreement *row)
{
    const iso_metrics *m = &row->metrics;
    if (row->refused || m->nonfinite_count > 0 || !isfinite(m->max_abs))
        return INFINITY;
    const double pairs[][2] = {
        {m->rmse, row->tolerances.rmse},           {m->max_abs, row->tolerances.max_abs},
        {m->p99_abs, row->tolerances.p99_abs},     {1 - m->ssim, row->tolerances.ssim_dissimilarity},
        {m->flip_mean, row->tolerances.flip_mean},
    };
    double worst = 0;
    bool asked = false;
    for (size_t i = 0; i < sizeof pairs / sizeof pairs[0]; ++i)
        if (pairs[i][1] > 0) {
            asked = true;
            worst = iso_larger(worst, pairs[i][0] / pairs[i][1]);
        }
    if (!asked && row->gate_count == 0)
        return m->max_abs > 0 ? INFINITY : 0;
    for (size_t i = 0; i < row->gate_count; ++i) {
        const iso_report_gate *g = &row->gates[i];
        double ratio = g->limit > 0 ? g->value / g->limit : g->value <= 0 ? 0 : INFINITY;
        if (isnan(ratio))
            return INFINITY;
        worst = fmax(worst, ratio);
    }
    return isnan(worst) ? INFINITY : worst;
}

static bool gates_hold(const iso_report_agreement *row)
{
    for (size_t i = 0; i < row->gate_count; ++i)
        if (!(row->gates[i].value <= row->gates[i].limit))
            return false;
    return true;
}

static bool has_tolerances(const iso_tolerances *l)
{
    return l->rmse > 0 || l->max_abs > 0 || l->p99_abs > 0 || l->ssim_dissimilarity > 0 || l->flip_mean > 0;
}

iso_verdict iso_report_verdict(const iso_report_agreement *row)
{
    if (row->refused)
        return ISO_VERDICT_REFUSED;
    const bool metrics = row->gate_count > 0 && !has_tolerances(&row->tolerances)
                             ? row->metrics.nonfinite_count == 0
                             : iso_metrics_within(&row->metrics, &row->tolerances);
    if (!metrics || !gates_hold(row)) /* also if the reference shows nothing: b draws something then */
        return ISO_VERDICT_DIFFER;
    return row->uncompared == ISO_UNCOMPARED_NOT ? ISO_VERDICT_AGREE : ISO_VERDICT_NOT_COMPARED;
}

/* ---- rows ---- */

static json_t *gates_json(const iso_report_agreement *row)
{
    json_t *list = json_array();
    for (size_t i = 0; !row->refused && i < row->gate_count; ++i)
        json_array_append_new(list, json_pack("{s:s, s:s, s:o, s:f}", "gate", gates[row->gates[i].gate].key, "name",
                                              iso_gate_name(row->gates[i].gate), "value",
                                              iso_json_number(row->gates[i].value), "limit", row->gates[i].limit));
    return list;
}

/* Lists the limits of the metrics. Without any limit or gate only equal images agree. */
static json_t *limits_json(const iso_report_agreement *row)
{
    json_t *object = iso_tolerances_to_json(&row->tolerances);
    if (json_object_size(object) == 0 && row->gate_count == 0 && row->image_b && !row->refused)
        json_object_set_new(object, "max_abs", json_real(0));
    return object;
}

static json_t *signal_json(const iso_signal *s)
{
    return json_pack("{s:o, s:o, s:f, s:s}", "color", iso_json_number(s->color), "alpha", iso_json_number(s->alpha),
                     "least", s->least, "measure", s->measure == ISO_SIGNAL_P99 ? "p99" : "rms");
}

static iso_status check_image_name(iso_report *r, const char *name, iso_error *err)
{
    pthread_mutex_lock(&r->lock);
    const bool known = !name || json_object_get(json_object_get(r->root, "images"), name);
    pthread_mutex_unlock(&r->lock);
    if (!known)
        return iso_fail(err, ISO_E_RANGE, "report: no image \"%s\" was added", name);
    return ISO_OK;
}

/* Inserts a row after all others of the same order. Takes the references to row and difference. */
static iso_status insert_row(iso_report *r, size_t order, json_t *row, json_t *difference, iso_error *err)
{
    pthread_mutex_lock(&r->lock);
    json_t *rows = json_object_get(r->root, "agreement"), *differences = json_object_get(r->inlined, "differences");
    const size_t count = json_array_size(rows);
    size_t *orders = realloc(r->orders, (count + 1) * sizeof *orders), at = count;
    if (orders) {
        r->orders = orders;
        for (; at > 0 && orders[at - 1] > order; --at)
            orders[at] = orders[at - 1];
        orders[at] = order;
    }
    bool good = orders && json_array_insert(rows, at, row) == 0 && json_array_insert(differences, at, difference) == 0;
    pthread_mutex_unlock(&r->lock);
    json_decref(row);
    json_decref(difference);
    return good ? ISO_OK : no_memory(err);
}

/* Returns the reason for which it was not compared, or for its limits. */
static const char *reason_of(const iso_report_agreement *row, iso_verdict verdict)
{
    if (row->refused)
        return row->refused;
    return verdict == ISO_VERDICT_NOT_COMPARED ? row->uncompared_why : row->why;
}

iso_status iso_report_add_agreement(iso_report *r, const iso_report_agreement *row, iso_error *err)
{
    static const iso_metrics none = {
        .rmse = NAN, .max_abs = NAN, .p99_abs = NAN, .psnr_db = NAN, .ssim = NAN, .flip_mean = NAN};
    FREED char *difference = NULL;
    NEED(check_image_name(r, row->image_a, err));
    NEED(check_image_name(r, row->image_b, err));
    if (row->image_a && row->image_b)
        NEED(iso_report_files_difference(r->out.temp_path, row->image_a, row->image_b, &difference, err));
    const iso_verdict verdict = iso_report_verdict(row);
    char name[ISO_ROW_NAME_BYTES];
    const char *renderer = row->renderer ? row->renderer : "", *variant = row->variant ? row->variant : "";
    iso_row_name(renderer, row->comparison, variant, name);
    json_t *o = json_pack("{s:I, s:o, s:o, s:s, s:s, s:s, s:s, s:o}", "level", (json_int_t)row->level, "scene",
                          text(row->scene), "a", text(row->a), "b", name, "renderer", renderer, "comparison",
                          iso_comparison_word(row->comparison), "variant", variant, "tier", text(row->tier));
    const bool is_measured = row->image_b || !(row->refused || row->uncompared);
    json_object_update_new(o, iso_metrics_to_json(is_measured ? &row->metrics : &none));
    json_object_set_new(o, "error_bar", iso_json_number(row->error_bar));
    json_object_set_new(o, "verdict", json_string(iso_verdict_word(verdict)));
    json_object_set_new(o, "severity", iso_json_number(iso_report_severity(row)));
    if (verdict == ISO_VERDICT_NOT_COMPARED)
        json_object_set_new(o, "not_compared", json_string(iso_uncompared_word(row->uncompared)));
    json_object_set_new(o, "limits", limits_json(row));
    if (row->signal.least > 0)
        json_object_set_new(o, "signal", signal_json(&row->signal));
    json_object_set_new(o, "gates", gates_json(row));
    if (row->statistics)
        json_object_set(o, "statistics", row->statistics);
    json_object_update_new(o, json_pack("{s:o, s:o, s:o, s:o, s:o}", "seconds",
                                        row->seconds > 0 ? json_real(row->seconds) : json_null(), "why",
                                        text(reason_of(row, verdict)), "command", text(row->command), "image_a",
                                        text(row->image_a), "image_b", text(row->image_b)));
    return insert_row(r, row->order, o, text(difference), err);
}

iso_status iso_report_add_consistency(iso_report *r, const iso_report_consistency *row, iso_error *err)
{
    NEED(check_image_name(r, row->image, err));
    NEED(check_image_name(r, row->reference_image, err));
    json_t *o = json_pack("{s:I, s:o, s:s, s:o, s:I, s:o, s:o, s:o, s:o, s:o, s:o, s:o}", "level",
                          (json_int_t)row->level, "method", text(row->method), "tf",
                          row->scaled    ? "scaled"
                          : row->adapted ? "adapted"
                                         : "original",
                          "original_kept", text(row->original_kept), "views", (json_int_t)row->views,
                          "ssim_dissimilarity_mean", iso_json_number(row->ssim_dissimilarity_mean), "flip_mean",
                          iso_json_number(row->flip_mean), "rmse_mean", iso_json_number(row->rmse_mean),
                          "gradient_angle_mean_deg", iso_json_number(row->gradient_angle_mean_deg),
                          "gradient_angle_p95_deg", iso_json_number(row->gradient_angle_p95_deg), "image",
                          text(row->image), "reference_image", text(row->reference_image));
    if (row->by_view.ssim_dissimilarity)
        json_object_set_new(o, "by_view",
                            json_pack("{s:o, s:o, s:o}", "ssim_dissimilarity",
                                      iso_json_numbers(row->by_view.ssim_dissimilarity, row->views), "flip",
                                      iso_json_numbers(row->by_view.flip, row->views), "rmse",
                                      iso_json_numbers(row->by_view.rmse, row->views)));
    return json_array_append_new(json_object_get(r->root, "consistency"), o) == 0 ? ISO_OK : no_memory(err);
}

void iso_report_consistency_name(const json_t *row, char name[ISO_CONSISTENCY_NAME_BYTES])
{
    const char *tf = iso_row_text(row, "tf");
    snprintf(name, ISO_CONSISTENCY_NAME_BYTES, "%.100s%s", iso_row_text(row, "method"),
             strcmp(tf, "adapted") == 0  ? "+adapted"
             : strcmp(tf, "scaled") == 0 ? "+scaled"
                                         : "");
}

iso_status iso_report_add_calibration(iso_report *r, const iso_report_calibration *row, iso_error *err)
{
    const iso_verdict verdict = row->not_asked                   ? ISO_VERDICT_NOT_COMPARED
                                : fabs(row->value) <= row->limit ? ISO_VERDICT_PASS
                                                                 : ISO_VERDICT_FAIL; /* NaN fails */
    json_t *o = json_pack("{s:o, s:o, s:o, s:o, s:o, s:s, s:o}", "renderer", text(row->renderer), "check",
                          text(row->check), "value", iso_json_number(row->value), "limit", iso_json_number(row->limit),
                          "unit", text(row->unit), "verdict", iso_verdict_word(verdict), "detail", text(row->detail));
    return json_array_append_new(json_object_get(r->root, "calibration"), o) == 0 ? ISO_OK : no_memory(err);
}

iso_status iso_report_add_mistake(iso_report *r, const iso_report_mistake *m, iso_error *err)
{
    static const char *const parts[3] = {"wanted", "got", "explained"};
    char names[3][128], caption[128];
    FREED char *difference = NULL;
    for (int i = 0; i < 3; ++i) {
        snprintf(names[i], sizeof names[i], "mistake-%.99s-%s", m->renderer, parts[i]);
        snprintf(caption, sizeof caption, "calibration: %.99s", m->check);
        NEED(iso_report_add_image(r, names[i], m->pictures[i], caption, err));
    }
    NEED(iso_report_files_difference(r->out.temp_path, names[0], names[1], &difference, err));
    iso_report_put(r, "mistakes", m->renderer, json_string(m->text));
    json_object_set_new(json_object_get(r->inlined, "mistakes"), m->renderer, json_string(difference));
    return ISO_OK;
}

static double sort_key(const json_t *row)
{
    static const int groups[] = {[ISO_VERDICT_DIFFER] = 4,
                                 [ISO_VERDICT_REFUSED] = 3,
                                 [ISO_VERDICT_NOT_COMPARED] = 2,
                                 [ISO_VERDICT_AGREE] = 1,
                                 [ISO_VERDICT_UNKNOWN] = 0};
    const json_t *value = json_object_get(row, "severity");
    double worst = json_is_number(value) ? fmin(json_number_value(value), 1e300) : 1e300;
    return groups[iso_row_verdict(row)] * 1000 + log10(fmax(worst, 1e-300));
}

static int worst_first(const void *a, const void *b)
{
    json_t *const *x = a, *const *y = b;
    double kx = sort_key(*x), ky = sort_key(*y);
    return (kx < ky) - (kx > ky);
}

/* Sorts and numbers the rows: the page keeps pictures of differences, and names of rows, under the number. */
static iso_status sort_rows(iso_report *r, iso_error *err)
{
    json_t *rows = json_object_get(r->root, "agreement"), *words = json_object_get(r->inlined, "words");
    size_t count = json_array_size(rows), i;
    FREED json_t **order = calloc(count + 1, sizeof *order);
    json_t *row, *sorted = json_array();
    if (!order)
        return no_memory(err);
    json_array_foreach (rows, i, row) {
        char name[ISO_ROW_NAME_BYTES];
        iso_row_words_of(row, name);
        json_array_append_new(words, json_string(name));
        order[i] = row;
        json_object_set_new(row, "number", json_integer((json_int_t)i));
    }
    qsort(order, count, sizeof *order, worst_first);
    for (i = 0; i < count; ++i)
        json_array_append(sorted, order[i]);
    json_object_set_new(r->root, "agreement", sorted);
    return ISO_OK;
}

iso_status iso_report_finish(iso_report *r, iso_error *err)
{
    if (r->finished)
        return iso_fail(err, ISO_E_RANGE, "report: already finished");
    NEED(sort_rows(r, err));
    iso_report_summary summary = iso_report_summarize(r);
    const iso_levels_summary levels = iso_levels_summarize(r->root);
    json_object_set_new(r->root, "verdict",
                        json_string(iso_verdict_word(summary.holds ? ISO_VERDICT_AGREE : ISO_VERDICT_DIFFER)));
    json_object_set_new(r->root, "sentence", json_string(summary.sentence));
    json_object_set_new(r->root, "levels_sentence", json_string(levels.sentence));
    if (!json_object_get(json_object_get(r->root, "seconds"), "total"))
        iso_report_put(r, "seconds", "total", json_real(iso_clock_seconds() - r->start_seconds));
    iso_error missing = {""};
    iso_status status = iso_report_files_charts(r->out.temp_path, r->root, json_object_get(r->inlined, "charts"),
                                                &missing);
    if (status == ISO_E_MISSING)
        json_object_set_new(r->root, "charts_missing", json_string(missing.text));
    else if (status != ISO_OK)
        return iso_fail(err, status, "%s", missing.text);
    status = iso_report_files_page(r->out.temp_path, r->root, r->inlined, err);
    TRY(status, iso_output_commit_locked(&r->out, &r->standing, err));
    r->finished = status == ISO_OK;
    return status;
}
