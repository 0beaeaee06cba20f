/* SPDX-License-Identifier: MIT */
/* frames.h - selects the frame and the channel of a file to read; private to src/volume.
 *
 * A file may have time steps (frames) and several numbers per voxel (channels) in addition to its three axes of
 * space. A format's open() announces them by iso_source_choose() before it looks at its samples. All later steps
 * read one frame and one channel, which the caller names (iso_volume_hints). Both count from 0, as in nibabel, FSL
 * and ParaView. */
#pragma once

#include "volume/stream.h"

enum { ISO_NAMED_CHANNELS = 32, ISO_CHANNEL_NAME_BYTES = 48 };

/* An axis besides those of space. */
typedef struct iso_extra_axis {
    size_t count;  /* 0 or 1: there is none */
    bool inside;   /* True if a voxel's samples are adjacent; false: one whole volume after the other */
    size_t stride; /* from one to the next, in samples of a voxel or in volumes */
} iso_extra_axis;

typedef struct iso_extra_axes {
    iso_extra_axis frame, channel;
    const struct json_t *layers; /* segments (segments.h) if the frames are layers of them; NULL otherwise */
    double frame_step;           /* of time, or of the axis' quantity; 0: not given */
    char frame_unit[16];         /* "" if not given */
    bool is_color;               /* True for red, green, blue, and alpha if there are four */
    bool gives_luminance;        /* True if the reader weighs the colors itself */
    char channel_name[ISO_NAMED_CHANNELS][ISO_CHANNEL_NAME_BYTES];
} iso_extra_axes;

/* How the chosen samples stand among the file's. */
typedef struct iso_source_choice {
    size_t inside_count, inside_at; /* samples stored for a voxel, and which is read */
    size_t volume_count, volume_at; /* consecutive volumes, and the index of the one to read */
    size_t frame, channel;
    bool luminance; /* all colors are read, and weighed */
} iso_source_choice;

/* Chooses a frame and a channel. ISO_E_USAGE if there are several and the hints name none, or one that does not
 * exist: one line that lists them. */
iso_status iso_source_choose(iso_volume_source *source, const iso_extra_axes *axes, iso_error *err);

/* Does the same for the frame only. */
iso_status iso_frames_choose(const char *path, const iso_volume_hints *hints, const iso_extra_axes *axes, size_t *frame,
                             iso_error *err);

/* Converts `count` voxels of the file to the samples to read. */
void iso_source_convert(const iso_volume_source *source, const void *cells, size_t count, void *out);
/* True if the samples to read are those of the file, in the same order. */
bool iso_source_is_plain(const iso_volume_source *source);

/* A frame in a file of its own. */
typedef struct iso_frame_file {
    char *path; /* of the chosen frame, to be freed; NULL: the frames are in one file, or there is one */
    size_t count, frame;
    double step; /* of time, if a list has it; 0 otherwise */
} iso_frame_file;

/* Finds the files of `path`, if it has a place for numbers, as "name_%04d.nrrd", and is not a file itself; or if it
 * is a list of files. ISO_E_USAGE as above. */
iso_status iso_frames_of_files(const char *path, const iso_volume_hints *hints, iso_frame_file *found, iso_error *err);
