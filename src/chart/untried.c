/* SPDX-License-Identifier: MIT */
#include "chart/untried.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static bool has_tag(const iso_chart_tags *l, const char *tag)
{
    for (size_t i = 0; i < l->count; ++i)
        if (strcmp(l->tags[i], tag) == 0)
            return true;
    return false;
}

static void add_tags(const iso_chart_case *c, const iso_chart_tags *without, iso_chart_tags *l)
{
    char tags[6][ISO_CHART_TAG_BYTES];
    iso_chart_describe_series(c, tags[0], ISO_CHART_TAG_BYTES);
    snprintf(tags[1], ISO_CHART_TAG_BYTES, "level %zu", c->level);
    snprintf(tags[2], ISO_CHART_TAG_BYTES, "step %g", c->step_voxels);
    snprintf(tags[3], ISO_CHART_TAG_BYTES, "filter %s", iso_direction_filter_name(c->filter));
    snprintf(tags[4], ISO_CHART_TAG_BYTES, "estimator %s", iso_gradient_name(c->estimator));
    snprintf(tags[5], ISO_CHART_TAG_BYTES, "%s%s",
             c->preintegrated ? "pre-integration"
             : c->level > 0   ? "TF "
                              : "midpoints",
             !c->preintegrated && c->level > 0 ? iso_chart_name_tf(c) : "");
    for (size_t i = 0; i < 6; ++i)
        if (l->count < ISO_CHART_MAX_TAGS && !has_tag(l, tags[i]) && !(without && has_tag(without, tags[i])))
            memcpy(l->tags[l->count++], tags[i], ISO_CHART_TAG_BYTES);
}

iso_status iso_chart_find_untried(const iso_chart_result *r, iso_chart_tags **untried)
{
    iso_chart_tags *lists = calloc(2, sizeof *lists);
    *untried = lists ? lists + 1 : NULL;
    for (size_t i = 0; lists && i < r->count; ++i)
        add_tags(&r->cases[i], i < r->done_count ? NULL : &lists[0], &lists[i < r->done_count ? 0 : 1]);
    return lists ? ISO_OK : ISO_E_MEMORY;
}

void iso_chart_free_untried(iso_chart_tags *untried)
{
    if (untried)
        free(untried - 1);
}
