/* SPDX-License-Identifier: MIT */
#include "render/gl/gl_variant.h"

#include <stdio.h>

#include "encode/decode_double.h"

/* A name at its own value. */
#define NAMED(value) [value] = #value

static const char *const source_names[] = {NAMED(SOURCE_CODES),   NAMED(SOURCE_VECTORS), NAMED(SOURCE_ON_THE_FLY),
                                           NAMED(SOURCE_PALETTE), NAMED(SOURCE_NEAREST), NAMED(SOURCE_FLIPPED)};
static const char *const output_names[] = {NAMED(OUTPUT_INTEGRAL), NAMED(OUTPUT_HIT_COLOR), NAMED(OUTPUT_HIT_PLACE),
                                           NAMED(OUTPUT_HIT_NORMAL), NAMED(OUTPUT_POINTS)};
static const char *const scale_names[] = {NAMED(SCALE_NONE), NAMED(SCALE_WITH_DIRECTIONS), NAMED(SCALE_ALONE)};
static const char *const decoder_names[] = {NAMED(ISO_DECODER_LINEAR), NAMED(ISO_DECODER_REGION48),
                                            NAMED(ISO_DECODER_UNIT), NAMED(ISO_DECODER_OCT)};

int iso_gl_output(const iso_surface *surface)
{
    static const int outputs[] = {[ISO_SURFACE_COLOR] = OUTPUT_HIT_COLOR,
                                  [ISO_SURFACE_POSITION] = OUTPUT_HIT_PLACE,
                                  [ISO_SURFACE_NORMAL] = OUTPUT_HIT_NORMAL};
    return surface ? outputs[surface->output] : OUTPUT_INTEGRAL;
}

iso_status iso_gl_get_variant(iso_gl *gl, const iso_gl_variant *v, GLuint *program, iso_error *err)
{
    char defines[736], transition[48] = "";
    if (v->transition)
        snprintf(transition, sizeof transition, "#define TRANSITION %s\n", v->transition);
    snprintf(defines, sizeof defines,
             "#define DIRECTION_SOURCE %s\n#define DECODER %s\n#define OUTPUT %s\n#define LIGHT_COUNT %zu\n"
             "#define SPECULAR %d\n#define SHADE_TABLE %d\n#define SKIP_EMPTY %d\n#define PREINTEGRATED %d\n"
             "#define EXACT %d\n#define ROI %d\n#define BRICKS %d\n#define TF_2D_ROWS %d\n#define EXTINCTION_SCALE %s\n"
             "#define PAGES %zu\n#define SCREEN_TILE %d\n#define SCALAR_WITH_DIRECTIONS %d\n%s%s",
             source_names[v->direction_source], decoder_names[v->decoder], output_names[v->output], v->light_count,
             v->specular, v->shade_table, v->skip_empty, v->preintegrated, v->exact, v->roi, v->bricks, v->tf_2d_rows,
             scale_names[v->extinction_scale], v->pages ? v->pages : 1, v->screen_tile, v->scalar_with_directions,
             v->filtered_by_hand ? "#define FILTERED_BY_HAND 1\n" : "", transition);
    return iso_gl_get_program(gl, "raycast.glsl", defines, program, err);
}
