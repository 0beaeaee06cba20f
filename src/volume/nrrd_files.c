/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "volume/nrrd_files.h"

#include <errno.h>
#include <limits.h>
#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>
#include <sys/types.h>

#include "base/file.h"
#include "base/inputs.h"
#include "base/words.h"

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
    if (++l->count > ISO_NRRD_MOST_FILES)
        return iso_fail(err, ISO_E_RANGE, "%s: names more than %d data files", l->path, ISO_NRRD_MOST_FILES);
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
    if (count > ISO_NRRD_MOST_FILES)
        return iso_fail(err, ISO_E_RANGE, "%s: names %.0f data files, at most %d", l->path, count, ISO_NRRD_MOST_FILES);
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

iso_status iso_nrrd_look_at_files(const char *path, double *bytes, iso_error *err)
{
    look l = {.path = path};
    bool any = false;
    NEED(look_through(&l, &any, err));
    *bytes = any ? l.bytes : -1;
    return ISO_OK;
}

iso_status iso_nrrd_check_words(const char *path, FILE *file, iso_error *err)
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
