/* SPDX-License-Identifier: MIT */
#include "volume/itk/bmp.h"

#include <fstream>

namespace {

constexpr size_t head_bytes = 54;

int64_t number_at(const std::string &head, size_t at)
{
    uint32_t value = 0;
    for (size_t i = 4; i-- > 0;)
        value = value << 8 | static_cast<unsigned char>(head[at + i]);
    return static_cast<int32_t>(value);
}

size_t row_bytes(const Bitmap &b)
{
    return (b.width * b.bits / 8 + 3) / 4 * 4;
}

/* Reads the palette; a missing color is black. Without one, indices are gray values. */
void take_palette(std::ifstream &file, const std::string &head, Bitmap &b)
{
    const int64_t at = 14 + number_at(head, 14), used = number_at(head, 46),
                  colors = used > 0 && used < 256 ? used : 256;
    b.palette.assign(1024, 0);
    file.seekg(at);
    file.read(reinterpret_cast<char *>(b.palette.data()), static_cast<std::streamsize>(4 * colors));
    for (size_t i = 0; i < 1024; i += 4)
        if (b.palette[i] != b.palette[i + 1] || b.palette[i] != b.palette[i + 2])
            b.components = 3;
}

} // namespace

Bitmap open_bitmap(const std::string &path)
{
    std::ifstream file(path, std::ios::binary | std::ios::ate);
    const int64_t size = static_cast<int64_t>(file.tellg());
    std::string head(head_bytes, 0);
    Bitmap b;
    file.seekg(0);
    if (!file.read(&head[0], head_bytes) || head.compare(0, 2, "BM") != 0 || number_at(head, 14) < 40)
        fail(ISO_E_FORMAT, path + ": damaged, or not a bitmap of Windows 3 or later");
    const int64_t width = number_at(head, 18), height = number_at(head, 22), packing = number_at(head, 30);
    b.path = path;
    b.bits = static_cast<unsigned char>(head[28]) + 256u * static_cast<unsigned char>(head[29]);
    b.is_top_down = height < 0;
    if (packing != 0 || (b.bits != 8 && b.bits != 24 && b.bits != 32))
        fail(ISO_E_FORMAT, path + ": a bitmap of " + std::to_string(b.bits) + " bits" + (packing ? ", packed" : "") +
                               ", must be 8, 24 or 32 bits, not packed");
    if (width < 1 || height == 0 || width > 1 << 20 || std::abs(height) > 1 << 20)
        fail(ISO_E_FORMAT, path + ": damaged: a bitmap of " + std::to_string(width) + " x " + std::to_string(height));
    b.width = static_cast<size_t>(width), b.height = static_cast<size_t>(std::abs(height));
    b.samples_at = static_cast<size_t>(std::max<int64_t>(number_at(head, 10), 0));
    const double need = static_cast<double>(b.samples_at) +
                        static_cast<double>(row_bytes(b)) * static_cast<double>(b.height);
    if (static_cast<double>(size) < need)
        fail(ISO_E_FORMAT, path + ": truncated: holds " + std::to_string(size) + " bytes, needs " +
                               std::to_string(static_cast<int64_t>(need)));
    b.components = b.bits == 8 ? 1 : 3;
    if (b.bits == 8)
        take_palette(file, head, b);
    return b;
}

void read_bitmap(const Bitmap &b, char *out)
{
    std::ifstream file(b.path, std::ios::binary);
    std::vector<char> row(row_bytes(b));
    file.seekg(static_cast<std::streamoff>(b.samples_at));
    for (size_t y = 0; y < b.height; ++y) {
        if (!file.read(row.data(), static_cast<std::streamsize>(row.size())))
            fail(ISO_E_IO, b.path + ": cannot be read");
        char *to = out + (b.is_top_down ? y : b.height - 1 - y) * b.width * b.components;
        for (size_t x = 0; x < b.width; ++x) {
            const char *pixel = b.bits == 8
                                    ? reinterpret_cast<const char *>(&b.palette[4 * static_cast<unsigned char>(row[x])])
                                    : row.data() + x * b.bits / 8;
            for (size_t c = 0; c < b.components; ++c)
                to[x * b.components + c] = pixel[b.components == 1 ? 0 : 2 - c];
        }
    }
}
