/* SPDX-License-Identifier: MIT */
/* scene_parts.h - parts of NAME.inc, each written by a file of its own; private to this folder. */
#ifndef ISO_POVRAY_SCENE_PARTS_H
#define ISO_POVRAY_SCENE_PARTS_H

#include "povray/scene_text.h"

/* How bright highlights can be. */
double iso_povray_specular_sum(const iso_view *view);

/* transfer_text.c: the TF as density maps, or as lookups of DF3 tables. */
void iso_povray_write_transfer_function(FILE *f, const iso_povray_scene *s);

/* Marks the entries that a color_map of channels [from, to) needs: those between two kept ones lie on the line between
 * them, within `tolerance`. keep: tf->count, all false. Returns how many. */
size_t iso_povray_mark_bends(const iso_tf_table *tf, const int channels[2], double tolerance, bool *keep);

/* tf_text.c: NAME_tf.inc, the transfer function as a color_map to edit; and in NAME.inc what takes a map that was changed,
 * before what takes the exact table. */
bool iso_povray_has_editable_map(const iso_povray_scene *s);
void iso_povray_begin_edited(FILE *f, const iso_povray_scene *s);
void iso_povray_end_edited(FILE *f, const iso_povray_scene *s);

/* shading_text.c: lights; diffuse light and highlights at a point; and the isosurface, which is shaded by them. */
void iso_povray_write_lights(FILE *f, const iso_view *view);
void iso_povray_write_diffuse(FILE *f, const iso_povray_scene *s);
void iso_povray_write_specular(FILE *f, const iso_povray_scene *s);
void iso_povray_write_surface(FILE *f, const iso_povray_scene *s);

/* The text with its declared names made those of the finer layer. */
void iso_povray_write_renamed(FILE *f, const char *text);

/* The planes that a scene clips by, in voxel coordinates. */
void iso_povray_write_clips(FILE *f, const iso_povray_scene *s);

/* "select(Iso_Opaque(x, y, z), 0, " when part of the TF is transparent: what follows is not evaluated there. */
const char *iso_povray_lazily(const iso_povray_scene *s, const char *select);

#endif
