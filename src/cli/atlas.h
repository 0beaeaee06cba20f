/* atlas.h - the ways in which methods fail: the smallest scene that shows each,
 * a figure for it, and the fallback that mends it.
 *
 * A case renders three pictures with the CPU reference - what is right, the
 * failure, the fallback - and measures the last two alike, the smaller the
 * better. It stands while the failure is at least bad_at_least and the fallback
 * at most good_at_most: tests hold both, so that neither a cured failure nor a
 * broken fallback goes unnoticed. */
#ifndef ISO_CLI_ATLAS_H
#define ISO_CLI_ATLAS_H

#include "image/image.h"
#include "pyramid/pyramid.h"
#include "render/field.h"
#include "render/scene.h"

enum { ISO_ATLAS_PIXELS = 96 };

typedef struct iso_atlas_result {
    double bad, good;
    iso_image truth, failure, mended;
} iso_atlas_result;

typedef struct iso_atlas_case {
    const char *id, *title, *cause;
    const char *measure;          /* what bad and good are, with the unit */
    const char *failure, *mended; /* what is done in each picture */
    double bad_at_least, good_at_most;
    iso_status (*run)(iso_atlas_result *out, iso_error *err);
} iso_atlas_case;

extern const iso_atlas_case iso_atlas_cases[];
extern const size_t iso_atlas_case_count;

/* Runs a case; the images are created. Release with iso_atlas_clear(). */
iso_status iso_atlas_run(const iso_atlas_case *c, iso_atlas_result *out, iso_error *err);
void iso_atlas_clear(iso_atlas_result *out);
static inline bool iso_atlas_stands(const iso_atlas_case *c, const iso_atlas_result *r)
{
    return r->bad >= c->bad_at_least && r->good <= c->good_at_most; /* NaN does not stand */
}

/* ---- what cases are made of (atlas_stage.c) ---- */

/* A field in closed form: the value and the unit normal (zero where there is none) at a point of the world. */
typedef double (*iso_atlas_field)(iso_vec3 world_mm, iso_vec3 *normal);

typedef struct iso_atlas_stage {
    iso_atlas_field field;
    iso_pyramid pyramid; /* float directions are kept */
    iso_view view;
} iso_atlas_stage;

typedef struct iso_atlas_options {
    size_t size;         /* voxels along each axis */
    iso_geometry *geometry; /* or this grid instead */
    iso_type type;       /* ISO_U8 quantises [0, 1] to `steps` values */
    size_t steps;
    double noise;        /* added to the value, uniform in +-noise */
    iso_pyramid_options build;
} iso_atlas_options;
iso_atlas_options iso_atlas_defaults(void);

iso_status iso_atlas_stage_create(iso_atlas_stage *s, iso_atlas_field field, const iso_atlas_options *opt, iso_error *err);
void iso_atlas_stage_destroy(iso_atlas_stage *s);

/* The TF: transparent below lo, opaque from hi on; between them a ramp. Or a band round a value. */
iso_status iso_atlas_show_above(iso_atlas_stage *s, double lo, double hi, double extinction, iso_error *err);
iso_status iso_atlas_show_band(iso_atlas_stage *s, double middle, double half_width, double extinction, iso_error *err);

/* Renders a level; step 0 is the converged quadrature. */
iso_status iso_atlas_render(const iso_atlas_stage *s, size_t level, iso_direction_source source, double step_voxels,
                            iso_image *image, iso_error *err);
/* The same level with the closed-form normals. */
iso_status iso_atlas_render_truth(iso_atlas_stage *s, size_t level, iso_image *image, iso_error *err);
/* The mean angle in degrees between the level's directions and the closed form, where the TF shows something;
 * two-sided as the light is; a direction that is missing counts 90. */
iso_status iso_atlas_angle(const iso_atlas_stage *s, size_t level, iso_direction_source source, double *degrees, iso_error *err);
iso_status iso_atlas_rmse(const iso_image *a, const iso_image *b, double *rmse, iso_error *err);

#endif
