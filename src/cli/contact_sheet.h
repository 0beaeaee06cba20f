/* SPDX-License-Identifier: MIT */
/* contact_sheet.h - a sheet of many small pictures with numbers and names, drawn by gnuplot.
 *
 *     +---------+---------+--------  columns: a multiple of `group`, so that a group stays in one row
 *     | picture | picture |
 *     | 1 label | 2 label | */
#pragma once

#include <jansson.h>

#include "image/image.h"

typedef struct iso_contact_sheet {
    size_t count, room;
    struct iso_contact_panel {
        unsigned char *rgb; /* display colors; row 0 is the top */
        size_t left, top;   /* position in the sheet's pixels, set by iso_contact_sheet_draw() */
        char *label, *command;
    } * panels;
    size_t side; /* of each square picture, in pixels */
} iso_contact_sheet;

/* Adds a square picture of the same size as the others. ISO_E_RANGE, ISO_E_MEMORY. */
iso_status iso_contact_sheet_add(iso_contact_sheet *s, const iso_image *image, const char *label, const char *command,
                                 iso_error *err);
/* Draws the sheet. group: number of pictures that stay in one row. Errors as of iso_gnuplot_picture(). A PNG has the
 * pictures pixel by pixel. */
iso_status iso_contact_sheet_draw(iso_contact_sheet *s, size_t group, const char *title, const char *output,
                                  iso_error *err);
/* Returns [{"number": 1, "label", "command", "left", "top", "size"}]. */
json_t *iso_contact_sheet_to_json(const iso_contact_sheet *s);
void iso_contact_sheet_destroy(iso_contact_sheet *s); /* accepts empty */
