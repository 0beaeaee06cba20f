/* SPDX-License-Identifier: MIT */
/* lattice_samples.h - a sparse lattice as samples of DF3 files, row by row, without making a dense level. Private to
 * exporters/povray. */
#pragma once

#include "brick/lattice.h"
#include "encode/code.h"

typedef struct iso_lattice_samples {
    const iso_lattice *lattice; /* borrowed */
    iso_code code;              /* directions are encoded and decoded, as a level's are */
    float unlit[3];             /* value of nodes without a direction */
} iso_lattice_samples;

iso_lattice_samples iso_lattice_samples_of(const iso_lattice *l, iso_code code);

/* Copies a float, or three, of each of `count` nodes from number `first` on, all in one row of the lattice's box. */
void iso_lattice_samples_scalars(const iso_lattice_samples *s, size_t first, size_t count, float *restrict out);
void iso_lattice_samples_directions(const iso_lattice_samples *s, size_t first, size_t count, float *restrict out);
/* Implements iso_df3_source.run: nodes of a block without active nodes are all equal. */
size_t iso_lattice_samples_run(const iso_lattice_samples *s, size_t first, size_t count, bool *same);
