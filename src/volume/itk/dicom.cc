/* SPDX-License-Identifier: MIT */
#include "volume/itk/dicom.h"

#include <cmath>
#include <fstream>
#include <set>

#include "volume/itk/dicom_elements.h"

/* ---- mosaics ---- */

/* Siemens mosaics: a picture whose tiles are the slices of a volume, row by row, in a square.
 *
 * The number of slices and their normal are private elements of Siemens. */
namespace {

struct Mosaic {
    bool is_one = false;
    size_t tiles = 0, side = 0; /* slices, 0: their number is missing; tiles in a row */
    Numbers normal;             /* from slice to slice; empty if it is missing */
};


/* Returns the element of a private block that `creator` owns; empty if there is none. */
std::string private_bytes(const DataSet &all, uint16_t group, const char *creator, unsigned element)
{
    for (unsigned block = 0x10; block < 0x20; ++block)
        if (text_in(&all, Tag(group, static_cast<uint16_t>(block))) == creator)
            return bytes_in(&all, Tag(group, static_cast<uint16_t>(block << 8 | element)));
    return "";
}

uint32_t word_at(const std::string &bytes, size_t at)
{
    uint32_t value = 0;
    if (at + sizeof value <= bytes.size())
        memcpy(&value, &bytes[at], sizeof value); /* little-endian, as this program's machines are */
    return value;
}

/* Returns the numbers of an entry of Siemens' CSA header; none if it is missing or damaged.
 *
 * Version 2 starts with "SV10" and 4 bytes. Then: the number of entries, a word; per entry a name of 64 bytes, three
 * words, the number of items, a word; per item four words and a text padded to 4 bytes. The second of the four words is
 * the text's length; in version 1 the first one, less the number of items of the first entry. */
Numbers csa_numbers(const std::string &csa, const std::string &name)
{
    constexpr size_t entry_bytes = 84, most_items = 1024;
    const bool is_second = csa.compare(0, 4, "SV10") == 0;
    size_t at = is_second ? 8 : 0;
    const uint32_t entries = word_at(csa, at);
    uint32_t first_items = 0;
    at += 8;
    for (uint32_t i = 0; i < entries && at + entry_bytes <= csa.size(); ++i) {
        const bool is_wanted = csa.compare(at, name.size() + 1, name.c_str(), name.size() + 1) == 0;
        const uint32_t items = word_at(csa, at + 76);
        first_items = i == 0 ? items : first_items;
        at += entry_bytes;
        Numbers found;
        for (uint32_t k = 0; k < items && k < most_items && at + 16 <= csa.size(); ++k) {
            const size_t length = is_second ? word_at(csa, at + 4) : word_at(csa, at) - first_items;
            at += 16;
            if (length > csa.size() - at)
                return {};
            const Numbers one = decimals_of(std::string(csa, at, length).c_str());
            if (one.size() == 1)
                found.push_back(one[0]);
            at += (length + 3) / 4 * 4;
            at = std::min(at, csa.size());
        }
        if (is_wanted)
            return found;
    }
    return {};
}

size_t count_of_tiles(const DataSet &all, const std::string &csa)
{
    const Numbers count = csa_numbers(csa, "NumberOfImagesInMosaic");
    const std::string own = private_bytes(all, 0x0019, "SIEMENS MR HEADER", 0x0a),
                      times = private_bytes(all, 0x0019, "SIEMENS MR HEADER", 0x29); /* MosaicRefAcqTimes */
    uint16_t number = 0;
    if (own.size() >= sizeof number)
        memcpy(&number, own.data(), sizeof number);
    return !count.empty() && count[0] >= 1 && count[0] < 65536 ? static_cast<size_t>(count[0])
           : number > 0                                        ? number
                                                               : times.size() / sizeof(double);
}


Mosaic mosaic_of(const DataSet &all)
{
    Mosaic m;
    if (text_in(&all, Tag(0x0008, 0x0008)).find("MOSAIC") == std::string::npos)
        return m;
    const std::string csa = private_bytes(all, 0x0029, "SIEMENS CSA HEADER", 0x10);
    m.is_one = true;
    m.tiles = count_of_tiles(all, csa);
    m.side = static_cast<size_t>(std::ceil(std::sqrt(m.tiles)));
    m.normal = csa_numbers(csa, "SliceNormalVector");
    return m;
}

} // namespace

/* ---- slices ---- */

namespace {

constexpr uint16_t pixels = 0x7fe0;

/* Returns the unit of the last digit of any of the decimals. */
double last_digit_of(const std::string &text)
{
    int most = 0;
    for (const auto &word : words_of(text)) {
        const size_t end = std::min(word.find_first_of("eE"), word.size()), point = word.find('.');
        const int exponent = end < word.size() ? atoi(word.c_str() + end + 1) : 0;
        const size_t last = word.find_last_of("0123456789", end);
        const int after = point < end && last != std::string::npos && last > point ? static_cast<int>(last - point) : 0;
        most = std::max(most, after - exponent);
    }
    return std::pow(10, -most);
}

/* The element sets of a frame, the first of which comes first: its own groups, the shared ones, and the file's. */
struct Sets {
    const DataSet *file, *frame, *shared;

    /* An element of a functional group, or of the file itself. */
    std::string text(const Tag &group, const Tag &tag) const
    {
        for (const DataSet *set : {frame, shared}) {
            const Items items(set, group);
            const std::string own = text_in(items.at(0), tag);
            if (!own.empty())
                return own;
        }
        return text_in(file, tag);
    }
    template <typename T> std::string binary(const Tag &group, const Tag &tag) const
    {
        for (const DataSet *set : {frame, shared}) {
            const Items items(set, group);
            const std::string own = binary_text(binary_in<T>(items.at(0), tag));
            if (!own.empty())
                return own;
        }
        return "";
    }
};

const Tag pixel_measures(0x0028, 0x9110), plane_orientation(0x0020, 0x9116), plane_position(0x0020, 0x9113),
    value_transformation(0x0028, 0x9145), frame_content(0x0020, 0x9111), cardiac(0x0018, 0x9118), echo(0x0018, 0x9114),
    diffusion(0x0018, 0x9117), segment_identification(0x0062, 0x000a);

/* Returns the value of each key of stack.h, by the frame's groups or by the file. */
std::vector<std::string> keys_of(const Sets &sets)
{
    std::vector<std::string> keys;
    for (const auto &key : plane_keys) {
        const std::string tag = key.tag;
        std::string value = tag == "0020|0100"   ? sets.binary<uint32_t>(frame_content, Tag(0x0020, 0x9128))
                            : tag == "0018|1060" ? sets.binary<double>(cardiac, Tag(0x0020, 0x9153))
                            : tag == "0008|002a" ? sets.text(frame_content, Tag(0x0018, 0x9074))
                            : tag == "0018|0081" ? sets.binary<double>(echo, Tag(0x0018, 0x9082))
                            : tag == "0018|9087" ? sets.binary<double>(diffusion, Tag(0x0018, 0x9087))
                                                 : "";
        unsigned group, element;
        sscanf(key.tag, "%x|%x", &group, &element);
        const Tag own(static_cast<uint16_t>(group), static_cast<uint16_t>(element));
        const bool is_binary = tag == "0018|9087";
        if (value.empty())
            value = is_binary ? binary_text(binary_in<double>(sets.file, own)) : text_in(sets.file, own);
        keys.push_back(value);
    }
    return keys;
}

double length_of(const Vector &a)
{
    return std::hypot(a[0], a[1], a[2]);
}

Vector cross(const Vector &a, const Vector &b)
{
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

/* Returns two spacings, between rows and then between columns; empty if the file lacks them. */
Numbers pixel_spacing(const Sets &sets, DicomFile &file)
{
    struct {
        Tag tag;
        const char *warning;
    } const all[] = {
        {Tag(0x0028, 0x0030), ""},
        {Tag(0x0018, 0x2010), ""},
        {Tag(0x0018, 0x1164), "the spacing of pixels is ImagerPixelSpacing, at the detector: the patient is smaller"},
    };
    for (const auto &one : all) {
        const Numbers spacing = decimals_of(sets.text(pixel_measures, one.tag));
        if (spacing.size() != 2 || !(spacing[0] > 0) || !(spacing[1] > 0))
            continue;
        file.warning = *one.warning ? file.path + ": " + one.warning : "";
        return spacing;
    }
    return {};
}

/* Reads directions, which must be unit vectors at right angles, up to the digits that the file has; and spacing. */
void take_axes(const Sets &sets, DicomFile &file, DicomFrame &frame)
{
    const std::string text = sets.text(plane_orientation, Tag(0x0020, 0x0037));
    const Numbers turn = decimals_of(text), spacing = pixel_spacing(sets, file);
    Vector u{1, 0, 0}, v{0, 1, 0};
    file.has_direction = turn.size() == 6;
    if (file.has_direction) {
        u = {turn[0], turn[1], turn[2]}, v = {turn[3], turn[4], turn[5]};
        const Vector n = cross(u, v);
        const double dot = u[0] * v[0] + u[1] * v[1] + u[2] * v[2];
        if (!(std::fabs(length_of(u) - 1) < 0.01) || !(std::fabs(length_of(v) - 1) < 0.01) || !(std::fabs(dot) < 0.01))
            fail(ISO_E_FORMAT, file.path + ": ImageOrientationPatient is \"" + text +
                                   "\", must be two unit vectors at a right angle");
        const double nu = length_of(u), nn = length_of(n);
        for (size_t r = 0; r < 3; ++r)
            u[r] /= nu;
        v = cross({n[0] / nn, n[1] / nn, n[2] / nn}, u);
        frame.plane.turn_digit = last_digit_of(text);
    }
    if (spacing.empty())
        file.unspaced = "of its pixels";
    for (size_t r = 0; r < 3; ++r) {
        frame.u[r] = u[r] * (spacing.empty() ? 1 : spacing[1]);
        frame.v[r] = v[r] * (spacing.empty() ? 1 : spacing[0]);
    }
}

void take_place(const Sets &sets, DicomFrame &frame)
{
    const std::string text = sets.text(plane_position, Tag(0x0020, 0x0032));
    const Numbers place = decimals_of(text);
    frame.has_place = place.size() == 3;
    if (!frame.has_place)
        return;
    frame.plane.first = {place[0], place[1], place[2]};
    frame.plane.digit = last_digit_of(text);
}

/* Returns an element of the file, which must be a number; `none` if it is missing. */
double number_or(const std::string &text, double none, const char *name, const DicomFile &file)
{
    const Numbers value = decimals_of(text);
    if (text.empty())
        return none;
    if (value.size() != 1)
        fail(ISO_E_FORMAT, file.path + ": " + name + " is \"" + text + "\", must be a number");
    return value[0];
}

void take_scale(const Sets &sets, const DicomFile &file, DicomFrame &frame)
{
    const std::string slope = sets.text(value_transformation, Tag(0x0028, 0x1053)),
                      intercept = sets.text(value_transformation, Tag(0x0028, 0x1052));
    const std::string dose = text_in(sets.file, Tag(0x3004, 0x000e));
    frame.slope = number_or(slope, 1, "RescaleSlope", file) * number_or(dose, 1, "DoseGridScaling", file);
    frame.intercept = number_or(intercept, 0, "RescaleIntercept", file);
    if (frame.slope == 0)
        fail(ISO_E_FORMAT, file.path + ": the slope of its values is 0, must not be");
    const bool is_dose = text_in(sets.file, Tag(0x0008, 0x0016)) == "1.2.840.10008.5.1.4.1.1.481.2";
    if (is_dose && dose.empty())
        fail(ISO_E_FORMAT, file.path + ": an RT dose without DoseGridScaling, which gives its values their unit");
    if (slope.empty() && Items(sets.file, Tag(0x0028, 0x3000)).count() > 0)
        fail(ISO_E_FORMAT, file.path + ": its values go through a ModalityLUTSequence, which is not read");
}

/* Returns the unit of rescaled values. Of CT it is HU unless the file has another one; US is "unspecified". */
std::string value_unit_of(const Sets &sets)
{
    const std::string type = sets.text(value_transformation, Tag(0x0028, 0x1054));
    const std::string modality = text_in(sets.file, Tag(0x0008, 0x0060));
    if (!type.empty())
        return type == "US" ? "" : type;
    if (modality == "PT")
        return text_in(sets.file, Tag(0x0054, 0x1001));
    const bool is_rescaled = !sets.text(value_transformation, Tag(0x0028, 0x1052)).empty();
    return modality == "CT" && is_rescaled ? "HU" : "";
}

/* Reads one of the three tables of a palette: LUT data of 16 bits, or two of 8 bits in each word. */
std::vector<uint16_t> palette_entries(const DataSet &all, uint16_t color, size_t count, unsigned bits,
                                      const std::string &path)
{
    const std::string bytes = bytes_in(&all, Tag(0x0028, static_cast<uint16_t>(0x1201 + color)));
    const bool is_packed = bits == 8 && bytes.size() < 2 * count;
    std::vector<uint16_t> entries(count);
    if (bytes.size() < (is_packed ? count : 2 * count))
        fail(ISO_E_FORMAT, path + ": its palette has " + std::to_string(bytes.size()) + " bytes for " +
                               std::to_string(count) + " colors of " + std::to_string(bits) +
                               " bits; segmented palettes are not read");
    for (size_t i = 0; i < count; ++i) {
        if (is_packed)
            entries[i] = static_cast<unsigned char>(bytes[i]);
        else
            memcpy(&entries[i], &bytes[2 * i], sizeof entries[i]);
        entries[i] &= bits == 8 ? 0xff : 0xffff;
    }
    return entries;
}

void take_palette(const DataSet &all, DicomFile &file)
{
    const std::string bytes = bytes_in(&all, Tag(0x0028, 0x1101));
    uint16_t words[3] = {};
    memcpy(words, bytes.data(), std::min(bytes.size(), sizeof words));
    const size_t count = words[0] == 0 ? 65536 : words[0];
    if (bytes.size() < sizeof words || (words[2] != 8 && words[2] != 16))
        fail(ISO_E_FORMAT, file.path + ": its samples are indices into a palette that is missing");
    file.palette.first = file.is_signed ? static_cast<int16_t>(words[1]) : words[1];
    file.palette.bits = words[2];
    for (uint16_t c = 0; c < 3; ++c)
        file.palette.entries[c] = palette_entries(all, c, count, words[2], file.path);
}

/* Reads how pixels are coded. A palette that is gray throughout gives gray values, as such pictures do. */
void take_coding(const DataSet &all, DicomFile &file)
{
    const std::string color = text_in(&all, Tag(0x0028, 0x0004));
    const double components = binary_in<uint16_t>(&all, Tag(0x0028, 0x0002));
    Coding &coding = file.coding;
    coding.bits = file.bits_allocated;
    coding.has_whole_bytes = coding.bits != 1;
    coding.components = components > 1 ? static_cast<size_t>(components) : 1;
    coding.is_in_planes = binary_in<uint16_t>(&all, Tag(0x0028, 0x0006)) == 1;
    const bool is_small = file.samples == Samples::integer && (coding.bits == 8 || coding.bits == 16);
    if (color == "PALETTE COLOR" && coding.components == 1 && is_small) {
        take_palette(all, file);
        coding.color = Color::palette;
    } else if (coding.components == 1)
        return;
    else if (coding.components == 3 && is_small && (color == "RGB" || color == "YBR_RCT" || color == "YBR_ICT"))
        coding.color = Color::rgb;
    else if (coding.components == 3 && is_small && (color == "YBR_FULL" || color == "YBR_FULL_422"))
        coding.color = color == "YBR_FULL" ? Color::ybr : Color::ybr_half;
    else
        fail(ISO_E_FORMAT, file.path + ": " + std::to_string(coding.components) + " components per voxel (" + color +
                               "), must be RGB, YBR_FULL, YBR_FULL_422 or PALETTE COLOR of 8 or 16 bits");
    file.channels = coding.color == Color::palette && file.palette.is_gray() ? 1 : 3;
    choose_channel(file, 0);
}

void take_samples(const DataSet &all, DicomFile &file)
{
    const auto number = [&](uint16_t element, unsigned none) {
        const double value = binary_in<uint16_t>(&all, Tag(0x0028, element));
        return std::isnan(value) ? none : static_cast<unsigned>(value);
    };
    file.samples = all.FindDataElement(Tag(pixels, 0x0008))   ? Samples::float32
                   : all.FindDataElement(Tag(pixels, 0x0009)) ? Samples::float64
                                                              : Samples::integer;
    if (file.samples != Samples::integer) {
        file.bits_allocated = file.samples == Samples::float32 ? 32 : 64;
        return;
    }
    file.bits_allocated = number(0x0100, 0);
    file.bits_stored = number(0x0101, file.bits_allocated);
    file.high_bit = number(0x0102, file.bits_stored - 1);
    file.is_signed = number(0x0103, 0) == 1;
    if (const unsigned padding = number(0x0120, 0))
        file.padding = file.is_signed ? static_cast<double>(static_cast<int16_t>(padding)) : padding;
    const unsigned bits = file.bits_allocated;
    if (bits != 1 && bits != 8 && bits != 16 && bits != 32)
        fail(ISO_E_FORMAT, file.path + ": BitsAllocated is " + std::to_string(bits) + ", must be 1, 8, 16 or 32");
    if (file.bits_stored < 1 || file.bits_stored > bits || file.high_bit >= bits ||
        file.high_bit + 1 < file.bits_stored)
        fail(ISO_E_FORMAT, file.path + ": damaged: BitsStored is " + std::to_string(file.bits_stored) + ", HighBit " +
                               std::to_string(file.high_bit) + " of " + std::to_string(bits) + " bits");
}

void move(Plane &plane, const Vector &along, double by)
{
    for (size_t r = 0; r < 3; ++r)
        plane.first[r] += by * along[r];
}

/* Offsets of the frames (PS3.3 C.8.8.3.2), from the first frame along the normal, or, if they start with the first
 * frame's z, the z of each. Empty if the file has none. */
Numbers frame_offsets(const DataSet &all, const DicomFile &file, const Vector &n)
{
    Numbers offsets = decimals_in(&all, Tag(0x3004, 0x000c));
    if (offsets.empty())
        return {};
    const Plane &first = file.frames[0].plane;
    const double start = offsets[0];
    const bool is_z = start != 0 && std::fabs(start - first.first[2]) <= 1e-3 && std::fabs(n[2]) > 0.999;
    if (offsets.size() != file.frames.size() || (start != 0 && !is_z))
        fail(ISO_E_FORMAT, file.path + ": GridFrameOffsetVector has " + std::to_string(offsets.size()) +
                               " offsets for " + std::to_string(file.frames.size()) + " frames, the first is " +
                               binary_text(start) + ", must be 0 or the frame's z");
    for (auto &offset : offsets)
        offset = (offset - start) * (is_z ? n[2] : 1);
    return offsets;
}

/* Places the frames of a file that gives only the first one's place, or none. */
void place_frames(const DataSet &all, const DataSet *shared, DicomFile &file)
{
    const DicomFrame &first = file.frames[0];
    Vector n = cross(first.u, first.v);
    const double length = length_of(n);
    for (auto &r : n)
        r /= length;
    Numbers offsets = frame_offsets(all, file, n);
    const std::string said = Sets{&all, nullptr, shared}.text(pixel_measures, Tag(0x0018, 0x0088));
    const double step = number_or(said, 0, "SpacingBetweenSlices", file);
    if (offsets.empty() && step == 0 && !file.unspaced.empty())
        file.unspaced = "of its voxels";
    else if (offsets.empty() && step == 0) {
        const std::string thick = Sets{&all, nullptr, shared}.text(pixel_measures, Tag(0x0018, 0x0050));
        file.unspaced = "between its frames" + (thick.empty() ? "" : " (SliceThickness " + thick + " is not that)");
    }
    for (size_t k = 0; k < file.frames.size(); ++k) {
        file.frames[k].plane.first = first.plane.first;
        file.frames[k].has_place = first.has_place;
    }
    for (size_t k = 1; k < file.frames.size(); ++k)
        move(file.frames[k].plane, n, offsets.empty() ? static_cast<double>(k) * (step == 0 ? 1 : step) : offsets[k]);
}

void check_frames(const DicomFile &file)
{
    const DicomFrame &first = file.frames[0];
    for (size_t i = 1; i < file.frames.size(); ++i) {
        const DicomFrame &other = file.frames[i];
        for (size_t r = 0; r < 3; ++r)
            if (!(std::fabs(first.u[r] - other.u[r]) <= 1e-4) || !(std::fabs(first.v[r] - other.v[r]) <= 1e-4))
                fail(ISO_E_FORMAT, file.path + ": its frames 1 and " + std::to_string(i + 1) +
                                       " are turned against each other, or of different spacings");
    }
}

/* Turns the only frame into one per tile. The picture's place is the corner of a slice of the whole picture's size with
 * the same center. */
void take_tiles(const DataSet &all, const Mosaic &mosaic, DicomFile &file)
{
    const double said = number_or(text_in(&all, Tag(0x0018, 0x0088)), 0, "SpacingBetweenSlices", file);
    if (mosaic.tiles == 0)
        fail(ISO_E_FORMAT, file.path + ": a mosaic of slices in one picture without Siemens' number of them");
    if (file.frames.size() != 1 || file.columns % mosaic.side != 0 || file.rows % mosaic.side != 0)
        fail(ISO_E_FORMAT, file.path + ": damaged: a mosaic of " + std::to_string(mosaic.tiles) + " slices in " +
                               std::to_string(file.frames.size()) + " pictures of " + std::to_string(file.columns) +
                               " x " + std::to_string(file.rows) + " pixels");
    if (!(said > 0))
        file.unspaced = "between its slices";
    file.tiles = mosaic.side;
    file.columns /= mosaic.side, file.rows /= mosaic.side;
    DicomFrame first = file.frames[0];
    const double more = static_cast<double>(mosaic.side - 1) / 2;
    move(first.plane, first.u, more * static_cast<double>(file.columns));
    move(first.plane, first.v, more * static_cast<double>(file.rows));
    const Vector n = cross(first.u, first.v);
    const Numbers &up = mosaic.normal;
    const bool is_down = up.size() == 3 && n[0] * up[0] + n[1] * up[1] + n[2] * up[2] < 0;
    const double step = (is_down ? -1 : 1) * (said > 0 ? said : 1) / length_of(n);
    file.frames.assign(mosaic.tiles, first);
    for (size_t k = 0; k < mosaic.tiles; ++k) {
        file.frames[k].plane.name = "tile " + std::to_string(k + 1) + " of " + file.path;
        move(file.frames[k].plane, n, step * static_cast<double>(k));
    }
}

void take_frames(const DataSet &all, DicomFile &file)
{
    const Items shared_items(&all, Tag(0x5200, 0x9229)), frame_items(&all, Tag(0x5200, 0x9230));
    const DataSet *shared = shared_items.at(0);
    const double count = number_or(text_in(&all, Tag(0x0028, 0x0008)), 1, "NumberOfFrames", file);
    if (!(count >= 1 && count <= 1e6) || (frame_items.count() > 0 && static_cast<double>(frame_items.count()) != count))
        fail(ISO_E_FORMAT, file.path + ": damaged: NumberOfFrames is " + binary_text(count) + ", there are " +
                               std::to_string(frame_items.count()) + " functional groups of frames");
    bool has_own_places = count == 1;
    const double resolution = number_or(text_in(&all, Tag(0x0020, 0x0110)), 0, "TemporalResolution", file);
    for (size_t k = 0; k < static_cast<size_t>(count); ++k) {
        const Sets sets{&all, frame_items.at(k), shared};
        DicomFrame frame;
        frame.plane.name = count == 1 ? file.path : "frame " + std::to_string(k + 1) + " of " + file.path;
        frame.plane.resolution_ms = resolution;
        take_axes(sets, file, frame);
        take_place(sets, frame);
        take_scale(sets, file, frame);
        if (k == 0)
            file.value_unit = value_unit_of(sets);
        const Items segment(sets.frame, segment_identification);
        const double number = binary_in<uint16_t>(segment.at(0), Tag(0x0062, 0x000b));
        frame.segment = number >= 1 ? static_cast<unsigned>(number) : 0;
        frame.plane.keys = keys_of(sets);
        has_own_places = has_own_places || Items(sets.frame, plane_position).count() > 0;
        file.frames.push_back(frame);
    }
    check_frames(file);
    const Mosaic mosaic = mosaic_of(all);
    if (mosaic.is_one)
        return take_tiles(all, mosaic, file);
    if (!has_own_places)
        return place_frames(all, shared, file);
    for (const auto &frame : file.frames)
        if (!frame.has_place && count > 1)
            fail(ISO_E_FORMAT, file.path + ": some frames have ImagePositionPatient, others do not");
}

/* Reads the names of a segmentation's segments. */
void take_segments(const DataSet &all, DicomFile &file)
{
    const Items segments(&all, Tag(0x0062, 0x0002));
    for (size_t i = 0; i < segments.count(); ++i) {
        const double number = binary_in<uint16_t>(segments.at(i), Tag(0x0062, 0x0004));
        if (number >= 1)
            file.segments.push_back({static_cast<unsigned>(number), text_in(segments.at(i), Tag(0x0062, 0x0005))});
    }
    file.is_label_map = text_in(&all, Tag(0x0062, 0x0001)) == "LABELMAP";
}

/* Takes frames of one place that differ only in InstanceNumber, if the file has their number. */
void take_repetition(const DataSet &all, DicomFile &file)
{
    const Numbers times = decimals_in(&all, Tag(0x0020, 0x0105)), repetition = decimals_in(&all, Tag(0x0018, 0x0080));
    for (auto &frame : file.frames) {
        frame.plane.number = file.number;
        frame.plane.times = times.size() == 1 && times[0] >= 1 ? static_cast<size_t>(times[0]) : 0;
        frame.plane.repetition_ms = repetition.size() == 1 ? repetition[0] : 0;
    }
}

} // namespace

bool has_mark_of_dicom(const std::string &path)
{
    char head[132] = "";
    std::ifstream(path, std::ios::binary).read(head, sizeof head);
    return memcmp(head + 128, "DICM", 4) == 0;
}

bool read_dicom(const std::string &path, DicomFile &file)
{
    const ParseMemory memory(bytes_to_parse(path));
    const Tag samples(pixels, 0x0010);
    gdcm::Reader reader;
    reader.SetFileName(path.c_str());
    if (!reader.ReadUpToTag(samples, {samples}) && !is_whole_deflated(path)) {
        if (has_mark_of_dicom(path))
            fail(ISO_E_FORMAT, path + ": a DICOM file that is damaged, or of a transfer syntax that GDCM lacks");
        return false;
    }
    const DataSet &all = reader.GetFile().GetDataSet();
    const double rows = binary_in<uint16_t>(&all, Tag(0x0028, 0x0010)),
                 columns = binary_in<uint16_t>(&all, Tag(0x0028, 0x0011));
    if (!(rows > 0) || !(columns > 0))
        return false;
    file = DicomFile{};
    file.path = path;
    file.rows = static_cast<size_t>(rows), file.columns = static_cast<size_t>(columns);
    file.series = text_in(&all, Tag(0x0020, 0x000e));
    file.description = text_in(&all, Tag(0x0008, 0x103e));
    file.instance = text_in(&all, Tag(0x0008, 0x0018));
    const Numbers number = decimals_in(&all, Tag(0x0020, 0x0013));
    file.number = number.size() == 1 ? number[0] : NAN;
    take_samples(all, file);
    take_coding(all, file);
    take_frames(all, file);
    take_segments(all, file);
    take_repetition(all, file);
    return true;
}
