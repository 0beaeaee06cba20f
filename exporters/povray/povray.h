/* povray.h - POV-Ray scenes of a level, and POV-Ray as a renderer.
 *
 * DF3 files (16 bits scalar and directions, or 32), an include with the TF, the
 * media and the declared names, a scene with camera and lights, an .ini beside
 * it. media { method 2 samples 1,1 jitter 0 intervals N }: N equal intervals of
 * the chord, midpoint samples, weight tau exp(-tau / 2). Converged mode cuts the
 * ray by planes and extrapolates. Alpha comes from a second pass without
 * emission over white. */
#ifndef ISO_EXPORT_POVRAY_H
#define ISO_EXPORT_POVRAY_H

#include "base/progress.h"
#include "image/image.h"
#include "pyramid/pyramid.h"
#include "render/scene.h"

typedef struct iso_povray_options {
    size_t intervals;   /* 1 to 255 a ray (and slab) */
    size_t planes;      /* cutting planes: 0 is lock-step with the reference */
    bool extrapolate;   /* Richardson from N/2 and N intervals */
    bool df3_32bit;     /* scalar and directions in 32 bits instead of 16 */
    int threads;
} iso_povray_options;
iso_povray_options iso_povray_defaults(void);

iso_status iso_povray_version(char *version, size_t size, iso_error *err);

/* A folder: NAME.pov, NAME.inc, NAME.ini and the DF3 files; complete or absent. */
iso_status iso_povray_export(const iso_pyramid *p, size_t level, const iso_view *view, const char *dir,
                             const iso_povray_options *opt, const iso_progress *progress, iso_error *err);

iso_status iso_povray_render(const iso_pyramid *p, size_t level, const iso_view *view, const iso_povray_options *opt,
                             iso_image *image, const iso_progress *progress, iso_error *err);

#endif
