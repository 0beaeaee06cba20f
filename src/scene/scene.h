/* SPDX-License-Identifier: MIT */
/* scene.h - settings of a rendering: camera, lights, shading, background, size, step, TF.
 *
 * One scene file (*.scene.json) serves all renderers. Parts of it may be fitted: a fitted camera frames the box of any
 * volume, a fitted TF follows its range. iso_scene_resolve() converts it, for one volume, to an iso_view of plain
 * numbers; renderers and exporters use only the view.
 *
 *   { "schema": "isoshade.scene/1",
 *     "image": {"width": 160, "height": 160},
 *     "camera": {"projection": "perspective" | "orthographic",
 *                "fit": true, "direction": [1, 2, -1], "up": [0, 0, 1],     looking along direction
 *                "margin": 1.05, "fov_y_deg": 30, "zoom": 1}        zoom enlarges the picture's middle
 *            or {"projection": .., "position": [x, y, z], "look_at": [x, y, z], "up": .., "fov_y_deg": | "height_mm":}
 *     "lights": [ {"direction": [0, 0, 1], "space": "world" | "camera", "intensity": 1} ],
 *                 direction points towards the light; camera space: right, up, backwards (towards the viewer)
 *     "clip_planes": [ {"normal": [0, 1, 0], "at": 0.5} | {"normal": .., "point_mm": [x, y, z]} ],   optional, up to 6
 *                 keeps the normal's side; at: 0 at the box's beginning along the normal, 1 at its end
 *     "shading": {"ambient": 0.3, "diffuse": 0.7, "specular": 0.2, "power": 20},
 *     "background": [0, 0, 0],
 *     "step_voxels": 0.5,               ray step, in the smallest spacing of the rendered level
 *     "tf": "name.tf.json" | { ... },   a path relative to the scene file, or the TF itself
 *        or {"file": "preset.xml", "name": "CT-Bone", "unit_distance_mm": 2, "opacity": [0, 1], "range": "fit" | [lo, hi]},
 *                                       a file of another program, and settings that it lacks
 *     "agreement": {"tier": "convergence", "tf": "smooth" | "sharp", "why": "..."},   the limits of validation; optional
 *     "levels": {"ssim_dissimilarity": 0.1, "flip": [0.05, 0.1], "rmse": 0.02},   limits of the levels' errors; optional
 *     "suite": {"make": "shells --size 31x37x29", "isosurface": 0.5} }   the volume, as options of isoshade make; optional
 *
 *   shade(d) = ka + sum over lights of intensity (kd |n.l| + ks |n.h|^p),  h = normalize(l + v), v towards the viewer
 * two-sided; ka + kd sum(intensity) <= 1. Every renderer computes
 *   C = integral of T(t) sigma(s) c(s) shade(d) dt + T_end * background,  T = exp(-integral of sigma). */
#pragma once

#include "tf/tf_2d.h"
#include "tf/tf.h"

#define ISO_MAX_LIGHTS 8
#define ISO_MAX_CLIP_PLANES 6

typedef struct iso_camera {
    bool orthographic;
    iso_vec3 position;           /* world mm; if orthographic, the image plane's center */
    iso_vec3 forward, right, up; /* orthonormal, right-handed: right = forward x up */
    double half_height;          /* tan(fov_y / 2); if orthographic, in mm */
} iso_camera;

typedef struct iso_light {
    iso_vec3 direction; /* unit, towards the light */
    bool in_camera_space;
    double intensity;
} iso_light;

/* Keeps the side normal . p >= offset_mm, normal a unit vector. */
typedef struct iso_clip_plane {
    iso_vec3 normal;
    double offset_mm;
} iso_clip_plane;

typedef struct iso_shading {
    double ambient, diffuse, specular, power;
} iso_shading;

/* Source of a scene's reference image, which sets the limits of validation: enum, name. */
/* clang-format off */
#define ISO_TIER_LIST(X)                                                                                     \
    X(ISO_TIER_CLOSED_FORM, "closed form") /* a formula; for all renderers */                                \
    X(ISO_TIER_TIGHT, "tight")             /* the ray caster's own samples in double precision */            \
    X(ISO_TIER_CONVERGENCE, "convergence") /* limits of halved steps, by all renderers */                    \
    X(ISO_TIER_LIT, "lit")                 /* the same, and visible differences of highlights: FLIP, SSIM */ \
    X(ISO_TIER_FIRST_HIT, "first hit")     /* an isosurface: no quadrature at all */
/* clang-format on */

typedef enum iso_tier {
#define ISO_TIER_ENUM(name, text) name,
    ISO_TIER_LIST(ISO_TIER_ENUM)
#undef ISO_TIER_ENUM
        ISO_TIER_COUNT
} iso_tier;
const char *iso_tier_name(iso_tier tier);

/* sharp: the TF has bends or steps within less than a voxel, so error bars may be wider. */
typedef struct iso_scene_agreement {
    iso_tier tier;
    bool sharp;
    char why[512];
    bool assumed; /* True if not stated by the scene */
} iso_scene_agreement;

/* Limits of the differences between pictures of a coarse level and of level 0, means over the views. A number is for
 * all levels; a list begins with level 1, and its last number is for all coarser levels, too. */
enum { ISO_SCENE_LEVELS = 16 };
typedef struct iso_scene_level_limits {
    size_t count; /* 0: no limits */
    double limits[ISO_SCENE_LEVELS];
} iso_scene_level_limits;
/* Returns a level's limit; NaN if there is none. */
double iso_scene_level_limit(const iso_scene_level_limits *limits, size_t level);

typedef struct iso_scene {
    char *path; /* of its file */
    size_t width, height;
    bool camera_fit;
    bool orthographic;
    iso_vec3 camera_direction, camera_position, camera_look_at, camera_up;
    double fov_y_deg, height_mm, margin;
    double zoom; /* magnification of the picture's middle; 0 and 1: all of it */
    size_t light_count;
    iso_light lights[ISO_MAX_LIGHTS];
    size_t clip_count;
    struct iso_scene_clip {
        iso_vec3 normal, point_mm;
        double at; /* fraction of the box's extent along the normal; NaN: through point_mm */
    } clips[ISO_MAX_CLIP_PLANES];
    iso_shading shading;
    double background[3];
    double step_voxels;
    iso_tf tf;
    iso_scene_agreement agreement;
    struct iso_scene_asked {
        iso_scene_level_limits ssim_dissimilarity, flip, rmse;
    } levels;
    char *suite_make;        /* arguments of `isoshade make`, without -o; NULL: not in a suite */
    double suite_isosurface; /* surface value as a fraction of the volume's range; NaN: none */
} iso_scene;

iso_status iso_scene_load(const char *path, iso_scene *scene, iso_error *err);
/* Reads a scene from an object. A TF file in it is relative to the folder of `path`, which messages name. */
iso_status iso_scene_from_json(const json_t *root, const char *path, iso_scene *scene, iso_error *err);
void iso_scene_destroy(iso_scene *scene);
/* Returns a new object in the form of the file, with the TF in it, without "agreement", "levels" and "suite". */
json_t *iso_scene_to_json(const iso_scene *scene);
/* Writes a file's object, but only if the reader accepts it. */
iso_status iso_scene_save_json(const json_t *root, const char *path, iso_error *err);

/* A scene resolved for one volume: all input of a renderer but the level. */
typedef struct iso_view {
    size_t width, height;
    iso_camera camera;
    size_t light_count;
    iso_light lights[ISO_MAX_LIGHTS]; /* all in world space */
    size_t clip_count;
    iso_clip_plane clips[ISO_MAX_CLIP_PLANES];
    iso_shading shading;
    double background[3];
    double step_voxels;
    iso_tf_table tf;
    iso_tf_2d *tf_2d; /* the 2D transfer function of the rendered level, used instead of tf; owned, or NULL */
    /* Scales the extinction of tf or tf_2d: one byte per voxel of the rendered level (fit/extinction_scale.h);
     * owned, or NULL. */
    uint8_t *extinction_scale;
    struct iso_roi *roi; /* a finer level inside a box (roi.h); owned, or NULL */
} iso_view;

/* Resolves a scene. value_min/max: range of level 0. */
iso_status iso_scene_resolve(const iso_scene *scene, const iso_geometry *level0, double value_min, double value_max,
                             iso_view *view, iso_error *err);
void iso_view_destroy(iso_view *view);
/* True if the view's shading depends on directions; False if no light has an effect. */
bool iso_view_is_lit(const iso_view *view);
/* Returns a new array [{"direction": [x, y, z], "intensity": 1}, ...], towards the lights, in world space. */
json_t *iso_view_lights_to_json(const iso_view *view);
/* Returns the geometry whose spacing is the unit of ray steps: that of the finest level in the view. */
const iso_geometry *iso_view_step_geometry(const iso_view *view, const iso_geometry *level);

/* Returns the height of a pixel in the plane through the box's center, parallel to the image, for scale bars; 0 if that
 * plane is not in front of the camera. */
double iso_view_mm_per_pixel(const iso_view *view, const iso_geometry *level0);

typedef struct iso_ray {
    iso_vec3 origin, direction; /* world mm, unit direction */
} iso_ray;

/* Returns the ray through the center of pixel (column, row); row 0 is the top. */
iso_ray iso_camera_ray(const iso_camera *camera, size_t width, size_t height, size_t column, size_t row);

/* Clips the ray to the box of g: [*t0, *t1] in mm, *t0 >= 0. False if it misses. */
bool iso_ray_box(const iso_ray *ray, const iso_geometry *g, double *t0, double *t1);
/* Does the same, and clips also to the kept side of all clip planes. */
bool iso_view_ray(const iso_view *view, const iso_ray *ray, const iso_geometry *g, double *t0, double *t1);

/* Converts a clip plane to index coordinates of g: keeps plane[0..2] . index >= plane[3]. */
void iso_clip_in_index(const iso_clip_plane *clip, const iso_geometry *g, double plane[4]);
/* True unless a clip plane removes the whole box from lo to hi (index coordinates). May be True for a box that only
 * several planes together remove. */
bool iso_view_keeps(const iso_view *view, const iso_geometry *g, const double lo[3], const double hi[3]);
