/* SPDX-License-Identifier: MIT */
#include "volume/segments.h"

#include <string.h>
#include <strings.h>

#include "base/words.h"

json_t *iso_segments_text(const char *text)
{
    char copy[128];
    size_t n = 0;
    for (; text[n] && n + 1 < sizeof copy; ++n)
        copy[n] = text[n];
    if (text[n]) /* whole characters */
        while (n > 0 && ((unsigned char)text[n] & 0xC0) == 0x80)
            --n;
    copy[n] = 0;
    for (size_t i = 0; i < n; ++i)
        memset(copy + i, '_', iso_words_control(copy + i));
    json_t *json = json_string(copy);
    for (size_t i = 0; !json && i < n; ++i)
        copy[i] = (unsigned char)copy[i] >= 128 ? '_' : copy[i];
    return json ? json : json_string(copy);
}

static void check_segment(iso_json_reader *r, size_t number, const json_t *segment)
{
    const json_t *label = json_object_get(segment, "label");
    const char *name;
    double color[3];
    if (!json_is_object(segment))
        r->status = iso_fail(r->err, ISO_E_FORMAT, "%s: \"segments\": entry %zu is not an object", r->path, number);
    else if (!json_is_integer(label) || json_integer_value(label) < ISO_SEGMENTS_LABEL_MIN ||
             json_integer_value(label) > ISO_SEGMENTS_LABEL_MAX)
        r->status = iso_fail(r->err, ISO_E_FORMAT,
                             "%s: \"label\" of entry %zu of \"segments\": no whole number, %ld to %ld", r->path, number,
                             ISO_SEGMENTS_LABEL_MIN, ISO_SEGMENTS_LABEL_MAX);
    iso_json_get_string(r, segment, "name", true, &name);
    iso_json_get_numbers(r, segment, "color", false, &(iso_json_list){color, 3, 0, 1});
}

void iso_segments_check(iso_json_reader *r, const json_t *segments)
{
    for (size_t i = 0; i < json_array_size(segments) && r->status == ISO_OK; ++i)
        check_segment(r, i, json_array_get(segments, i));
}

const json_t *iso_segments_find(const json_t *segments, long label)
{
    for (size_t i = 0; i < json_array_size(segments); ++i) {
        const json_t *segment = json_array_get(segments, i);
        if (json_integer_value(json_object_get(segment, "label")) == label)
            return segment;
    }
    return NULL;
}

static const char *name_of(const json_t *segment)
{
    const char *name = json_string_value(json_object_get(segment, "name"));
    return name ? name : "";
}

const char *iso_segments_name(const json_t *segments, long label)
{
    return name_of(iso_segments_find(segments, label));
}

bool iso_segments_color(const json_t *segments, long label, double srgb[3])
{
    const json_t *color = json_object_get(iso_segments_find(segments, label), "color");
    for (size_t c = 0; c < 3; ++c)
        srgb[c] = json_number_value(json_array_get(color, c));
    return json_array_size(color) == 3;
}

static size_t layer_of(const json_t *segment)
{
    return (size_t)json_integer_value(json_object_get(segment, "layer"));
}

bool iso_segments_layer(const json_t *segments, const char *name, size_t *layer)
{
    for (size_t i = 0; i < json_array_size(segments); ++i) {
        const json_t *segment = json_array_get(segments, i);
        if (strcasecmp(name_of(segment), name) == 0) {
            *layer = layer_of(segment);
            return true;
        }
    }
    return false;
}

void iso_segments_list_layers(const json_t *segments, size_t layer_count, char *text, size_t size)
{
    *text = 0;
    for (size_t layer = 0; layer < layer_count && strlen(text) + 2 < size; ++layer) { /* until the text is full */
        size_t found = 0;
        iso_words_append(text, size, "%s%zu (", layer ? ", " : "", layer);
        for (size_t i = 0; i < json_array_size(segments); ++i)
            if (layer_of(json_array_get(segments, i)) == layer)
                iso_words_append(text, size, "%s%s", found++ ? ", " : "", name_of(json_array_get(segments, i)));
        iso_words_append(text, size, ")");
    }
}

json_t *iso_segments_of_layer(const json_t *segments, size_t layer)
{
    json_t *list = json_array();
    for (size_t i = 0; i < json_array_size(segments); ++i) {
        json_t *segment = json_array_get(segments, i);
        if (layer_of(segment) != layer)
            continue;
        json_t *copy = json_copy(segment);
        json_object_del(copy, "layer");
        json_array_append_new(list, copy);
    }
    if (json_array_size(list) > 0)
        return list;
    json_decref(list);
    return NULL;
}
