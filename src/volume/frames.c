/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "volume/frames.h"

#include <ctype.h>
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "base/words.h"
#include "volume/segments.h"
#include "volume/stream_kernel.h"

/* As many as bytes have: fewer are seen in a picture. */
enum { LEAST_STEPS = 256 };

/* Of red, green and blue in luminance: [itu-bt709], of the values as they are stored. */
static const double luminance_weights[3] = {0.2126, 0.7152, 0.0722};

static const char *const color_names[4] = {"red", "green", "blue", "alpha"};

static const char *channel_name(const iso_extra_axes *axes, size_t channel)
{
    if (channel < ISO_NAMED_CHANNELS && axes->channel_name[channel][0])
        return axes->channel_name[channel];
    return axes->is_color && channel < 4 ? color_names[channel] : "";
}

/* Reads a whole number below `count`. False if the text is another. */
static bool read_index(const char *text, size_t count, size_t *index)
{
    char *end;
    const unsigned long long value = strtoull(text, &end, 10);
    *index = (size_t)value;
    return isdigit((unsigned char)*text) && *end == 0 && value < count;
}

/* Writes " (2.5 s apart)", or "" if the step is not known. */
static void describe_step(double step, const char *unit, char *text, size_t size)
{
    *text = 0;
    if (step > 0)
        snprintf(text, size, " (%g%s%s apart)", step, *unit ? " " : "", unit);
}

/* Chooses a layer of segments that overlap, by number or by a segment's name. */
static iso_status choose_layer(const char *path, const iso_volume_hints *hints, const iso_extra_axes *axes,
                               size_t *layer, iso_error *err)
{
    const size_t count = axes->frame.count;
    char list[320];
    if (hints->frame && iso_segments_layer(axes->layers, hints->frame, layer) && *layer < count)
        return ISO_OK;
    *layer = 0;
    if (!hints->frame && (count == 1 || hints->takes_first))
        return ISO_OK;
    iso_segments_list_layers(axes->layers, count, list, sizeof list);
    if (hints->frame)
        return iso_fail(err, ISO_E_USAGE, "%s: --frame is \"%s\", there are %zu layers of segments: %s", path,
                        hints->frame, count, list);
    return iso_fail(
        err, ISO_E_USAGE,
        "%s: has %zu layers of segments, which overlap; --frame chooses one by number or by a segment's name: %s", path,
        count, list);
}

iso_status iso_frames_choose(const char *path, const iso_volume_hints *hints, const iso_extra_axes *axes, size_t *frame,
                             iso_error *err)
{
    const size_t count = axes->frame.count;
    char step[64];
    *frame = 0;
    if (hints->frame && read_index(hints->frame, count, frame))
        return ISO_OK;
    if (axes->layers)
        return choose_layer(path, hints, axes, frame, err);
    describe_step(axes->frame_step, axes->frame_unit, step, sizeof step);
    if (hints->frame)
        return iso_fail(err, ISO_E_USAGE, "%s: has %zu frame%s%s, numbered from 0 to %zu; --frame is \"%s\"", path, count,
                        iso_words_plural(count), step, count - 1, hints->frame);
    if (count == 1 || hints->takes_first)
        return ISO_OK;
    return iso_fail(
        err, ISO_E_USAGE,
        "%s: has %zu frames%s; --frame K chooses one, from 0 to %zu (build --frames all: a pyramid of each)", path,
        count, step, count - 1);
}

/* Writes "0 red, 1 green, 2 blue", or "0 to 2"; luminance if there is one. */
static void list_channels(const iso_extra_axes *axes, char *text, size_t size)
{
    enum { LISTED = 12 };
    const size_t count = axes->channel.count;
    *text = 0;
    if (count <= LISTED && *channel_name(axes, 0))
        for (size_t c = 0; c < count; ++c)
            iso_words_append(text, size, "%s%zu%s%s", c ? ", " : "", c, *channel_name(axes, c) ? " " : "",
                             channel_name(axes, c));
    else
        iso_words_append(text, size, count > 1 ? "0 to %zu" : "%zu", count - 1);
    if (axes->is_color)
        iso_words_append(text, size, ", luminance");
}

static iso_status choose_channel(const char *path, const iso_volume_hints *hints, const iso_extra_axes *axes,
                                 iso_source_choice *choice, iso_error *err)
{
    const size_t count = axes->channel.count;
    char list[640];
    choice->channel = 0;
    if (hints->channel && read_index(hints->channel, count, &choice->channel))
        return ISO_OK;
    for (size_t c = 0; hints->channel && c < count && c < ISO_NAMED_CHANNELS; ++c) /* no other has a name */
        if (strcasecmp(channel_name(axes, c), hints->channel) == 0 && *hints->channel) {
            choice->channel = c;
            return ISO_OK;
        }
    choice->channel = 0;
    choice->luminance = hints->channel && axes->is_color && count >= 3 &&
                        (axes->channel.inside || axes->gives_luminance) && strcmp(hints->channel, "luminance") == 0;
    if (choice->luminance || (!hints->channel && (count == 1 || hints->takes_first)))
        return ISO_OK;
    list_channels(axes, list, sizeof list);
    if (hints->channel)
        return iso_fail(err, ISO_E_USAGE, "%s: has %zu channel%s: %s; --channel is \"%s\"", path, count,
                        iso_words_plural(count), list, hints->channel);
    return iso_fail(err, ISO_E_USAGE, "%s: has %zu channels a voxel; --channel chooses one of them: %s", path, count,
                    list);
}

/* Counts this axis among those of its place. */
static void place(const iso_extra_axis *axis, size_t index, iso_source_choice *choice)
{
    size_t *count = axis->inside ? &choice->inside_count : &choice->volume_count;
    *(axis->inside ? &choice->inside_at : &choice->volume_at) += index * axis->stride;
    if (__builtin_mul_overflow(*count, axis->count, count))
        *count = SIZE_MAX;
}

static void take_notes(const iso_extra_axes *axes, const iso_source_choice *choice, iso_volume_notes *notes)
{
    notes->frame_count = axes->frame.count;
    notes->frame = choice->frame;
    notes->frame_step = axes->frame_step > 0 ? axes->frame_step : 0;
    iso_words_copy_line(axes->frame_unit, notes->frame_unit, sizeof notes->frame_unit);
    notes->channel_count = axes->channel.count;
    notes->channel = choice->channel;
    char list[sizeof notes->channel_list] = "";
    if (axes->channel.count > 1)
        list_channels(axes, list, sizeof list);
    iso_words_copy_line(list, notes->channel_list, sizeof notes->channel_list);
    iso_words_copy_line(choice->luminance ? "luminance" : channel_name(axes, choice->channel), notes->channel_name,
                        sizeof notes->channel_name);
}

iso_status iso_source_choose(iso_volume_source *source, const iso_extra_axes *given, iso_error *err)
{
    iso_extra_axes axes = *given;
    iso_source_choice choice = {.inside_count = 1, .volume_count = 1};
    axes.frame.count += axes.frame.count == 0;
    axes.channel.count += axes.channel.count == 0;
    NEED(iso_frames_choose(source->path, &source->hints, &axes, &choice.frame, err));
    NEED(choose_channel(source->path, &source->hints, &axes, &choice, err));
    place(&axes.frame, choice.frame, &choice);
    place(&axes.channel, choice.channel, &choice);
    source->choice = choice;
    take_notes(&axes, &choice, &source->header.notes);
    return ISO_OK;
}

/* ---- samples ---- */

bool iso_source_is_plain(const iso_volume_source *s)
{
    return s->choice.inside_count == 1 && !s->scaled && !s->form;
}

static void pick(const char *restrict cells, size_t sample_bytes, size_t stride, size_t count, char *restrict out)
{
    for (size_t i = 0; i < count; ++i)
        memcpy(out + i * sample_bytes, cells + i * stride * sample_bytes, sample_bytes);
}

static void convert_form(const iso_volume_source *s, const void *cells, size_t count, void *out)
{
    for (size_t i = 0; i < count; ++i) {
        const double value = iso_form_value(s->form, cells, i * s->choice.inside_count + s->choice.inside_at);
        if (s->header.type == ISO_F32)
            ((float *)out)[i] = (float)(s->slope * value + s->intercept);
        else if (s->header.type == ISO_I32)
            ((int32_t *)out)[i] = (int32_t)value;
        else if (s->header.type == ISO_U32)
            ((uint32_t *)out)[i] = (uint32_t)value;
        else
            ((double *)out)[i] = value;
    }
}

void iso_source_convert(const iso_volume_source *s, const void *cells, size_t count, void *out)
{
    const iso_source_choice *c = &s->choice;
    const size_t stride = c->inside_count;
    const double slope = s->slope, intercept = s->intercept;
    if (s->form) {
        convert_form(s, cells, count, out);
        return;
    }
    if (!s->scaled) {
        const size_t bytes = iso_type_bytes(s->header.type);
        pick((const char *)cells + c->inside_at * bytes, bytes, stride, count, out);
        return;
    }
    const double own[3] = {1, 0, 0}, *w = c->luminance ? luminance_weights : own;
    const size_t second = c->luminance ? 1 : 0, third = c->luminance ? 2 : 0;
/* clang-format off */
#define ISO_CONVERT_CASE(name, text, ctype)                                                            \
    case name:                                                                                         \
        for (size_t i = 0; i < count; ++i) {                                                           \
            const ctype *at = (const ctype *)cells + i * stride + c->inside_at;                        \
            const double value = w[0] * (double)at[0] + w[1] * (double)at[second] + w[2] * (double)at[third]; \
            ((float *)out)[i] = (float)(slope * value + intercept);                                    \
        }                                                                                              \
        break;
    /* clang-format on */
    switch (s->stored) {
        ISO_TYPE_LIST(ISO_CONVERT_CASE)
    }
#undef ISO_CONVERT_CASE
}

/* ---- checks while samples are read ---- */

void iso_source_note_fill(iso_volume_source *s, double value)
{
    iso_source_look *k = &s->look;
    /* In the file it is a sample. */
    const double as_stored = iso_source_stored_type(s) == ISO_F32 ? (double)(float)value : value;
    if (k->fill_count < ISO_SOURCE_FILLS && isfinite(value) && !s->hints.no_data.is_given)
        k->fill[k->fill_count++] = as_stored;
}

static void look_at_value(iso_volume_source *s, double slope, double intercept, double value)
{
    iso_source_look *k = &s->look;
    const iso_no_data *rule = &s->hints.no_data;
    const double given = slope * value + intercept;
    if (isnan(value) || (rule->is_given && !rule->is_none && given >= rule->lo && given <= rule->hi))
        return;
    for (size_t f = 0; f < k->fill_count; ++f)
        if (value == k->fill[f]) {
            k->least_fill = k->filled ? fmin(k->least_fill, value) : value;
            k->most_fill = k->filled ? fmax(k->most_fill, value) : value;
            ++k->filled;
            return;
        }
    k->lo = value < k->lo ? value : k->lo;
    k->hi = value > k->hi ? value : k->hi;
    k->is_rounded = k->is_rounded || (double)(float)given != given;
}

/* True if floats hold all samples exactly; these are examined only if some values stand for no data. */
static bool is_exact(const iso_volume_source *s)
{
    const iso_type stored = iso_source_stored_type(s);
    const bool is_small = stored != ISO_F64 && stored != ISO_U32 && stored != ISO_I32;
    return s->form == ISO_FORM_HALF || (is_small && (!s->scaled || (s->slope == 1 && s->intercept == 0)));
}

void iso_source_look_at(iso_volume_source *s, const void *cells, size_t count)
{
    const iso_source_choice *c = &s->choice;
    iso_source_look *k = &s->look;
    const double slope = s->scaled ? s->slope : 1, intercept = s->scaled ? s->intercept : 0;
    if (c->luminance || (k->fill_count == 0 && is_exact(s)))
        return;
    if (k->seen == 0)
        k->lo = INFINITY, k->hi = -INFINITY;
    k->seen += count;
    for (size_t i = 0; i < count && s->form; ++i)
        look_at_value(s, slope, intercept, iso_form_value(s->form, cells, i * c->inside_count + c->inside_at));
    if (s->form)
        return;
/* clang-format off */
#define ISO_LOOK_CASE(name, text, ctype)                                                                        \
    case name:                                                                                                  \
        for (size_t i = 0; i < count; ++i)                                                                      \
            look_at_value(s, slope, intercept, (double)((const ctype *)cells)[i * c->inside_count + c->inside_at]); \
        break;
    /* clang-format on */
    switch (iso_source_stored_type(s)) {
        ISO_TYPE_LIST(ISO_LOOK_CASE)
    }
#undef ISO_LOOK_CASE
}

iso_status iso_source_check_look(const iso_volume_source *s, iso_error *err)
{
    const iso_source_look *k = &s->look;
    const double slope = s->scaled ? s->slope : 1, intercept = s->scaled ? s->intercept : 0;
    const double a = slope * k->lo + intercept, b = slope * k->hi + intercept;
    if (s->only_looks || !(k->hi >= k->lo)) /* none, or all stand for none */
        return ISO_OK;
    const double most = fmax(fabs(a), fabs(b));
    if (most > (double)FLT_MAX)
        return iso_fail(err, ISO_E_RANGE, "%s: values of %g to %g, at most %g fits into a float; scale them before",
                        s->path, fmin(a, b), fmax(a, b), (double)FLT_MAX);
    const double step = (double)(nextafterf((float)most, INFINITY) - (float)most);
    if (k->is_rounded && a != b && fabs(b - a) < LEAST_STEPS * step)
        return iso_fail(
            err, ISO_E_RANGE,
            "%s: values of %.15g to %.15g are floats here, %g apart, which leaves fewer than %d steps of a range of %g; "
            "subtract an offset before",
            s->path, fmin(a, b), fmax(a, b), step, LEAST_STEPS, fabs(b - a));
    return ISO_OK;
}
