/* SPDX-License-Identifier: MIT */
/* ranks_door.h - what the library beside the program offers; private to ranks. */
#ifndef ISO_RANKS_DOOR_H
#define ISO_RANKS_DOOR_H

#include <stddef.h>

#define ISO_RANKS_DOOR_SYMBOL "iso_ranks_door_mpi"

typedef struct iso_ranks_door {
    void (*open)(int *index, int *count);
    void (*close)(void);
    void (*gather)(const void *data, size_t bytes, void *all); /* to every rank */
    void (*broadcast)(void *data, size_t bytes);
    void (*largest)(double *values, size_t count);
    void (*send)(int to, const void *data, size_t bytes);
    void (*receive)(int from, void *data, size_t bytes);
} iso_ranks_door;

#endif
