/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "lab/weights_figures.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/embed.h"
#include "base/file.h"
#include "report/gnuplot.h"

ISO_EMBED(iso_levels_gp, "src/lab/levels.gp");
ISO_EMBED(iso_weights_gp, "src/lab/weights.gp");

static const char *text_of(const json_t *c, const char *key)
{
    const char *s = json_string_value(json_object_get(c, key));
    return s ? s : "";
}

static bool is_like(const json_t *c, const char *key, const char *value)
{
    return strcmp(text_of(c, key), value) == 0;
}

static int level_of(const json_t *c)
{
    return (int)json_integer_value(json_object_get(c, "level"));
}

/* Averages a volume's dissimilarity by a method, at one level or (0) at all. */
static double mean_of(const json_t *cases, const char *volume, const char *method, int level)
{
    const char *renderer = text_of(json_array_get(cases, 0), "renderer");
    double sum = 0, n = 0;
    size_t i;
    json_t *c;
    json_array_foreach (cases, i, c)
        if (is_like(c, "renderer", renderer) && is_like(c, "volume", volume) && is_like(c, "method", method) &&
            (level == 0 || level_of(c) == level)) {
            sum += json_number_value(json_object_get(c, "ssim_dissimilarity"));
            ++n;
        }
    return n > 0 ? sum / n : 0;
}

/* Lists the different values of a key in order of appearance. */
static size_t list_values(const json_t *cases, const char *key, const char *values[], size_t most)
{
    size_t count = 0, i, k;
    json_t *c;
    json_array_foreach (cases, i, c) {
        const char *value = text_of(c, key);
        for (k = 0; k < count && strcmp(values[k], value) != 0;)
            ++k;
        if (k == count && count < most)
            values[count++] = value;
    }
    return count;
}

enum { MOST = 64 };

static void write_rows(const json_t *cases, bool by_level, FILE *csv)
{
    const char *volumes[MOST], *methods[MOST];
    size_t volume_count = list_values(cases, "volume", volumes, MOST),
           method_count = list_values(cases, "method", methods, MOST), i;
    int first = 64, last = 0;
    json_t *c;
    json_array_foreach (cases, i, c) {
        first = level_of(c) < first ? level_of(c) : first;
        last = level_of(c) > last ? level_of(c) : last;
    }
    fprintf(csv, by_level ? "volume,level,method,ssim_dissimilarity,at\n" : "volume,method,ssim_dissimilarity,at\n");
    for (size_t v = 0; v < volume_count; ++v)
        for (size_t m = 0; m < method_count; ++m) {
            const int length = (int)strcspn(volumes[v], "."); /* without .nrrd and .nii.gz */
            if (!by_level)
                fprintf(csv, "%.*s,%s,%.9g,%zu\n", length, volumes[v], methods[m],
                        mean_of(cases, volumes[v], methods[m], 0), v);
            for (int level = first; by_level && level <= last; ++level)
                fprintf(csv, "%.*s,%d,%s,%.9g,%zu\n", length, volumes[v], level, methods[m],
                        mean_of(cases, volumes[v], methods[m], level), v);
        }
}

static iso_status draw(const json_t *cases, bool by_level, const char *dir, iso_error *err)
{
    FREED char *csv = NULL;
    size_t size = 0;
    FILE *f = open_memstream(&csv, &size);
    NEED_MEMORY(f, err, "isoshade-lab consistency: no memory for a figure's data");
    write_rows(cases, by_level, f);
    fclose(f);
    return iso_gnuplot_draw(dir, by_level ? "figure9" : "figure8", csv, by_level ? iso_levels_gp : iso_weights_gp,
                            "svg", err);
}

iso_status iso_lab_figures(const json_t *cases, const char *dir, iso_error *err)
{
    iso_output out = {0};
    iso_status status = iso_output_begin_dir(&out, dir, "figure9.csv", err);
    TRY(status, draw(cases, true, out.temp_path, err));
    TRY(status, draw(cases, false, out.temp_path, err));
    TRY(status, iso_output_commit(&out, err));
    iso_output_abandon(&out);
    return status;
}
