/* blender.h - Blender scenes of a level, and Cycles as a renderer.
 *
 * The .blend is made by Blender itself, running the embedded build_scene.py on
 * a JSON description: volume object with a relative path to the VDB, the TF as
 * a packed N x 1 float image, the material as a node group "isoshade", camera,
 * lights as group inputs. Cycles renders the same .blend. */
#ifndef ISO_EXPORT_BLENDER_H
#define ISO_EXPORT_BLENDER_H

#include "base/progress.h"
#include "image/image.h"
#include "pyramid/pyramid.h"
#include "render/scene.h"

typedef struct iso_blender_options {
    double step_voxels;  /* Cycles' step in the level's smallest spacing */
    int samples;         /* 1 goes exactly through the pixel centres */
    int seed;
    int threads;
} iso_blender_options;
iso_blender_options iso_blender_defaults(void);

/* Version of the program found, such as "3.4.1". ISO_E_MISSING. */
iso_status iso_blender_version(char *version, size_t size, iso_error *err);

/* NAME.blend and NAME.vdb beside it. */
iso_status iso_blender_export(const iso_pyramid *p, size_t level, const iso_view *view, const char *blend_path,
                              const iso_blender_options *opt, const iso_progress *progress, iso_error *err);

/* Renders a level with Cycles: background included as in iso_reference_render. */
iso_status iso_cycles_render(const iso_pyramid *p, size_t level, const iso_view *view, const iso_blender_options *opt,
                             iso_image *image, const iso_progress *progress, iso_error *err);

#endif
