/* SPDX-License-Identifier: MIT */
/* pyramid_layout.h - the files of a pyramid and its description; private to src/pyramid. */
#pragma once

#include <jansson.h>
#include <xxhash.h>

#include "pyramid/pyramid.h"

#define ISO_PYRAMID_SCHEMA "isoshade.pyramid/1"
#define ISO_PYRAMID_MARKER "pyramid.json"

/* One file of a level. */
typedef struct level_file {
    const char *key, *suffix;
    size_t components;
    iso_type type;
    bool stored;   /* by the options; FILE_SCALE by the level */
    bool is_bytes; /* in memory, too */
    bool is_kept;  /* True if samples keep their type in memory, by iso_large_samples() */
    size_t bytes;
    XXH64_hash_t hash; /* XXH3 of the whole file */
} level_file;

enum { FILE_SCALAR, FILE_CODES, FILE_DIRECTIONS, FILE_MAGNITUDE, FILE_SCALE, FILE_COUNT };

void iso_layout_files(const iso_pyramid_options *opt, iso_type scalar_type, level_file files[FILE_COUNT]);
/* Writes a name such as "level_K_dir.nrrd". */
void iso_layout_name(const level_file *f, size_t level, char name[64]);
/* Returns the type that the scalars of level 0 are stored in. */
iso_type iso_layout_type(iso_type input);
/* Returns the text before the samples: NRRD0004, raw, little-endian. Space origin is the center of the first
 * voxel. A comment fills it up to a multiple of 64 bytes, so that a mapped file has its samples aligned. To be
 * freed. */
char *iso_layout_header(const iso_geometry *g, const level_file *f);

/* Reads a level's file: `count` samples as floats, codes as bytes, or all as they are; to be freed. ISO_E_FORMAT if its
 * size, header or checksum differ from pyramid.json; ISO_E_IO, ISO_E_MEMORY. */
iso_status iso_layout_read(const char *path, const char *header, const level_file *f, const char *digest, size_t count,
                           void **data, iso_error *err);
/* Converts samples of the scalar's file to floats. */
void iso_layout_to_floats(const void *in, iso_type type, size_t count, float *out);

json_t *iso_layout_options(const iso_pyramid_options *opt);
json_t *iso_layout_geometry(const iso_geometry *g);
json_t *iso_layout_level(const iso_geometry *g, iso_type scalar_type, double min, double max,
                         const level_file files[FILE_COUNT], size_t level);
/* Writes the choice for a coarse level into its object; leaves the object unchanged if nothing was chosen. */
void iso_layout_choice(const iso_pyramid_options *opt, size_t level, json_t *object);
/* Writes pyramid.json; takes ownership of the list of levels. of: the pyramid, for its scene, its choices and its
 * segments; or NULL. */
iso_status iso_layout_save(const char *dir, const char *source, const iso_pyramid_unit *unit,
                           const iso_pyramid_options *opt, json_t *levels, const iso_pyramid *of, iso_error *err);
/* Gives each level the pyramid's segments, borrowed. */
void iso_pyramid_share_segments(iso_pyramid *p);
/* Gives coarse levels of a volume with voxels without data their scale (data_share.c), which files leave out. volume:
 * level 0's samples, if it has none. ISO_E_MEMORY. */
iso_status iso_pyramid_scale_by_share(iso_pyramid *p, const iso_volume *volume, iso_error *err);
/* Writes numbers with 17 digits, so that they are read back exactly. */
iso_status iso_layout_save_json(const char *dir, const char *name, const json_t *root, iso_error *err);

/* Loads pyramid.json. ISO_E_IO; ISO_E_FORMAT if it is not a pyramid's or was changed: changed levels, ranges or boxes
 * would give a wrong picture and no error. */
iso_status iso_layout_load(const char *path, json_t **root, iso_error *err);
