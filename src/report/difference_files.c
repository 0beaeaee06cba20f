/* SPDX-License-Identifier: MIT */
/* difference_files.c - compares the pictures of two reports, and writes the page of the differences. */
#define _GNU_SOURCE
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/words.h"
#include "report/difference.h"
#include "report/page.h"
#include "report/report.h"

/* ---- pictures ---- */

/* Two pictures of one name. */
typedef struct picture_pair {
    const char *name;
    const json_t *about;
    const json_t *rows[2]; /* rows whose image b it is; or NULL */
    iso_image images[2];
} picture_pair;

static const json_t *row_of_image(const json_t *report, const char *name)
{
    size_t i;
    json_t *row;
    json_array_foreach (json_object_get(report, "agreement"), i, row)
        if (strcmp(iso_row_text(row, "image_b"), name) == 0)
            return row;
    return NULL;
}

static bool has_the_same_pixels(const iso_image *a, const iso_image *b)
{
    return a->width == b->width && a->height == b->height &&
           memcmp(a->rgba, b->rgba, 4 * a->width * a->height * sizeof *a->rgba) == 0;
}

/* Describes a difference of two pictures by its figures. */
static json_t *describe(const picture_pair *p, const iso_metrics *m)
{
    const iso_tolerance t = iso_difference_tolerance(p->rows[0], p->rows[1], "rmse");
    return json_pack("{s:s, s:O, s:o, s:o, s:o, s:[I,I], s:f, s:s, s:b}", "name", p->name, "caption",
                     json_object_get(p->about, "caption") ? json_object_get(p->about, "caption") : json_null(), "rmse",
                     iso_json_number(m->rmse), "max_abs", iso_json_number(m->max_abs), "flip_mean",
                     iso_json_number(m->flip_mean), "worst_pixel", (json_int_t)m->worst[0], (json_int_t)m->worst[1],
                     "tolerance", t.value, "why", t.why, "counts", !(m->rmse <= t.value));
}

static json_t *describe_problem(const char *name, const char *problem)
{
    return json_pack("{s:s, s:n, s:s, s:b}", "name", name, "caption", "problem", problem, "counts", true);
}

/* Adds to `inlined` the images of the picture with this number. */
static iso_status inline_pair(const picture_pair *p, const iso_report_source *const of[2], size_t number,
                              json_t *inlined, iso_error *err)
{
    FREED char *difference = NULL;
    char key[32];
    for (int i = 0; i < 2; ++i) {
        FREED char *png = iso_report_source_picture(of[i], p->name, "png"), *place = NULL, *uri = NULL;
        if (!png || asprintf(&place, "%c/%s", "ab"[i], p -> name) < 0)
            return iso_fail(err, ISO_E_MEMORY, "report diff: out of memory");
        NEED(iso_page_file_uri(png, "image/png", &uri, err));
        json_object_set_new(json_object_get(inlined, "images"), place, json_string(uri));
    }
    NEED(iso_page_difference_uri(&p->images[0], &p->images[1], ISO_PAGE_FINE, &difference, err));
    snprintf(key, sizeof key, "%zu", number);
    json_object_set_new(json_object_get(inlined, "differences"), key, json_string(difference));
    return ISO_OK;
}

/* Loads both pictures. A missing one, or two of other sizes, are a difference: *problem is the reason, to be freed.
 * An unreadable one is an error. */
static iso_status load(picture_pair *p, const iso_report_source *const of[2], char **problem, iso_error *err)
{
    iso_status status = ISO_OK;
    int wrote = 0;
    for (int i = 0; i < 2 && !*problem && status == ISO_OK; ++i) {
        FREED char *exr = iso_report_source_picture(of[i], p->name, "exr");
        if (!exr)
            status = iso_fail(err, ISO_E_MEMORY, "report diff: out of memory");
        else if (!iso_path_exists(exr))
            wrote = asprintf(problem, "%s: no such file", exr);
        else
            status = iso_image_load_exr(exr, &p->images[i], err);
    }
    if (status == ISO_OK && !*problem && wrote == 0 &&
        (p->images[0].width != p->images[1].width || p->images[0].height != p->images[1].height))
        wrote = asprintf(problem, "%zu x %zu pixels in A, %zu x %zu in B", p->images[0].width, p->images[0].height,
                         p->images[1].width, p->images[1].height);
    if (wrote < 0) {
        *problem = NULL;
        status = iso_fail(err, ISO_E_MEMORY, "report diff: out of memory");
    }
    return status;
}

/* Compares two pictures, and adds them to list if they differ. */
static iso_status compare_pair(picture_pair *p, const iso_report_source *const of[2], json_t *list, json_t *inlined,
                               iso_error *err)
{
    FREED char *problem = NULL;
    iso_metrics m;
    iso_status status = load(p, of, &problem, err);
    if (status == ISO_OK && problem) {
        json_array_append_new(list, describe_problem(p->name, problem));
    } else if (status == ISO_OK && !has_the_same_pixels(&p->images[0], &p->images[1])) {
        status = iso_metrics_measure(&p->images[0], &p->images[1], &m, err);
        json_t *picture = status == ISO_OK ? describe(p, &m) : NULL;
        const size_t number = json_array_size(list);
        if (picture)
            json_object_set_new(picture, "number", json_integer((json_int_t)number));
        if (status == ISO_OK && inlined)
            status = inline_pair(p, of, number, inlined, err);
        json_array_append_new(list, picture);
    }
    iso_image_destroy(&p->images[0]);
    iso_image_destroy(&p->images[1]);
    return status;
}

/* Returns the difference in tolerances; INFINITY if the pictures cannot be compared. */
static double size_of_difference(const json_t *picture)
{
    const double rmse = iso_row_number(picture, "rmse"), tolerance = iso_row_number(picture, "tolerance");
    return isnan(rmse) ? INFINITY : rmse / tolerance;
}

static int largest_first(const void *a, const void *b)
{
    const double x = size_of_difference(*(json_t *const *)a), y = size_of_difference(*(json_t *const *)b);
    return (x < y) - (x > y);
}

/* Sorts the pictures. Takes the reference to list. */
static iso_status keep_sorted(json_t *difference, json_t *list, iso_error *err)
{
    const size_t count = json_array_size(list);
    json_t **order = calloc(count + 1, sizeof *order), *sorted = json_array();
    for (size_t i = 0; order && i < count; ++i)
        order[i] = json_array_get(list, i);
    if (order)
        qsort(order, count, sizeof *order, largest_first);
    for (size_t i = 0; order && i < count; ++i)
        json_array_append(sorted, order[i]);
    json_object_set_new(difference, "pictures", sorted);
    json_decref(list);
    free(order);
    return order ? ISO_OK : iso_fail(err, ISO_E_MEMORY, "report diff: out of memory");
}

/* Returns the report without pictures (only its report.json was kept), or NULL. */
static const iso_report_source *without_pictures(const iso_report_source *const of[2])
{
    for (int i = 0; i < 2; ++i)
        if (!iso_report_source_has_pictures(of[i]))
            return of[i];
    return NULL;
}

iso_status iso_difference_add_pictures(json_t *difference, const iso_report_source *a, const iso_report_source *b,
                                       json_t *inlined, iso_error *err)
{
    const iso_report_source *const of[2] = {a, b}, *none = without_pictures(of);
    const json_t *others = json_object_get(b->root, "images");
    json_t *list = json_array(), *about;
    const char *name;
    size_t count = 0;
    iso_status status = ISO_OK;
    json_object_foreach (json_object_get(a->root, "images"), name, about) {
        picture_pair p = {.name = name,
                          .about = about,
                          .rows = {row_of_image(a->root, name), row_of_image(b->root, name)}};
        if (none || status != ISO_OK || !json_object_get(others, name))
            continue;
        ++count;
        if (!iso_report_is_picture_name(name))
            json_array_append_new(list, describe_problem(name, "invalid image name"));
        else
            status = compare_pair(&p, of, list, inlined, err);
    }
    json_object_set_new(difference, "picture_count", json_integer((json_int_t)count));
    if (none)
        json_object_set_new(difference, "pictures_missing",
                            json_sprintf("Pictures were not compared: %s has no folder images.",
                                         none == a ? "A" : "B"));
    if (status != ISO_OK) {
        json_decref(list);
        return status;
    }
    return keep_sorted(difference, list, err);
}

/* ---- verdict and sentence ---- */

static size_t count_changes(const json_t *rows, const char *change)
{
    size_t i, count = 0;
    json_t *row;
    json_array_foreach (rows, i, row)
        count += strcmp(iso_row_text(row, "change"), change) == 0;
    return count;
}

static size_t count_counting(const json_t *list)
{
    size_t i, count = 0;
    json_t *one;
    json_array_foreach (list, i, one)
        count += json_is_true(json_object_get(one, "counts"));
    return count;
}

/* Adds the number of facts that differ, and missing pictures. */
static void add_fact_count(const json_t *difference, size_t counting, char *sentence, size_t size)
{
    const json_t *facts = json_object_get(difference, "facts"), *fact;
    size_t i, machine = 0;
    json_array_foreach (facts, i, fact)
        machine += strncmp(iso_row_text(fact, "fact"), "machine", 7) == 0;
    const size_t count = json_array_size(facts) - machine;
    if (count > 0)
        iso_words_append(sentence, size, " %zu version%s or option%s differ%s%s.", count, iso_words_plural(count),
                         iso_words_plural(count), count == 1 ? "s" : "", counting ? "" : " (not counted, by request)");
    if (json_object_get(difference, "pictures_missing"))
        iso_words_append(sentence, size, " %s", iso_row_text(difference, "pictures_missing"));
}

void iso_difference_conclude(json_t *difference)
{
    const json_t *rows = json_object_get(difference, "rows"), *pictures = json_object_get(difference, "pictures");
    const size_t all = (size_t)json_integer_value(json_object_get(difference, "row_count")),
                 shown = (size_t)json_integer_value(json_object_get(difference, "picture_count")),
                 changed = count_changes(rows, "changed"), appeared = count_changes(rows, "appeared"),
                 gone = count_changes(rows, "disappeared"), differing = count_counting(pictures),
                 facts = count_counting(json_object_get(difference, "facts"));
    char sentence[1024] = "";
    if (json_array_size(rows) + differing == 0)
        iso_words_append(sentence, sizeof sentence, "No difference in %zu row%s and %zu picture%s.", all,
                         iso_words_plural(all), shown, iso_words_plural(shown));
    else
        iso_words_append(sentence, sizeof sentence,
                         "The reports differ: %zu of %zu row%s changed, %zu appeared and %zu disappeared; %zu of %zu "
                         "picture%s differ%s beyond tolerance.",
                         changed, all, iso_words_plural(all), appeared, gone, differing, shown, iso_words_plural(shown),
                         differing == 1 ? "s" : "");
    add_fact_count(difference, facts, sentence, sizeof sentence);
    json_object_set_new(difference, "changed_count", json_integer((json_int_t)changed));
    json_object_set_new(difference, "appeared_count", json_integer((json_int_t)appeared));
    json_object_set_new(difference, "disappeared_count", json_integer((json_int_t)gone));
    json_object_set_new(difference, "differing_picture_count", json_integer((json_int_t)differing));
    json_object_set_new(difference, "verdict",
                        json_string(iso_verdict_word(
                            json_array_size(rows) + differing + facts == 0 ? ISO_VERDICT_AGREE : ISO_VERDICT_DIFFER)));
    json_object_set_new(difference, "sentence", json_string(sentence));
}

iso_status iso_difference_write(const char *dir, const json_t *difference, const json_t *inlined, iso_error *err)
{
    ENDED_BY(iso_output_abandon) iso_output out = {0};
    NEED(iso_output_begin_dir(&out, dir, "difference.json", err));
    FREED char *data = iso_path_join(out.temp_path, "difference.json"),
               *page = iso_path_join(out.temp_path, "index.html");
    NEED(data && page ? iso_json_save(data, difference, err)
                      : iso_fail(err, ISO_E_MEMORY, "report diff: out of memory"));
    NEED(iso_page_write(page, &iso_page_of_difference, difference, inlined, err));
    return iso_output_commit(&out, err);
}
