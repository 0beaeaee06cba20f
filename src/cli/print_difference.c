/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "cli/print_difference.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "report/rows.h"

static char *text_of(const json_t *value)
{
    char *text = NULL;
    if (json_is_real(value))
        return asprintf(&text, "%.4g", json_real_value(value)) < 0 ? NULL : text;
    return json_is_string(value) ? strdup(json_string_value(value)) : json_dumps(value, JSON_ENCODE_ANY);
}

/* Prints "    rmse: 0.001 -> 0.002". */
static void print_values(const char *before, const json_t *a, const json_t *b)
{
    char *from = text_of(a), *to = text_of(b);
    printf("%s: %s -> %s\n", before, from ? from : "", to ? to : "");
    free(from);
    free(to);
}

void iso_print_difference(const json_t *d)
{
    size_t i, j;
    json_t *one, *what;
    json_array_foreach (json_object_get(d, "facts"), i, one)
        print_values(iso_row_text(one, "fact"), json_object_get(one, "a"), json_object_get(one, "b"));
    json_array_foreach (json_object_get(d, "rows"), i, one) {
        printf("%s: %s\n", iso_row_text(one, "change"), iso_row_text(one, "name"));
        json_array_foreach (json_object_get(one, "what"), j, what) {
            char line[160];
            snprintf(line, sizeof line, "    %s%.130s", json_is_true(json_object_get(what, "worse")) ? "worse: " : "",
                     iso_row_text(what, "what"));
            print_values(line, json_object_get(what, "a"), json_object_get(what, "b"));
        }
    }
    json_array_foreach (json_object_get(d, "pictures"), i, one) {
        if (json_is_true(json_object_get(one, "counts")) && json_object_get(one, "problem"))
            printf("picture: %s: %s\n", iso_row_text(one, "name"), iso_row_text(one, "problem"));
        else if (json_is_true(json_object_get(one, "counts")))
            printf("picture: %s: RMSE %.4g, tolerance %.4g (%s)\n", iso_row_text(one, "name"),
                   iso_row_number(one, "rmse"), iso_row_number(one, "tolerance"), iso_row_text(one, "why"));
    }
    puts(iso_row_text(d, "sentence"));
}
