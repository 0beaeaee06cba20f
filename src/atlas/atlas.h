/* SPDX-License-Identifier: MIT */
/* atlas.h - the ways in which methods fail: the smallest scene that shows each,
 * a figure for it, and the fallback that corrects it.
 *
 * A case is a scene - a small volume of a closed form, a camera, a transfer
 * function - and three ways to show it: what is right, the failure, the fallback.
 * A way is given by options of `isoshade build` and `isoshade render`: they are run here, and
 * the page tells its reader to type them. The CPU reference
 * draws. The figure of a picture is its RMSE to the right one; the smaller the better.
 *
 * A case is valid while the failure is at least failure_at_least and the fallback
 * at most fallback_at_most. Tests check both, so that neither a failure that has
 * disappeared nor a broken fallback goes unnoticed.
 *
 *   fields.c  the closed forms
 *   stage.c   a scene as volume, view and scene file; a way as a picture
 *   faults.c  the failures that no option makes
 *   cases.c   the table
 *   page.c    the page and its pictures */
#ifndef ISO_ATLAS_H
#define ISO_ATLAS_H

#include <jansson.h>
#include <stdio.h>

#include "image/image.h"
#include "pyramid/pyramid.h"
#include "scene/scene.h"

enum { ISO_ATLAS_PIXELS = 96, ISO_ATLAS_ZOOM = 24 };

typedef enum iso_atlas_which { ISO_ATLAS_RIGHT, ISO_ATLAS_FAILURE, ISO_ATLAS_FALLBACK, ISO_ATLAS_WAYS } iso_atlas_which;
extern const char *const iso_atlas_names[ISO_ATLAS_WAYS]; /* right, failure, fallback */

/* The value, and the unit normal (zero where there is none), at a point of the world. */
typedef double iso_atlas_field(iso_vec3 world_mm, iso_vec3 *normal);

/* The box is 2 mm along each edge and centered at the origin. */
typedef struct iso_atlas_scene {
    iso_atlas_field *field; /* NULL: there is no volume, the case draws something else */
    size_t size[3];         /* voxels */
    double noise;           /* added to the value, uniform in +-noise */
    size_t values;          /* gray values that [0, 1] is rounded to; 0: none */
    bool band;              /* the TF: transparent but for a band lo .. hi; else from a ramp lo .. hi on */
    double lo, hi, extinction_per_mm;
    iso_vec3 forward, light; /* of the camera; towards the light. Zero: from above, aslant */
    double height_mm;        /* of the picture; 0: what a ball needs */
    size_t pixels;           /* of the picture, along a side; 0: ISO_ATLAS_PIXELS */
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
    const char *advice; /* the fallback as a command to type, and more words where it has limits */
    iso_atlas_scene scene;
    iso_atlas_way ways[ISO_ATLAS_WAYS];
    double failure_at_least, fallback_at_most;
    /* Another picture and figure than the render's, with its name and unit; else NULL. */
    const char *measure;
    iso_status (*draw)(const iso_volume *v, iso_atlas_which which, iso_image *image, double *value, iso_error *err);
} iso_atlas_case;

extern const iso_atlas_case iso_atlas_cases[];
extern const size_t iso_atlas_case_count;
const iso_atlas_case *iso_atlas_find(const char *id); /* NULL: there is none */
static inline const char *iso_atlas_measure(const iso_atlas_case *c)
{
    return c->measure ? c->measure : "RMSE to the right picture, linear color and opacity from 0 to 1";
}

typedef struct iso_atlas_result {
    double values[ISO_ATLAS_WAYS]; /* the right one's is 0 */
    iso_image images[ISO_ATLAS_WAYS];
} iso_atlas_result;

/* Runs a case; the images are created. Release with iso_atlas_clear(). */
iso_status iso_atlas_run(const iso_atlas_case *c, iso_atlas_result *out, iso_error *err);
void iso_atlas_clear(iso_atlas_result *out);
static inline bool iso_atlas_is_valid(const iso_atlas_case *c, const iso_atlas_result *r)
{
    return r->values[ISO_ATLAS_FAILURE] >= c->failure_at_least &&
           r->values[ISO_ATLAS_FALLBACK] <= c->fallback_at_most; /* NaN is not valid */
}

/* ---- stage.c ---- */

/* The scene's volume: float, created. */
iso_status iso_atlas_volume(const iso_atlas_scene *scene, iso_volume *v, iso_error *err);
/* What a side of the picture shows. */
double iso_atlas_picture_mm(const iso_atlas_scene *scene);
/* Its transfer function, tabulated for a volume of this geometry: created. */
iso_status iso_atlas_tf(const iso_atlas_scene *scene, const iso_geometry *g, iso_tf_table *tf, iso_error *err);
/* The scene as a scene file's content; NULL when memory ends. */
json_t *iso_atlas_scene_to_json(const iso_atlas_scene *scene, const char *comment);
/* One way: a pyramid of the volume, and a picture of it. draw: the case's, or NULL. */
iso_status iso_atlas_show(const iso_atlas_case *c, iso_atlas_which which, const iso_volume *v, iso_image *image,
                          double *value, iso_error *err);

/* ---- fields.c ---- */

iso_atlas_field iso_atlas_ball, iso_atlas_dome, iso_atlas_plate, iso_atlas_shell, iso_atlas_vessel, iso_atlas_shells,
    iso_atlas_balls, iso_atlas_block_and_plates, iso_atlas_two_textures, iso_atlas_ripples;

/* ---- faults.c ---- */

iso_atlas_fault iso_atlas_true_normals;    /* the closed form's: what is right */
iso_atlas_fault iso_atlas_index_gradients; /* the index gradient, taken for the world's */
iso_atlas_fault iso_atlas_folded_codes;    /* oct24, filtered; pyramids refuse such a code */
iso_atlas_fault iso_atlas_coarse_angles;   /* azimuth and polar cosine of a grid four times as coarse, filtered */
iso_atlas_fault iso_atlas_coarse_vectors;  /* the same grid's vectors, filtered */

/* The cut through a fine and a coarse brick; the value is the largest step over their face. */
iso_status iso_atlas_cut_bricks(const iso_volume *v, iso_atlas_which which, iso_image *image, double *value,
                                iso_error *err);
/* Directions round an axis, as bright as they are far from any that the code of 48 regions holds, with lambda 0 and
 * 0.61 in Eq. 2 of [diaz-garcia-2017]; the value is the largest angle in degrees. */
iso_status iso_atlas_draw_holes(const iso_volume *v, iso_atlas_which which, iso_image *image, double *value,
                                iso_error *err);

/* ---- page.c ---- */

typedef struct iso_atlas_page {
    FILE *html;
    json_t *cases;
    const char *dir;  /* where files are written */
    const char *name; /* the folder as the user calls it, for commands */
} iso_atlas_page;

/* Head and list of contents, with the figures of the results so far: call it last, into another stream. */
void iso_atlas_page_begin(FILE *html, const json_t *cases);
void iso_atlas_page_end(FILE *html);
/* Writes the case's files - ID.nrrd, ID.scene.json, pictures - and adds its section and its object. */
iso_status iso_atlas_page_add(iso_atlas_page *page, const iso_atlas_case *c, const iso_atlas_result *r, iso_error *err);

#endif
