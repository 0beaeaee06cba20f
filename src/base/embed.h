/* SPDX-License-Identifier: MIT */
/* embed.h - a text file inside the program, by the assembler.
 *
 *     ISO_EMBED(raycast_glsl, "src/render/gl/shaders/raycast.glsl");
 *
 * defines `extern const char raycast_glsl[]`, ended by a 0. Paths are relative
 * to the top of the project, where make runs; the Makefile makes the objects
 * depend on the embedded files. */
#pragma once

/* clang-format off */
#define ISO_EMBED(symbol, path)                                  \
    extern const char symbol[];                                  \
    __asm__(".pushsection .rodata\n"                             \
            ".global " #symbol "\n"                              \
            ".type " #symbol ", @object\n" #symbol ":\n"         \
            ".incbin \"" path "\"\n"                             \
            ".byte 0\n"                                          \
            ".size " #symbol ", . - " #symbol "\n"               \
            ".popsection\n")
/* clang-format on */
