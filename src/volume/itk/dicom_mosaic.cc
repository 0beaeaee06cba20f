/* SPDX-License-Identifier: MIT */
#include "volume/itk/dicom_mosaic.h"

namespace {

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

} // namespace

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
