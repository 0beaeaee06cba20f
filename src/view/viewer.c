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
ISO_EMBED(iso_viewer_vectors_js, "src/view/vectors.js");
ISO_EMBED(iso_viewer_arrays_js, "src/view/arrays.js");
ISO_EMBED(iso_viewer_camera_js, "src/view/camera.js");
ISO_EMBED(iso_viewer_transfer_js, "src/view/transfer.js");
ISO_EMBED(iso_viewer_adapt_js, "src/view/adapt.js");
ISO_EMBED(iso_viewer_occupancy_js, "src/view/occupancy.js");
ISO_EMBED(iso_viewer_context_js, "src/view/context.js");
ISO_EMBED(iso_viewer_textures_js, "src/view/textures.js");
ISO_EMBED(iso_viewer_bricks_js, "src/view/bricks.js");
ISO_EMBED(iso_viewer_caster_js, "src/view/caster.js");
ISO_EMBED(iso_viewer_frames_js, "src/view/frames.js");
ISO_EMBED(iso_viewer_state_js, "src/view/state.js");
ISO_EMBED(iso_viewer_orbit_js, "src/view/orbit.js");
ISO_EMBED(iso_viewer_planes_js, "src/view/planes.js");
ISO_EMBED(iso_viewer_overlay_js, "src/view/overlay.js");
ISO_EMBED(iso_viewer_pick_js, "src/view/pick.js");
ISO_EMBED(iso_viewer_slices_js, "src/view/slices.js");
ISO_EMBED(iso_viewer_outline_js, "src/view/outline.js");
ISO_EMBED(iso_viewer_editor_js, "src/view/editor.js");
ISO_EMBED(iso_viewer_save_js, "src/view/save.js");
ISO_EMBED(iso_viewer_controls_js, "src/view/controls.js");
ISO_EMBED(iso_viewer_open_samples_js, "src/view/open_samples.js");
ISO_EMBED(iso_viewer_open_nrrd_js, "src/view/open_nrrd.js");
ISO_EMBED(iso_viewer_open_nifti_js, "src/view/open_nifti.js");
ISO_EMBED(iso_viewer_open_js, "src/view/open.js");
ISO_EMBED(iso_viewer_start_js, "src/view/start.js");

/* The ray caster's own sources, which gl_program.c also embeds: one text in the program, with two names. */
ISO_EMBED(iso_viewer_code_decode_glsl, "src/encode/code_decode.h");
ISO_EMBED(iso_viewer_es_glsl, "src/render/gl/shaders/es.glsl");
ISO_EMBED(iso_viewer_fullscreen_glsl, "src/render/gl/shaders/fullscreen.glsl");
ISO_EMBED(iso_viewer_held_glsl, "src/render/gl/shaders/held.glsl");
ISO_EMBED(iso_viewer_probe_glsl, "src/render/gl/shaders/probe.glsl");
ISO_EMBED(iso_viewer_raycast_glsl, "src/render/gl/shaders/raycast.glsl");
ISO_EMBED(iso_viewer_roi_glsl, "src/render/gl/shaders/roi.glsl");
ISO_EMBED(iso_viewer_variants_glsl, "src/render/gl/shaders/variants.h");
ISO_EMBED(iso_viewer_display_glsl, "src/view/display.glsl");
ISO_EMBED(iso_viewer_overlay_glsl, "src/view/overlay.glsl");

static const struct {
    const char *name, *text;
} shaders[] = {
    {"code_decode.h", iso_viewer_code_decode_glsl}, {"es.glsl", iso_viewer_es_glsl},
    {"fullscreen.glsl", iso_viewer_fullscreen_glsl}, {"probe.glsl", iso_viewer_probe_glsl},
    {"raycast.glsl", iso_viewer_raycast_glsl},      {"roi.glsl", iso_viewer_roi_glsl},
    {"variants.h", iso_viewer_variants_glsl},       {"held.glsl", iso_viewer_held_glsl},
    {"display.glsl", iso_viewer_display_glsl},      {"overlay.glsl", iso_viewer_overlay_glsl},
};

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

/* Writes all scripts as one, each part after those that it uses. */
static void put_script(FILE *f)
{
    const char *const parts[] = {
        iso_viewer_vectors_js, iso_viewer_arrays_js, iso_viewer_camera_js, iso_viewer_transfer_js,
        iso_viewer_adapt_js, iso_viewer_occupancy_js, iso_viewer_context_js, iso_viewer_textures_js,
        iso_viewer_bricks_js, iso_viewer_caster_js, iso_viewer_frames_js, iso_viewer_state_js, iso_viewer_orbit_js,
        iso_viewer_planes_js, iso_viewer_overlay_js, iso_viewer_outline_js, iso_viewer_editor_js,
        iso_viewer_save_js, iso_viewer_controls_js,
        iso_viewer_pick_js, iso_viewer_slices_js, iso_viewer_open_samples_js, iso_viewer_open_nrrd_js, iso_viewer_open_nifti_js,
        iso_viewer_open_js, iso_viewer_start_js,
    };
    for (size_t i = 0; i < sizeof parts / sizeof *parts; ++i)
        put_code(f, parts[i]);
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

typedef struct page_part {
    const char *mark;
    void (*put)(FILE *f, const iso_viewer *v, const iso_contents *contents);
} page_part;

static void put_title_part(FILE *f, const iso_viewer *v, const iso_contents *c)
{
    (void)c;
    iso_markup_put(f, v->title);
}
static void put_style_part(FILE *f, const iso_viewer *v, const iso_contents *c)
{
    (void)v, (void)c;
    put_code(f, iso_viewer_css);
}
static void put_data_part(FILE *f, const iso_viewer *v, const iso_contents *c)
{
    (void)v;
    iso_markup_put_json(f, c->root);
}
static void put_shaders_part(FILE *f, const iso_viewer *v, const iso_contents *c)
{
    (void)v, (void)c;
    put_shaders(f);
}
static void put_script_part(FILE *f, const iso_viewer *v, const iso_contents *c)
{
    (void)v, (void)c;
    put_script(f);
}
static void put_first_part(FILE *f, const iso_viewer *v, const iso_contents *c)
{
    (void)v;
    put_arrays(f, c, 0, c->first_count);
}
static void put_rest_part(FILE *f, const iso_viewer *v, const iso_contents *c)
{
    (void)v;
    put_arrays(f, c, c->first_count, c->count);
}

/* Writes the template with its marks @NAME@ replaced. */
static void put_page(FILE *f, const iso_viewer *v, const iso_contents *contents)
{
    static const page_part parts[] = {
        {"@TITLE@", put_title_part},     {"@STYLE@", put_style_part},   {"@DATA@", put_data_part},
        {"@SHADERS@", put_shaders_part}, {"@SCRIPT@", put_script_part}, {"@FIRST@", put_first_part},
        {"@REST@", put_rest_part},
    };
    for (const char *at = iso_viewer_html; *at;) {
        const char *mark = strchr(at, '@'), *end = mark ? strchr(mark + 1, '@') : NULL;
        if (!end) {
            fputs(at, f);
            return;
        }
        fwrite(at, 1, (size_t)(mark - at), f);
        const size_t length = (size_t)(end - mark) + 1;
        at = end + 1;
        for (size_t i = 0; i < sizeof parts / sizeof *parts; ++i)
            if (strncmp(mark, parts[i].mark, length) == 0 && strlen(parts[i].mark) == length)
                parts[i].put(f, v, contents);
    }
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
    iso_output out = {0};
    NEED(iso_contents_make(v, progress, &contents, err));
    iso_status status = iso_output_begin(&out, path, err);
    FILE *f = status == ISO_OK ? fopen(out.temp_path, "wb") : NULL;
    if (status == ISO_OK && !f)
        status = iso_fail(err, iso_errno_status(), "%s: cannot be written: %s", path, strerror(errno));
    if (f) {
        put_page(f, v, &contents);
        const long end = ftell(f);
        contents.size.page_bytes = end > 0 ? (size_t)end : 0;
        const bool bad = ferror(f);
        if (fclose(f) != 0 || bad)
            status = iso_fail(err, iso_errno_status(), "%s: cannot be written: %s", path, strerror(errno));
    }
    for (size_t i = 0; i < contents.count; ++i)
        contents.size.data_bytes += (contents.arrays[i].packed.size + 2) / 3 * 4;
    TRY(status, iso_output_commit(&out, err));
    iso_output_abandon(&out);
    *size = contents.size;
    return status;
}
