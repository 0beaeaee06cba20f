/* SPDX-License-Identifier: MIT */
/* owned.h - release of a function's own memory and files on each way out of their block.
 *
 *     FREED float *plane = malloc(bytes);
 *     OWNED(iso_image) image = {0};                      by iso_image_destroy(&image)
 *     ENDED_BY(iso_close_file) FILE *file = fopen(path, "rb");
 *     NEED(iso_source_read(source, 1, plane, err));      all three are released here, too
 *
 * They apply to all variables of a declaration, in reverse order, after the value of a return is known. Each needs a first
 * value. The function gets the address of the variable. Set a pointer to NULL to keep its target. JSON has json_auto_t.
 *
 * Not for variables in the body of a parallel loop: OpenMP passes them by address, and loops become slower. */
#pragma once

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static inline void iso_free_owned(void *variable)
{
    void *memory;
    memcpy(&memory, variable, sizeof memory);
    free(memory);
}

static inline void iso_close_file(FILE **file)
{
    if (*file)
        fclose(*file);
}

#define ENDED_BY(function) __attribute__((cleanup(function)))
/* Defines `name`, for ENDED_BY() with a pointer: ISO_ENDING(end_key, iso_key, iso_key_destroy) */
#define ISO_ENDING(name, type, function) \
    static inline void name(type **variable) \
    { \
        if (*variable) \
            function(*variable); \
    }
#define OWNED(type) ENDED_BY(type##_destroy) type
#define FREED ENDED_BY(iso_free_owned)
