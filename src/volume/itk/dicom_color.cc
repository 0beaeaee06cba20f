/* SPDX-License-Identifier: MIT */
#include "volume/itk/dicom_color.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

namespace {

using Pixel = std::array<double, 3>;

double sample_at(const char *coded, unsigned bits, size_t i)
{
    uint16_t wide;
    if (bits == 8)
        return static_cast<unsigned char>(coded[i]);
    memcpy(&wide, coded + 2 * i, sizeof wide);
    return wide;
}

Pixel color_of_index(const Palette &palette, double index)
{
    const double last = static_cast<double>(palette.entries[0].size()) - 1;
    const size_t at = static_cast<size_t>(std::clamp(index - palette.first, 0., last));
    return {static_cast<double>(palette.entries[0][at]), static_cast<double>(palette.entries[1][at]),
            static_cast<double>(palette.entries[2][at])};
}

Pixel rgb_of_ybr(const Pixel &ybr, double most)
{
    const double middle = (most + 1) / 2, cb = ybr[1] - middle, cr = ybr[2] - middle;
    Pixel rgb = {ybr[0] + 1.402 * cr, ybr[0] - (0.114 * 1.772 * cb + 0.299 * 1.402 * cr) / 0.587, ybr[0] + 1.772 * cb};
    for (double &c : rgb)
        c = std::clamp(std::floor(c + 0.5), 0., most);
    return rgb;
}

Pixel pixel_at(const Coding &coding, const Palette &palette, const char *coded, size_t pixels, size_t i)
{
    const unsigned bits = coding.bits;
    const double most = bits == 8 ? 255 : 65535;
    Pixel p{};
    if (coding.color == Color::palette)
        return color_of_index(palette, sample_at(coded, bits, i));
    if (coding.color == Color::ybr_half) /* Y Y Cb Cr */
        return rgb_of_ybr({sample_at(coded, bits, i / 2 * 4 + i % 2), sample_at(coded, bits, i / 2 * 4 + 2),
                           sample_at(coded, bits, i / 2 * 4 + 3)},
                          most);
    for (size_t c = 0; c < 3; ++c)
        p[c] = sample_at(coded, bits, coding.is_in_planes ? c * pixels + i : 3 * i + c);
    return coding.color == Color::ybr ? rgb_of_ybr(p, most) : p;
}

template <typename T> void put(char *out, size_t i, double value)
{
    const T given = static_cast<T>(value);
    memcpy(out + i * sizeof given, &given, sizeof given);
}

} // namespace

void color_channel(const Coding &coding, const Palette &palette, const char *coded, size_t pixels, size_t channel,
                   char *out)
{
    const unsigned bits = coding.color == Color::palette ? palette.bits : coding.bits;
    for (size_t i = 0; i < pixels; ++i) {
        const Pixel p = pixel_at(coding, palette, coded, pixels, i);
        if (channel > 2)
            put<float>(out, i, 0.2126 * p[0] + 0.7152 * p[1] + 0.0722 * p[2]);
        else if (bits == 8)
            put<uint8_t>(out, i, p[channel]);
        else
            put<uint16_t>(out, i, p[channel]);
    }
}
