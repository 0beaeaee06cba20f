/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "volume/frames_all.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static iso_status measure_planes(const char *path, iso_volume_source *source, double range[2], bool *has_no_data,
                                 iso_error *err)
{
    iso_volume plane = *iso_source_volume(source);
    const size_t planes = plane.geometry.size[2];
    plane.geometry.size[2] = 1;
    FREED void *samples = plane.data = malloc(plane.geometry.size[0] * plane.geometry.size[1] *
                                              iso_type_bytes(plane.type));
    NEED_MEMORY(samples, err, "%s: no memory for a plane", path);
    for (size_t z = 0; z < planes; ++z) {
        NEED(iso_source_read(source, 1, plane.data, err));
        const iso_volume_stats s = iso_volume_measure(&plane);
        range[0] = fmin(range[0], s.min);
        range[1] = fmax(range[1], s.max);
        *has_no_data = *has_no_data || s.no_data_count > 0;
        if (s.nonfinite_count > 0)
            return iso_fail(err, ISO_E_RANGE, "%s: voxels of plane %zu are NaN or infinite, none may be", path, z);
    }
    return ISO_OK;
}

iso_status iso_frames_measure(const char *path, const iso_volume_input *input, iso_frames_facts *facts, iso_error *err)
{
    double most = -1;
    *facts = (iso_frames_facts){.count = 1, .range = {INFINITY, -INFINITY}};
    for (size_t k = 0; k < facts->count; ++k) {
        char number[24];
        double range[2] = {INFINITY, -INFINITY};
        ENDED_BY(iso_source_close_owned) iso_volume_source *source = NULL;
        iso_volume_input one = *input;
        snprintf(number, sizeof number, "%zu", k);
        one.frame = number;
        NEED(iso_volume_input_open(path, &one, &source, err));
        facts->count = iso_source_volume(source)->notes.frame_count;
        if (facts->count <= 1)
            return iso_fail(err, ISO_E_USAGE, "%s: has one frame, --frames all is for several", path);
        NEED(measure_planes(path, source, range, &facts->has_no_data, err));
        if (!(range[0] <= range[1]))
            return iso_fail(err, ISO_E_RANGE, "%s: frame %zu has no voxel with data, each must have some", path, k);
        if (range[1] - range[0] > most) {
            most = range[1] - range[0];
            facts->widest = k;
        }
        facts->range[0] = fmin(facts->range[0], range[0]);
        facts->range[1] = fmax(facts->range[1], range[1]);
    }
    return ISO_OK;
}

iso_status iso_frames_labels(const char *path, const iso_volume_input *input, size_t *count, iso_error *err)
{
    size_t frames = 1, with = 0, without = 0;
    *count = 0;
    for (size_t k = 0; k < frames; ++k) {
        char number[24];
        size_t labels = 0;
        iso_volume_input one = *input;
        snprintf(number, sizeof number, "%zu", k);
        one.frame = number;
        if (k == 0) {
            iso_volume_source *source;
            NEED(iso_volume_input_open(path, &one, &source, err));
            frames = iso_source_volume(source)->notes.frame_count;
            iso_source_close(source);
        }
        iso_label_facts facts;
        NEED(iso_volume_input_look(path, &one, &labels, &facts, err));
        if (labels > 0 && facts.is_sparse)
            return iso_fail(err, ISO_E_RANGE,
                            "%s: labels of %.0f to %.0f would get other numbers in each frame; choose one by --frame",
                            path, facts.value[0], facts.value[facts.count - 1]);
        *(labels ? &with : &without) = k + 1;
        *count = labels > *count ? labels : *count;
    }
    if (with && without && !input->labels)
        return iso_fail(err, ISO_E_USAGE,
                        "%s: frame %zu looks like a label map, frame %zu does not; use --labels or --no-labels", path,
                        with - 1, without - 1);
    return ISO_OK;
}

char *iso_frames_name(const char *output, const char *suffix, size_t frame)
{
    const char *place = strchr(output, '%'), *end = strrchr(output, '.');
    const size_t digits = place ? 1 + strspn(place + 1, "0123456789") : 0;
    char *name = NULL;
    int n;
    if (place && place[digits] == 'd')
        n = asprintf(&name, "%.*s%04zu%s", (int)(place - output), output, frame, place + digits + 1);
    else if (end && *suffix && strcmp(end, suffix) == 0)
        n = asprintf(&name, "%.*s_%04zu%s", (int)(end - output), output, frame, suffix);
    else
        n = asprintf(&name, "%s_%04zu%s", output, frame, suffix);
    return n < 0 ? NULL : name;
}
