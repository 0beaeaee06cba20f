/* SPDX-License-Identifier: MIT */
/* measured.h - what consistency.c measured of the levels, for level_verdict.c to judge. */
#pragma once

#include "report/levels.h"
#include "scene/views.h"
#include "validate/validate.h"

/* Transfer function that a level is shown with. */
typedef enum iso_level_tf_use {
    ISO_USE_ORIGINAL, /* the original transfer function */
    ISO_USE_ADAPTED,  /* the one adapted to the level */
    ISO_USE_SCALED    /* iso_validation.scales */
} iso_level_tf_use;

/* A level as one method shows it, in each view. */
typedef struct iso_measured_level {
    size_t level;
    const iso_method *method;
    iso_level_tf_use use;
    double figures[ISO_LEVEL_FIGURE_COUNT][ISO_FACE_VIEWS];
    double angle_deg; /* mean angle between its directions and level 0's; NaN if none is visible */
} iso_measured_level;

enum { ISO_MEASURED_MOST = 16 }; /* ways to show a level */
typedef struct iso_measured {
    const iso_method *own, *on_the_fly; /* the pyramid's own directions */
    bool shown;                         /* level 0 shows something */
    size_t count, room;
    iso_measured_level *levels;
    /* Of levels that the views left open: the default and the simple way in twenty views; two a level. */
    size_t more_count;
    iso_measured_level *more;
} iso_measured;

/* Returns the use of a transfer function by which a level is judged. */
iso_level_tf_use iso_measured_own_use(const iso_validation *v, size_t level);
const iso_measured_level *iso_measured_find(const iso_measured *all, size_t level, const iso_method *method,
                                            iso_level_tf_use use);
/* True if the default is worse than the simple way in the mean of a figure, and the scatter over the views is larger
 * than the difference. */
bool iso_measured_is_open(const iso_measured_level *own, const iso_measured_level *simple, size_t views);
/* True if it is worse beyond the scatter. More views have to confirm that: of three figures at several levels one is
 * beyond an interval of 95 % by chance more often than once in twenty. */
bool iso_measured_is_behind(const iso_measured_level *own, const iso_measured_level *simple, size_t views);

/* Makes view i of the levels: the scene's, from another side, of the size of v->consistency_size. */
iso_status iso_validate_level_view(const iso_validation *v, size_t i, iso_view *view, iso_error *err);
/* Fills row->scale: are the bytes those that level 0 makes, and do they change a picture? Nothing where v->scales is
 * none. */
iso_status iso_validate_judge_scale(iso_validation *v, const iso_pyramid *rebuilt, iso_report_level *row,
                                    iso_error *err);
/* Renders view i of a level of p, by the renderer that draws all views. */
iso_status iso_validate_render_level(iso_validation *v, const iso_pyramid *p, const iso_measured_level *shown, size_t i,
                                     iso_image *image, iso_error *err);
/* Fills row->bound for the pictures of `own`, which are drawn again with smaller steps if their RMSE is above the
 * bound. Sets *late if the budget is over. */
iso_status iso_validate_bound_level(iso_validation *v, const iso_measured_level *own, iso_report_level *row, bool *late,
                                    iso_error *err);

/* Judges all levels. rebuilt: made of level 0, with the pyramid's own options. */
iso_status iso_validate_judge_levels(iso_validation *v, const iso_measured *all, const iso_pyramid *rebuilt,
                                     iso_error *err);

/* The angle between a level's normals and level 0's, in degrees, at visible fine voxels that have a direction; at most
 * about 1e5 of them, evenly strided. Level 0 is that of v->pyramid, the level one of p. NaN if there are none. */
typedef struct iso_level_angles {
    double mean, p95;
} iso_level_angles;
iso_status iso_validate_angles(const iso_validation *v, const iso_pyramid *p, size_t level, iso_direction_source source,
                               iso_level_angles *angles, iso_error *err);

/* Pyramid and source of the directions that angles are measured of. */
typedef struct iso_angles_of {
    const iso_pyramid *pyramid;
    iso_direction_source source;
} iso_angles_of;
/* Measures how much larger the angles of a are than those of b, at the same voxels, with an interval. Neighbors are
 * interpolated from the same voxels, so blocks of 2 x 2 x 2 of the level's voxels count as one. NaN if there are
 * none. */
iso_status iso_validate_compare_angles(const iso_validation *v, size_t level, iso_angles_of a, iso_angles_of b,
                                       double confidence, iso_paired *difference, iso_error *err);
