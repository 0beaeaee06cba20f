/* SPDX-License-Identifier: MIT */
/* stream.h - reads and writes volumes plane by plane, so that they may be larger than memory.
 *
 * A source reads a file from its first plane to its last; a sink writes one.
 * iso_volume_load() and iso_volume_save() are built on them.
 *
 * World coordinates (geometry.h) are millimeters. If the file names an
 * anatomical space (NRRD: left-posterior-superior and the like; NIfTI with an
 * sform or a qform) they are turned to right, anterior, superior, so that one
 * patient lies in one place in every file format; a reflected space (LAS)
 * gives a reflected index_to_world. Else the world is the file's own frame.
 *   NRRD   space directions are the columns of index_to_world; space origin is
 *          the center of the first sample, so origin_mm = space origin - half a
 *          step along each axis. Without a space: spacings along the world's
 *          axes, axis mins if all three are given; otherwise the box is centered.
 *          Known units (unit.h) are converted, others refused; without one lengths are mm.
 *   NIfTI  (1 and 2) sform before qform before bare pixdim (centered); its matrix maps
 *          voxel centers, so the corner lies at (-1/2, -1/2, -1/2).
 * doc/reference/formats-read.md has the other formats. Trailing axes of one sample are dropped. Of several
 * time steps or several numbers per voxel one is chosen (frames.h). Volumes of two axes are refused. */
#pragma once

#include "volume/volume.h"

typedef struct iso_volume_source iso_volume_source;

/* Reads the header and checks it against the size of the file. Statuses as
 * iso_volume_load. *source stays NULL on failure. Other threads may read from it, but not for longer than the thread
 * lives that opened it: a program that reads the format ends with that. */
iso_status iso_source_open(const char *path, iso_volume_source **source, iso_error *err);
/* Values that the file lacks, or has wrong. */
typedef struct iso_volume_hints {
    const char *unit;     /* of its lengths, one of unit.h; NULL: the file's */
    double spacing_mm[3]; /* 0: the file's. Axes keep their directions, and the box its center */
    const char *series;   /* of a folder that holds several: its number from 1, or its name; NULL: the only one */
    const char *frame;    /* which time step, from 0; NULL: the only one */
    iso_uneven uneven;
    bool is_piece; /* a part of a parallel file, which names it */
    bool takes_first; /* True if frame and channel 0 are taken of several, unless they are named */
    iso_no_data no_data;
    const char *channel;  /* which number of a voxel: from 0, its name, or "luminance" of colors; NULL: the only one */
} iso_volume_hints;
iso_status iso_source_open_with(const char *path, const iso_volume_hints *hints, iso_volume_source **source,
                                iso_error *err);
iso_status iso_source_open_raw(const char *path, const iso_raw_layout *layout, iso_volume_source **source,
                               iso_error *err);

/* Returns the header's volume; data is NULL. Valid until close. */
const iso_volume *iso_source_volume(const iso_volume_source *source);

/* Makes the source return physical values, slope * sample + intercept, as float (iso_volume_notes, whose scale then
 * is 1 and 0). No effect if the file has no scale. To be called before the first read. */
void iso_source_apply_scale(iso_volume_source *source);

/* Reads the next plane_count planes, in the machine's byte order, into plane_count * nx * ny * iso_type_bytes(type)
 * bytes. With the last plane, also checks the end of compressed data. Does not look for NaN and Inf. */
iso_status iso_source_read(iso_volume_source *source, size_t plane_count, void *out, iso_error *err);
/* Skips planes: by a seek where samples are not compressed, else by unpacking them. */
iso_status iso_source_skip(iso_volume_source *source, size_t plane_count, iso_error *err);
void iso_source_close(iso_volume_source *source); /* accepts NULL */
static inline void iso_source_close_owned(iso_volume_source **source) /* for ENDED_BY */
{
    iso_source_close(*source);
}

/* Reads the whole volume from a source that nothing has been read from yet; closes the source in every case. Statuses
 * as iso_volume_load. */
iso_status iso_volume_load_source(iso_volume_source *source, const char *path, iso_volume *v, iso_error *err);

typedef struct iso_volume_sink iso_volume_sink;

/* Opens an NRRD file for writing, header attached, raw or gzip. It appears when the sink is committed. `like` gives
 * geometry, type and notes; its data is not read. */
iso_status iso_sink_open(const char *path, const iso_volume *like, bool gzip, iso_volume_sink **sink, iso_error *err);
iso_status iso_sink_write(iso_volume_sink *sink, size_t plane_count, const void *planes, iso_error *err);
/* Puts the file in place; ISO_E_RANGE when planes are missing. Frees the sink in every case. */
iso_status iso_sink_commit(iso_volume_sink *sink, iso_error *err);
void iso_sink_abandon(iso_volume_sink *sink); /* accepts NULL */
