/* SPDX-License-Identifier: MIT */
/* certificate.c - groups the rows of reports into certificates, and sums these up by renderer. */
#define _GNU_SOURCE
#include "report/certificate.h"

#include <stdlib.h>
#include <string.h>

#include "base/provenance.h"
#include "base/words.h"

/* ---- groups of rows ---- */

/* The groups by key: each {"rows": [...], "report": its number, "superseded": [...]}. */
typedef struct grouping {
    const iso_report_source *reports;
    json_t *groups, *renderers, *scenes; /* the latter two: keys in the order of the page */
} grouping;

static char *key_of(const char *renderer, const char *scene)
{
    char *key = NULL;
    return asprintf(&key, "%s\n%s", renderer, scene) < 0 ? NULL : key;
}

/* Joins the names of volume and scene: two reports may have scenes of one name. */
static char *scene_key(const json_t *report, const json_t *row)
{
    return key_of(iso_row_text(report, "volume"), iso_row_text(row, "scene"));
}

static iso_status check_row(const char *path, size_t number, const json_t *row, iso_error *err)
{
    static const char *const texts[] = {"renderer", "scene", "comparison", "verdict"};
    static const char good[] = "abcdefghijklmnopqrstuvwxyz0123456789-_.";
    for (size_t i = 0; i < sizeof texts / sizeof *texts; ++i)
        if (!json_is_string(json_object_get(row, texts[i])))
            return iso_fail(err, ISO_E_FORMAT, "%s: agreement, row %zu: %s is no text; the report is damaged", path,
                            number + 1, texts[i]);
    const json_t *level = json_object_get(row, "level");
    if (!json_is_integer(level) || json_integer_value(level) < 0 || !json_is_object(json_object_get(row, "limits")))
        return iso_fail(err, ISO_E_FORMAT, "%s: agreement, row %zu: level is no number, or limits no object; %s", path,
                        number + 1, "the report is damaged");
    const char *name = iso_row_text(row, "renderer"); /* it becomes a file's name */
    if (name[0] == '.' || strspn(name, good) != strlen(name) || strlen(name) > 64)
        return iso_fail(err, ISO_E_FORMAT, "%s: agreement, row %zu: invalid renderer \"%.64s\"; use a-z, digits, - _ .",
                        path, number + 1, name);
    return ISO_OK;
}

/* Adds the keys of `names` to an object, sorted. */
static void add_sorted(json_t *to, const json_t *names)
{
    for (const char *last = "", *next, *name; last; last = next) {
        json_t *used;
        next = NULL;
        json_object_foreach ((json_t *)names, name, used) {
            if (strcmp(name, last) > 0 && (!next || strcmp(name, next) < 0))
                next = name;
        }
        if (next)
            json_object_set_new(to, next, json_true());
    }
}

/* Puts the rows of one report into groups of its own. Stages that did not run are of no renderer. */
static iso_status group_report(const grouping *g, size_t number, json_t *own, iso_error *err)
{
    const iso_report_source *of = &g->reports[number];
    json_t *row;
    json_auto_t *scenes = json_object();
    const char *name;
    size_t i;
    json_object_foreach (json_object_get(of->root, "renderers"), name, row)
        json_object_set_new(g->renderers, name, json_true());
    json_array_foreach (json_object_get(of->root, "agreement"), i, row) {
        const char *renderer = iso_row_text(row, "renderer");
        NEED(check_row(of->path, i, row, err));
        if (!renderer[0])
            continue;
        FREED char *scene = scene_key(of->root, row), *key = scene ? key_of(renderer, scene) : NULL;
        json_t *group = key ? json_object_get(own, key) : NULL;
        if (key && !group) {
            group = json_pack("{s:[], s:I, s:[]}", "rows", "report", (json_int_t)number, "superseded");
            json_object_set_new(own, key, group);
            json_object_set_new(g->renderers, renderer, json_true());
            json_object_set_new(scenes, scene, json_true());
        }
        json_array_append(json_object_get(group, "rows"), row);
    }
    add_sorted(g->scenes, scenes);
    return ISO_OK;
}

static const iso_report_source *source_of(const iso_report_source *reports, const json_t *group)
{
    return &reports[json_integer_value(json_object_get(group, "report"))];
}

static json_t *describe_report(const iso_report_source *of)
{
    return json_pack("{s:s, s:s}", "report", iso_provenance_name(of->path), "made", iso_row_text(of->root, "made"));
}

/* Moves a later report's group into all groups; the newer one of a key stays. Times are ISO 8601, so that texts
 * compare. */
static void merge_group(const grouping *g, const char *key, json_t *group)
{
    json_t *other = json_object_get(g->groups, key);
    const iso_report_source *a = other ? source_of(g->reports, other) : NULL, *b = source_of(g->reports, group);
    if (other && strcmp(iso_row_text(a->root, "made"), iso_row_text(b->root, "made")) > 0) {
        json_array_append_new(json_object_get(other, "superseded"), describe_report(b));
        return;
    }
    if (other) {
        json_array_extend(json_object_get(group, "superseded"), json_object_get(other, "superseded"));
        json_array_append_new(json_object_get(group, "superseded"), describe_report(a));
    }
    json_object_set(g->groups, key, group);
}

/* ---- verdicts and levels ---- */

static size_t count_rows(const json_t *rows, iso_verdict verdict)
{
    size_t i, count = 0;
    json_t *row;
    json_array_foreach (rows, i, row)
        count += iso_row_verdict(row) == verdict;
    return count;
}

static iso_verdict verdict_of(const json_t *rows)
{
    static const iso_verdict order[] = {ISO_VERDICT_DIFFER, ISO_VERDICT_REFUSED, ISO_VERDICT_AGREE};
    for (size_t i = 0; i < sizeof order / sizeof *order; ++i)
        if (count_rows(rows, order[i]) > 0)
            return order[i];
    return ISO_VERDICT_NOT_COMPARED;
}

static json_t *rows_of_level(const json_t *rows, json_int_t level)
{
    json_t *list = json_array(), *row;
    size_t i;
    json_array_foreach (rows, i, row)
        if (json_integer_value(json_object_get(row, "level")) == level)
            json_array_append(list, row);
    return list;
}

/* Lists each level with its verdict, ascending. */
static json_t *levels_of(const json_t *rows)
{
    json_t *list = json_array(), *row;
    json_int_t last = -1, next;
    for (;; last = next) {
        size_t i;
        next = -1;
        json_array_foreach (rows, i, row) {
            const json_int_t level = json_integer_value(json_object_get(row, "level"));
            if (level > last && (next < 0 || level < next))
                next = level;
        }
        if (next < 0)
            return list;
        json_auto_t *at = rows_of_level(rows, next);
        json_array_append_new(list,
                              json_pack("{s:I, s:s}", "level", next, "verdict", iso_verdict_word(verdict_of(at))));
    }
}

static void certificate_levels(const json_t *levels, char text[ISO_LEVELS_TEXT_BYTES])
{
    size_t i;
    json_t *one;
    json_int_t first = -1, last = -1;
    text[0] = 0;
    for (i = 0; i <= json_array_size(levels); ++i) {
        one = json_array_get(levels, i);
        const json_int_t level = json_integer_value(json_object_get(one, "level"));
        const bool agrees = one && iso_row_verdict(one) == ISO_VERDICT_AGREE;
        if (agrees && first >= 0 && level == last + 1) {
            last = level;
            continue;
        }
        if (first >= 0)
            iso_words_append(text, ISO_LEVELS_TEXT_BYTES, last > first ? "%s%lld-%lld" : "%s%lld", text[0] ? ", " : "",
                             (long long)first, (long long)last);
        first = agrees ? level : -1;
        last = level;
    }
}

/* ---- one certificate ---- */

/* Returns the number of pixels of a row's picture; 0: it has none. */
static double pixels_of(const json_t *report, const json_t *row)
{
    const json_t *image = json_object_get(json_object_get(report, "images"), iso_row_text(row, "image_b"));
    return (double)json_integer_value(json_object_get(image, "width")) *
           (double)json_integer_value(json_object_get(image, "height"));
}

/* Returns the row to show, one of the verdict: the worst with a picture if it does not agree; otherwise the largest
 * picture of the finest level under the scene's own directions and transfer function. Rows come worst first. */
static json_t *row_to_show(const json_t *report, const json_t *rows, iso_verdict verdict)
{
    json_t *best = NULL, *row;
    double most = -1;
    size_t i;
    json_array_foreach (rows, i, row) {
        if (iso_row_verdict(row) != verdict)
            continue;
        double weight = pixels_of(report, row);
        if (verdict == ISO_VERDICT_AGREE && weight > 0)
            weight += (iso_row_text(row, "variant")[0] ? 0 : 1e12) -
                      1e15 * (double)json_integer_value(json_object_get(row, "level")) + 1e18;
        else if (weight > 0)
            weight = 1;
        if (weight > most) {
            most = weight;
            best = row;
        }
    }
    return best;
}

/* Lists the worst row of each kind of comparison, shortened, with the number of such rows. */
static json_t *comparisons_of(const json_t *rows)
{
    static const char *const kept[] = {"comparison", "level", "variant", "verdict", "rmse", "max_abs", "limits"};
    json_t *kinds = json_object(), *list = json_array(), *row, *kind;
    const char *name;
    size_t i, k;
    json_array_foreach (rows, i, row) {
        const char *key = iso_row_text(row, "comparison");
        kind = json_object_get(kinds, key);
        if (kind) {
            json_object_set_new(kind, "rows", json_integer(1 + json_integer_value(json_object_get(kind, "rows"))));
            continue;
        }
        kind = json_pack("{s:s, s:i}", "words", iso_row_comparison_words(row), "rows", 1);
        for (k = 0; k < sizeof kept / sizeof *kept; ++k)
            if (json_object_get(row, kept[k]))
                json_object_set(kind, kept[k], json_object_get(row, kept[k]));
        json_object_set_new(kinds, key, kind);
    }
    json_object_foreach (kinds, name, kind)
        json_array_append(list, kind);
    json_decref(kinds);
    return list;
}

/* Lists the failed checks of the renderer's calibration. */
static json_t *failed_checks(const json_t *report, const char *renderer)
{
    json_t *list = json_array(), *row;
    size_t i;
    json_array_foreach (json_object_get(report, "calibration"), i, row)
        if (strcmp(iso_row_text(row, "renderer"), renderer) == 0 && iso_row_verdict(row) == ISO_VERDICT_FAIL)
            json_array_append(list, row);
    return list;
}

/* True if the program is not there: it has no version then. */
static bool is_missing(const json_t *certificate)
{
    const json_t *checks = json_object_get(certificate, "failed");
    return json_array_size(checks) == 1 && strcmp(iso_row_text(json_array_get(checks, 0), "check"), "answers") == 0;
}

static json_t *sentence_of(const json_t *certificate, const json_t *rows, iso_verdict verdict)
{
    const size_t agree = count_rows(rows, ISO_VERDICT_AGREE), differ = count_rows(rows, ISO_VERDICT_DIFFER),
                 open = count_rows(rows, ISO_VERDICT_NOT_COMPARED);
    char text[640], levels[ISO_LEVELS_TEXT_BYTES];
    certificate_levels(json_object_get(certificate, "levels"), levels);
    if (verdict == ISO_VERDICT_AGREE)
        snprintf(text, sizeof text, "%zu comparison%s within %s limit%s, level %s.", agree, iso_words_plural(agree),
                 agree == 1 ? "its" : "their", iso_words_plural(agree), levels);
    else if (verdict == ISO_VERDICT_DIFFER)
        snprintf(text, sizeof text, "%zu of %zu comparison%s beyond the limits.", differ, differ + agree,
                 iso_words_plural(differ + agree));
    else
        snprintf(text, sizeof text, "%s: %.500s.", verdict == ISO_VERDICT_REFUSED ? "Refused" : "Not compared",
                 iso_row_text(certificate, "why"));
    if (open > 0 && verdict != ISO_VERDICT_NOT_COMPARED)
        iso_words_append(text, sizeof text, " %zu not compared.", open);
    return json_string(text);
}

/* Adds the pictures of the calibration that shows the renderer's known mistake best. */
static void add_mistake_pictures(json_t *certificate, const json_t *report, const char *renderer)
{
    static const char *const parts[] = {"wanted", "got"};
    for (int i = 0; i < 2; ++i) {
        char key[32], name[128];
        snprintf(key, sizeof key, "mistake_%s", parts[i]);
        snprintf(name, sizeof name, "mistake-%.99s-%s", renderer, parts[i]);
        if (json_object_get(json_object_get(report, "images"), name))
            json_object_set_new(certificate, key, json_string(name));
    }
}

/* Names the certificate's pictures by their report: "2/level-0-gl-lockstep". */
static void name_pictures(json_t *certificate, const json_t *group)
{
    static const char *const keys[] = {"image_a", "image_b", "mistake_wanted", "mistake_got"};
    for (int i = 0; i < 4; ++i) {
        const char *name = iso_row_text(certificate, keys[i]);
        if (name[0])
            json_object_set_new(certificate, keys[i],
                                json_sprintf("%lld/%s", json_integer_value(json_object_get(group, "report")), name));
    }
}

static json_t *make_certificate(const iso_report_source *of, const json_t *group, size_t number)
{
    const json_t *rows = json_object_get(group, "rows");
    const iso_verdict verdict = verdict_of(rows);
    json_t *c = json_deep_copy(row_to_show(of->root, rows, verdict));
    const char *renderer = iso_row_text(c, "renderer");
    const json_t *about = json_object_get(json_object_get(of->root, "renderers"), renderer);
    const char *title = iso_row_text(about, "title");
    json_object_update_new(c,
                           json_pack("{s:I, s:s, s:s, s:s, s:O?, s:O?, s:O?, s:s, s:s, s:s, s:O, s:O?, s:o, s:o, s:o}",
                                     "number", (json_int_t)number, "title", title[0] ? title : renderer, "version",
                                     iso_row_text(about, "version"), "isoshade",
                                     iso_row_text(json_object_get(of->root, "versions"), "isoshade"), "draws",
                                     json_object_get(about, "draws"), "lacks", json_object_get(about, "lacks"),
                                     "limits_why", json_object_get(about, "why"), "volume",
                                     iso_row_text(of->root, "volume"), "report", iso_provenance_name(of->path), "made",
                                     iso_row_text(of->root, "made"), "superseded", json_object_get(group, "superseded"),
                                     "mistake", json_object_get(json_object_get(of->root, "mistakes"), renderer),
                                     "failed", failed_checks(of->root, renderer), "levels", levels_of(rows),
                                     "comparisons", comparisons_of(rows)));
    json_object_set_new(c, "sentence", sentence_of(c, rows, verdict));
    json_object_set_new(c, "missing", json_boolean(is_missing(c)));
    add_mistake_pictures(c, of->root, renderer);
    name_pictures(c, group);
    return c;
}

/* ---- summaries ---- */

/* Adds to levels, which has an object per level, those of a certificate: a level agrees in all scenes or not. */
static void add_levels(json_t *levels, const json_t *more)
{
    json_t *one, *other;
    size_t i, k;
    json_array_foreach (more, i, one) {
        if (iso_row_verdict(one) == ISO_VERDICT_NOT_COMPARED)
            continue;
        const json_int_t level = json_integer_value(json_object_get(one, "level"));
        for (k = 0; k < json_array_size(levels); ++k) {
            other = json_array_get(levels, k);
            if (json_integer_value(json_object_get(other, "level")) >= level)
                break;
        }
        other = json_array_get(levels, k);
        if (!other || json_integer_value(json_object_get(other, "level")) != level)
            json_array_insert_new(levels, k, json_deep_copy(one));
        else if (iso_verdict_doubt(iso_row_verdict(one)) > iso_verdict_doubt(iso_row_verdict(other)))
            json_object_update(other, one);
    }
}

/* Words of the badge. */
static json_t *words_of(const json_t *rows, const json_t *levels, iso_verdict verdict)
{
    const size_t count = json_array_size(rows), differ = count_rows(rows, ISO_VERDICT_DIFFER);
    char text[ISO_LEVELS_TEXT_BYTES];
    certificate_levels(levels, text);
    if (verdict == ISO_VERDICT_AGREE)
        return json_sprintf("agrees, level %s", text);
    if (verdict == ISO_VERDICT_DIFFER)
        return json_sprintf("differs in %zu of %zu scene%s", differ, count, iso_words_plural(count));
    if (verdict == ISO_VERDICT_REFUSED)
        return json_string(json_is_true(json_object_get(json_array_get(rows, 0), "missing")) ? "not available"
                                                                                             : "refused");
    return json_string("not compared");
}

static json_t *sum_up_renderer(const char *renderer, json_t *certificates)
{
    json_t *levels = json_array(), *one;
    const json_t *newest = NULL;
    const iso_verdict verdict = verdict_of(certificates);
    size_t i;
    json_array_foreach (certificates, i, one) {
        add_levels(levels, json_object_get(one, "levels"));
        if (!newest || strcmp(iso_row_text(newest, "made"), iso_row_text(one, "made")) <= 0)
            newest = one;
    }
    return json_pack("{s:s, s:s, s:s, s:s, s:s, s:o, s:I, s:I, s:o, s:o}", "renderer", renderer, "title",
                     iso_row_text(newest, "title"), "version", iso_row_text(newest, "version"), "made",
                     iso_row_text(newest, "made"), "verdict", iso_verdict_word(verdict), "words",
                     words_of(certificates, levels, verdict), "scenes", (json_int_t)json_array_size(certificates),
                     "agreed", (json_int_t)count_rows(certificates, ISO_VERDICT_AGREE), "levels", levels, "badge",
                     json_sprintf("badges/%s.svg", renderer));
}

static json_t *site_sentence(const json_t *renderers)
{
    const size_t count = json_array_size(renderers), agree = count_rows(renderers, ISO_VERDICT_AGREE);
    char text[1024] = "";
    json_t *one;
    size_t i;
    iso_words_append(text, sizeof text, "%zu of %zu renderer%s agree%s with the reference in all scenes.", agree, count,
                     iso_words_plural(count), count == 1 || agree == 1 ? "s" : "");
    json_array_foreach (renderers, i, one)
        if (iso_row_verdict(one) != ISO_VERDICT_AGREE)
            iso_words_append(text, sizeof text, " %s: %s.", iso_row_text(one, "renderer"), iso_row_text(one, "words"));
    return json_string(text);
}

/* Makes the certificates scene by scene, and the sum of each renderer. */
static json_t *make_site(const grouping *g)
{
    json_t *certificates = json_array(), *renderers = json_array(), *used, *list;
    json_auto_t *by_renderer = json_object();
    const char *scene, *renderer;
    json_object_foreach (g->renderers, renderer, used)
        json_object_set_new(by_renderer, renderer, json_array());
    json_object_foreach (g->scenes, scene, used)
        json_object_foreach (by_renderer, renderer, list) {
            FREED char *key = key_of(renderer, scene);
            const json_t *group = key ? json_object_get(g->groups, key) : NULL;
            if (group) {
                json_t *c = make_certificate(source_of(g->reports, group), group, json_array_size(certificates));
                json_array_append(list, c);
                json_array_append_new(certificates, c);
            }
        }
    json_object_foreach (by_renderer, renderer, list)
        if (json_array_size(list) > 0)
            json_array_append_new(renderers, sum_up_renderer(renderer, list));
    const bool bad = count_rows(renderers, ISO_VERDICT_DIFFER) + count_rows(renderers, ISO_VERDICT_REFUSED) > 0;
    return json_pack("{s:s, s:s, s:o, s:o, s:o}", "schema", "isoshade.certificates/1", "verdict",
                     iso_verdict_word(bad ? ISO_VERDICT_DIFFER : ISO_VERDICT_AGREE), "sentence",
                     site_sentence(renderers), "renderers", renderers, "certificates", certificates);
}

iso_status iso_certificates_of(const iso_report_source *reports, size_t count, json_t **site, iso_error *err)
{
    json_auto_t *groups = json_object(), *renderers = json_object(), *scenes = json_object();
    const grouping g = {reports, groups, renderers, scenes};
    *site = NULL;
    for (size_t i = 0; i < count; ++i) {
        json_auto_t *own = json_object();
        json_t *group;
        const char *key;
        NEED(group_report(&g, i, own, err));
        if (json_object_size(own) == 0)
            return iso_fail(err, ISO_E_FORMAT, "%s: has no comparison of a renderer, so nothing can be certified",
                            reports[i].path);
        json_object_foreach (own, key, group)
            merge_group(&g, key, group);
    }
    *site = make_site(&g);
    return *site ? ISO_OK : iso_fail(err, ISO_E_MEMORY, "certificate: out of memory");
}
