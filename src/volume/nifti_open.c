/* SPDX-License-Identifier: MIT */
/* nifti_open.c - headers of NIfTI-1, NIfTI-2 and Analyze 7.5, whose fields NIfTI-1 keeps. The header is read and
 * checked here, since libnifti prints, and trusts its input; it computes only the affine of a qform. */
#define _GNU_SOURCE
#include <ctype.h>
#include <errno.h>
#include <math.h>
#include <nifti1_io.h>
#include <nifti2.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "base/file.h"
#include "base/inputs.h"
#include "volume/stream_kernel.h"

/* The fields of both versions; the first has shorter numbers. */
typedef struct nifti_header {
    const char *version; /* for messages */
    bool one_file, known;
    char magic[4];
    int64_t dim[8];
    int datatype, qform_code, sform_code, units, intent, colors; /* colors: 3 or 4 bytes per voxel; 0 */
    double pixdim[8], vox_offset, slope, intercept, quatern[3], qoffset[3], srow[3][4];
    double least_offset; /* of the samples in one file: after the header and its extension flag */
} nifti_header;

/* True for NIfTI-1 or NIfTI-2 of either byte order. */
static bool starts_like_nifti(const unsigned char *head, size_t size)
{
    int32_t first = 0;
    if (size >= 4)
        memcpy(&first, head, 4);
    const int32_t swapped = (int32_t)__builtin_bswap32((uint32_t)first);
    return first == 348 || swapped == 348 || first == 540 || swapped == 540;
}

/* The arrays that both versions of the header have, in types of their own. */
#define TAKE_ARRAYS(out, h) \
    memcpy(out.magic, h->magic, 3); \
    for (int i = 0; i < 8; ++i) { \
        out.dim[i] = h->dim[i]; \
        out.pixdim[i] = h->pixdim[i]; \
    } \
    for (int c = 0; c < 4; ++c) { \
        out.srow[0][c] = h->srow_x[c]; \
        out.srow[1][c] = h->srow_y[c]; \
        out.srow[2][c] = h->srow_z[c]; \
    }

static nifti_header from_nifti_1(const nifti_1_header *h)
{
    nifti_header out = {.version = "NIfTI-1",
                        .one_file = memcmp(h->magic, "n+1", 4) == 0,
                        .datatype = h->datatype,
                        .qform_code = h->qform_code,
                        .sform_code = h->sform_code,
                        .units = h->xyzt_units,
                        .intent = h->intent_code,
                        .vox_offset = h->vox_offset,
                        .slope = h->scl_slope,
                        .intercept = h->scl_inter,
                        .quatern = {h->quatern_b, h->quatern_c, h->quatern_d},
                        .qoffset = {h->qoffset_x, h->qoffset_y, h->qoffset_z},
                        .least_offset = 352};
    out.known = out.one_file || memcmp(h->magic, "ni1", 4) == 0;
    TAKE_ARRAYS(out, h)
    return out;
}

/* Keeps the fields that Analyze shares with NIfTI-1: sizes, spacings, type, and SPM's factor of the samples. Clears
 * positions, units and intent, whose bytes differ. */
static void make_analyze(nifti_header *h)
{
    h->version = "Analyze 7.5";
    h->known = true;
    h->qform_code = h->sform_code = h->units = h->intent = 0;
    h->intercept = 0;
}

static void swap_each(void *values, size_t width, size_t count)
{
    for (size_t i = 0; i < count; ++i) {
        char *at = (char *)values + i * width;
        for (size_t b = 0; b < width / 2; ++b) {
            const char c = at[b];
            at[b] = at[width - 1 - b];
            at[width - 1 - b] = c;
        }
    }
}

/* Swaps the bytes of the fields that are used. */
static void swap_nifti_2(nifti_2_header *h)
{
    swap_each(&h->datatype, 2, 1);
    swap_each(h->dim, 8, 8);
    swap_each(h->pixdim, 8, 8);
    swap_each(&h->vox_offset, 8, 3); /* and scl_slope, scl_inter */
    swap_each(&h->qform_code, 4, 2); /* and sform_code */
    swap_each(&h->quatern_b, 8, 18); /* to the end of srow_z */
    swap_each(&h->xyzt_units, 4, 2); /* and intent_code */
}

static nifti_header from_nifti_2(const nifti_2_header *h)
{
    nifti_header out = {.version = "NIfTI-2",
                        .one_file = memcmp(h->magic, "n+2\0\r\n\032\n", 8) == 0,
                        .datatype = h->datatype,
                        .qform_code = h->qform_code,
                        .sform_code = h->sform_code,
                        .units = h->xyzt_units,
                        .intent = h->intent_code,
                        .vox_offset = (double)h->vox_offset,
                        .slope = h->scl_slope,
                        .intercept = h->scl_inter,
                        .quatern = {h->quatern_b, h->quatern_c, h->quatern_d},
                        .qoffset = {h->qoffset_x, h->qoffset_y, h->qoffset_z},
                        .least_offset = 544};
    out.known = out.one_file || memcmp(h->magic, "ni2\0\r\n\032\n", 8) == 0;
    TAKE_ARRAYS(out, h)
    return out;
}

static bool our_type(int datatype, iso_type *type, int *colors)
{
    *colors = datatype == NIFTI_TYPE_RGB24 ? 3 : datatype == NIFTI_TYPE_RGBA32 ? 4 : 0;
    switch (datatype) {
    case NIFTI_TYPE_INT8: *type = ISO_I8; return true;
    case NIFTI_TYPE_RGB24:
    case NIFTI_TYPE_RGBA32:
    case NIFTI_TYPE_UINT8: *type = ISO_U8; return true;
    case NIFTI_TYPE_INT16: *type = ISO_I16; return true;
    case NIFTI_TYPE_UINT16: *type = ISO_U16; return true;
    case NIFTI_TYPE_INT32: *type = ISO_I32; return true;
    case NIFTI_TYPE_UINT32: *type = ISO_U32; return true;
    case NIFTI_TYPE_FLOAT32: *type = ISO_F32; return true;
    case NIFTI_TYPE_FLOAT64: *type = ISO_F64; return true;
    default: return false;
    }
}

/* Returns a unit as a header's word; "" if there is none. */
static const char *unit_name(int units)
{
    switch (XYZT_TO_SPACE(units)) {
    case NIFTI_UNITS_UNKNOWN: return "";
    case NIFTI_UNITS_METER: return "m";
    case NIFTI_UNITS_MM: return "mm";
    case NIFTI_UNITS_MICRON: return "um";
    default: return "a code that NIfTI does not define";
    }
}

/* True if an axis of the sform is zero. Some writers store such an sform, with a code above 0, next to a good qform. */
static bool sform_is_empty(const nifti_header *h)
{
    bool is_empty = false;
    for (int a = 0; a < 3; ++a)
        is_empty = is_empty || (h->srow[0][a] == 0 && h->srow[1][a] == 0 && h->srow[2][a] == 0);
    return is_empty;
}

/* Computes the affine of voxel centers; false if the file gives only spacings. The signs of pixdim have no meaning,
 * except pixdim[0]: the axes' handedness. */
static bool center_affine(const nifti_header *h, const double spacing[3], double m[3][4])
{
    if (h->sform_code > 0 && !sform_is_empty(h)) {
        memcpy(m, h->srow, sizeof h->srow);
        return true;
    }
    if (h->qform_code <= 0)
        return false;
    mat44 q = nifti_quatern_to_mat44((float)h->quatern[0], (float)h->quatern[1], (float)h->quatern[2],
                                     (float)h->qoffset[0], (float)h->qoffset[1], (float)h->qoffset[2],
                                     (float)spacing[0], (float)spacing[1], (float)spacing[2],
                                     h->pixdim[0] < 0 ? -1.0f : 1.0f);
    for (int r = 0; r < 3; ++r)
        for (int c = 0; c < 4; ++c)
            m[r][c] = q.m[r][c];
    return true;
}

static iso_status read_geometry(const nifti_header *h, iso_volume_source *source, iso_error *err)
{
    iso_volume *header = &source->header;
    iso_geometry *g = &header->geometry;
    double mm, m[3][4];
    NEED(iso_source_unit(source, unit_name(h->units), "mm", &mm, err));
    if (h->sform_code > 0 && sform_is_empty(h) && !(source->hints.spacing_mm[0] > 0))
        return iso_fail(
            err, ISO_E_FORMAT,
            "%s: its sform (code %d) has an axis of zeros, which spans no volume; set --spacing SXxSYxSZ, in mm, "
            "reads it by its qform",
            source->path, h->sform_code);
    double spacing[3] = {fabs(h->pixdim[1]), fabs(h->pixdim[2]), fabs(h->pixdim[3])};
    const bool by_sform = h->sform_code > 0 && !sform_is_empty(h);
    if (!by_sform)
        NEED(iso_source_take_spacing(source, spacing, err));
    size_t size[3] = {(size_t)h->dim[1], (size_t)h->dim[2], (size_t)h->dim[3]};
    *g = iso_geometry_axis_aligned(size, (double[]){spacing[0] * mm, spacing[1] * mm, spacing[2] * mm});
    header->notes.world_is_ras = center_affine(h, spacing, m);
    if (!header->notes.world_is_ras)
        return ISO_OK;
    for (int r = 0; r < 3; ++r)
        for (int c = 0; c < 3; ++c)
            g->index_to_world.m[r][c] = m[r][c] * mm;
    g->origin_mm = iso_sub(iso_v3(m[0][3] * mm, m[1][3] * mm, m[2][3] * mm),
                           iso_mul(g->index_to_world, iso_v3(0.5, 0.5, 0.5)));
    return ISO_OK;
}

static const char *time_unit(int units)
{
    switch (XYZT_TO_TIME(units)) {
    case NIFTI_UNITS_SEC: return "s";
    case NIFTI_UNITS_MSEC: return "ms";
    case NIFTI_UNITS_USEC: return "us";
    case NIFTI_UNITS_HZ: return "Hz";
    case NIFTI_UNITS_PPM: return "ppm";
    case NIFTI_UNITS_RADS: return "rad/s";
    default: return "";
    }
}

/* Chooses a frame and a component. Axis 4 is time, axis 5 has components; colors have theirs in each voxel. */
static iso_status choose(const nifti_header *h, iso_volume_source *source, iso_error *err)
{
    const size_t frames = h->dim[0] >= 4 ? (size_t)h->dim[4] : 1, components = h->dim[0] >= 5 ? (size_t)h->dim[5] : 1;
    if (h->colors && components > 1)
        return iso_fail(err, ISO_E_FORMAT, "%s: %zu components of colors, which is not read", source->path, components);
    iso_extra_axes axes = {.frame = {.count = frames, .stride = 1},
                           .channel = {.count = components, .stride = frames},
                           .frame_step = frames > 1 ? h->pixdim[4] : 0,
                           .is_color = h->colors > 0};
    if (h->colors)
        axes.channel = (iso_extra_axis){.count = (size_t)h->colors, .inside = true, .stride = 1};
    snprintf(axes.frame_unit, sizeof axes.frame_unit, "%s", time_unit(h->units));
    return iso_source_choose(source, &axes, err);
}

static iso_status check_header(const nifti_header *h, const char *path, iso_error *err)
{
    const int digit = h->version[6];
    if (!h->known)
        return iso_fail(err, ISO_E_FORMAT, "%s: the magic is \"%.3s\", %s has \"n+%c\" or \"ni%c\"", path, h->magic,
                        h->version, digit, digit);
    int64_t dim = h->dim[0];
    if (dim < 1 || dim > 7)
        return iso_fail(err, ISO_E_FORMAT, "%s: %lld axes, must be 1 to 7", path, (long long)dim);
    for (int a = 1; a <= dim; ++a)
        if (h->dim[a] < 1)
            return iso_fail(err, ISO_E_RANGE, "%s: axis %d has size %lld, must be at least 1", path, a,
                            (long long)h->dim[a]);
    while (dim > 3 && h->dim[dim] == 1)
        --dim;
    if (dim < 3 || dim > 5)
        return iso_fail(err, ISO_E_FORMAT, "%s: %lld axes, a volume has 3, with time 4, with components 5", path,
                        (long long)dim);
    const double least = h->one_file ? h->least_offset : 0;
    if (!(h->vox_offset >= least && h->vox_offset <= 1e9))
        return iso_fail(err, ISO_E_RANGE, "%s: samples start at byte %g, must be %g to 1e9", path, h->vox_offset,
                        least);
    return ISO_OK;
}

/* Returns a name with its ending replaced, ".hdr" by ".img" or back, in small letters or in capitals, with or without
 * .gz; to be freed. NULL: it has no such ending. */
static char *other_of_pair(const char *path, const char *ending, const char *other)
{
    const size_t n = strlen(ending), tail = iso_path_ends_with(path, ".gz") ? 3 : 0, length = strlen(path);
    char *name = NULL;
    if (length > n + tail && isupper((unsigned char)path[length - tail - 1]))
        other = strcmp(other, ".img") == 0 ? ".IMG" : ".HDR";
    if (length <= n + tail || strncasecmp(path + length - tail - n, ending, n) != 0 ||
        asprintf(&name, "%.*s%s%s", (int)(length - tail - n), path, other, path + length - tail) < 0)
        return NULL;
    return name;
}

/* True for the samples of a pair: the .hdr lies next to the .img. */
static bool is_image_of_pair(const char *path)
{
    FREED char *header = other_of_pair(path, ".img", ".hdr");
    const bool is_one = header && iso_path_is_file(header);
    return is_one;
}

/* Opens the file of the samples, positioned at the first one. */
static iso_status open_samples(iso_volume_source *source, const nifti_header *h, iso_error *err)
{
    FREED char *image = h->one_file ? strdup(source->path) : other_of_pair(source->path, ".hdr", ".img");
    if (!image)
        return iso_fail(err, ISO_E_FORMAT, "%s: a header alone (\"ni1\", \"ni2\") is named .hdr, its samples .img",
                        source->path);
    struct stat st;
    if (!h->one_file)
        NEED(iso_inputs_note(image, err));
    source->gz = stat(image, &st) == 0 && S_ISREG(st.st_mode) ? gzopen(image, "rb") : NULL;
    size_t offset = (size_t)h->vox_offset;
    if (!source->gz)
        return iso_fail(err, iso_errno_status(), "%s: its samples, %s, cannot be opened: %s", source->path, image,
                        strerror(errno));
    gzbuffer(source->gz, 1 << 18); /* before the first look into it */
    gzdirect(source->gz);
    NEED(iso_source_check_read_gz(source->gz, image, ISO_OK, err));
    if (!gzdirect(source->gz)) {
        NEED(iso_source_check_packed(source, image, (double)st.st_size, ISO_SOURCE_DEFLATE_MOST, err));
        return gzseek(source->gz, (z_off_t)offset, SEEK_SET) >= 0
                   ? ISO_OK
                   : iso_fail(err, ISO_E_FORMAT, "%s: truncated before the samples at byte %zu", image, offset);
    }
    gzclose(source->gz);
    source->gz = NULL;
    source->file = fopen(image, "rb");
    if (!source->file || fseeko(source->file, (off_t)offset, SEEK_SET) != 0)
        return iso_fail(err, iso_errno_status(), "%s: cannot be read: %s", image, strerror(errno));
    return iso_source_check_bytes(source, (double)st.st_size - (double)offset, err);
}

static bool is_header_of_pair(const char *path)
{
    FREED char *image = other_of_pair(path, ".hdr", ".img");
    const bool is_one = image && iso_path_is_file(image);
    return is_one;
}

/* Reads the header, in the machine's byte order. */
static iso_status read_header(iso_volume_source *source, nifti_header *out, iso_error *err)
{
    union {
        int32_t size;
        nifti_1_header one;
        nifti_2_header two;
    } h;
    memset(&h, 0, sizeof h);
    gzFile gz = gzopen(source->path, "rb");
    if (!gz)
        return iso_fail(err, iso_errno_status(), "%s: cannot be opened: %s", source->path, strerror(errno));
    const int n = gzread(gz, &h, sizeof h);
    const iso_status status = iso_source_check_read_gz(gz, source->path, ISO_OK, err);
    gzclose(gz);
    if (status != ISO_OK)
        return status;
    const int32_t swapped = (int32_t)__builtin_bswap32((uint32_t)h.size);
    const bool second = h.size == 540 || swapped == 540;
    const int need = second ? (int)sizeof h.two : (int)sizeof h.one;
    if (n < need)
        return iso_fail(err, ISO_E_FORMAT, "%s: truncated: %d bytes, a NIfTI-%d header has %d", source->path,
                        n > 0 ? n : 0, second ? 2 : 1, need);
    source->swap_bytes = swapped == need;
    if (source->swap_bytes && second)
        swap_nifti_2(&h.two);
    else if (source->swap_bytes)
        swap_nifti_header(&h.one, 1);
    *out = second ? from_nifti_2(&h.two) : from_nifti_1(&h.one);
    if (!second && h.one.magic[0] != 'n' && is_header_of_pair(source->path))
        make_analyze(out);
    return check_header(out, source->path, err);
}

/* Goes from the samples of a pair to its header. */
static iso_status go_to_header(iso_volume_source *source, iso_error *err)
{
    char *header = other_of_pair(source->path, ".img", ".hdr");
    NEED_MEMORY(header, err, "%s: out of memory", source->path);
    free(source->path);
    source->path = header;
    return iso_inputs_note(header, err);
}

static iso_status open_nifti(iso_volume_source *source, iso_error *err)
{
    nifti_header h;
    if (is_image_of_pair(source->path))
        NEED(go_to_header(source, err));
    NEED(read_header(source, &h, err));
    if (h.datatype == NIFTI_TYPE_INT64 || h.datatype == NIFTI_TYPE_UINT64)
        iso_source_set_form(source, h.datatype == NIFTI_TYPE_INT64 ? ISO_FORM_I64 : ISO_FORM_U64);
    else if (!our_type(h.datatype, &source->header.type, &h.colors))
        return iso_fail(err, ISO_E_FORMAT, "%s: data type %d (%s), must be an integer, float, double or RGB",
                        source->path, h.datatype, nifti_datatype_string(h.datatype));
    NEED(read_geometry(&h, source, err));
    NEED(choose(&h, source, err));
    source->header.notes.says_labels = h.intent == NIFTI_INTENT_LABEL;
    if (isfinite(h.slope) && h.slope != 0 && isfinite(h.intercept)) {
        source->header.notes.scale_slope = h.slope;
        source->header.notes.scale_intercept = h.intercept;
    }
    NEED(iso_source_check_geometry(source, err));
    return open_samples(source, &h, err);
}

const iso_volume_format iso_volume_format_nifti = {
    .name = "nifti",
    .title = "NIfTI-1, NIfTI-2 and Analyze 7.5",
    .summary = "one file or .hdr with .img, either packed by gzip or not, plane by plane",
    .suffixes = ".nii .nii.gz .hdr .img",
    .starts = "348 or 540 as its first number",
    .unpacks = true,
    .probe = starts_like_nifti,
    .probe_path = is_image_of_pair,
    .open = open_nifti,
};
