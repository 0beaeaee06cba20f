/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "volume/input.h"

#include <stdio.h>

#include "base/words.h"

void iso_volume_input_defaults(iso_volume_input *input)
{
    *input = (iso_volume_input){0};
}

char *iso_volume_input_line(const iso_volume_input *in)
{
    const struct {
        const char *option, *value;
    } words[] = {{"--raw-size", in->raw_size}, {"--raw-type", in->raw_type}, {"--raw-spacing", in->raw_spacing}};
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
    if (in->physical)
        fputs(" --physical", f);
    fclose(f);
    return text;
}

static bool is_raw(const iso_volume_input *in)
{
    return in->raw_size || in->raw_type || in->raw_spacing || in->raw_big_endian || in->raw_skip_bytes;
}

static iso_status parse_layout(const iso_volume_input *in, iso_raw_layout *layout, iso_error *err)
{
    *layout = (iso_raw_layout){.spacing_mm = {1, 1, 1}, .big_endian = in->raw_big_endian};
    if (!in->raw_size || !in->raw_type)
        return iso_fail(err, ISO_E_USAGE, "a raw volume needs both --raw-size and --raw-type");
    iso_status status = iso_words_parse_sizes(in->raw_size, "--raw-size", layout->size, err);
    if (status == ISO_OK && iso_type_from_name(in->raw_type, &layout->type, err) != ISO_OK)
        status = iso_fail_in(err, ISO_E_USAGE, "--raw-type");
    if (status == ISO_OK && in->raw_spacing)
        status = iso_words_parse_numbers(in->raw_spacing, "--raw-spacing", layout->spacing_mm, err);
    for (int a = 0; status == ISO_OK && a < 3; ++a)
        status = iso_words_check_range("--raw-spacing", layout->spacing_mm[a], 1e-9, 1e9, err);
    if (status == ISO_OK)
        status = iso_words_check_range("--raw-skip", (double)in->raw_skip_bytes, 0, 1e15, err);
    layout->skip_bytes = (size_t)in->raw_skip_bytes;
    return status;
}

static iso_status open_stored(const char *path, const iso_volume_input *in, iso_volume_source **source, iso_error *err)
{
    iso_raw_layout layout;
    if (!is_raw(in))
        return iso_source_open(path, source, err);
    iso_status status = parse_layout(in, &layout, err);
    return status == ISO_OK ? iso_source_open_raw(path, &layout, source, err) : status;
}

iso_status iso_volume_input_open(const char *path, const iso_volume_input *in, iso_volume_source **source,
                                 iso_error *err)
{
    *source = NULL;
    iso_status status = open_stored(path, in, source, err);
    if (status == ISO_OK && in->physical)
        iso_source_apply_scale(*source);
    return status;
}

iso_status iso_volume_input_load(const char *path, const iso_volume_input *in, iso_volume *v, iso_error *err)
{
    iso_volume_source *source;
    *v = (iso_volume){0};
    iso_status status = iso_volume_input_open(path, in, &source, err);
    return status == ISO_OK ? iso_volume_load_source(source, path, v, err) : status;
}
