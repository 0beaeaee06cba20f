/* SPDX-License-Identifier: MIT */
/* readers.h - what each target does with its input. */
#pragma once

#include "tests/fuzz/fuzz.h"

#define FUZZ_READER(name) void name(const fuzz_target *target, const char *path, const uint8_t *data, size_t size)
FUZZ_READER(fuzz_volume);
FUZZ_READER(fuzz_afni);
FUZZ_READER(fuzz_pvti);
FUZZ_READER(fuzz_raw);
FUZZ_READER(fuzz_tf);
FUZZ_READER(fuzz_scene);
FUZZ_READER(fuzz_pyramid);
FUZZ_READER(fuzz_joint);
FUZZ_READER(fuzz_plan);
FUZZ_READER(fuzz_report);
FUZZ_READER(fuzz_renderers);
FUZZ_READER(fuzz_manifest);
FUZZ_READER(fuzz_palette);
FUZZ_READER(fuzz_exr);
FUZZ_READER(fuzz_png);
FUZZ_READER(fuzz_ppm);
FUZZ_READER(fuzz_words);
FUZZ_READER(fuzz_planted);

void fuzz_repair_pyramid(uint8_t *data, size_t size);
void fuzz_repair_png(uint8_t *data, size_t size);

/* What is read back has to be what was written. */
struct json_t;
void fuzz_check_same(const char *what, const struct json_t *written, const struct json_t *read);
