/* nifti_open.c - NIfTI-1 headers. The header is read and checked here, since
 * libnifti prints and trusts what it reads; its part is the affine of a qform. */
#define _GNU_SOURCE
#include <errno.h>
#include <math.h>
#include <nifti1_io.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "volume/stream_kernel.h"

bool iso_nifti_starts_like(const unsigned char *head, size_t size)
{
    int32_t first = 0;
    if (size >= 4)
        memcpy(&first, head, 4);
    return first == 348 || __builtin_bswap32((uint32_t)first) == 348;
}

static bool our_type(int datatype, iso_type *type)
{
    switch (datatype) {
    case NIFTI_TYPE_INT8: *type = ISO_I8; return true;
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

static double millimetres(int units)
{
    switch (XYZT_TO_SPACE(units)) {
    case NIFTI_UNITS_METER: return 1000;
    case NIFTI_UNITS_MICRON: return 1e-3;
    default: return 1;
    }
}

/* The affine of voxel centres; false when the file gives only spacings. */
static bool centre_affine(const nifti_1_header *h, double m[3][4])
{
    if (h->sform_code > 0) {
        for (int c = 0; c < 4; ++c) {
            m[0][c] = h->srow_x[c];
            m[1][c] = h->srow_y[c];
            m[2][c] = h->srow_z[c];
        }
        return true;
    }
    if (h->qform_code <= 0)
        return false;
    mat44 q = nifti_quatern_to_mat44(h->quatern_b, h->quatern_c, h->quatern_d, h->qoffset_x, h->qoffset_y, h->qoffset_z,
                                     h->pixdim[1], h->pixdim[2], h->pixdim[3], h->pixdim[0] < 0 ? -1.0f : 1.0f);
    for (int r = 0; r < 3; ++r)
        for (int c = 0; c < 4; ++c)
            m[r][c] = q.m[r][c];
    return true;
}

static void read_geometry(const nifti_1_header *h, iso_volume *header)
{
    iso_geometry *g = &header->geometry;
    double mm = millimetres(h->xyzt_units), m[3][4];
    double spacing[3] = {h->pixdim[1] * mm, h->pixdim[2] * mm, h->pixdim[3] * mm};
    size_t size[3] = {(size_t)h->dim[1], (size_t)h->dim[2], (size_t)h->dim[3]};
    *g = iso_geometry_axis_aligned(size, spacing);
    header->notes.world_is_ras = centre_affine(h, m);
    if (!header->notes.world_is_ras)
        return;
    for (int r = 0; r < 3; ++r)
        for (int c = 0; c < 3; ++c)
            g->index_to_world.m[r][c] = m[r][c] * mm;
    g->origin_mm = iso_sub(iso_v3(m[0][3] * mm, m[1][3] * mm, m[2][3] * mm),
                           iso_mul(g->index_to_world, iso_v3(0.5, 0.5, 0.5)));
}

static iso_status check_header(const nifti_1_header *h, const char *path, iso_error *err)
{
    bool one_file = memcmp(h->magic, "n+1", 4) == 0, two_files = memcmp(h->magic, "ni1", 4) == 0;
    if (!one_file && !two_files)
        return iso_fail(err, ISO_E_FORMAT, "%s: the magic at byte 344 is \"%.3s\", NIfTI-1 has \"n+1\" or \"ni1\"", path, h->magic);
    int dim = h->dim[0];
    if (dim < 1 || dim > 7)
        return iso_fail(err, ISO_E_FORMAT, "%s: %d axes, must be 1 to 7", path, dim);
    for (int a = 1; a <= dim; ++a)
        if (h->dim[a] < 1)
            return iso_fail(err, ISO_E_RANGE, "%s: axis %d has size %d, must be at least 1", path, a, h->dim[a]);
    while (dim > 3 && h->dim[dim] == 1)
        --dim;
    if (dim != 3)
        return iso_fail(err, ISO_E_FORMAT, "%s: %d axes, a scalar volume has 3", path, dim);
    if (one_file && !(h->vox_offset >= 352 && h->vox_offset <= 1e9f))
        return iso_fail(err, ISO_E_RANGE, "%s: samples start at byte %g, must be 352 to 1e9", path, (double)h->vox_offset);
    if (two_files && !(h->vox_offset >= 0 && h->vox_offset <= 1e9f))
        return iso_fail(err, ISO_E_RANGE, "%s: samples start at byte %g, must be 0 to 1e9", path, (double)h->vox_offset);
    return ISO_OK;
}

/* NAME.hdr and NAME.img, either with .gz. */
static char *image_path(const char *path)
{
    const char *hdr = NULL;
    for (const char *at = path; (at = strstr(at, ".hdr")); ++at)
        hdr = at;
    char *image = NULL;
    if (!hdr || asprintf(&image, "%.*s.img%s", (int)(hdr - path), path, hdr + 4) < 0)
        return NULL;
    return image;
}

/* The file of the samples, positioned at the first one. */
static iso_status open_samples(iso_volume_source *source, const nifti_1_header *h, iso_error *err)
{
    char *image = memcmp(h->magic, "n+1", 4) == 0 ? strdup(source->path) : image_path(source->path);
    if (!image)
        return iso_fail(err, ISO_E_FORMAT, "%s: a header alone (\"ni1\") is named .hdr, its samples .img", source->path);
    struct stat st;
    iso_status status = ISO_OK;
    source->gz = stat(image, &st) == 0 ? gzopen(image, "rb") : NULL;
    size_t offset = (size_t)h->vox_offset;
    if (source->gz)
        gzbuffer(source->gz, 1 << 18); /* before the first look into it */
    if (!source->gz) {
        status = iso_fail(err, ISO_E_IO, "%s: its samples, %s, cannot be opened: %s", source->path, image, strerror(errno));
    } else if (gzdirect(source->gz)) {
        gzclose(source->gz);
        source->gz = NULL;
        source->file = fopen(image, "rb");
        if (!source->file || fseeko(source->file, (off_t)offset, SEEK_SET) != 0)
            status = iso_fail(err, ISO_E_IO, "%s: cannot be read: %s", image, strerror(errno));
        else
            status = iso_source_check_bytes(source, (double)st.st_size - (double)offset, err);
    } else if ((double)iso_source_bytes(source) > 1032.0 * (double)st.st_size) {
        status = iso_fail(err, ISO_E_FORMAT, "%s: truncated: %lld compressed bytes cannot hold the %zu that the sizes need",
                          image, (long long)st.st_size, iso_source_bytes(source));
    } else if (gzseek(source->gz, (z_off_t)offset, SEEK_SET) < 0) {
        status = iso_fail(err, ISO_E_FORMAT, "%s: truncated before the samples at byte %zu", image, offset);
    }
    free(image);
    return status;
}

iso_status iso_nifti_open(iso_volume_source *source, iso_error *err)
{
    nifti_1_header h;
    gzFile gz = gzopen(source->path, "rb");
    int n = gz ? gzread(gz, &h, sizeof h) : -1;
    if (gz)
        gzclose(gz);
    if (n != (int)sizeof h)
        return iso_fail(err, ISO_E_FORMAT, "%s: truncated: %d bytes, a NIfTI-1 header has %zu", source->path, n > 0 ? n : 0, sizeof h);
    source->swap_bytes = h.sizeof_hdr != 348;
    if (source->swap_bytes)
        swap_nifti_header(&h, 1);
    iso_status status = check_header(&h, source->path, err);
    if (status != ISO_OK)
        return status;
    if (!our_type(h.datatype, &source->header.type))
        return iso_fail(err, ISO_E_FORMAT, "%s: data type %d (%s), must be an integer of 8, 16 or 32 bits, float or double",
                        source->path, h.datatype, nifti_datatype_string(h.datatype));
    read_geometry(&h, &source->header);
    if (isfinite(h.scl_slope) && h.scl_slope != 0 && isfinite(h.scl_inter)) {
        source->header.notes.scale_slope = h.scl_slope;
        source->header.notes.scale_intercept = h.scl_inter;
    }
    status = iso_geometry_check(&source->header.geometry, source->path, err);
    return status == ISO_OK ? open_samples(source, &h, err) : status;
}
