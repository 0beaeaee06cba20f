/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "view/viewer.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/base64.h"
#include "base/embed.h"
#include "base/file.h"
#include "base/markup.h"
#include "view/contents.h"

/* ---- the parts of the page ---------------------------------------------------------------------------------------- */

ISO_EMBED(iso_viewer_html, "src/view/view.html");
ISO_EMBED(iso_viewer_css, "src/view/view.css");

/* clang-format off */
/* The scripts, each of which depends on the ones before. */
#define SCRIPTS(X) \
    X(vectors) X(arrays) X(camera) X(transfer) X(adapt) X(occupancy) X(context) X(textures) X(bricks) X(caster) \
    X(frames) X(state) X(orbit) X(planes) X(overlay) X(outline) X(editor) X(save) X(controls) X(pick) X(slices) \
    X(open_samples) X(open_nrrd) X(open_nifti) X(open) X(start)
#define EMBED_SCRIPT(name) ISO_EMBED(iso_viewer_##name##_js, "src/view/" #name ".js");
SCRIPTS(EMBED_SCRIPT)
#define SCRIPT_ENTRY(name) iso_viewer_##name##_js,
static const char *const scripts[] = {SCRIPTS(SCRIPT_ENTRY)};

/* The shaders; most are the ray caster's own, which gl_program.c also embeds: one text in the program, with two names. */
#define CASTER "src/render/gl/shaders/"
#define SHADERS(X) \
    X(code_decode_glsl, "src/encode/", "code_decode.h") \
    X(es_glsl, CASTER, "es.glsl") \
    X(fullscreen_glsl, CASTER, "fullscreen.glsl") \
    X(probe_glsl, CASTER, "probe.glsl") \
    X(raycast_glsl, CASTER, "raycast.glsl") \
    X(roi_glsl, CASTER, "roi.glsl") \
    X(variants_glsl, CASTER, "variants.h") \
    X(held_glsl, CASTER, "held.glsl") \
    X(display_glsl, "src/view/", "display.glsl") \
    X(overlay_glsl, "src/view/", "overlay.glsl")
#define EMBED_SHADER(symbol, folder, file) ISO_EMBED(iso_viewer_##symbol, folder file);
SHADERS(EMBED_SHADER)
#define SHADER_ENTRY(symbol, folder, file) {file, iso_viewer_##symbol},
static const struct {
    const char *name, *text;
} shaders[] = {SHADERS(SHADER_ENTRY)};
/* clang-format on */

/* Returns the length of the code that `text` begins with, before a comment or the end of its line. */
static size_t code_length(const char *text)
{
    size_t n = 0;
    for (; text[n] && text[n] != '\n'; ++n)
        if (text[n] == '/' && (text[n + 1] == '/' || text[n + 1] == '*') && (n == 0 || text[n - 1] == ' '))
            return n;
    return n;
}

/* Writes source text without indentation and comments, a fifth of it. A blank stands before each comment; no string has
 * several lines or anything like a comment. */
static void put_code(FILE *f, const char *text)
{
    while (*text) {
        text += strspn(text, " \n");
        const size_t n = code_length(text);
        if (n > 0)
            fprintf(f, "%.*s\n", (int)n, text);
        text += n;
        if (strncmp(text, "/*", 2) == 0)
            text = strstr(text, "*/") + 2;
        else
            text += strcspn(text, "\n");
    }
}

static void put_shaders(FILE *f)
{
    json_auto_t *all = json_object();
    for (size_t i = 0; i < sizeof shaders / sizeof *shaders; ++i) {
        FREED char *text = NULL;
        size_t size;
        FILE *code = open_memstream(&text, &size);
        if (!code)
            continue;
        put_code(code, shaders[i].text);
        fclose(code);
        json_object_set_new(all, shaders[i].name, json_string(text));
    }
    iso_markup_put_json(f, all);
}

/* Writes an element per array. Those of the coarsest level precede the script, which draws it while the browser reads
 * the rest. */
static void put_arrays(FILE *f, const iso_contents *contents, size_t from, size_t to)
{
    for (size_t i = from; i < to; ++i) {
        fprintf(f, "<script type=\"text/plain\" id=\"%s\">", contents->arrays[i].name);
        iso_base64_put(f, contents->arrays[i].packed.bytes, contents->arrays[i].packed.size);
        fputs("</script>\n", f);
    }
}

typedef struct page {
    const iso_viewer *viewer;
    const iso_contents *contents;
} page;

static void put_mark(FILE *f, const char *mark, const void *user)
{
    const page *p = user;
    const iso_contents *c = p->contents;
    if (strcmp(mark, "TITLE") == 0)
        iso_markup_put(f, p->viewer->title);
    else if (strcmp(mark, "STYLE") == 0)
        put_code(f, iso_viewer_css);
    else if (strcmp(mark, "DATA") == 0)
        iso_markup_put_json(f, c->root);
    else if (strcmp(mark, "SHADERS") == 0)
        put_shaders(f);
    else if (strcmp(mark, "SCRIPT") == 0)
        for (size_t i = 0; i < sizeof scripts / sizeof *scripts; ++i)
            put_code(f, scripts[i]);
    else if (strcmp(mark, "FIRST") == 0)
        put_arrays(f, c, 0, c->first_count);
    else if (strcmp(mark, "REST") == 0)
        put_arrays(f, c, c->first_count, c->count);
}

size_t iso_viewer_finest_level(const iso_pyramid *p, double most_voxels)
{
    size_t level = 0;
    while (level + 1 < p->level_count && (double)iso_geometry_voxel_count(&p->levels[level].geometry) > most_voxels)
        ++level;
    return level;
}

iso_status iso_viewer_save(const iso_viewer *v, const char *path, const iso_progress *progress, iso_viewer_size *size,
                           iso_error *err)
{
    OWNED(iso_contents) contents = {0};
    ENDED_BY(iso_output_abandon) iso_output out = {0};
    NEED(iso_contents_make(v, progress, &contents, err));
    NEED(iso_output_begin(&out, path, err));
    FILE *f = fopen(out.temp_path, "wb");
    bool good = f;
    if (f) {
        iso_markup_fill_marks(f, iso_viewer_html, put_mark, &(page){v, &contents});
        const long end = ftell(f);
        contents.size.page_bytes = end > 0 ? (size_t)end : 0;
        good = !ferror(f);
        good = fclose(f) == 0 && good;
    }
    if (!good)
        return iso_fail(err, iso_errno_status(), "%s: cannot be written: %s", path, strerror(errno));
    for (size_t i = 0; i < contents.count; ++i)
        contents.size.data_bytes += (contents.arrays[i].packed.size + 2) / 3 * 4;
    NEED(iso_output_commit(&out, err));
    *size = contents.size;
    return ISO_OK;
}
