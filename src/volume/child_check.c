/* SPDX-License-Identifier: MIT */
#include "volume/child_check.h"

#include <math.h>

#define END_TEXT(text) ((text)[sizeof(text) - 1] = 0)

void iso_child_end_text(iso_child_answer *answer)
{
    END_TEXT(answer->error.text);
}

void iso_child_end_texts(iso_child_header *h)
{
    END_TEXT(h->version);
    iso_child_end_text(&h->answer);
    for (int r = 0; r < 3; ++r)
        END_TEXT(h->unit[r]);
    for (int c = 0; c < ISO_CHILD_CHANNELS; ++c)
        END_TEXT(h->channel_name[c]);
    for (int s = 0; s < ISO_CHILD_SEGMENTS; ++s)
        END_TEXT(h->segment[s].name);
    END_TEXT(h->value_unit);
    END_TEXT(h->frame_unit);
    END_TEXT(h->unspaced);
    END_TEXT(h->warning);
}

/* True for a status that a reader may have: not of a comparison or a renderer. */
static bool is_known(iso_status status)
{
    return status >= ISO_E_USAGE && status <= ISO_E_PROGRAM;
}

iso_status iso_child_check_answer(const iso_child_answer *answer, const char *path, const char *library, iso_error *err)
{
    if (answer->status == ISO_OK)
        return ISO_OK;
    if (is_known(answer->status) && answer->error.text[0])
        return iso_fail(err, answer->status, "%s", answer->error.text);
    return iso_fail(err, ISO_E_FORMAT, "%s: damaged: %s fails with status %d and reports \"%s\"", path, library,
                    (int)answer->status, answer->error.text);
}

static bool is_type(iso_type type)
{
    switch (type) {
#define ISO_TYPE_CASE(name, text, ctype) case name:
        ISO_TYPE_LIST(ISO_TYPE_CASE)
#undef ISO_TYPE_CASE
        return true;
    }
    return false;
}

static bool is_world(iso_child_world world)
{
    return world == ISO_CHILD_LPS || world == ISO_CHILD_RAS || world == ISO_CHILD_OWN || world == ISO_CHILD_CENTERED;
}

/* True if the box lies in the grid; 0 stands for the grid's size. */
static bool has_box(const iso_child_header *h)
{
    bool good = true;
    for (int a = 0; a < 3; ++a)
        good = good && h->box[a] >= 0 && h->box[a] <= (double)h->size[a];
    return good;
}

iso_status iso_child_check_header(const iso_child_header *h, const char *path, const char *library, iso_error *err)
{
    size_t volumes;
    if (!is_type(h->type))
        return iso_fail(err, ISO_E_FORMAT, "%s: damaged: %s names samples of type %d, which there is not", path,
                        library, (int)h->type);
    if (!is_world(h->world))
        return iso_fail(err, ISO_E_FORMAT, "%s: damaged: %s names axes of kind %d, which there is not", path, library,
                        (int)h->world);
    if (!isfinite(h->slope) || !isfinite(h->intercept))
        return iso_fail(err, ISO_E_FORMAT, "%s: damaged: slope %g and intercept %g, which have to be finite", path,
                        h->slope, h->intercept);
    if (!has_box(h))
        return iso_fail(err, ISO_E_FORMAT, "%s: damaged: a box of %g x %g x %g voxels in a grid of %zu x %zu x %zu",
                        path, h->box[0], h->box[1], h->box[2], h->size[0], h->size[1], h->size[2]);
    if (__builtin_mul_overflow(h->frames, h->channels, &volumes))
        return iso_fail(err, ISO_E_FORMAT, "%s: damaged: %zu frames of %zu channels cannot be counted", path, h->frames,
                        h->channels);
    return ISO_OK;
}
