/* SPDX-License-Identifier: MIT */
#include "figure/paper.h"

#include <math.h>
#include <string.h>

static const double edge_mm = 0.6, row_gap_mm = 1.2, least_mm = 12;

static double title_room(const iso_paper *p, const iso_paper_row *row)
{
    return row->has_titles ? iso_page_line_mm(p->page, ISO_PAGE_TITLE) + 0.6 : 0;
}

static double note_room(const iso_paper *p, const iso_paper_row *row)
{
    return row->has_notes ? iso_page_line_mm(p->page, ISO_PAGE_NOTE) + 0.8 : 0;
}

/* Places the panels of each row, with `part` of the available width. Returns the total height. */
static double place_rows(iso_paper *p, double part)
{
    double y = edge_mm;
    for (size_t i = 0; i < p->row_count; ++i) {
        const iso_paper_row *row = &p->rows[i];
        const double columns = (double)row->columns;
        const double room = p->job->width_mm - 2 * edge_mm - row->left_mm - row->right_mm;
        p->panel_mm[i] = part * fmin((room - (columns - 1) * row->gap_mm) / columns, row->most_mm);
        p->top_mm[i] = y + title_room(p, row);
        y = p->top_mm[i] + p->panel_mm[i] * row->aspect + row->foot_mm + note_room(p, row) + row->below_mm + row_gap_mm;
    }
    return y - row_gap_mm + edge_mm;
}

iso_status iso_paper_lay_out(iso_paper *p, const iso_figure_job *job, iso_page *page, const iso_paper_row *rows,
                             size_t count, iso_error *err)
{
    *p = (iso_paper){.job = job, .page = page, .row_count = count};
    memcpy(p->rows, rows, count * sizeof *rows);
    for (int i = 0; i < ISO_PAGE_ROLES; ++i)
        p->line_mm[i] = iso_page_line_mm(page, (iso_page_role)i);
    double part = 1, high = place_rows(p, part), wide = 0, narrowest = INFINITY;
    while (high > job->height_mm && part > 0.05)
        high = place_rows(p, part *= 0.97);
    for (size_t i = 0; i < count; ++i) {
        const double columns = (double)rows[i].columns;
        wide = fmax(wide, 2 * edge_mm + rows[i].left_mm + rows[i].right_mm + columns * p->panel_mm[i] +
                              (columns - 1) * rows[i].gap_mm);
        narrowest = fmin(narrowest, p->panel_mm[i]);
    }
    if (!(narrowest >= least_mm && high <= job->height_mm))
        return iso_fail(err, ISO_E_RANGE,
                        "figure: --width %g and --height %g leave %.1f mm for each panel, at least %g are needed",
                        job->width_mm, job->height_mm, fmax(narrowest, 0), least_mm);
    iso_page_set_size(page, wide, high);
    return ISO_OK;
}

/* Puts a text above or below a panel, in its middle. */
static void put_text(const iso_paper *p, iso_page_role role, double x, double y, double room_mm, const char *text)
{
    const iso_page_text at = {.x = x, .y = y, .role = role, .align = ISO_PAGE_CENTER};
    const double wide = text ? iso_page_text_mm(p->page, role, text) : 0;
    if (!text)
        return;
    if (wide > room_mm)
        iso_page_set_text_pt(p->page, role, iso_page_text_pt(p->page, role) * room_mm / wide);
    iso_page_put_text(p->page, &at, text);
}

iso_page_box iso_paper_panel(const iso_paper *p, size_t i, size_t column, const char *title, const char *note)
{
    const iso_paper_row *row = &p->rows[i];
    const double wide = p->panel_mm[i], high = wide * row->aspect, room = wide + row->gap_mm;
    const iso_page_box box = {edge_mm + row->left_mm + (double)column * room, p->top_mm[i], wide, high};
    const double middle = box.left + 0.5 * wide;
    put_text(p, ISO_PAGE_TITLE, middle, box.top - 0.5 * p->line_mm[ISO_PAGE_TITLE] - 0.3, room, title);
    put_text(p, ISO_PAGE_NOTE, middle, box.top + high + row->foot_mm + 0.5 * p->line_mm[ISO_PAGE_NOTE] + 0.5, room,
             note);
    return box;
}

size_t iso_paper_dots(const iso_paper *p, size_t row)
{
    return iso_page_dots(p->page, p->panel_mm[row]);
}

iso_page_box iso_paper_corner(iso_page_box box)
{
    box.width = box.height = 0;
    return box;
}

iso_page_box iso_paper_picture(const iso_paper *p, size_t row, size_t column, const char *title, const char *note,
                               const iso_image *image)
{
    const iso_page_box box = iso_paper_panel(p, row, column, title, note), corner = iso_paper_corner(box);
    iso_page_put_picture(p->page, &corner, image);
    return box;
}
