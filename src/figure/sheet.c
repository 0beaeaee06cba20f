/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "figure/sheet.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "figure/page_text.h"
#include "volume/unit.h"

/* Print sizes; journals require 6 points at least. Titles become smaller before words overlap. */
static const double largest_title_pt = 8, smallest_pt = 6, note_pt = 6.2;
static const double mm_per_pt = 25.4 / 72, line_height = 1.25;
static const double narrowest_mm = 8, widest_mm = 60, gap_mm = 1.5;

/* ---- text ---- */

/* Returns the width of the longest word. */
static double word_width_mm(const char *text, double pt)
{
    double widest = 0;
    for (const char *s = text; *s; s += strspn(s, " |")) {
        size_t n = strcspn(s, " |");
        widest = fmax(widest, iso_page_text_width_mm(s, n, pt));
        s += n;
    }
    return widest;
}

/* Joins lines into one; a '|' becomes two blanks. */
static void join(const char *text, char out[128])
{
    size_t used = 0;
    for (const char *s = text; *s && used + 3 < 128; ++s) {
        out[used++] = *s == '|' ? ' ' : *s;
        if (*s == '|')
            out[used++] = ' ';
    }
    out[used] = 0;
}

/* Breaks a text into lines of at most room_mm, with a '|' between them: at each '|', and at blanks if needed.
 * Returns the number of lines. */
static size_t break_lines(const char *text, double room_mm, double pt, char out[128])
{
    size_t count = text[0] != 0, line = 0, blank = 0; /* start of the line; its last blank, 0: none */
    snprintf(out, 128, "%s", text);
    for (size_t i = 0; out[i]; ++i) {
        if (out[i] == '|' || (blank > line && iso_page_text_width_mm(out + line, i + 1 - line, pt) > room_mm)) {
            size_t end = out[i] == '|' ? i : blank;
            out[end] = '|';
            line = end + 1;
            ++count;
        }
        if (out[i] == ' ')
            blank = i;
    }
    return count;
}

/* ---- layout: millimeters from the left and the top ---- */

typedef struct layout {
    double panel_width, panel_height, left, right, head, width, height;
    double title_pt;
    iso_page_box legend;
    char legend_text[128];
} layout;

static const char legend_words[] = "difference,|1 = white";
static const double legend_bar_mm = 2.2;

static const char *text_of(const iso_figure_panel *p, bool title)
{
    return title ? p->title : p->note;
}

/* True if the titles, or the notes, of a row each fit in one line. Otherwise all are broken, to look the same. */
static bool fit_in_one(const iso_figure_sheet *f, size_t row, bool titles, double room_mm, double pt)
{
    char line[128];
    for (size_t i = 0; i < f->count; ++i) {
        join(text_of(&f->panels[i], titles), line);
        if (f->panels[i].row == row && iso_page_text_width_mm(line, strlen(line), pt) > room_mm)
            return false;
    }
    return true;
}

/* Sets the lines of a panel's title or note. Returns their number. */
static size_t set_lines(const iso_figure_sheet *f, const iso_figure_panel *p, bool title, double room_mm, double pt,
                        char out[128])
{
    if (!fit_in_one(f, p->row, title, room_mm, pt))
        return break_lines(text_of(p, title), room_mm, pt, out);
    join(text_of(p, title), out);
    return out[0] != 0;
}

static size_t most_lines(const iso_figure_sheet *f, size_t row, bool titles, double room_mm, double pt)
{
    char lines[128];
    size_t most = 0;
    for (size_t i = 0; i < f->count; ++i) {
        size_t n = f->panels[i].row == row ? set_lines(f, &f->panels[i], titles, room_mm, pt, lines) : 0;
        most = n > most ? n : most;
    }
    return most;
}

static double lines_mm(size_t count, double pt)
{
    return (double)count * line_height * pt * mm_per_pt;
}

/* Returns the height below a row: its notes, or a gap. */
static double row_foot(const iso_figure_sheet *f, const layout *l, size_t row)
{
    return gap_mm + lines_mm(most_lines(f, row, false, l->panel_width, note_pt), note_pt);
}

/* Returns the height above a row; 0 for the first, whose titles are in the page's head. */
static double row_head(const iso_figure_sheet *f, const layout *l, size_t row)
{
    const size_t lines = most_lines(f, row, true, l->panel_width, l->title_pt);
    return lines > 0 ? lines_mm(lines, l->title_pt) + 0.5 : 0;
}

static double row_top(const iso_figure_sheet *f, const layout *l, size_t row)
{
    double y = l->head;
    for (size_t r = 0; r < row; ++r)
        y += l->panel_height + row_foot(f, l, r) + row_head(f, l, r + 1);
    return y;
}

/* Returns the largest height of a text on the left: its rows. */
static double side_mm(const iso_figure_sheet *f, const layout *l)
{
    return (double)f->rows_per_side * (l->panel_height + gap_mm) - gap_mm;
}

static size_t side_lines(const iso_figure_sheet *f, const layout *l)
{
    char lines[128];
    size_t most = 0;
    for (size_t i = 0; i < f->count; ++i) {
        size_t n = break_lines(f->panels[i].side, side_mm(f, l), l->title_pt, lines);
        most = n > most ? n : most;
    }
    return most;
}

static bool has_panel(const iso_figure_sheet *f, size_t row, size_t column)
{
    for (size_t i = 0; i < f->count; ++i)
        if (f->panels[i].row == row && f->panels[i].column == column)
            return true;
    return false;
}

static size_t first_map_row(const iso_figure_sheet *f)
{
    if (f->legend)
        return 0;
    for (size_t i = 0; i < f->count; ++i)
        if (f->panels[i].against)
            return f->panels[i].row;
    return f->rows;
}

/* Maps' differences are at most 1, and unknown before they are drawn. */
static double legend_ticks_mm(const iso_figure_sheet *f)
{
    const iso_page_color_bar bar = {.range = {f->low, f->high}};
    return f->legend ? iso_page_color_bar_ticks_mm(&bar, note_pt) : 1 + iso_page_text_width_mm("0.000", 5, note_pt);
}

static double legend_words_mm(const iso_figure_sheet *f, const layout *l, char out[128])
{
    return lines_mm(break_lines(f->legend ? f->legend : legend_words, 0.95 * l->panel_height, note_pt, out), note_pt) +
           0.8;
}

/* Places the legend before the first maps, if there is an empty box, or on their right. */
static void place_legend(const iso_figure_sheet *f, layout *l, bool inside)
{
    const double top = row_top(f, l, first_map_row(f)), words = legend_words_mm(f, l, l->legend_text);
    const double wide = words + legend_bar_mm + legend_ticks_mm(f);
    double x = inside ? l->left + fmax(0.5 * (l->panel_width - wide), 0) : l->width - l->right + gap_mm;
    l->legend = (iso_page_box){x + words, top + 0.04 * l->panel_height, legend_bar_mm, 0.92 * l->panel_height};
}

static size_t has_sides(const iso_figure_sheet *f)
{
    size_t any = 0;
    for (size_t i = 0; i < f->count; ++i)
        any |= f->panels[i].side[0] != 0;
    return any;
}

/* Sizes the panels: as wide as possible with the texts around them. */
static void size_panels(const iso_figure_sheet *f, layout *l, bool inside, double narrower)
{
    const iso_image *first = &f->panels[0].a;
    const double columns = (double)f->columns, gaps = (columns - 1) * gap_mm;
    char lines[128];
    /* The panels' height gives the number of lines of the upright texts, which reduce the width: repeats until both
     * agree. */
    for (size_t sides = 0, wanted = has_sides(f), passes = 0; wanted > sides || passes == 0;
         wanted = side_lines(f, l)) {
        sides = wanted;
        ++passes;
        l->left = 0.5 + lines_mm(sides, l->title_pt) + 0.5;
        l->right = inside || first_map_row(f) == f->rows
                       ? 0.5
                       : gap_mm + legend_words_mm(f, l, lines) + legend_bar_mm + legend_ticks_mm(f) + 0.5;
        l->panel_width = fmin((f->width_mm - l->left - l->right - gaps) / columns, widest_mm) * narrower;
        l->panel_height = l->panel_width * (double)first->height / (double)first->width;
    }
    l->width = l->left + columns * l->panel_width + gaps + l->right;
    l->head = 0.5 + lines_mm(most_lines(f, 0, true, l->panel_width, l->title_pt), l->title_pt) + 0.8;
    l->height = row_top(f, l, f->rows);
}

/* Returns the largest ratio of a word's width to its available width; at most 1 fits. */
static double crowding(const iso_figure_sheet *f, const layout *l)
{
    const double room = l->panel_width + gap_mm, upright = side_mm(f, l) + gap_mm;
    double most = narrowest_mm / l->panel_width;
    for (size_t i = 0; i < f->count; ++i) {
        const iso_figure_panel *p = &f->panels[i];
        most = fmax(most, fmax(word_width_mm(p->title, l->title_pt), word_width_mm(p->note, note_pt)) / room);
        most = fmax(most, word_width_mm(p->side, l->title_pt) / upright);
    }
    return most;
}

static iso_status plan_layout(const iso_figure_sheet *f, layout *l, iso_error *err)
{
    const size_t maps = first_map_row(f);
    bool inside = maps < f->rows && !has_panel(f, maps, 0);
    double narrower = 1;
    char lines[128];
    *l = (layout){.title_pt = largest_title_pt};
    size_panels(f, l, inside, narrower);
    if (inside && legend_words_mm(f, l, lines) + legend_bar_mm + legend_ticks_mm(f) > l->panel_width)
        size_panels(f, l, inside = false, narrower);
    for (int i = 0; i < 20 && l->height > f->height_mm; ++i) {
        narrower *= fmax(1 - (l->height - f->height_mm) / ((double)f->rows * l->panel_height), 0.5);
        size_panels(f, l, inside, narrower);
    }
    while (!(crowding(f, l) <= 1) && l->title_pt > smallest_pt) {
        l->title_pt = fmax(l->title_pt - 0.5, smallest_pt);
        size_panels(f, l, inside, narrower);
    }
    if (!(l->panel_width > 0 && l->height <= f->height_mm && crowding(f, l) <= 1))
        return iso_fail(err, ISO_E_RANGE,
                        "figure: %zu columns and %zu rows do not fit into %g x %g mm with texts of %g points; they "
                        "need %.1f times this size",
                        f->columns, f->rows, f->width_mm, f->height_mm, smallest_pt,
                        ceil(10 * fmax(crowding(f, l), l->height / f->height_mm)) / 10);
    if (maps < f->rows)
        place_legend(f, l, inside);
    return ISO_OK;
}

/* ---- pixels ---- */

static double difference_at(const iso_figure_sheet *f, const iso_figure_panel *p, size_t i)
{
    double d = 0;
    for (int c = 0; c < 4; ++c)
        d = fmax(d, fabs((double)p->a.rgba[4 * i + (size_t)c] - (double)p->b.rgba[4 * i + (size_t)c]));
    return f->in_logs ? fmax(log10(d), f->low) : fmin(d, f->high);
}

static void put_map(const iso_figure_sheet *f, const iso_figure_panel *p, const iso_page_box *box, iso_page *page)
{
    const size_t count = p->a.width * p->a.height;
    FREED float *values = malloc(count * sizeof *values);
    for (size_t i = 0; i < count && values; ++i)
        values[i] = (float)difference_at(f, p, i);
    if (values)
        iso_page_put_values(page, box, values, p->a.width, p->a.height, f->map, (double[2]){f->low, f->high});
}

/* ---- panels ---- */

/* Puts lines below each other, with '|' between them; y is the middle of the first. */
static void put_lines(iso_page *page, iso_page_text at, const char *lines)
{
    const double line = iso_page_line_mm(page, at.role);
    for (const char *s = lines; s && *s;) {
        char part[128];
        snprintf(part, sizeof part, "%.*s", (int)strcspn(s, "|"), s);
        iso_page_put_text(page, &at, part);
        *(at.upright ? &at.x : &at.y) += line;
        s = strchr(s, '|') ? strchr(s, '|') + 1 : NULL;
    }
}

static size_t count_lines(const char *lines)
{
    size_t count = *lines != 0;
    for (const char *s = lines; *s; ++s)
        count += *s == '|';
    return count;
}

static void put_texts(const iso_figure_sheet *f, const layout *l, const iso_figure_panel *p, const iso_page_box *box,
                      iso_page *page)
{
    char lines[128];
    const double middle = box->left + 0.5 * box->width;
    const double title = iso_page_line_mm(page, ISO_PAGE_TITLE), note = iso_page_line_mm(page, ISO_PAGE_NOTE);
    set_lines(f, p, true, l->panel_width, l->title_pt, lines);
    put_lines(page,
              (iso_page_text){.x = middle,
                              .y = box->top - ((double)count_lines(lines) - 0.4) * title,
                              .role = ISO_PAGE_TITLE,
                              .align = ISO_PAGE_CENTER},
              lines);
    set_lines(f, p, false, l->panel_width, note_pt, lines);
    put_lines(page,
              (iso_page_text){.x = middle,
                              .y = box->top + box->height + 0.7 * note,
                              .role = ISO_PAGE_NOTE,
                              .align = ISO_PAGE_CENTER},
              lines);
    break_lines(p->side, side_mm(f, l), l->title_pt, lines);
    put_lines(page,
              (iso_page_text){.x = box->left - ((double)count_lines(lines) - 0.4) * title,
                              .y = box->top + 0.5 * side_mm(f, l),
                              .role = ISO_PAGE_TITLE,
                              .align = ISO_PAGE_CENTER,
                              .upright = 1},
              lines);
}

/* Puts frames of one color around the inset, and around its part of the picture. */
static void put_frames(const iso_figure_panel *p, const iso_page_box *box, iso_page *page)
{
    const iso_page_pen pen = {"#e69f00", 0.8, 0};
    const iso_page_box mark = {box->left + p->mark[0] * box->width, box->top + p->mark[1] * box->height,
                               p->mark[2] * box->width, p->mark[3] * box->height};
    if (mark.width > 0)
        iso_page_put_rectangle(page, &mark, NULL, &pen);
    if (p->framed)
        iso_page_put_rectangle(page, box, NULL, &pen);
}

static iso_page_box panel_box(const iso_figure_sheet *f, const layout *l, const iso_figure_panel *p,
                              const iso_page *page)
{
    iso_page_box box = {l->left + (double)p->column * (l->panel_width + gap_mm), row_top(f, l, p->row), l->panel_width,
                        l->panel_height};
    if (f->is_pixel_per_dot)
        box.width = iso_page_dots_mm(page, p->a.width), box.height = iso_page_dots_mm(page, p->a.height);
    return box;
}

static void put_panel(const iso_figure_sheet *f, const layout *l, size_t i, iso_page *page)
{
    const iso_figure_panel *p = &f->panels[i];
    const iso_page_box box = panel_box(f, l, p, page);
    if (p->against)
        put_map(f, p, &box, page);
    else
        iso_page_put_picture(page, &box, &p->a);
    put_texts(f, l, p, &box, page);
    put_frames(p, &box, page);
    if (p->scale_bar)
        iso_page_put_scale_bar(page, &box, &p->a, p->mm_per_pixel);
}

/* ---- figure.csv: positions of all contents, for editing the script ---- */

/* Writes a cell; "-" for none, ';' for a comma. */
static void put_cell(FILE *csv, const char *s)
{
    if (!*s)
        fputs("-", csv);
    for (; *s; ++s)
        fputc(*s == ',' ? ';' : *s == '"' ? '\'' : *s, csv);
    fputc(',', csv);
}

static void put_row(const iso_figure_sheet *f, const layout *l, size_t i, const iso_page *page, FILE *csv)
{
    const iso_figure_panel *p = &f->panels[i];
    const iso_page_box box = panel_box(f, l, p, page);
    const double wide = iso_page_width(page), high = iso_page_height(page);
    const double bar_mm = p->scale_bar ? iso_page_scale_bar_mm(page, &box, &p->a, p->mm_per_pixel) : 0;
    char lines[128], bar[32] = "";
    const size_t times = iso_page_times(page, box.width, p->a.width);
    fprintf(csv, "%d,picture%zu.raw,%zu,%zu,%.6f,%.6f,%.6f,%.6f,", p->against ? 1 : 0, i, times * p->a.width,
            times * p->a.height, box.left / wide, (box.left + box.width) / wide, 1 - (box.top + box.height) / high,
            1 - box.top / high);
    set_lines(f, p, true, l->panel_width, l->title_pt, lines);
    put_cell(csv, lines);
    set_lines(f, p, false, l->panel_width, note_pt, lines);
    put_cell(csv, lines);
    break_lines(p->side, side_mm(f, l), l->title_pt, lines);
    put_cell(csv, lines);
    if (bar_mm > 0)
        iso_unit_text(bar_mm, 6, bar, sizeof bar);
    fprintf(csv, "%.6f,", bar_mm > 0 ? bar_mm / (p->mm_per_pixel * (double)p->a.width) : 0);
    put_cell(csv, bar);
    fprintf(csv, "%.6g,%.6g,%d,%.4f,%.4f\n", f->low, f->high, f->in_logs, wide * 96 / 25.4, high * 96 / 25.4);
}

static iso_status write_table(const iso_figure_sheet *f, const layout *l, const iso_page *page, iso_error *err)
{
    FREED char *path = iso_page_file(page, "figure.csv");
    FILE *csv = path ? fopen(path, "w") : NULL;
    iso_status status = csv ? ISO_OK : iso_fail(err, ISO_E_IO, "figure: figure.csv cannot be written");
    if (!csv)
        return status;
    fputs("kind,file,width,height,left,right,bottom,top,title,note,side,bar,bar_text,low,high,logs,figure_width,"
          "figure_height\n",
          csv);
    for (size_t i = 0; i < f->count; ++i)
        put_row(f, l, i, page, csv);
    return fclose(csv) == 0 ? status : iso_fail(err, ISO_E_IO, "figure: figure.csv cannot be written");
}

static iso_page_color_bar legend_bar(const iso_figure_sheet *f, const layout *l)
{
    return (iso_page_color_bar){l->legend, f->map, {f->low, f->high}, f->in_logs, l->legend_text};
}

/* ---- the figure ---- */

double iso_figure_round_up(double number)
{
    static const double steps[] = {1, 1.2, 1.5, 2, 2.5, 3, 4, 5, 6, 8};
    if (!(number > 0))
        return 1;
    const double decade = pow(10, floor(log10(number)));
    for (size_t i = 0; i < sizeof steps / sizeof *steps; ++i)
        if (steps[i] * decade >= number * (1 - 1e-9))
            return steps[i] * decade;
    return 10 * decade;
}

void iso_figure_describe(const iso_figure_sheet *f, FILE *caption)
{
    if (f->legend || first_map_row(f) == f->rows)
        return;
    fprintf(caption, " Colors of the maps: %s%.3g to %s%.3g, of linear light where 1 is white, and of opacity%s.",
            f->in_logs ? "10^" : "", f->low, f->in_logs ? "10^" : "", f->high,
            f->in_logs ? "" : "; at most 1 % of a map's pixels are beyond, in the last color");
}

iso_status iso_figure_panel_width(const iso_figure_sheet *sheet, double *width_mm, iso_error *err)
{
    layout l;
    const iso_status status = plan_layout(sheet, &l, err);
    *width_mm = l.panel_width;
    return status;
}

iso_status iso_figure_draw(const iso_figure_sheet *f, iso_page *page, iso_error *err)
{
    layout l;
    NEED(plan_layout(f, &l, err));
    iso_page_set_size(page, l.width, l.height + f->foot_mm);
    iso_page_set_text_pt(page, ISO_PAGE_TITLE, l.title_pt);
    iso_page_set_text_pt(page, ISO_PAGE_NOTE, note_pt);
    for (size_t i = 0; i < f->count; ++i)
        put_panel(f, &l, i, page);
    if (first_map_row(f) < f->rows) {
        const iso_page_color_bar bar = legend_bar(f, &l);
        iso_page_put_color_bar(page, &bar);
    }
    return write_table(f, &l, page, err);
}
