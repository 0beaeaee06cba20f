/* SPDX-License-Identifier: MIT */
/* picture_store.h - pictures that were rendered, in a folder, so that a job that was interrupted need not draw them again.
 *
 * A picture is found by a hash of all that it depends on: the command's key (base/key.h), the voxels and codes of its level,
 * the view, the options of its frame, and the renderer with its programs. So a picture from the folder is the one that would
 * be drawn. A file that is cut off or changed does not have its checksum, and counts as not there.
 * Threads may share a store. Not kept: views with 2D transfer functions, scales or regions, directions that are not from
 * codes or on the fly, isosurfaces; what is timed; planted faults; pictures that were made elsewhere; those of a program of
 * a renderers.json, which may be edited in between while its version stays. */
#ifndef ISO_PICTURE_STORE_H
#define ISO_PICTURE_STORE_H

#include "renderers/renderers.h"

typedef struct iso_picture_store iso_picture_store;

/* Before the input is read: the folder is locked, and made if it is absent. ISO_E_IO, with the first entry that is not the
 * store's own: the folder is absent, empty, or has been made by a store and holds nothing else. Links are not followed. Nor
 * may another process have the folder open as a store. */
iso_status iso_picture_store_open(const char *folder, iso_picture_store **store, iso_error *err);
/* When the work begins. keep: pictures of the same key are taken; else all are removed. */
iso_status iso_picture_store_begin(iso_picture_store *store, bool keep, const iso_key *key, iso_error *err);
/* remove: the store's own files, and the folder if it holds no others. If no work has begun, pictures of an earlier run
 * stay. NULL: nothing. */
void iso_picture_store_close(iso_picture_store *store, bool remove);

/* Nothing of a renderer is kept before its version is known. */
void iso_picture_store_set_version(iso_picture_store *store, const iso_renderer_info *r, const char *version);

/* How many pictures were taken from the folder. */
size_t iso_picture_store_taken(const iso_picture_store *store);

/* true: *image is created. frame: instead of q->options. */
bool iso_picture_store_find(iso_picture_store *store, const iso_render_request *q, const iso_render_options *frame,
                            iso_image *image);
/* A folder that cannot be written to is no reason to stop: nothing is kept then. */
void iso_picture_store_put(iso_picture_store *store, const iso_render_request *q, const iso_render_options *frame,
                           const iso_image *image);

#endif
