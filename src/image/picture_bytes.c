/* SPDX-License-Identifier: MIT */
#include "image/picture_bytes.h"

#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "image/exr_codec.h"

/* First bytes of files, the more certain ones first. */
typedef struct signature {
    size_t at, length;
    const char *bytes, *name;
    iso_picture_kind kind;
} signature;

#define AT(offset, bytes, name) {offset, sizeof bytes - 1, bytes, name, ISO_PICTURE_OTHER}
static const signature signatures[] = {
    {0, 4, "\x76\x2f\x31\x01", "an OpenEXR picture", ISO_PICTURE_EXR},
    {0, 8, "\x89PNG\r\n\x1a\n", "a PNG picture", ISO_PICTURE_PNG},
    {0, 2, "P6", "a PPM picture", ISO_PICTURE_PPM},
    AT(0, "\xff\xd8\xff", "a JPEG picture"),
    AT(0, "\xff\x4f\xff\x51", "a JPEG 2000 picture"),
    AT(4, "jP  \r\n", "a JPEG 2000 picture"),
    AT(4, "JXL \r\n", "a JPEG XL picture"),
    AT(0, "\xff\x0a", "a JPEG XL picture"),
    AT(4, "ftypavif", "an AVIF picture"),
    AT(4, "ftyphei", "a HEIF picture"),
    AT(4, "ftypmif", "a HEIF picture"),
    AT(4, "ftyp", "an MP4 video"),
    AT(0, "II*\0", "a TIFF picture"),
    AT(0, "MM\0*", "a TIFF picture"),
    AT(0, "II+\0", "a BigTIFF picture"),
    AT(0, "MM\0+", "a BigTIFF picture"),
    AT(0, "#?RADIANCE", "a Radiance HDR picture (RGBE)"),
    AT(0, "#?RGBE", "a Radiance HDR picture (RGBE)"),
    AT(8, "WEBP", "a WebP picture"),
    AT(0, "GIF8", "a GIF picture"),
    AT(0, "8BPS", "a Photoshop picture"),
    AT(0, "SDPX", "a DPX picture"),
    AT(0, "XPDS", "a DPX picture"),
    AT(0, "PF\n", "a PFM picture"),
    AT(0, "Pf\n", "a PFM picture"),
    AT(0, "P3", "a PPM picture in text"),
    AT(0, "P5", "a PGM picture"),
    AT(0, "P7\n", "a PAM picture"),
    AT(0, "%PDF", "a PDF document"),
    AT(0, "%!PS", "a PostScript document"),
    AT(0, "NRRD000", "a volume file (NRRD)"),
    AT(344, "n+1", "a volume file (NIfTI)"),
    AT(4, "n+2", "a volume file (NIfTI-2)"),
    AT(128, "DICM", "a DICOM file"),
    AT(208, "MAP ", "a volume file (MRC)"),
    AT(0, " BDV", "a volume file (OpenVDB)"),
    AT(0, "NanoVDB", "a volume file (NanoVDB)"),
    AT(0, "\x89HDF\r\n\x1a\n", "an HDF5 file"),
    AT(0, "CDF\x01", "a netCDF file"),
    AT(0, "CDF\x02", "a netCDF file"),
    AT(0, "\x93NUMPY", "a NumPy array"),
    AT(0, "ObjectType", "a volume file (MetaImage)"),
    AT(0, "# vtk", "a volume file (VTK)"),
    AT(0, "<VTKFile", "a volume file (VTK)"),
    AT(0, "<svg", "an SVG drawing"),
    AT(0, "<?xml", "an XML file"),
    AT(0, "{", "a JSON file"),
    AT(0, "\x1f\x8b", "a file packed by gzip"),
    AT(0, "\xfd" "7zXZ", "a file packed by xz"),
    AT(0, "\x28\xb5\x2f\xfd", "a file packed by zstd"),
    AT(0, "PK\x03\x04", "a ZIP archive"),
    AT(0, "BM", "a BMP picture"),
};
#undef AT

static const signature *find_signature(const char *data, size_t size)
{
    for (size_t i = 0; i < sizeof signatures / sizeof signatures[0]; ++i) {
        const signature *s = &signatures[i];
        if (size >= s->at + s->length && memcmp(data + s->at, s->bytes, s->length) == 0)
            return s;
    }
    return NULL;
}

static iso_picture_kind picture_kind_of(const char *data, size_t size)
{
    const signature *s = find_signature(data, size);
    return s ? s->kind : ISO_PICTURE_OTHER;
}

/* Reports bytes of another kind, with its name, as ISO_E_FORMAT. wanted: the kinds that are read. */
static iso_status picture_refuse(const char *path, const char *data, size_t size, const char *wanted, iso_error *err)
{
    const signature *s = find_signature(data, size);
    if (size == 0)
        return iso_fail(err, ISO_E_FORMAT, "%s: is empty, must be %s", path, wanted);
    return s ? iso_fail(err, ISO_E_FORMAT, "%s: is %s, must be %s; convert it", path, s->name, wanted)
             : iso_fail(err, ISO_E_FORMAT, "%s: is no picture of a known kind, must be %s", path, wanted);
}

iso_status iso_picture_read_file(const char *path, char **data, size_t *size, iso_error *err)
{
    *data = NULL;
    return iso_path_is_dir(path) ? iso_fail(err, ISO_E_IO, "%s: is a folder, must be a picture's file", path)
                                 : iso_file_read(path, data, size, err);
}

iso_status iso_picture_read_kind(const char *path, iso_picture_kind kind, const char *wanted, char **data, size_t *size,
                                 iso_error *err)
{
    iso_status status = iso_picture_read_file(path, data, size, err);
    if (status != ISO_OK || picture_kind_of(*data, *size) == kind)
        return status;
    status = picture_refuse(path, *data, *size, wanted, err);
    free(*data);
    *data = NULL;
    return status;
}

iso_status iso_image_load(const char *path, iso_image_choice *choice, iso_image *image, iso_error *err)
{
    FREED char *data = NULL;
    size_t size;
    bool has_alpha = false;
    *image = (iso_image){0};
    iso_status status = iso_picture_read_file(path, &data, &size, err);
    if (status != ISO_OK)
        return status;
    const iso_picture_kind kind = picture_kind_of(data, size);
    switch (kind) {
    case ISO_PICTURE_EXR: status = iso_exr_decode(path, data, size, choice, image, err); break;
    case ISO_PICTURE_PNG: status = iso_png_decode(path, data, size, &has_alpha, image, err); break;
    case ISO_PICTURE_PPM: status = iso_ppm_decode(path, data, size, image, err); break;
    case ISO_PICTURE_OTHER: status = picture_refuse(path, data, size, "OpenEXR, PNG or PPM of 16 bits", err);
    }
    if (choice && kind != ISO_PICTURE_EXR)
        choice->has_alpha = has_alpha;
    return status;
}
