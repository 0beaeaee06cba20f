/* SPDX-License-Identifier: MIT */
/* picture.h - the subject of a figure's pictures, and rendering for print. */
#pragma once

#include "figure/job.h"
#include "renderers/renderers.h"
#include "scene/viewpoint.h"

/* Zeroed: empty. */
typedef struct iso_figure_subject {
    const iso_figure_job *job;
    iso_pyramid pyramid;
    iso_scene scene;
    iso_tf_table tf; /* of level 0, from the scene */
    iso_renderers renderers;
    const iso_renderer_info *drawn_by; /* renderer of the last picture */
} iso_figure_subject;

/* Loads the job's volume, with at least this number of levels, and its scene. build: NULL for the defaults.
 * ISO_E_RANGE: a pyramid on disk has fewer. */
iso_status iso_figure_subject_load(iso_figure_subject *s, const iso_figure_job *job, size_t level_count,
                                   const iso_pyramid_options *build, iso_error *err);
/* Creates the scene's transfer function for the pyramid's level 0. */
iso_status iso_figure_scene_tf(const iso_scene *scene, const iso_pyramid *p, iso_tf_table *tf, iso_error *err);
void iso_figure_subject_end(iso_figure_subject *s); /* accepts empty */

/* Finds the renderer of --with; by default the fastest. */
iso_status iso_figure_renderer(const iso_figure_job *job, const iso_renderer_info **with, iso_error *err);

typedef struct iso_figure_picture {
    const iso_renderer_info *with;
    bool named; /* True for exactly this renderer; otherwise iso_renderers_choose() may replace it */
    size_t level;
    size_t width, height;               /* in pixels */
    const iso_viewpoint *viewpoint;     /* of a camera that frames the box; NULL: the scene's */
    double turn_deg;                    /* turns the camera around the scene's up axis */
    size_t turns;                       /* number of equal parts of a full turn that the frames show; 0: one frame */
    const iso_direction_source *source; /* NULL: the renderer's default */
    const iso_cli_roi *region;          /* a finer level in a box; or NULL */
    bool adapted;                       /* True under the transfer function adapted to the level */
} iso_figure_picture;
/* Renders a picture. mm_per_pixel may be NULL. */
iso_status iso_figure_render(iso_figure_subject *s, const iso_figure_picture *what, iso_image *image,
                             double *mm_per_pixel, iso_error *err);

/* Limit of a picture that is rendered for an inset. */
enum { ISO_FIGURE_MOST_PIXELS = 64 << 20 };

/* Writes " of NAME (SCENE)" into a caption. */
void iso_figure_put_subject(const iso_figure_subject *s, FILE *caption);
/* Returns width divided by height of the scene's picture. */
double iso_figure_aspect(const iso_figure_subject *s);
