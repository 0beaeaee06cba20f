/* SPDX-License-Identifier: MIT */
/* all_page.h - writes the answer of `bench all` as a page. */
#pragma once

#include <jansson.h>

#include "base/status.h"

iso_status iso_bench_all_page_write(const char *path, const json_t *answer, iso_error *err);
