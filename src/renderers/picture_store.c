/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "renderers/picture_store.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>
#define XXH_INLINE_ALL
#include <xxhash.h>

#include "base/file.h"
#include "base/unfinished.h"

struct iso_picture_store {
    char *folder;
    int lock; /* descriptor of the folder; while it is open, no other process uses the folder */
    bool began;
    char key[ISO_KEY_DIGEST_BYTES];
    char renderers[ISO_MAX_RENDERERS][ISO_KEY_DIGEST_BYTES]; /* set before threads share the store */
    atomic_size_t taken;
    iso_ranks_place place;
    int claims;          /* descriptor of the file whose bytes are locked; -1: there is one rank */
    void (*ended)(void); /* of a rank other than 0 */
};

/* ---- the folder ---- */

/* Marks the folder as a store. */
#define MARKER "isoshade-pictures"
static const char marker_text[] = "Pictures that isoshade validate keeps until its report is complete.\n";
static const char suffix[] = ".picture";
/* With several ranks: it names the job, and its bytes stand for pictures that a rank draws. */
#define CLAIMS "isoshade-ranks"

enum { HASH_DIGITS = 32 };

static bool is_temporary(const char *name)
{
    return strncmp(name, ".isoshade-", 10) == 0;
}

/* True for the marker, a picture, or a temporary file of either that a killed run has left. */
static bool is_own_name(const char *name)
{
    if (strcmp(name, MARKER) == 0 || strcmp(name, CLAIMS) == 0 ||
        (is_temporary(name) && (iso_path_ends_with(name, "-" MARKER) || iso_path_ends_with(name, "-" CLAIMS))))
        return true;
    return iso_path_ends_with(name, suffix) &&
           (is_temporary(name) || (strspn(name, "0123456789abcdef") == HASH_DIGITS &&
                             strlen(name) == HASH_DIGITS + strlen(suffix)));
}

/* Handles an entry by the descriptor of the folder, so that no other folder can take its place meanwhile. */
typedef iso_status visitor(DIR *dir, const char *folder, const char *name, iso_error *err);

static iso_status check_entry(DIR *dir, const char *folder, const char *name, iso_error *err)
{
    struct stat st;
    const bool is_file = fstatat(dirfd(dir), name, &st, AT_SYMLINK_NOFOLLOW) == 0 && S_ISREG(st.st_mode);
    return is_file && is_own_name(name) ? ISO_OK
                                        : iso_fail(err, ISO_E_IO,
                                                   "%s: contains %s, which is not isoshade's; move it away, or choose "
                                                   "another output",
                                                   folder, name);
}

static iso_status remove_picture(DIR *dir, const char *folder, const char *name, iso_error *err)
{
    if (!is_own_name(name) || strcmp(name, MARKER) == 0 || unlinkat(dirfd(dir), name, 0) == 0)
        return ISO_OK;
    return iso_fail(err, iso_errno_status(), "%s/%s: cannot be removed: %s", folder, name, strerror(errno));
}

/* Calls visit for each entry until one fails; *count is the number of finished ones. A missing folder has none. */
static iso_status visit_folder(const char *folder, visitor *visit, size_t *count, iso_error *err)
{
    const int fd = open(folder, O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC);
    DIR *dir = fd >= 0 ? fdopendir(fd) : NULL;
    iso_status status = ISO_OK;
    *count = 0;
    if (!dir) {
        const int cause = errno;
        if (fd >= 0)
            close(fd);
        return cause == ENOENT
                   ? ISO_OK
                   : iso_fail(err, ISO_E_IO, "%s: cannot store pictures in this folder: %s", folder, strerror(cause));
    }
    for (const struct dirent *e; status == ISO_OK && (e = readdir(dir));)
        if (strcmp(e->d_name, ".") != 0 && strcmp(e->d_name, "..") != 0) {
            *count += !is_temporary(e->d_name); /* a killed run may have left only that of the marker */
            status = visit(dir, folder, e->d_name, err);
        }
    closedir(dir);
    return status;
}

static iso_status check_content(const char *folder, iso_error *err)
{
    size_t count;
    NEED(visit_folder(folder, check_entry, &count, err));
    FREED char *marker = iso_path_join(folder, MARKER);
    NEED_MEMORY(marker, err, "%s: out of memory", folder);
    if (count > 0 && !iso_path_is_file(marker))
        return iso_fail(err, ISO_E_IO,
                        "%s: is not a store of pictures (no " MARKER "); move it away, or choose another output",
                        folder);
    return ISO_OK;
}

/* Removes the store's pictures only. The marker stays, so that a run killed in between leaves a valid store. */
static void remove_pictures(const char *folder)
{
    size_t count;
    visit_folder(folder, remove_picture, &count, NULL);
}

/* Removes the store, the marker last, once no other entry is left. */
static void remove_folder(const char *folder)
{
    FREED char *marker = iso_path_join(folder, MARKER);
    size_t met = 2;
    for (int looks = 0; looks < 4 && met > 1; ++looks)
        if (visit_folder(folder, remove_picture, &met, NULL) != ISO_OK)
            break;
    if (marker && met <= 1 && unlink(marker) == 0)
        rmdir(folder);
}

/* Explains a failed lock; ISO_E_IO if another process has it. */
static iso_status fail_to_lock(const iso_folder_lock *lock, const char *folder, iso_error *err)
{
    errno = lock->cause;
    if (lock->cause == EWOULDBLOCK)
        return iso_fail(err, ISO_E_IO,
                        "%s: another process stores pictures there; wait for its end, or choose another output",
                        folder);
    return iso_fail(err, iso_errno_status(), "%s: cannot store pictures in this folder: %s", folder, strerror(errno));
}

/* Writes the marker before anything else: a run killed in between leaves a folder that the next may use. */
static iso_status write_marker(const char *folder, iso_error *err)
{
    FREED char *marker = iso_path_join(folder, MARKER);
    return marker ? iso_file_write(marker, marker_text, sizeof marker_text - 1, err)
                  : iso_fail(err, ISO_E_MEMORY, "%s: out of memory", folder);
}

iso_status iso_picture_store_open(const char *folder, iso_picture_store **store, iso_error *err)
{
    const iso_folder_lock lock = iso_folder_lock_take(folder, true);
    *store = NULL;
    if (lock.fd < 0)
        return fail_to_lock(&lock, folder, err);
    if (lock.made)
        iso_unfinished_add(folder, false);
    iso_status status = check_content(folder, err);
    TRY(status, write_marker(folder, err));
    iso_picture_store *s = status == ISO_OK ? calloc(1, sizeof *s) : NULL;
    if (status == ISO_OK && (!s || !(s->folder = strdup(folder))))
        status = iso_fail(err, ISO_E_MEMORY, "%s: out of memory", folder);
    if (status != ISO_OK) {
        if (lock.made)
            remove_folder(folder);
        iso_unfinished_drop(folder);
        free(s);
        close(lock.fd);
        return status;
    }
    s->lock = lock.fd;
    s->claims = -1;
    *store = s;
    return ISO_OK;
}

/* Opens the file of claims if it is that of the job. -1: it is not there. */
static int open_claims(const char *folder, const iso_ranks_place *place)
{
    char *path = iso_path_join(folder, CLAIMS), job[sizeof place->job] = "";
    const int fd = path ? open(path, O_RDWR | O_CLOEXEC | O_NOFOLLOW) : -1;
    free(path);
    const ssize_t length = fd >= 0 ? read(fd, job, sizeof job) : -1;
    if (length >= 0 && (size_t)length == strlen(place->job) && memcmp(job, place->job, (size_t)length) == 0)
        return fd;
    if (fd >= 0)
        close(fd);
    return -1;
}

static iso_status begin_claims(iso_picture_store *store, const iso_ranks_place *place, iso_error *err)
{
    FREED char *path = iso_path_join(store->folder, CLAIMS);
    iso_status status = path ? iso_file_write(path, place->job, strlen(place->job), err)
                             : iso_fail(err, ISO_E_MEMORY, "%s: out of memory", store->folder);
    store->claims = status == ISO_OK ? open_claims(store->folder, place) : -1;
    return status;
}

iso_status iso_picture_store_begin(iso_picture_store *store, bool keep, const iso_key *key,
                                   const iso_ranks_place *place, iso_error *err)
{
    NEED_MEMORY(iso_key_digest(key, store->key), err, "%s: out of memory", store->folder);
    iso_unfinished_drop(store->folder);
    if (!keep)
        remove_pictures(store->folder);
    store->began = true;
    store->place = *place;
    return place->count > 1 ? begin_claims(store, place, err) : ISO_OK;
}

iso_status iso_picture_store_join(const char *folder, const iso_key *key, const iso_ranks_place *place,
                                  void (*ended)(void), iso_picture_store **store, iso_error *err)
{
    enum { PAUSES = 120 * 20 }; /* two minutes: rank 0 reads the same volume */
    const struct timespec pause = {.tv_nsec = 50 * 1000000};
    int claims;
    *store = NULL;
    for (int pauses = 0; (claims = open_claims(folder, place)) < 0 && pauses < PAUSES; ++pauses)
        nanosleep(&pause, NULL);
    if (claims < 0)
        return iso_fail(err, ISO_E_IO, "%s: rank 0 has not begun to draw", folder);
    iso_picture_store *s = calloc(1, sizeof *s);
    const int fd = open(folder, O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC);
    if (!s || fd < 0 || !(s->folder = strdup(folder)) || !iso_key_digest(key, s->key)) {
        if (fd >= 0)
            close(fd);
        close(claims);
        free(s);
        return iso_fail(err, ISO_E_IO, "%s: cannot be opened", folder);
    }
    s->lock = fd;
    s->claims = claims;
    s->place = *place;
    s->ended = ended;
    s->began = true;
    *store = s;
    return ISO_OK;
}

iso_picture_share iso_picture_store_share(const iso_picture_store *s, size_t count)
{
    if (!s || s->claims < 0)
        return (iso_picture_share){0, 0};
    const size_t index = (size_t)s->place.index, ranks = (size_t)s->place.count;
    return (iso_picture_share){count * index / ranks, count * (index + 1) / ranks};
}

void iso_picture_store_close(iso_picture_store *store, bool remove)
{
    size_t count = 0;
    if (!store)
        return;
    remove = remove && !store->ended; /* rank 0 removes it */
    if (!store->began)
        remove = visit_folder(store->folder, check_entry, &count, NULL) == ISO_OK && count <= 1; /* only the marker */
    if (remove)
        remove_folder(store->folder);
    iso_unfinished_drop(store->folder);
    if (store->claims >= 0)
        close(store->claims);
    close(store->lock);
    free(store->folder);
    free(store);
}

void iso_picture_store_set_version(iso_picture_store *store, const iso_renderer_info *r, const char *version)
{
    if (store)
        iso_renderer_identify(r, version, store->renderers[iso_renderer_index(r)], NULL);
}

size_t iso_picture_store_taken(const iso_picture_store *store)
{
    return store ? store->taken : 0;
}

/* ---- the hash of a request ---- */

static bool is_known(const iso_picture_store *s, const iso_renderer_info *r)
{
    return s->renderers[iso_renderer_index(r)][0] && !iso_renderer_has(r, ISO_IS_OF_PICTURES);
}

static bool is_kept(const iso_picture_store *s, const iso_render_request *q, const iso_render_options *o)
{
    const iso_view *v = q->view;
    return is_known(s, o->renderer) && !q->renderers->after.change && !o->stats && o->repeats <= 1 &&
           !(o->repeat_seconds > 0) && !o->isosurface && !v->tf_2d && !v->extinction_scale && !v->roi &&
           (o->source == ISO_FROM_CODES || o->source == ISO_FROM_DECODED || o->source == ISO_FROM_ON_THE_FLY) &&
           !q->renderers->shader_dir;
}

/* Adds single numbers, since structs have padding. */
static void add_doubles(XXH3_state_t *h, const double *values, size_t count)
{
    XXH3_128bits_update(h, values, count * sizeof *values);
}

static void add_vec(XXH3_state_t *h, iso_vec3 v)
{
    add_doubles(h, (const double[]){v.x, v.y, v.z}, 3);
}

static void add_text(XXH3_state_t *h, const char *text)
{
    XXH3_128bits_update(h, text, strlen(text) + 1);
}

static void add_view(XXH3_state_t *h, const iso_view *v)
{
    const iso_camera *c = &v->camera;
    add_doubles(h, (const double[]){(double)v->width, (double)v->height, c->orthographic, c->half_height, v->step_voxels,
                                    (double)v->light_count, (double)v->clip_count},
                7);
    add_vec(h, c->position), add_vec(h, c->forward), add_vec(h, c->right), add_vec(h, c->up);
    for (size_t i = 0; i < v->light_count; ++i) {
        add_vec(h, v->lights[i].direction);
        add_doubles(h, &v->lights[i].intensity, 1);
    }
    for (size_t i = 0; i < v->clip_count; ++i) {
        add_vec(h, v->clips[i].normal);
        add_doubles(h, &v->clips[i].offset_mm, 1);
    }
    const iso_shading *s = &v->shading;
    add_doubles(h, (const double[]){s->ambient, s->diffuse, s->specular, s->power}, 4);
    add_doubles(h, v->background, 3);
    add_doubles(h, (const double[]){(double)v->tf.count, v->tf.lo, v->tf.hi}, 3);
    XXH3_128bits_update(h, v->tf.entries, v->tf.count * 4 * sizeof *v->tf.entries);
}

/* Adds level 0 too, since Blender's units and the ranges of its grids depend on it. */
static void add_geometry(XXH3_state_t *h, const iso_geometry *g)
{
    for (int a = 0; a < 3; ++a)
        add_doubles(h, (const double[]){(double)g->size[a], g->box_index[a], g->index_to_world.m[a][0],
                                        g->index_to_world.m[a][1], g->index_to_world.m[a][2]},
                    5);
    add_vec(h, g->origin_mm);
}

static void add_level(XXH3_state_t *h, const iso_pyramid *p, size_t k)
{
    const iso_level *l = &p->levels[k], *finest = &p->levels[0];
    const size_t voxels = iso_geometry_voxel_count(&l->geometry);
    add_geometry(h, &finest->geometry);
    add_geometry(h, &l->geometry);
    add_doubles(h, (const double[]){(double)k, (double)p->options.code, (double)l->stored_type, l->min, l->max, finest->min,
                                    finest->max, finest->labels},
                8);
    XXH3_128bits_update(h, l->scalar, voxels * sizeof *l->scalar);
    XXH3_128bits_update(h, l->codes, 3 * voxels);
}

static void add_frame(XXH3_state_t *h, const iso_render_options *o)
{
    add_doubles(h, (const double[]){(double)o->source, (double)o->quadrature, o->step_voxels, (double)o->intervals,
                                    (double)o->planes, o->extrapolate, o->samples, o->seed, o->shade_table, o->exact_lookups},
                10);
}

static bool hash_of(const iso_picture_store *s, const iso_render_request *q, const iso_render_options *frame,
                    XXH128_hash_t *hash)
{
    XXH3_state_t *h = XXH3_createState();
    if (!h || XXH3_128bits_reset(h) != XXH_OK) {
        XXH3_freeState(h);
        return false;
    }
    add_text(h, s->key);
    add_text(h, s->renderers[iso_renderer_index(frame->renderer)]);
    add_frame(h, frame);
    add_view(h, q->view);
    add_level(h, q->pyramid, q->level);
    *hash = XXH3_128bits_digest(h);
    XXH3_freeState(h);
    return true;
}

static char *path_of(const iso_picture_store *s, const iso_render_request *q, const iso_render_options *frame)
{
    XXH128_hash_t hash;
    char *path = NULL;
    if (!hash_of(s, q, frame, &hash))
        return NULL;
    if (asprintf(&path, "%s/%016llx%016llx%s", s->folder, (unsigned long long)hash.high64,
                 (unsigned long long)hash.low64, suffix) < 0)
        return NULL;
    return path;
}

/* ---- files: width, height, checksum of the values, values ---- */

typedef struct header {
    uint64_t width, height, checksum;
} header;

static size_t value_bytes(size_t width, size_t height)
{
    return width * height * 4 * sizeof(float);
}

static bool load(const char *path, const iso_view *view, iso_image *image)
{
    FREED char *bytes = NULL;
    size_t size = 0;
    header about;
    const size_t wanted = value_bytes(view->width, view->height);
    bool good = iso_path_exists(path) && iso_file_read(path, &bytes, &size, NULL) == ISO_OK && size == sizeof about + wanted;
    if (good) {
        memcpy(&about, bytes, sizeof about);
        good = about.width == view->width && about.height == view->height &&
               about.checksum == XXH3_64bits(bytes + sizeof about, wanted) &&
               iso_image_create(image, view->width, view->height, NULL) == ISO_OK;
    }
    if (good)
        memcpy(image->rgba, bytes + sizeof about, wanted);
    return good;
}

/* ---- claims ---- */

/* True in a thread that draws: it waits for no other picture, so that no two ranks wait for each other. */
static _Thread_local bool draws;

/* Locks or unlocks one byte of the file, which need not exist. */
static void lock_byte(const iso_picture_store *s, uint64_t claim, short type)
{
    struct flock byte = {.l_type = type, .l_whence = SEEK_SET, .l_start = (off_t)claim, .l_len = 1};
    while (fcntl(s->claims, F_OFD_SETLKW, &byte) < 0 && errno == EINTR)
        ;
}

/* True if rank 0 has closed its store, or died: its lock is gone. */
static bool has_ended(const iso_picture_store *s)
{
    const bool is_free = flock(s->lock, LOCK_SH | LOCK_NB) == 0;
    if (is_free)
        flock(s->lock, LOCK_UN);
    return is_free;
}

uint64_t iso_picture_store_claim(iso_picture_store *s, const iso_render_request *q, const iso_render_options *frame)
{
    enum { NUMBER_BITS = 62 };
    XXH128_hash_t hash;
    if (!s || s->claims < 0 || draws || !is_kept(s, q, frame) || !hash_of(s, q, frame, &hash))
        return 0;
    if (s->ended && has_ended(s))
        s->ended();
    const uint64_t claim = (hash.low64 >> (64 - NUMBER_BITS)) | 1;
    lock_byte(s, claim, F_WRLCK);
    draws = true;
    return claim;
}

void iso_picture_store_release(iso_picture_store *s, uint64_t claim)
{
    if (claim == 0)
        return;
    draws = false;
    lock_byte(s, claim, F_UNLCK);
}

bool iso_picture_store_find(iso_picture_store *s, const iso_render_request *q, const iso_render_options *frame,
                            iso_image *image)
{
    FREED char *path = s && is_kept(s, q, frame) ? path_of(s, q, frame) : NULL;
    const bool found = path && load(path, q->view, image);
    if (found)
        ++s->taken;
    return found;
}

void iso_picture_store_put(iso_picture_store *s, const iso_render_request *q, const iso_render_options *frame,
                           const iso_image *image)
{
    if (!s || !is_kept(s, q, frame) || image->width != q->view->width || image->height != q->view->height)
        return;
    const size_t count = value_bytes(image->width, image->height);
    FREED char *path = path_of(s, q, frame);
    FREED char *bytes = malloc(sizeof(header) + count);
    const header about = {image->width, image->height, XXH3_64bits(image->rgba, count)};
    if (path && bytes) {
        memcpy(bytes, &about, sizeof about);
        memcpy(bytes + sizeof about, image->rgba, count);
        iso_file_write(path, bytes, sizeof about + count, NULL);
    }
}
