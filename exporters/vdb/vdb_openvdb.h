/* SPDX-License-Identifier: MIT */
/* vdb_openvdb.h - the interface between C (vdb.c) and C++ (vdb_openvdb.cc): plain types, no exceptions.
 *
 * The C++ is in isoshade_openvdb.so, in the folder of the program. It is loaded only to write or read grid files:
 * OpenVDB and its dependencies take longer to load than the rest of the program.
 *
 * Transforms are rows of a 3 x 4 matrix from OpenVDB's index (integers at voxel centers) to world. Private to
 * exporters/vdb. */
#pragma once

#include <stdbool.h>
#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

enum { ISO_OPENVDB_OK, ISO_OPENVDB_IO, ISO_OPENVDB_NO_GRID, ISO_OPENVDB_MEMORY, ISO_OPENVDB_FAILED };

/* Forms of a file; small: OpenVDB's smallest, at several times the time. */
typedef enum iso_openvdb_form { ISO_OPENVDB_PLAIN, ISO_OPENVDB_SMALL, ISO_OPENVDB_NANO } iso_openvdb_form;

typedef struct iso_vdb_message {
    char text[512];
} iso_vdb_message;

/* A grid to be written. */
typedef struct iso_vdb_source {
    const char *name;
    int channels; /* 1: float; 3: vec3s, covariant, in world space */
    size_t size[3];
    long first[3]; /* index of voxel (0, 0, 0) */
    size_t pad;    /* rim of repeated edge values */
    double index_to_world[3][4];
    /* Copies `count` voxels of row (y, z) from x on, `channels` floats each. */
    void (*read)(const void *user, size_t x, size_t y, size_t z, size_t count, float *out);
    const void *user;
    /* Called before voxels in [first, end) are read; no other call runs meanwhile, and earlier voxels are not read
     * again. Returns false if out of memory. NULL: all voxels can be read at any time. */
    bool (*prepare)(void *user, const size_t first[3], const size_t end[3]);
    void *prepare_user;
    /* Writes one byte per voxel, 1 if active, of row (y, z) from x on, counted with the rim; others are background.
     * NULL: all are active. */
    void (*read_active)(const void *user, size_t x, size_t y, size_t z, size_t count, unsigned char *out);
    const void *active_user;
    float background;
    bool fog_volume;
    bool is_color, y_up; /* is_color: three channels that axes do not rotate; y_up: the world is rotated (fields.h) */
    double direction_scale;      /* factor of vectors; 1 for other grids */
    bool half_float, reversed_x; /* reversed_x: rows run against the volume's x */
    int threads; /* threads that read and compress values, at least 1; all call read() at the same time */
    const char *creator, *made_from, *meaning;
    /* Segments of a label map as JSON (volume/segments.h), "[]" if none has a name; NULL for other volumes. */
    const char *labels;
    int level;
    double value_min, value_max, box_index[3], spacing_mm[3];
    const char *unit; /* of the transform; "" if it has no name */
    double unit_mm, origin_mm[3];
} iso_vdb_source;

typedef struct iso_vdb_file iso_vdb_file;

/* Contents of a grid's header. box_index is size if the file has none. */
typedef struct iso_vdb_grid_info {
    double index_to_world[3][4];
    double box_index[3];
    double unit_mm, origin_mm[3];
} iso_vdb_grid_info;

#define ISO_OPENVDB_SYMBOL "iso_openvdb_functions"

typedef struct iso_openvdb {
    /* Returns NULL if out of memory. */
    iso_vdb_file *(*create)(void);
    /* Reads the active flags of a source. write() reads the values later, in any order within the prepared box, so the
     * data of the source must stay until then. */
    int (*add)(iso_vdb_file *file, const iso_vdb_source *source, iso_vdb_message *message);
    /* Adds an entry to the file's metadata. */
    int (*note)(iso_vdb_file *file, const char *key, const char *text, iso_vdb_message *message);
    int (*write)(const iso_vdb_file *file, const char *path, iso_openvdb_form form, iso_vdb_message *message);
    void (*destroy)(iso_vdb_file *file); /* accepts NULL */
    int (*read)(const char *path, const char *grid, int channels, const size_t size[3], float *out,
                iso_vdb_grid_info *info, iso_vdb_message *message);
    /* Reads all grids of a file; sums the active voxels and the bytes of the trees, by OpenVDB's count. */
    int (*measure)(const char *path, size_t *active_voxels, size_t *memory_bytes, iso_vdb_message *message);
    const char *(*nanovdb_version)(void); /* NULL: built without NanoVDB's headers */
} iso_openvdb;

#ifdef __cplusplus
}
#endif
