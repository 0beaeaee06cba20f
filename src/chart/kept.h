/* SPDX-License-Identifier: MIT */
/* kept.h - what a chart has measured, kept while it works, so that an interrupted one goes on (--resume).
 *
 *     .DIR.partial/settings.jsonl       a line with the chart's key (base/key.h), then a line a setting, written when it is
 *                                       measured; of several lines of one setting the last counts
 *                  reference-SCENE.exr  what errors are measured against
 *
 * When the chart is finished the folder becomes DIR, with these files in it, so that a finished chart goes on as well: with
 * a larger budget, or with more values on its axes. */
#ifndef ISO_CHART_KEPT_H
#define ISO_CHART_KEPT_H

#include "base/file.h"
#include "chart/bench.h"

typedef struct iso_chart_kept_file {
    iso_output output; /* the folder */
    char renderers[ISO_MAX_RENDERERS][ISO_KEY_DIGEST_BYTES]; /* of iso_renderer_identify(); empty: nothing of it is taken */
    FILE *lines;
    long begun;   /* bytes before the first setting of a chart that begins anew */
    bool resumed; /* there was something of the same job */
} iso_chart_kept_file;

/* Begins the folder, or takes the one that is there if `resume`. key: of the command; the rest is added to it. ISO_E_USAGE:
 * the chart that is there has another key, of which a part is named; it stays as it is. k->renderers is the caller's to set
 * afterwards. */
iso_status iso_chart_kept_open(iso_chart_kept_file *k, const char *folder, bool resume, iso_key *key,
                               const iso_chart_bench *b, iso_error *err);
/* Fills the settings that are there and were drawn by these renderers, and those scenes' references. */
iso_status iso_chart_kept_take(iso_chart_kept_file *k, iso_chart_bench *b, iso_chart_case *cases, size_t count,
                               iso_error *err);
iso_status iso_chart_kept_put_reference(iso_chart_kept_file *k, const iso_chart_bench *b, size_t scene, iso_error *err);
iso_status iso_chart_kept_put(iso_chart_kept_file *k, const iso_chart_bench *b, const iso_chart_case *c, iso_error *err);
/* The folder becomes the chart's. */
iso_status iso_chart_kept_commit(iso_chart_kept_file *k, iso_error *err);
/* What is kept stays, if there is any. Accepts empty and what was committed. */
void iso_chart_kept_close(iso_chart_kept_file *k);

/* "reference-brain.exr"; a single scene's is "reference.exr". */
void iso_chart_reference_name(const iso_chart_bench *b, size_t scene, char *text, size_t size);

#endif
