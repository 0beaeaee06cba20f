/* SPDX-License-Identifier: MIT */
/* page.c - the atlas as a page: one section per case with its pictures, volume, scene and commands. */
#define _GNU_SOURCE
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/embed.h"
#include "base/file.h"
#include "base/markup.h"
#include "atlas/atlas.h"
#include "compare/metrics.h"

ISO_EMBED(iso_atlas_head, "src/atlas/atlas.html");

/* A case, its result, and the layout of its section. */
typedef struct drawing {
    const iso_atlas_page *page;
    const iso_atlas_case *c;
    const iso_atlas_result *r;
    double largest; /* upper end of the difference maps' colors */
    size_t zoom[2]; /* column and row of the zoomed square's corner */
} drawing;

static char *file_of(const drawing *d, const char *folder, const char *suffix)
{
    char *path = NULL;
    return asprintf(&path, "%s/%s%s", folder, d->c->id, suffix) < 0 ? NULL : path;
}

/* ---- pictures ---- */

static double difference_at(const iso_image *a, const iso_image *b, size_t pixel)
{
    double d = 0;
    for (size_t c = 4 * pixel; c < 4 * pixel + 4; ++c)
        d = fmax(d, fabs((double)a->rgba[c] - (double)b->rgba[c]));
    return d;
}

/* Returns the detail in a square of the right picture: the deviation of its pixels from their mean. */
static double structure(const iso_image *image, size_t x, size_t y)
{
    double mean = 0, sum = 0;
    for (int pass = 0; pass < 2; ++pass)
        for (size_t i = 0; i < ISO_ATLAS_ZOOM * ISO_ATLAS_ZOOM; ++i) {
            double v = (double)image->rgba[4 * ((y + i / ISO_ATLAS_ZOOM) * image->width + x + i % ISO_ATLAS_ZOOM)];
            if (pass == 0)
                mean += v / (ISO_ATLAS_ZOOM * ISO_ATLAS_ZOOM);
            else
                sum += fabs(v - mean);
        }
    return sum;
}

/* Finds the square with a large error in the failure and a small one in the fallback; ties go to edges. */
static void find_zoom(drawing *d)
{
    const iso_image *right = &d->r->images[ISO_ATLAS_RIGHT];
    double best = -INFINITY;
    for (size_t y = 0; y + ISO_ATLAS_ZOOM <= right->height; y += 4)
        for (size_t x = 0; x + ISO_ATLAS_ZOOM <= right->width; x += 4) {
            double sum = 0.02 * structure(right, x, y);
            for (size_t i = 0; i < ISO_ATLAS_ZOOM * ISO_ATLAS_ZOOM; ++i) {
                size_t pixel = (y + i / ISO_ATLAS_ZOOM) * right->width + x + i % ISO_ATLAS_ZOOM;
                sum += difference_at(right, &d->r->images[ISO_ATLAS_FAILURE], pixel) -
                       difference_at(right, &d->r->images[ISO_ATLAS_FALLBACK], pixel);
            }
            if (sum > best) {
                best = sum;
                d->zoom[0] = x;
                d->zoom[1] = y;
            }
        }
}

/* Maps t in [0, 1] to a color from dark to bright, in linear light as images are. */
static void paint(double t, float rgba[4])
{
    static const double stops[5][3] = {{8, 8, 24}, {72, 20, 110}, {176, 44, 104}, {244, 126, 60}, {252, 246, 190}};
    double at = fmin(fmax(t, 0), 1) * 4;
    size_t i = at < 3 ? (size_t)at : 3;
    for (size_t c = 0; c < 3; ++c) {
        double s = (stops[i][c] + (at - (double)i) * (stops[i + 1][c] - stops[i][c])) / 255;
        rgba[c] = (float)(s <= 0.04045 ? s / 12.92 : pow((s + 0.055) / 1.055, 2.4));
    }
    rgba[3] = 1;
}

static iso_status save_difference(const drawing *d, iso_atlas_which which, iso_error *err)
{
    const iso_image *right = &d->r->images[ISO_ATLAS_RIGHT];
    OWNED(iso_image) map = {0};
    NEED(iso_image_create(&map, right->width, right->height, err));
    for (size_t i = 0; i < right->width * right->height; ++i)
        paint(difference_at(right, &d->r->images[which], i) / d->largest, map.rgba + 4 * i);
    FREED char *path = file_of(d, d->page->dir,
                               which == ISO_ATLAS_FAILURE ? "-failure-difference.png" : "-fallback-difference.png");
    return path ? iso_image_save_png(&map, path, 1, err) : iso_fail(err, ISO_E_MEMORY, "out of memory");
}

static iso_status save_picture(const drawing *d, iso_atlas_which which, const char *type, iso_error *err)
{
    FREED char *path = NULL;
    if (asprintf(&path, "%s/%s-%s.%s", d->page->dir, d->c->id, iso_atlas_names[which], type) < 0)
        return iso_fail(err, ISO_E_MEMORY, "out of memory");
    const iso_image *image = &d->r->images[which];
    return strcmp(type, "png") == 0 ? iso_image_save_png(image, path, 1, err)
                                    : iso_image_save_exr(image, path, NULL, err);
}

static iso_status save_pictures(drawing *d, iso_error *err)
{
    iso_metrics m;
    iso_status status = iso_metrics_measure(&d->r->images[ISO_ATLAS_RIGHT], &d->r->images[ISO_ATLAS_FAILURE], &m, err);
    d->largest = status == ISO_OK && m.p99_abs > 0 ? m.p99_abs : 1;
    find_zoom(d);
    for (int w = 0; w < ISO_ATLAS_WAYS && status == ISO_OK; ++w) {
        status = save_picture(d, (iso_atlas_which)w, "png", err);
        TRY(status, save_picture(d, (iso_atlas_which)w, "exr", err));
        if (status == ISO_OK && w != ISO_ATLAS_RIGHT)
            status = save_difference(d, (iso_atlas_which)w, err);
    }
    return status;
}

static iso_status save_scene(const drawing *d, iso_error *err)
{
    FREED char *volume = file_of(d, d->page->dir, ".nrrd"), *scene = file_of(d, d->page->dir, ".scene.json");
    json_auto_t *json = iso_atlas_scene_to_json(&d->c->scene, d->c->title);
    OWNED(iso_volume) v = {0};
    NEED_MEMORY(volume && scene && json, err, "out of memory");
    NEED(iso_atlas_volume(&d->c->scene, &v, err));
    NEED(iso_volume_save(&v, volume, true, err));
    return iso_scene_save_json(json, scene, err);
}

/* ---- commands ---- */

/* Writes a word of a command, quoted for the shell. */
static void put_word(FILE *f, const char *folder, const char *rest)
{
    bool plain = strspn(folder, "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789._/+-") ==
                 strlen(folder);
    if (!plain)
        fputc('\'', f);
    for (const char *s = folder; *s; ++s)
        *s == '\'' ? fputs("'\\''", f) : fputc(*s, f);
    fputs(rest, f);
    if (!plain)
        fputc('\'', f);
}

/* Writes the path of one of the case's files as one word. */
static void put_file(FILE *f, const drawing *d, const char *suffix)
{
    char *rest = NULL;
    if (asprintf(&rest, "/%s%s", d->c->id, suffix) >= 0)
        put_word(f, d->page->name, rest);
    free(rest);
}

/* Returns the commands from volume and scene to the figure under the picture; none if no option produces it. */
static char *commands_of(const drawing *d, iso_atlas_which which)
{
    const iso_atlas_way *way = &d->c->ways[which];
    char *text = NULL;
    size_t size = 0;
    FILE *f = way->fault || d->c->draw ? NULL : open_memstream(&text, &size);
    if (!f)
        return NULL;
    const char *id = d->c->id, *name = iso_atlas_names[which];
    if (way->build) {
        fputs("isoshade build ", f);
        put_file(f, d, ".nrrd");
        fprintf(f, " %s -o %s-%s.iso\n", way->build, id, name);
    }
    fputs("isoshade render ", f);
    if (way->build)
        fprintf(f, "%s-%s.iso", id, name);
    else
        put_file(f, d, ".nrrd");
    fputs(" --scene ", f);
    put_file(f, d, ".scene.json");
    fprintf(f, " --with reference --quadrature midpoint%s%s -o %s-%s.exr\n", way->render ? " " : "",
            way->render ? way->render : "", id, name);
    fputs("isoshade compare ", f);
    put_file(f, d, "-right.exr");
    fprintf(f, " %s-%s.exr --max-rmse %g\n", id, name, d->c->fallback_at_most);
    fclose(f);
    return text;
}

static char *case_command(const drawing *d)
{
    char *text = NULL;
    return asprintf(&text, "isoshade atlas --case %s -o %s", d->c->id, d->c->id) < 0 ? NULL : text;
}

/* ---- the section ---- */

/* Writes commands as HTML; their words do not break at hyphens. */
static void put_advice(FILE *html, const char *text)
{
    for (const char *s = text; *s;) {
        char word[128];
        size_t n = strcspn(s, " ");
        snprintf(word, sizeof word, "%.*s", (int)n, s);
        fputs(s == text ? "<code><span>" : " <span>", html);
        iso_markup_put(html, word);
        fputs("</span>", html);
        s += n + strspn(s + n, " ");
    }
    fputs("</code>", html);
}

/* Writes a picture with the frame of its enlarged square, or that square. */
static void put_picture(FILE *html, const drawing *d, const char *suffix, bool zoomed)
{
    const double unit = 100.0 / ISO_ATLAS_PIXELS, scale = (double)ISO_ATLAS_PIXELS / ISO_ATLAS_ZOOM;
    const double left = unit * (double)d->zoom[0], top = unit * (double)d->zoom[1];
    fprintf(html, "<div class=\"%s\"><img src=\"%s%s.png\" alt=\"%s%s\"", zoomed ? "zoom" : "whole", d->c->id, suffix,
            d->c->title, zoomed ? ", zoomed in" : "");
    if (zoomed)
        fprintf(html, " style=\"width:%g%%;left:%g%%;top:%g%%\"></div>", 100 * scale, -left * scale, -top * scale);
    else
        fprintf(html, "><span style=\"left:%g%%;top:%g%%;width:%g%%;height:%g%%\"></span></div>", left, top,
                100 / scale, 100 / scale);
}

static void put_pictures(FILE *html, const drawing *d)
{
    static const char *const suffixes[] = {"-right", "-failure", "-fallback", "-failure-difference",
                                           "-fallback-difference"};
    const iso_atlas_way *ways = d->c->ways;
    fputs("<div class=\"grid\">\n<h3>right</h3><h3 class=\"bad\">the failure</h3><h3 class=\"good\">the fallback</h3>"
          "<h3>difference, failure</h3><h3>difference, fallback</h3>\n",
          html);
    for (size_t zoomed = 0; zoomed < 2; ++zoomed)
        for (size_t i = 0; i < sizeof suffixes / sizeof *suffixes; ++i)
            put_picture(html, d, suffixes[i], zoomed);
    fprintf(html, "\n<p>%s</p><p>%s<b class=\"bad\">%.3g</b></p><p>%s<b class=\"good\">%.3g</b></p>",
            ways[ISO_ATLAS_RIGHT].what, ways[ISO_ATLAS_FAILURE].what, d->r->values[ISO_ATLAS_FAILURE],
            ways[ISO_ATLAS_FALLBACK].what, d->r->values[ISO_ATLAS_FALLBACK]);
    fprintf(html, "<div class=\"legend\"><i></i><span>0</span><span>%.2g%s</span></div></div>\n", d->largest,
            d->largest < 1 ? " of 1, and more" : "");
}

static void put_section(FILE *html, const drawing *d, const char *command)
{
    const iso_atlas_case *c = d->c;
    fprintf(html, "<section id=\"%s\"%s><h2>%s</h2>\n<p>%s <em>What to see:</em> %s</p>\n", c->id,
            iso_atlas_is_valid(c, d->r) ? "" : " class=\"fallen\"", c->title, c->cause, c->look);
    put_pictures(html, d);
    fprintf(html, "<p class=\"figure\"><b>%.3g</b> and <b>%.3g</b>: %s. Failure: %g or more; corrected: %g or less.",
            d->r->values[ISO_ATLAS_FAILURE], d->r->values[ISO_ATLAS_FALLBACK], iso_atlas_measure(c),
            c->failure_at_least, c->fallback_at_most);
    if (c->scene.field)
        fprintf(html, " Volume of %zu x %zu x %zu voxels.", c->scene.size[0], c->scene.size[1], c->scene.size[2]);
    fputs("</p>\n<p class=\"advice\"><b>Fallback</b> ", html);
    put_advice(html, c->advice);
    fputs("</p>\n<details><summary>Commands</summary><pre>", html);
    iso_markup_put(html, command);
    fputc('\n', html);
    for (int w = ISO_ATLAS_FAILURE; w < ISO_ATLAS_WAYS; ++w) {
        char *lines = commands_of(d, (iso_atlas_which)w);
        if (lines) {
            fprintf(html, "\n# the %s\n", iso_atlas_names[w]);
            iso_markup_put(html, lines);
        } else if (c->ways[w].fault) {
            fprintf(html, "\n# the %s is planted: no option produces it\n", iso_atlas_names[w]);
        }
        free(lines);
    }
    fputs("</pre></details></section>\n", html);
}

static void add_object(json_t *cases, const drawing *d, const char *command)
{
    const iso_atlas_case *c = d->c;
    json_t *object = json_pack("{s:s, s:s, s:s, s:s, s:s, s:s, s:f, s:f, s:s, s:f, s:f, s:s, s:b, s:s}", "id", c->id,
                               "title", c->title, "cause", c->cause, "look", c->look, "measure", iso_atlas_measure(c),
                               "failure", c->ways[ISO_ATLAS_FAILURE].what, "failure_value",
                               d->r->values[ISO_ATLAS_FAILURE], "failure_at_least", c->failure_at_least, "fallback",
                               c->ways[ISO_ATLAS_FALLBACK].what, "fallback_value", d->r->values[ISO_ATLAS_FALLBACK],
                               "fallback_at_most", c->fallback_at_most, "advice", c->advice, "stands",
                               iso_atlas_is_valid(c, d->r), "command", command);
    static const char *const keys[ISO_ATLAS_WAYS] = {NULL, "failure_commands", "fallback_commands"};
    for (int w = ISO_ATLAS_FAILURE; w < ISO_ATLAS_WAYS; ++w) {
        char *lines = commands_of(d, (iso_atlas_which)w);
        if (lines)
            json_object_set_new(object, keys[w], json_string(lines));
        free(lines);
    }
    json_array_append_new(cases, object);
}

iso_status iso_atlas_page_add(iso_atlas_page *page, const iso_atlas_case *c, const iso_atlas_result *r, iso_error *err)
{
    drawing d = {.page = page, .c = c, .r = r};
    FREED char *command = case_command(&d);
    NEED_MEMORY(command, err, "out of memory");
    if (c->scene.field)
        NEED(save_scene(&d, err));
    NEED(save_pictures(&d, err));
    put_section(page->html, &d, command);
    add_object(page->cases, &d, command);
    return ISO_OK;
}

/* ---- head and foot ---- */

void iso_atlas_page_begin(FILE *html, const json_t *cases)
{
    json_t *c;
    size_t i;
    fputs(iso_atlas_head, html);
    fputs("<table><thead><tr><th>case</th><th>failure</th><th>corrected</th><th>fallback</th></tr></thead><tbody>\n",
          html);
    json_array_foreach (cases, i, c) {
        fprintf(html, "<tr><td><a href=\"#%s\">%s</a></td><td>%.3g</td><td>%.3g</td><td>",
                json_string_value(json_object_get(c, "id")), json_string_value(json_object_get(c, "title")),
                json_number_value(json_object_get(c, "failure_value")),
                json_number_value(json_object_get(c, "fallback_value")));
        put_advice(html, json_string_value(json_object_get(c, "advice")));
        fputs("</td></tr>\n", html);
    }
    fputs("</tbody></table>\n", html);
}

void iso_atlas_page_end(FILE *html)
{
    fputs("</main></body></html>\n", html);
}
