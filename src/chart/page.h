/* SPDX-License-Identifier: MIT */
/* page.h - DIR/index.html: the chart as a page without network or other files. Pointing at a setting, or selecting it
 * by keys, shows its picture, figures and command. */
#pragma once

#include "chart/result.h"

/* Writes the page. json: from iso_chart_result_json(). */
iso_status iso_chart_page_write(const iso_chart_result *r, const char *folder, const json_t *json, iso_error *err);
