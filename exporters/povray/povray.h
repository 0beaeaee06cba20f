/* SPDX-License-Identifier: MIT */
/* povray.h - POV-Ray scenes of a level, and POV-Ray as a renderer.
 *
 * A scene is a folder: NAME.pov (camera, background), NAME.inc (the volume:
 * declared names, the TF as color_maps, the media), NAME.ini ("povray NAME.ini"
 * in that folder renders it) and DF3 files, big endian, with a rim of one voxel
 * of edge values, which makes `interpolate 1` equal to clamping.
 *
 * The media use method 2: N equal intervals of the ray inside the box (or of
 * its pieces between cutting planes), samples at the midpoints,
 *     C = sum E_i ds exp(-sigma_i ds / 2) exp(-sum_{j<i} sigma_j ds),
 * N is at most 255. With planes = 0 the samples are those of ISO_QUADRATURE_POVRAY. The
 * error is of second order in ds, so that extrapolation removes most of it.
 *
 * Scalars of 8 and 16 bits and linear direction codes (fit, snorm) are stored
 * exactly (8 or 16 bits); what is float is stored in df3_bits over its range. POV-Ray
 * computes colors in float and writes 16 bits: half a step is 7.6e-6 of the
 * brightest possible color. Alpha comes from a second pass without emission
 * over white.
 *
 * A 2D transfer function is a DF3 of its rows. A region of interest
 * (scene/roi.h) is a second set of media in the same container, with a lattice
 * and a TF of its own; both are multiplied by their weights.
 *
 * Isosurface: instead of the media, the first point of a ray inside the box
 * where the value is at least iso, opaque: C = c(iso) shade(d), A = 1, with the
 * TF's color c and the shade of the pre-computed direction. The same as
 * ISO_QUADRATURE_FIRST_HIT. */
#ifndef ISO_EXPORT_POVRAY_H
#define ISO_EXPORT_POVRAY_H

#include "base/process.h"
#include "base/progress.h"
#include "brick/lattice.h"
#include "image/image.h"
#include "pyramid/pyramid.h"
#include "scene/scene.h"

#define ISO_POVRAY_MAX_INTERVALS 255 /* a fixed vector inside POV-Ray */
#define ISO_POVRAY_MAX_PLANES 100    /* two trace levels a plane, of 256 */
#define ISO_POVRAY_MAX_PICTURES 16   /* of one start */

/* Environment: set, each pass is a start of its own. For bench job. */
#define ISO_POVRAY_APART "ISOSHADE_PICTURES_APART"

/* Measurements of a render inside POV-Ray, over all its passes. */
typedef struct iso_povray_stats {
    double trace_seconds;     /* without starting, reading DF3 files and parsing */
    double processor_seconds; /* the same over all threads */
    double df3_bytes;         /* of the DF3 files, which POV-Ray holds as they are */
} iso_povray_stats;

typedef struct iso_povray_options {
    size_t intervals;       /* 2 to 255 a piece of a ray */
    size_t planes;          /* cutting planes across the view: 0 to 100 */
    bool extrapolate;       /* Richardson from intervals / 2 and intervals */
    unsigned df3_bits;      /* 16 or 32, for values that 8 or 16 bits do not hold exactly */
    double quantum;         /* scalars are whole multiples of it, and exact in 16 bits where these hold as many; 0: not known */
    bool float_directions;  /* iso_level.directions instead of the codes */
    bool isosurface;        /* first hit instead of volume rendering */
    double iso;             /* the value of the isosurface */
    const double (*box)[3]; /* low and high corner of the visible part, in voxels; NULL: 0 to box_index */
    const iso_volume *volume; /* level 0's scalars where the pyramid has none (pyramid/narrow.h); or NULL */
    const iso_lattice *lattice; /* what the level's samples are where it has none: it is the lattice's box; or NULL */
    int threads;
    iso_povray_stats *stats; /* filled by renders; or NULL */
} iso_povray_options;
/* Converged: 255 intervals, 8 planes, extrapolated, 32 bits. */
iso_povray_options iso_povray_defaults(void);
/* As few pieces of equally many intervals as make the longest ray's step at most step_voxels; not extrapolated. g: of
 * the level. */
void iso_povray_set_step(const iso_geometry *g, const iso_view *view, double step_voxels, iso_povray_options *options);

/* Bytes of the DF3 files in a folder, such as an export. */
double iso_povray_df3_bytes(const char *folder);

/* "3.7.0.10". ISO_E_MISSING, ISO_E_PROGRAM. */
iso_status iso_povray_version(char *version, size_t size, iso_error *err);

/* iso_process_run() of POV-Ray, which gives up where its threads do not start within seconds, as on a machine with much
 * other work. Nothing has been rendered then, and it is started again, five times at most; not where a signal or its
 * limit of time ended it. */
iso_status iso_povray_run_program(const char *const argv[], const iso_process_options *options, iso_error *err);

/* The brightest value that a picture of the view can have. POV-Ray writes 16 bits a channel relative to it, so pictures
 * are rounded by up to half of peak / 65535. */
double iso_povray_peak(const iso_view *view);

/* The folder; complete or absent. An older export of the same name is replaced.
 * ISO_E_RANGE: options outside their limits, a level that is not there. */
iso_status iso_povray_export(const iso_pyramid *p, size_t level, const iso_view *view, const char *dir,
                             const iso_povray_options *opt, const iso_progress *progress, iso_error *err);

/* Exports to a private folder and runs POV-Ray there: as iso_reference_render. */
iso_status iso_povray_render(const iso_pyramid *p, size_t level, const iso_view *view, const iso_povray_options *opt,
                             iso_image *image, const iso_progress *progress, iso_error *err);

/* Pictures that differ in their intervals alone (opt->intervals is not read, nor is opt->extrapolate), by one export
 * and one start of POV-Ray; all or none. At most ISO_POVRAY_MAX_PICTURES. */
typedef struct iso_povray_pictures {
    const size_t *intervals;
    size_t count;
    iso_image *images;
} iso_povray_pictures;
iso_status iso_povray_render_several(const iso_pyramid *p, size_t level, const iso_view *view,
                                     const iso_povray_options *opt, const iso_povray_pictures *wanted,
                                     const iso_progress *progress, iso_error *err);

/* Pictures of one size of several scenes by one start of POV-Ray, each what iso_povray_render() makes of it; all or
 * none. At most half of ISO_POVRAY_MAX_PICTURES scenes: an extrapolated picture is made of two. The first scene's
 * threads and stats are those of all. */
typedef struct iso_povray_wanted {
    const iso_pyramid *pyramid;
    size_t level;
    const iso_view *view;
    const iso_povray_options *options;
} iso_povray_wanted;
iso_status iso_povray_render_scenes(const iso_povray_wanted *scenes, size_t count, iso_image *images,
                                    const iso_progress *progress, iso_error *err);

#endif
