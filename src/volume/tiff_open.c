/* SPDX-License-Identifier: MIT */
/* tiff_open.c - TIFF and BigTIFF, a slice a page, by libtiff. TIFF itself does not say how far slices are apart:
 * ImageJ's description and OME's XML do, and nothing else is trusted. */
#define _GNU_SOURCE
#include <assert.h>
#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>
#include <tiffio.h>
#include <unistd.h>

#include "volume/stream_kernel.h"

typedef struct tiff_reader {
    TIFF *tiff;
    int fd;
    bool is_unread; /* a call on the file failed: what libtiff says then is about missing bytes, or nothing */
    uint64_t *page; /* offsets of the directories */
    size_t page_count, next;
    uint16_t odd_bits;  /* of samples that are no whole bytes; 0: they are */
    uint16_t planes;    /* of pages that have their components in planes; 1: of others */
    size_t first, step; /* of the chosen frame and channel: the first page, and from one to the next */
} tiff_reader;

typedef struct tiff_page {
    uint32_t width, height, depth;
    uint16_t bits, samples, format, planar, compression;
    bool is_color;
} tiff_page;

/* Fields of a description. */
typedef struct tiff_notes {
    bool is_imagej, is_ome;
    size_t slices, channels, frames; /* 0: missing */
    char order[8];                   /* of pages: "ZCT": z first */
    double frame_step;
    char frame_unit[16];
    char channel_name[ISO_NAMED_CHANNELS][ISO_CHANNEL_NAME_BYTES];
    double spacing[3]; /* 0: not said */
    char unit[3][32];
} tiff_notes;

/* True for a TIFF header that is not the preamble of a DICOM file (PS3.10 7.1). */
static bool starts_like_tiff(const unsigned char *head, size_t size)
{
    const bool is_dicom = size >= 132 && memcmp(head + 128, "DICM", 4) == 0;
    return size >= 4 && !is_dicom &&
           (memcmp(head, "II*\0", 4) == 0 || memcmp(head, "MM\0*", 4) == 0 || memcmp(head, "II+\0", 4) == 0 ||
            memcmp(head, "MM\0+", 4) == 0);
}

/* ---- the file, as libtiff asks for it ---- */

static tmsize_t read_bytes(thandle_t user, void *to, tmsize_t count)
{
    tiff_reader *r = user;
    tmsize_t done = 0;
    while (done < count) {
        const ssize_t n = read(r->fd, (char *)to + done, (size_t)(count - done));
        if (n == 0)
            break;
        r->is_unread = r->is_unread || (n < 0 && errno != EINTR);
        if (n < 0 && errno != EINTR)
            return -1;
        done += n > 0 ? n : 0;
    }
    return done;
}

static tmsize_t write_nothing(thandle_t user, void *from, tmsize_t count)
{
    (void)user;
    (void)from;
    (void)count;
    return -1;
}

static toff_t seek_to(thandle_t user, toff_t offset, int from)
{
    tiff_reader *r = user;
    const off_t at = lseek(r->fd, (off_t)offset, from);
    r->is_unread = r->is_unread || at < 0;
    return (toff_t)at;
}

static int close_nothing(thandle_t user)
{
    (void)user;
    return 0;
}

static toff_t size_of(thandle_t user)
{
    tiff_reader *r = user;
    struct stat st;
    if (fstat(r->fd, &st) == 0)
        return (toff_t)st.st_size;
    r->is_unread = true;
    return 0;
}

static iso_status check_read(const tiff_reader *r, const char *path, iso_status status, iso_error *err)
{
    return r->is_unread ? iso_fail(err, ISO_E_IO, "%s: cannot be read", path) : status;
}

/* ---- pages, and checks of all pages ---- */

static tiff_page read_page(TIFF *t)
{
    tiff_page p = {.depth = 1,
                   .bits = 1,
                   .samples = 1,
                   .format = SAMPLEFORMAT_UINT,
                   .planar = PLANARCONFIG_CONTIG,
                   .compression = COMPRESSION_NONE};
    uint16_t meaning = 0;
    TIFFGetField(t, TIFFTAG_IMAGEWIDTH, &p.width);
    TIFFGetField(t, TIFFTAG_IMAGELENGTH, &p.height);
    TIFFGetField(t, TIFFTAG_IMAGEDEPTH, &p.depth);
    TIFFGetFieldDefaulted(t, TIFFTAG_BITSPERSAMPLE, &p.bits);
    TIFFGetFieldDefaulted(t, TIFFTAG_SAMPLESPERPIXEL, &p.samples);
    TIFFGetFieldDefaulted(t, TIFFTAG_SAMPLEFORMAT, &p.format);
    TIFFGetFieldDefaulted(t, TIFFTAG_PLANARCONFIG, &p.planar);
    TIFFGetFieldDefaulted(t, TIFFTAG_COMPRESSION, &p.compression);
    TIFFGetFieldDefaulted(t, TIFFTAG_PHOTOMETRIC, &meaning);
    p.is_color = meaning == PHOTOMETRIC_RGB && (p.samples == 3 || p.samples == 4);
    return p;
}

/* Returns the largest number of sample bytes per byte of the file. PackBits stores 128 equal bytes in two, LZW up to
 * 4094 bytes in a word of 9 to 12 bits. zstd packs most of the others: a block of 128 kB of equal bytes into four. */
static double most_of(uint16_t compression)
{
    switch (compression) {
    case COMPRESSION_NONE: return 1;
    case COMPRESSION_PACKBITS: return 64;
    case COMPRESSION_LZW: return 4094;
    case COMPRESSION_DEFLATE:
    case COMPRESSION_ADOBE_DEFLATE: return ISO_SOURCE_DEFLATE_MOST;
    default: return 32768;
    }
}

/* True for gray samples of 1 to 15 bits that are no whole bytes, such as masks and those of 12-bit cameras. */
static bool has_odd_bits(const tiff_page *p)
{
    return p->format <= SAMPLEFORMAT_UINT && p->bits < 16 && p->bits % 8 != 0 && p->samples == 1;
}

static bool take_type(const tiff_page *p, iso_volume_source *source)
{
    static const struct {
        uint16_t format, bits;
        iso_type type;
    } types[] = {{SAMPLEFORMAT_UINT, 8, ISO_U8},     {SAMPLEFORMAT_UINT, 16, ISO_U16},
                 {SAMPLEFORMAT_UINT, 32, ISO_U32},   {SAMPLEFORMAT_INT, 8, ISO_I8},
                 {SAMPLEFORMAT_INT, 16, ISO_I16},    {SAMPLEFORMAT_INT, 32, ISO_I32},
                 {SAMPLEFORMAT_IEEEFP, 32, ISO_F32}, {SAMPLEFORMAT_IEEEFP, 64, ISO_F64}};
    const uint16_t format = p->format == SAMPLEFORMAT_VOID ? SAMPLEFORMAT_UINT : p->format;
    for (size_t i = 0; i < sizeof types / sizeof types[0]; ++i)
        if (types[i].format == format && types[i].bits == p->bits) {
            source->header.type = types[i].type;
            return true;
        }
    const iso_form form = format == SAMPLEFORMAT_IEEEFP && p->bits == 16 ? ISO_FORM_HALF
                          : format == SAMPLEFORMAT_INT && p->bits == 64  ? ISO_FORM_I64
                          : format == SAMPLEFORMAT_UINT && p->bits == 64 ? ISO_FORM_U64
                                                                         : ISO_FORM_TYPE;
    if (form)
        iso_source_set_form(source, form);
    if (form || !has_odd_bits(p))
        return form != ISO_FORM_TYPE;
    source->header.type = p->bits < 8 ? ISO_U8 : ISO_U16;
    return true;
}

/* ---- descriptions ---- */

/* Finds the text after `key` and its mark, up to one of `ends`; false if it is missing. */
static bool find_text(const char *description, const char *key, const char *ends, char *out, size_t size)
{
    const char *at = strstr(description, key);
    if (!at)
        return false;
    at += strlen(key);
    snprintf(out, size, "%.*s", (int)strcspn(at, ends), at);
    return true;
}

static double find_number(const char *description, const char *key, const char *ends)
{
    char text[64];
    return find_text(description, key, ends, text, sizeof text) ? strtod(text, NULL) : 0;
}

/* Reads lines "key=value". The sizes of pixels are in TIFF's resolution, in pixels per unit. */
static void read_imagej(TIFF *t, const char *description, tiff_notes *n)
{
    float x = 0, y = 0;
    n->is_imagej = true;
    n->slices = (size_t)find_number(description, "\nslices=", "\n");
    n->channels = (size_t)find_number(description, "\nchannels=", "\n");
    n->frames = (size_t)find_number(description, "\nframes=", "\n");
    if (n->slices == 0 && n->channels <= 1 && n->frames <= 1)
        n->slices = (size_t)find_number(description, "\nimages=", "\n");
    snprintf(n->order, sizeof n->order, "CZT");
    n->frame_step = find_number(description, "\nfinterval=", "\n");
    if (!find_text(description, "\ntunit=", "\n", n->frame_unit, sizeof n->frame_unit))
        snprintf(n->frame_unit, sizeof n->frame_unit, "s");
    n->spacing[2] = find_number(description, "\nspacing=", "\n");
    if (find_text(description, "\nunit=", "\n", n->unit[0], sizeof n->unit[0])) {
        memcpy(n->unit[1], n->unit[0], sizeof n->unit[0]);
        memcpy(n->unit[2], n->unit[0], sizeof n->unit[0]);
    }
    find_text(description, "\nyunit=", "\n", n->unit[1], sizeof n->unit[1]);
    find_text(description, "\nzunit=", "\n", n->unit[2], sizeof n->unit[2]);
    if (TIFFGetField(t, TIFFTAG_XRESOLUTION, &x) && x > 0)
        n->spacing[0] = 1 / (double)x;
    if (TIFFGetField(t, TIFFTAG_YRESOLUTION, &y) && y > 0)
        n->spacing[1] = 1 / (double)y;
}

/* Reads the names of channels, each in an element of its own; a name may be missing. */
static void read_ome_channels(const char *pixels, tiff_notes *n)
{
    const char *at = pixels;
    for (size_t c = 0; c < ISO_NAMED_CHANNELS && (at = strstr(at, "<Channel ")); ++c, ++at) {
        const char *end = strchr(at, '>'), *name = strstr(at, " Name=\"");
        if (end && name && name < end)
            find_text(name, " Name=\"", "\"", n->channel_name[c], sizeof n->channel_name[c]);
    }
}

/* Reads the attributes of the element Pixels. */
static void read_ome(const char *description, tiff_notes *n)
{
    static const char *const sizes[] = {" PhysicalSizeX=\"", " PhysicalSizeY=\"", " PhysicalSizeZ=\""};
    static const char *const units[] = {" PhysicalSizeXUnit=\"", " PhysicalSizeYUnit=\"", " PhysicalSizeZUnit=\""};
    const char *pixels = strstr(description, "<Pixels");
    n->is_ome = pixels != NULL;
    for (int a = 0; pixels && a < 3; ++a) {
        n->spacing[a] = find_number(pixels, sizes[a], "\"");
        if (!find_text(pixels, units[a], "\"", n->unit[a], sizeof n->unit[a]))
            snprintf(n->unit[a], sizeof n->unit[a], "um"); /* as the schema has it */
    }
    if (pixels) {
        n->slices = (size_t)find_number(pixels, " SizeZ=\"", "\"");
        n->channels = (size_t)find_number(pixels, " SizeC=\"", "\"");
        n->frames = (size_t)find_number(pixels, " SizeT=\"", "\"");
        n->frame_step = find_number(pixels, " TimeIncrement=\"", "\"");
        if (!find_text(pixels, " TimeIncrementUnit=\"", "\"", n->frame_unit, sizeof n->frame_unit))
            snprintf(n->frame_unit, sizeof n->frame_unit, "s");
        find_text(pixels, " DimensionOrder=\"XY", "\"", n->order, sizeof n->order);
        read_ome_channels(pixels, n);
    }
}

static tiff_notes read_notes(TIFF *t)
{
    tiff_notes n = {0};
    const char *description = NULL;
    if (!TIFFGetField(t, TIFFTAG_IMAGEDESCRIPTION, &description) || !description)
        return n;
    if (strncmp(description, "ImageJ=", 7) == 0)
        read_imagej(t, description, &n);
    else if (strstr(description, "<OME"))
        read_ome(description, &n);
    return n;
}

/* ---- the header ---- */

static iso_status find_pages(tiff_reader *r, const char *path, tiff_page *first, iso_error *err)
{
    size_t room = 0;
    for (size_t i = 0; i == 0 || !TIFFLastDirectory(r->tiff); ++i) {
        uint32_t kind = 0;
        if (i > 0 && !TIFFReadDirectory(r->tiff))
            return iso_fail(err, ISO_E_FORMAT, "%s: truncated or damaged after page %zu", path, r->page_count);
        TIFFGetFieldDefaulted(r->tiff, TIFFTAG_SUBFILETYPE, &kind);
        if (kind & FILETYPE_REDUCEDIMAGE)
            continue; /* a thumbnail */
        const tiff_page p = read_page(r->tiff);
        if (r->page_count == 0)
            *first = p;
        if (p.width != first->width || p.height != first->height || p.bits != first->bits ||
            p.samples != first->samples || p.format != first->format || p.planar != first->planar)
            return iso_fail(err, ISO_E_FORMAT, "%s: page %zu has %u x %u pixels of %u bits, the first %u x %u of %u",
                            path, r->page_count + 1, p.width, p.height, p.bits, first->width, first->height,
                            first->bits);
        if (r->page_count == room) {
            room = room ? 2 * room : 64;
            uint64_t *more = realloc(r->page, room * sizeof *more);
            NEED_MEMORY(more, err, "%s: out of memory", path);
            r->page = more;
        }
        r->page[r->page_count++] = TIFFCurrentDirOffset(r->tiff);
    }
    return r->page_count > 0 ? ISO_OK : iso_fail(err, ISO_E_FORMAT, "%s: has only thumbnails", path);
}

/* Checks OME's DimensionOrder after XY, the order of pages: a repeated letter would lead beyond the last page. */
static iso_status check_order(const tiff_notes *n, const char *path, iso_error *err)
{
    const bool has_each = strchr(n->order, 'Z') && strchr(n->order, 'C') && strchr(n->order, 'T');
    if (!n->order[0] || (has_each && strlen(n->order) == 3))
        return ISO_OK;
    return iso_fail(err, ISO_E_FORMAT, "%s: OME's DimensionOrder is XY%s, must be XY and each of Z, C and T once", path,
                    n->order);
}

/* Orders pages by their description. Components of one page are in its pixels. */
static iso_status choose(const tiff_notes *n, const tiff_page *p, iso_volume_source *source, size_t *slices,
                         iso_error *err)
{
    tiff_reader *r = source->reader;
    const size_t frames = n->frames > 1 ? n->frames : 1, all = n->channels > 1 ? n->channels : 1;
    const size_t inside = p->samples > 0 ? p->samples : 1,
                 channels = all % inside == 0 ? all / inside : all; /* OME counts both */
    *slices = n->slices > 0 ? n->slices : r->page_count / frames / channels;
    if (*slices == 0 || *slices > r->page_count ||
        (double)*slices * (double)frames * (double)channels != (double)r->page_count)
        return iso_fail(err, ISO_E_FORMAT,
                        "%s: truncated: has %zu pages, but by %s %zu slices, %zu channels and %zu time steps",
                        source->path, r->page_count, n->is_ome ? "OME" : "ImageJ", *slices, channels, frames);
    const bool in_planes = inside > 1 && p->planar != PLANARCONFIG_CONTIG;
    if (inside > 1 && channels > 1)
        return iso_fail(err, ISO_E_FORMAT, "%s: %zu channels of %zu components each, which is not read", source->path,
                        channels, inside);
    iso_extra_axes axes = {.frame = {.count = frames, .stride = 1},
                           .channel = {.count = inside > 1 ? inside : channels, .inside = inside > 1, .stride = 1},
                           .frame_step = n->frame_step,
                           .is_color = p->is_color};
    snprintf(axes.frame_unit, sizeof axes.frame_unit, "%s", n->frame_step > 0 ? n->frame_unit : "");
    if (inside == 1)
        memcpy(axes.channel_name, n->channel_name, sizeof axes.channel_name);
    const iso_status status = iso_source_choose(source, &axes, err);
    if (status != ISO_OK && in_planes && r->page_count == 1 && !source->hints.channel)
        return iso_fail(err, status,
                        "%s: one page of %zu planes, which are channels: --channel K chooses one, from 0 to "
                        "%zu; if they are slices, save a page for each",
                        source->path, inside, inside - 1);
    if (status != ISO_OK)
        return status;
    /* Which pages and planes: this reader's business. */
    r->planes = in_planes ? p->samples : 1;
    const size_t count[3] = {*slices, channels, frames};
    const size_t chosen[3] = {0, inside > 1 ? 0 : source->choice.channel, source->choice.frame};
    size_t stride = 1;
    for (const char *at = n->order[0] ? n->order : "ZCT"; *at; ++at) {
        const int axis = *at == 'Z' ? 0 : *at == 'C' ? 1 : 2;
        r->first += chosen[axis] * stride;
        r->step = axis == 0 ? stride : r->step;
        stride *= count[axis];
    }
    assert(r->first + (*slices - 1) * r->step < r->page_count);
    source->choice.volume_count = 1;
    source->choice.volume_at = 0;
    return ISO_OK;
}

static iso_status take_geometry(iso_volume_source *source, const tiff_page *p, size_t slices, tiff_notes *n,
                                iso_error *err)
{
    double spacing[3], mm;
    bool lacks = false;
    for (int a = 0; a < 3; ++a) {
        const bool is_pixels = strncasecmp(n->unit[a], "pixel", 5) == 0 || n->unit[a][0] == 0;
        spacing[a] = n->spacing[a] == 0 || (is_pixels && !source->hints.unit) ? (double)NAN : n->spacing[a];
        lacks = lacks || isnan(spacing[a]);
    }
    NEED(iso_source_take_spacing(source, spacing, err));
    for (int a = 0; a < 3; ++a) {
        NEED(iso_source_unit(source, lacks ? NULL : n->unit[a], "mm", &mm, err));
        spacing[a] *= mm;
    }
    source->header.geometry = iso_geometry_axis_aligned((size_t[]){p->width, p->height, slices}, spacing);
    return iso_source_check_geometry(source, err);
}

/* ---- samples ---- */

static bool read_tiles(TIFF *t, uint16_t plane, char *out, size_t row_bytes, size_t rows)
{
    uint32_t width = 0, height = 0;
    TIFFGetField(t, TIFFTAG_TILEWIDTH, &width);
    TIFFGetField(t, TIFFTAG_TILELENGTH, &height);
    const size_t tile_row = TIFFTileRowSize64(t), across = tile_row ? (row_bytes + tile_row - 1) / tile_row : 0;
    const uint32_t first = TIFFComputeTile(t, 0, 0, 0, plane);
    FREED char *tile = malloc(TIFFTileSize64(t));
    bool well = tile && across > 0 && height > 0;
    for (size_t y = 0; well && y < rows; y += height)
        for (size_t i = 0; well && i < across; ++i) {
            const size_t bytes = i * tile_row + tile_row <= row_bytes ? tile_row : row_bytes - i * tile_row;
            well = TIFFReadEncodedTile(t, first + (uint32_t)(y / height * across + i), tile, -1) > 0;
            for (size_t row = 0; well && row < height && y + row < rows; ++row)
                memcpy(out + (y + row) * row_bytes + i * tile_row, tile + row * tile_row, bytes);
        }
    return well;
}

static bool read_strips(TIFF *t, uint16_t plane, char *out, size_t bytes)
{
    size_t done = 0;
    for (uint32_t strip = TIFFComputeStrip(t, 0, plane); strip < TIFFNumberOfStrips(t) && done < bytes; ++strip) {
        const tmsize_t got = TIFFReadEncodedStrip(t, strip, out + done, (tmsize_t)(bytes - done));
        if (got <= 0)
            return false;
        done += (size_t)got;
    }
    return done == bytes;
}

static bool read_component(TIFF *t, uint16_t plane, char *out, size_t bytes, size_t rows)
{
    return TIFFIsTiled(t) ? read_tiles(t, plane, out, bytes / rows, rows) : read_strips(t, plane, out, bytes);
}

/* Reads samples whose bits stand without gaps within a row. */
static bool read_odd_bits(const iso_volume_source *source, char *out)
{
    tiff_reader *r = source->reader;
    const size_t *n = source->header.geometry.size, row_bytes = (n[0] * r->odd_bits + 7) / 8;
    FREED unsigned char *packed = malloc(row_bytes * n[1]);
    if (!packed || !read_component(r->tiff, 0, (char *)packed, row_bytes * n[1], n[1]))
        return false;
    for (size_t y = 0; y < n[1]; ++y)
        for (size_t x = 0; x < n[0]; ++x) {
            uint16_t value = 0;
            for (size_t bit = x * r->odd_bits; bit < (x + 1) * r->odd_bits; ++bit)
                value = (uint16_t)(value << 1 | (packed[y * row_bytes + bit / 8] >> (7 - bit % 8) & 1));
            if (r->odd_bits < 8)
                ((uint8_t *)out)[y * n[0] + x] = (uint8_t)value;
            else
                ((uint16_t *)out)[y * n[0] + x] = value;
        }
    return true;
}

/* Reads the components of a page; those in planes are put next to each other, as other pages have them. */
static bool read_page_samples(const iso_volume_source *source, char *out)
{
    tiff_reader *r = source->reader;
    const size_t rows = source->header.geometry.size[1], bytes = iso_source_plane_bytes(source),
                 sample = iso_type_bytes(iso_source_stored_type(source));
    if (r->odd_bits)
        return read_odd_bits(source, out);
    if (r->planes == 1)
        return read_component(r->tiff, 0, out, bytes, rows);
    FREED char *plane = malloc(bytes / r->planes);
    bool well = plane != NULL;
    for (uint16_t c = 0; well && c < r->planes; ++c) {
        well = read_component(r->tiff, c, plane, bytes / r->planes, rows);
        for (size_t i = 0; well && i < bytes / r->planes / sample; ++i)
            memcpy(out + (i * r->planes + c) * sample, plane + i * sample, sample);
    }
    return well;
}

static iso_status read_planes(iso_volume_source *source, size_t plane_count, void *out, iso_error *err)
{
    tiff_reader *r = source->reader;
    const size_t *n = source->header.geometry.size, bytes = iso_source_plane_bytes(source);
    for (size_t i = 0; i < plane_count; ++i, ++r->next) {
        if (!TIFFSetSubDirectory(r->tiff, r->page[r->first + r->next * r->step]) ||
            !read_page_samples(source, (char *)out + i * bytes))
            return check_read(r, source->path,
                              iso_fail(err, ISO_E_FORMAT, "%s: truncated or damaged in page %zu of %zu", source->path,
                                       r->next + 1, n[2]),
                              err);
    }
    return check_read(r, source->path, ISO_OK, err);
}

static void close_tiff(iso_volume_source *source)
{
    tiff_reader *r = source->reader;
    if (r->tiff)
        TIFFClose(r->tiff);
    if (r->fd >= 0)
        close(r->fd);
    free(r->page);
    free(r);
}

static iso_status start_reader(iso_volume_source *source, iso_error *err)
{
    tiff_reader *r = calloc(1, sizeof *r);
    NEED_MEMORY(r, err, "%s: out of memory", source->path);
    source->reader = r;
    source->read_planes = read_planes;
    source->close_reader = close_tiff;
    r->fd = open(source->path, O_RDONLY | O_CLOEXEC);
    if (r->fd < 0)
        return iso_fail(err, iso_errno_status(), "%s: cannot be opened: %s", source->path, strerror(errno));
    TIFFSetErrorHandler(NULL); /* the messages are ours */
    TIFFSetWarningHandler(NULL);
    r->tiff = TIFFClientOpen(source->path, "rm", r, read_bytes, write_nothing, seek_to, close_nothing, size_of, NULL,
                             NULL);
    return r->tiff ? ISO_OK
                   : iso_fail(err, ISO_E_FORMAT, "%s: truncated or damaged: not a good TIFF file", source->path);
}

static iso_status read_header(iso_volume_source *source, iso_error *err)
{
    tiff_reader *r = source->reader;
    tiff_page page = {0};
    size_t slices = 0;
    tiff_notes notes = read_notes(r->tiff);
    NEED(find_pages(r, source->path, &page, err));
    if (page.depth != 1)
        return iso_fail(err, ISO_E_FORMAT,
                        "%s: has %u slices in a page (ImageDepth), which is not read; save a page for each slice",
                        source->path, page.depth);
    if (!take_type(&page, source))
        return iso_fail(err, ISO_E_FORMAT,
                        "%s: samples of %u bits, format %u, must be a gray integer of 1 to 16 bits, an integer of "
                        "8, 16, 32 or 64 bits, half, float or double",
                        source->path, page.bits, page.format);
    r->odd_bits = has_odd_bits(&page) ? page.bits : 0;
    NEED(check_order(&notes, source->path, err));
    NEED(choose(&notes, &page, source, &slices, err));
    NEED(take_geometry(source, &page, slices, &notes, err));
    return iso_source_check_packed(source, source->path, (double)size_of(r),
                                   most_of(page.compression) * (r->odd_bits ? 16. / r->odd_bits : 1), err);
}

static iso_status open_tiff(iso_volume_source *source, iso_error *err)
{
    iso_status status = start_reader(source, err);
    TRY(status, read_header(source, err));
    /* A tag that could not be read would be one that is not there. */
    return source->reader ? check_read(source->reader, source->path, status, err) : status;
}

const iso_volume_format iso_volume_format_tiff = {
    .name = "tiff",
    .title = "TIFF",
    .summary = "TIFF and BigTIFF, a slice a page, spacing of ImageJ's and OME's descriptions, plane by plane",
    .suffixes = ".tif .tiff .ome.tif .ome.tiff",
    .starts = "\"II*\", \"MM\", \"II+\"",
    .probe = starts_like_tiff,
    .open = open_tiff,
};
