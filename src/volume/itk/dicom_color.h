/* SPDX-License-Identifier: MIT */
/* dicom_color.h - colors of DICOM (PS3.3 C.7.6.3.1.2): red, green and blue of what a file stores. */
#pragma once

#include <cstdint>
#include <string>
#include <vector>

enum class Color { gray, rgb, ybr, ybr_half, palette }; /* ybr_half: one Cb and Cr for two pixels of a row */

/* Colors by index, of 8 or 16 bits. */
struct Palette {
    int first = 0; /* index of the first color; lower ones have that, higher ones the last */
    unsigned bits = 8;
    std::vector<uint16_t> entries[3];
    bool is_gray() const
    {
        return entries[0] == entries[1] && entries[0] == entries[2];
    }
};

/* How the samples of a file are coded. */
struct Coding {
    Color color = Color::gray;
    unsigned bits = 0;        /* of a sample: 1, 8, 16, 32 or 64 */
    size_t components = 1;    /* of a pixel */
    bool is_in_planes = false; /* all red ones of a frame, then all green ones */
    bool has_whole_bytes = true; /* false: the bits of all frames stand without a gap */
};

/* Writes a channel of the frame at `coded`, 0 to 2, as samples of the coding's or the palette's bits; 3: luminance
 * [itu-bt709], as floats. */
void color_channel(const Coding &coding, const Palette &palette, const char *coded, size_t pixels, size_t channel,
                   char *out);
