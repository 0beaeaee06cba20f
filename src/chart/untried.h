/* SPDX-License-Identifier: MIT */
/* untried.h - values of the axes that a chart had no time for: "level 2", "step 0.5". */
#pragma once

#include "chart/result.h"

/* Values for which no setting was measured. */
enum { ISO_CHART_MAX_TAGS = 64, ISO_CHART_TAG_BYTES = 96 };
typedef struct iso_chart_tags {
    size_t count;
    char tags[ISO_CHART_MAX_TAGS][ISO_CHART_TAG_BYTES];
} iso_chart_tags;

/* Allocates the list. ISO_E_MEMORY. */
iso_status iso_chart_find_untried(const iso_chart_result *r, iso_chart_tags **untried);
void iso_chart_free_untried(iso_chart_tags *untried); /* accepts NULL */
