/* SPDX-License-Identifier: MIT */
/* vdb_openvdb.h - the interface between C (vdb.c) and C++ (vdb_openvdb.cc): plain types, no exceptions.
 *
 * The C++ is in isoshade_openvdb.so, which lies beside the program and is loaded when a file of grids is written or
 * read: OpenVDB and what it stands on take longer to load than all the rest of the program.
 *
 * Transforms are rows of a 3 x 4 matrix that takes OpenVDB's index (integers at the voxels' centers) to world. Private
 * to exporters/vdb. */
#ifndef ISO_VDB_OPENVDB_H
#define ISO_VDB_OPENVDB_H

#include <stdbool.h>
#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

enum { ISO_OPENVDB_OK, ISO_OPENVDB_IO, ISO_OPENVDB_NO_GRID, ISO_OPENVDB_MEMORY, ISO_OPENVDB_FAILED };

typedef struct iso_vdb_message {
    char text[512];
} iso_vdb_message;

/* One grid to be written. */
typedef struct iso_vdb_source {
    const char *name;
    int channels; /* 1: float; 3: vec3s, covariant, in world space */
    size_t size[3];
    long first[3]; /* index of voxel (0, 0, 0) */
    size_t pad;    /* rim of repeated edge values */
    double index_to_world[3][4];
    /* Copies `count` voxels of the row (y, z) from x on, `channels` floats each. */
    void (*read)(const void *user, size_t x, size_t y, size_t z, size_t count, float *out);
    const void *user;
    /* Called before voxels from `first` to `end`, which is not included, are read, and by nobody else meanwhile: those
     * before are not read again. False when memory ends. NULL: all can be read at any time. */
    bool (*prepare)(void *user, const size_t first[3], const size_t end[3]);
    void *prepare_user;
    /* Which voxels are active, a byte each, of the row (y, z) from x on, counted with the rim; NULL: all. Others are
     * background. */
    void (*read_active)(const void *user, size_t x, size_t y, size_t z, size_t count, unsigned char *out);
    const void *active_user;
    float background;
    bool fog_volume;
    bool is_color, y_up; /* three channels that axes do not turn; the world is turned (fields.h) */
    double direction_scale;      /* that vectors are multiplied by; 1 else */
    bool half_float, reversed_x; /* reversed_x: what is given runs along x the other way than the volume does */
    int threads; /* that read and compress values, at least 1; read() is called by all of them at once */
    const char *creator, *made_from, *meaning;
    const char
        *labels; /* of a label map: its segments as JSON (volume/segments.h), "[]" where none are named; else NULL */
    int level;
    double value_min, value_max, box_index[3], spacing_mm[3];
    const char *unit; /* of the transform; "" where it has no name */
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
    /* NULL when memory ends. */
    iso_vdb_file *(*create)(void);
    /* Asks which voxels are active. Their values are read by write(), in no order within what is prepared, so that what
     * the source's users point to has to stay until then. */
    int (*add)(iso_vdb_file *file, const iso_vdb_source *source, iso_vdb_message *message);
    /* An entry of the file's own metadata. */
    int (*note)(iso_vdb_file *file, const char *key, const char *text, iso_vdb_message *message);
    /* small: as small as can be, in several times the time. */
    int (*write)(const iso_vdb_file *file, const char *path, bool small, iso_vdb_message *message);
    void (*destroy)(iso_vdb_file *file); /* accepts NULL */
    int (*read)(const char *path, const char *grid, int channels, const size_t size[3], float *out,
                iso_vdb_grid_info *info, iso_vdb_message *message);
    /* Reads all grids of a file; active voxels and bytes of the trees, as OpenVDB counts them, summed. */
    int (*measure)(const char *path, size_t *active_voxels, size_t *memory_bytes, iso_vdb_message *message);
    /* All grids of a file as a file of NanoVDB (nanovdb.h). The version is NULL where its headers were not there. */
    int (*to_nanovdb)(const char *vdb_path, const char *path, iso_vdb_message *message);
    const char *(*nanovdb_version)(void);
} iso_openvdb;

#ifdef __cplusplus
}
#endif

#endif
