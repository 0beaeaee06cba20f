/* SPDX-License-Identifier: MIT */
/* vti_open.c - VTK's XML image data (.vti) and rectilinear grids (.vtr, rectilinear.h): one piece; its samples appended
 * raw or in base64, inline in base64 or as text; packed by zlib, LZ4 or LZMA, or not. Samples that are appended raw and
 * not packed are read plane by plane, others at once. */
#define _GNU_SOURCE
#include <errno.h>
#include <lz4.h>
#include <lzma.h>
#include <stdlib.h>
#include <string.h>

#include "base/file.h"
#include "base/words.h"
#include "volume/reader.h"
#include "volume/rectilinear.h"

enum { HEAD_BYTES = 1 << 16, WORD_BYTES = 256 };

/* Unpacks a block into at most *given bytes, and returns their number there; false: it is damaged. */
typedef bool unpack_block(const unsigned char *packed, size_t size, unsigned char *out, size_t *given);

static bool unpack_zlib(const unsigned char *packed, size_t size, unsigned char *out, size_t *given)
{
    uLongf bytes = (uLongf)*given;
    const bool well = uncompress(out, &bytes, packed, (uLong)size) == Z_OK;
    *given = (size_t)bytes;
    return well;
}

static bool unpack_lz4(const unsigned char *packed, size_t size, unsigned char *out, size_t *given)
{
    const int most = *given < LZ4_MAX_INPUT_SIZE ? (int)*given : LZ4_MAX_INPUT_SIZE;
    const int bytes = size < LZ4_MAX_INPUT_SIZE
                          ? LZ4_decompress_safe((const char *)packed, (char *)out, (int)size, most)
                          : -1;
    *given = bytes > 0 ? (size_t)bytes : 0;
    return bytes >= 0;
}

static bool unpack_lzma(const unsigned char *packed, size_t size, unsigned char *out, size_t *given)
{
    uint64_t memory = (uint64_t)256 << 20;
    size_t from = 0, to = 0;
    const bool well = lzma_stream_buffer_decode(&memory, 0, NULL, packed, &from, size, out, &to, *given) == LZMA_OK;
    *given = to;
    return well;
}

/* VTK's packers, and the most bytes that they pack into one. */
static const struct {
    const char *name;
    unpack_block *unpack;
    double most;
} packers[] = {{"vtkZLibDataCompressor", unpack_zlib, ISO_SOURCE_DEFLATE_MOST},
               {"vtkLZ4DataCompressor", unpack_lz4, 255},
               {"vtkLZMADataCompressor", unpack_lzma, 1 << 13}};
enum { PACKERS = sizeof packers / sizeof *packers };

typedef struct vti_array {
    const char *text; /* after the tag DataArray */
    char type[32], format[32];
    size_t offset;
} vti_array;

typedef struct vti {
    char *text; /* the file's beginning, or all of it */
    size_t size;
    const char *part; /* name of the array to read; NULL: the scalars */
    vti_array values;
    const char *appended; /* after the _ of AppendedData */
    char encoding[32];
    iso_rectilinear coordinates;
    long extent[6];
    double origin[3], spacing[3], direction[9]; /* rows of a matrix whose columns are the axes' directions */
    size_t length_bytes;
    bool big_endian, packed, of_cells;
    size_t packer; /* row of packers, if packed */
    iso_extra_axes axes;
} vti;

/* Reads the file's beginning, or all of it if the first samples are not appended. */
static iso_status read_text(const char *path, vti *v, iso_error *err)
{
    FILE *f = fopen(path, "rb");
    v->text = f ? calloc(1, HEAD_BYTES + 1) : NULL;
    v->size = v->text ? fread(v->text, 1, HEAD_BYTES, f) : 0;
    const int cause = errno;
    const iso_status status = f ? iso_source_check_read(f, path, ISO_OK, err) : ISO_OK;
    if (f)
        fclose(f);
    errno = cause;
    if (!v->text)
        return iso_fail(err, iso_errno_status(), "%s: cannot be opened: %s", path, strerror(errno));
    if (status != ISO_OK)
        return status;
    if (strstr(v->text, "<AppendedData"))
        return ISO_OK;
    free(v->text);
    v->text = NULL;
    return iso_file_read(path, &v->text, &v->size, err);
}

/* Returns the array of that name; without a name, the one that the section names as its scalars, or its first. */
static const char *find_array(const char *section, const char *part)
{
    char wanted[WORD_BYTES], name[WORD_BYTES];
    const char *first = strstr(section, "<DataArray"), *end = strstr(section + 1, "Data>");
    iso_reader_attribute(section, "Scalars", wanted, sizeof wanted);
    if (part)
        snprintf(wanted, sizeof wanted, "%s", part);
    for (const char *at = first; *wanted && at && (!end || at < end); at = strstr(at + 1, "<DataArray"))
        if (iso_reader_attribute(at, "Name", name, sizeof name) && strcmp(name, wanted) == 0)
            return at;
    return part ? NULL : first;
}

static iso_status refuse_part(const vti *v, const char *image, const char *path, iso_error *err)
{
    char list[400] = "", name[WORD_BYTES];
    for (const char *at = image; (at = strstr(at, "<DataArray")); ++at)
        if (iso_reader_attribute(at, "Name", name, sizeof name))
            iso_words_append(list, sizeof list, "%s%s", *list ? ", " : "", name);
    return iso_fail(err, ISO_E_USAGE, "%s: has no array \"%s\", FILE:ARRAY must be one of: %s", path, v->part, list);
}

/* Reads the components. Three or four bytes count as colors, as VTK maps them. */
static void take_channels(vti *v, const char *array, size_t count)
{
    char type[16], key[32];
    iso_reader_attribute(array, "type", type, sizeof type);
    v->axes.channel = (iso_extra_axis){.count = count, .inside = true, .stride = 1};
    v->axes.is_color = strcmp(type, "UInt8") == 0 && (count == 3 || count == 4);
    for (size_t c = 0; c < count && c < ISO_NAMED_CHANNELS; ++c) {
        snprintf(key, sizeof key, "ComponentName%zu", c);
        iso_reader_attribute(array, key, v->axes.channel_name[c], sizeof v->axes.channel_name[c]);
    }
}

static iso_status take_packer(const char *file, const char *path, vti *v, iso_error *err)
{
    char word[WORD_BYTES];
    v->packed = iso_reader_attribute(file, "compressor", word, sizeof word);
    while (v->packed && v->packer < PACKERS && strcmp(word, packers[v->packer].name) != 0)
        ++v->packer;
    return v->packer < PACKERS
               ? ISO_OK
               : iso_fail(err, ISO_E_FORMAT, "%s: packed by %s, must be VTK's ZLib, LZ4 or LZMA", path, word);
}

/* Takes the extent of the samples: of the whole, or of a piece of a .pvti. */
static iso_status take_extent(const char *image, const char *tag, bool is_piece, const char *path, vti *v,
                              iso_error *err)
{
    char word[WORD_BYTES], piece[WORD_BYTES];
    const bool has_own = iso_reader_attribute(tag, "Extent", piece, sizeof piece);
    if (!iso_reader_attribute(image, "WholeExtent", word, sizeof word))
        *word = 0;
    if (has_own && strcmp(piece, word) != 0 && !is_piece)
        return iso_fail(err, ISO_E_FORMAT, "%s: its first piece is not the whole, which is not read", path);
    if (sscanf(has_own && is_piece ? piece : word, "%ld %ld %ld %ld %ld %ld", &v->extent[0], &v->extent[1],
               &v->extent[2], &v->extent[3], &v->extent[4], &v->extent[5]) != 6)
        return iso_fail(err, ISO_E_FORMAT, "%s: no WholeExtent of six numbers", path);
    return ISO_OK;
}

static vti_array take_array(const char *tag)
{
    vti_array a = {.text = strchr(tag, '>')};
    char word[WORD_BYTES];
    iso_reader_attribute(tag, "type", a.type, sizeof a.type);
    iso_reader_attribute(tag, "format", a.format, sizeof a.format);
    if (iso_reader_attribute(tag, "offset", word, sizeof word))
        a.offset = strtoull(word, NULL, 10);
    return a;
}

static iso_status parse(vti *v, const char *path, bool is_piece, iso_error *err)
{
    char word[WORD_BYTES];
    double list[9];
    const char *file = strstr(v->text, "<VTKFile"), *image = strstr(v->text, "<ImageData"),
               *coordinates = strstr(v->text, "<Coordinates");
    image = image ? image : strstr(v->text, "<RectilinearGrid");
    const char *data = image ? strstr(image, "<PointData") : NULL, *tag = strstr(v->text, "<Piece");
    const char *array = data ? find_array(data, v->part) : NULL;
    const char *cells = image ? strstr(image, "<CellData") : NULL;
    if (cells && (!array || array > cells)) {
        array = find_array(cells, v->part);
        v->of_cells = true;
    }
    array = coordinates && array > coordinates ? NULL : array;
    if (image && v->part && !array)
        return refuse_part(v, image, path, err);
    if (!file || !image || !tag || !array)
        return iso_fail(err, ISO_E_FORMAT, "%s: truncated, or no grid with an array in it", path);
    NEED(take_extent(image, tag, is_piece, path, v, err));
    NEED(take_packer(file, path, v, err));
    for (int a = 0; a < 9; ++a)
        v->direction[a] = a % 4 == 0;
    for (int a = 0; a < 3; ++a)
        v->spacing[a] = 1;
    if (iso_reader_attribute(image, "Origin", word, sizeof word))
        iso_reader_numbers(word, v->origin, 3);
    if (iso_reader_attribute(image, "Spacing", word, sizeof word))
        iso_reader_numbers(word, v->spacing, 3);
    if (iso_reader_attribute(image, "Direction", word, sizeof word) && iso_reader_numbers(word, list, 9) == 9)
        memcpy(v->direction, list, sizeof list);
    iso_reader_attribute(file, "byte_order", word, sizeof word);
    v->big_endian = strcmp(word, "BigEndian") == 0;
    iso_reader_attribute(file, "header_type", word, sizeof word);
    v->length_bytes = strcmp(word, "UInt64") == 0 ? 8 : 4;
    if (iso_reader_attribute(array, "NumberOfComponents", word, sizeof word) && atoi(word) > 1)
        take_channels(v, array, (size_t)atoi(word));
    v->values = take_array(array);
    const char *appended = strstr(v->text, "<AppendedData");
    iso_reader_attribute(appended, "encoding", v->encoding, sizeof v->encoding);
    const char *end = appended ? strchr(appended, '>') : NULL, *mark = end ? strchr(end, '_') : NULL;
    v->appended = mark ? mark + 1 : NULL;
    return ISO_OK;
}

/* Returns the points along an axis; 0: none, or too many. */
static size_t points_along(const vti *v, int axis)
{
    const double points = (double)v->extent[2 * axis + 1] - (double)v->extent[2 * axis] + 1;
    return points > 0 && points < 0x1p53 ? (size_t)points : 0;
}

static iso_status take_geometry(vti *v, iso_volume_source *source, iso_error *err)
{
    iso_geometry *g = &source->header.geometry;
    size_t size[3];
    const size_t points[3] = {points_along(v, 0), points_along(v, 1), points_along(v, 2)};
    double mm, first[3], spacing[3];
    NEED(iso_source_unit(source, NULL, "mm", &mm, err));
    if (v->coordinates.at[0]) {
        NEED(iso_rectilinear_measure(&v->coordinates, source, points, v->origin, v->spacing, err));
        for (int a = 0; a < 3; ++a) /* of the first sample, not of index 0 */
            v->origin[a] -= (double)v->extent[2 * a] * v->spacing[a];
    }
    memcpy(spacing, v->spacing, sizeof spacing); /* 1 if the file gives none, as VTK has it */
    NEED(iso_source_take_spacing(source, spacing, err));
    for (int a = 0; a < 3; ++a) {
        size[a] = points[a] - (v->of_cells && points[a] > 0);
        first[a] = (double)v->extent[2 * a] - (v->of_cells ? 0 : 0.5);
    }
    *g = iso_geometry_axis_aligned(size, (double[]){1, 1, 1});
    for (int a = 0; a < 3; ++a)
        for (int r = 0; r < 3; ++r)
            g->index_to_world.m[r][a] = mm * v->direction[3 * r + a] * spacing[a];
    g->origin_mm = iso_add(iso_scale(iso_v3(v->origin[0], v->origin[1], v->origin[2]), mm),
                           iso_mul(g->index_to_world, iso_v3(first[0], first[1], first[2])));
    return iso_source_check_geometry(source, err);
}

/* ---- samples ---- */

/* Decodes base64, in several runs that may each end with =. NULL: no memory. */
static unsigned char *decode_base64(const char *text, size_t *size)
{
    static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    unsigned char value[256];
    memset(value, 255, sizeof value);
    for (int i = 0; i < 64; ++i)
        value[(unsigned char)digits[i]] = (unsigned char)i;
    unsigned char *out = malloc(strlen(text) / 4 * 3 + 4);
    uint32_t group = 0;
    int count = 0, pads = 0;
    *size = 0;
    for (; out && *text && *text != '<'; ++text) {
        const bool pad = *text == '=';
        if (!pad && value[(unsigned char)*text] == 255)
            continue;
        group = group << 6 | (pad ? 0 : value[(unsigned char)*text]);
        pads += pad;
        if (++count < 4)
            continue;
        for (int b = 0; b < 3 - pads; ++b)
            out[(*size)++] = (unsigned char)(group >> (16 - 8 * b));
        group = 0, count = pads = 0;
    }
    return out;
}

static uint64_t number_at(const vti *v, const unsigned char *at)
{
    uint64_t value = 0;
    for (size_t b = 0; b < v->length_bytes; ++b)
        value = value << 8 | at[v->big_endian ? b : v->length_bytes - 1 - b];
    return value;
}

/* Unpacks [blocks][bytes per block][bytes of the last one, 0: the same][packed bytes of each], then the blocks. */
static bool unpack(const vti *v, const unsigned char *data, size_t size, unsigned char *out, size_t bytes)
{
    const size_t n = v->length_bytes;
    const uint64_t blocks = size >= 3 * n ? number_at(v, data) : 0;
    if (blocks == 0 || blocks > (size - 3 * n) / n)
        return false;
    size_t at = (3 + (size_t)blocks) * n, done = 0;
    for (uint64_t i = 0; i < blocks; ++i) {
        const uint64_t packed = number_at(v, data + (3 + i) * n);
        size_t room = bytes - done;
        if (packed > size - at || !packers[v->packer].unpack(data + at, (size_t)packed, out + done, &room))
            return false;
        done += room;
        at += (size_t)packed;
    }
    return done == bytes;
}

/* Takes `size` bytes that start with their length, or with the lengths of blocks. */
static iso_status take_bytes(const vti *v, iso_volume_source *source, const unsigned char *data, size_t size,
                             iso_error *err)
{
    const size_t bytes = iso_source_bytes(source), n = v->length_bytes;
    NEED(iso_source_check_packed(source, source->path, (double)size, v->packed ? packers[v->packer].most : 1, err));
    source->preloaded = malloc(bytes);
    NEED_MEMORY(source->preloaded, err, "%s: no memory for %zu bytes of samples", source->path, bytes);
    const bool well = v->packed ? unpack(v, data, size, (unsigned char *)source->preloaded, bytes)
                                : size >= n + bytes && number_at(v, data) == bytes;
    if (!well)
        return iso_fail(err, ISO_E_FORMAT,
                        "%s: truncated or damaged: its array is not of the %zu bytes that the sizes need", source->path,
                        bytes);
    if (!v->packed)
        memcpy(source->preloaded, data + n, bytes);
    return ISO_OK;
}

static iso_status take_base64(const vti *v, iso_volume_source *source, const char *text, iso_error *err)
{
    size_t size;
    FREED unsigned char *data = decode_base64(text, &size);
    return data ? take_bytes(v, source, data, size, err)
                : iso_fail(err, ISO_E_MEMORY, "%s: out of memory", source->path);
}

static iso_status take_text(const vti *v, iso_volume_source *source, iso_error *err)
{
    /* Up to the next tag, which may follow the last number without a space. */
    const char *text = v->values.text + 1;
    const size_t rest = v->size - (size_t)(text - v->text);
    const char *tag = memchr(text, '<', rest);
    FILE *f = fmemopen((void *)(size_t)text, tag > text ? (size_t)(tag - text) : rest, "r");
    const iso_status status = f ? iso_source_take_text(source, f, (iso_text_layout){0}, err)
                                : iso_fail(err, ISO_E_MEMORY, "%s: out of memory", source->path);
    if (f)
        fclose(f);
    return status;
}

static iso_status take_appended(const vti *v, iso_volume_source *source, iso_error *err)
{
    const size_t at = (size_t)(v->appended - v->text) + v->values.offset;
    if (strcmp(v->encoding, "raw") == 0 && !v->packed)
        return iso_source_take_part(source, source->path, at + v->length_bytes, err);
    FREED char *all = NULL;
    size_t size;
    NEED(iso_file_read(source->path, &all, &size, err));
    if (at >= size)
        return iso_fail(err, ISO_E_FORMAT, "%s: truncated before its samples at byte %zu", source->path, at);
    return strcmp(v->encoding, "raw") == 0 ? take_bytes(v, source, (unsigned char *)all + at, size - at, err)
                                           : take_base64(v, source, all + at, err);
}

static iso_status take_samples(const vti *v, iso_volume_source *source, iso_error *err)
{
    source->swap_bytes = v->big_endian == (__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__);
    if (strcmp(v->values.format, "appended") == 0 && v->appended)
        return take_appended(v, source, err);
    if (strcmp(v->values.format, "binary") == 0 && v->values.text)
        return take_base64(v, source, v->values.text + 1, err);
    source->swap_bytes = false;
    if (strcmp(v->values.format, "ascii") == 0 && v->values.text)
        return take_text(v, source, err);
    return iso_fail(err, ISO_E_FORMAT, "%s: truncated, or an array of format \"%s\"", source->path, v->values.format);
}

/* Reads the coordinates of an axis, as the samples of a row. */
static iso_status read_coordinates(vti *v, const iso_volume_source *source, const char *tag, int axis, iso_error *err)
{
    const size_t count = points_along(v, axis);
    iso_volume_source row = {.path = source->path,
                             .unpacked.path = source->unpacked.path,
                             .choice = {.inside_count = 1, .volume_count = 1}};
    vti own = *v;
    own.values = take_array(tag);
    row.header.geometry = iso_geometry_axis_aligned((size_t[]){count, 1, 1}, (double[]){1, 1, 1});
    iso_status status = iso_reader_take_type(&row, own.values.type, strlen(own.values.type))
                            ? ISO_OK
                            : iso_fail(err, ISO_E_FORMAT, "%s: type \"%s\" of coordinates", source->path,
                                       own.values.type);
    TRY(status, iso_geometry_check(&row.header.geometry, source->path, err));
    TRY(status, take_samples(&own, &row, err));
    TRY(status, iso_rectilinear_take(&v->coordinates, axis, &row, err));
    if (row.file)
        fclose(row.file);
    free(row.preloaded);
    return status;
}

/* Reads the coordinates of a rectilinear grid: three arrays. */
static iso_status take_coordinates(vti *v, const iso_volume_source *source, iso_error *err)
{
    const char *tag = strstr(v->text, "<Coordinates");
    for (int a = 0; a < 3 && tag; ++a) {
        tag = strstr(tag + 1, "<DataArray");
        NEED(tag ? read_coordinates(v, source, tag, a, err)
                 : iso_fail(err, ISO_E_FORMAT, "%s: truncated, or without the coordinates of its %c axis", source->path,
                            'x' + a));
    }
    return ISO_OK;
}

static void release(vti *v)
{
    iso_rectilinear_destroy(&v->coordinates);
    free(v->text);
}

static iso_status open_vti(iso_volume_source *source, iso_error *err)
{
    ENDED_BY(release) vti v = {0};
    NEED(read_text(source->path, &v, err));
    v.part = source->part;
    NEED(parse(&v, source->path, source->hints.is_piece, err));
    NEED(iso_reader_need_type(source, v.values.type, err));
    NEED(take_coordinates(&v, source, err));
    NEED(take_geometry(&v, source, err));
    NEED(iso_source_choose(source, &v.axes, err));
    NEED(take_samples(&v, source, err));
    return iso_rectilinear_resample(&v.coordinates, source, err);
}

static bool starts_like_vti(const unsigned char *head, size_t size)
{
    return memmem(head, size, "<VTKFile", 8) &&
           (memmem(head, size, "\"ImageData\"", 11) || memmem(head, size, "\"RectilinearGrid\"", 17));
}

const iso_volume_format iso_volume_format_vti = {
    .name = "vti",
    .title = "VTK XML",
    .summary =
        "image data and rectilinear grids of one piece: appended raw plane by plane, base64, text and packed by zlib, "
        "LZ4 or LZMA at once",
    .suffixes = ".vti .vtr .pvd .series .vti.series",
    .starts = "\"<VTKFile\"",
    .takes_part = true,
    .probe = starts_like_vti,
    .open = open_vti,
};
