/* SPDX-License-Identifier: MIT */
/* vdb_file.h - how a file of grids comes about; private to this folder.
 *
 *   vdb.c            saving: metadata, units, and the file
 *   vdb_grids.c      the grids of a level and of a lattice, as sources of rows
 *   vdb_sparse.c     which voxels of a level are active
 *   vdb_read.c       reading back, measuring
 *   vdb_library.c    isoshade_openvdb.so, which has the rest, loaded
 *   vdb_openvdb.cc   OpenVDB; vdb_tree.h: grids that are written without ever being whole in memory,
 *                    vdb_leaves.h: by several threads
 *   vdb_nanovdb.cc   NanoVDB, by its own conversion of OpenVDB grids (nanovdb.h); vdb_guarded.h: exceptions end there */
#ifndef ISO_VDB_FILE_H
#define ISO_VDB_FILE_H

#include "pyramid/narrow.h"
#include "vdb/vdb.h"
#include "vdb/vdb_openvdb.h"
#include "vdb/vdb_sparse.h"

/* Rows that run the other way. */
typedef struct iso_vdb_reversed {
    void (*read)(const void *user, size_t x, size_t y, size_t z, size_t count, float *out);
    void (*read_active)(const void *user, size_t x, size_t y, size_t z, size_t count, unsigned char *out);
    const void *user, *active_user;
    bool (*prepare)(void *user, const size_t first[3], const size_t end[3]);
    void *prepare_user;
    size_t width, wide; /* of rows; with the rim */
    size_t channels;
} iso_vdb_reversed;

enum { ISO_VDB_MAX_GRIDS = 4 };

/* Source of the grids of a level. It stays in place until the file is written. */
typedef struct iso_vdb_grids {
    const iso_lattice *lattice; /* or a level: */
    const iso_level *level;
    const iso_volume *volume; /* its scalars if it has none */
    iso_narrow_codes made;    /* owned: its codes, box by box, if it has none */
    iso_code code;
    const uint8_t *tf_2d, *extinction_scale;
    float direction_scale;
    iso_vdb_activity activity; /* owned; empty: all voxels are active */
    iso_vdb_reversed reversed[ISO_VDB_MAX_GRIDS];
} iso_vdb_grids;

/* The data being saved. */
typedef struct iso_vdb_job {
    const iso_openvdb *openvdb;
    iso_vdb_file *file;
    const char *path;
    const iso_vdb_options *opt;
    bool plain_names;
} iso_vdb_job;

/* NULL where it cannot be loaded, with ISO_E_MISSING; path: of the file that it is wanted for. */
const iso_openvdb *iso_vdb_library(const char *path, iso_error *err);

/* Fills in the shared description of a level or a lattice. */
iso_vdb_source iso_vdb_describe(const iso_geometry *g, const char *made_from, const iso_vdb_options *opt);
iso_status iso_vdb_fail(int code, const char *path, const iso_vdb_message *message, iso_error *err);

/* Adds the grids of level k to the file; shown: of this level, or NULL. */
iso_status iso_vdb_add_level(const iso_vdb_job *job, const iso_pyramid *p, size_t k, const iso_vdb_shown *shown,
                             iso_vdb_grids *grids, iso_error *err);
iso_status iso_vdb_add_lattice(const iso_vdb_job *job, const iso_lattice *l, const char *made_from,
                               iso_vdb_grids *grids, iso_error *err);
void iso_vdb_grids_destroy(iso_vdb_grids *grids); /* accepts empty */

/* Voxel 0 gets the index `first` along each axis, and stays where it is in the world. */
void iso_vdb_begin_at(iso_vdb_source *source, const long first[3]);

#endif
