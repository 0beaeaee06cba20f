/* SPDX-License-Identifier: MIT */
#include "volume/itk/pictures.h"

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <string>
#include <vector>

#include <tiffio.h>

#include "volume/child_writer.h"
#include "volume/half.h"
#include "volume/itk/dicom_series.h"

/* ---- BMP ---- */

/* Windows bitmaps that are not packed: indices of 8 bits into a palette, or colors of 24 and 32 bits.
 *
 * A palette that is gray throughout gives gray values, not colors: such are the slices of micro-CT scanners. */
namespace {

struct Bitmap {
    std::string path;
    size_t width = 0, height = 0, components = 1; /* 1: gray; 3: red, green, blue */
    bool is_top_down = false;
    size_t bits = 8, samples_at = 0;
    std::vector<unsigned char> palette; /* blue, green, red, unused; 256 colors */
};

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

/* Reads the header. Throws Failure if the file is damaged, or of a kind that is not read. */
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

/* Reads all pixels, the first row first, one byte per component. */
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

/* ---- TIFF ---- */

/* Gray samples. ITK takes tiles for colors, integers of 32 bits for 0, and halves for integers. */
const struct TiffKind {
    uint16_t format, bits;
    iso_type type; /* as which they are given */
} tiff_kinds[] = {{SAMPLEFORMAT_UINT, 8, ISO_U8},     {SAMPLEFORMAT_INT, 8, ISO_I8},
                  {SAMPLEFORMAT_UINT, 16, ISO_U16},   {SAMPLEFORMAT_INT, 16, ISO_I16},
                  {SAMPLEFORMAT_UINT, 32, ISO_U32},   {SAMPLEFORMAT_INT, 32, ISO_I32},
                  {SAMPLEFORMAT_UINT, 64, ISO_F64},   {SAMPLEFORMAT_INT, 64, ISO_F64},
                  {SAMPLEFORMAT_IEEEFP, 16, ISO_F32}, {SAMPLEFORMAT_IEEEFP, 32, ISO_F32},
                  {SAMPLEFORMAT_IEEEFP, 64, ISO_F64}};

struct Tiff {
    const TiffKind *kind = nullptr; /* null: a file for ITK */
    std::array<size_t, 3> size{1, 1, 1};
};

using TiffFile = std::unique_ptr<TIFF, void (*)(TIFF *)>;

Tiff open_tiff(const std::string &path)
{
    TIFFSetErrorHandler(nullptr), TIFFSetWarningHandler(nullptr);
    const TiffFile file(TIFFOpen(path.c_str(), "rm"), TIFFClose);
    Tiff t;
    uint32_t width = 0, height = 0;
    uint16_t bits = 1, samples = 1, format = SAMPLEFORMAT_UINT, meaning = PHOTOMETRIC_MINISBLACK;
    if (!file)
        return t;
    TIFFGetField(file.get(), TIFFTAG_IMAGEWIDTH, &width);
    TIFFGetField(file.get(), TIFFTAG_IMAGELENGTH, &height);
    TIFFGetFieldDefaulted(file.get(), TIFFTAG_BITSPERSAMPLE, &bits);
    TIFFGetFieldDefaulted(file.get(), TIFFTAG_SAMPLESPERPIXEL, &samples);
    TIFFGetFieldDefaulted(file.get(), TIFFTAG_SAMPLEFORMAT, &format);
    TIFFGetFieldDefaulted(file.get(), TIFFTAG_PHOTOMETRIC, &meaning);
    const bool is_gray = samples == 1 && meaning <= PHOTOMETRIC_MINISBLACK;
    format = format == SAMPLEFORMAT_VOID ? SAMPLEFORMAT_UINT : format;
    for (const auto &kind : tiff_kinds)
        if (kind.bits == bits && kind.format == format && is_gray)
            t.kind = &kind;
    if (!is_gray && bits > 8 && bits != (format == SAMPLEFORMAT_IEEEFP ? 32 : 16))
        fail(ISO_E_FORMAT, path + ": " + std::to_string(samples) + " components of " + std::to_string(bits) +
                               " bits per pixel, must be of 8 or 16 bits, or floats");
    t.size = {width, height, TIFFLastDirectory(file.get()) ? 1u : 2u};
    return t;
}

/* Copies a strip or tile of `row` bytes a row to where it stands in the picture. */
void put_part(const std::vector<char> &part, size_t row, size_t x, size_t y, size_t row_bytes, std::vector<char> &all)
{
    const size_t bytes = std::min(row, row_bytes - x);
    for (size_t at = 0; at + row <= part.size() && (y + 1) * row_bytes <= all.size(); at += row, ++y)
        memcpy(&all[y * row_bytes + x], &part[at], bytes);
}

template <typename From, typename To, typename Value>
void convert(const std::vector<char> &from, char *out, Value value)
{
    for (size_t i = 0; i < from.size() / sizeof(From); ++i) {
        From sample;
        memcpy(&sample, &from[i * sizeof sample], sizeof sample);
        const To number = value(sample);
        memcpy(out + i * sizeof number, &number, sizeof number);
    }
}

/* Reads all pixels, of the kind's type. */
void read_tiff(const std::string &path, const Tiff &t, char *out)
{
    const TiffFile file(TIFFOpen(path.c_str(), "rm"), TIFFClose);
    const size_t row_bytes = t.size[0] * t.kind->bits / 8;
    const bool is_tiled = file && TIFFIsTiled(file.get());
    std::vector<char> all(row_bytes * t.size[1]);
    uint32_t width = 0, rows = 0, height = static_cast<uint32_t>(t.size[1]);
    if (file)
        TIFFGetField(file.get(), TIFFTAG_TILEWIDTH, &width);
    if (file)
        TIFFGetFieldDefaulted(file.get(), is_tiled ? TIFFTAG_TILELENGTH : TIFFTAG_ROWSPERSTRIP, &rows);
    rows = std::min(rows, is_tiled ? rows : height);
    const size_t row = is_tiled ? static_cast<size_t>(width) * t.kind->bits / 8 : row_bytes;
    std::vector<char> part(row * rows);
    bool well = !part.empty();
    uint32_t next = 0;
    for (size_t y = 0; well && y < height; y += rows)
        for (size_t x = 0; well && x < row_bytes; x += row, ++next) {
            const tmsize_t room = static_cast<tmsize_t>(part.size());
            const tmsize_t got = is_tiled ? TIFFReadEncodedTile(file.get(), next, part.data(), room)
                                          : TIFFReadEncodedStrip(file.get(), next, part.data(), room);
            well = got >= static_cast<tmsize_t>(row * std::min<size_t>(rows, height - y));
            put_part(part, row, x, y, row_bytes, all);
        }
    if (!well)
        fail(ISO_E_FORMAT, path + ": truncated or damaged");
    if (t.kind->bits == 16 && t.kind->type == ISO_F32)
        convert<uint16_t, float>(all, out, iso_half_to_float);
    else if (t.kind->bits == 64 && t.kind->format == SAMPLEFORMAT_INT)
        convert<int64_t, double>(all, out, [](int64_t whole) { return static_cast<double>(whole); });
    else if (t.kind->bits == 64 && t.kind->format == SAMPLEFORMAT_UINT)
        convert<uint64_t, double>(all, out, [](uint64_t whole) { return static_cast<double>(whole); });
    else
        memcpy(out, all.data(), all.size());
}

} // namespace

/* ---- pictures ---- */

namespace {

namespace fs = std::filesystem;

/* Kinds of pictures, by their first bytes, or by their names: a damaged slice is an error, not left out. */
const struct Kind {
    const char *name, *starts[2], *endings[2];
    size_t bytes;
} kinds[] = {
    {"PNG", {"\x89PNG", "\x89PNG"}, {".png", ".png"}, 4},
    {"JPEG", {"\xff\xd8\xff", "\xff\xd8\xff"}, {".jpg", ".jpeg"}, 3},
    {"TIFF", {"II*\0", "MM\0*"}, {".tif", ".tiff"}, 4},
    {"BMP", {"BM", "BM"}, {".bmp", ".bmp"}, 2},
};
constexpr size_t tiff = 2, bmp = 3;

std::string lower(std::string text)
{
    for (char &c : text)
        c = static_cast<char>(tolower(static_cast<unsigned char>(c)));
    return text;
}

/* Returns the kind of a file; NULL: no picture. */
const Kind *kind_of(const fs::path &path)
{
    char head[4] = "";
    const std::string ending = lower(path.extension().string());
    for (const auto &kind : kinds)
        if (ending == kind.endings[0] || ending == kind.endings[1])
            return &kind;
    std::ifstream(path, std::ios::binary).read(head, sizeof head);
    for (const auto &kind : kinds)
        for (const char *start : kind.starts)
            if ((kind.bytes > 2 || ending.empty()) && memcmp(head, start, kind.bytes) == 0)
                return &kind;
    return nullptr;
}

/* Returns the file's name, each number in it replaced by one sign. */
std::string pattern_of(const std::string &path)
{
    std::string text;
    for (const char c : fs::path(path).filename().string())
        if (!isdigit(static_cast<unsigned char>(c)))
            text += c;
        else if (text.empty() || text.back() != '#')
            text += '#';
    return text;
}

/* Returns the value that most files have; of equally many the first. */
template <typename Value, typename Of> Value most_frequent(const std::vector<std::string> &files, Of of)
{
    std::map<Value, size_t> counts;
    Value found{};
    size_t most = 0;
    for (const auto &file : files)
        ++counts[of(file)];
    for (const auto &file : files)
        if (counts[of(file)] > most)
            most = counts[of(file)], found = of(file);
    return found;
}

std::vector<std::string> slices_in(const std::string &folder, std::string &warning)
{
    std::vector<std::string> pictures, chosen;
    size_t files = 0;
    for (const auto &entry : fs::directory_iterator(folder)) {
        if (!entry.is_regular_file() || entry.path().filename().string()[0] == '.')
            continue;
        ++files;
        if (kind_of(entry.path()))
            pictures.push_back(entry.path().string());
    }
    if (pictures.empty())
        fail(ISO_E_FORMAT, folder + (files == 0 ? ": holds no regular file, which a slice is"
                                                : ": none of its " + std::to_string(files) +
                                                      " files is a slice: DICOM, PNG, JPEG, TIFF or BMP"));
    std::sort(pictures.begin(), pictures.end(), comes_before);
    const Kind *kind = most_frequent<const Kind *>(pictures, [](const auto &f) { return kind_of(f); });
    for (const auto &file : pictures)
        if (kind_of(file) == kind)
            chosen.push_back(file);
        else if (warning.empty())
            warning = file + " is left out: most slices are " + kind->name;
    return chosen;
}

/* Returns where the names differ, if it is one number of each: its first digit in the first name. npos otherwise. */
size_t place_of_number(const std::vector<std::string> &names)
{
    for (size_t at = names[0].size(); at-- > 0;) {
        const auto is_digit = [&](const std::string &name, size_t i) {
            return i < name.size() && isdigit(static_cast<unsigned char>(name[i]));
        };
        if (!is_digit(names[0], at) || (at > 0 && is_digit(names[0], at - 1)))
            continue;
        const auto after = [&](const std::string &name) { return name.find_first_not_of("0123456789", at); };
        const std::string before = names[0].substr(0, at),
                          rest = names[0].substr(std::min(after(names[0]), names[0].size()));
        if (std::all_of(names.begin(), names.end(), [&](const std::string &name) {
                return name.compare(0, at, before) == 0 && is_digit(name, at) &&
                       name.substr(std::min(after(name), name.size())) == rest;
            }))
            return at;
    }
    return std::string::npos;
}

/* Refuses a gap in the numbers of the names, which are in their order. */
void check_numbers(const std::string &folder, const std::vector<std::string> &names)
{
    const size_t at = place_of_number(names);
    if (at == std::string::npos)
        return;
    const auto number = [&](size_t i) { return strtoull(names[i].c_str() + at, nullptr, 10); };
    unsigned long long step = 0;
    for (size_t i = 1; i < names.size(); ++i)
        step = step == 0 ? number(i) - number(i - 1) : std::min(step, number(i) - number(i - 1));
    for (size_t i = 1; i < names.size(); ++i)
        if (number(i) - number(i - 1) != step)
            fail(ISO_E_FORMAT, folder + ": number " + std::to_string(number(i - 1) + step) + " is missing between " +
                                   names[i - 1] + " and " + names[i] +
                                   "; put that slice there, or number the files evenly");
}

/* True for a PNG file of colors by a palette that are all gray. */
bool is_gray_by_palette(const std::string &path)
{
    constexpr size_t color_type = 25, chunks = 33; /* bytes from the file's start */
    std::ifstream file(path, std::ios::binary);
    std::string head(chunks, 0), data;
    if (!file.read(&head[0], chunks) || head.compare(0, 4, "\x89PNG") != 0 || head[color_type] != 3)
        return false;
    unsigned char start[8];
    while (file.read(reinterpret_cast<char *>(start), sizeof start)) {
        const uint32_t length = static_cast<uint32_t>(start[0]) << 24 | start[1] << 16 | start[2] << 8 | start[3];
        if (memcmp(start + 4, "PLTE", 4) != 0) {
            file.seekg(static_cast<std::streamoff>(length) + 4, std::ios::cur);
            continue;
        }
        data.resize(std::min<size_t>(length, 768));
        bool is_gray = static_cast<bool>(file.read(&data[0], static_cast<std::streamsize>(data.size())));
        for (size_t i = 0; i + 2 < data.size(); i += 3)
            is_gray = is_gray && data[i] == data[i + 1] && data[i] == data[i + 2];
        return is_gray;
    }
    return false;
}

/* A picture, and the components of its pixels that are given: one if all are gray. */
struct Picture : Slice {
    Bitmap bitmap; /* of a BMP file, which has no reader of ITK */
    Tiff tiff;     /* of a TIFF file that ITK does not read right */
    size_t components = 1;
};

Picture open_picture(const std::string &path)
{
    Picture p;
    if (kind_of(path) == &kinds[bmp]) {
        p.bitmap = open_bitmap(path);
        p.path = path;
        p.size = {p.bitmap.width, p.bitmap.height, 1};
        p.stored = p.components = p.bitmap.components;
        return p;
    }
    if (kind_of(path) == &kinds[tiff])
        p.tiff = open_tiff(path);
    if (p.tiff.kind) {
        p.path = path;
        p.size = p.tiff.size;
        p.type = p.tiff.kind->type;
        return p;
    }
    static_cast<Slice &>(p) = open_slice(path);
    p.components = is_gray_by_palette(path) ? 1 : p.stored;
    return p;
}

template <typename T> void pick_as(const Picture &s, const char *samples, size_t channel, char *out)
{
    const size_t count = s.size[0] * s.size[1], n = s.stored;
    for (size_t i = 0; i < count; ++i) {
        T at[4];
        memcpy(at, samples + i * n * sizeof(T), n * sizeof(T));
        /* [itu-bt709], of the values as they are stored */
        const float luminance = static_cast<float>(0.2126 * static_cast<double>(at[0]) +
                                                   0.7152 * static_cast<double>(at[1]) +
                                                   0.0722 * static_cast<double>(at[2]));
        if (channel < n)
            memcpy(out + i * sizeof(T), &at[channel], sizeof(T));
        else
            memcpy(out + i * sizeof luminance, &luminance, sizeof luminance);
    }
}

void pick(const Picture &s, const char *samples, size_t channel, char *out)
{
    switch (bytes_of(s.type)) {
    case 1: return pick_as<uint8_t>(s, samples, channel, out);
    case 2: return pick_as<uint16_t>(s, samples, channel, out);
    default: return pick_as<float>(s, samples, channel, out);
    }
}

class PictureReader : public PlaneReader {
public:
    PictureReader(const std::string &folder, size_t channel) : channel_(channel)
    {
        std::string warning;
        for (const auto &file : slices_in(folder, warning))
            slices_.push_back(open_picture(file));
        leave_out_overviews(warning);
        check(folder);
        std::vector<std::string> names;
        for (const auto &slice : slices_)
            names.push_back(fs::path(slice.path).filename().string());
        check_numbers(folder, names);
        const Picture &first = slices_[0];
        header.size[0] = first.size[0];
        header.size[1] = first.size[1];
        header.size[2] = slices_.size();
        header.type = channel < first.components ? first.type : ISO_F32;
        header.channels = first.components;
        header.is_color = first.components >= 3;
        header.is_whole = first.tiff.kind && first.tiff.kind->bits == 64 &&
                          first.tiff.kind->format != SAMPLEFORMAT_IEEEFP;
        header.world = ISO_CHILD_CENTERED;
        for (int a = 0; a < 3; ++a)
            header.step[a][a] = 1;
        snprintf(header.unspaced, sizeof header.unspaced, "of its voxels, as pictures do not");
        snprintf(header.warning, sizeof header.warning, "%s", warning.c_str());
    }

    void read_plane(char *out, size_t plane) override
    {
        /* The reader again: it holds its file open, and thousands of them are too many. */
        const Picture picture = open_picture(slices_[next_++].path);
        std::vector<char> all(
            picture.stored == 1 ? 0 : picture.size[0] * picture.size[1] * picture.stored * bytes_of(picture.type));
        char *to = picture.stored == 1 ? out : all.data();
        if (!picture.bitmap.path.empty())
            read_bitmap(picture.bitmap, to);
        else if (picture.tiff.kind)
            read_tiff(picture.path, picture.tiff, to);
        else
            read_samples(picture, to, picture.stored == 1 ? plane : all.size());
        if (picture.stored > 1)
            pick(picture, to, channel_, out);
    }

private:
    std::vector<Picture> slices_;
    size_t next_ = 0, channel_;

    /* A scanner's overview has a name of its own, and often a size. */
    void leave_out_overviews(std::string &warning)
    {
        std::vector<std::string> paths;
        for (const auto &s : slices_)
            paths.push_back(s.path);
        const std::string pattern = most_frequent<std::string>(paths, pattern_of);
        const auto usual = std::find_if(slices_.begin(), slices_.end(),
                                        [&](const Picture &s) { return pattern_of(s.path) == pattern; });
        const std::array<size_t, 3> size = usual->size;
        const auto has_pattern = [&](const std::string &path) { return pattern_of(path) == pattern; };
        const bool is_of_most = 2 * static_cast<size_t>(std::count_if(paths.begin(), paths.end(), has_pattern)) >
                                paths.size();
        for (size_t i = slices_.size(); i-- > 0;)
            if (!has_pattern(slices_[i].path) && (is_of_most || slices_[i].size != size)) {
                warning = slices_[i].path + " is left out: its name is not like those of the slices";
                slices_.erase(slices_.begin() + static_cast<long>(i));
            }
        std::map<std::string, size_t> others;
        for (const auto &s : slices_)
            if (!has_pattern(s.path) && ++others[pattern_of(s.path)] == 2 && warning.empty())
                warning = "slices named " + pattern + " and " + pattern_of(s.path) +
                          " are read as one volume; others need a folder of their own";
    }

    void check(const std::string &folder) const
    {
        const Picture &first = slices_[0];
        for (const auto &s : slices_)
            if (s.size[2] != 1)
                fail(ISO_E_FORMAT, folder + ": holds volumes, not slices: " + s.path);
        for (const auto &s : slices_)
            if (s.type != first.type || s.components != first.components || s.tiff.kind != first.tiff.kind)
                fail(ISO_E_FORMAT, folder + ": slices of different types: " + first.path + ", " + s.path);
        for (const auto &s : slices_)
            if (s.size != first.size)
                fail(ISO_E_FORMAT, folder + ": slices of different sizes: " + first.path + ", " + s.path);
        if (channel_ > (first.components >= 3 ? first.components : first.components - 1))
            fail(ISO_E_RANGE, folder + ": has no such channel");
    }
};

} // namespace

bool holds_pictures(const std::string &folder)
{
    for (const auto &entry : fs::directory_iterator(folder))
        if (entry.is_regular_file() && entry.path().filename().string()[0] != '.' && kind_of(entry.path()))
            return true;
    return false;
}

std::unique_ptr<PlaneReader> open_pictures(const std::string &folder, size_t channel)
{
    return std::make_unique<PictureReader>(folder, channel);
}
