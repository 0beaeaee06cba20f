/* SPDX-License-Identifier: MIT */
/* scene_parts.h - parts of NAME.inc, one source file each; private to this folder. */
#pragma once

#include "povray/scene_text.h"

/* Returns the brightest possible highlight. */
double iso_povray_specular_sum(const iso_view *view);

/* Writes the TF as density maps, or as lookups of DF3 tables (transfer_text.c). */
void iso_povray_write_transfer_function(FILE *f, const iso_povray_scene *s);

/* Marks the entries that a color_map of channels [from, to) needs: entries between two kept ones lie on the line
 * between them, within `tolerance`. keep: tf->count, all false. Returns their number. */
size_t iso_povray_mark_bends(const iso_tf_table *tf, const int channels[2], double tolerance, bool *keep);

/* True if NAME_tf.inc holds the TF as an editable color_map (tf_text.c). The others begin and end the part of NAME.inc
 * that uses an edited map; if the map is as exported, the exact table is used. */
bool iso_povray_has_editable_map(const iso_povray_scene *s);
void iso_povray_begin_edited(FILE *f, const iso_povray_scene *s);
void iso_povray_end_edited(FILE *f, const iso_povray_scene *s);

/* Writes lights; diffuse light and highlights at a point; the isosurface with this shading (shading_text.c). */
void iso_povray_write_lights(FILE *f, const iso_view *view);
void iso_povray_write_diffuse(FILE *f, const iso_povray_scene *s);
void iso_povray_write_specular(FILE *f, const iso_povray_scene *s);
void iso_povray_write_surface(FILE *f, const iso_povray_scene *s);

/* Writes the text with its declared names renamed to those of the finer layer. */
void iso_povray_write_renamed(FILE *f, const char *text);

/* Writes the clip planes of a scene, in voxel coordinates. */
void iso_povray_write_clips(FILE *f, const iso_povray_scene *s);

/* Returns `select`, e.g. "select(Iso_Opaque(x, y, z), 0, ", which skips the rest in transparent places; "" if the TF
 * has no transparent part. */
const char *iso_povray_lazily(const iso_povray_scene *s, const char *select);
