/* SPDX-License-Identifier: MIT */
/* picture.h - what the pictures of a figure are of, and one call that renders one for its place in print. */
#ifndef ISO_FIGURE_PICTURE_H
#define ISO_FIGURE_PICTURE_H

#include "figure/job.h"
#include "renderers/renderers.h"
#include "scene/viewpoint.h"

/* Zeroed: empty. */
typedef struct iso_figure_subject {
    const iso_figure_job *job;
    iso_pyramid pyramid;
    iso_scene scene;
    iso_tf_table tf; /* of level 0, as the scene has it */
    iso_renderers renderers;
    const iso_renderer_info *drawn_by; /* the last picture */
} iso_figure_subject;

/* The job's volume with so many levels at least, and its scene. build: NULL for the defaults. ISO_E_RANGE: a pyramid on disk
 * has fewer. */
iso_status iso_figure_subject_load(iso_figure_subject *s, const iso_figure_job *job, size_t level_count,
                                   const iso_pyramid_options *build, iso_error *err);
/* The transfer function that a scene has for a pyramid's level 0: created. */
iso_status iso_figure_scene_tf(const iso_scene *scene, const iso_pyramid *p, iso_tf_table *tf, iso_error *err);
void iso_figure_subject_end(iso_figure_subject *s); /* accepts empty */

/* --with as one renderer; the fastest where it is not given. */
iso_status iso_figure_renderer(const iso_figure_job *job, const iso_renderer_info **with, iso_error *err);

typedef struct iso_figure_picture {
    const iso_renderer_info *with;
    bool named; /* with no other: else iso_renderers_choose() where the job names none */
    size_t level;
    size_t width, height;               /* pixels */
    const iso_viewpoint *viewpoint;     /* of the camera, which frames the box; NULL: the scene's */
    double turn_deg;                    /* the camera, round the scene's up axis */
    size_t turns;                       /* turn_deg is one of so many equal parts of a turn; 0: there are no others */
    const iso_direction_source *source; /* NULL: the renderer's default */
    const iso_cli_roi *region;          /* a finer level in a box; or NULL */
    bool adapted;                       /* under the transfer function adapted to the level, whatever the job says */
} iso_figure_picture;
/* mm_per_pixel may be NULL. */
iso_status iso_figure_render(iso_figure_subject *s, const iso_figure_picture *what, iso_image *image,
                             double *mm_per_pixel, iso_error *err);

/* Of a picture that is rendered large for an inset. */
enum { ISO_FIGURE_MOST_PIXELS = 64 << 20 };

/* " of NAME (SCENE)", for captions. */
void iso_figure_put_subject(const iso_figure_subject *s, FILE *caption);
/* Width over height of the scene's picture. */
double iso_figure_aspect(const iso_figure_subject *s);

#endif
