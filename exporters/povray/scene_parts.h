/* SPDX-License-Identifier: MIT */
/* scene_parts.h - parts of NAME.inc, each written by a file of its own; private to this folder. */
#ifndef ISO_POVRAY_SCENE_PARTS_H
#define ISO_POVRAY_SCENE_PARTS_H

#include "povray/scene_text.h"

/* How bright highlights can be. */
double iso_povray_specular_sum(const iso_view *view);

/* transfer_text.c: the TF as density maps, or as lookups of DF3 tables. */
void iso_povray_write_transfer_function(FILE *f, const iso_povray_scene *s);
/* Negative inside the ranges of the TF without extinction: shading, which is most of the work, is not computed there. */
void iso_povray_write_opaque(FILE *f, const iso_povray_scene *s);

/* shading_text.c: diffuse light and highlights at a point; and the isosurface, which is shaded by them. */
void iso_povray_write_diffuse(FILE *f, const iso_povray_scene *s);
void iso_povray_write_specular(FILE *f, const iso_povray_scene *s);
void iso_povray_write_surface(FILE *f, const iso_povray_scene *s);

/* The planes that a scene clips by, in voxel coordinates. */
void iso_povray_write_clips(FILE *f, const iso_povray_scene *s);

/* "select(Iso_Opaque(x, y, z), 0, " when part of the TF is transparent: what follows is not evaluated there. */
const char *iso_povray_lazily(const iso_povray_scene *s, const char *select);

#endif
