/* SPDX-License-Identifier: MIT */
/* stream_kernel.h - functions that the readers of formats share; private to src/volume. */
#pragma once

#include <stdio.h>
#include <zlib.h>

#include "volume/format.h"
#include "volume/frames.h"
#include "volume/unpack.h"

enum { ISO_SOURCE_FILLS = 3 };

/* Statistics of the samples, taken while they are read. */
typedef struct iso_source_look {
    double fill[ISO_SOURCE_FILLS]; /* values that stand for none */
    size_t fill_count, filled;     /* voxels that have one of them */
    double least_fill, most_fill;  /* of those */
    double lo, hi;                 /* of the other samples, as they are stored */
    size_t seen;
    bool is_rounded; /* True if some value does not fit a float */
} iso_source_look;

struct iso_volume_source {
    char *path; /* a file, or a folder */
    char *part; /* which of the volumes that it holds, of FILE:PART; NULL: the only one */
    iso_unpacked unpacked; /* the copy that is read, of a packed file */
    iso_volume_hints hints;
    iso_volume header;
    FILE *file; /* plain samples, or */
    gzFile gz;  /* compressed ones, or */
    bool gz_end_is_missing;
    char *preloaded; /* all of them, of encodings that are read at once */
    bool swap_bytes;
    iso_form form;
    iso_type
        stored; /* the type in the file if header.type is another one: of scaled values, luminance, or a form; of as
                        many bytes as the form has */
    iso_source_look look;
    bool has_fills;  /* True if look.fill are no data in some voxels */
    bool only_looks; /* True for a pass that looks for them */
    bool scaled; /* samples are made floats, slope * value + intercept */
    double slope, intercept;
    iso_source_choice choice;
    size_t planes_done,
        planes_read; /* given to the caller; read from the file, which may have several consecutive volumes */
    /* Samples that are none of these: read_planes gives the next planes of the file, all its channels, in the machine's
     * byte order, and close_reader, which may be NULL, ends it. */
    void *reader;
    iso_status (*read_planes)(iso_volume_source *source, size_t plane_count, void *out, iso_error *err);
    void (*close_reader)(iso_volume_source *source);
};

/* Converts one of the file's units to mm, for its lengths. `unit` is the header's word, NULL or "" if it has none,
 * which is then `fallback`; the caller's hint comes before both. ISO_E_FORMAT for an unknown unit. */
iso_status iso_source_unit(iso_volume_source *source, const char *unit, const char *fallback, double *mm,
                           iso_error *err);
/* Fails with ISO_E_FORMAT if no hint gives the spacing that the file lacks; `what` names it: "between its slices". */
iso_status iso_source_need_spacing(const iso_volume_source *source, const char *what, iso_error *err);
/* Applies the rule of all formats for lengths in a header: each is finite and above 0. NAN: the header lacks it.
 * ISO_E_FORMAT for others, unless a hint gives the spacing: then they become 1. */
iso_status iso_source_take_spacing(const iso_volume_source *source, double spacing[3], iso_error *err);
/* Applies the same rule to the axes of header.geometry, which may have any direction; then calls
 * iso_geometry_check(). */
iso_status iso_source_check_geometry(iso_volume_source *source, iso_error *err);
/* Opens the file at its first sample, which stands at `offset`, and checks that the file ends with the last. */
iso_status iso_source_take_file(iso_volume_source *source, const char *path, size_t offset, iso_error *err);
/* Does the same for a file in which other data follows. */
iso_status iso_source_take_part(iso_volume_source *source, const char *path, size_t offset, iso_error *err);
/* Does the same for samples that zlib packed, up to the end of the packed data. */
iso_status iso_source_take_zlib(iso_volume_source *source, const char *path, size_t offset, iso_error *err);
/* Returns ISO_E_IO if reading the file failed, even if data is missing; otherwise `status`. */
iso_status iso_source_check_read(FILE *f, const char *path, iso_status status, iso_error *err);
iso_status iso_source_check_read_gz(gzFile gz, const char *path, iso_status status, iso_error *err);
/* How samples stand as decimals in a file. */
typedef struct iso_text_layout {
    bool z_fastest;    /* z runs fastest, x slowest */
    bool words_follow; /* True if a word that is not a number may follow; false: nothing may */
    bool anything_follows;
} iso_text_layout;
/* Reads all samples from the file's position, and leaves it after the last; the caller checks for a read error. */
iso_status iso_source_take_text(iso_volume_source *source, FILE *f, iso_text_layout layout, iso_error *err);

/* Checks header.geometry, and that `available` is the number of bytes of its samples. */
iso_status iso_source_check_bytes(const iso_volume_source *source, double available, iso_error *err);
/* Deflate, of zlib and gzip, packs no more bytes into one. */
enum { ISO_SOURCE_DEFLATE_MOST = 1032 };
/* Checks the size before memory is allocated. ISO_E_FORMAT if `packed` bytes of the file `path`, of at most `most`
 * bytes of samples each, cannot hold all samples. */
iso_status iso_source_check_packed(const iso_volume_source *source, const char *path, double packed, double most,
                                   iso_error *err);
/* Fails with ISO_E_IO if the path is not a regular file: reading a pipe would wait. */
iso_status iso_source_check_regular(const char *path, iso_error *err);
/* Returns the bytes of all samples in the file; of one of its planes. Both include frames and channels not read. */
size_t iso_source_bytes(const iso_volume_source *source);
size_t iso_source_plane_bytes(const iso_volume_source *source);
/* Returns the number of planes in the file, of all consecutive volumes; the type of its samples. */
size_t iso_source_planes(const iso_volume_source *source);
iso_type iso_source_stored_type(const iso_volume_source *source);
/* Skips planes of the file. */
iso_status iso_source_skip_stored(iso_volume_source *source, size_t plane_count, iso_error *err);
/* Makes the header's type float, or double, which may become int32 or uint32. Called before samples are examined. */
void iso_source_set_form(iso_volume_source *source, iso_form form);
/* Notes a value of the file that stands for no data, unless the caller's rule replaces it. */
void iso_source_note_fill(iso_volume_source *source, double value);
/* Looks at a plane of the file. */
void iso_source_look_at(iso_volume_source *source, const void *cells, size_t count);
/* Reads a source to its end and sets *found if some voxels have its fill values, which then are no data. */
iso_status iso_source_look_for_fills(iso_volume_source *source, bool *found, iso_error *err);
/* Makes the header's type one that holds ISO_NO_DATA. */
void iso_source_hold_no_data(iso_volume_source *source);
/* Sets the samples `out` that are no data, of `count` voxels that stand in the file as `cells`. */
void iso_source_mark_no_data(const iso_volume_source *source, const void *cells, size_t count, void *out);
/* Returns a sample of the form. */
double iso_form_value(iso_form form, const void *cells, size_t at);
/* Fails with ISO_E_RANGE if floats cannot hold the values. */
iso_status iso_source_check_look(const iso_volume_source *source, iso_error *err);
/* Makes the source convert samples to floats from now on (iso_source_convert). */
void iso_source_make_floats(iso_volume_source *source);
