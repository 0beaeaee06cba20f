// SPDX-License-Identifier: MIT
#include "image/exr_codec.h"

#include <algorithm>
#include <climits>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <string>
#include <vector>

#include <Iex.h>
#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfIO.h>
#include <ImfInputPart.h>
#include <ImfMultiPartInputFile.h>
#include <ImfOutputFile.h>
#include <ImfPartType.h>
#include <ImfStandardAttributes.h>
#include <ImfStringAttribute.h>

#include "image/exr_header.h"
#include "image/primaries.h"

using Imath::Box2i;

namespace {

constexpr size_t pixel_bytes = 4 * sizeof(float);

class ByteInput : public Imf::IStream {
  public:
    ByteInput(const char *data, size_t size) : Imf::IStream("it"), data_(data), size_(size) {}
    bool read(char to[], int count) override
    {
        if (count < 0 || at_ > size_ || static_cast<uint64_t>(count) > size_ - at_)
            throw Iex::InputExc("it ends too early");
        std::memcpy(to, data_ + at_, static_cast<size_t>(count));
        at_ += static_cast<uint64_t>(count);
        return at_ < size_;
    }
    uint64_t tellg() override { return at_; }
    void seekg(uint64_t to) override { at_ = to; }

  private:
    const char *data_;
    uint64_t size_, at_ = 0;
};

class ByteOutput : public Imf::OStream {
  public:
    ByteOutput() : Imf::OStream("it") {}
    void write(const char from[], int count) override
    {
        bytes.resize(std::max(bytes.size(), at_ + static_cast<size_t>(count)));
        std::memcpy(&bytes[at_], from, static_cast<size_t>(count));
        at_ += static_cast<size_t>(count);
    }
    uint64_t tellp() override { return at_; }
    void seekp(uint64_t to) override { at_ = to; }
    std::string bytes;

  private:
    size_t at_ = 0;
};

/* Returns the status of `work`, or of the exception that it throws. */
template <typename Work> iso_status guarded(const char *path, iso_error *err, Work work)
{
    try {
        return work();
    } catch (const std::bad_alloc &) {
        return iso_fail(err, ISO_E_MEMORY, "%s: no memory for its pixels", path);
    } catch (const std::exception &e) {
        return iso_fail(err, ISO_E_FORMAT, "%s: damaged OpenEXR picture: %s", path, e.what());
    } catch (...) {
        return iso_fail(err, ISO_E_FORMAT, "%s: damaged OpenEXR picture", path);
    }
}

/* ---- parts ---- */

bool is_deep(const Imf::Header &header) { return header.hasType() && Imf::isDeepData(header.type()); }

/* Returns the parts that are pictures, as: 1 "left", 2 "right". */
std::string list_parts(const Imf::MultiPartInputFile &file)
{
    std::string list;
    for (int i = 0; i < file.parts(); ++i) {
        const Imf::Header &header = file.header(i);
        list += (list.empty() ? "" : ", ") + std::to_string(i + 1) + " \"" + (header.hasName() ? header.name() : "") +
                "\"" + (is_deep(header) ? " (deep)" : "");
    }
    return list;
}

bool is_named(const Imf::MultiPartInputFile &file, int part, const char *name)
{
    return file.header(part).hasName() && file.header(part).name() == name;
}

/* Returns the part of that name, else of that number from 1, else -1. */
int find_part(const Imf::MultiPartInputFile &file, const char *wanted)
{
    for (int i = 0; i < file.parts(); ++i)
        if (is_named(file, i, wanted))
            return i;
    char *end;
    const long number = std::strtol(wanted, &end, 10);
    return *wanted && !*end && number >= 1 && number <= file.parts() ? static_cast<int>(number - 1) : -1;
}

iso_status choose_part(const char *path, const Imf::MultiPartInputFile &file, iso_image_choice *choice, int *part,
                       iso_error *err)
{
    int pictures = 0;
    for (int i = file.parts(); i-- > 0;)
        if (!is_deep(file.header(i))) {
            *part = i;
            ++pictures;
        }
    if (pictures == 0)
        return iso_fail(err, ISO_E_FORMAT, "%s: is a deep OpenEXR picture, must be a flat one; flatten it", path);
    if (choice && choice->part && file.parts() > 1) {
        choice->used_part = true;
        *part = find_part(file, choice->part);
        if (*part < 0)
            return iso_fail(err, ISO_E_RANGE, "%s: has no part \"%s\"; its parts are %.600s", path, choice->part,
                            list_parts(file).c_str());
        if (is_deep(file.header(*part)))
            return iso_fail(err, ISO_E_FORMAT, "%s: part \"%s\" is deep, must be flat; its parts are %.600s", path,
                            choice->part, list_parts(file).c_str());
    } else if (pictures > 1)
        return iso_fail(err, ISO_E_FORMAT, "%s: has %d parts, must be one; choose by --part: %.600s", path, file.parts(),
                        list_parts(file).c_str());
    return ISO_OK;
}

/* ---- channels ---- */

/* Names of the channels to take; gray stands for all three colors. */
struct Channels {
    std::string names[4];
    bool is_gray = false;
};

bool has_color(const Imf::ChannelList &list, const std::string &prefix)
{
    for (const char *name : {"R", "G", "B"})
        if (!list.findChannel(prefix + name))
            return false;
    return true;
}

bool has_gray(const Imf::ChannelList &list, const std::string &prefix)
{
    return list.findChannel(prefix + "Y") && !list.findChannel(prefix + "RY") && !list.findChannel(prefix + "BY");
}

bool has_picture(const Imf::ChannelList &list, const std::string &prefix)
{
    return has_color(list, prefix) || has_gray(list, prefix);
}

/* Returns the layers that are pictures, or with `all` every channel. */
std::string list_channels(const Imf::ChannelList &list, bool all)
{
    std::string text;
    for (auto i = list.begin(); i != list.end(); ++i) {
        const std::string name = i.name();
        const size_t point = name.rfind('.');
        const bool is_first = point != std::string::npos && has_picture(list, name.substr(0, point + 1)) &&
                              name.substr(point + 1) == (has_color(list, name.substr(0, point + 1)) ? "B" : "Y");
        if (all || is_first)
            text += (text.empty() ? "\"" : ", \"") + (all ? name : name.substr(0, point)) + "\"";
    }
    return text;
}

iso_status refuse_channels(const char *path, const Imf::ChannelList &list, const iso_image_choice *choice, iso_error *err)
{
    const std::string layers = list_channels(list, false);
    if (choice && choice->layer && !layers.empty())
        return iso_fail(err, ISO_E_RANGE, "%s: has no layer \"%s\" with channels R, G and B; its layers are %.600s", path,
                        choice->layer, layers.c_str());
    if (!layers.empty())
        return iso_fail(err, ISO_E_FORMAT, "%s: has no channels R, G and B outside of layers; choose by --layer: %.600s",
                        path, layers.c_str());
    return iso_fail(err, ISO_E_FORMAT, "%s: has no channels R, G and B, and no gray channel Y; its channels are %.600s",
                    path, list_channels(list, true).c_str());
}

iso_status choose_channels(const char *path, const Imf::ChannelList &list, iso_image_choice *choice, Channels *channels,
                           iso_error *err)
{
    std::string prefix;
    if (choice && choice->layer && has_picture(list, std::string(choice->layer) + ".")) {
        prefix = std::string(choice->layer) + ".";
        choice->used_layer = true;
    } else if (!has_picture(list, "") || (choice && choice->layer && !list_channels(list, false).empty()))
        return refuse_channels(path, list, choice, err);
    channels->is_gray = !has_color(list, prefix);
    for (int c = 0; c < 4; ++c) {
        channels->names[c] = prefix + (channels->is_gray && c == 0 ? 'Y' : "RGBA"[c]);
        const Imf::Channel *channel = list.findChannel(channels->names[c]);
        if (channel && (channel->xSampling != 1 || channel->ySampling != 1))
            return iso_fail(err, ISO_E_FORMAT, "%s: channel %s has a value per %d x %d pixels, must be one per pixel", path,
                            channels->names[c].c_str(), channel->xSampling, channel->ySampling);
    }
    return ISO_OK;
}

/* ---- pixels ---- */

constexpr int most_edge = 65536, most_tile_edge = 4096;

/* Refuses headers by which the library would reserve more than the file can fill: tables follow the windows,
 * buffers the tiles. */
iso_status check_header(const char *path, const char *data, size_t size, iso_error *err)
{
    static const bool is_limited = (Imf::Header::setMaxImageSize(most_edge, most_edge),
                                    Imf::Header::setMaxTileSize(most_tile_edge, most_tile_edge), true);
    (void)is_limited;
    return iso_exr_header_check(path, data, size, err);
}

int64_t width_of(const Box2i &window) { return static_cast<int64_t>(window.max.x) - window.min.x + 1; }
int64_t height_of(const Box2i &window) { return static_cast<int64_t>(window.max.y) - window.min.y + 1; }

iso_status check_window(const char *path, const char *name, const Box2i &window, iso_error *err)
{
    const int64_t width = width_of(window), height = height_of(window);
    if (width < 1 || height < 1 || width > most_edge || height > most_edge)
        return iso_fail(err, ISO_E_RANGE, "%s: %s window is %lld x %lld, each must be 1 to %d", path, name,
                        static_cast<long long>(width), static_cast<long long>(height), most_edge);
    return ISO_OK;
}

/* Refuses pictures that the file cannot hold. Constant pictures of PIZ and DWA have 42,000 times their bytes; the two
 * windows are separate, so that a short file may name a display window of gigabytes. */
iso_status check_bytes(const char *path, const Box2i &window, size_t size, iso_error *err)
{
    const uint64_t bytes = pixel_bytes * static_cast<uint64_t>(width_of(window)) * static_cast<uint64_t>(height_of(window));
    const uint64_t most = (UINT64_C(64) << 20) + 65536 * static_cast<uint64_t>(size);
    if (bytes > most)
        return iso_fail(err, ISO_E_FORMAT, "%s: its window of %lld x %lld pixels is more than a file of %zu bytes can hold",
                        path, static_cast<long long>(width_of(window)), static_cast<long long>(height_of(window)), size);
    return ISO_OK;
}

/* Has rows read into `row`, whose first pixel is the data window's first column. */
void aim(Imf::InputPart &part, const Channels &channels, int32_t first_column, std::vector<float> &row)
{
    Imf::FrameBuffer buffer;
    const intptr_t first = reinterpret_cast<intptr_t>(row.data()) - static_cast<intptr_t>(pixel_bytes) * first_column;
    for (int c = 0; c < 4; ++c)
        if (c == 0 || c == 3 || !channels.is_gray)
            buffer.insert(channels.names[c],
                          Imf::Slice(Imf::FLOAT, reinterpret_cast<char *>(first) + static_cast<size_t>(c) * sizeof(float),
                                     pixel_bytes, 0, 1, 1, 1.0));
    part.setFrameBuffer(buffer);
}

/* Fills the display window's pixels that the data window has. */
void read_rows(Imf::InputPart &part, const Channels &channels, iso_image *image)
{
    const Box2i &data = part.header().dataWindow(), &display = part.header().displayWindow();
    const int64_t x0 = std::max(data.min.x, display.min.x), x1 = std::min(data.max.x, display.max.x);
    const int64_t y0 = std::max(data.min.y, display.min.y), y1 = std::min(data.max.y, display.max.y);
    std::vector<float> row(4 * static_cast<size_t>(width_of(data)));
    aim(part, channels, data.min.x, row);
    for (int64_t y = y0; y <= y1 && x0 <= x1; ++y) {
        part.readPixels(static_cast<int>(y));
        for (size_t i = 0; channels.is_gray && i < row.size(); i += 4)
            row[i + 1] = row[i + 2] = row[i];
        std::memcpy(image->rgba + 4 * (static_cast<size_t>(y - display.min.y) * image->width +
                                       static_cast<size_t>(x0 - display.min.x)),
                    row.data() + 4 * static_cast<size_t>(x0 - data.min.x),
                    pixel_bytes * static_cast<size_t>(x1 - x0 + 1));
    }
}

iso_status convert_colors(const char *path, const Imf::Header &header, iso_image *image, iso_error *err)
{
    if (!Imf::hasChromaticities(header))
        return ISO_OK;
    const Imf::Chromaticities &c = Imf::chromaticities(header);
    const iso_primaries p = {{{c.red.x, c.red.y}, {c.green.x, c.green.y}, {c.blue.x, c.blue.y}, {c.white.x, c.white.y}}};
    return iso_primaries_convert(path, &p, image, err);
}

iso_status decode(const char *path, Imf::IStream &input, size_t size, iso_image_choice *choice, iso_image *image,
                  iso_error *err)
{
    int number = 0;
    Channels channels;
    Imf::MultiPartInputFile file(input, 0, false);
    iso_status status = choose_part(path, file, choice, &number, err);
    if (status != ISO_OK)
        return status;
    const Imf::Header &header = file.header(number);
    const Box2i &display = header.displayWindow();
    if ((status = check_window(path, "data", header.dataWindow(), err)) != ISO_OK ||
        (status = check_window(path, "display", display, err)) != ISO_OK ||
        (status = check_bytes(path, header.dataWindow(), size, err)) != ISO_OK ||
        (status = check_bytes(path, display, size, err)) != ISO_OK ||
        (status = choose_channels(path, header.channels(), choice, &channels, err)) != ISO_OK)
        return status;
    if (choice)
        choice->has_alpha = header.channels().findChannel(channels.names[3]) != nullptr;
    Imf::InputPart part(file, number);
    if ((status = iso_image_create(image, static_cast<size_t>(width_of(display)), static_cast<size_t>(height_of(display)),
                                   err)) != ISO_OK)
        return iso_fail_in(err, status, "%s", path);
    image->origin[0] = display.min.x;
    image->origin[1] = display.min.y;
    read_rows(part, channels, image);
    return channels.is_gray ? ISO_OK : convert_colors(path, header, image, err);
}

iso_status encode(const iso_image *image, const iso_image_note *notes, Imf::OStream &output)
{
    Imf::Header header(static_cast<int>(image->width), static_cast<int>(image->height));
    Imf::FrameBuffer buffer;
    header.compression() = Imf::ZIP_COMPRESSION;
    for (size_t c = 0; c < 4; ++c) {
        const char name[2] = {"RGBA"[c], 0};
        header.channels().insert(name, Imf::Channel(Imf::FLOAT));
        buffer.insert(name, Imf::Slice(Imf::FLOAT, reinterpret_cast<char *>(image->rgba + c), pixel_bytes,
                                       pixel_bytes * image->width));
    }
    for (; notes && notes->key; ++notes)
        if (notes->value[0])
            header.insert(notes->key, Imf::StringAttribute(notes->value));
    Imf::OutputFile file(output, header, 0);
    file.setFrameBuffer(buffer);
    file.writePixels(static_cast<int>(image->height));
    return ISO_OK;
}

} // namespace

iso_status iso_exr_decode(const char *path, const char *data, size_t size, iso_image_choice *choice, iso_image *image,
                          iso_error *err)
{
    ByteInput input(data, size);
    *image = iso_image{};
    NEED(check_header(path, data, size, err));
    iso_status status = guarded(path, err, [&] { return decode(path, input, size, choice, image, err); });
    if (status != ISO_OK)
        iso_image_destroy(image);
    return status;
}

iso_status iso_exr_decode_header(const char *path, const char *data, size_t size, iso_exr_header *header, iso_error *err)
{
    ByteInput input(data, size);
    *header = iso_exr_header{};
    const iso_status status = check_header(path, data, size, err);
    return status != ISO_OK ? status : guarded(path, err, [&] {
        int number = 0;
        Imf::MultiPartInputFile file(input, 0, false);
        iso_status status = choose_part(path, file, nullptr, &number, err);
        const Imf::Header &found = file.header(number);
        if (status != ISO_OK || (status = check_window(path, "data", found.dataWindow(), err)) != ISO_OK)
            return status;
        header->width = static_cast<size_t>(width_of(found.dataWindow()));
        header->height = static_cast<size_t>(height_of(found.dataWindow()));
        header->is_cropped = found.dataWindow() != found.displayWindow();
        for (unsigned c = 0; c < 4; ++c) {
            const Imf::Channel *channel = found.channels().findChannel(std::string(1, "RGBA"[c]));
            if (channel && channel->xSampling == 1 && channel->ySampling == 1)
                header->channels |= 1u << c;
        }
        return ISO_OK;
    });
}

iso_status iso_exr_encode(const char *path, const iso_image *image, const iso_image_note *notes, char **data, size_t *size,
                          iso_error *err)
{
    ByteOutput output;
    *data = nullptr;
    if (image->width > INT_MAX || image->height > INT_MAX)
        return iso_fail(err, ISO_E_RANGE, "%s: %zu x %zu pixels, each must be at most %d", path, image->width,
                        image->height, INT_MAX);
    const iso_status status = guarded(path, err, [&] { return encode(image, notes, output); });
    if (status != ISO_OK)
        return status == ISO_E_FORMAT ? ISO_E_IO : status;
    *size = output.bytes.size();
    *data = static_cast<char *>(std::malloc(*size));
    if (!*data)
        return iso_fail(err, ISO_E_MEMORY, "%s: no memory for %zu bytes", path, *size);
    std::memcpy(*data, output.bytes.data(), *size);
    return ISO_OK;
}
