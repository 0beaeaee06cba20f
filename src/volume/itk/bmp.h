/* SPDX-License-Identifier: MIT */
/* bmp.h - Windows bitmaps that are not packed: indices of 8 bits into a palette, or colors of 24 and 32 bits.
 *
 * A palette that is gray throughout gives gray values, not colors: such are the slices of micro-CT scanners. */
#pragma once

#include <string>
#include <vector>

#include "volume/child_writer.h"

struct Bitmap {
    std::string path;
    size_t width = 0, height = 0, components = 1; /* 1: gray; 3: red, green, blue */
    bool is_top_down = false;
    size_t bits = 8, samples_at = 0;
    std::vector<unsigned char> palette; /* blue, green, red, unused; 256 colors */
};

/* Reads the header. Throws Failure if the file is damaged, or of a kind that is not read. */
Bitmap open_bitmap(const std::string &path);
/* Reads all pixels, the first row first, one byte per component. */
void read_bitmap(const Bitmap &b, char *out);
