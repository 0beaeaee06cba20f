/* SPDX-License-Identifier: MIT */
/* povray.h - POV-Ray scenes of a level, and POV-Ray as a renderer.
 *
 * A scene is a folder: NAME.pov (camera, background), NAME.inc (the volume: declared names, the TF as color_maps, the
 * media), NAME.ini ("povray NAME.ini" in that folder renders it) and DF3 files, big endian. These have a rim of one
 * voxel of edge values, which makes `interpolate 1` equal to clamping.
 *
 * The media use method 2: N equal intervals of the ray inside the box (or of its pieces between cutting planes),
 * samples at the midpoints,
 *     C = sum E_i ds exp(-sigma_i ds / 2) exp(-sum_{j<i} sigma_j ds),
 * N is at most 255. With planes = 0 the samples are those of ISO_QUADRATURE_POVRAY. The error is of second order in ds,
 * so that extrapolation removes most of it.
 *
 * Scalars of 8 and 16 bits and linear direction codes (fit, snorm) are stored exactly in 8 or 16 bits, floats in
 * df3_bits over their range. POV-Ray computes colors in float and writes 16 bits: half a step is 7.6e-6 of the
 * brightest possible color. Alpha comes from a second pass without emission over white.
 *
 * A 2D transfer function is a DF3 of its rows. A region of interest (scene/roi.h) is a second set of media in the same
 * container, with its own lattice and TF; both are multiplied by their weights.
 *
 * Isosurface: instead of the media, the first point of a ray inside the box with a value of at least iso, opaque: C =
 * c(iso) shade(d), A = 1, with the TF's color c and the shade of the pre-computed direction. The same as
 * ISO_QUADRATURE_FIRST_HIT. */
#pragma once

#include "base/process.h"
#include "base/progress.h"
#include "brick/lattice.h"
#include "image/image.h"
#include "pyramid/pyramid.h"
#include "scene/scene.h"

#define ISO_POVRAY_MAX_INTERVALS 255 /* a fixed array inside POV-Ray */
#define ISO_POVRAY_MAX_PLANES 100    /* two of its 256 trace levels per plane */
#define ISO_POVRAY_MAX_PICTURES 16   /* per start of POV-Ray */

/* Environment variable: if set, each pass starts its own POV-Ray. For bench job. */
#define ISO_POVRAY_APART "ISOSHADE_PICTURES_APART"

/* Measurements of a render inside POV-Ray, over all its passes. */
typedef struct iso_povray_stats {
    double trace_seconds;     /* without start, DF3 files and parsing */
    double processor_seconds; /* summed over all threads */
    double df3_bytes;         /* of the DF3 files, which POV-Ray keeps in this form */
} iso_povray_stats;

typedef struct iso_povray_options {
    size_t intervals;       /* 2 to 255 per piece of a ray */
    size_t planes;          /* cutting planes across the view: 0 to 100 */
    bool extrapolate;       /* Richardson from intervals / 2 and intervals */
    unsigned df3_bits;      /* 16 or 32, for values that 8 or 16 bits do not hold exactly */
    double quantum;         /* scalars are whole multiples of it, exact in 16 bits if these suffice; 0: unknown */
    bool float_directions;  /* iso_level.directions instead of the codes */
    bool isosurface;        /* first hit instead of volume rendering */
    double iso;             /* the value of the isosurface */
    const double (*box)[3]; /* low and high corner of the visible part, in voxels; NULL: 0 to box_index */
    const iso_volume *volume;   /* scalars of level 0 if the pyramid has none (pyramid/narrow.h); or NULL */
    const iso_lattice *lattice; /* samples of a level without voxels of its own: the lattice's box; or NULL */
    int threads;
    iso_povray_stats *stats; /* filled by renders; or NULL */
} iso_povray_options;
/* Returns the converged setting: 255 intervals, 8 planes, extrapolated, 32 bits. */
iso_povray_options iso_povray_defaults(void);
/* Sets the fewest pieces of equally many intervals that make the longest ray's step at most step_voxels; no
 * extrapolation. g: geometry of the level. */
void iso_povray_set_step(const iso_geometry *g, const iso_view *view, double step_voxels, iso_povray_options *options);

/* Returns the bytes of the DF3 files in a folder, such as an export. */
double iso_povray_df3_bytes(const char *folder);

/* Returns e.g. "3.7.0.10". ISO_E_MISSING, ISO_E_PROGRAM. */
iso_status iso_povray_version(char *version, size_t size, iso_error *err);

/* Runs POV-Ray with iso_process_run(). On a busy machine POV-Ray gives up, before it renders anything, if its threads
 * do not start within seconds: it is then started again, at most five times. A signal or the time limit ends it for
 * good. */
iso_status iso_povray_run_program(const char *const argv[], const iso_process_options *options, iso_error *err);

/* Returns the brightest possible value of a picture of the view. POV-Ray writes 16 bits per channel relative to it, so
 * the rounding error is at most half of peak / 65535. */
double iso_povray_peak(const iso_view *view);

/* Writes the folder, complete or not at all. Replaces an older export of the same name. ISO_E_RANGE: options outside
 * their limits, or no such level. */
iso_status iso_povray_export(const iso_pyramid *p, size_t level, const iso_view *view, const char *dir,
                             const iso_povray_options *opt, const iso_progress *progress, iso_error *err);

/* Exports to a private folder and runs POV-Ray there; contract as iso_reference_render(). */
iso_status iso_povray_render(const iso_pyramid *p, size_t level, const iso_view *view, const iso_povray_options *opt,
                             iso_image *image, const iso_progress *progress, iso_error *err);

/* Pictures that differ only in their intervals (opt->intervals and opt->extrapolate are ignored), from one export and
 * one start of POV-Ray; all or none. At most ISO_POVRAY_MAX_PICTURES. */
typedef struct iso_povray_pictures {
    const size_t *intervals;
    size_t count;
    iso_image *images;
} iso_povray_pictures;
iso_status iso_povray_render_several(const iso_pyramid *p, size_t level, const iso_view *view,
                                     const iso_povray_options *opt, const iso_povray_pictures *wanted,
                                     const iso_progress *progress, iso_error *err);

/* Pictures of one size of several scenes from one start of POV-Ray, each as iso_povray_render() makes it; all or none.
 * At most ISO_POVRAY_MAX_PICTURES / 2 scenes, because an extrapolated picture takes two. The first scene's threads and
 * stats apply to all. */
typedef struct iso_povray_wanted {
    const iso_pyramid *pyramid;
    size_t level;
    const iso_view *view;
    const iso_povray_options *options;
} iso_povray_wanted;
iso_status iso_povray_render_scenes(const iso_povray_wanted *scenes, size_t count, iso_image *images,
                                    const iso_progress *progress, iso_error *err);
