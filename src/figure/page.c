/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "figure/page.h"

#include <math.h>
#include <png.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/embed.h"
#include "base/file.h"
#include "base/status.h"
#include "compare/srgb.h"
#include "figure/page_text.h"
#include "report/gnuplot.h"

/* ---- the PNG ---- */

/* Composes the PNG of a page: pictures, and gnuplot's drawing over them. */

/* Pixels in sRGB, 3 bytes each, in a box of wide x high dots that starts at x, y. */
typedef struct iso_page_pixels {
    unsigned char *rgb;
    size_t width, height, x, y, wide, high;
} iso_page_pixels;

typedef struct canvas {
    size_t wide, high;
    unsigned char *rgb;
} canvas;

/* Computes the mean of the pixels that a dot covers; if a pixel covers whole dots, that pixel. */
static void sample(const iso_page_pixels *p, size_t x, size_t y, unsigned char rgb[3])
{
    const size_t left = x * p->width / p->wide, top = y * p->height / p->high;
    const size_t right = ((x + 1) * p->width + p->wide - 1) / p->wide,
                 bottom = ((y + 1) * p->height + p->high - 1) / p->high;
    for (size_t c = 0; c < 3; ++c) {
        size_t sum = 0;
        for (size_t v = top; v < bottom; ++v)
            for (size_t u = left; u < right; ++u)
                sum += p->rgb[3 * (v * p->width + u) + c];
        const size_t count = (right - left) * (bottom - top);
        rgb[c] = (unsigned char)((sum + count / 2) / count);
    }
}

static void put_pictures(canvas *c, const iso_page_pixels *pictures, size_t count)
{
    memset(c->rgb, 255, 3 * c->wide * c->high);
    for (size_t i = 0; i < count; ++i) {
        const iso_page_pixels *p = &pictures[i];
        for (size_t y = 0; y < p->high && p->y + y < c->high; ++y)
            for (size_t x = 0; x < p->wide && p->x + x < c->wide; ++x)
                sample(p, x, y, c->rgb + 3 * ((p->y + y) * c->wide + p->x + x));
    }
}

/* Blends a row of the drawing over the canvas; bytes under transparent dots stay unchanged. */
static void put_over(canvas *c, const unsigned char *rgba)
{
    for (size_t i = 0; i < c->wide * c->high; ++i) {
        const int alpha = rgba[4 * i + 3];
        for (size_t k = 0; k < 3; ++k)
            c->rgb[3 * i + k] = (unsigned char)((rgba[4 * i + k] * alpha + c->rgb[3 * i + k] * (255 - alpha) + 127) /
                                                255);
    }
}

/* Reads the file without libpng, which does not distinguish an unreadable file from one that is not a PNG. */
static iso_status read_overlay(const char *path, const canvas *c, unsigned char **rgba, iso_error *err)
{
    png_image png = {.version = PNG_IMAGE_VERSION};
    FREED char *bytes = NULL;
    size_t size;
    *rgba = NULL;
    iso_status status = iso_file_read(path, &bytes, &size, err);
    if (status == ISO_OK && !png_image_begin_read_from_memory(&png, bytes, size))
        status = iso_fail(err, ISO_E_FORMAT, "%s: %s", path, png.message);
    if (status != ISO_OK)
        return status;
    png.format = PNG_FORMAT_RGBA;
    if (png.width != c->wide || png.height != c->high)
        status = iso_fail(err, ISO_E_FORMAT, "%s: gnuplot drew %u x %u dots of %zu x %zu", path, png.width, png.height,
                          c->wide, c->high);
    else if (!(*rgba = malloc(PNG_IMAGE_SIZE(png))))
        status = iso_fail(err, ISO_E_MEMORY, "figure: out of memory");
    else if (!png_image_finish_read(&png, NULL, *rgba, 0, NULL))
        status = iso_fail(err, ISO_E_FORMAT, "%s: %s", path, png.message);
    png_image_free(&png);
    return status;
}

/* Replaces libpng's own messages. */
static void stop(png_structp png, png_const_charp text)
{
    (void)text;
    png_longjmp(png, 1);
}

static void pass_over(png_structp png, png_const_charp text)
{
    (void)png, (void)text;
}

/* Writes the rows. libpng's calls jump on errors, so no variable changes after setjmp(). */
static int write_rows(FILE *f, png_structp png, png_infop info, const canvas *c, double dpi)
{
    if (setjmp(png_jmpbuf(png)))
        return 0;
    const png_uint_32 per_meter = (png_uint_32)lrint(dpi / 0.0254);
    png_init_io(png, f);
    png_set_IHDR(png, info, (png_uint_32)c->wide, (png_uint_32)c->high, 8, PNG_COLOR_TYPE_RGB, PNG_INTERLACE_NONE,
                 PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    png_set_sRGB(png, info, PNG_sRGB_INTENT_PERCEPTUAL);
    png_set_pHYs(png, info, per_meter, per_meter, PNG_RESOLUTION_METER);
    png_write_info(png, info);
    for (size_t y = 0; y < c->high; ++y)
        png_write_row(png, c->rgb + 3 * y * c->wide);
    png_write_end(png, info);
    return 1;
}

static iso_status write_png(const char *path, const canvas *c, double dpi, iso_error *err)
{
    FILE *f = fopen(path, "wb");
    png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, NULL, stop, pass_over);
    png_infop info = png ? png_create_info_struct(png) : NULL;
    int whole = f && info && write_rows(f, png, info, c, dpi);
    png_destroy_write_struct(&png, &info);
    if (f && fclose(f) != 0)
        whole = 0;
    return whole ? ISO_OK : iso_fail(err, ISO_E_IO, "%s: cannot be written", path);
}

/* Replaces the transparent PNG of wide x high dots at path by an opaque one, over the pictures on white, with its
 * resolution. ISO_E_FORMAT: it has another size. */
static iso_status page_png_compose(const char *path, const iso_page_pixels *pictures, size_t count, size_t wide,
                                   size_t high, double dpi, iso_error *err)
{
    FREED unsigned char *rgb = malloc(3 * wide * high), *overlay = NULL;
    canvas c = {wide, high, rgb};
    NEED(rgb ? read_overlay(path, &c, &overlay, err) : iso_fail(err, ISO_E_MEMORY, "figure: out of memory"));
    put_pictures(&c, pictures, count);
    put_over(&c, overlay);
    return write_png(path, &c, dpi, err);
}

ISO_EMBED(iso_page_gp, "src/figure/page.gp");

static const char *const role_names[ISO_PAGE_ROLES] = {"title_pt", "note_pt"};
static const double mm_per_pt = 25.4 / 72, line_height = 1.25, least_panel_mm = 6;
enum { MOST_PICTURES = 512 };

/* Pieces of the script, in drawing order. */
typedef enum piece { PICTURES, PLOTS, OVERLAY, CAPTION, PIECES } piece;

/* The upper left corner of a panel that gets a letter. */
typedef struct panel {
    double left, top;
} panel;

struct iso_page {
    char *dir;
    double dpi, text_pt[ISO_PAGE_ROLES];
    size_t dots_wide, dots_high;
    FILE *files[PIECES];
    char *texts[PIECES];
    size_t sizes[PIECES];
    iso_page_pixels pictures[MOST_PICTURES]; /* at their positions on the page, in dots */
    size_t picture_count;
    bool lettered;
    panel panels[MOST_PICTURES];
    size_t panel_count;
    iso_status status;
    iso_error err;
};

/* ---- the page ---- */

iso_status iso_page_create(iso_page **page, const char *dir, double dpi, iso_error *err)
{
    iso_page *p = *page = calloc(1, sizeof *p);
    if (!p || !(p->dir = strdup(dir)))
        return iso_fail(err, ISO_E_MEMORY, "figure: out of memory");
    p->dpi = dpi;
    p->text_pt[ISO_PAGE_TITLE] = 8;
    p->text_pt[ISO_PAGE_NOTE] = 6.5;
    for (int i = 0; i < PIECES; ++i)
        if (!(p->files[i] = open_memstream(&p->texts[i], &p->sizes[i])))
            return iso_fail(err, ISO_E_MEMORY, "figure: out of memory");
    return ISO_OK;
}

void iso_page_destroy(iso_page *p)
{
    if (!p)
        return;
    for (int i = 0; i < PIECES; ++i) {
        if (p->files[i])
            fclose(p->files[i]);
        free(p->texts[i]);
    }
    for (size_t i = 0; i < p->picture_count; ++i)
        free(p->pictures[i].rgb);
    free(p->dir);
    free(p);
}

void iso_page_set_size(iso_page *p, double width_mm, double height_mm)
{
    p->dots_wide = iso_page_dots(p, width_mm);
    p->dots_high = iso_page_dots(p, height_mm);
}

double iso_page_dots_mm(const iso_page *p, size_t dots)
{
    return (double)dots * 25.4 / p->dpi;
}

double iso_page_width(const iso_page *p)
{
    return iso_page_dots_mm(p, p->dots_wide);
}

double iso_page_height(const iso_page *p)
{
    return iso_page_dots_mm(p, p->dots_high);
}

size_t iso_page_dots(const iso_page *p, double mm)
{
    return (size_t)fmax(1, floor(mm / 25.4 * p->dpi + 1e-6));
}

FILE *iso_page_caption(iso_page *p)
{
    return p->files[CAPTION];
}

char *iso_page_file(const iso_page *p, const char *name)
{
    return iso_path_join(p->dir, name);
}

/* ---- text ---- */

double iso_page_text_pt(const iso_page *p, iso_page_role role)
{
    return p->text_pt[role];
}

void iso_page_set_text_pt(iso_page *p, iso_page_role role, double pt)
{
    p->text_pt[role] = fmin(fmax(pt, 6), 9);
}

double iso_page_text_mm(const iso_page *p, iso_page_role role, const char *text)
{
    return iso_page_text_width_mm(text, strlen(text), p->text_pt[role]);
}

double iso_page_line_mm(const iso_page *p, iso_page_role role)
{
    return line_height * p->text_pt[role] * mm_per_pt;
}

void iso_page_put_text(iso_page *p, const iso_page_text *at, const char *text)
{
    static const char *const aligned[] = {"left", "center", "right"};
    if (!*text)
        return;
    FILE *gp = p->files[OVERLAY];
    fputs("set label ", gp);
    iso_page_text_put(gp, role_names[at->role], text);
    fprintf(gp, " at %.4f, %.4f %s %s noenhanced front font sized(%s) textcolor rgb '%s'\n", at->x, at->y,
            aligned[at->align], at->upright ? "rotate by 90" : "", role_names[at->role],
            at->color ? at->color : "#000000");
}

/* ---- pictures ---- */

static void fail(iso_page *p, iso_status status)
{
    TRY(p->status, status);
}

static size_t nearest_dot(const iso_page *p, double mm)
{
    return (size_t)lrint(fmax(mm, 0) / 25.4 * p->dpi);
}

size_t iso_page_times(const iso_page *p, double width_mm, size_t pixels)
{
    /* A panel that is a few dots too narrow must not draw each pixel twice. */
    return width_mm > 0 && pixels > 1 ? (size_t)fmax(1, ceil(width_mm / 25.4 * p->dpi / (double)pixels - 0.02)) : 1;
}

/* Enlarges pixels in both directions; takes the bytes. NULL: out of memory. */
static unsigned char *enlarge(unsigned char *rgb, size_t width, size_t height, size_t times)
{
    unsigned char *out = times > 1 ? malloc(3 * width * height * times * times) : rgb;
    if (out == rgb)
        return rgb;
    for (size_t y = 0; y < height * times && out; ++y)
        for (size_t x = 0; x < width * times; ++x)
            memcpy(out + 3 * (y * width * times + x), rgb + 3 * (y / times * width + x / times), 3);
    free(rgb);
    return out;
}

void iso_page_letter_panels(iso_page *p)
{
    p->lettered = true;
}

void iso_page_add_panel(iso_page *p, const iso_page_box *box)
{
    if (p->lettered && p->panel_count < MOST_PICTURES)
        p->panels[p->panel_count++] = (panel){box->left, box->top};
}

/* Allows a difference of some dots between panels of a row. */
static int in_reading_order(const void *a, const void *b)
{
    const panel *x = a, *y = b;
    const double before = fabs(x->top - y->top) > 2 ? x->top - y->top : x->left - y->left;
    return (before > 0) - (before < 0);
}

/* Puts letters on white squares, to be legible on any picture. */
static void put_letters(iso_page *p)
{
    const double line = iso_page_line_mm(p, ISO_PAGE_TITLE);
    qsort(p->panels, p->panel_count, sizeof *p->panels, in_reading_order);
    for (size_t i = 0; i < p->panel_count; ++i) {
        const panel *at = &p->panels[i];
        char text[8] = "(a)";
        if (i < 26)
            text[1] = (char)('a' + i);
        else
            snprintf(text, sizeof text, "(%c%c)", (char)('a' + i / 26 - 1), (char)('a' + i % 26));
        const double wide = iso_page_text_mm(p, ISO_PAGE_TITLE, text) + 0.8;
        iso_page_put_rectangle(p, &(iso_page_box){at->left, at->top, wide, line + 0.4}, "#ffffff", NULL);
        iso_page_put_text(p,
                          &(iso_page_text){.x = at->left + 0.5 * wide,
                                           .y = at->top + 0.5 * line + 0.2,
                                           .role = ISO_PAGE_TITLE,
                                           .align = ISO_PAGE_CENTER},
                          text);
    }
}

/* Puts pixels; takes the bytes. */
static void put_pixels(iso_page *p, const iso_page_box *box, unsigned char *rgb, size_t width, size_t height)
{
    char name[32];
    const size_t times = iso_page_times(p, box->width, width);
    if (rgb)
        rgb = enlarge(rgb, width, height, times);
    width *= times, height *= times;
    if (!rgb || p->picture_count == MOST_PICTURES) {
        free(rgb);
        fail(p, rgb ? iso_fail(&p->err, ISO_E_RANGE, "figure: more than %d pictures", (int)MOST_PICTURES)
                    : iso_fail(&p->err, ISO_E_MEMORY, "figure: no memory for %zu x %zu pixels", width, height));
        return;
    }
    iso_page_pixels *one = &p->pictures[p->picture_count];
    *one = (iso_page_pixels){rgb, width, height, nearest_dot(p, box->left), nearest_dot(p, box->top), width, height};
    if (box->width > 0)
        one->wide = nearest_dot(p, box->width), one->high = nearest_dot(p, box->height);
    if (iso_page_dots_mm(p, one->high) >= least_panel_mm)
        iso_page_add_panel(p, box);
    snprintf(name, sizeof name, "picture%zu.raw", p->picture_count++);
    FREED char *path = iso_page_file(p, name);
    if (path)
        fail(p, iso_file_write(path, rgb, 3 * width * height, &p->err));
    const double wide = (double)p->dots_wide, high = (double)p->dots_high;
    fprintf(
        p->files[PICTURES],
        "set lmargin at screen %.9f; set rmargin at screen %.9f; set tmargin at screen %.9f; set bmargin at screen %.9f\n"
        "set xrange [0:%zu]; set yrange [0:%zu]\n"
        "plot '%s' binary array=(%zu, %zu) flipy origin=(0.5, 0.5) format='%%uchar%%uchar%%uchar' using 1:2:3 with rgbimage\n",
        (double)one->x / wide, (double)(one->x + one->wide) / wide, 1 - (double)one->y / high,
        1 - (double)(one->y + one->high) / high, width, height, name, width, height);
}

void iso_page_put_colors(iso_page *p, const iso_page_box *box, const unsigned char *rgb, size_t width, size_t height)
{
    unsigned char *copy = malloc(3 * width * height + 1);
    if (copy)
        memcpy(copy, rgb, 3 * width * height);
    put_pixels(p, box, copy, width, height);
}

void iso_page_put_picture(iso_page *p, const iso_page_box *box, const iso_image *image)
{
    const size_t count = image->width * image->height;
    unsigned char *rgb = malloc(3 * count + 1);
    for (size_t i = 0; i < count && rgb; ++i)
        for (size_t c = 0; c < 3; ++c)
            rgb[3 * i + c] = (unsigned char)(iso_srgb_encode((double)image->rgba[4 * i + c]) * 255 + 0.5);
    put_pixels(p, box, rgb, image->width, image->height);
}

void iso_page_put_values(iso_page *p, const iso_page_box *box, const float *values, size_t width, size_t height,
                         const iso_colormap *map, const double range[2])
{
    unsigned char *rgb = malloc(3 * width * height + 1);
    for (size_t i = 0; i < width * height && rgb; ++i)
        iso_colormap_lookup(map, ((double)values[i] - range[0]) / (range[1] - range[0]), rgb + 3 * i);
    put_pixels(p, box, rgb, width, height);
}

/* ---- lines ---- */

static void put_pen(FILE *gp, const iso_page_pen *pen)
{
    fprintf(gp, "lc rgb '%s' lw pen(%g) %s", pen->color, pen->pt, pen->dashed ? "dt 2" : "dt 1");
}

void iso_page_put_line(iso_page *p, double x0, double y0, double x1, double y1, const iso_page_pen *pen)
{
    FILE *gp = p->files[OVERLAY];
    fprintf(gp, "set arrow from %.4f, %.4f to %.4f, %.4f nohead front ", x0, y0, x1, y1);
    put_pen(gp, pen);
    fputc('\n', gp);
}

void iso_page_put_rectangle(iso_page *p, const iso_page_box *b, const char *fill, const iso_page_pen *pen)
{
    FILE *gp = p->files[OVERLAY];
    fprintf(gp, "set object rectangle from %.4f, %.4f to %.4f, %.4f front ", b->left, b->top + b->height,
            b->left + b->width, b->top);
    if (fill)
        fprintf(gp, "fillcolor rgb '%s' fillstyle solid 1 %s", fill, pen ? "border " : "noborder");
    else
        fputs("fillstyle empty border ", gp);
    if (pen) {
        fprintf(gp, "lc rgb '%s' lw pen(%g)", pen->color, pen->pt);
    }
    fputc('\n', gp);
}

/* ---- plots ---- */

FILE *iso_page_plot_begin(iso_page *p, const iso_page_box *b)
{
    FILE *gp = p->files[PLOTS];
    const double wide = iso_page_width(p), high = iso_page_height(p);
    fprintf(
        gp,
        "reset\nset encoding utf8\nset lmargin at screen %.6f; set rmargin at screen %.6f; set tmargin at screen %.6f; "
        "set bmargin at screen %.6f\n"
        "set border 3 lc rgb '#444444' lw pen(0.5)\n"
        "set tics nomirror out scale 0.4 font note_font textcolor rgb '#222222'\n"
        "set format x ticks('%%g'); set format y ticks('%%g'); if (format ne 'tex') { set minussign }\n"
        "set xlabel font note_font; set ylabel font note_font; set key off\n",
        b->left / wide, (b->left + b->width) / wide, 1 - b->top / high, 1 - (b->top + b->height) / high);
    return gp;
}

double iso_page_tick_step(const double range[2], int most)
{
    const double least = (range[1] - range[0]) / most, decade = pow(10, floor(log10(least)));
    const double step = decade >= least       ? decade
                        : 2 * decade >= least ? 2 * decade
                        : 5 * decade >= least ? 5 * decade
                                              : 10 * decade;
    const bool has_two = floor(range[1] / step) > ceil(range[0] / step);
    return has_two || most > 20 ? step : iso_page_tick_step(range, most + 1);
}

void iso_page_plot_ticks(FILE *gp, char axis, const double range[2], int most)
{
    const double step = iso_page_tick_step(range, most);
    const char *before = "";
    fprintf(gp, "set %ctics (", axis);
    for (double i = ceil(range[0] / step - 1e-6); i * step <= range[1] + 1e-6 * step; ++i) {
        char text[64];
        iso_page_number(i * step, step, text);
        fputs(before, gp);
        iso_page_text_put(gp, "note_pt", text);
        fprintf(gp, " %.9g", i * step);
        before = ", ";
    }
    fputs(")\n", gp);
}

void iso_page_plot_end(iso_page *p)
{
    fputc('\n', p->files[PLOTS]);
}

/* ---- all formats ---- */

/* Returns the whole script, to be freed; NULL: out of memory. */
static char *write_script(const iso_page *p)
{
    char *script = NULL;
    size_t size = 0;
    FILE *gp = open_memstream(&script, &size);
    if (!gp)
        return NULL;
    fprintf(
        gp,
        "# SPDX-License-Identifier: MIT\n# A figure: pictures, plots above them, texts above these. Sizes of texts in "
        "points; lengths in millimeters.\nname = 'figure'\n"
        "width = %.4f; height = %.4f; dpi = %g\n",
        (double)p->dots_wide / p->dpi * 96, (double)p->dots_high / p->dpi * 96, p->dpi);
    for (int i = 0; i < ISO_PAGE_ROLES; ++i)
        fprintf(gp, "%s = %g\n", role_names[i], p->text_pt[i]);
    fputs("load 'style.gp'\nset datafile missing\n", gp);
    fputs(iso_page_gp, gp);
    fputs("set multiplot\nunset border; unset tics; unset key; unset grid\nif (!exists(\"overlay\")) {\n", gp);
    fwrite(p->texts[PICTURES], 1, p->sizes[PICTURES], gp);
    fputs("}\n", gp);
    fwrite(p->texts[PLOTS], 1, p->sizes[PLOTS], gp);
    fprintf(gp,
            "reset\nset encoding utf8\nunset border; unset tics; unset key; unset grid\n"
            "set lmargin at screen 0; set rmargin at screen 1; set tmargin at screen 1; set bmargin at screen 0\n"
            "set xrange [0:%.6f]; set yrange [%.6f:0]\n",
            iso_page_width(p), iso_page_height(p));
    fwrite(p->texts[OVERLAY], 1, p->sizes[OVERLAY], gp);
    fputs("plot -1 notitle\nunset multiplot\n", gp);
    if (fclose(gp) != 0) {
        free(script);
        return NULL;
    }
    return script;
}

static void remove_file(const iso_page *p, const char *name)
{
    FREED char *path = iso_page_file(p, name);
    if (path)
        remove(path);
}

static void remove_sources(const iso_page *p)
{
    char name[32];
    remove_file(p, "figure.gp");
    remove_file(p, "figure.csv");
    remove_file(p, "style.gp");
    for (size_t i = 0; i < p->picture_count; ++i) {
        snprintf(name, sizeof name, "picture%zu.raw", i);
        remove_file(p, name);
    }
}

static iso_status draw_png(const iso_page *p, iso_error *err)
{
    FREED char *path = iso_page_file(p, "figure.png");
    return path ? page_png_compose(path, p->pictures, p->picture_count, p->dots_wide, p->dots_high, p->dpi, err)
                : iso_fail(err, ISO_E_MEMORY, "figure: out of memory");
}

static iso_status write_caption(const iso_page *p, iso_error *err)
{
    FREED char *path = iso_page_file(p, "caption.txt"), *text = NULL;
    if (!path || asprintf(&text, "%.*s\n", (int)p->sizes[CAPTION], p->texts[CAPTION]) < 0)
        return iso_fail(err, ISO_E_MEMORY, "figure: out of memory");
    return iso_file_write(path, text, strlen(text), err);
}

static const struct {
    const char *name, *format; /* for users, and for gnuplot's scripts */
} forms_beside[] = {{"svg", "svg"}, {"png", "png"}, {"latex", "tex"}};
enum { FORMS = sizeof forms_beside / sizeof *forms_beside };

static bool is_named(const char *list, const char *name)
{
    const size_t n = strlen(name);
    for (const char *at = list; at; at = strchr(at, ',') ? strchr(at, ',') + 1 : NULL)
        if (strncmp(at, name, n) == 0 && (at[n] == 0 || at[n] == ','))
            return true;
    return !list;
}

iso_status iso_page_check_forms(const char *list, iso_error *err)
{
    for (const char *at = list; at; at = strchr(at, ',') ? strchr(at, ',') + 1 : NULL) {
        char word[16];
        bool known = false;
        snprintf(word, sizeof word, "%.*s", (int)strcspn(at, ","), at);
        for (size_t i = 0; i < FORMS; ++i)
            known |= !strcmp(word, forms_beside[i].name);
        if (!known && strcmp(word, "pdf") != 0)
            return iso_fail(err, ISO_E_USAGE, "--formats: \"%s\" is none of pdf, svg, png and latex", word);
    }
    return ISO_OK;
}

iso_status iso_page_finish(iso_page *p, const char *forms, int with_sources, iso_error *err)
{
    if (p->status != ISO_OK)
        return iso_fail(err, p->status, "%s", p->err.text);
    put_letters(p);
    for (int i = 0; i < PIECES; ++i)
        if (fflush(p->files[i]) != 0)
            return iso_fail(err, ISO_E_MEMORY, "figure: out of memory");
    FREED char *script = write_script(p);
    iso_status status = script ? ISO_OK : iso_fail(err, ISO_E_MEMORY, "figure: out of memory");
    TRY(status, iso_gnuplot_draw_script(p->dir, "figure", script, "pdf", err));
    for (size_t i = 0; i < FORMS && status == ISO_OK; ++i)
        if (is_named(forms, forms_beside[i].name))
            status = iso_gnuplot_draw_script(p->dir, "figure", script, forms_beside[i].format, err);
    if (status == ISO_OK && is_named(forms, "png"))
        status = draw_png(p, err);
    TRY(status, write_caption(p, err));
    if (!with_sources)
        remove_sources(p);
    return status;
}
