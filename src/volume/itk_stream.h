/* SPDX-License-Identifier: MIT */
/* itk_stream.h - what the program isoshade-itk writes to its output: an iso_itk_header, and if all is well for each plane
 * an iso_itk_answer, and its samples if that is well. A program of its own: libraries for so many formats end by an
 * assertion or worse where a file is damaged, which then ends no more than that. */
#ifndef ISO_VOLUME_ITK_STREAM_H
#define ISO_VOLUME_ITK_STREAM_H

#include <stdbool.h>

#include "volume/type.h"

#define ISO_ITK_PROGRAM "isoshade-itk"

typedef struct iso_itk_answer {
    iso_status status;
    iso_error error;
} iso_itk_answer;

typedef struct iso_itk_header {
    char version[16]; /* ISO_VERSION */
    iso_itk_answer answer;
    size_t size[3];
    iso_type type;
    double first_mm[3];   /* where the center of the first sample stands */
    double step_mm[3][3]; /* step_mm[a]: from a sample to the next along axis a */
    bool is_patient;      /* the world is left, posterior, superior; else the file's own frame, around its center */
    char unspaced[64];    /* "", or which spacing the file does not say: "between its slices" */
} iso_itk_header;

#endif
