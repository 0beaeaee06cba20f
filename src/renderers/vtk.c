/* SPDX-License-Identifier: MIT */
/* vtk.c - VTK's two ray casters, by a script that reads a request (exporters/vtk/render_vtk.py; figures: doc/vtk.md). */
#include "base/embed.h"
#include "renderers/external.h"

ISO_EMBED(iso_render_vtk_py, "exporters/vtk/render_vtk.py");

static const iso_external_file files[] = {{"render_vtk.py", iso_render_vtk_py}, {NULL, NULL}};

/* ---- the fixed-point mapper ---- */

static const char *const command[] = {"python3", "render_vtk.py", NULL};
static const char *const version[] = {"python3", "render_vtk.py", "--version", NULL};
static const iso_external program = {.command = command,
                                     .version = version,
                                     .package = "python3",
                                     .files = files,
                                     .tier = "8 bits",
                                     .timeout_seconds = 1200};

static const iso_lock_step lock_step = {
    .quadrature = ISO_QUADRATURE_CONVERGED,
    .smooth = {.rmse = 2e-3, .max_abs = 1.0 / 255},
    .sharp = {.rmse = 4e-3, .max_abs = 10.0 / 255},
    .why =
        "VTK rounds every product up to 15 bits, ends rays at 0.8 % of the light and counts cut steps whole; averaged over "
        "steps that leaves less than 1/255. By itself (--as-is: 8 bits, a box from center to center) it is 0.4 off a slab",
};

static const char *const programs[] = {"python3", NULL};

const iso_renderer_info iso_renderer_vtk = {
    .name = "vtk",
    .title = "VTK",
    .programs = programs,
    .color = "#7b4173",
    .traits = ISO_EXTERNAL_TRAITS | ISO_HAS_ORTHOGRAPHIC | ISO_HAS_CLIP_PLANES | ISO_HAS_LABELS,
    .defaults = {.source = ISO_FROM_CODES},
    .sample_seconds = 4e-7,
    .lock_step = &lock_step,
    .output = {.bits = 15, .most = 1e6},
    .data = &program,
    ISO_EXTERNAL_CALLBACKS,
};

/* ---- the mapper of OpenGL ---- */

static const char *const gpu_command[] = {"python3", "render_vtk.py", "--gpu", NULL};
static const char *const gpu_version[] = {"python3", "render_vtk.py", "--gpu", "--version", NULL};
static const iso_external gpu_program = {.command = gpu_command,
                                         .version = gpu_version,
                                         .package = "python3",
                                         .files = files,
                                         .tier = "8 bits",
                                         .timeout_seconds = 1200,
                                         .starts_server = true};

static const iso_lock_step gpu_lock_step = {
    .quadrature = ISO_QUADRATURE_CONVERGED,
    .smooth = {.rmse = 4e-3, .max_abs = 8.0 / 255},
    .sharp = {.rmse = 1e-2, .max_abs = 30.0 / 255},
    .why = "VTK's window has 8 bits, its tables 1024 entries, and a step that the box cuts counts whole",
};

const iso_renderer_info iso_renderer_vtk_gpu = {
    .name = "vtk-gpu",
    .title = "VTK, OpenGL",
    .programs = programs,
    .color = "#637939",
    .traits = ISO_EXTERNAL_TRAITS | ISO_HAS_ORTHOGRAPHIC | ISO_HAS_CLIP_PLANES,
    .defaults = {.source = ISO_FROM_CODES},
    .sample_seconds = 8e-8,
    .lock_step = &gpu_lock_step,
    .output = {.bits = 8, .most = 1e6},
    .data = &gpu_program,
    ISO_EXTERNAL_CALLBACKS,
};
