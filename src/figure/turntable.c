/* SPDX-License-Identifier: MIT */
/* The volume from all sides: frames on a page, as an animation, and as files. */
#include <errno.h>
#include <math.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <zlib.h>

#include "base/file.h"
#include "compare/srgb.h"
#include "figure/columns.h"
#include "figure/kinds.h"
#include "figure/picture.h"
#include "image/image.h"
#include "renderers/picture_store.h"

enum { USUAL_FRAMES = 8, SHOWN_OF_MANY = 32 };

/* An animated PNG, written frame by frame. */
typedef struct animation {
    FILE *file;
    size_t frames, added, width, height;
    uint32_t sequence; /* counts fcTL and fdAT */
    unsigned milliseconds;
} animation;

static void put_u32(unsigned char *at, size_t value)
{
    for (int i = 0; i < 4; ++i)
        at[i] = (unsigned char)(value >> (24 - 8 * i));
}

/* Writes a chunk, returns true on success; the checksum covers the type and the data. */
static int put_chunk(FILE *f, const char type[4], const unsigned char *data, size_t size)
{
    unsigned char head[8], tail[4];
    put_u32(head, size);
    memcpy(head + 4, type, 4);
    uLong sum = crc32(crc32(0, NULL, 0), head + 4, 4);
    if (size > 0)
        sum = crc32(sum, data, (uInt)size);
    put_u32(tail, sum);
    return fwrite(head, 1, 8, f) == 8 && fwrite(data, 1, size, f) == size && fwrite(tail, 1, 4, f) == 4;
}

/* Creates an animation of `frames` frames, each shown for the given seconds, repeated endlessly. */
static iso_status animation_create(animation **out, const char *path, size_t frames, double seconds, iso_error *err)
{
    animation *a = *out = calloc(1, sizeof *a);
    NEED_MEMORY(a, err, "animation: out of memory");
    a->frames = frames;
    a->milliseconds = (unsigned)lrint(1000 * seconds);
    a->file = fopen(path, "wb");
    return a->file ? ISO_OK : iso_fail(err, ISO_E_IO, "%s: cannot be written", path);
}

static int put_head(animation *a)
{
    static const unsigned char signature[8] = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
    static const unsigned char perceptual[1] = {0};
    unsigned char size[13] = {0}, control[8] = {0}; /* the second number of acTL: 0 repeats endlessly */
    put_u32(size, a->width);
    put_u32(size + 4, a->height);
    size[8] = 8;
    size[9] = 2; /* RGB */
    put_u32(control, a->frames);
    return fwrite(signature, 1, 8, a->file) == 8 && put_chunk(a->file, "IHDR", size, 13) &&
           put_chunk(a->file, "sRGB", perceptual, 1) && put_chunk(a->file, "acTL", control, 8);
}

static int put_frame_control(animation *a)
{
    unsigned char c[26] = {0};
    put_u32(c, a->sequence++);
    put_u32(c + 4, a->width);
    put_u32(c + 8, a->height);
    c[20] = (unsigned char)(a->milliseconds >> 8), c[21] = (unsigned char)a->milliseconds;
    c[22] = 1000 >> 8, c[23] = 1000 & 0xff;
    return put_chunk(a->file, "fcTL", c, sizeof c);
}

/* Returns the rows in PNG's form: a byte of the filter, "sub", then differences from the pixel on the left. */
static unsigned char *filter_rows(const iso_image *image)
{
    const size_t row = 1 + 3 * image->width;
    unsigned char *rows = malloc(row * image->height);
    for (size_t y = 0; y < image->height && rows; ++y) {
        unsigned char before[3] = {0};
        rows[y * row] = 1;
        for (size_t i = 0; i < 3 * image->width; ++i) {
            const float linear = image->rgba[4 * (y * image->width + i / 3) + i % 3];
            const unsigned char byte = (unsigned char)(iso_srgb_encode((double)linear) * 255 + 0.5);
            rows[y * row + 1 + i] = (unsigned char)(byte - before[i % 3]);
            before[i % 3] = byte;
        }
    }
    return rows;
}

/* Writes a frame. The first one is the PNG's own picture; the others have their number before the data. */
static int put_frame(animation *a, const unsigned char *rows, size_t size)
{
    uLongf packed = compressBound(size);
    FREED unsigned char *data = malloc(4 + packed);
    const int first = a->added == 0;
    int whole = data && compress2(data + 4, &packed, rows, size, 6) == Z_OK && put_frame_control(a);
    if (whole && !first)
        put_u32(data, a->sequence++);
    whole = whole &&
            (first ? put_chunk(a->file, "IDAT", data + 4, packed) : put_chunk(a->file, "fdAT", data, 4 + packed));
    return whole;
}

/* Adds a frame. All frames have one size. */
static iso_status animation_add(animation *a, const iso_image *image, iso_error *err)
{
    const size_t size = (1 + 3 * image->width) * image->height;
    if (a->added == 0)
        a->width = image->width, a->height = image->height;
    if (image->width != a->width || image->height != a->height)
        return iso_fail(err, ISO_E_RANGE, "animation: frames differ in size");
    unsigned char *rows = filter_rows(image);
    const int whole = rows && (a->added > 0 || put_head(a)) && put_frame(a, rows, size);
    free(rows);
    ++a->added;
    return whole ? ISO_OK : iso_fail(err, rows ? ISO_E_IO : ISO_E_MEMORY, "animation: cannot be written");
}

/* Finishes the file. ISO_E_IO; ISO_E_RANGE: the number of added frames is not `frames`. */
static iso_status animation_finish(animation *a, iso_error *err)
{
    if (a->added != a->frames)
        return iso_fail(err, ISO_E_RANGE, "animation: %zu frames were added, not %zu", a->added, a->frames);
    const int whole = put_chunk(a->file, "IEND", (const unsigned char *)"", 0);
    const int closed = fclose(a->file) == 0;
    a->file = NULL;
    return whole && closed ? ISO_OK : iso_fail(err, ISO_E_IO, "animation: cannot be written");
}

static void animation_destroy(animation *a)
{
    if (a && a->file)
        fclose(a->file);
    free(a);
}

typedef struct turned {
    iso_figure_subject subject;
    const iso_renderer_info *with;
    size_t frames, level, shown; /* total frames; number of frames on the page */
    const char *dir;             /* of the frames' files */
    animation *animation;
} turned;

static void turned_destroy(turned *t)
{
    animation_destroy(t->animation);
    iso_figure_subject_end(&t->subject);
}

static iso_status save_frame(const turned *t, size_t frame, const iso_image *image, iso_error *err)
{
    char name[32];
    snprintf(name, sizeof name, "%03zu.png", frame);
    char *path = iso_path_join(t->dir, name);
    const iso_status status = path ? iso_image_save_png(image, path, 1, err)
                                   : iso_fail(err, ISO_E_MEMORY, "figure: out of memory");
    free(path);
    return status;
}

static iso_status draw_frame(turned *t, size_t frame, size_t width, size_t height, iso_image *image,
                             double *mm_per_pixel, iso_error *err)
{
    const iso_figure_picture what = {.with = t->with,
                                     .level = t->level,
                                     .width = width,
                                     .height = height,
                                     .turn_deg = 360.0 * (double)frame / (double)t->frames,
                                     .turns = t->frames};
    return iso_figure_render(&t->subject, &what, image, mm_per_pixel, err);
}

static iso_status render_frame(turned *t, size_t frame, size_t width, size_t height, iso_image *image,
                               double *mm_per_pixel, iso_error *err)
{
    NEED(draw_frame(t, frame, width, height, image, mm_per_pixel, err));
    NEED(animation_add(t->animation, image, err));
    return save_frame(t, frame, image, err);
}

/* Draws the frames for rank 0, from the end of this rank's share backwards: so it meets the rank before it. */
static iso_status draw_as_other_rank(turned *t, size_t width, size_t height, iso_error *err)
{
    const size_t end = iso_picture_store_share(t->subject.renderers.store, t->frames).end;
    for (size_t i = t->frames; i > 0; --i) {
        OWNED(iso_image) image = {0};
        NEED(draw_frame(t, (end + i - 1) % t->frames, width, height, &image, NULL, err));
    }
    t->subject.job->end_rank();
    return ISO_OK;
}

static size_t frame_of(const turned *t, size_t column)
{
    return column * t->frames / t->shown;
}

/* Renders a frame of the page, and the following ones up to the next on the page. */
static iso_status render(void *user, size_t column, size_t width, size_t height, iso_image *image, double *mm_per_pixel,
                         iso_error *err)
{
    turned *t = user;
    const size_t first = frame_of(t, column), end = frame_of(t, column + 1);
    if (t->subject.job->end_rank)
        return draw_as_other_rank(t, width, height, err);
    NEED(render_frame(t, first, width, height, image, mm_per_pixel, err));
    for (size_t i = first + 1; i < end; ++i) {
        OWNED(iso_image) between = {0};
        NEED(render_frame(t, i, width, height, &between, &(double){0}, err));
    }
    return ISO_OK;
}

/* Chooses 2 to 8 frames per row, few enough for a scale bar and its text in each, with full rows if possible. */
static size_t choose_row(size_t frames, double width_mm)
{
    const double least_mm = 24;
    size_t best = frames > 32 ? 8 : frames < 4 ? frames : width_mm < 2 * least_mm ? 2 : 4;
    for (size_t n = 3; n <= 8 && n <= frames; ++n)
        if (frames % n == 0 && (n == 3 || width_mm / (double)n >= least_mm))
            best = n;
    return best;
}

static iso_status make_folder(const char *dir, iso_error *err)
{
    return mkdir(dir, 0777) == 0 ? ISO_OK : iso_fail(err, ISO_E_IO, "%s: %s", dir, strerror(errno));
}

static void write_caption(const turned *t, FILE *f)
{
    fputs("Turns", f);
    iso_figure_put_subject(&t->subject, f);
    fprintf(f, " around the camera's up axis, level %zu", t->level);
    if (t->shown < t->frames)
        fprintf(f, ", %zu of %zu frames", t->shown, t->frames);
}

static iso_status draw_frames(turned *t, const iso_figure_job *job, iso_page *page, iso_error *err)
{
    iso_figure_columns c = {.job = job, .count = t->shown, .render = render, .user = t};
    c.per_row = choose_row(c.count, job->width_mm);
    for (size_t i = 0; i < c.count; ++i)
        snprintf(c.titles[i], sizeof c.titles[i], "%.4g°", 360.0 * (double)frame_of(t, i) / (double)t->frames);
    NEED(iso_figure_subject_load(&t->subject, job, t->level + 1, NULL, err));
    write_caption(t, iso_page_caption(page));
    c.drawn_by = &t->subject.drawn_by;
    c.tf = iso_figure_tf_foot_of(&t->subject);
    c.aspect = iso_figure_aspect(&t->subject);
    iso_status status = iso_figure_draw_columns(&c, page, err);
    if (status == ISO_OK)
        fputs(" turntable.png is an animation of all, 10 per second; frames/ has each as a file.",
              iso_page_caption(page));
    return status;
}

static iso_status draw_turntable(const iso_figure_job *job, iso_page *page, iso_error *err)
{
    FREED char *path = iso_page_file(page, "turntable.png"), *dir = iso_page_file(page, "frames");
    OWNED(turned)
    t = {.frames = job->frames ? (size_t)job->frames : USUAL_FRAMES, .level = (size_t)job->level, .dir = dir};
    t.shown = t.frames > ISO_FIGURE_MOST_COLUMNS ? (size_t)SHOWN_OF_MANY : t.frames;
    NEED(path && dir ? iso_figure_renderer(job, &t.with, err) : iso_fail(err, ISO_E_MEMORY, "figure: out of memory"));
    NEED(make_folder(dir, err));
    NEED(animation_create(&t.animation, path, t.frames, 0.1, err));
    NEED(draw_frames(&t, job, page, err));
    NEED(animation_finish(t.animation, err));
    if (job->store)
        json_object_set_new(job->facts, "frames_of_other_ranks",
                            json_integer((json_int_t)iso_picture_store_taken(job->store)));
    return ISO_OK;
}

const iso_figure_info iso_figure_turntable = {
    .name = "turntable",
    .summary = "the volume from all sides: frames side by side, as animation turntable.png, and as files",
    .takes = ISO_FIGURE_OF_VOLUME | ISO_FIGURE_HAS_LOOK | ISO_FIGURE_HAS_WITH | ISO_FIGURE_HAS_LEVEL |
             ISO_FIGURE_HAS_ADAPT | ISO_FIGURE_HAS_FRAMES | ISO_FIGURE_HAS_RANKS,
    .draw = draw_turntable,
};
