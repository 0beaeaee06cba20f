/* SPDX-License-Identifier: MIT */
#include "volume/arrays/netcdf_header.h"

#include <netcdf.h>

#include <cstdint>
#include <filesystem>
#include <fstream>

#include "volume/child_writer.h"

namespace {

class Header {
public:
    explicit Header(const std::string &path) : path_(path), in_(path, std::ios::binary)
    {
        left_ = std::filesystem::file_size(path);
    }

    void check()
    {
        char magic[4] = "";
        in_.read(magic, sizeof magic);
        if (!in_ || std::string(magic, 3) != "CDF" || (magic[3] != 1 && magic[3] != 2 && magic[3] != 5))
            return;
        left_ -= sizeof magic;
        wide_ = magic[3] == 5;
        const uint64_t place_bytes = magic[3] == 1 ? 4 : 8;
        number(); /* of records */
        for (uint64_t n = list_of("dimensions"); n > 0; --n) {
            name();
            number();
        }
        attributes();
        for (uint64_t n = list_of("variables"); n > 0; --n) {
            name();
            skip(number_up_to(NC_MAX_VAR_DIMS, "dimensions of a variable"), wide_ ? 8 : 4);
            attributes();
            skip(4, 1); /* type */
            number();   /* bytes */
            skip(place_bytes, 1);
        }
    }

private:
    std::string path_;
    std::ifstream in_;
    uint64_t left_ = 0; /* bytes of the file that were not read */
    bool wide_ = false; /* numbers of 8 bytes */

    [[noreturn]] void refuse(const std::string &what) const
    {
        fail(ISO_E_FORMAT, path_ + ": damaged netCDF header: " + what);
    }

    void skip(uint64_t count, uint64_t each)
    {
        if (count > left_ / each)
            refuse("it ends before its lists do");
        left_ -= count * each;
        in_.seekg(static_cast<std::streamoff>(count * each), std::ios::cur);
    }

    uint64_t word(unsigned bytes)
    {
        unsigned char digits[8] = {0};
        if (left_ < bytes || !in_.read(reinterpret_cast<char *>(digits), bytes))
            refuse("it ends before its lists do");
        left_ -= bytes;
        uint64_t value = 0;
        for (unsigned i = 0; i < bytes; ++i)
            value = value << 8 | digits[i];
        return value;
    }

    uint64_t number()
    {
        return word(wide_ ? 8 : 4);
    }

    uint64_t number_up_to(uint64_t most, const std::string &what)
    {
        const uint64_t value = number();
        if (value > most)
            refuse(std::to_string(value) + " " + what + ", at most " + std::to_string(most));
        return value;
    }

    /* A tag and the number of elements, none of which takes less than a name's number. */
    uint64_t list_of(const char *what)
    {
        word(4);
        return number_up_to(left_ / 4, what);
    }

    void name()
    {
        skip((number_up_to(NC_MAX_NAME, "bytes in a name") + 3) / 4, 4);
    }

    static uint64_t bytes_of_type(uint64_t type)
    {
        switch (type) {
        case NC_BYTE:
        case NC_CHAR:
        case NC_UBYTE: return 1;
        case NC_SHORT:
        case NC_USHORT: return 2;
        case NC_DOUBLE:
        case NC_INT64:
        case NC_UINT64: return 8;
        default: return 4;
        }
    }

    void attributes()
    {
        for (uint64_t n = list_of("attributes"); n > 0; --n) {
            name();
            const uint64_t each = bytes_of_type(word(4)), count = number_up_to(left_ / each, "values of an attribute");
            skip((count * each + 3) / 4, 4);
        }
    }
};

} // namespace

void check_netcdf_header(const std::string &path)
{
    Header(path).check();
}
