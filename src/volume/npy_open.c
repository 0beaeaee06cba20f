/* SPDX-License-Identifier: MIT */
/* npy_open.c - arrays that numpy.save() wrote: a Python dictionary of type, order and shape, then the samples [NEP 1].
 *
 * Axes: (z, y, x) in C order, (x, y, z) in Fortran order, so that x runs fastest. Of four axes the fastest has channels
 * if it has at most four samples, as in NRRD, or else the slowest time; of five both. Three or four bytes are colors.
 * The format has no spacing: --spacing gives it. An .npz is a zip archive of arrays, FILE:NAME; one is unpacked. */
#define _GNU_SOURCE
#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "volume/npy.h"
#include "volume/stream_kernel.h"

enum { MAGIC_BYTES = 6, START_BYTES = 12, MOST_CHANNELS = 4 };
static const char magic[] = "\x93NUMPY";

typedef struct npy {
    iso_npy header;
    size_t axes[ISO_NPY_MOST_AXES]; /* the fastest first */
    size_t axis_count;
} npy;

static bool starts_like_npy(const unsigned char *head, size_t size)
{
    return size >= MAGIC_BYTES && memcmp(head, magic, MAGIC_BYTES) == 0;
}

iso_status iso_npy_read_header(const char *path, iso_npy *n, iso_error *err)
{
    unsigned char start[START_BYTES];
    ENDED_BY(iso_close_file) FILE *f = fopen(path, "rb");
    if (!f)
        return iso_fail(err, iso_errno_status(), "%s: cannot be opened: %s", path, strerror(errno));
    size_t got = fread(start, 1, START_BYTES, f);
    const bool is_long = got > 6 && start[6] >= 2; /* versions 2 and 3 have 4 bytes for the length */
    const size_t text_at = is_long ? 12 : 10;
    size_t length = got < START_BYTES ? 0 : start[8] + 256u * start[9];
    if (is_long && got == START_BYTES)
        length += ((size_t)start[10] << 16) + ((size_t)start[11] << 24);
    n->samples_at = text_at + length;
    got = 0;
    if (length > 0 && length <= ISO_NPY_MOST_HEADER && fseek(f, (long)text_at, SEEK_SET) == 0)
        got = fread(n->text, 1, length, f);
    n->text[got] = 0;
    NEED(iso_source_check_read(f, path, ISO_OK, err));
    return got > 0 && got == length
               ? ISO_OK
               : iso_fail(err, ISO_E_FORMAT,
                          "%s: damaged: a NumPy header of %zu bytes, must be 1 to %d and in the file", path, length,
                          ISO_NPY_MOST_HEADER);
}

const char *iso_npy_value(const iso_npy *n, const char *key)
{
    char quoted[32];
    snprintf(quoted, sizeof quoted, "'%s'", key);
    const char *at = strstr(n->text, quoted);
    if (!at)
        return NULL;
    at += strlen(quoted);
    at += strspn(at, " ");
    return *at == ':' ? at + 1 + strspn(at + 1, " ") : NULL;
}

bool iso_npy_type(const iso_npy *n, char *order, char name[3])
{
    const char *value = iso_npy_value(n, "descr");
    return value && sscanf(value, "'%c%2[a-z0-9]'", order, name) == 2 && strchr("<>|=", *order) && strlen(name) == 2 &&
           value[4] == '\'';
}

bool iso_npy_is_swapped(char order)
{
    return order == (__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__ ? '>' : '<');
}

static iso_status take_type(const npy *n, iso_volume_source *source, iso_error *err)
{
    static const struct {
        const char *name;
        iso_type type;
    } types[] = {{"b1", ISO_U8},  {"u1", ISO_U8},  {"i1", ISO_I8},  {"u2", ISO_U16}, {"i2", ISO_I16},
                 {"u4", ISO_U32}, {"i4", ISO_I32}, {"f4", ISO_F32}, {"f8", ISO_F64}};
    static const struct {
        const char *name;
        iso_form form;
    } forms[] = {{"f2", ISO_FORM_HALF}, {"i8", ISO_FORM_I64}, {"u8", ISO_FORM_U64}};
    const char *value = iso_npy_value(&n->header, "descr");
    char order = 0, name[3] = "";
    if (iso_npy_type(&n->header, &order, name)) {
        source->swap_bytes = name[1] != '1' && iso_npy_is_swapped(order);
        for (size_t i = 0; i < sizeof types / sizeof *types; ++i)
            if (strcmp(name, types[i].name) == 0) {
                source->header.type = types[i].type;
                return ISO_OK;
            }
        for (size_t i = 0; i < sizeof forms / sizeof *forms; ++i)
            if (strcmp(name, forms[i].name) == 0) {
                iso_source_set_form(source, forms[i].form);
                return ISO_OK;
            }
    }
    if (value && *value == '[')
        return iso_fail(err, ISO_E_FORMAT,
                        "%s: its type has fields, must be one number; numpy.save() one field, a['NAME']", source->path);
    return iso_fail(err, ISO_E_FORMAT,
                    "%s: its type is %.*s, must be a bool, integer or float of 16 to 64 bits; numpy's "
                    "astype() converts it",
                    source->path, value ? (int)strcspn(value, ",}\n") : 7, value ? value : "missing");
}

bool iso_npy_shape(const iso_npy *n, size_t axes[ISO_NPY_MOST_AXES], size_t *count, bool *is_fortran)
{
    const char *order = iso_npy_value(n, "fortran_order"), *value = iso_npy_value(n, "shape");
    *count = 0;
    if (!order || !value || *value++ != '(')
        return false;
    *is_fortran = strncmp(order, "True", 4) == 0;
    for (value += strspn(value, " "); *value != ')'; value += strspn(value, ", ")) {
        char *end;
        if (*value < '0' || *value > '9' || *count == ISO_NPY_MOST_AXES)
            return false;
        errno = 0;
        axes[(*count)++] = strtoull(value, &end, 10);
        if (errno != 0 || end == value)
            return false;
        value = end;
    }
    return true;
}

static iso_status take_axes(npy *n, const char *path, iso_error *err)
{
    size_t axes[ISO_NPY_MOST_AXES], count;
    const char *shape = iso_npy_value(&n->header, "shape");
    bool is_fortran = false;
    if (!iso_npy_shape(&n->header, axes, &count, &is_fortran))
        return iso_fail(err, ISO_E_FORMAT, "%s: damaged, or an array of more than %d axes", path, ISO_NPY_MOST_AXES);
    if (count < 3)
        return iso_fail(err, ISO_E_FORMAT, "%s: its shape is %.*s, a volume has 3 axes, with time or channels 4", path,
                        (int)strcspn(shape, ")") + 1, shape);
    for (size_t a = 0; a < count; ++a) {
        n->axes[a] = axes[is_fortran ? a : count - 1 - a];
        if (n->axes[a] < 1)
            return iso_fail(err, ISO_E_RANGE, "%s: its shape is %.*s, each axis must be at least 1", path,
                            (int)strcspn(shape, ")") + 1, shape);
    }
    n->axis_count = count;
    return ISO_OK;
}

/* Sorts the axes into those of space, the next three from *first on, and others. */
static iso_status sort_axes(const npy *n, const iso_volume_source *source, size_t *first, iso_extra_axes *extra,
                            iso_error *err)
{
    const size_t *axes = n->axes, slowest = axes[n->axis_count - 1];
    const bool are_bytes = source->header.type == ISO_U8 && !source->form;
    const bool is_last = are_bytes && n->axis_count == 4 && axes[0] > MOST_CHANNELS && (slowest == 3 || slowest == 4);
    *first = n->axis_count > 3 && axes[0] <= MOST_CHANNELS;
    *extra = (iso_extra_axes){.frame = {.count = 1, .stride = 1}, .channel = {.count = 1, .stride = 1}};
    if (*first)
        extra->channel = (iso_extra_axis){axes[0], true, 1};
    else if (is_last) /* planes of colors */
        extra->channel = (iso_extra_axis){slowest, false, 1};
    if (n->axis_count > 3 + *first && !is_last)
        extra->frame.count = slowest;
    extra->is_color = are_bytes && (extra->channel.count == 3 || extra->channel.count == 4);
    if (n->axis_count == 5 && !*first)
        return iso_fail(err, ISO_E_FORMAT, "%s: 5 axes with %zu samples along the fastest, at most %d can be channels",
                        source->path, axes[0], MOST_CHANNELS);
    return ISO_OK;
}

static iso_status open_array(iso_volume_source *source, npy *n, iso_error *err)
{
    iso_extra_axes extra;
    size_t first;
    iso_geometry *g = &source->header.geometry;
    double mm;
    NEED(iso_npy_read_header(source->path, &n->header, err));
    NEED(take_type(n, source, err));
    NEED(take_axes(n, source->path, err));
    NEED(sort_axes(n, source, &first, &extra, err));
    NEED(iso_source_unit(source, "mm", "mm", &mm, err));
    NEED(iso_source_need_spacing(source, "of its voxels", err));
    *g = iso_geometry_axis_aligned(n->axes + first, (double[]){1, 1, 1});
    NEED(iso_source_check_geometry(source, err));
    NEED(iso_source_choose(source, &extra, err));
    return iso_source_take_file(source, source->path, n->header.samples_at, err);
}

static iso_status open_npy(iso_volume_source *source, iso_error *err)
{
    FREED npy *n = calloc(1, sizeof *n);
    return n ? open_array(source, n, err) : iso_fail(err, ISO_E_MEMORY, "%s: out of memory", source->path);
}

const iso_volume_format iso_volume_format_npy = {
    .name = "npy",
    .title = "NumPy array",
    .summary = "numpy.save() of 3 axes, time and channels, in C or Fortran order; by --spacing, plane by plane",
    .suffixes = ".npy",
    .starts = "\"\\x93NUMPY\"",
    .probe = starts_like_npy,
    .open = open_npy,
};

/* True for a zip archive whose first member is an array. */
static bool starts_like_npz(const unsigned char *head, size_t size)
{
    enum { LENGTH = 26, NAME = 30 };
    const size_t length = size > NAME ? head[LENGTH] + 256u * head[LENGTH + 1] : 0;
    return length > 4 && length <= size - NAME && memcmp(head, "PK\3\4", 4) == 0 &&
           memcmp(head + NAME + length - 4, ".npy", 4) == 0;
}

static iso_status open_npz(iso_volume_source *source, iso_error *err)
{
    char *const own = source->path;
    NEED(iso_unpack_member(own, source->part, ".npy", &source->unpacked, err));
    source->path = source->unpacked.path;
    iso_status status = open_npy(source, err);
    source->path = own;
    if (status != ISO_OK)
        iso_output_rename_in(source->unpacked.path, own, err);
    return status;
}

const iso_volume_format iso_volume_format_npz = {
    .name = "npz",
    .title = "NumPy archive",
    .summary = "numpy.savez(), packed or not, FILE:NAME; unpacked into a copy",
    .suffixes = ".npz",
    .starts = "a zip archive whose first file ends with .npy",
    .takes_part = true,
    .probe = starts_like_npz,
    .open = open_npz,
};
