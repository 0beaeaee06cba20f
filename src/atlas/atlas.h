/* SPDX-License-Identifier: MIT */
/* atlas.h - a catalog of failures: the smallest scene that shows each, a figure for it, and the fallback that corrects
 * it.
 *
 * A case is a scene (a small closed-form volume, a camera, a transfer function) and three ways to show it: right,
 * failure, fallback. A way is given by options of `isoshade build` and `isoshade render`: they run here, and the page
 * lists them as commands. The CPU reference draws all pictures. A picture's figure is its RMSE to the right one;
 * smaller is better.
 *
 * A case is valid while the failure is at least failure_at_least and the fallback at most fallback_at_most. Tests check
 * both, so that they notice a failure that has disappeared and a broken fallback.
 *
 *   fields.c  the closed forms
 *   stage.c   a scene as volume, view and scene file; a way as a picture
 *   faults.c  the failures that no option produces
 *   cases.c   the table
 *   page.c    the page and its pictures */
#pragma once

#include <jansson.h>
#include <stdio.h>

#include "image/image.h"
#include "pyramid/pyramid.h"
#include "scene/scene.h"

enum { ISO_ATLAS_PIXELS = 96, ISO_ATLAS_ZOOM = 24 };

typedef enum iso_atlas_which { ISO_ATLAS_RIGHT, ISO_ATLAS_FAILURE, ISO_ATLAS_FALLBACK, ISO_ATLAS_WAYS } iso_atlas_which;
extern const char *const iso_atlas_names[ISO_ATLAS_WAYS]; /* right, failure, fallback */

/* The value at a point in world space (mm); *normal: the unit normal, or zero if undefined. */
typedef double iso_atlas_field(iso_vec3 world_mm, iso_vec3 *normal);

/* The box is 2 mm along each edge and centered at the origin. */
typedef struct iso_atlas_scene {
    iso_atlas_field *field; /* NULL: no volume, the case draws something else */
    size_t size[3];         /* voxels */
    double noise;           /* added to the value, uniform in +-noise */
    size_t values;          /* number of gray values in [0, 1]; 0: not rounded */
    bool band;              /* true: the TF shows only lo .. hi; false: a ramp from lo to hi, opaque above */
    double lo, hi, extinction_per_mm;
    iso_vec3 forward, light; /* camera direction; direction to the light. Zero: obliquely from above */
    double height_mm;        /* picture height; 0: fits a ball */
    size_t pixels;           /* per side of the picture; 0: ISO_ATLAS_PIXELS */
} iso_atlas_scene;

/* A failure that no option of isoshade produces: the function overwrites the level's directions or codes. */
typedef iso_status iso_atlas_fault(const iso_atlas_scene *scene, iso_pyramid *p, size_t level, iso_error *err);

typedef struct iso_atlas_way {
    const char *what;           /* for the caption */
    const char *build, *render; /* options, or NULL */
    iso_atlas_fault *fault;     /* planted after the build, or NULL */
} iso_atlas_way;

typedef struct iso_atlas_case {
    const char *id, *title, *cause;
    const char *look;   /* what to see in the pictures */
    const char *advice; /* the fallback as a command to type, and its limits if any */
    iso_atlas_scene scene;
    iso_atlas_way ways[ISO_ATLAS_WAYS];
    double failure_at_least, fallback_at_most;
    /* Name and unit of a figure other than the RMSE of a render; NULL: the RMSE. */
    const char *measure;
    iso_status (*draw)(const iso_volume *v, iso_atlas_which which, iso_image *image, double *value, iso_error *err);
} iso_atlas_case;

extern const iso_atlas_case iso_atlas_cases[];
extern const size_t iso_atlas_case_count;
const iso_atlas_case *iso_atlas_find(const char *id); /* NULL if unknown */
static inline const char *iso_atlas_measure(const iso_atlas_case *c)
{
    return c->measure ? c->measure : "RMSE to the right picture, linear color and opacity from 0 to 1";
}

typedef struct iso_atlas_result {
    double values[ISO_ATLAS_WAYS]; /* the right one's is 0 */
    iso_image images[ISO_ATLAS_WAYS];
} iso_atlas_result;

/* Runs a case and creates the images. Release with iso_atlas_clear(). */
iso_status iso_atlas_run(const iso_atlas_case *c, iso_atlas_result *out, iso_error *err);
void iso_atlas_clear(iso_atlas_result *out);
static inline bool iso_atlas_is_valid(const iso_atlas_case *c, const iso_atlas_result *r)
{
    return r->values[ISO_ATLAS_FAILURE] >= c->failure_at_least &&
           r->values[ISO_ATLAS_FALLBACK] <= c->fallback_at_most; /* NaN is not valid */
}

/* ---- stage.c ---- */

/* Creates the scene's volume of float voxels. */
iso_status iso_atlas_volume(const iso_atlas_scene *scene, iso_volume *v, iso_error *err);
/* Returns the height and width of the picture in mm. */
double iso_atlas_picture_mm(const iso_atlas_scene *scene);
/* Creates the scene's transfer function, tabulated for a volume of this geometry. */
iso_status iso_atlas_tf(const iso_atlas_scene *scene, const iso_geometry *g, iso_tf_table *tf, iso_error *err);
/* Returns the content of a scene file; NULL if out of memory. */
json_t *iso_atlas_scene_to_json(const iso_atlas_scene *scene, const char *comment);
/* Builds a pyramid of the volume and renders it in one way. */
iso_status iso_atlas_show(const iso_atlas_case *c, iso_atlas_which which, const iso_volume *v, iso_image *image,
                          double *value, iso_error *err);

/* ---- fields.c ---- */

iso_atlas_field iso_atlas_ball, iso_atlas_dome, iso_atlas_plate, iso_atlas_shell, iso_atlas_vessel, iso_atlas_shells,
    iso_atlas_balls, iso_atlas_block_and_plates, iso_atlas_two_textures, iso_atlas_ripples;

/* ---- faults.c ---- */

iso_atlas_fault iso_atlas_true_normals;    /* the closed form's normals */
iso_atlas_fault iso_atlas_index_gradients; /* the index gradient without the conversion to world space */
iso_atlas_fault iso_atlas_folded_codes;    /* oct24, filtered; pyramids refuse to filter such a code */
iso_atlas_fault iso_atlas_coarse_angles;   /* azimuth and polar cosine of a grid four times as coarse, filtered */
iso_atlas_fault iso_atlas_coarse_vectors;  /* the same grid's vectors, filtered */

/* Draws a cut through a fine and a coarse brick; *value: the largest step across their common face. */
iso_status iso_atlas_cut_bricks(const iso_volume *v, iso_atlas_which which, iso_image *image, double *value,
                                iso_error *err);
/* Draws directions around an axis; brightness is the angle to the nearest direction of the code of 48 regions. Lambda
 * in Eq. 2 of [diaz-garcia-2017] is 0 (failure) or 0.61 (fallback). *value: the largest angle in degrees. */
iso_status iso_atlas_draw_holes(const iso_volume *v, iso_atlas_which which, iso_image *image, double *value,
                                iso_error *err);

/* ---- page.c ---- */

typedef struct iso_atlas_page {
    FILE *html;
    json_t *cases;
    const char *dir;  /* output folder */
    const char *name; /* the folder as given by the user, for commands */
} iso_atlas_page;

/* Writes head and table of contents with the figures so far: call it last, into a separate stream. */
void iso_atlas_page_begin(FILE *html, const json_t *cases);
void iso_atlas_page_end(FILE *html);
/* Writes the case's files (ID.nrrd, ID.scene.json, pictures) and adds its section and its JSON object. */
iso_status iso_atlas_page_add(iso_atlas_page *page, const iso_atlas_case *c, const iso_atlas_result *r, iso_error *err);
