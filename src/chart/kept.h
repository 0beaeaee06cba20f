/* SPDX-License-Identifier: MIT */
/* kept.h - measurements of an unfinished chart, from which --resume continues.
 *
 *     .DIR.partial/settings.jsonl       the chart's key (base/key.h), then one line per measured setting, written
 *                                       at once; the last line of a setting counts
 *                  reference-SCENE.exr  reference image of a scene
 *
 * When the chart is finished, the folder becomes DIR and keeps these files. So a finished chart can be continued too,
 * with a larger budget or with more values on its axes. */
#pragma once

#include "base/file.h"
#include "chart/bench.h"

typedef struct iso_chart_kept_file {
    iso_output output; /* the folder */
    char renderers[ISO_MAX_RENDERERS][ISO_KEY_DIGEST_BYTES]; /* by iso_renderer_identify(); empty: take none of its
                                                              * settings */
    FILE *lines;
    long begun;   /* bytes before the first setting of a new chart */
    bool resumed; /* True if a chart of the same job was there */
} iso_chart_kept_file;

/* Creates the folder, or opens the existing one if `resume`. key: key of the command; this function completes it.
 * ISO_E_USAGE: the chart there has another key; the message names a part that differs, and the chart is kept. The
 * caller sets k->renderers afterwards. */
iso_status iso_chart_kept_open(iso_chart_kept_file *k, const char *folder, bool resume, iso_key *key,
                               const iso_chart_bench *b, iso_error *err);
/* Reads the stored settings of these renderers, and the references of their scenes. */
iso_status iso_chart_kept_take(iso_chart_kept_file *k, iso_chart_bench *b, iso_chart_case *cases, size_t count,
                               iso_error *err);
iso_status iso_chart_kept_put_reference(iso_chart_kept_file *k, const iso_chart_bench *b, size_t scene, iso_error *err);
iso_status iso_chart_kept_put(iso_chart_kept_file *k, const iso_chart_bench *b, const iso_chart_case *c, iso_error *err);
/* Moves the folder to its final place. */
iso_status iso_chart_kept_commit(iso_chart_kept_file *k, iso_error *err);
/* Closes the folder; keeps it if it holds measurements. Accepts empty and committed folders. */
void iso_chart_kept_close(iso_chart_kept_file *k);

/* Writes "reference-brain.exr", or "reference.exr" if there is one scene. */
void iso_chart_reference_name(const iso_chart_bench *b, size_t scene, char *text, size_t size);
