/* SPDX-License-Identifier: MIT */
/* lattice_samples.h - a sparse lattice as the samples of DF3 files, row by row: no dense level is made of it. Private
 * to exporters/povray. */
#ifndef ISO_LATTICE_SAMPLES_H
#define ISO_LATTICE_SAMPLES_H

#include "brick/lattice.h"
#include "encode/code.h"

typedef struct iso_lattice_samples {
    const iso_lattice *lattice; /* kept */
    iso_code code;              /* directions are taken through it and back, as those of a level's codes are */
    float unlit[3];             /* what a node without a direction has then */
} iso_lattice_samples;

iso_lattice_samples iso_lattice_samples_of(const iso_lattice *l, iso_code code);

/* One float, or three, of each of `count` nodes from number `first` on, which lie in one row of the lattice's box. */
void iso_lattice_samples_scalars(const iso_lattice_samples *s, size_t first, size_t count, float *restrict out);
void iso_lattice_samples_directions(const iso_lattice_samples *s, size_t first, size_t count, float *restrict out);
/* As iso_df3_source.run: nodes of blocks in which none is active are alike. */
size_t iso_lattice_samples_run(const iso_lattice_samples *s, size_t first, size_t count, bool *alike);

#endif
