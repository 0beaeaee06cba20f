/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "report/figure_draw.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/embed.h"
#include "base/file.h"
#include "report/gnuplot.h"
#include "compare/srgb.h"

ISO_EMBED(iso_figure_gp, "src/report/figure.gp");

/* Print sizes; journals ask for 6 points at least. Titles become smaller before words stand in each other's way. */
static const double largest_title_pt = 8, smallest_pt = 6, note_pt = 6.2;
static const double mm_per_pt = 25.4 / 72, line_height = 1.25;
static const double narrowest_mm = 8, widest_mm = 60, gap_mm = 1.5;

/* ---- text ---- */

/* The width of a letter of DejaVu Sans in em, in a few classes and rather too wide. */
static double letter_em(char c)
{
    if (strchr("ijl.,:;'|!", c))
        return 0.34;
    if (strchr(" ft-()/I", c))
        return 0.4;
    if (strchr("mwMWOQ%@+=", c))
        return 0.95;
    return c >= 'A' && c <= 'Z' ? 0.72 : 0.64;
}

static double text_width_mm(const char *s, size_t bytes, double pt)
{
    double em = 0;
    for (size_t i = 0; i < bytes; ++i)
        if ((unsigned char)s[i] >= 0xc0) /* the first byte of what is no ASCII: a minus sign */
            em += 0.84;
        else if ((unsigned char)s[i] < 0x80)
            em += letter_em(s[i]);
    return em * pt * mm_per_pt;
}

/* The longest of the words between blanks. */
static double word_width_mm(const char *text, double pt)
{
    double widest = 0;
    for (const char *s = text; *s; s += strspn(s, " |")) {
        size_t n = strcspn(s, " |");
        widest = fmax(widest, text_width_mm(s, n, pt));
        s += n;
    }
    return widest;
}

/* In one line, a '|' becoming two blanks. */
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

/* Text as lines at most room_mm wide, a '|' between them: broken at each '|', and at blanks where that is still too wide.
 * Returns the count of lines. */
static size_t break_lines(const char *text, double room_mm, double pt, char out[128])
{
    size_t count = text[0] != 0, line = 0, blank = 0; /* where the line begins; the last blank in it, 0: none */
    snprintf(out, 128, "%s", text);
    for (size_t i = 0; out[i]; ++i) {
        if (out[i] == '|' || (blank > line && text_width_mm(out + line, i + 1 - line, pt) > room_mm)) {
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

/* A cell of the CSV; "-" for none. gnuplot knows no commas within cells: they stand as ';', and figure.gp turns them back. */
static void put_text(FILE *csv, const char *s)
{
    if (!*s)
        fputs("-", csv);
    for (; *s; ++s)
        fputc(*s == ',' ? ';' : *s == '"' ? '\'' : *s, csv);
    fputc(',', csv);
}

/* ---- where things stand: millimetres from the left and the top ---- */

typedef struct box {
    double left, top, width, height;
} box;

typedef struct layout {
    double panel_width, panel_height, left, right, head, width, height;
    double title_pt;
    box legend;
    char legend_text[128];
} layout;

static const char legend_words[] = "difference,|1 = white";
static const double legend_bar_mm = 2.2;

static const char *text_of(const iso_figure_panel *p, bool title)
{
    return title ? p->title : p->note;
}

/* Do the titles, or the notes, of a row each fit in one line? They look alike: else all are broken. */
static bool fit_in_one(const iso_figure_sheet *f, size_t row, bool titles, double room_mm, double pt)
{
    char line[128];
    for (size_t i = 0; i < f->count; ++i) {
        join(text_of(&f->panels[i], titles), line);
        if (f->panels[i].row == row && text_width_mm(line, strlen(line), pt) > room_mm)
            return false;
    }
    return true;
}

/* A panel's title or note as it stands. Returns the count of lines. */
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

/* Below a row: its notes, or a gap. */
static double row_foot(const iso_figure_sheet *f, const layout *l, size_t row)
{
    return gap_mm + lines_mm(most_lines(f, row, false, l->panel_width, note_pt), note_pt);
}

static double row_top(const iso_figure_sheet *f, const layout *l, size_t row)
{
    double y = l->head;
    for (size_t r = 0; r < row; ++r)
        y += l->panel_height + row_foot(f, l, r);
    return y;
}

/* How high the text on the left may be: its rows. */
static double side_mm(const iso_figure_sheet *f, const layout *l)
{
    return (double)f->rows_a_side * (l->panel_height + gap_mm) - gap_mm;
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
    for (size_t i = 0; i < f->count; ++i)
        if (f->panels[i].against)
            return f->panels[i].row;
    return f->rows;
}

/* gnuplot writes exponents at 0.8 of the size. */
static double tick_pt(const iso_figure_sheet *f)
{
    return f->in_logs ? smallest_pt / 0.8 : note_pt;
}

static double legend_ticks_mm(const iso_figure_sheet *f)
{
    return 0.5 + (f->in_logs ? text_width_mm("1000", 4, tick_pt(f)) : text_width_mm("0.000", 5, tick_pt(f)));
}

static double legend_words_mm(const layout *l, char out[128])
{
    return lines_mm(break_lines(legend_words, 0.95 * l->panel_height, note_pt, out), note_pt) + 0.8;
}

/* The legend stands in the empty place before the first maps, or on the right of them. */
static void place_legend(const iso_figure_sheet *f, layout *l, bool inside)
{
    const double top = row_top(f, l, first_map_row(f)), words = legend_words_mm(l, l->legend_text);
    const double wide = words + legend_bar_mm + legend_ticks_mm(f);
    double x = inside ? l->left + fmax(0.5 * (l->panel_width - wide), 0) : l->width - l->right + gap_mm;
    l->legend = (box){x + words, top + 0.04 * l->panel_height, legend_bar_mm, 0.92 * l->panel_height};
}

/* Panels as wide as the sheet has room for, texts around them. */
static void size_panels(const iso_figure_sheet *f, layout *l, bool inside, double narrower)
{
    const iso_image *first = &f->panels[0].a;
    const double columns = (double)f->columns, gaps = (columns - 1) * gap_mm;
    char lines[128];
    /* The height of the panels says how many lines the upright texts have, and these leave less width: until both agree. */
    for (size_t sides = 0, wanted = 1; wanted > sides; wanted = side_lines(f, l)) {
        sides = wanted;
        l->left = 0.5 + lines_mm(sides, l->title_pt) + 0.5;
        l->right = inside || first_map_row(f) == f->rows
                       ? 0.5
                       : gap_mm + legend_words_mm(l, lines) + legend_bar_mm + legend_ticks_mm(f) + 0.5;
        l->panel_width = fmin((f->width_mm - l->left - l->right - gaps) / columns, widest_mm) * narrower;
        l->panel_height = l->panel_width * (double)first->height / (double)first->width;
    }
    l->width = l->left + columns * l->panel_width + gaps + l->right;
    l->head = 0.5 + lines_mm(most_lines(f, 0, true, l->panel_width, l->title_pt), l->title_pt) + 0.8;
    l->height = row_top(f, l, f->rows);
}

/* The widest word of any text beside the room for it: 1 and less fit. */
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
    if (inside && legend_words_mm(l, lines) + legend_bar_mm + legend_ticks_mm(f) > l->panel_width)
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
                        "figure: %zu columns and %zu rows do not fit into %g x %g mm with texts of %g points: they "
                        "need %.1f times that",
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

/* The panel's pixels, each repeated `times` in both directions; row 0 on top. */
static iso_status write_pixels(const iso_figure_sheet *f, const iso_figure_panel *p, size_t times, const char *path,
                               iso_error *err)
{
    size_t width = p->a.width, height = p->a.height, bytes_of_one = p->against ? sizeof(float) : 3;
    size_t size = width * times * height * times * bytes_of_one;
    unsigned char *out = malloc(size), *at = out;
    if (!out)
        return iso_fail(err, ISO_E_MEMORY, "%s: no memory for %zu bytes", path, size);
    for (size_t y = 0; y < height * times; ++y)
        for (size_t x = 0; x < width * times; ++x, at += bytes_of_one) {
            size_t i = y / times * width + x / times;
            float value = p->against ? (float)difference_at(f, p, i) : 0;
            if (p->against)
                memcpy(at, &value, sizeof value);
            else
                for (size_t c = 0; c < 3; ++c)
                    at[c] = (unsigned char)(iso_srgb_encode((double)p->a.rgba[4 * i + c]) * 255 + 0.5);
        }
    iso_status status = iso_file_write(path, out, size, err);
    free(out);
    return status;
}

/* ---- the scale bar ---- */

double iso_figure_bar_mm(double width_mm)
{
    double decade = pow(10, floor(log10(width_mm / 3)));
    return width_mm / 3 >= 5 * decade ? 5 * decade : width_mm / 3 >= 2 * decade ? 2 * decade : decade;
}

/* Dark on what is bright in the corner that the bar stands in, bright on what is dark. */
static const char *bar_color(const iso_image *image)
{
    double sum = 0;
    size_t count = 0;
    for (size_t y = image->height * 4 / 5; y < image->height; ++y)
        for (size_t x = 0; x < (image->width + 1) / 2; ++x, ++count)
            sum += iso_srgb_encode((double)image->rgba[4 * (y * image->width + x) + 1]);
    return sum > 0.5 * (double)count ? "#000000" : "#ffffff";
}

/* ---- figure.csv ---- */

static iso_status write_panel(const iso_figure_sheet *f, const layout *l, size_t i, const char *dir, FILE *csv,
                              iso_error *err)
{
    const iso_figure_panel *p = &f->panels[i];
    const double px = 96 / 25.4, x = l->left + (double)p->column * (l->panel_width + gap_mm), y = row_top(f, l, p->row);
    /* Some dots too few, where the last text moved a margin, are no reason to draw each pixel twice. */
    const size_t times = (size_t)ceil(f->dpi * l->panel_width / 25.4 / (double)p->a.width - 0.02);
    char file[32], lines[128], bar_text[32] = "";
    snprintf(file, sizeof file, "panel%zu.raw", i);
    char *path = iso_path_join(dir, file);
    iso_status status = path ? write_pixels(f, p, times, path, err)
                             : iso_fail(err, ISO_E_MEMORY, "figure: out of memory");
    free(path);
    double bar = 0;
    if (p->scale_bar && p->mm_per_pixel > 0) {
        double width_mm = p->mm_per_pixel * (double)p->a.width, length = iso_figure_bar_mm(width_mm);
        bar = length / width_mm;
        snprintf(bar_text, sizeof bar_text, "%g mm", length);
    }
    fprintf(csv, "%d,%s,%zu,%zu,%.6f,%.6f,%.6f,%.6f,", p->against ? 1 : 0, file, p->a.width * times,
            p->a.height * times, x / l->width, (x + l->panel_width) / l->width, 1 - (y + l->panel_height) / l->height,
            1 - y / l->height);
    set_lines(f, p, true, l->panel_width, l->title_pt, lines);
    put_text(csv, lines);
    set_lines(f, p, false, l->panel_width, note_pt, lines);
    put_text(csv, lines);
    break_lines(p->side, side_mm(f, l), l->title_pt, lines);
    put_text(csv, lines);
    fprintf(csv, "%.6f,", bar);
    put_text(csv, bar_text);
    fprintf(csv, "%.6g,%.6g,%d,%.1f,%.1f,%s,%.6f\n", f->low, f->high, f->in_logs, l->width * px, l->height * px,
            bar_color(&p->a), 1 - (y + 0.5 * side_mm(f, l)) / l->height);
    return status;
}

/* The panels, and in figure.gp's own words what they share. */
static iso_status write_panels(const iso_figure_sheet *f, const char *dir, FILE *csv, FILE *script, iso_error *err)
{
    layout l;
    iso_status status = plan_layout(f, &l, err);
    if (status != ISO_OK)
        return status;
    fputs(
        "kind,file,width,height,left,right,bottom,top,title,note,side,bar,bar_text,low,high,logs,figure_width,figure_height,"
        "bar_color,side_middle\n",
        csv);
    for (size_t i = 0; i < f->count && status == ISO_OK; ++i)
        status = write_panel(f, &l, i, dir, csv, err);
    fprintf(script,
            "# Print sizes in points, and where the colour legend stands, as parts of the figure.\n"
            "title_pt = %g; note_pt = %g; tick_pt = %g\n",
            l.title_pt, note_pt, tick_pt(f));
    fprintf(script, "legend_left = %.6f; legend_bottom = %.6f; legend_width = %.6f; legend_height = %.6f\n",
            l.legend.left / l.width, 1 - (l.legend.top + l.legend.height) / l.height, l.legend.width / l.width,
            l.legend.height / l.height);
    fprintf(script, "legend_text = '%s'\n", l.legend_text);
    fputs(iso_figure_gp, script);
    return status;
}

void iso_figure_describe(const iso_figure_sheet *f, FILE *caption)
{
    for (size_t i = 0; i < f->count; ++i)
        if (f->panels[i].scale_bar && f->panels[i].mm_per_pixel > 0)
            fprintf(caption, " Scale bar: %g mm, in the plane through the centre of the volume.",
                    iso_figure_bar_mm(f->panels[i].mm_per_pixel * (double)f->panels[i].a.width));
    fprintf(caption, " Colours of the maps: %s%.3g to %s%.3g, of linear light where 1 is white, and of opacity%s.\n",
            f->in_logs ? "10^" : "", f->low, f->in_logs ? "10^" : "", f->high,
            f->in_logs ? "" : "; at most 1 % of a map's pixels are beyond and drawn as the last colour");
}

iso_status iso_figure_panel_width(const iso_figure_sheet *sheet, double *width_mm, iso_error *err)
{
    layout l;
    const iso_status status = plan_layout(sheet, &l, err);
    *width_mm = l.panel_width;
    return status;
}

/* What the figure was drawn from. */
static void remove_sources(const char *dir, size_t panels)
{
    const char *const names[] = {"figure.csv", "figure.gp", "style.gp"};
    char name[32];
    for (size_t i = 0; i < panels + sizeof names / sizeof *names; ++i) {
        snprintf(name, sizeof name, "panel%zu.raw", i);
        char *path = iso_path_join(dir, i < panels ? name : names[i - panels]);
        if (path)
            remove(path);
        free(path);
    }
}

iso_status iso_figure_draw(const iso_figure_sheet *sheet, const char *dir, iso_error *err)
{
    char *csv = NULL, *script = NULL;
    size_t csv_size = 0, script_size = 0;
    FILE *csv_file = open_memstream(&csv, &csv_size), *script_file = open_memstream(&script, &script_size);
    iso_status status = csv_file && script_file ? write_panels(sheet, dir, csv_file, script_file, err)
                                                : iso_fail(err, ISO_E_MEMORY, "figure: out of memory");
    if (csv_file)
        fclose(csv_file);
    if (script_file)
        fclose(script_file);
    if (status == ISO_OK)
        status = iso_gnuplot_draw(dir, "figure", csv, script, "pdf", err);
    if (status == ISO_OK)
        status = iso_gnuplot_draw(dir, "figure", csv, script, "svg", err);
    if (!sheet->with_sources)
        remove_sources(dir, sheet->count);
    free(csv);
    free(script);
    return status;
}
