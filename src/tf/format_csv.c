/* SPDX-License-Identifier: MIT */
/* format_csv.c - a transfer function as a table for other programs: a line an entry. */
#define _GNU_SOURCE
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "base/file.h"
#include "tf/format.h"

static void write_rows(FILE *file, const iso_tf_table *t, double unit_mm)
{
    for (size_t i = 0; i < t->count; ++i) {
        const float *e = t->entries + 4 * i;
        const double values[] = {t->lo + (t->hi - t->lo) * (double)i / (double)(t->count - 1),
                                 e[0],
                                 e[1],
                                 e[2],
                                 e[3],
                                 -expm1(-(double)e[3] * unit_mm)};
        for (int c = 0; c < 6; ++c)
            fprintf(file, "%s%.9g", c ? "," : "", values[c]);
        fputc('\n', file);
    }
}

static iso_status save_csv(const iso_tf_table *t, double unit_mm, const char *path, iso_error *err)
{
    char *text = NULL;
    size_t size = 0;
    FILE *memory = open_memstream(&text, &size);
    if (!memory)
        return iso_fail(err, ISO_E_MEMORY, "out of memory");
    fprintf(memory, "value,r_linear,g_linear,b_linear,extinction_per_mm,opacity_of_%.9g_mm\n", unit_mm);
    write_rows(memory, t, unit_mm);
    fclose(memory);
    iso_status status = iso_file_write(path, text, size, err);
    free(text);
    return status;
}

const iso_tf_format iso_tf_format_csv = {
    .name = "csv",
    .summary = "value, linear color, extinction, opacity: a line an entry; written only",
    .suffix = ".csv",
    .save = save_csv,
};
