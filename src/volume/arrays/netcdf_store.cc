/* SPDX-License-Identifier: MIT */
/* netcdf_store.cc - netCDF's classic files, and MINC 1, which is of these. netCDF-4 is HDF5. */
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <netcdf.h>
#include <string>

#include "volume/arrays/store.h"
#include "volume/child_writer.h"

/* ---- the header ---- */

/* The header of a classic netCDF file, before netCDF's library sees it: the library copies names and
 * lists of dimensions of any length into its callers' buffers (nc_inq_var() and the like of 4.9), which its
 * documentation lets be of NC_MAX_NAME and NC_MAX_VAR_DIMS. */
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


/* Checks a classic header. Throws Failure (child_writer.h): ISO_E_FORMAT if a name, a list or the header itself is
 * longer than allowed. Files that are not classic are left to the library. Format: the netCDF Classic Format
 * Specification, versions 1, 2 and 5. */
void check_netcdf_header(const std::string &path)
{
    Header(path).check();
}

} // namespace

/* ---- the store ---- */

namespace {

/* An open file, which is closed also if its content is refused. */
class OpenFile {
public:
    explicit OpenFile(const std::string &path)
    {
        check_netcdf_header(path);
        const int code = nc_open(path.c_str(), NC_NOWRITE, &id_);
        if (code != NC_NOERR)
            fail(ISO_E_FORMAT, path + ": netCDF: " + nc_strerror(code));
    }
    OpenFile(const OpenFile &) = delete;
    OpenFile &operator=(const OpenFile &) = delete;
    ~OpenFile()
    {
        nc_close(id_);
    }
    operator int() const
    {
        return id_;
    }

private:
    int id_ = -1;
};

class NetCdf : public Store {
public:
    explicit NetCdf(const std::string &path) : path_(path), file_(path)
    {
        check_is_whole();
    }

    std::vector<Array> arrays() override
    {
        int count = 0;
        check(nc_inq_nvars(file_, &count), "its header");
        std::vector<Array> all;
        for (int v = 0; v < count; ++v)
            all.push_back(describe(v));
        return all;
    }

    std::vector<double> numbers(const std::string &array, const std::string &attribute) override
    {
        const int v = find(array);
        nc_type type;
        size_t n = 0;
        if (v < 0 || nc_inq_att(file_, v, attribute.c_str(), &type, &n) != NC_NOERR || type == NC_CHAR || n > 1 << 16)
            return {};
        std::vector<double> values(n);
        return nc_get_att_double(file_, v, attribute.c_str(), values.data()) == NC_NOERR ? values
                                                                                         : std::vector<double>{};
    }

    std::string text(const std::string &array, const std::string &attribute) override
    {
        const int v = find(array);
        nc_type type;
        size_t n = 0;
        if (v < 0 || nc_inq_att(file_, v, attribute.c_str(), &type, &n) != NC_NOERR || type != NC_CHAR || n > 1 << 16)
            return "";
        std::string text(n, 0);
        if (nc_get_att_text(file_, v, attribute.c_str(), &text[0]) != NC_NOERR)
            return "";
        text.resize(strnlen(text.c_str(), n));
        return text;
    }

    std::string coordinate(const Array &array, size_t axis) override
    {
        const int v = find(array.axes[axis]);
        int rank = 0, of = -1, dimension = -1;
        return v >= 0 && nc_inq_varndims(file_, v, &rank) == NC_NOERR && rank == 1 &&
                       nc_inq_vardimid(file_, v, &of) == NC_NOERR &&
                       nc_inq_dimid(file_, array.axes[axis].c_str(), &dimension) == NC_NOERR && of == dimension
                   ? array.axes[axis]
                   : "";
    }

    std::vector<double> values(const std::string &array) override
    {
        const int v = find(array);
        if (v < 0)
            return {};
        size_t n = 1;
        for (const size_t size : describe(v).size)
            n = n > 1 << 24 ? n : n * size;
        if (n < 1 || n > 1 << 24)
            return {};
        std::vector<double> all(n);
        return nc_get_var_double(file_, v, all.data()) == NC_NOERR ? all : std::vector<double>{};
    }

    void read(const Array &array, const std::vector<size_t> &start, const std::vector<size_t> &count,
              void *out) override
    {
        const int v = find(array.name);
        const auto get = [&] {
            return array.is_whole ? nc_get_vara_double(file_, v, start.data(), count.data(), static_cast<double *>(out))
                                  : nc_get_vara(file_, v, start.data(), count.data(), out);
        };
        check(get(), "variable " + array.name);
    }

private:
    std::string path_;
    OpenFile file_;

    void check(int code, const std::string &what) const
    {
        if (code != NC_NOERR)
            fail(ISO_E_FORMAT, path_ + ": " + what + ": damaged or truncated: netCDF: " + nc_strerror(code));
    }

    static double padded(double bytes)
    {
        return 4 * std::ceil(bytes / 4);
    }

    /* Returns the bytes of a list of attributes in the header: names, types, counts and values. */
    double attribute_bytes(int v, int count) const
    {
        double bytes = 8;
        for (int i = 0; i < count; ++i) {
            char name[NC_MAX_NAME + 1] = "";
            nc_type type = NC_NAT;
            size_t n = 0, size = 1;
            check(nc_inq_attname(file_, v, i, name), "its header");
            check(nc_inq_att(file_, v, name, &type, &n), "its header");
            nc_inq_type(file_, type, nullptr, &size);
            bytes += 12 + padded(static_cast<double>(strlen(name))) + padded(static_cast<double>(n * size));
        }
        return bytes;
    }

    /* Refuses a truncated file, for which the library gives zeros. The classic format's header and variables take
     * these bytes, and more in its later versions. */
    void check_is_whole()
    {
        int dimensions = 0, count = 0, attributes = 0, of_variable = 0;
        check(nc_inq(file_, &dimensions, &count, &attributes, nullptr), "its header");
        double need = 24 + attribute_bytes(NC_GLOBAL, attributes);
        for (int d = 0; d < dimensions; ++d) {
            char name[NC_MAX_NAME + 1] = "";
            check(nc_inq_dimname(file_, d, name), "its header");
            need += 8 + padded(static_cast<double>(strlen(name)));
        }
        for (int v = 0; v < count; ++v) {
            const Array array = describe(v);
            double bytes = array.refused.empty() ? static_cast<double>(bytes_of(array.type)) : 1;
            for (const size_t n : array.size)
                bytes *= static_cast<double>(n);
            check(nc_inq_varnatts(file_, v, &of_variable), "its header");
            need += bytes + 20 + padded(static_cast<double>(array.name.size())) +
                    4 * static_cast<double>(array.size.size()) + attribute_bytes(v, of_variable);
        }
        const double there = static_cast<double>(std::filesystem::file_size(path_));
        if (there < need)
            fail(ISO_E_FORMAT, path_ + ": truncated: holds " + std::to_string(static_cast<long long>(there)) +
                                   " bytes, its variables need " + std::to_string(static_cast<long long>(need)));
    }

    int find(const std::string &array) const
    {
        int v = -1;
        return nc_inq_varid(file_, array.c_str(), &v) == NC_NOERR ? v : -1;
    }

    Array describe(int v)
    {
        char name[NC_MAX_NAME + 1] = "";
        int rank = 0, dimensions[NC_MAX_VAR_DIMS];
        nc_type type = NC_NAT;
        check(nc_inq_var(file_, v, name, &type, &rank, dimensions, nullptr), "its header");
        Array array;
        array.name = name;
        for (int a = 0; a < rank; ++a) {
            char axis[NC_MAX_NAME + 1] = "";
            size_t size = 0;
            check(nc_inq_dim(file_, dimensions[a], axis, &size), "its header");
            array.size.push_back(size);
            array.axes.push_back(axis);
        }
        take_type(type, array);
        return array;
    }

    void take_type(nc_type type, Array &array)
    {
        switch (type) {
        case NC_BYTE: array.type = bytes_are_unsigned(array.name) ? ISO_U8 : ISO_I8; break;
        case NC_UBYTE: array.type = ISO_U8; break;
        case NC_SHORT: array.type = text(array.name, "signtype") == "unsigned" ? ISO_U16 : ISO_I16; break;
        case NC_USHORT: array.type = ISO_U16; break;
        case NC_INT: array.type = ISO_I32; break;
        case NC_UINT: array.type = ISO_U32; break;
        case NC_FLOAT: array.type = ISO_F32; break;
        case NC_DOUBLE: array.type = ISO_F64; break;
        case NC_CHAR: array.refused = "text"; break;
        case NC_INT64:
        case NC_UINT64:
            array.type = ISO_F64;
            array.is_whole = true;
            break;
        default: array.refused = "a type that is no number"; break;
        }
    }

    /* True for unsigned bytes. The classic format has no such type: a convention and MINC mark it otherwise; MINC's
     * default is unsigned. */
    bool bytes_are_unsigned(const std::string &name)
    {
        const std::string is_minc = text(name, "vartype"), sign = text(name, "signtype");
        return text(name, "_Unsigned") == "true" || sign == "unsigned" || (is_minc == "group________" && sign.empty());
    }
};

} // namespace

std::unique_ptr<Store> open_netcdf(const std::string &path)
{
    return std::make_unique<NetCdf>(path);
}
