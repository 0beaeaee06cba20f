/* SPDX-License-Identifier: MIT */
/* picture_store.h - a folder of rendered pictures, so that an interrupted job need not draw them again.
 *
 * The key of a picture is a hash of all its inputs: the command's key (base/key.h), the voxels and codes of its level,
 * the view, the options of its frame, and the renderer with its programs. So a stored picture equals a new one. A
 * truncated or changed file has another checksum, and counts as missing. Threads may share a store.
 *
 * Not stored: views with 2D transfer functions, scales or regions; directions that are not from codes or on the fly;
 * isosurfaces; timed pictures; planted faults; pictures made elsewhere; pictures of a program of a renderers.json,
 * which may change without a new version. */
#pragma once

#include "base/ranks.h"
#include "renderers/renderers.h"

typedef struct iso_picture_store iso_picture_store;

/* Locks the folder before the input is read, and creates it if it is absent. It must be empty, or an earlier store
 * and contain nothing else. Links are not followed. ISO_E_IO names the first other entry, or reports that another
 * process uses the store. */
iso_status iso_picture_store_open(const char *folder, iso_picture_store **store, iso_error *err);
/* Begins the work. keep: pictures of the same key are used; without it all are removed. With several ranks the others
 * may join from then on. */
iso_status iso_picture_store_begin(iso_picture_store *store, bool keep, const iso_key *key,
                                   const iso_ranks_place *place, iso_error *err);
/* Joins the store of rank 0 of the same job, once it has begun. ended() is called, and must not return, if rank 0 has
 * closed its store or died. ISO_E_IO: it has not begun within minutes. */
iso_status iso_picture_store_join(const char *folder, const iso_key *key, const iso_ranks_place *place,
                                  void (*ended)(void), iso_picture_store **store, iso_error *err);
/* Closes the store; NULL: nothing. remove: removes the store's own files, and the folder if it is empty then. If no
 * work has begun, pictures of an earlier run stay. */
void iso_picture_store_close(iso_picture_store *store, bool remove);

/* Sets the version of a renderer. Its pictures are stored only after this call. */
void iso_picture_store_set_version(iso_picture_store *store, const iso_renderer_info *r, const char *version);

/* Returns the number of pictures that were found in the folder. */
size_t iso_picture_store_taken(const iso_picture_store *store);

/* Takes the right to draw a picture and those that are drawn with it: of several ranks one draws, the others wait here,
 * and then find it. If a rank dies, the kernel gives its right to the next one. Nothing without ranks. */
uint64_t iso_picture_store_claim(iso_picture_store *store, const iso_render_request *q,
                                 const iso_render_options *frame);
void iso_picture_store_release(iso_picture_store *store, uint64_t claim);
/* This rank's share of `count` pictures or parts, to be drawn before the others'. Empty without ranks. */
typedef struct iso_picture_share {
    size_t first, end;
} iso_picture_share;
iso_picture_share iso_picture_store_share(const iso_picture_store *store, size_t count);

/* Returns true if *image was created from the store. frame: instead of q->options. */
bool iso_picture_store_find(iso_picture_store *store, const iso_render_request *q, const iso_render_options *frame,
                            iso_image *image);
/* Stores a picture. If the folder is not writable, nothing is stored; that is not an error. */
void iso_picture_store_put(iso_picture_store *store, const iso_render_request *q, const iso_render_options *frame,
                           const iso_image *image);
