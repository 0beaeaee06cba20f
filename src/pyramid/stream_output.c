/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#define XXH_STATIC_LINKING_ONLY /* the checksum's state as a struct, to hand it on */
#include "pyramid/stream_output.h"

#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/large.h"
#include "base/parallel.h"

/* Hashed, then copied to the file's block while in the cache. */
#define PIECE_BYTES ((size_t)128 << 10)

/* State of one file that goes to the next rank in turn. */
typedef struct stream_tail {
    iso_bigfile_tail file;
    XXH3_state_t hash;
} stream_tail;

void iso_stream_output_describe(stream_output *o, const iso_geometry *geometry, iso_type input,
                                const iso_pyramid_options *opt)
{
    iso_geometry g = *geometry;
    pthread_mutex_init(&o->mutex, NULL);
    o->level_count = iso_cascade_level_count(geometry, opt);
    for (size_t k = 0; k < o->level_count; ++k) {
        stream_level *l = &o->levels[k];
        l->geometry = g;
        l->type = k == 0 ? iso_layout_type(input) : ISO_F32;
        l->converts = k > 0 || l->type != input;
        iso_layout_files(opt, l->type, l->files);
        g = iso_geometry_coarser(&g);
    }
}

void iso_stream_output_begin_at(stream_output *o, size_t first)
{
    for (size_t k = 0; k < first && k < o->level_count; ++k)
        for (int i = 0; i < FILE_COUNT; ++i)
            o->levels[k].files[i].stored = false;
}

static size_t stream_file_plane_bytes(const stream_level *l, int i)
{
    return l->geometry.size[0] * l->geometry.size[1] * l->files[i].components * iso_type_bytes(l->files[i].type);
}

size_t iso_stream_level_plane_bytes(const stream_level *l, const iso_pyramid_options *opt)
{
    const size_t n = l->geometry.size[0] * l->geometry.size[1];
    return n * (3 + (l->converts ? sizeof(float) : 0) + (opt->keep_float ? 3 * sizeof(float) : 0) +
                (opt->keep_magnitude ? sizeof(float) : 0));
}

static bool create_set(const stream_level *l, const iso_pyramid_options *opt, iso_cascade_out *out)
{
    const size_t n = l->capacity * l->geometry.size[0] * l->geometry.size[1];
    out->codes = iso_large_alloc(3 * n);
    out->scalar = l->converts ? iso_large_alloc(n * sizeof(float)) : NULL;
    out->directions = opt->keep_float ? iso_large_alloc(3 * n * sizeof(float)) : NULL;
    out->magnitude = opt->keep_magnitude ? iso_large_alloc(n * sizeof(float)) : NULL;
    return out->codes && (out->scalar || !l->converts) && (out->directions || !opt->keep_float) &&
           (out->magnitude || !opt->keep_magnitude);
}

bool iso_stream_output_create(stream_output *o, const iso_cascade *c, size_t slab, const iso_pyramid_options *opt)
{
    bool good = true;
    for (size_t k = 0; k < o->level_count; ++k) {
        stream_level *l = &o->levels[k];
        l->capacity = iso_cascade_capacity(c, k, slab);
        good = create_set(l, opt, &l->set[0]) && create_set(l, opt, &l->set[1]) && good;
    }
    return good;
}

void iso_stream_output_destroy(stream_output *o)
{
    iso_stream_output_wait(o, NULL);
    for (size_t k = 0; k < o->level_count; ++k) {
        stream_level *l = &o->levels[k];
        for (int set = 0; set < 2; ++set) {
            free(l->set[set].scalar);
            free(l->set[set].codes);
            free(l->set[set].directions);
            free(l->set[set].magnitude);
        }
        for (int i = 0; i < FILE_COUNT; ++i) {
            iso_bigfile_abandon(l->file[i]);
            XXH3_freeState(l->hash[i]);
        }
    }
    pthread_mutex_destroy(&o->mutex);
}

/* ---- files ---- */

static iso_status write_and_hash(stream_level *l, int i, const char *data, size_t bytes, iso_error *err)
{
    for (size_t at = 0; at < bytes; at += PIECE_BYTES) {
        const size_t n = bytes - at < PIECE_BYTES ? bytes - at : PIECE_BYTES;
        XXH3_64bits_update(l->hash[i], data + at, n);
        NEED(iso_bigfile_write(l->file[i], data + at, n, err));
    }
    l->files[i].bytes += bytes;
    return ISO_OK;
}

/* Adds the first `bytes` of a file of an earlier build to its checksum. */
static iso_status hash_file(const char *path, XXH3_state_t *hash, size_t bytes, iso_error *err)
{
    enum { CHUNK = 1 << 20 };
    FREED char *chunk = malloc(CHUNK);
    FILE *file = fopen(path, "rb");
    bool good = chunk && file;
    for (size_t done = 0; done < bytes && good;) {
        size_t n = bytes - done < CHUNK ? bytes - done : CHUNK;
        good = fread(chunk, 1, n, file) == n;
        if (good)
            XXH3_64bits_update(hash, chunk, n);
        done += n;
    }
    if (file)
        fclose(file);
    return good ? ISO_OK : iso_fail(err, ISO_E_FORMAT, "%s: holds less than progress.json says", path);
}

static iso_status open_file(stream_output *o, const char *path, const char *header, size_t k, int i, bool join,
                            iso_error *err)
{
    stream_level *l = &o->levels[k];
    XXH3_64bits_reset(l->hash[i]);
    if (join)
        return iso_bigfile_join(path, o->direct, &l->file[i], err);
    l->files[i].bytes = l->first ? strlen(header) + l->first * stream_file_plane_bytes(l, i) : 0;
    NEED(iso_bigfile_open(path, o->direct, l->files[i].bytes, &l->file[i], err));
    return l->first ? hash_file(path, l->hash[i], l->files[i].bytes, err)
                    : write_and_hash(l, i, header, strlen(header), err);
}

static iso_status open_files(stream_output *o, const char *dir, bool join, iso_error *err)
{
    for (size_t at = 0; at < o->level_count * FILE_COUNT; ++at) {
        const size_t k = at / FILE_COUNT;
        const int i = (int)(at % FILE_COUNT);
        stream_level *l = &o->levels[k];
        if (!l->files[i].stored)
            continue;
        char name[64];
        iso_layout_name(&l->files[i], k, name);
        FREED char *path = iso_path_join(dir, name), *header = iso_layout_header(&l->geometry, &l->files[i]);
        l->hash[i] = XXH3_createState();
        NEED(path && header && l->hash[i] ? open_file(o, path, header, k, i, join, err)
                                          : iso_fail(err, ISO_E_MEMORY, "%s: out of memory", name));
    }
    return ISO_OK;
}

iso_status iso_stream_output_open(stream_output *o, const char *dir, iso_error *err)
{
    return open_files(o, dir, false, err);
}

iso_status iso_stream_output_join(stream_output *o, const char *dir, iso_error *err)
{
    return open_files(o, dir, true, err);
}

iso_status iso_stream_output_sync(stream_output *o, iso_error *err)
{
    NEED(iso_stream_output_wait(o, err));
    for (size_t k = 0; k < o->level_count; ++k)
        for (int i = 0; i < FILE_COUNT; ++i)
            if (o->levels[k].file[i])
                NEED(iso_bigfile_sync(o->levels[k].file[i], err));
    return ISO_OK;
}

iso_status iso_stream_output_close(stream_output *o, iso_error *err)
{
    iso_status status = iso_stream_output_wait(o, err);
    for (size_t k = 0; k < o->level_count; ++k)
        for (int i = 0; i < FILE_COUNT; ++i) {
            stream_level *l = &o->levels[k];
            if (l->hash[i])
                l->files[i].hash = XXH3_64bits_digest(l->hash[i]);
            iso_status closed = iso_bigfile_close(l->file[i], status == ISO_OK ? err : NULL);
            status = status == ISO_OK ? closed : status;
            l->file[i] = NULL;
        }
    return status;
}

/* ---- slabs ---- */

static void list_pointers(const iso_cascade_out *out, char *data[FILE_COUNT])
{
    data[FILE_SCALAR] = (char *)out->scalar;
    data[FILE_CODES] = (char *)out->codes;
    data[FILE_DIRECTIONS] = (char *)out->directions;
    data[FILE_MAGNITUDE] = (char *)out->magnitude;
    data[FILE_SCALE] = NULL;
}

void iso_stream_output_copy_begun(stream_output *o)
{
    for (size_t k = 0; k < o->level_count; ++k) {
        stream_level *l = &o->levels[k];
        char *to[FILE_COUNT], *from[FILE_COUNT];
        list_pointers(&l->set[o->active], to);
        list_pointers(&l->set[!o->active], from);
        for (int i = 0; i < FILE_COUNT; ++i) {
            const size_t plane = stream_file_plane_bytes(l, i);
            if (to[i])
                memcpy(to[i], from[i] + l->written * plane, (l->capacity - l->written) * plane);
        }
    }
}

void iso_stream_output_targets(const stream_output *o, iso_cascade_out out[STREAM_MAX_LEVELS])
{
    for (size_t k = 0; k < o->level_count; ++k) {
        out[k] = o->levels[k].set[o->active];
        out[k].first = o->levels[k].first;
    }
}

void iso_stream_output_list(stream_output *o, const size_t complete[STREAM_MAX_LEVELS], const char *input,
                            size_t input_first)
{
    o->item_count = 0;
    for (size_t k = 0; k < o->level_count; ++k) {
        stream_level *l = &o->levels[k];
        char *data[FILE_COUNT];
        list_pointers(&l->set[o->active], data);
        const char *scalar = l->converts ? data[FILE_SCALAR]
                                         : input + (l->first - input_first) * stream_file_plane_bytes(l, FILE_SCALAR);
        l->written = complete[k] > l->first ? complete[k] - l->first : 0;
        for (int i = 0; i < FILE_COUNT && l->written > 0; ++i)
            if (l->files[i].stored)
                o->items[o->item_count++] = (stream_item){l, i, i == FILE_SCALAR ? scalar : data[i],
                                                          l->written * stream_file_plane_bytes(l, i)};
        l->first += l->written;
    }
}

/* Takes items until none is left. */
static void *write_items(void *user)
{
    stream_output *o = user;
    const double start = iso_clock_seconds();
    iso_error error = {""};
    iso_status status = ISO_OK;
    for (size_t i; status == ISO_OK && (i = atomic_fetch_add(&o->next_item, 1)) < o->item_count;) {
        const stream_item *w = &o->items[i];
        iso_bigfile *file = w->level->file[w->file];
        if (!o->in_turns)
            status = write_and_hash(w->level, w->file, w->data, w->bytes, &error);
        else if ((status = iso_bigfile_write(file, w->data, w->bytes, &error)) == ISO_OK)
            status = iso_bigfile_flush(file, &error);
    }
    pthread_mutex_lock(&o->mutex);
    o->seconds_busy += iso_clock_seconds() - start;
    if (status != ISO_OK && o->status == ISO_OK) {
        o->status = status;
        o->error = error;
    }
    pthread_mutex_unlock(&o->mutex);
    return NULL;
}

void iso_stream_output_start(stream_output *o)
{
    atomic_store(&o->next_item, 0);
    while (o->writer_count < STREAM_WRITERS && pthread_create(&o->writers[o->writer_count], NULL, write_items, o) == 0)
        ++o->writer_count;
    if (o->writer_count == 0)
        write_items(o);
    o->active = !o->active;
}

iso_status iso_stream_output_wait(stream_output *o, iso_error *err)
{
    for (; o->writer_count > 0; --o->writer_count)
        pthread_join(o->writers[o->writer_count - 1], NULL);
    if (o->status != ISO_OK && err)
        *err = o->error;
    return o->status;
}

/* ---- in turns ---- */

/* Returns the tail of a file; only stored files have one. */
static stream_tail *tail_of(const stream_output *o, void *tails, const stream_level *level, int file)
{
    stream_tail *tail = tails;
    for (size_t k = 0; k < o->level_count; ++k)
        for (int i = 0; i < FILE_COUNT; ++i) {
            if (&o->levels[k] == level && i == file)
                return tail;
            tail += o->levels[k].files[i].stored;
        }
    return NULL;
}

size_t iso_stream_tails_bytes(const stream_output *o)
{
    size_t count = 0;
    for (size_t k = 0; k < o->level_count; ++k)
        for (int i = 0; i < FILE_COUNT; ++i)
            count += o->levels[k].files[i].stored;
    return count * sizeof(stream_tail);
}

void iso_stream_tails_get(const stream_output *o, void *tails)
{
    stream_tail *tail = tails;
    for (size_t k = 0; k < o->level_count; ++k)
        for (int i = 0; i < FILE_COUNT; ++i)
            if (o->levels[k].files[i].stored) {
                memset(tail, 0, sizeof *tail);
                iso_bigfile_get_tail(o->levels[k].file[i], &tail->file);
                memcpy(&tail->hash, o->levels[k].hash[i], sizeof tail->hash);
                ++tail;
            }
}

/* Repairs the pointer of a state from another process: it has to point to this process's copy of the library's
 * secret. */
static void adopt_hash(XXH3_state_t *own, const XXH3_state_t *state)
{
    const unsigned char *secret = own->extSecret;
    memcpy(own, state, sizeof *own);
    own->extSecret = secret;
}

void iso_stream_tails_set(stream_output *o, const void *tails)
{
    const stream_tail *tail = tails;
    for (size_t k = 0; k < o->level_count; ++k)
        for (int i = 0; i < FILE_COUNT; ++i)
            if (o->levels[k].files[i].stored) {
                iso_bigfile_go_on(o->levels[k].file[i], &tail->file);
                adopt_hash(o->levels[k].hash[i], &tail->hash);
                o->levels[k].files[i].bytes = tail->file.end;
                ++tail;
            }
}

void iso_stream_tails_advance(stream_output *o, void *tails)
{
#pragma omp parallel for schedule(dynamic, 1)
    for (size_t n = 0; n < o->item_count; ++n) {
        const stream_item *w = &o->items[n];
        stream_tail *tail = tail_of(o, tails, w->level, w->file);
        XXH3_state_t *hash = w->level->hash[w->file];
        iso_bigfile_tail_after(&tail->file, w->data, w->bytes);
        XXH3_64bits_update(hash, w->data, w->bytes);
        memcpy(&tail->hash, hash, sizeof *hash);
    }
}
