/* SPDX-License-Identifier: MIT */
/* vdb_file.h - internals of writing grid files; private to this folder.
 *
 *   vdb.c            saving: metadata, units, and the file
 *   vdb_grids.c      the grids of a level and of a lattice, as sources of rows
 *   vdb_sparse.c     active voxels of a level
 *   vdb_library.c    loads isoshade_openvdb.so, which contains:
 *   vdb_openvdb.cc   OpenVDB; vdb_tree.h: grids that are never complete in memory, vdb_leaves.h: written by several threads
 *   vdb_nanovdb.cc   NanoVDB, from the same grids; vdb_guarded.h: exceptions end here */
#pragma once

#include "pyramid/narrow.h"
#include "vdb/vdb.h"
#include "vdb/vdb_openvdb.h"
#include "vdb/vdb_sparse.h"

/* Rows in reverse order. */
typedef struct iso_vdb_reversed {
    void (*read)(const void *user, size_t x, size_t y, size_t z, size_t count, float *out);
    void (*read_active)(const void *user, size_t x, size_t y, size_t z, size_t count, unsigned char *out);
    const void *user, *active_user;
    bool (*prepare)(void *user, const size_t first[3], const size_t end[3]);
    void *prepare_user;
    size_t width, wide; /* of rows; wide: including the rim */
    size_t channels;
} iso_vdb_reversed;

enum { ISO_VDB_MAX_GRIDS = 4 };

/* Source of the grids of a level. Must not move until the file is written. */
typedef struct iso_vdb_grids {
    const iso_lattice *lattice; /* or a level: */
    const iso_level *level;
    const iso_volume *volume; /* its scalars if it has none */
    iso_narrow_codes made;    /* owned: codes made box by box if the level has none */
    iso_code code;
    const uint8_t *tf_2d, *extinction_scale;
    float direction_scale;
    iso_vdb_activity activity; /* owned; empty: all voxels are active */
    iso_vdb_reversed reversed[ISO_VDB_MAX_GRIDS];
} iso_vdb_grids;

/* The file being saved. */
typedef struct iso_vdb_job {
    const iso_openvdb *openvdb;
    iso_vdb_file *file;
    const char *path;
    const iso_vdb_options *opt; /* NULL for fields */
    bool plain_names;
} iso_vdb_job;

/* Contents of a file: note() adds its metadata, add() one of `count` parts, which are one or more grids. */
typedef struct iso_vdb_contents {
    iso_status (*note)(const iso_vdb_job *job, void *user, iso_error *err);
    iso_status (*add)(const iso_vdb_job *job, void *user, size_t i, iso_error *err);
    void *user;
    size_t count;
    const iso_vdb_options *opt;
    bool nanovdb;
} iso_vdb_contents;
iso_status iso_vdb_save_file(const iso_vdb_contents *contents, const char *path, const iso_progress *progress,
                             iso_error *err);
/* Adds an entry to the metadata, unless the text is NULL or empty. */
iso_status iso_vdb_note(const iso_vdb_job *job, const char *key, const char *text, iso_error *err);
iso_status iso_vdb_add(const iso_vdb_job *job, const iso_vdb_source *source, iso_error *err);

/* Loads the library. NULL and ISO_E_MISSING if that fails; path: the file to be written or read, for the message. */
const iso_openvdb *iso_vdb_library(const char *path, iso_error *err);

/* Fills the part of a source that all grids of a level or lattice share. */
iso_vdb_source iso_vdb_describe(const iso_geometry *g, const char *made_from, const iso_vdb_options *opt);
iso_status iso_vdb_fail(int code, const char *path, const iso_vdb_message *message, iso_error *err);

/* Adds the grids of level k to the file; shown: of this level, or NULL. */
iso_status iso_vdb_add_level(const iso_vdb_job *job, const iso_pyramid *p, size_t k, const iso_vdb_shown *shown,
                             iso_vdb_grids *grids, iso_error *err);
iso_status iso_vdb_add_lattice(const iso_vdb_job *job, const iso_lattice *l, const char *made_from,
                               iso_vdb_grids *grids, iso_error *err);
void iso_vdb_grids_destroy(iso_vdb_grids *grids); /* accepts empty */

/* Moves voxel 0 to index `first` along each axis; its world position stays. */
void iso_vdb_begin_at(iso_vdb_source *source, const long first[3]);
