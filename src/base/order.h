/* SPDX-License-Identifier: MIT */
/* order.h - orders for qsort(). */
#pragma once

/* Compares doubles, the smaller one first. */
static inline int iso_order_doubles(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}
