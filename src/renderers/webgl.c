/* SPDX-License-Identifier: MIT */
/* webgl.c - the viewer's ray caster (src/view) in Chromium without a window: what a person sees in the page of `isoshade
 * view`, held to the same comparisons as any renderer. */
#include "base/embed.h"
#include "renderers/external.h"

ISO_EMBED(iso_webgl_py, "src/renderers/webgl.py");
ISO_EMBED(iso_webgl_chromium_py, "src/view/chromium.py");
ISO_EMBED(iso_webgl_exr_py, "src/view/exr.py");
ISO_EMBED(iso_webgl_vectors_js, "src/view/vectors.js");
ISO_EMBED(iso_webgl_arrays_js, "src/view/arrays.js");
ISO_EMBED(iso_webgl_camera_js, "src/view/camera.js");
ISO_EMBED(iso_webgl_transfer_js, "src/view/transfer.js");
ISO_EMBED(iso_webgl_adapt_js, "src/view/adapt.js");
ISO_EMBED(iso_webgl_occupancy_js, "src/view/occupancy.js");
ISO_EMBED(iso_webgl_context_js, "src/view/context.js");
ISO_EMBED(iso_webgl_textures_js, "src/view/textures.js");
ISO_EMBED(iso_webgl_caster_js, "src/view/caster.js");
ISO_EMBED(iso_webgl_request_js, "src/view/request.js");
ISO_EMBED(iso_webgl_code_decode_glsl, "src/encode/code_decode.h");
ISO_EMBED(iso_webgl_es_glsl, "src/render/gl/shaders/es.glsl");
ISO_EMBED(iso_webgl_fullscreen_glsl, "src/render/gl/shaders/fullscreen.glsl");
ISO_EMBED(iso_webgl_held_glsl, "src/render/gl/shaders/held.glsl");
ISO_EMBED(iso_webgl_probe_glsl, "src/render/gl/shaders/probe.glsl");
ISO_EMBED(iso_webgl_raycast_glsl, "src/render/gl/shaders/raycast.glsl");
ISO_EMBED(iso_webgl_roi_glsl, "src/render/gl/shaders/roi.glsl");
ISO_EMBED(iso_webgl_variants_glsl, "src/render/gl/shaders/variants.h");

static const iso_external_file files[] = {
    {"webgl.py", iso_webgl_py},
    {"chromium.py", iso_webgl_chromium_py},
    {"exr.py", iso_webgl_exr_py},
    {"vectors.js", iso_webgl_vectors_js},
    {"arrays.js", iso_webgl_arrays_js},
    {"camera.js", iso_webgl_camera_js},
    {"transfer.js", iso_webgl_transfer_js},
    {"adapt.js", iso_webgl_adapt_js},
    {"occupancy.js", iso_webgl_occupancy_js},
    {"context.js", iso_webgl_context_js},
    {"textures.js", iso_webgl_textures_js},
    {"caster.js", iso_webgl_caster_js},
    {"request.js", iso_webgl_request_js},
    {"code_decode.h", iso_webgl_code_decode_glsl},
    {"es.glsl", iso_webgl_es_glsl},
    {"fullscreen.glsl", iso_webgl_fullscreen_glsl},
    {"held.glsl", iso_webgl_held_glsl},
    {"probe.glsl", iso_webgl_probe_glsl},
    {"raycast.glsl", iso_webgl_raycast_glsl},
    {"roi.glsl", iso_webgl_roi_glsl},
    {"variants.h", iso_webgl_variants_glsl},
    {NULL, NULL},
};

/* -E: the standard library is enough, whatever PYTHONPATH has for others. */
static const char *const command[] = {"python3", "-E", "webgl.py", NULL};
static const char *const version[] = {"python3", "-E", "webgl.py", "--version", NULL};
/* Chromium puts what it shows into sandboxes of its own (view/chromium.py), which it speaks to over sockets. */
static const iso_external webgl = {.command = command,
                                   .version = version,
                                   .files = files,
                                   .tier = "samples",
                                   .timeout_seconds = 300,
                                   .has_all_rights = true};

/* WebGL2 has no doubles: where the ray caster sets its rays up in them, floats stand, up to 1e-5 voxels off after 300
 * voxels. Times the slope of the transfer function that is seen: four times the ray caster's limits. */
static const iso_lock_step lock_step = {
    .quadrature = ISO_QUADRATURE_MIDPOINT,
    .smooth = {.rmse = 4e-6, .max_abs = 8e-5},
    .sharp = {.rmse = 2e-5, .max_abs = 8e-4},
    .why = "the same samples, of rays that are set up in floats, up to 1e-5 voxels off: WebGL2 has no doubles",
};

static const char *const programs[] = {"python3", "chromium", "chromium-browser", "google-chrome", NULL};

const iso_renderer_info iso_renderer_webgl = {
    .name = "webgl",
    .programs = programs,
    .title = "viewer in Chromium",
    .stages = {"webgl"},
    .color = "#56b4e9",
    .traits = ISO_EXTERNAL_TRAITS | ISO_HAS_CLIP_PLANES | ISO_HAS_LABELS | ISO_HAS_LIGHTS | ISO_HAS_ORTHOGRAPHIC |
              ISO_HAS_LIMIT,
    .quadratures = 1u << ISO_QUADRATURE_MIDPOINT,
    .defaults = {.quadrature = ISO_QUADRATURE_MIDPOINT},
    .sample_seconds = 1.2e-7,
    .first_step_voxels = 1.0 / 8,
    .lock_step = &lock_step,
    .data = &webgl,
    ISO_EXTERNAL_CALLBACKS,
};
