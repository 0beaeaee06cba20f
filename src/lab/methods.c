/* SPDX-License-Identifier: MIT */
#include "lab/methods.h"

#include <stdio.h>
#include <string.h>

const iso_lab_method iso_lab_methods[ISO_LAB_METHOD_COUNT] = {
    {"original", false, {.bits = 8}, 0, false},
    {"paper", true, {.weight = ISO_WEIGHT_GAUSS, .average = ISO_AVERAGE_RGBA, .bits = 8}, 0, false},
    {"paper-constant",
     true,
     {.weight = ISO_WEIGHT_FLAT, .window = 2.5, .average = ISO_AVERAGE_RGBA, .bits = 8},
     0,
     false},
    {"opacity-gauss", true, {.weight = ISO_WEIGHT_GAUSS, .average = ISO_AVERAGE_OPACITY, .bits = 8}, 0, false},
    {"opacity-wide",
     true,
     {.weight = ISO_WEIGHT_FLAT, .window = 3, .average = ISO_AVERAGE_OPACITY, .bits = 8},
     0,
     false},
    {"opacity-flat", true, {.weight = ISO_WEIGHT_FLAT, .average = ISO_AVERAGE_OPACITY, .bits = 8}, 0, false},
    {"extinction-flat", true, {.weight = ISO_WEIGHT_FLAT, .average = ISO_AVERAGE_EXTINCTION, .bits = 8}, 0, false},
    {"transmittance-flat",
     true,
     {.weight = ISO_WEIGHT_FLAT, .average = ISO_AVERAGE_TRANSMITTANCE, .bits = 8},
     0,
     false},
    {"default",
     true,
     {.weight = ISO_WEIGHT_FLAT, .average = ISO_AVERAGE_OPACITY, .bits = 8, .fall_back = true},
     0,
     false},
    {"tf-2d-deviation",
     true,
     {.weight = ISO_WEIGHT_FLAT, .average = ISO_AVERAGE_OPACITY, .bits = 8},
     ISO_SECOND_VALUE_DEVIATION,
     false},
    {"tf-2d-gradient",
     true,
     {.weight = ISO_WEIGHT_FLAT, .average = ISO_AVERAGE_OPACITY, .bits = 8},
     ISO_SECOND_VALUE_GRADIENT,
     false},
    {.name = "original-scaled", .options = {.bits = 8}, .extinction_scale = true},
    {.name = "default-scaled",
     .adapt = true,
     .options = {.weight = ISO_WEIGHT_FLAT, .average = ISO_AVERAGE_OPACITY, .bits = 8},
     .extinction_scale = true},
};

static bool is_word(const char *at, size_t length, const char *word)
{
    return strlen(word) == length && strncmp(at, word, length) == 0;
}

static iso_status unknown(const char *at, size_t length, iso_error *err)
{
    char names[400] = "";
    size_t used = 0;
    for (int m = 1; m < ISO_LAB_METHOD_COUNT && used < sizeof names; ++m)
        used += (size_t)snprintf(names + used, sizeof names - used, "%s, ", iso_lab_methods[m].name);
    return iso_fail(err, ISO_E_USAGE, "--methods: unknown method \"%.*s\"; %sor all", (int)length, at, names);
}

iso_status iso_lab_choose_methods(const char *text, bool wanted[ISO_LAB_METHOD_COUNT], iso_error *err)
{
    wanted[0] = true;
    if (!*text)
        return unknown(text, 0, err);
    for (const char *at = text; *at;) {
        const size_t length = strcspn(at, ",");
        bool known = false;
        for (int m = 0; m < ISO_LAB_METHOD_COUNT; ++m)
            if (is_word(at, length, "all") || is_word(at, length, iso_lab_methods[m].name))
                wanted[m] = known = true;
        if (!known)
            return unknown(at, length, err);
        at += length + (at[length] == ',');
    }
    return ISO_OK;
}
