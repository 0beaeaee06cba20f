/* SPDX-License-Identifier: MIT */
/* cast_width.h - whether this compiler makes the packets of AVX2 and AVX-512. */
#pragma once

#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__)
#define ISO_CAST_HAS_X86
#else
typedef int iso_cast_has_no_x86; /* C forbids source files without a declaration */
#endif
