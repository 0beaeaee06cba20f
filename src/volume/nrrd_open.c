/* SPDX-License-Identifier: MIT */
/* nrrd_open.c - NRRD headers by teem; raw and gzip samples are then read by
 * source.c, plane by plane, other encodings and lists of files by teem at once. */
#define _GNU_SOURCE
#include <errno.h>
#include <jansson.h>
#include <limits.h>
#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>
#include <sys/types.h>
#include <teem/biff.h>
#include <teem/nrrd.h>
#include <unistd.h>

#include "base/control.h"
#include "base/file.h"
#include "base/inputs.h"
#include "base/status.h"
#include "base/words.h"
#include "volume/segments.h"
#include "volume/stream_kernel.h"

/* ---- the data files that a header names, looked at before teem opens them ---- */

enum { MOST_FILES = 65536 };

typedef struct look {
    const char *path; /* of the header */
    double bytes;
    bool is_text; /* words are looked at, too */
    size_t count;
    char missing[160]; /* the first missing file; checked first, since a pipe after it is worse */
} look;

/* Checks the words from the file's position to its end. */
static iso_status check_words(const char *path, FILE *file, iso_error *err)
{
    enum { MOST_WORD = 100 }; /* a message of 1024 bytes quotes it */
    size_t length = 0;
    for (int c; (c = getc_unlocked(file)) != EOF && length <= MOST_WORD;)
        length = c == ' ' || (c >= '\t' && c <= '\r') ? 0 : length + 1;
    return length <= MOST_WORD
               ? ISO_OK
               : iso_fail(err, ISO_E_FORMAT, "%s: a number of its samples has more than %d digits", path, MOST_WORD);
}

static iso_status add_name(look *l, const char *name, iso_error *err)
{
    char shown[80];
    iso_words_copy_line(name, shown, sizeof shown);
    if (strcmp(name, "-") == 0)
        return iso_fail(err, ISO_E_FORMAT, "%s: its data file is \"-\", must be the name of a file", l->path);
    if (++l->count > MOST_FILES)
        return iso_fail(err, ISO_E_RANGE, "%s: names more than %d data files", l->path, MOST_FILES);
    FREED char *dir = iso_path_dir(l->path);
    FREED char *file = name[0] == '/' ? strdup(name) : dir ? iso_path_join(dir, name) : NULL;
    struct stat st;
    NEED_MEMORY(file, err, "%s: out of memory", l->path);
    const int cause = stat(file, &st) != 0 ? errno : 0;
    if (cause == 0 && !S_ISREG(st.st_mode))
        return iso_fail(err, ISO_E_IO, "%s: its data file \"%s\" is not a regular file", l->path, shown);
    if (cause == 0)
        l->bytes += (double)st.st_size;
    else if (!l->missing[0])
        snprintf(l->missing, sizeof l->missing, "\"%s\" cannot be read: %s", shown, strerror(cause));
    NEED(iso_inputs_note(file, err));
    ENDED_BY(iso_close_file) FILE *text = l->is_text ? fopen(file, "rbe") : NULL;
    return text ? check_words(l->path, text, err) : ISO_OK;
}

/* The place of %d, %4d or %04d; NULL: there is none, and teem takes the text as it is. */
static const char *number_place(const char *pattern)
{
    for (const char *at = strchr(pattern, '%'); at; at = strchr(at + 1, '%'))
        if (at[1 + strspn(at + 1, "0123456789")] == 'd')
            return at;
    return NULL;
}

/* Adds the files of a line "NAME%03d.raw MIN MAX STEP". */
static iso_status add_numbered(look *l, char *pattern, iso_error *err)
{
    int first, last, step;
    char shown[80];
    iso_words_copy_line(pattern, shown, sizeof shown);
    char *rest = pattern + strcspn(pattern, " \t");
    if (sscanf(rest, "%d %d %d", &first, &last, &step) != 3)
        return ISO_OK; /* teem refuses it before it opens anything */
    *rest = 0;
    const char *place = number_place(pattern);
    if (!place || strchr(pattern, '%') != place || strchr(place + 1, '%') || strspn(place + 1, "0123456789") > 2)
        return iso_fail(err, ISO_E_FORMAT, "%s: data files \"%s\": must have one place for a number, such as %%03d",
                        l->path, shown);
    if (step == 0)
        return ISO_OK; /* as above */
    /* teem multiplies the first two, and counts until it is beyond the last one, in int. */
    const double way = (double)last - first, count = way / step + 1;
    if (fabs(way) > INT_MAX || fabs(way * step) > INT_MAX || fabs((double)last + step) > INT_MAX)
        return iso_fail(err, ISO_E_RANGE, "%s: the numbers %d to %d by %d of its data files are too large", l->path,
                        first, last, step);
    if (count > MOST_FILES)
        return iso_fail(err, ISO_E_RANGE, "%s: names %.0f data files, at most %d", l->path, count, MOST_FILES);
    for (int i = 0; i < (int)count; ++i) {
        FREED char *name = NULL;
        const size_t after = strcspn(place, "d") + 1;
        const int width = atoi(place + 1), zeros = place[1] == '0';
        if (asprintf(&name, zeros ? "%.*s%0*d%s" : "%.*s%*d%s", (int)(place - pattern), pattern, width,
                     first + i * step, place + after) < 0)
            return iso_fail(err, ISO_E_MEMORY, "%s: out of memory", l->path);
        NEED(add_name(l, name, err));
    }
    return ISO_OK;
}

/* Reads a line, which ends at \n, \r or both, as in teem. Returns its length without them; below 0: the file has ended,
 * or memory has. *ended: the line has such an end. */
static ssize_t read_line(FILE *file, char **line, size_t *room, bool *ended)
{
    size_t length = 0;
    int c;
    while ((c = getc_unlocked(file)) != EOF && c != '\n' && c != '\r') {
        if (length + 2 > *room) {
            char *more = realloc(*line, *room = *room ? 2 * *room : 256);
            if (!more)
                return -1;
            *line = more;
        }
        (*line)[length++] = (char)c;
    }
    *ended = c != EOF;
    if (c == '\r' && (c = getc_unlocked(file)) != '\n' && c != EOF)
        ungetc(c, file);
    if (length == 0 && !*ended)
        return -1;
    if (*room == 0 && !(*line = malloc(*room = 256)))
        return -1;
    (*line)[length] = 0;
    return (ssize_t)length;
}

/* teem keeps 1024 bytes for a message, which may quote a line that it cannot read. */
enum { MOST_LINE = 800 };
static bool may_be_quoted(const char *line)
{
    const char *field = strstr(line, ": "), *key = strstr(line, ":=");
    if (line[0] == '#' || strncasecmp(line, "content: ", 9) == 0)
        return false;
    return !key || (field && field < key);
}

/* Returns the value of a field "data file"; NULL: another line. */
static char *data_file_of(char *line)
{
    char *colon = line[0] == '#' ? NULL : strstr(line, ": ");
    if (!colon)
        return NULL;
    *colon = 0;
    const char *field = line + strspn(line, " \t");
    if (strcasecmp(field, "data file") != 0 && strcasecmp(field, "datafile") != 0)
        return NULL;
    return colon + 2 + strspn(colon + 2, " \t");
}

static iso_status take_line(look *l, char *line, bool *list, bool *any, iso_error *err)
{
    char *value = *list ? line : data_file_of(line);
    if (!value)
        return ISO_OK;
    if (!*value)
        return iso_fail(err, ISO_E_FORMAT, "%s: names a data file without a name", l->path);
    *any = true;
    if (*list || (strncasecmp(value, "LIST", 4) != 0 && !number_place(value)))
        return add_name(l, value, err);
    *list = strncasecmp(value, "LIST", 4) == 0;
    return *list ? ISO_OK : add_numbered(l, value, err);
}

/* True for a comment of bytes that teem removes all: teem would then read before the comment's first byte. */
static bool is_unprintable_comment(const char *line)
{
    const char *text = line + strspn(line, "# ");
    if (line[0] != '#' || !*text)
        return false;
    for (; *text; ++text)
        if ((*text >= ' ' && *text <= '~') || (*text >= '\t' && *text <= '\r'))
            return false;
    return true;
}

static iso_status look_at(look *l, FILE *header, bool *any, iso_error *err)
{
    FREED char *line = NULL;
    size_t room = 0;
    bool list = false, ended = true;
    for (ssize_t n; (n = read_line(header, &line, &room, &ended)) > 0;) {
        if (n > MOST_LINE && may_be_quoted(line))
            return iso_fail(err, ISO_E_FORMAT, "%s: a line of its header has %zd bytes, at most %d", l->path, n,
                            MOST_LINE);
        if (!ended) /* teem would take the bytes after it for its end */
            return iso_fail(err, ISO_E_FORMAT, "%s: its header ends within a line", l->path);
        if (strlen(line) != (size_t)n)
            return iso_fail(err, ISO_E_FORMAT, "%s: its header holds a byte of 0", l->path);
        if (is_unprintable_comment(line))
            return iso_fail(err, ISO_E_FORMAT, "%s: a comment of its header holds no character that can be read",
                            l->path);
        NEED(take_line(l, line, &list, any, err));
    }
    return ISO_OK;
}

static iso_status look_through(look *l, bool *any, iso_error *err)
{
    ENDED_BY(iso_close_file) FILE *header = fopen(l->path, "rbe");
    if (!header)
        return iso_fail(err, iso_errno_status(), "%s: cannot be opened: %s", l->path, strerror(errno));
    NEED(look_at(l, header, any, err));
    return l->missing[0] ? iso_fail(err, ISO_E_FORMAT, "%s: its data file %s", l->path, l->missing) : ISO_OK;
}

/* Finds the header's files, and refuses those that are unsafe in teem:
 *  - it prints a name's pattern by sprintf() into a buffer 10 bytes longer than the pattern;
 *  - it opens pipes, takes "-" for its input, and counts to any number of files;
 *  - messages of more than 1024 bytes, and a last line without its end, overflow it;
 *  - it reads the byte after an empty name, and the byte before a comment without a readable character.
 * So patterns have one place for a number, of a width of at most two digits. Files are regular ones, at most
 * MOST_FILES. Lines are short and whole. *bytes: the files' total size; below 0 if the header names none.
 * ISO_E_FORMAT, ISO_E_IO, ISO_E_MEMORY. */
static iso_status nrrd_look_at_files(const char *path, double *bytes, iso_error *err)
{
    look l = {.path = path};
    bool any = false;
    NEED(look_through(&l, &any, err));
    *bytes = any ? l.bytes : -1;
    return ISO_OK;
}

/* Checks samples as text, which teem reads by words into a small buffer. The words have to be short enough in the
 * rest of a file, which keeps its position, and in the files of a header. file may be NULL. ISO_E_FORMAT if they are
 * not. */
static iso_status nrrd_check_words(const char *path, FILE *file, iso_error *err)
{
    look l = {.path = path, .is_text = true};
    bool any = false;
    const off_t at = file ? ftello(file) : -1;
    iso_status status = look_through(&l, &any, err);
    if (at >= 0 && status == ISO_OK)
        status = check_words(path, file, err);
    if (at >= 0)
        fseeko(file, at, SEEK_SET);
    return status;
}

/* ---- the segments that a .seg.nrrd file names ---- */

enum { MOST_SEGMENTS = 65536 };

/* Returns the value of "SegmentN_KEY"; to be freed. NULL: the key is missing. */
static char *value_of(const Nrrd *nrrd, int number, const char *key)
{
    char name[64];
    snprintf(name, sizeof name, "Segment%d_%s", number, key);
    return nrrdKeyValueGet(nrrd, name);
}

/* Returns a whole number of the file, or `otherwise`. */
static long number_of(const Nrrd *nrrd, int number, const char *key, long otherwise)
{
    char *text = value_of(nrrd, number, key), *end = text;
    const long value = text ? strtol(text, &end, 10) : otherwise;
    const bool good = text && end != text && value >= ISO_SEGMENTS_LABEL_MIN && value <= ISO_SEGMENTS_LABEL_MAX;
    free(text);
    return good ? value : otherwise;
}

/* Reads three numbers; a color's are 0 to 1. */
static json_t *color_of(const Nrrd *nrrd, int number)
{
    char *text = value_of(nrrd, number, "Color"), *at = text;
    json_t *color = json_array();
    for (int c = 0; at && c < 3; ++c) {
        char *end = at;
        const double value = strtod(at, &end);
        if (end == at || !(value >= 0 && value <= 1))
            break;
        json_array_append_new(color, json_real(value));
        at = end;
    }
    free(text);
    if (json_array_size(color) == 3)
        return color;
    json_decref(color);
    return NULL;
}

static json_t *segment_of(const Nrrd *nrrd, int number, bool has_layers)
{
    FREED char *id = value_of(nrrd, number, "ID"), *name = value_of(nrrd, number, "Name");
    json_t *segment = NULL, *color;
    if (id || name) {
        const long label = number_of(nrrd, number, "LabelValue", has_layers ? 1 : number + 1);
        const long layer = number_of(nrrd, number, "Layer", has_layers ? number : 0);
        segment = json_pack("{sI so sI}", "label", (json_int_t)label, "name", iso_segments_text(name ? name : id),
                            "layer", (json_int_t)(layer > 0 ? layer : 0));
        if (segment && (color = color_of(nrrd, number)))
            json_object_set_new(segment, "color", color);
    }
    return segment;
}

/* Returns each segment with its layer (segments.h); NULL if the file names none. has_layers: it has an axis of them. */
static json_t *nrrd_segments(const Nrrd *nrrd, bool has_layers)
{
    json_t *segments = json_array(), *segment;
    for (int i = 0; i < MOST_SEGMENTS && (segment = segment_of(nrrd, i, has_layers)); ++i)
        json_array_append_new(segments, segment);
    if (json_array_size(segments) > 0)
        return segments;
    json_decref(segments);
    return NULL;
}

/* ---- axes ---- */

/* Reports the innermost of teem's messages. */
static iso_status teem_failed(const char *path, const Nrrd *nrrd, iso_error *err)
{
    const int number = errno; /* of the failed call on the file, if any */
    const bool is_of_file = number == EIO || number == EINTR || number == EMFILE || number == ENFILE ||
                            number == EACCES || number == ENOMEM;
    FREED char *text = biffGetDone(NRRD);
    char cause[512] = "unknown error";
    for (char *rest = text, *line; text && (line = strsep(&rest, "\n"));)
        if (*line)
            snprintf(cause, sizeof cause, "%s", line);
    if (is_of_file)
        return iso_fail(err, number == ENOMEM ? ISO_E_MEMORY : ISO_E_IO, "%s: cannot be read: %s", path,
                        strerror(number));
    /* "[nrrd] function: cause" */
    if (strstr(cause, "too large"))
        return iso_fail(err, ISO_E_RANGE, "%s: sizes %zu x %zu x %zu ... overflow, at most %zu bytes can be addressed",
                        path, nrrd->axis[0].size, nrrd->axis[1].size, nrrd->axis[2].size, SIZE_MAX);
    const char *colon = strncmp(cause, "[nrrd] ", 7) == 0 ? strstr(cause, ": ") : NULL;
    return iso_fail(err, ISO_E_FORMAT, "%s: not a good NRRD file: %s", path, colon ? colon + 2 : cause);
}

static bool our_type(int teem_type, iso_type *type)
{
    switch (teem_type) {
    case nrrdTypeChar: *type = ISO_I8; return true;
    case nrrdTypeUChar: *type = ISO_U8; return true;
    case nrrdTypeShort: *type = ISO_I16; return true;
    case nrrdTypeUShort: *type = ISO_U16; return true;
    case nrrdTypeInt: *type = ISO_I32; return true;
    case nrrdTypeUInt: *type = ISO_U32; return true;
    case nrrdTypeFloat: *type = ISO_F32; return true;
    case nrrdTypeDouble: *type = ISO_F64; return true;
    default: return false;
    }
}

typedef enum axis_use { AXIS_SPACE, AXIS_FRAMES, AXIS_CHANNELS } axis_use;

/* Returns the use of an axis: by its kind, or else by its direction, or by position if the file has no directions. Of
 * four axes without kinds, the first has components if there are at most four; if not, the last has frames. */
static axis_use use_of(const Nrrd *nrrd, unsigned a, unsigned dim)
{
    const int kind = nrrd->axis[a].kind;
    const bool may_be_components = nrrd->axis[0].size <= 4;
    if (kind == nrrdKindList || kind == nrrdKindTime)
        return AXIS_FRAMES;
    if (kind == nrrdKindUnknown && nrrd->spaceDim > 0)
        return isnan(nrrd->axis[a].spaceDirection[0]) ? (a == 0 && may_be_components ? AXIS_CHANNELS : AXIS_FRAMES)
                                                      : AXIS_SPACE;
    if (kind == nrrdKindUnknown && dim > 3 && a == (may_be_components ? 0 : dim - 1))
        return may_be_components ? AXIS_CHANNELS : AXIS_FRAMES;
    return kind == nrrdKindUnknown || kind == nrrdKindDomain || kind == nrrdKindSpace ? AXIS_SPACE : AXIS_CHANNELS;
}

/* The axes of space, and those before and after them. */
typedef struct nrrd_axes {
    unsigned space[3];
    iso_extra_axes extra;
} nrrd_axes;

static void take_extra(const NrrdAxisInfo *axis, axis_use use, bool inside, size_t stride, iso_extra_axes *extra)
{
    *(use == AXIS_FRAMES ? &extra->frame : &extra->channel) = (iso_extra_axis){axis->size, inside, stride};
    if (use == AXIS_CHANNELS) {
        extra->is_color = axis->kind == nrrdKindRGBColor || axis->kind == nrrdKindRGBAColor;
        return;
    }
    extra->frame_step = isnan(axis->spacing) ? 0 : axis->spacing;
    snprintf(extra->frame_unit, sizeof extra->frame_unit, "%s", axis->units ? axis->units : "");
}

static iso_status sort_axes(const Nrrd *nrrd, const char *path, nrrd_axes *out, iso_error *err)
{
    unsigned dim = nrrd->dim, found = 0;
    size_t stride[2] = {1, 1}; /* after the axes of space, and before them */
    *out = (nrrd_axes){0};
    while (dim > 3 && nrrd->axis[dim - 1].size == 1)
        --dim;
    for (unsigned a = 0; a < dim; ++a) {
        const NrrdAxisInfo *axis = &nrrd->axis[a];
        const axis_use use = use_of(nrrd, a, dim);
        const bool inside = found == 0;
        if (use == AXIS_SPACE && found < 3) {
            out->space[found++] = a;
            continue;
        }
        if (use == AXIS_SPACE || (found > 0 && found < 3) ||
            (use == AXIS_FRAMES ? out->extra.frame : out->extra.channel).count > 0)
            return iso_fail(err, ISO_E_FORMAT,
                            "%s: %u axes, of which axis %u is of kind %s: a volume has 3 of space side by side, and at "
                            "most one of time and one of components",
                            path, dim, a, axis->kind == nrrdKindUnknown ? "???" : airEnumStr(nrrdKind, axis->kind));
        take_extra(axis, use, inside, stride[inside], &out->extra);
        stride[inside] *= axis->size;
    }
    return found == 3 ? ISO_OK
                      : iso_fail(err, ISO_E_FORMAT, "%s: %u axes, %u of space, a volume has 3", path, dim, found);
}

/* Returns the signs that turn an anatomical space to right, anterior, superior. False for other spaces. */
static bool ras_signs(int space, double sign[3])
{
    sign[0] = sign[1] = sign[2] = 1;
    if (space == nrrdSpaceLeftAnteriorSuperior || space == nrrdSpaceLeftPosteriorSuperior)
        sign[0] = -1;
    if (space == nrrdSpaceLeftPosteriorSuperior)
        sign[1] = -1;
    return space == nrrdSpaceRightAnteriorSuperior || space == nrrdSpaceLeftAnteriorSuperior ||
           space == nrrdSpaceLeftPosteriorSuperior;
}

static iso_vec3 scaled(const double v[3], const double scale[3])
{
    return iso_v3(v[0] * scale[0], v[1] * scale[1], v[2] * scale[2]);
}

static iso_status oriented_geometry(const Nrrd *nrrd, const nrrd_axes *axes, iso_volume_source *source, iso_error *err)
{
    iso_volume *header = &source->header;
    iso_geometry *g = &header->geometry;
    if (nrrd->spaceDim != 3)
        return iso_fail(err, ISO_E_FORMAT, "%s: space of dimension %u, must be 3", source->path, nrrd->spaceDim);
    double scale[3], mm;
    header->notes.world_is_ras = ras_signs(nrrd->space, scale);
    for (int a = 0; a < 3; ++a) {
        NEED(iso_source_unit(source, nrrd->spaceUnits[a], "mm", &mm, err));
        scale[a] *= mm;
    }
    for (int a = 0; a < 3; ++a) {
        iso_vec3 step = scaled(nrrd->axis[axes->space[a]].spaceDirection, scale);
        g->index_to_world.m[0][a] = step.x;
        g->index_to_world.m[1][a] = step.y;
        g->index_to_world.m[2][a] = step.z;
    }
    if (isnan(nrrd->spaceOrigin[0]))
        g->origin_mm = iso_scale(iso_sub(iso_geometry_box_center_mm(g), g->origin_mm), -1);
    else
        g->origin_mm = iso_sub(scaled(nrrd->spaceOrigin, scale), iso_mul(g->index_to_world, iso_v3(0.5, 0.5, 0.5)));
    return ISO_OK;
}

/* Returns the spacing; NAN if the header has none. An axis' bounds give it if its centering is known. */
static double spacing_of(const NrrdAxisInfo *axis)
{
    if (!isnan(axis->spacing) || isnan(axis->min) || isnan(axis->max) || axis->center == nrrdCenterUnknown)
        return axis->spacing;
    const double steps = (double)axis->size - (axis->center == nrrdCenterNode ? 1 : 0);
    return steps > 0 ? (axis->max - axis->min) / steps : (double)NAN;
}

static iso_status plain_geometry(const Nrrd *nrrd, const nrrd_axes *axes, iso_volume_source *source, iso_error *err)
{
    iso_geometry *g = &source->header.geometry;
    double spacing[3], corner[3], mm;
    bool placed = true;
    for (int a = 0; a < 3; ++a) {
        const NrrdAxisInfo *axis = &nrrd->axis[axes->space[a]];
        NEED(iso_source_unit(source, axis->units, "mm", &mm, err));
        spacing[a] = spacing_of(axis) * mm;
        placed = placed && !isnan(axis->min);
        corner[a] = axis->min * mm;
    }
    NEED(iso_source_take_spacing(source, spacing, err));
    for (int a = 0; a < 3; ++a)
        corner[a] -= nrrd->axis[axes->space[a]].center == nrrdCenterNode ? 0.5 * spacing[a] : 0;
    *g = iso_geometry_axis_aligned(g->size, spacing);
    if (placed)
        g->origin_mm = iso_v3(corner[0], corner[1], corner[2]);
    return ISO_OK;
}

static void read_scale(const Nrrd *nrrd, iso_volume_notes *notes)
{
    static const char *const keys[2][2] = {{"scale_slope", "scale_intercept"}, {"nifti_scl_slope", "nifti_scl_inter"}};
    for (int k = 0; k < 2; ++k) {
        FREED char *slope = nrrdKeyValueGet(nrrd, keys[k][0]), *intercept = nrrdKeyValueGet(nrrd, keys[k][1]);
        double s = slope ? strtod(slope, NULL) : 0, i = intercept ? strtod(intercept, NULL) : 0;
        if (isfinite(s) && s != 0 && isfinite(i)) {
            notes->scale_slope = s;
            notes->scale_intercept = i;
        }
    }
}

/* Takes the unit without the quotes that teem writes around it and keeps on reading. */
static void take_value_unit(const char *said, iso_volume_notes *notes)
{
    if (!said)
        return;
    const bool is_quoted = said[0] == '"';
    iso_words_copy_line(said + is_quoted, notes->value_unit, sizeof notes->value_unit);
    const size_t n = strlen(notes->value_unit);
    if (is_quoted && n > 0 && notes->value_unit[n - 1] == '"')
        notes->value_unit[n - 1] = 0;
}

static iso_status read_header(const Nrrd *nrrd, iso_volume_source *source, iso_error *err)
{
    iso_volume *header = &source->header;
    nrrd_axes axes;
    NEED(sort_axes(nrrd, source->path, &axes, err));
    if (nrrd->type == nrrdTypeLLong || nrrd->type == nrrdTypeULLong)
        iso_source_set_form(source, nrrd->type == nrrdTypeLLong ? ISO_FORM_I64 : ISO_FORM_U64);
    else if (!our_type(nrrd->type, &header->type))
        return iso_fail(err, ISO_E_FORMAT, "%s: type \"%s\", must be an integer, float or double", source->path,
                        airEnumStr(nrrdType, nrrd->type));
    for (int a = 0; a < 3; ++a) {
        header->geometry.size[a] = nrrd->axis[axes.space[a]].size;
        header->geometry.box_index[a] = (double)nrrd->axis[axes.space[a]].size;
    }
    iso_status status = nrrd->spaceDim > 0 ? oriented_geometry(nrrd, &axes, source, err)
                                           : plain_geometry(nrrd, &axes, source, err);
    read_scale(nrrd, &header->notes);
    take_value_unit(nrrd->sampleUnits, &header->notes);
    json_auto_t *segments = nrrd_segments(nrrd, axes.extra.frame.count > 1);
    header->notes.says_labels = segments != NULL;
    axes.extra.layers = segments;
    TRY(status, iso_source_choose(source, &axes.extra, err));
    header->segments = iso_segments_of_layer(segments, header->notes.frame);
    return status == ISO_OK ? iso_source_check_geometry(source, err) : status;
}

/* Passes the open data file on: positioned after the header (or the lines and bytes to skip), raw or gzip. */
static iso_status take_file(iso_volume_source *source, NrrdIoState *io, iso_error *err)
{
    off_t at = ftello(io->dataFile);
    struct stat st;
    if (at < 0 || fstat(fileno(io->dataFile), &st) != 0)
        return iso_fail(err, ISO_E_IO, "%s: the samples cannot be read", source->path);
    source->swap_bytes = iso_type_bytes(iso_source_stored_type(source)) > 1 && io->endian != airEndianUnknown &&
                         io->endian != airMyEndian();
    if (io->encoding == nrrdEncodingRaw) {
        source->file = io->dataFile;
        io->dataFile = NULL;
        return iso_source_check_bytes(source, (double)(st.st_size - at), err);
    }
    NEED(iso_source_check_packed(source, source->path, (double)(st.st_size - at), ISO_SOURCE_DEFLATE_MOST, err));
    int fd = dup(fileno(io->dataFile));
    fclose(io->dataFile); /* before the seek: both have one offset, which closing may set (POSIX; glibc of late) */
    io->dataFile = NULL;
    source->gz = fd >= 0 && lseek(fd, at, SEEK_SET) == at ? gzdopen(fd, "rb") : NULL;
    if (!source->gz)
        return iso_fail(err, ISO_E_IO, "%s: the samples cannot be read", source->path);
    gzbuffer(source->gz, 1 << 18);
    const bool is_plain = gzdirect(source->gz);
    int code;
    gzerror(source->gz, &code);
    if (code == Z_ERRNO)
        return iso_fail(err, iso_errno_status(), "%s: the samples cannot be read: %s", source->path, strerror(errno));
    if (is_plain)
        return iso_fail(err, ISO_E_FORMAT, "%s: the samples are not gzip data, unlike the header's encoding",
                        source->path);
    if (io->byteSkip > 0 && gzseek(source->gz, io->byteSkip, SEEK_SET) < 0)
        return iso_fail(err, ISO_E_FORMAT, "%s: fewer compressed samples than the %ld bytes to skip", source->path,
                        io->byteSkip);
    return ISO_OK;
}

/* Returns the most bytes of samples per byte of the file. */
static double most_of(const NrrdEncoding *encoding)
{
    /* The shortest text is a digit and a space for a double. A block of bzip2 takes more than 32 bytes, and holds 900
     * 000 after a first pass that makes 5 of 255 equal ones. */
    return encoding == nrrdEncodingAscii || encoding == nrrdEncodingHex ? 4.0
           : encoding == nrrdEncodingBzip2                              ? 900000.0 / 5 * 255 / 32
           : encoding == nrrdEncodingGzip                               ? ISO_SOURCE_DEFLATE_MOST
                                                                        : 1.0;
}

/* Loads text encodings, bzip2 and lists of files by teem, at once. Refuses impossible sizes before allocating memory.
 * listed_bytes: of the files that the header names; below 0: the samples follow the header. */
static iso_status load_by_teem(iso_volume_source *source, const NrrdIoState *io, double listed_bytes, iso_error *err)
{
    struct stat st;
    const double there = listed_bytes >= 0                                       ? listed_bytes
                         : io->dataFile && fstat(fileno(io->dataFile), &st) == 0 ? (double)st.st_size
                                                                                 : 0;
    if ((double)iso_source_bytes(source) > most_of(io->encoding) * there + 8)
        return iso_fail(err, ISO_E_FORMAT,
                        "%s: truncated: %.0f bytes of %s cannot hold the %zu bytes of samples that the sizes need",
                        source->path, there,
                        io->encoding == nrrdEncodingAscii || io->encoding == nrrdEncodingHex ? "text"
                                                                                             : io->encoding->name,
                        iso_source_bytes(source));
    iso_status status = io->encoding == nrrdEncodingAscii ? nrrd_check_words(source->path, io->dataFile, err) : ISO_OK;
    if (status != ISO_OK)
        return status;
    Nrrd *nrrd = nrrdNew();
    NEED_MEMORY(nrrd, err, "%s: no memory to read it", source->path);
    errno = 0;
    if (nrrdLoad(nrrd, source->path, NULL) != 0)
        status = teem_failed(source->path, nrrd, err);
    if (status == ISO_OK) {
        source->preloaded = nrrd->data;
        nrrd->data = NULL;
    }
    nrrdNuke(nrrd);
    return status;
}

static iso_status open_nrrd(iso_volume_source *source, iso_error *err)
{
    double listed_bytes;
    NEED(nrrd_look_at_files(source->path, &listed_bytes, err));
    Nrrd *nrrd = nrrdNew();
    NrrdIoState *io = nrrdIoStateNew();
    if (!nrrd || !io) {
        nrrdNuke(nrrd);
        nrrdIoStateNix(io);
        return iso_fail(err, ISO_E_MEMORY, "%s: no memory to read it", source->path);
    }
    io->skipData = 1;
    io->keepNrrdDataFileOpen = 1;
    iso_status status = ISO_OK;
    errno = 0;
    if (nrrdLoad(nrrd, source->path, io) != 0)
        status = teem_failed(source->path, nrrd, err);
    else
        status = read_header(nrrd, source, err);
    if (status == ISO_OK) {
        bool streamed = io->encoding == nrrdEncodingRaw || io->encoding == nrrdEncodingGzip;
        status = streamed && io->dataFile ? take_file(source, io, err) : load_by_teem(source, io, listed_bytes, err);
    }
    if (io->dataFile)
        fclose(io->dataFile);
    io->dataFile = NULL;
    nrrdIoStateNix(io);
    nrrdNuke(nrrd);
    return status;
}

const iso_volume_format iso_volume_format_nrrd = {
    .name = "nrrd",
    .title = "NRRD",
    .summary = "attached or detached header; raw and gzip plane by plane, other encodings at once",
    .suffixes = ".nrrd .nhdr",
    .starts = "\"NRRD000N\"",
    .marks = {ISO_MARK(0, "NRRD")},
    .open = open_nrrd,
};
