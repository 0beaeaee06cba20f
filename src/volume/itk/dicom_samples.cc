/* SPDX-License-Identifier: MIT */
/* dicom_samples.cc - the samples of a DICOM file, and the values that they stand for. */
#include <gdcmPixmapReader.h>
#include <gdcmReader.h>
#include <zlib.h>

#include <cmath>
#include <limits>

#include "volume/itk/dicom_elements.h"
#include "volume/itk/dicom.h"

namespace {

using gdcm::TransferSyntax;

constexpr char rle[] = "1.2.840.10008.1.2.5";

/* Returns the UID of the transfer syntax, also of one that GDCM does not have. */
std::string syntax_of(const gdcm::Reader &reader)
{
    return text_in(&reader.GetFile().GetHeader(), Tag(0x0002, 0x0010));
}

/* Returns the pixels of a picture: of a mosaic all tiles. */
size_t pixels_of(const DicomFile &file)
{
    return file.rows * file.columns * (file.tiles ? file.tiles * file.tiles : 1);
}

size_t pictures_of(const DicomFile &file)
{
    return file.tiles ? 1 : file.frames.size();
}

/* Returns the samples of a picture as they are coded; an odd last pixel of YBR_FULL_422 has a pair of its own. */
size_t samples_of(const DicomFile &file, const Coding &coding)
{
    return coding.color == Color::ybr_half ? (pixels_of(file) + 1) / 2 * 4 : pixels_of(file) * coding.components;
}

size_t picture_bytes(const DicomFile &file, const Coding &coding)
{
    return (samples_of(file, coding) * coding.bits + 7) / 8;
}

size_t all_bytes(const DicomFile &file, const Coding &coding)
{
    return coding.has_whole_bytes ? picture_bytes(file, coding) * pictures_of(file)
                                  : (samples_of(file, coding) * pictures_of(file) + 7) / 8;
}

Tag tag_of_samples(const DicomFile &file)
{
    if (file.coding.color != Color::gray) /* their luminance is given as float */
        return Tag(0x7fe0, 0x0010);
    return Tag(0x7fe0, file.samples == Samples::float32 ? 0x0008 : file.samples == Samples::float64 ? 0x0009 : 0x0010);
}

/* Returns the bytes of the words that GDCM swaps when it reads an element of a big-endian file. */
size_t swapped_bytes(const gdcm::DataElement &element, TransferSyntax syntax)
{
    if (syntax == TransferSyntax::ExplicitVRBigEndian)
        return element.GetVR() == gdcm::VR::OW   ? 2
               : element.GetVR() == gdcm::VR::OF ? 4
               : element.GetVR() == gdcm::VR::OD ? 8
                                                 : 1;
    return syntax == TransferSyntax::ImplicitVRBigEndianPrivateGE ? 1 : 0; /* 0: a little-endian file */
}

/* Corrects the order of swapped words within longer samples. */
void turn_words(std::vector<char> &data, size_t sample, size_t word)
{
    if (word == 0 || word >= sample)
        return;
    std::vector<char> turned(sample);
    for (size_t at = 0; at + sample <= data.size(); at += sample) {
        for (size_t i = 0; i < sample; i += word)
            memcpy(&turned[sample - word - i], &data[at + i], word);
        memcpy(&data[at], turned.data(), sample);
    }
}

/* Turns bytes back that GDCM swapped as words. */
void turn_bytes(std::vector<char> &data)
{
    for (size_t i = 0; i + 1 < data.size(); i += 2)
        std::swap(data[i], data[i + 1]);
}

/* Checks the length of the samples. GDCM accepts a file that ends within them and fills in zeros. So this searches the
 * element: its tag, its type if present, and a length that would be right. */
void check_samples_are_there(const DicomFile &file)
{
    const size_t need = all_bytes(file, file.coding), size = std::filesystem::file_size(file.path);
    std::string head(std::min<size_t>(size, 16 << 20), 0);
    std::ifstream(file.path, std::ios::binary).read(&head[0], static_cast<std::streamsize>(head.size()));
    const std::string tags[] = {{'\xe0', '\x7f', static_cast<char>(tag_of_samples(file).GetElement()), '\0'},
                                {'\x7f', '\xe0', '\0', static_cast<char>(tag_of_samples(file).GetElement())}};
    for (const auto &tag : tags)
        for (size_t at = head.find(tag); at != std::string::npos && at + 12 <= head.size();
             at = head.find(tag, at + 1)) {
            const bool is_typed = head[at + 4] == 'O';
            uint32_t length;
            memcpy(&length, &head[at + (is_typed ? 8 : 4)], 4);
            length = &tag == &tags[1] ? __builtin_bswap32(length) : length;
            const size_t there = size - at - (is_typed ? 12 : 8);
            if (length >= need && length <= need + 1 && there < need)
                fail(ISO_E_FORMAT, file.path + ": truncated: holds " + std::to_string(there) +
                                       " bytes of samples, needs " + std::to_string(need));
        }
}

[[noreturn]] void fail_of_size(const DicomFile &file, size_t has, size_t needs)
{
    fail(ISO_E_FORMAT, file.path + ": truncated or damaged: holds " + std::to_string(has) +
                           " bytes of samples, needs " + std::to_string(needs));
}

/* Returns samples that are not compressed, in the machine's byte order. */
Coded plain_samples(const DicomFile &file, const gdcm::ByteValue &value, size_t word)
{
    const size_t bytes = all_bytes(file, file.coding);
    if (value.GetLength() < bytes)
        fail_of_size(file, value.GetLength(), bytes);
    if (word == 2 && file.coding.bits == 32)
        fail(ISO_E_FORMAT, file.path +
                               ": big-endian samples of 32 bits, of which programs write the 16-bit words in "
                               "different orders; convert the file to little endian with the program that wrote it");
    check_samples_are_there(file);
    Coded coded{file.coding, {value.GetPointer(), value.GetPointer() + bytes}};
    if (word == 2 && file.coding.bits < 16)
        turn_bytes(coded.bytes);
    turn_words(coded.bytes, file.coding.bits / 8, word);
    return coded;
}

/* Returns the coding of GDCM's decoded samples. Its decoder of JPEG 2000 undoes YBR_RCT and YBR_ICT. */
Coding decoded_coding(const DicomFile &file, const gdcm::Pixmap &image)
{
    using gdcm::PhotometricInterpretation;
    Coding coding = file.coding;
    const PhotometricInterpretation color = image.GetPhotometricInterpretation();
    if (coding.components == 1)
        return coding;
    coding.is_in_planes = image.GetPlanarConfiguration() == 1;
    coding.color = color == PhotometricInterpretation::YBR_FULL || color == PhotometricInterpretation::YBR_FULL_422
                       ? Color::ybr
                       : Color::rgb;
    return coding;
}

Coded unpacked_samples(const DicomFile &file)
{
    gdcm::PixmapReader reader;
    reader.SetFileName(file.path.c_str());
    if (file.samples == Samples::integer && file.channels == 1 && file.high_bit + 1 != file.bits_stored)
        fail(ISO_E_FORMAT, file.path + ": compressed samples whose HighBit is not BitsStored - 1, which is not read");
    if (!reader.Read())
        fail(ISO_E_FORMAT, file.path + ": GDCM: its compressed samples are damaged, or of a kind that is not read");
    const gdcm::Pixmap &image = reader.GetPixmap();
    Coded coded{decoded_coding(file, image), {}};
    const size_t bytes = all_bytes(file, coded.coding);
    if (image.GetBufferLength() != bytes)
        fail_of_size(file, image.GetBufferLength(), bytes);
    coded.bytes.resize(bytes);
    if (!image.GetBuffer(coded.bytes.data()) || image.GetBufferLength() != bytes)
        fail(ISO_E_FORMAT, file.path + ": GDCM: its compressed samples are damaged, or of a kind that is not read");
    return coded;
}

/* Unpacks PackBits, up to `most` bytes (PS3.5 G.3). */
std::vector<char> unpack_bits(const char *data, size_t size, size_t most)
{
    std::vector<char> out;
    for (size_t at = 0; at < size && out.size() < most;) {
        const int n = static_cast<signed char>(data[at++]);
        const size_t count = static_cast<size_t>(n < 0 ? 1 - n : n + 1);
        if (n == -128)
            continue;
        if (n < 0 && at < size)
            out.insert(out.end(), count, data[at++]);
        else if (n >= 0) {
            out.insert(out.end(), data + at, data + std::min(size, at + count));
            at += count;
        }
    }
    out.resize(std::min(out.size(), most));
    return out;
}

/* Unpacks a frame of RLE (PS3.5 G.5): the number of segments, their places in 15 words, then a segment for each byte of
 * a sample, the highest first, and each component. Components come in planes. */
std::vector<char> unpack_rle(const char *data, size_t size, const Coding &coding, size_t bytes)
{
    constexpr size_t head = 64;
    const size_t n = coding.bits == 1 ? 1 : coding.bits / 8, segments = coding.components * n, each = bytes / segments;
    uint32_t words[16] = {};
    if (size < head)
        return {};
    memcpy(words, data, sizeof words);
    std::vector<char> out(each * segments);
    for (size_t s = 0; s < segments; ++s) {
        const size_t from = s + 1 < 16 ? words[s + 1] : size;
        const auto segment = unpack_bits(data + std::min(from, size), size - std::min(from, size), each);
        if (words[0] != segments || segment.size() < each)
            return {};
        for (size_t i = 0; i < each; ++i)
            out[(s / n * each + i) * n + n - 1 - s % n] = segment[i];
    }
    return out;
}

/* Returns samples that are packed frame by frame and that GDCM does not decode, or not right: bits, and colors of 16
 * bits by RLE. */
Coded unpacked_frames(const DicomFile &file, const gdcm::SequenceOfFragments &fragments, const std::string &syntax)
{
    Coded coded{file.coding, {}};
    coded.coding.has_whole_bytes = coded.coding.is_in_planes = true;
    if (syntax != rle || fragments.GetNumberOfFragments() != file.frames.size())
        fail(ISO_E_FORMAT, file.path + ": samples of " + std::to_string(file.coding.bits) + " bits in " +
                               std::to_string(fragments.GetNumberOfFragments()) + " fragments of transfer syntax " +
                               syntax + ", must be RLE with one fragment per frame");
    const size_t bytes = picture_bytes(file, coded.coding);
    for (size_t k = 0; k < file.frames.size(); ++k) {
        const gdcm::ByteValue *value = fragments.GetFragment(k).GetByteValue();
        const char *data = value ? value->GetPointer() : "";
        const size_t size = value ? static_cast<size_t>(value->GetLength()) : 0;
        const auto frame = unpack_rle(data, size, coded.coding, bytes);
        if (frame.size() < bytes)
            fail_of_size(file, frame.size(), bytes);
        coded.bytes.insert(coded.bytes.end(), frame.begin(), frame.end());
    }
    return coded;
}

template <typename T> T sample_at(const char *stored, size_t i)
{
    T value;
    memcpy(&value, stored + i * sizeof value, sizeof value);
    return value;
}

/* Returns a sample's number: the stored bits below HighBit, with their sign. Other bits may hold overlays. */
double integer_of(const DicomFile &file, const char *stored, size_t i)
{
    const unsigned bits = file.bits_stored;
    uint64_t word = file.bits_allocated <= 8    ? sample_at<uint8_t>(stored, i)
                    : file.bits_allocated == 16 ? sample_at<uint16_t>(stored, i)
                                                : sample_at<uint32_t>(stored, i);
    word = (word >> (file.high_bit + 1 - bits)) & ((UINT64_C(1) << bits) - 1);
    const bool is_negative = file.is_signed && (word >> (bits - 1)) != 0;
    return static_cast<double>(static_cast<int64_t>(word) - (is_negative ? INT64_C(1) << bits : 0));
}

double number_of(const DicomFile &file, const char *stored, size_t i)
{
    switch (file.samples) {
    case Samples::float32: return sample_at<float>(stored, i);
    case Samples::float64: return sample_at<double>(stored, i);
    default: return integer_of(file, stored, i);
    }
}

struct Range {
    double least = std::numeric_limits<double>::infinity(), most = -std::numeric_limits<double>::infinity();
};

/* Widens the range by the values that a frame's samples can have. */
void widen(Range &range, const DicomFile &file, const DicomFrame &frame)
{
    const double span = std::ldexp(1.0, static_cast<int>(file.bits_stored)), low = file.is_signed ? -span / 2 : 0;
    for (const double stored : {low, low + span - 1}) {
        const double value = frame.slope * stored + frame.intercept;
        range.least = std::min(range.least, value), range.most = std::max(range.most, value);
    }
}

template <typename T> bool holds(const Range &range)
{
    return range.least >= static_cast<double>(std::numeric_limits<T>::lowest()) &&
           range.most <= static_cast<double>(std::numeric_limits<T>::max());
}

template <typename T> void convert(const DicomFile &file, const DicomFrame &frame, const char *stored, char *out)
{
    for (size_t i = 0; i < file.rows * file.columns; ++i) {
        const T value = static_cast<T>(frame.slope * number_of(file, stored, i) + frame.intercept);
        memcpy(out + i * sizeof value, &value, sizeof value);
    }
}

template <typename T> void blend_as(double weight, const char *second, size_t count, char *first)
{
    for (size_t i = 0; i < count; ++i) {
        const double value = (1 - weight) * static_cast<double>(sample_at<T>(first, i)) +
                             weight * static_cast<double>(sample_at<T>(second, i));
        const T given = static_cast<T>(std::numeric_limits<T>::is_integer ? std::nearbyint(value) : value);
        memcpy(first + i * sizeof given, &given, sizeof given);
    }
}

} // namespace

bool is_whole_deflated(const std::string &path)
{
    constexpr size_t meta = 132, of_length = 12; /* the preamble; the element with the length of the part that is not deflated */
    std::ifstream file(path, std::ios::binary);
    std::string head(1024, 0), packed(65536, 0), unpacked(65536, 0);
    file.read(&head[0], static_cast<std::streamsize>(head.size()));
    uint32_t length;
    memcpy(&length, &head[meta + 8], sizeof length);
    if (head.find(deflated_syntax) == std::string::npos || memcmp(&head[meta], "\2\0\0\0UL\4\0", 8) != 0)
        return false;
    file.clear();
    file.seekg(static_cast<std::streamoff>(meta + of_length + length));
    z_stream z{};
    int result = inflateInit2(&z, -MAX_WBITS);
    while (result == Z_OK && (z.avail_in > 0 || file)) {
        if (z.avail_in == 0) {
            file.read(&packed[0], static_cast<std::streamsize>(packed.size()));
            z.next_in = reinterpret_cast<Bytef *>(&packed[0]), z.avail_in = static_cast<uInt>(file.gcount());
        }
        z.next_out = reinterpret_cast<Bytef *>(&unpacked[0]), z.avail_out = static_cast<uInt>(unpacked.size());
        result = z.avail_in > 0 ? inflate(&z, Z_NO_FLUSH) : Z_BUF_ERROR;
    }
    inflateEnd(&z);
    return result == Z_STREAM_END;
}

void choose_channel(DicomFile &file, size_t channel)
{
    const Coding &coding = file.coding;
    const unsigned bits = coding.color == Color::palette ? file.palette.bits : coding.bits;
    file.channel = channel;
    if (coding.color == Color::gray)
        return;
    const bool is_luminance = channel >= 3;
    file.samples = is_luminance ? Samples::float32 : Samples::integer;
    file.bits_allocated = is_luminance ? 32 : bits;
    file.bits_stored = bits;
    file.high_bit = bits - 1;
    file.is_signed = false;
    file.padding = 0;
}

Coded coded_samples(const DicomFile &file)
{
    /* Decoders keep several copies of their output. */
    const ParseMemory memory(bytes_to_parse(file.path) + 4 * static_cast<double>(all_bytes(file, file.coding)));
    gdcm::Reader reader;
    reader.SetFileName(file.path.c_str());
    const Tag tag = tag_of_samples(file);
    if (!reader.Read() && !is_whole_deflated(file.path))
        fail(ISO_E_FORMAT, file.path + ": a DICOM file that is damaged, or of a transfer syntax that GDCM lacks");
    const gdcm::DataSet &all = reader.GetFile().GetDataSet();
    if (!all.FindDataElement(tag))
        fail(ISO_E_FORMAT, file.path + ": holds no samples");
    const gdcm::DataElement &element = all.GetDataElement(tag);
    const TransferSyntax syntax = reader.GetFile().GetHeader().GetDataSetTransferSyntax();
    if (const gdcm::ByteValue *value = element.GetByteValue())
        return plain_samples(file, *value, swapped_bytes(element, syntax));
    if (file.coding.color == Color::gray && file.samples != Samples::integer)
        fail(ISO_E_FORMAT, file.path + ": compressed floats, not supported in this format");
    const gdcm::SequenceOfFragments *fragments = element.GetSequenceOfFragments();
    const std::string uid = syntax_of(reader);
    const bool is_ours = file.coding.bits == 1 || (uid == rle && file.coding.components > 1);
    return is_ours && fragments ? unpacked_frames(file, *fragments, uid) : unpacked_samples(file);
}

namespace {

/* Writes the bits of a frame as bytes; the lowest bit of a byte comes first. */
void spread_bits(const char *bits, size_t first, size_t count, char *out)
{
    for (size_t i = 0; i < count; ++i)
        out[i] = static_cast<char>((static_cast<unsigned char>(bits[(first + i) / 8]) >> ((first + i) % 8)) & 1);
}

void cut_tile(const DicomFile &file, const char *picture, size_t tile, size_t sample, std::vector<char> &out)
{
    const size_t row = file.columns * sample, across = file.tiles * row;
    out.resize(row * file.rows);
    const char *from = picture + tile / file.tiles * file.rows * across + tile % file.tiles * row;
    for (size_t y = 0; y < file.rows; ++y)
        memcpy(&out[y * row], from + y * across, row);
}

} // namespace

const char *frame_samples(const DicomFile &file, const Coded &coded, size_t frame, std::vector<char> &own)
{
    const size_t pixels = file.rows * file.columns, bytes = picture_bytes(file, coded.coding);
    if (file.tiles && coded.coding.color == Color::gray && coded.coding.bits >= 8) {
        cut_tile(file, coded.bytes.data(), frame, coded.coding.bits / 8, own);
        return own.data();
    }
    const char *at = coded.bytes.data() + (coded.coding.has_whole_bytes ? frame * bytes : 0);
    if (coded.coding.bits == 1) {
        own.resize(pixels);
        spread_bits(at, coded.coding.has_whole_bytes ? 0 : frame * pixels, pixels, own.data());
    } else if (coded.coding.color != Color::gray) {
        own.resize(pixels * file.bits_allocated / 8);
        color_channel(coded.coding, file.palette, at, pixels, file.channel, own.data());
    } else
        return at;
    return own.data();
}

iso_type type_of_values(const std::vector<DicomFile> &files)
{
    Range range;
    bool is_integer = true, is_wide = false;
    for (const auto &file : files)
        for (const auto &frame : file.frames) {
            is_integer = is_integer && file.samples == Samples::integer && frame.slope == std::round(frame.slope) &&
                         frame.intercept == std::round(frame.intercept);
            is_wide = is_wide || file.samples == Samples::float64 || file.bits_stored > 24;
            widen(range, file, frame);
        }
    if (!is_integer)
        return is_wide ? ISO_F64 : ISO_F32;
    return holds<uint8_t>(range)    ? ISO_U8
           : holds<int8_t>(range)   ? ISO_I8
           : holds<uint16_t>(range) ? ISO_U16
           : holds<int16_t>(range)  ? ISO_I16
           : holds<uint32_t>(range) ? ISO_U32
           : holds<int32_t>(range)  ? ISO_I32
                                    : ISO_F64;
}

void values_of_frame(const DicomFile &file, size_t frame, const char *stored, iso_type type, char *out)
{
    const DicomFrame &f = file.frames[frame];
    switch (type) {
    case ISO_U8: return convert<uint8_t>(file, f, stored, out);
    case ISO_I8: return convert<int8_t>(file, f, stored, out);
    case ISO_U16: return convert<uint16_t>(file, f, stored, out);
    case ISO_I16: return convert<int16_t>(file, f, stored, out);
    case ISO_U32: return convert<uint32_t>(file, f, stored, out);
    case ISO_I32: return convert<int32_t>(file, f, stored, out);
    case ISO_F32: return convert<float>(file, f, stored, out);
    case ISO_F64: return convert<double>(file, f, stored, out);
    }
}

void blend(iso_type type, double weight, const char *second, size_t count, char *first)
{
    switch (type) {
    case ISO_U8: return blend_as<uint8_t>(weight, second, count, first);
    case ISO_I8: return blend_as<int8_t>(weight, second, count, first);
    case ISO_U16: return blend_as<uint16_t>(weight, second, count, first);
    case ISO_I16: return blend_as<int16_t>(weight, second, count, first);
    case ISO_U32: return blend_as<uint32_t>(weight, second, count, first);
    case ISO_I32: return blend_as<int32_t>(weight, second, count, first);
    case ISO_F32: return blend_as<float>(weight, second, count, first);
    case ISO_F64: return blend_as<double>(weight, second, count, first);
    }
}
