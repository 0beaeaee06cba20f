/* SPDX-License-Identifier: MIT */
/* ranks_interface.h - functions that isoshade_mpi.so offers to the program (ranks.h); private to ranks. */
#pragma once

#include <stddef.h>

#define ISO_RANKS_INTERFACE_SYMBOL "iso_ranks_interface_mpi"

typedef struct iso_ranks_interface {
    void (*open)(int *index, int *count);
    void (*close)(void);
    void (*gather)(const void *data, size_t bytes, void *all); /* every rank gets the data of all */
    void (*broadcast)(void *data, size_t bytes);
    void (*largest)(double *values, size_t count);
    void (*send)(int to, const void *data, size_t bytes);
    void (*receive)(int from, void *data, size_t bytes);
} iso_ranks_interface;
