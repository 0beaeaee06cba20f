/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "base/key.h"

#include <errno.h>
#include <fcntl.h>
#include <ftw.h>
#include <inttypes.h>
#include <pthread.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>
#include <xxhash.h>

#include "base/helper.h"
#include "base/file.h"
#include "base/inputs.h"
#include "base/process.h"

struct iso_key {
    json_t *parts; /* name to hash */
    json_t *shown; /* names of the input parts in messages */
    size_t whole_bytes_left;
    bool has_failed; /* memory ended: the key is no longer all of it */
};

#define INPUT "input "

iso_key *iso_key_create(void)
{
    iso_key *key = malloc(sizeof *key);
    if (!key)
        return NULL;
    *key = (iso_key){.parts = json_object(), .shown = json_object(), .whole_bytes_left = ISO_KEY_WHOLE_BYTES};
    if (key->parts && key->shown)
        return key;
    iso_key_destroy(key);
    return NULL;
}

void iso_key_destroy(iso_key *key)
{
    if (!key)
        return;
    json_decref(key->parts);
    json_decref(key->shown);
    free(key);
}

/* ---- parts ---- */

static void put_hash(iso_key *key, const char *part, uint64_t hash)
{
    char text[17];
    snprintf(text, sizeof text, "%016" PRIx64, hash);
    key->has_failed = json_object_set_new(key->parts, part, json_string(text)) != 0 || key->has_failed;
}

void iso_key_add(iso_key *key, const char *part, const void *value, size_t bytes)
{
    put_hash(key, part, XXH3_64bits(value, bytes));
}

void iso_key_add_text(iso_key *key, const char *part, const char *text)
{
    iso_key_add(key, part, text, strlen(text));
}

void iso_key_add_all(iso_key *key, const iso_key *other)
{
    const bool good = json_object_update(key->parts, other->parts) == 0 &&
                      json_object_update(key->shown, other->shown) == 0;
    key->has_failed = !good || other->has_failed || key->has_failed;
}

/* ---- files ---- */

enum { BLOCK_BYTES = 1 << 16, SAMPLE_COUNT = 64 };

static iso_status fail_read(const char *path, iso_error *err)
{
    return iso_fail(err, iso_errno_status(), "%s: cannot be read: %s", path, strerror(errno));
}

/* Hashes `bytes` bytes from `at` on, or fewer at the end of the file. */
static bool hash_bytes(XXH3_state_t *state, int fd, off_t at, size_t bytes)
{
    static _Thread_local unsigned char block[BLOCK_BYTES];
    while (bytes > 0) {
        const ssize_t n = pread(fd, block, bytes < sizeof block ? bytes : sizeof block, at);
        if (n < 0 && errno != EINTR)
            return false;
        if (n == 0)
            return true;
        if (n > 0) {
            XXH3_64bits_update(state, block, (size_t)n);
            at += n;
            bytes -= (size_t)n;
        }
    }
    return true;
}

/* Hashes the attributes that change when the file is written, even with the same bytes. */
static void hash_marks(XXH3_state_t *state, const struct stat *st)
{
    const int64_t marks[] = {(int64_t)st->st_size,         (int64_t)st->st_ino,         (int64_t)st->st_mtim.tv_sec,
                             (int64_t)st->st_mtim.tv_nsec, (int64_t)st->st_ctim.tv_sec, (int64_t)st->st_ctim.tv_nsec};
    XXH3_64bits_update(state, marks, sizeof marks);
}

static bool hash_samples(XXH3_state_t *state, int fd, const struct stat *st)
{
    const off_t last = st->st_size > BLOCK_BYTES ? st->st_size - BLOCK_BYTES : 0;
    bool good = true;
    hash_marks(state, st);
    for (off_t i = 0; i < SAMPLE_COUNT && good; ++i)
        good = hash_bytes(state, fd, last / (SAMPLE_COUNT - 1) * i, BLOCK_BYTES);
    return good;
}

/* Hashes a file. *whole_left: bytes of files that may still be hashed whole. */
static iso_status hash_file(XXH3_state_t *state, const char *path, size_t *whole_left, iso_error *err)
{
    struct stat st;
    const int fd = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    bool good = fd >= 0 && fstat(fd, &st) == 0;
    if (good && (size_t)st.st_size <= *whole_left) {
        *whole_left -= (size_t)st.st_size;
        good = hash_bytes(state, fd, 0, (size_t)st.st_size);
    } else if (good) {
        good = hash_samples(state, fd, &st);
    }
    const iso_status status = good ? ISO_OK : fail_read(path, err);
    if (fd >= 0)
        close(fd);
    return status;
}

/* ---- folders, such as Zarr stores: their files in the order of their names ---- */

typedef struct entry {
    char *path;
    struct stat st;
} entry;

static _Thread_local struct {
    entry *all;
    size_t count, room;
} found; /* nftw() passes nothing on */

static int add_entry(const char *path, const struct stat *st, int type, struct FTW *ftw)
{
    (void)ftw;
    if (type != FTW_F)
        return 0;
    if (found.count == found.room) {
        const size_t room = found.room ? 2 * found.room : 256;
        entry *more = realloc(found.all, room * sizeof *more);
        if (!more)
            return -1;
        found.all = more;
        found.room = room;
    }
    found.all[found.count] = (entry){strdup(path), *st};
    return found.all[found.count++].path ? 0 : -1;
}

static int by_path(const void *a, const void *b)
{
    return strcmp(((const entry *)a)->path, ((const entry *)b)->path);
}

/* Hashes a folder's entries. A store may have millions of chunks: they are not opened if they exceed the budget of
 * whole files. */
static iso_status hash_entries(XXH3_state_t *state, size_t name_at, size_t *whole_left, iso_error *err)
{
    for (size_t i = 0; i < found.count; ++i) {
        const entry *e = &found.all[i];
        XXH3_64bits_update(state, e->path + name_at, strlen(e->path + name_at) + 1);
        if ((size_t)e->st.st_size <= *whole_left)
            NEED(hash_file(state, e->path, whole_left, err));
        else
            hash_marks(state, &e->st);
    }
    return ISO_OK;
}

static iso_status hash_folder(XXH3_state_t *state, const char *path, size_t *whole_left, iso_error *err)
{
    found.count = 0;
    iso_status status = nftw(path, add_entry, 16, 0) == 0 ? ISO_OK : fail_read(path, err);
    if (status == ISO_OK && found.count > 0) {
        qsort(found.all, found.count, sizeof *found.all, by_path);
        status = hash_entries(state, strlen(path), whole_left, err);
    }
    for (size_t i = 0; i < found.count; ++i)
        free(found.all[i].path);
    free(found.all);
    found.all = NULL;
    found.count = found.room = 0;
    return status;
}

static iso_status hash_path(const char *path, size_t *whole_left, uint64_t *hash, iso_error *err)
{
    XXH3_state_t *state = XXH3_createState();
    NEED_MEMORY(state, err, "%s: out of memory", path);
    XXH3_64bits_reset(state);
    const iso_status status = iso_path_is_dir(path) ? hash_folder(state, path, whole_left, err)
                                                    : hash_file(state, path, whole_left, err);
    *hash = XXH3_64bits_digest(state);
    XXH3_freeState(state);
    return status;
}

/* ---- inputs ---- */

static iso_status add_input(void *user, const char *path, iso_error *err)
{
    iso_key *key = user;
    char part[sizeof INPUT + 16];
    uint64_t hash = 0;
    NEED(hash_path(path, &key->whole_bytes_left, &hash, err));
    snprintf(part, sizeof part, INPUT "%016" PRIx64, (uint64_t)XXH3_64bits(path, strlen(path)));
    put_hash(key, part, hash);
    key->has_failed = json_object_set_new(key->shown, part, json_string_nocheck(path)) != 0 || key->has_failed;
    return ISO_OK;
}

/* ---- the program ---- */

static struct {
    pthread_once_t once;
    iso_status status;
    iso_error why;
    uint64_t hash;
} program = {.once = PTHREAD_ONCE_INIT};

/* Hashes the program and its helpers whole: a version or a build id may stay while the file changes. */
static void hash_program(void)
{
    static const char *const names[] = {"isoshade-itk", "isoshade-arrays", "isoshade-vdb", "isoshade_openvdb.so"};
    enum { COUNT = sizeof names / sizeof *names };
    uint64_t hashes[1 + COUNT] = {0};
    size_t all = SIZE_MAX;
    program.status = hash_path("/proc/self/exe", &all, &hashes[0], &program.why);
    for (size_t i = 0; i < COUNT && program.status == ISO_OK; ++i) {
        FREED char *path = iso_helper_find(names[i]);
        if (path)
            program.status = hash_path(path, &all, &hashes[1 + i], &program.why);
    }
    program.hash = XXH3_64bits(hashes, sizeof hashes);
}

static iso_status add_program(iso_key *key, iso_error *err)
{
    pthread_once(&program.once, hash_program);
    put_hash(key, "the program", program.hash);
    return program.status == ISO_OK ? ISO_OK : iso_fail(err, program.status, "%s", program.why.text);
}

/* ---- the environment ---- */

/* Beginnings of names: our own variables; Mesa's, EGL's and the makers' of graphics cards; those of renderers. */
static const char *const variables[] = {"ISOSHADE_", "LIBGL_", "MESA_", "GALLIUM_", "GALLIVM_", "LP_",
                                        "EGL_",      "__EGL_", "GL_",   "__GL",     "DRI_",     "VK_",
                                        "NVIDIA_",   "AMD_",   "RADV_", "CUDA_",    "POV",      "BLENDER_",
                                        "CYCLES_",   "OCIO",   "VTK_",  "PYTHON"};

static void add_environment(iso_key *key)
{
    for (char **word = environ; word && *word; ++word) {
        const char *equals = strchr(*word, '=');
        char part[128];
        bool is_one = false;
        for (size_t i = 0; i < sizeof variables / sizeof *variables && equals; ++i)
            is_one = is_one || strncmp(*word, variables[i], strlen(variables[i])) == 0;
        if (!is_one)
            continue;
        snprintf(part, sizeof part, "$%.*s", (int)(equals - *word), *word);
        for (char *c = part; *c; ++c) /* JSON takes UTF-8 alone */
            *c = *c > 0 ? *c : '?';
        iso_key_add_text(key, part, equals + 1);
    }
}

iso_status iso_key_add_surroundings(iso_key *key, iso_error *err)
{
    key->whole_bytes_left = ISO_KEY_WHOLE_BYTES;
    add_environment(key);
    NEED(add_program(key, err));
    return iso_inputs_visit(add_input, key, err);
}

/* ---- renderers ---- */

/* Finds a dependency's path. To be freed; NULL if the file does not exist. */
static char *find_dependency(const char *name)
{
    char *path = NULL;
    const char *home = getenv("HOME");
    if (name[0] == '~' && name[1] == '/')
        return home && asprintf(&path, "%s%s", home, name + 1) >= 0 ? path : NULL;
    if (strchr(name, '/'))
        return strdup(name);
    return iso_process_find(name, name, &path, NULL) == ISO_OK ? path : NULL;
}

iso_status iso_key_add_dependency(iso_key *key, const char *name, iso_error *err)
{
    struct stat st;
    FREED char *path = find_dependency(name);
    uint64_t hash = 0;
    if (path && stat(path, &st) == 0 && S_ISREG(st.st_mode)) {
        size_t whole = st.st_size <= BLOCK_BYTES ? (size_t)st.st_size : 0; /* a script, which may be copied */
        NEED(hash_path(path, &whole, &hash, err));
    }
    put_hash(key, name, hash);
    return ISO_OK;
}

/* ---- stored keys ---- */

json_t *iso_key_to_json(const iso_key *key)
{
    return key->has_failed ? NULL : json_copy(key->parts);
}

bool iso_key_digest(const iso_key *key, char digest[ISO_KEY_DIGEST_BYTES])
{
    FREED char *text = key->has_failed ? NULL : json_dumps(key->parts, JSON_COMPACT | JSON_SORT_KEYS);
    if (!text)
        return false;
    const XXH128_hash_t hash = XXH3_128bits(text, strlen(text));
    snprintf(digest, ISO_KEY_DIGEST_BYTES, "%016" PRIx64 "%016" PRIx64, (uint64_t)hash.high64, (uint64_t)hash.low64);
    return true;
}

static void describe(const iso_key *key, const char *part, char *text, size_t size)
{
    const char *name = json_string_value(json_object_get(key->shown, part));
    if (name)
        snprintf(text, size, "%s changed since", name);
    else if (strncmp(part, INPUT, strlen(INPUT)) == 0)
        snprintf(text, size, "other files are read than then");
    else
        snprintf(text, size, "%s is not the same as then", part);
}

bool iso_key_differs(const iso_key *key, const json_t *stored, char *text, size_t size)
{
    const char *part;
    json_t *value;
    json_object_foreach (key->parts, part, value) {
        const json_t *then = json_object_get(stored, part);
        if (json_equal(value, then))
            continue;
        if (!then && strncmp(part, INPUT, strlen(INPUT)) == 0)
            snprintf(text, size, "other files are read than then");
        else
            describe(key, part, text, size);
        return true;
    }
    json_object_foreach ((json_t *)stored, part, value) {
        if (json_object_get(key->parts, part))
            continue;
        describe(key, part, text, size);
        return true;
    }
    return key->has_failed;
}
