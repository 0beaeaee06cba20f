/* SPDX-License-Identifier: MIT */
/* source.c - opening by content, and raw files. */
#define _GNU_SOURCE
#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/file.h"
#include "base/inputs.h"
#include "base/warnings.h"
#include "base/words.h"
#include "volume/stream_kernel.h"
#include "volume/unit.h"

/* Returns the bytes of all samples. If they cannot be addressed: a number larger than any file. */
size_t iso_source_bytes(const iso_volume_source *source)
{
    const iso_source_choice *c = &source->choice;
    const size_t one = iso_geometry_voxel_count(&source->header.geometry) *
                       iso_type_bytes(iso_source_stored_type(source));
    size_t cells, bytes;
    return __builtin_mul_overflow(one, c->inside_count, &cells) ||
                   __builtin_mul_overflow(cells, c->volume_count, &bytes)
               ? SIZE_MAX / 2
               : bytes;
}

static const char *form_name(const iso_volume_source *source)
{
    switch (source->form) {
    case ISO_FORM_HALF: return "half";
    case ISO_FORM_I64: return "int64";
    case ISO_FORM_U64_OF_FITS:
    case ISO_FORM_U64: return "uint64";
    default: return iso_type_name(iso_source_stored_type(source));
    }
}

iso_status iso_source_check_bytes(const iso_volume_source *source, double available, iso_error *err)
{
    const iso_geometry *g = &source->header.geometry;
    const iso_source_choice *c = &source->choice;
    double need = (double)iso_source_bytes(source);
    char times[48] = "";
    if (available < 0)
        return iso_fail(err, ISO_E_FORMAT, "%s: truncated: its samples start %.0f bytes after its end", source->path,
                        -available);
    if (available == need)
        return ISO_OK;
    if (c->inside_count > 1 || c->volume_count > 1)
        snprintf(times, sizeof times, ", %zu times,", c->inside_count * c->volume_count);
    return iso_fail(err, ISO_E_FORMAT, "%s: %s: holds %.0f bytes of samples, %zu x %zu x %zu of %s%s need %.0f",
                    source->path, available < need ? "truncated" : "too long", available, g->size[0], g->size[1],
                    g->size[2], form_name(source), times, need);
}

iso_status iso_source_check_packed(const iso_volume_source *source, const char *path, double packed, double most,
                                   iso_error *err)
{
    const size_t need = iso_source_bytes(source);
    return (double)need <= most * packed
               ? ISO_OK
               : iso_fail(err, ISO_E_FORMAT,
                          "%s: truncated: %.0f compressed bytes cannot hold the %zu that the sizes need", path, packed,
                          need);
}

iso_status iso_source_check_regular(const char *path, iso_error *err)
{
    struct stat st;
    if (stat(path, &st) != 0)
        return iso_fail(err, iso_errno_status(), "%s: cannot be opened: %s", path, strerror(errno));
    return S_ISREG(st.st_mode) ? ISO_OK : iso_fail(err, ISO_E_IO, "%s: is not a regular file", path);
}

iso_status iso_source_check_read(FILE *f, const char *path, iso_status status, iso_error *err)
{
    return ferror(f) ? iso_fail(err, ISO_E_IO, "%s: cannot be read", path) : status;
}

iso_status iso_source_check_read_gz(gzFile gz, const char *path, iso_status status, iso_error *err)
{
    int code;
    gzerror(gz, &code);
    return code == Z_ERRNO ? iso_fail(err, ISO_E_IO, "%s: cannot be read", path) : status;
}

/* Does the work of iso_source_check_bytes() for the rest of the plain file. */
static iso_status source_check_rest(const iso_volume_source *source, iso_error *err)
{
    struct stat st;
    const off_t at = ftello(source->file);
    if (at < 0 || fstat(fileno(source->file), &st) != 0)
        return iso_fail(err, ISO_E_IO, "%s: the samples cannot be read", source->path);
    return iso_source_check_bytes(source, (double)st.st_size - (double)at, err);
}

static iso_status open_at(iso_volume_source *source, const char *path, size_t offset, iso_error *err)
{
    NEED(iso_source_check_regular(path, err));
    if (path != source->unpacked.path) /* the packed file is noted */
        NEED(iso_inputs_note(path, err));
    source->file = fopen(path, "rb");
    if (!source->file)
        return iso_fail(err, iso_errno_status(), "%s: cannot be opened: %s", path, strerror(errno));
    if (fseeko(source->file, (off_t)offset, SEEK_SET) != 0)
        return iso_fail(err, ISO_E_IO, "%s: cannot be read at byte %zu", path, offset);
    return ISO_OK;
}

iso_status iso_source_take_part(iso_volume_source *source, const char *path, size_t offset, iso_error *err)
{
    struct stat st;
    NEED(open_at(source, path, offset, err));
    if (fstat(fileno(source->file), &st) != 0)
        return iso_fail(err, ISO_E_IO, "%s: the samples cannot be read", path);
    const double there = (double)st.st_size - (double)offset;
    return there >= (double)iso_source_bytes(source) ? ISO_OK : iso_source_check_bytes(source, there, err);
}

iso_status iso_source_take_file(iso_volume_source *source, const char *path, size_t offset, iso_error *err)
{
    NEED(open_at(source, path, offset, err));
    return source_check_rest(source, err);
}

iso_status iso_source_unit(iso_volume_source *source, const char *unit, const char *fallback, double *mm,
                           iso_error *err)
{
    iso_volume_notes *notes = &source->header.notes;
    const char *word = source->hints.unit ? source->hints.unit : unit && *unit ? unit : fallback, *name = "mm";
    if (!iso_unit_find(word, mm, &name))
        return iso_fail(err, ISO_E_FORMAT,
                        "%s: unknown unit \"%s\"; override it with --unit, one of " ISO_UNIT_NAMES
                        "; if it is no length, set --spacing, too",
                        source->path, word);
    notes->unit_mm = *mm;
    if (source->hints.unit || (unit && *unit))
        snprintf(notes->unit, sizeof notes->unit, "%s", name);
    return ISO_OK;
}

/* Names the options that choose of several, for an overview that fails before it could show them. */
static const char *describe_choice(const iso_volume_source *source, char *text, size_t size)
{
    const iso_volume_notes *n = &source->header.notes;
    *text = 0;
    if (source->hints.takes_first && !source->hints.frame && n->frame_count > 1)
        iso_words_append(text, size, "; --frame K chooses one of %zu frames", n->frame_count);
    if (source->hints.takes_first && !source->hints.channel && n->channel_count > 1)
        iso_words_append(text, size, "; --channel chooses one of %zu channels: %s", n->channel_count, n->channel_list);
    return text;
}

iso_status iso_source_need_spacing(const iso_volume_source *source, const char *what, iso_error *err)
{
    if (source->hints.spacing_mm[0] > 0)
        return ISO_OK;
    char choice[400];
    return iso_fail(err, ISO_E_FORMAT, "%s: does not state the spacing %s; set --spacing SXxSYxSZ, in mm%s",
                    source->path, what, describe_choice(source, choice, sizeof choice));
}

iso_status iso_source_take_spacing(const iso_volume_source *source, double spacing[3], iso_error *err)
{
    char along[32] = "of its voxels";
    int wrong = -1, lacking = 0, last = 0;
    for (int a = 0; a < 3; ++a) {
        const bool is_good = spacing[a] > 0 && isfinite(spacing[a]);
        lacking += isnan(spacing[a]);
        last = isnan(spacing[a]) ? a : last;
        wrong = !is_good && !isnan(spacing[a]) && wrong < 0 ? a : wrong;
    }
    if (source->hints.spacing_mm[0] > 0)
        for (int a = 0; a < 3 && (wrong >= 0 || lacking > 0); ++a)
            spacing[a] = spacing[a] > 0 && isfinite(spacing[a]) ? spacing[a] : 1;
    else if (wrong >= 0)
        return iso_fail(
            err, ISO_E_FORMAT,
            "%s: its spacing along axis %d is %g mm, must be above 0 and finite; override it with --spacing SXxSYxSZ",
            source->path, wrong + 1, spacing[wrong]);
    if (lacking == 1 && last == 2)
        snprintf(along, sizeof along, "between its slices");
    else if (lacking < 3)
        snprintf(along, sizeof along, "along its axis %d", last + 1);
    return lacking > 0 ? iso_source_need_spacing(source, along, err) : ISO_OK;
}

iso_status iso_source_check_geometry(iso_volume_source *source, iso_error *err)
{
    iso_geometry *g = &source->header.geometry;
    double spacing[3], good[3];
    iso_geometry_spacing_mm(g, spacing);
    memcpy(good, spacing, sizeof good);
    NEED(iso_source_take_spacing(source, good, err));
    for (int a = 0; a < 3; ++a)
        for (int r = 0; r < 3 && good[a] != spacing[a]; ++r) /* the hint gives its length: no direction is left */
            g->index_to_world.m[r][a] = r == a;
    if (memcmp(good, spacing, sizeof good) != 0 && !isfinite(iso_norm(g->origin_mm))) {
        g->origin_mm = iso_v3(0, 0, 0);
        g->origin_mm = iso_scale(iso_geometry_box_center_mm(g), -1);
    }
    return iso_geometry_check(g, source->path, err);
}

/* Applies the hint's spacing to each axis and keeps the box's center. */
static void apply_spacing(iso_volume_source *source)
{
    iso_geometry *g = &source->header.geometry;
    const iso_vec3 center = iso_geometry_box_center_mm(g);
    double spacing[3];
    iso_geometry_spacing_mm(g, spacing);
    if (!(source->hints.spacing_mm[0] > 0))
        return;
    for (int a = 0; a < 3; ++a)
        for (int r = 0; r < 3; ++r)
            g->index_to_world.m[r][a] *= source->hints.spacing_mm[a] / spacing[a];
    g->origin_mm = iso_add(g->origin_mm, iso_sub(center, iso_geometry_box_center_mm(g)));
}

/* Returns the bytes of FILE in FILE:PART; all bytes if a file has the whole name, or if no such FILE exists. */
static size_t path_bytes(const char *path)
{
    struct stat st;
    for (const char *at = stat(path, &st) == 0 ? NULL : strchr(path, ':'); at; at = strchr(at + 1, ':')) {
        FREED char *before = strndup(path, (size_t)(at - path));
        const bool found = before && *before && stat(before, &st) == 0;
        if (found && at[1])
            return (size_t)(at - path);
    }
    return strlen(path);
}

static iso_status new_source(const char *path, const iso_volume_hints *hints, iso_volume_source **source,
                             iso_error *err)
{
    struct stat st;
    *source = NULL;
    iso_volume_source *s = calloc(1, sizeof *s);
    const size_t bytes = path_bytes(path);
    if (s)
        s->path = strndup(path, bytes);
    if (s && path[bytes])
        s->part = strdup(path + bytes + 1);
    if (s && s->path && stat(s->path, &st) != 0) {
        iso_source_close(s);
        return iso_fail(err, iso_errno_status(), "%s: cannot be opened: %s", path, strerror(errno));
    }
    if (s && s->path && !S_ISREG(st.st_mode) && !S_ISDIR(st.st_mode)) {
        iso_source_close(s);
        return iso_fail(err, ISO_E_IO, "%s: is neither a regular file nor a folder", path);
    }
    if (!s || !s->path || (path[bytes] && !s->part)) {
        iso_source_close(s);
        return iso_fail(err, ISO_E_MEMORY, "%s: out of memory", path);
    }
    s->header.notes.scale_slope = 1;
    s->header.notes.unit_mm = 1;
    s->choice.inside_count = s->choice.volume_count = 1;
    if (hints)
        s->hints = *hints;
    *source = s;
    return ISO_OK;
}

typedef struct file_head {
    unsigned char bytes[ISO_VOLUME_HEAD_BYTES];
    size_t size;
    bool is_gzip; /* True if the bytes are unpacked ones */
} file_head;

/* Reads the first bytes, unpacked by zlib if gzip packed them. */
static iso_status read_head(const char *path, file_head *head, iso_error *err)
{
    gzFile gz = gzopen(path, "rb");
    if (!gz)
        return iso_fail(err, iso_errno_status(), "%s: cannot be opened: %s", path, strerror(errno));
    head->is_gzip = !gzdirect(gz);
    int n = gzread(gz, head->bytes, ISO_VOLUME_HEAD_BYTES), code = Z_OK;
    if (n < 0)
        gzerror(gz, &code);
    iso_status status = ISO_OK;
    if (code == Z_ERRNO || code == Z_MEM_ERROR)
        status = iso_fail(err, code == Z_ERRNO ? iso_errno_status() : ISO_E_MEMORY, "%s: cannot be read: %s", path,
                          code == Z_ERRNO ? strerror(errno) : "out of memory");
    head->size = n > 0 ? (size_t)n : 0;
    gzclose(gz);
    return status;
}

static iso_status refuse_series(const iso_volume_source *s, iso_error *err)
{
    return iso_fail(err, ISO_E_USAGE, "%s: is one volume, --series %s chooses among those of a folder of DICOM slices",
                    s->path, s->hints.series);
}

static iso_status open_as(const iso_volume_format *f, iso_volume_source *s, iso_error *err)
{
    if (s->part && !f->takes_part)
        return iso_fail(err, ISO_E_USAGE,
                        "%s:%s: a file of this kind (%s) is one volume, \":%s\" names none of several", s->path,
                        s->part, f->title, s->part);
    if (s->hints.series && !(f->takes_series && iso_path_is_dir(s->path)))
        return refuse_series(s, err);
    if (f->open)
        return f->open(s, err);
    ENDED_BY(iso_close_file) FILE *file = fopen(s->path, "rb");
    return file ? iso_source_check_read(file, s->path, f->read(file, s, err), err)
                : iso_fail(err, iso_errno_status(), "%s: cannot be opened: %s", s->path, strerror(errno));
}

/* Opens a file or folder whose first bytes no format recognizes, by its path. */
static iso_status open_by_path(iso_volume_source *s, bool *found, iso_error *err)
{
    const iso_volume_format *f;
    *found = false;
    for (size_t i = 0; (f = iso_volume_format_at(i)) && !*found; ++i)
        if (f->probe_path && (*found = f->probe_path(s->path)))
            return open_as(f, s, err);
    return ISO_OK;
}

/* True if the name of a folder, with or without a slash at its end, has the ending. */
static bool is_named(const char *folder, const char *ending)
{
    const size_t tail = strlen(ending);
    size_t length = strlen(folder);
    if (length > 0 && folder[length - 1] == '/')
        --length;
    return length > tail && strncmp(folder + length - tail, ending, tail) == 0;
}

/* Reports why a folder is not a volume: it is unreadable, lacks the file that its name promises, or has no slices. */
static iso_status refuse_folder(const char *path, iso_error *err)
{
    static const struct {
        const char *ending, *what, *file;
    } kinds[] = {{".iso", "a pyramid", "pyramid.json"}, {".zarr", "a Zarr", ".zarray, .zgroup or zarr.json"}};
    if (access(path, R_OK | X_OK) != 0)
        return iso_fail(err, iso_errno_status(), "%s: cannot be read: %s", path, strerror(errno));
    for (size_t i = 0; i < sizeof kinds / sizeof *kinds; ++i)
        if (is_named(path, kinds[i].ending))
            return iso_fail(err, ISO_E_FORMAT, "%s: named as %s, but has no %s", path, kinds[i].what, kinds[i].file);
    return iso_fail(err, ISO_E_FORMAT, "%s: a folder that holds no slices of a volume", path);
}

/* True if a folder that is named as a pyramid lacks its list; a reader of slices would take its levels for slices. */
static bool is_broken_pyramid(const char *path)
{
    FREED char *list = iso_path_join(path, "pyramid.json");
    const bool is_broken = list && is_named(path, ".iso") && !iso_path_is_file(list);
    return is_broken;
}

/* Files that people have and no format reads, by their first bytes. */
static const struct {
    const char *magic;
    size_t bytes;
    const char *kind, *remedy;
} others[] = {
    {"PK\3\4", 4, "a zip archive", "unpack it"},
    {"ZISRAWFILE", 10, "CZI of Zeiss", "bioformats2raw converts it to OME-Zarr"},
    {"\xda\xce\xbe\x0a", 4, "ND2 of Nikon", "bioformats2raw converts it to OME-Zarr"},
    {"\x70\0\0\0", 4, "LIF of Leica", "bioformats2raw converts it to OME-Zarr"},
    {"MATLAB 5", 8, "MATLAB's version 5", "save it with -v7.3, as HDF5"},
    {"%PDF", 4, "PDF", "export its pictures"},
    {"\xff\x4f\xff\x51", 4, "JPEG 2000", "opj_decompress makes TIFF of it"},
};

static iso_status refuse_unknown(const iso_volume_source *s, const file_head *head, iso_error *err)
{
    char shown[9] = "";
    for (size_t i = 0; i < sizeof others / sizeof *others; ++i) {
        if (others[i].bytes <= head->size && memcmp(head->bytes, others[i].magic, others[i].bytes) == 0)
            return iso_fail(err, ISO_E_FORMAT, "%s: is %s, which is not read; %s", s->path, others[i].kind,
                            others[i].remedy);
    }
    if (head->size >= 262 && memcmp(head->bytes + 257, "ustar", 5) == 0)
        return iso_fail(err, ISO_E_FORMAT, "%s: is a tar archive, which is not read; unpack it", s->path);
    if (memmem(head->bytes, head->size, "<VTKFile", 8))
        return iso_fail(err, ISO_E_FORMAT,
                        "%s: is a grid of VTK that is not read, unlike .vti, .vtr, .pvti and .pvtr; ParaView's filter "
                        "Resample To Image makes one",
                        s->path);
    for (size_t i = 0; i < 8 && i < head->size; ++i)
        shown[i] = head->bytes[i] >= 32 && head->bytes[i] < 127 ? (char)head->bytes[i] : '?';
    return iso_fail(err, ISO_E_FORMAT,
                    "%s: starts with \"%s\", an unknown format; isoshade list names those that are read, "
                    "--raw-size and --raw-type read samples without a header",
                    s->path, shown);
}

static const iso_volume_format *find_format(const file_head *head)
{
    const iso_volume_format *f;
    for (size_t i = 0; (f = iso_volume_format_at(i)); ++i)
        if (iso_marks_fit(f->marks, ISO_VOLUME_MARKS, head->bytes, head->size) ||
            (f->probe && f->probe(head->bytes, head->size)))
            return f;
    return NULL;
}

static iso_status open_plain(iso_volume_source *s, const file_head *head, iso_error *err)
{
    const iso_volume_format *f = find_format(head);
    bool found = f != NULL;
    if (head->size == 0)
        return iso_fail(err, ISO_E_FORMAT, "%s: is empty", s->path);
    const iso_status status = f ? open_as(f, s, err) : open_by_path(s, &found, err);
    return found ? status : refuse_unknown(s, head, err);
}

/* Opens an unpacked copy, so that each format is read of each packer. Messages name the user's file. */
static iso_status open_packed(iso_volume_source *s, iso_error *err)
{
    file_head head;
    NEED(iso_unpack(s->path, &s->unpacked, err));
    char *const own = s->path;
    s->path = s->unpacked.path;
    iso_status status = read_head(s->path, &head, err);
    TRY(status, open_plain(s, &head, err));
    s->path = own;
    if (status != ISO_OK)
        iso_output_rename_in(s->unpacked.path, own, err);
    return status;
}

static iso_status open_by_content(iso_volume_source *s, iso_error *err)
{
    bool found = false;
    if (iso_path_is_dir(s->path)) {
        if (is_broken_pyramid(s->path))
            return refuse_folder(s->path, err);
        const iso_status status = open_by_path(s, &found, err);
        return found ? status : refuse_folder(s->path, err);
    }
    file_head head;
    NEED(read_head(s->path, &head, err));
    const iso_volume_format *f = find_format(&head);
    const bool is_packed = head.is_gzip ? !(f && f->unpacks) : !f && iso_looks_packed(head.bytes, head.size);
    if (!is_packed)
        return open_plain(s, &head, err);
    const iso_status by_path = f ? ISO_OK : open_by_path(s, &found, err);
    return found ? by_path : open_packed(s, err);
}

iso_status iso_source_open(const char *path, iso_volume_source **source, iso_error *err)
{
    return iso_source_open_with(path, NULL, source, err);
}

static iso_status finish_choice(iso_volume_source *s, iso_error *err)
{
    /* formats with a single volume by definition make no choice */
    const iso_extra_axes one = {0};
    if (!s->header.notes.frame_count)
        NEED(iso_source_choose(s, &one, err));
    if (s->choice.luminance)
        iso_source_make_floats(s);
    return iso_source_skip_stored(s, s->choice.volume_at * s->header.geometry.size[2], err);
}

static iso_status open_as_stored(const char *path, const iso_volume_hints *hints, iso_volume_source **source,
                                 iso_error *err)
{
    ENDED_BY(iso_source_close_owned) iso_volume_source *s = NULL;
    *source = NULL;
    NEED(new_source(path, hints, &s, err));
    NEED(iso_inputs_note(s->path, err));
    NEED(open_by_content(s, err));
    NEED(finish_choice(s, err));
    apply_spacing(s);
    s->header.geometry.is_patient = s->header.notes.world_is_ras;
    *source = s;
    s = NULL;
    return ISO_OK;
}

/* Widens [lo, hi] by all samples of a source of doubles, which it reads to the end. */
static iso_status find_range(iso_volume_source *source, double *lo, double *hi, iso_error *err)
{
    const size_t *n = source->header.geometry.size, plane = n[0] * n[1];
    FREED double *samples = malloc(plane * sizeof *samples);
    NEED_MEMORY(samples, err, "%s: no memory for a plane", source->path);
    for (size_t z = 0; z < n[2]; ++z) {
        NEED(iso_source_read(source, 1, samples, err));
        for (size_t i = 0; i < plane; ++i) {
            *lo = fmin(*lo, samples[i]);
            *hi = fmax(*hi, samples[i]);
        }
    }
    return ISO_OK;
}

/* Sets the type of a source of 64-bit integers by all its samples. */
static void take_narrow_type(iso_volume_source *source, double lo, double hi)
{
    if (lo >= INT32_MIN && hi <= INT32_MAX)
        source->header.type = ISO_I32;
    else if (lo >= 0 && hi <= UINT32_MAX)
        source->header.type = ISO_U32;
}

/* Reads 64-bit integers as 32-bit ones if all fit, which is usual, otherwise as doubles. Takes a pass of its own, since
 * the type is needed before the first sample. */
static iso_status narrow(const char *path, const iso_volume_hints *hints, iso_volume_source *source, iso_error *err)
{
    const iso_volume_notes *notes = &source->header.notes;
    ENDED_BY(iso_source_close_owned) iso_volume_source *all = NULL;
    double lo = INFINITY, hi = -INFINITY;
    if (source->form < ISO_FORM_I64 || source->scaled || notes->scale_slope != 1 || notes->scale_intercept != 0)
        return ISO_OK;
    NEED(open_as_stored(path, hints, &all, err));
    NEED(find_range(all, &lo, &hi, err));
    take_narrow_type(source, lo, hi);
    return ISO_OK;
}

/* Finds out whether voxels have the file's fill values. Takes a pass of its own, since these change the type. */
static iso_status find_fills(const char *path, const iso_volume_hints *hints, iso_volume_source *source, iso_error *err)
{
    ENDED_BY(iso_source_close_owned) iso_volume_source *all = NULL;
    if (source->hints.no_data.is_given && !source->hints.no_data.is_none)
        iso_source_hold_no_data(source);
    if (source->look.fill_count == 0)
        return ISO_OK;
    NEED(open_as_stored(path, hints, &all, err));
    NEED(iso_source_look_for_fills(all, &source->has_fills, err));
    if (source->has_fills)
        iso_source_hold_no_data(source);
    else
        source->look.fill_count = 0;
    return ISO_OK;
}

static iso_status open_one(const char *path, const iso_volume_hints *hints, iso_volume_source **source, iso_error *err)
{
    iso_status status = open_as_stored(path, hints, source, err);
    TRY(status, narrow(path, hints, *source, err));
    TRY(status, find_fills(path, hints, *source, err));
    if (status != ISO_OK) {
        iso_source_close(*source);
        *source = NULL;
    }
    return status;
}

iso_status iso_source_open_with(const char *path, const iso_volume_hints *hints, iso_volume_source **source,
                                iso_error *err)
{
    iso_frame_file found;
    *source = NULL;
    iso_status status = iso_frames_of_files(path, hints, &found, err);
    if (status != ISO_OK || !found.path) /* one file of frames, or of one */
        return status == ISO_OK ? open_one(path, hints, source, err) : status;
    iso_volume_hints own = hints ? *hints : (iso_volume_hints){0};
    own.frame = NULL;
    status = open_one(found.path, &own, source, err);
    free(found.path);
    if (status != ISO_OK)
        return status;
    (*source)->header.notes.frame_count = found.count;
    (*source)->header.notes.frame = found.frame;
    (*source)->header.notes.frame_step = found.step > 0 ? found.step : 0;
    return ISO_OK;
}

/* True if a file of that size may be the layout's: what follows the samples is less than a plane, a trailer. */
static bool fits_raw(const iso_volume_source *s, const iso_raw_layout *layout, double size)
{
    const double more = size - (double)layout->skip_bytes - (double)iso_source_bytes(s);
    return more >= 0 && more < (double)iso_source_plane_bytes(s);
}

/* Unpacks a raw file that a packer's first bytes begin, unless it has the bytes of the layout: then these are
 * samples. */
static iso_status unpack_raw(iso_volume_source *s, const iso_raw_layout *layout, iso_error *err)
{
    unsigned char head[8];
    struct stat st;
    ENDED_BY(iso_close_file) FILE *f = fopen(s->path, "rb");
    const size_t size = f ? fread(head, 1, sizeof head, f) : 0;
    const bool is_plain = !iso_looks_packed(head, size) || stat(s->path, &st) != 0 ||
                          (double)st.st_size == (double)layout->skip_bytes + (double)iso_source_bytes(s);
    return is_plain ? ISO_OK : iso_unpack(s->path, &s->unpacked, err);
}

/* Opens the samples. A trailer is left out with a warning; a longer rest means wrong sizes. */
static iso_status take_raw(iso_volume_source *s, const iso_raw_layout *layout, iso_error *err)
{
    const char *path = s->unpacked.path ? s->unpacked.path : s->path;
    struct stat st;
    char text[640];
    if (stat(path, &st) != 0 || !fits_raw(s, layout, (double)st.st_size))
        return iso_source_take_file(s, path, layout->skip_bytes, err);
    const size_t more = (size_t)st.st_size - layout->skip_bytes - iso_source_bytes(s);
    if (more > 0) {
        snprintf(text, sizeof text, "%.500s: the %zu bytes after its samples are left out", s->path, more);
        iso_warn(text);
    }
    return iso_source_take_part(s, path, layout->skip_bytes, err);
}

static iso_status open_raw(iso_volume_source *s, const iso_raw_layout *layout, iso_error *err)
{
    s->header.type = layout->type;
    if (layout->form)
        iso_source_set_form(s, layout->form);
    s->hints.no_data = layout->no_data;
    s->header.geometry = iso_geometry_axis_aligned(layout->size, layout->spacing_mm);
    s->swap_bytes = layout->big_endian == (__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__);
    NEED(iso_geometry_check(&s->header.geometry, s->path, err));
    NEED(unpack_raw(s, layout, err));
    return take_raw(s, layout, err);
}

static iso_status open_raw_as_stored(const char *path, const iso_raw_layout *layout, iso_volume_source **source,
                                     iso_error *err)
{
    ENDED_BY(iso_source_close_owned) iso_volume_source *s = NULL;
    *source = NULL;
    NEED(new_source(path, NULL, &s, err));
    if (iso_path_is_dir(path))
        return iso_fail(err, ISO_E_IO, "%s: is not a regular file", path);
    NEED(open_raw(s, layout, err));
    *source = s;
    s = NULL;
    return ISO_OK;
}

/* Reads integers of 64 bits to their end and opens them again, as narrow() does. */
static iso_status narrow_raw(const char *path, const iso_raw_layout *layout, iso_volume_source **source, iso_error *err)
{
    double lo = INFINITY, hi = -INFINITY;
    const iso_status status = find_range(*source, &lo, &hi, err);
    iso_source_close(*source);
    *source = NULL;
    NEED(status);
    NEED(open_raw_as_stored(path, layout, source, err));
    take_narrow_type(*source, lo, hi);
    return ISO_OK;
}

iso_status iso_source_open_raw(const char *path, const iso_raw_layout *layout, iso_volume_source **source,
                               iso_error *err)
{
    NEED(open_raw_as_stored(path, layout, source, err));
    if (layout->form >= ISO_FORM_I64)
        NEED(narrow_raw(path, layout, source, err));
    if (layout->no_data.is_given && !layout->no_data.is_none)
        iso_source_hold_no_data(*source);
    return ISO_OK;
}

const iso_volume_format iso_volume_format_raw = {
    .name = "raw",
    .title = "raw",
    .summary = "a file without a header, by --raw-size and --raw-type, plane by plane",
    .suffixes = ".raw",
};

const iso_volume *iso_source_volume(const iso_volume_source *source)
{
    return &source->header;
}
