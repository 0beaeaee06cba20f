/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "volume/input.h"

#include <stdio.h>

#include "base/words.h"
#include "volume/labels.h"
#include "volume/unit.h"

char *iso_volume_input_line(const iso_volume_input *in)
{
    const struct {
        const char *option, *value;
    } words[] = {{"--raw-size", in->raw_size}, {"--raw-type", in->raw_type}, {"--raw-spacing", in->raw_spacing},
                 {"--spacing", in->spacing},   {"--unit", in->unit},         {"--series", in->series},
                 {"--frame", in->frame},       {"--channel", in->channel},   {"--no-data", in->no_data}};
    char *text = NULL;
    size_t size = 0;
    FILE *f = open_memstream(&text, &size);
    if (!f)
        return NULL;
    for (size_t i = 0; i < sizeof words / sizeof *words; ++i)
        if (words[i].value) {
            fprintf(f, " %s ", words[i].option);
            iso_words_put_quoted(f, words[i].value);
        }
    if (in->raw_big_endian)
        fputs(" --raw-big-endian", f);
    if (in->raw_skip_bytes)
        fprintf(f, " --raw-skip %ld", in->raw_skip_bytes);
    if (in->stored)
        fputs(" --stored", f);
    if (in->resample)
        fputs(" --resample", f);
    if (in->force_spacing)
        fputs(" --force-spacing", f);
    if (in->labels)
        fputs(" --labels", f);
    if (in->no_labels)
        fputs(" --no-labels", f);
    fclose(f);
    return text;
}

static bool is_raw(const iso_volume_input *in)
{
    return in->raw_size || in->raw_type || in->raw_spacing || in->raw_big_endian || in->raw_skip_bytes;
}

/* Reads the option's three numbers, in the unit that --unit names, and converts them to mm. */
static iso_status parse_spacing(const char *option, const char *text, double unit_mm, double spacing_mm[3],
                                iso_error *err)
{
    NEED(iso_words_parse_numbers(text, option, spacing_mm, err));
    for (int a = 0; a < 3; ++a) {
        NEED(iso_words_check_range(option, spacing_mm[a], ISO_LEAST_MM, ISO_MOST_MM, err));
        spacing_mm[a] *= unit_mm;
    }
    return ISO_OK;
}

static iso_status parse_hints(const iso_volume_input *in, iso_volume_hints *hints, double *unit_mm, iso_error *err)
{
    *hints = (iso_volume_hints){.series = in->series,
                                .frame = in->frame,
                                .channel = in->channel,
                                .takes_first = in->takes_first};
    hints->uneven = in->resample ? ISO_UNEVEN_RESAMPLE : in->force_spacing ? ISO_UNEVEN_FORCE : ISO_UNEVEN_REFUSE;
    if (in->resample && in->force_spacing)
        return iso_fail(err, ISO_E_USAGE, "--resample and --force-spacing: one or the other");
    *unit_mm = 1;
    if (in->unit)
        NEED(iso_unit_parse("--unit", in->unit, unit_mm, &hints->unit, err));
    if (in->spacing)
        NEED(parse_spacing("--spacing", in->spacing, *unit_mm, hints->spacing_mm, err));
    return iso_no_data_parse(in->no_data, &hints->no_data, err);
}

static iso_status parse_layout(const iso_volume_input *in, const iso_volume_hints *hints, double unit_mm,
                               iso_raw_layout *layout, iso_error *err)
{
    *layout = (iso_raw_layout){.spacing_mm = {unit_mm, unit_mm, unit_mm}, .big_endian = in->raw_big_endian};
    for (int a = 0; a < 3 && hints->spacing_mm[a] > 0; ++a)
        layout->spacing_mm[a] = hints->spacing_mm[a];
    if (!in->raw_size || !in->raw_type)
        return iso_fail(err, ISO_E_USAGE, "a raw volume needs both --raw-size and --raw-type");
    NEED(iso_words_parse_sizes(in->raw_size, "--raw-size", layout->size, err));
    if (iso_file_type_from_name(in->raw_type, &layout->type, &layout->form, err) != ISO_OK)
        return iso_fail_in(err, ISO_E_USAGE, "--raw-type");
    if (in->raw_spacing)
        NEED(parse_spacing("--raw-spacing", in->raw_spacing, unit_mm, layout->spacing_mm, err));
    NEED(iso_words_check_range("--raw-skip", (double)in->raw_skip_bytes, 0, 1e15, err));
    layout->skip_bytes = (size_t)in->raw_skip_bytes;
    layout->no_data = hints->no_data;
    return ISO_OK;
}

static iso_status open_stored(const char *path, const iso_volume_input *in, iso_volume_source **source, iso_error *err)
{
    iso_raw_layout layout;
    iso_volume_hints hints;
    double unit_mm;
    NEED(parse_hints(in, &hints, &unit_mm, err));
    if (!is_raw(in))
        return iso_source_open_with(path, &hints, source, err);
    if (in->series)
        return iso_fail(err, ISO_E_USAGE, "%s: a raw file is one volume, --series %s names none of several", path,
                        in->series);
    NEED(parse_layout(in, &hints, unit_mm, &layout, err));
    return iso_source_open_raw(path, &layout, source, err);
}

iso_status iso_volume_input_open(const char *path, const iso_volume_input *in, iso_volume_source **source,
                                 iso_error *err)
{
    *source = NULL;
    NEED(open_stored(path, in, source, err));
    if (!in->stored)
        iso_source_apply_scale(*source);
    return ISO_OK;
}

/* Checks all that needs no look at the samples; *look: a look is needed. */
static iso_status check_labels(const char *path, const iso_volume_input *in, const iso_volume *v, bool *look,
                               iso_error *err)
{
    const iso_type type = v->type;
    const bool is_integer = type != ISO_F32 && type != ISO_F64;
    *look = is_integer && !in->no_labels;
    if (in->labels && in->no_labels)
        return iso_fail(err, ISO_E_USAGE, "--labels and --no-labels: one or the other");
    if (in->labels && !is_integer)
        return iso_fail(err, ISO_E_USAGE, "--labels: %s has values of type %s, labels are integers", path,
                        iso_type_name(type));
    return ISO_OK;
}

/* Sets the number of labels, 0: no label map. said: the caller or the file marks it as a label map. */
static iso_status count_labels(const char *path, bool said, const iso_label_facts *facts, size_t *count, iso_error *err)
{
    *count = facts->is_map || said ? facts->count : 0; /* 0 also if the samples were not examined */
    if (said && facts->has_too_many)
        return iso_fail(err, ISO_E_RANGE,
                        "%s: a label map, but with more than %d values (--no-labels reads intensities)", path,
                        ISO_LABELS_MAX_COUNT);
    return ISO_OK;
}

iso_status iso_volume_input_look(const char *path, const iso_volume_input *in, size_t *count, iso_label_facts *facts,
                                 iso_error *err)
{
    ENDED_BY(iso_source_close_owned) iso_volume_source *source = NULL;
    bool look = false;
    *count = 0;
    *facts = (iso_label_facts){0};
    NEED(iso_volume_input_open(path, in, &source, err));
    const bool said = in->labels || iso_source_volume(source)->notes.says_labels;
    NEED(check_labels(path, in, iso_source_volume(source), &look, err));
    if (look)
        NEED(iso_labels_look(source, said, facts, err));
    return count_labels(path, said, facts, count, err);
}

iso_status iso_volume_input_labels(const char *path, const iso_volume_input *in, size_t *count, iso_error *err)
{
    iso_label_facts facts;
    NEED(iso_volume_input_look(path, in, count, &facts, err));
    if (*count > 0 && facts.is_far)
        return iso_fail(err, ISO_E_RANGE,
                        "%s: labels of %.0f to %.0f, those of a pyramid have 16 bits; render, view and export number "
                        "them",
                        path, facts.value[0], facts.value[facts.count - 1]);
    return ISO_OK;
}

static iso_status note_labels(const char *path, const iso_volume_input *in, iso_volume *v, iso_error *err)
{
    iso_label_facts facts = {0};
    const bool said = in->labels || v->notes.says_labels;
    bool look = false;
    NEED(check_labels(path, in, v, &look, err));
    if (look)
        NEED(iso_labels_look_at(v, said, &facts, err));
    NEED(count_labels(path, said, &facts, &v->notes.label_count, err));
    if (v->notes.label_count > 0 && facts.is_sparse)
        iso_labels_number(v, &facts);
    return ISO_OK;
}

iso_status iso_volume_input_load_source(iso_volume_source *source, const char *path, const iso_volume_input *in,
                                        iso_volume *v, iso_error *err)
{
    *v = (iso_volume){0};
    iso_status status = iso_volume_load_source(source, path, v, err);
    TRY(status, note_labels(path, in, v, err));
    if (status != ISO_OK)
        iso_volume_destroy(v);
    return status;
}

iso_status iso_volume_input_load(const char *path, const iso_volume_input *in, iso_volume *v, iso_error *err)
{
    iso_volume_source *source;
    *v = (iso_volume){0};
    NEED(iso_volume_input_open(path, in, &source, err));
    return iso_volume_input_load_source(source, path, in, v, err);
}
