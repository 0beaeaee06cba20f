/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "cli/contact_sheet.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/provenance.h"
#include "compare/srgb.h"
#include "report/gnuplot.h"

/* Distances in pixels of a PNG; all even, because gnuplot gets their halves. */
enum { GAP = 10, LABEL = 24, HEAD = 40 };

iso_status iso_contact_sheet_add(iso_contact_sheet *s, const iso_image *image, const char *label, const char *command,
                                 iso_error *err)
{
    const size_t pixels = image->width * image->height;
    if (image->width != image->height || (s->count > 0 && image->width != s->side))
        return iso_fail(err, ISO_E_RANGE,
                        "sheet: a picture has %zu x %zu pixels, must be a square of the same size as the others",
                        image->width, image->height);
    if (s->count == s->room) {
        const size_t room = s->room ? 2 * s->room : 16;
        void *panels = realloc(s->panels, room * sizeof *s->panels);
        if (!panels)
            return iso_fail(err, ISO_E_MEMORY, "sheet: out of memory");
        s->panels = panels, s->room = room;
    }
    struct iso_contact_panel *p = &s->panels[s->count];
    *p = (struct iso_contact_panel){.rgb = malloc(3 * pixels), .label = strdup(label), .command = strdup(command)};
    s->side = image->width;
    ++s->count;
    if (!p->rgb || !p->label || !p->command)
        return iso_fail(err, ISO_E_MEMORY, "sheet: out of memory");
    for (size_t i = 0; i < 3 * pixels; ++i)
        p->rgb[i] = (unsigned char)(iso_srgb_encode((double)image->rgba[4 * (i / 3) + i % 3]) * 255 + 0.5);
    return ISO_OK;
}

typedef struct mosaic {
    const iso_contact_sheet *sheet;
    const char *title, *raw;
    size_t columns, width, height;
    unsigned char *rgb;
} mosaic;

/* Returns the number of columns: whole groups, so that the sheet is about 1.5 times as wide as high. */
static size_t choose_columns(const iso_contact_sheet *s, size_t group)
{
    const size_t groups = (s->count + group - 1) / group;
    size_t best = 1;
    double least = INFINITY;
    for (size_t k = 1; k <= groups; ++k) {
        const double shape = (double)(k * group) / ceil((double)groups / (double)k), off = fabs(log(shape / 1.5));
        if (off < least)
            least = off, best = k;
    }
    return best * group;
}

static void place(iso_contact_sheet *s, mosaic *m)
{
    const size_t rows = (s->count + m->columns - 1) / m->columns, side = s->side + s->side % 2;
    m->width = m->columns * (side + GAP) + GAP;
    m->height = HEAD + rows * (side + LABEL + GAP);
    memset(m->rgb, 255, 3 * m->width * m->height);
    for (size_t i = 0; i < s->count; ++i) {
        struct iso_contact_panel *p = &s->panels[i];
        p->left = GAP + i % m->columns * (side + GAP);
        p->top = HEAD + i / m->columns * (side + LABEL + GAP);
        for (size_t y = 0; y < s->side; ++y)
            memcpy(m->rgb + 3 * ((p->top + y) * m->width + p->left), p->rgb + 3 * y * s->side, 3 * s->side);
    }
}

static iso_status write_sheet(FILE *gp, void *user, iso_error *err)
{
    const mosaic *m = user;
    const iso_contact_sheet *s = m->sheet;
    /* font size at which the longest names of presets and views fit below a picture */
    const double points = 5.5 * fmin(1, (double)s->side / 176);
    (void)err;
    fprintf(gp,
            "set lmargin 0\nset rmargin 0\nset tmargin 0\nset bmargin 0\nunset border\nunset tics\nunset key\n"
            "set xrange [-0.5:%zu.5]\nset yrange [-0.5:%zu.5]\n",
            m->width - 1, m->height - 1);
    fputs("set label ", gp);
    iso_gnuplot_put_quoted(gp, m->title);
    fprintf(gp, " at %d,%zu left front noenhanced font ',8'\n", GAP, m->height - HEAD / 2 - 2);
    for (size_t i = 0; i < s->count; ++i) {
        char text[160];
        snprintf(text, sizeof text, "%zu  %.120s", i + 1, s->panels[i].label);
        fputs("set label ", gp);
        iso_gnuplot_put_quoted(gp, text);
        fprintf(gp, " at %zu,%zu left front noenhanced font ',%.2f'\n", s->panels[i].left,
                m->height - (s->panels[i].top + s->side + LABEL / 2 + 1), points);
    }
    fputs("plot ", gp);
    iso_gnuplot_put_quoted(gp, m->raw);
    fprintf(gp, " binary array=(%zu,%zu) flip=y format='%%3uchar' using 1:2:3 with rgbimage\n", m->width, m->height);
    return ISO_OK;
}

iso_status iso_contact_sheet_draw(iso_contact_sheet *s, size_t group, const char *title, const char *output,
                                  iso_error *err)
{
    mosaic m = {.sheet = s, .title = title, .columns = choose_columns(s, group)};
    const size_t rows = (s->count + m.columns - 1) / m.columns;
    FREED char *dir = iso_make_temp_dir(), *raw = dir ? iso_path_join(dir, "sheet.raw") : NULL;
    m.raw = raw;
    m.rgb = malloc(3 * (m.columns * (s->side + 1 + GAP) + GAP) * (HEAD + rows * (s->side + 1 + LABEL + GAP)));
    iso_status status = ISO_OK;
    if (!dir)
        status = iso_temp_dir_fail(err);
    else if (!raw || !m.rgb)
        status = iso_fail(err, ISO_E_MEMORY, "sheet: out of memory");
    if (status == ISO_OK) {
        place(s, &m);
        status = iso_file_write(raw, m.rgb, 3 * m.width * m.height, err);
    }
    TRY(status, iso_gnuplot_picture(output, (double)m.width / 2, (double)m.height / 2, write_sheet, &m, err));
    if (dir)
        iso_remove_tree(dir);
    free(m.rgb);
    return status;
}

json_t *iso_contact_sheet_to_json(const iso_contact_sheet *s)
{
    json_t *list = json_array();
    for (size_t i = 0; i < s->count; ++i) {
        const struct iso_contact_panel *p = &s->panels[i];
        FREED char *command = iso_provenance_line(p->command);
        json_array_append_new(list, json_pack("{s:I, s:s, s:s, s:I, s:I, s:I}", "number", (json_int_t)(i + 1), "label",
                                              p->label, "command", command ? command : "", "left", (json_int_t)p->left,
                                              "top", (json_int_t)p->top, "size", (json_int_t)s->side));
    }
    return list;
}

void iso_contact_sheet_destroy(iso_contact_sheet *s)
{
    for (size_t i = 0; i < s->count; ++i) {
        free(s->panels[i].rgb);
        free(s->panels[i].label);
        free(s->panels[i].command);
    }
    free(s->panels);
    *s = (iso_contact_sheet){0};
}
